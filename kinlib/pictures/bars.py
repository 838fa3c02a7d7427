"""The bars of a linkage: where the ends of its links are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.pictures.floats import one_linkage
from kinlib.scalar import as_float
from kinlib.typing import ArrayLike

__all__ = ["Bars", "common_feet", "lines_of"]


@dataclass(frozen=True, eq=False)
class Bars:
    """The links of a linkage as bars between its axes; all is computed once.

    Parameters
    ----------
    linkage : Linkage
        With floats for its numbers, see `Bars.of`.
    """

    linkage: Linkage

    @classmethod
    def of(cls, linkage: Linkage, name: str = "the linkage") -> Bars:
        """The bars of a single linkage with any numbers; errors call it by the name."""
        return cls(one_linkage(linkage, name))

    @cached_property
    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """A point and the unit direction of every axis at home, each of shape (n, 3)."""
        return lines_of(self.linkage.axes)

    @cached_property
    def origin(self) -> np.ndarray:
        """The origin of the coupler's frame at home, shape (3,)."""
        return as_float(act(self.linkage.home, [0, 0, 0]))

    @cached_property
    def ends(self) -> np.ndarray:
        """The two ends of every link at home, on the axes that it joins; shape (n, 2, 3), row i for link i.

        Link i joins the axes i and i + 1 (link 0 the last and the first).  Its ends are the feet of their common
        perpendicular.  Where these feet run far away, the bars go straight between points that lie close together;
        where all axes meet, they go between points at one distance from there.
        """
        points, directions = self.lines
        near = _near_points(points, directions)
        feet = _feet(near, directions)
        if _radius(near) <= 1e-9 * np.abs(np.concatenate([near, [self.origin]])).max():
            distance = np.linalg.norm(self.origin - near[0])
            near = near + (distance if distance > 1e-9 * np.abs(near).max() else 1.0) * directions
        straight = np.stack([np.roll(near, 1, axis=0), near], axis=1)
        return feet if 1e-6 < _radius(feet) / _radius(straight) <= 3 else straight

    @cached_property
    def size(self) -> float:
        """The radius of the box about all bars at home, from which thicknesses are chosen; 1 if it is a point."""
        return float(_radius(self.ends)) or 1.0

    def ends_at(self, t: ArrayLike) -> np.ndarray:
        """The ends of all links at parameters of shape (k,); shape (k, n, 2, 3)."""
        return as_float(act(self.linkage.link_displacements(t)[..., None], self.ends))


def lines_of(axes: DualQuaternion) -> tuple[np.ndarray, np.ndarray]:
    """A point and the unit direction of every axis, each of shape (n, 3), for rotations of shape (n,)."""
    coefficients = as_float(axes.coeffs)
    length = np.linalg.norm(coefficients[:, 1:4], axis=1, keepdims=True)
    directions, moments = coefficients[:, 1:4] / length, coefficients[:, 5:8] / length
    return np.cross(directions, moments), directions


def _near_points(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """One point on every axis, so that the sum of the squared distances around the loop is least."""
    n = len(points)
    sides = np.eye(n) - np.roll(np.eye(n), 1, axis=1)
    system = (sides[:, None, :] * directions.T).reshape(3 * n, n)
    along = np.linalg.lstsq(system, -(sides @ points).ravel(), rcond=1e-9)[0]
    return points + along[:, None] * directions


def _feet(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The feet of the common perpendicular of each axis and the next; near the points if parallel."""
    return np.array([common_feet(points[[k - 1, k]], directions[[k - 1, k]]) for k in range(len(points))])


def common_feet(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The feet of the common perpendicular of two lines, shape (2, 3); near the points if they are parallel."""
    system = np.stack([-directions[0], directions[1]], axis=1)
    along = np.linalg.lstsq(system, points[0] - points[1], rcond=1e-7)[0]
    return points + along[:, None] * directions


def _radius(points: np.ndarray) -> float:
    """Half of the longest side of the box about some points."""
    points = points.reshape(-1, 3)
    return np.ptp(points, axis=0).max() / 2
