"""What scenes are made of: rods, balls, curves, surfaces, frames and labels, as shapes of meshcat.

Every part says where it is in units of length, and which body carries it; a part without a body stands still.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinlib.skeleton import PIN, X_AXIS, Y_AXIS, Z_AXIS, pose_matrices

with warnings.catch_warnings():  # about meshcat's server, which is not used here
    warnings.simplefilter("ignore", DeprecationWarning)
    from meshcat import Visualizer
    from meshcat import geometry as shapes

__all__ = [
    "DIGITS",
    "PIN",
    "Ball",
    "Curve",
    "Frame",
    "Label",
    "Rod",
    "Solid",
    "Surface",
    "View",
    "record",
    "tidy",
]

DIGITS = 5
"""Decimals that are kept of every number, in units of a scene's radius."""

GLOW = "#ffc531"
"""The light about a pose that is reached."""


@dataclass(frozen=True)
class View:
    """Where a scene is and how large: it is recorded in units of its radius, from its centre."""

    centre: np.ndarray
    radius: float

    def place(self, points) -> np.ndarray:
        """Points, shape (..., 3), in the units of the recording."""
        return (np.asarray(points, dtype=float) - self.centre) / self.radius

    def length(self, length: float | None, default: float) -> float:
        """A length in the units of the recording; the default is in these units already."""
        return default if length is None else length / self.radius


@dataclass(frozen=True)
class Solid:
    """A shape of meshcat, where it is (4×4), and how it is painted."""

    shape: shapes.Geometry
    matrix: np.ndarray
    colour: str
    opacity: float = 1.0
    group: str = ""


@dataclass(frozen=True)
class Rod:
    """A straight round bar from one point to another, in units of length.

    Its radius is 1.2 % of the scene's if it is not given.  The body is the name of the motion that carries it.
    """

    start: np.ndarray
    end: np.ndarray
    colour: str = PIN
    radius: float | None = None
    body: str = ""
    opacity: float = 1.0

    def points(self) -> np.ndarray:
        return np.array([self.start, self.end], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        matrix = _along(*view.place(self.points()), view.length(self.radius, 0.012))
        yield Solid(shapes.Cylinder(1, 1), matrix, self.colour, self.opacity)


@dataclass(frozen=True)
class Ball:
    """A ball about a point; its radius is 2.5 % of the scene's if it is not given."""

    centre: np.ndarray
    colour: str = PIN
    radius: float | None = None
    body: str = ""
    opacity: float = 1.0

    def points(self) -> np.ndarray:
        return np.array([self.centre], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        matrix = _scaled(view.place(self.centre), view.length(self.radius, 0.025))
        yield Solid(shapes.Sphere(1), matrix, self.colour, self.opacity)


@dataclass(frozen=True)
class Curve:
    """A smooth tube through points, shape (k, 3); closed if the last point is followed by the first."""

    path: np.ndarray
    colour: str = PIN
    radius: float | None = None
    closed: bool = False
    body: str = ""
    opacity: float = 1.0

    def points(self) -> np.ndarray:
        return np.asarray(self.path, dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        tube = Tube(view.place(self.path), view.length(self.radius, 0.007), self.closed)
        yield Solid(tube, np.eye(4), self.colour, self.opacity)


@dataclass(frozen=True)
class Surface:
    """A surface through a grid of points, shape (rows, columns, 3)."""

    grid: np.ndarray
    colour: str = PIN
    body: str = ""
    opacity: float = 0.4

    def points(self) -> np.ndarray:
        return np.asarray(self.grid, dtype=float).reshape(-1, 3)

    def solids(self, view: View) -> Iterable[Solid]:
        yield Solid(Sheet(view.place(self.grid)), np.eye(4), self.colour, self.opacity)


@dataclass(frozen=True)
class Frame:
    """A coordinate frame at a pose: x red, y green, z blue.

    Parameters
    ----------
    pose : DualQuaternion, 4×4 matrix or SciPy ``RigidTransform``
    size : float, optional
        The length of its axes; 18 % of the scene's radius if it is not given.
    name : str
        Written next to its origin.
    lights_at : int, optional
        The frame of the motion at which it lights up.
    """

    pose: object
    size: float | None = None
    name: str = ""
    body: str = ""
    lights_at: int | None = None
    radius: float = 0.08

    def matrix(self) -> np.ndarray:
        return pose_matrices([self.pose])[0]

    def points(self) -> np.ndarray:
        pose = self.matrix()
        return pose[:3, 3] + (self.size or 0) * np.concatenate([np.zeros((1, 3)), pose[:3, :3].T])

    def solids(self, view: View) -> Iterable[Solid]:
        pose, size = self.matrix(), view.length(self.size, 0.18)
        origin = view.place(pose[:3, 3])
        if self.lights_at is None:
            yield from _triad(origin, pose, size, self.radius * size, group="")
            return
        yield from _triad(origin, pose, size, 0.6 * self.radius * size, group="off")
        yield from _triad(origin, pose, 1.2 * size, 1.3 * self.radius * size, group="on")
        yield Solid(shapes.Sphere(1), _scaled(origin, 0.55 * size), GLOW, 0.35, "on")


@dataclass(frozen=True)
class Label:
    """A few letters next to a point."""

    text: str
    point: np.ndarray
    body: str = ""

    def points(self) -> np.ndarray:
        return np.array([self.point], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        return ()


def _triad(origin: np.ndarray, pose: np.ndarray, size: float, radius: float, group: str) -> Iterable[Solid]:
    for axis, colour in enumerate((X_AXIS, Y_AXIS, Z_AXIS)):
        tip = origin + size * pose[:3, axis]
        yield Solid(shapes.Cylinder(1, 1), _along(origin, tip, radius), colour, group=group)
        head = _along(tip, tip + 0.3 * size * pose[:3, axis], 2.2 * radius)
        yield Solid(shapes.Cylinder(1, radiusTop=0, radiusBottom=1), head, colour, group=group)


def _along(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """The matrix that takes a cylinder of radius and height 1 along the y-axis to one from start to end."""
    axis = end - start
    length = np.linalg.norm(axis)
    direction = axis / length if length > 0 else np.array([0.0, 1.0, 0.0])
    helper = np.eye(3)[np.argmin(np.abs(direction).round(6))]
    side = np.cross(direction, helper)
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1] = radius * side, max(length, 1e-4) * direction
    matrix[:3, 2], matrix[:3, 3] = radius * np.cross(side, direction), (start + end) / 2
    return matrix


def _scaled(centre: np.ndarray, radius: float) -> np.ndarray:
    matrix = np.diag([radius, radius, radius, 1.0])
    matrix[:3, 3] = centre
    return matrix


class Tube(shapes.Geometry):
    """three.js's tube about a smooth curve through points, shape (k, 3)."""

    def __init__(self, points: np.ndarray, radius: float, closed: bool):
        super().__init__()
        self.points, self.radius, self.closed = points, radius, closed

    def lower(self, object_data):
        pieces = 2 * len(self.points)
        path = {
            "type": "CatmullRomCurve3", "curveType": "centripetal", "tension": 0.5, "closed": self.closed,
            "arcLengthDivisions": 2 * pieces, "points": self.points.tolist(),
        }  # fmt: skip
        return {
            "uuid": self.uuid, "type": "TubeGeometry", "path": path, "closed": self.closed,
            "tubularSegments": pieces, "radius": self.radius, "radialSegments": 8,
        }  # fmt: skip


class Sheet(shapes.Geometry):
    """Two triangles for every mesh of a grid of points, shape (rows, columns, 3)."""

    def __init__(self, grid: np.ndarray):
        super().__init__()
        self.grid = grid

    def lower(self, object_data):
        rows, columns = self.grid.shape[:2]
        corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
        a, b, c, d = corner, corner + 1, corner + columns, corner + columns + 1
        position = {"itemSize": 3, "type": "Float32Array", "array": self.grid.ravel().tolist()}
        index = {"type": "Uint32Array", "array": np.stack([a, c, b, b, c, d], axis=1).ravel().tolist()}
        return {
            "uuid": self.uuid, "type": "BufferGeometry",
            "data": {"attributes": {"position": position}, "index": index},
        }  # fmt: skip


# ---- recording ---------------------------------------------------------------------------------------


class Recorder:
    """What meshcat takes for a window: it keeps the commands instead of sending them to a server."""

    def __init__(self):
        self.commands = []

    def send(self, command) -> None:
        self.commands.append(command.lower())


def _commands(parts: Sequence, view: View) -> list[dict]:
    """The commands of meshcat that draw the parts, each under the name of its body."""
    recorder = Recorder()
    visualizer = Visualizer(window=recorder)
    for number, part in enumerate(parts):
        for piece, solid in enumerate(part.solids(view)):
            place = visualizer[f"{part.body or 'fixed'}/{number}/{solid.group or 'on'}/{piece}"]
            place.set_object(solid.shape, _material(solid))
            place.set_transform(solid.matrix)
    return recorder.commands


def _material(solid: Solid) -> shapes.Material:
    return shapes.MeshPhongMaterial(color=int(solid.colour[1:], 16), opacity=solid.opacity)


def record(parts: Sequence, view: View) -> dict:
    """The parts as meshcat draws them, in plain tables: every shape once, numbers rounded, no random names.

    Returns
    -------
    dict
        ``geometries`` and ``materials`` as three.js has them, and ``objects``: path, number of the geometry, number
        of the material, and the twelve entries of the matrix by rows.
    """
    commands = _commands(parts, view)
    geometries: list[str] = []
    materials: list[str] = []
    objects = []
    for drawn, moved in zip(commands[::2], commands[1::2], strict=True):
        geometry = _number_of(_without_uuid(drawn["object"]["geometries"][0]), geometries)
        material = _number_of(_paint(drawn["object"]["materials"][0]), materials)
        matrix = np.reshape(moved["matrix"], (4, 4)).T[:3]
        objects.append([drawn["path"].removeprefix("/meshcat/"), geometry, material, *tidy(matrix.ravel())])
    return {
        "geometries": [json.loads(text) for text in geometries],
        "materials": [json.loads(text) for text in materials],
        "objects": objects,
    }


def _number_of(value: dict, table: list[str]) -> int:
    """The place of a value in a table, to which it is added if it is new."""
    text = json.dumps(tidy(value), sort_keys=True)
    if text not in table:
        table.append(text)
    return table.index(text)


def _without_uuid(shape: dict) -> dict:
    return {key: value for key, value in shape.items() if key != "uuid"}


def _paint(material: dict) -> dict:
    """The colour of a material, and how it lets light through; the rest is as the viewer would have it."""
    kept = {"type": material["type"], "color": material["color"], "side": 2}
    return kept | {"opacity": material["opacity"], "transparent": True} if material["transparent"] else kept


def tidy(value: Any):
    """The same value with rounded numbers, whole ones without a point, and lists instead of arrays."""
    if isinstance(value, Mapping):
        return {key: tidy(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [tidy(entry) for entry in value]
    if isinstance(value, (float, np.floating)):
        rounded = round(float(value), DIGITS)
        return int(rounded) if rounded == int(rounded) else rounded
    return int(value) if isinstance(value, np.integer) else value
