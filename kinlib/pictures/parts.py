"""What scenes are made of: rods, balls, curves, surfaces, frames and labels.

Every part says where it is in units of length, and which body carries it; a part without a body stands still.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from meshcat.geometry import Cylinder, Sphere

from kinlib.pictures.colours import GLOW, PIN
from kinlib.pictures.floats import pose_matrices
from kinlib.pictures.shapes import Sheet, Solid, Tube, View, along, scaled, triad
from kinlib.typing import PointLike, PoseLike

__all__ = ["Ball", "Curve", "Frame", "Label", "Part", "Rod", "Surface"]


@dataclass(frozen=True)
class Rod:
    """A straight round bar from one point to another, in units of length.

    Its radius is 1.2 % of the scene's if it is not given.  The body is the name of the motion that carries it.
    """

    start: PointLike
    end: PointLike
    colour: str = PIN
    radius: float | None = None
    body: str = ""
    opacity: float = 1.0

    def points(self) -> np.ndarray:
        return np.array([self.start, self.end], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        matrix = along(view.place(self.start), view.place(self.end), view.length(self.radius, 0.012))
        yield Solid(Cylinder(1, 1), matrix, self.colour, self.opacity)


@dataclass(frozen=True)
class Ball:
    """A ball about a point; its radius is 2.5 % of the scene's if it is not given."""

    centre: PointLike
    colour: str = PIN
    radius: float | None = None
    body: str = ""
    opacity: float = 1.0

    def points(self) -> np.ndarray:
        return np.array([self.centre], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        matrix = scaled(view.place(self.centre), view.length(self.radius, 0.025))
        yield Solid(Sphere(1), matrix, self.colour, self.opacity)


@dataclass(frozen=True)
class Curve:
    """A smooth tube through points, shape (k, 3); closed if the last point is followed by the first."""

    path: PointLike
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

    grid: PointLike
    colour: str = PIN
    body: str = ""
    opacity: float = 0.4

    def points(self) -> np.ndarray:
        return np.asarray(self.grid, dtype=float).reshape(-1, 3)

    def solids(self, view: View) -> Iterable[Solid]:
        yield Solid(Sheet(view.place(self.grid)), np.eye(4), self.colour, self.opacity)


@dataclass(frozen=True)
class Frame:
    """A coordinate frame at a pose: x raspberry, y lime, z violet.

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

    pose: PoseLike
    size: float | None = None
    name: str = ""
    body: str = ""
    lights_at: int | None = None
    radius: float = 0.08

    def matrix(self) -> np.ndarray:
        return pose_matrices([self.pose])[0]

    def points(self) -> np.ndarray:
        pose = self.matrix()
        return pose[:3, 3] + 1.3 * (self.size or 0) * np.concatenate([np.zeros((1, 3)), pose[:3, :3].T])

    def tips(self, view: View) -> np.ndarray:
        """Where its arrows end, in the units of the recording, shape (3, 3)."""
        pose = self.matrix()
        return view.place(pose[:3, 3]) + view.length(self.size, 0.18) * pose[:3, :3].T

    def solids(self, view: View) -> Iterable[Solid]:
        pose, size = self.matrix(), view.length(self.size, 0.18)
        origin = view.place(pose[:3, 3])
        if self.lights_at is None:
            yield from triad(origin, pose, size, self.radius * size, group="")
            return
        yield from triad(origin, pose, size, 0.6 * self.radius * size, group="off")
        yield from triad(origin, pose, 1.2 * size, 1.3 * self.radius * size, group="on")
        yield Solid(Sphere(1), scaled(origin, 0.55 * size), GLOW, 0.35, "on")


@dataclass(frozen=True)
class Label:
    """A few letters about a point."""

    text: str
    point: PointLike
    body: str = ""

    def points(self) -> np.ndarray:
        return np.array([self.point], dtype=float)

    def solids(self, view: View) -> Iterable[Solid]:
        return ()


Part: TypeAlias = Rod | Ball | Curve | Surface | Frame | Label
"""What a scene can hold."""
