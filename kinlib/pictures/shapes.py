"""Shapes of meshcat, placed and painted, in units of a scene's radius."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from meshcat.geometry import Cylinder, Geometry

from kinlib.pictures.colours import X_AXIS, Y_AXIS, Z_AXIS
from kinlib.typing import PointLike

__all__ = ["Sheet", "Solid", "Table", "Tube", "View", "along", "scaled", "triad"]

Table: TypeAlias = dict[str, Any]
"""What the player reads as JSON: texts, numbers, lists and tables by their names."""


@dataclass(frozen=True)
class View:
    """Where a scene is and how large: it is recorded in units of its radius, from its centre."""

    centre: np.ndarray
    radius: float

    def place(self, points: PointLike) -> np.ndarray:
        """Points, shape (..., 3), in the units of the recording."""
        return (np.asarray(points, dtype=float) - self.centre) / self.radius

    def length(self, length: float | None, default: float) -> float:
        """A length in the units of the recording; the default is in these units already."""
        return default if length is None else length / self.radius


@dataclass(frozen=True)
class Solid:
    """A shape of meshcat, where it is (4×4), and how it is painted."""

    shape: Geometry
    matrix: np.ndarray
    colour: str
    opacity: float = 1.0
    group: str = ""


def triad(origin: np.ndarray, pose: np.ndarray, size: float, radius: float, group: str) -> Iterable[Solid]:
    """The three arrows of a coordinate frame at a pose: x raspberry, y lime, z violet."""
    for axis, colour in enumerate((X_AXIS, Y_AXIS, Z_AXIS)):
        tip = origin + size * pose[:3, axis]
        yield Solid(Cylinder(1, 1), along(origin, tip, radius), colour, group=group)
        head = along(tip, tip + 0.3 * size * pose[:3, axis], 2.2 * radius)
        yield Solid(Cylinder(1, radiusTop=0, radiusBottom=1), head, colour, group=group)


def along(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
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


def scaled(centre: np.ndarray, radius: float) -> np.ndarray:
    """The matrix that takes a ball of radius 1 about the origin to one about a centre."""
    matrix = np.diag([radius, radius, radius, 1.0])
    matrix[:3, 3] = centre
    return matrix


class Tube(Geometry):
    """three.js's tube about a smooth curve through points, shape (k, 3)."""

    def __init__(self, points: np.ndarray, radius: float, closed: bool):
        super().__init__()
        self.points, self.radius, self.closed = points, radius, closed

    def lower(self, object_data: Table) -> Table:
        pieces = 2 * len(self.points)
        path = {
            "type": "CatmullRomCurve3", "curveType": "centripetal", "tension": 0.5, "closed": self.closed,
            "arcLengthDivisions": 2 * pieces, "points": self.points.tolist(),
        }  # fmt: skip
        return {
            "uuid": self.uuid, "type": "TubeGeometry", "path": path, "closed": self.closed,
            "tubularSegments": pieces, "radius": self.radius, "radialSegments": 8,
        }  # fmt: skip


class Sheet(Geometry):
    """Two triangles for every mesh of a grid of points, shape (rows, columns, 3).

    Where the last row or column is the first again, their points are the same, so that light finds no seam.
    """

    def __init__(self, grid: np.ndarray):
        super().__init__()
        self.grid = grid

    def lower(self, object_data: Table) -> Table:
        number, points = _numbered(self.grid)
        a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
        position = {"itemSize": 3, "type": "Float32Array", "array": points.ravel().tolist()}
        index = {"type": "Uint32Array", "array": np.stack([a, c, b, b, c, d], axis=1).ravel().tolist()}
        return {
            "uuid": self.uuid, "type": "BufferGeometry",
            "data": {"attributes": {"position": position}, "index": index},
        }  # fmt: skip


def _numbered(grid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The number of every point of a grid, shape (rows, columns), and the points without repeated edges."""
    rows, columns = grid.shape[:2]
    size = np.ptp(grid.reshape(-1, 3), axis=0).max()
    round_rows, round_columns = (np.allclose(edge[0], edge[1], atol=1e-9 * size) for edge in (
        (grid[0], grid[-1]), (grid[:, 0], grid[:, -1])
    ))  # fmt: skip
    kept = grid[: rows - round_rows, : columns - round_columns]
    row, column = np.arange(rows) % kept.shape[0], np.arange(columns) % kept.shape[1]
    return row[:, None] * kept.shape[1] + column, kept
