"""The bars of a linkage: where the ends of its links are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinlib.collision import checked_bars
from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.pictures.floats import one_linkage
from kinlib.scalar import as_float
from kinlib.typing import Array, ArrayLike

__all__ = ["Bars", "common_feet", "lines_of"]


@dataclass(frozen=True, eq=False)
class Bars:
    """The links of a linkage as bars between its axes; all is computed once.

    Parameters
    ----------
    linkage : Linkage
        With floats for its numbers, see `Bars.of`.
    given : array, shape (n, 2, 3), optional
        The ends of the bars at home, on the axes; those of the common perpendiculars if not given.
    """

    linkage: Linkage
    given: Array | None = None

    @classmethod
    def of(cls, linkage: Linkage, name: str = "the linkage", given: ArrayLike | None = None) -> Bars:
        """The bars of a single linkage with any numbers; errors call it by the name."""
        linkage = one_linkage(linkage, name)
        if given is None:
            return cls(linkage)
        points = as_float(checked_bars(given, linkage.chain.lines))
        if points.shape != (linkage.joint_count, 2, 3):
            raise ValueError(f"expected straight bars of one linkage, shape (n, 2, 3), got {points.shape}")
        return cls(linkage, points)

    @cached_property
    def lines(self) -> tuple[np.ndarray, np.ndarray]:
        """A point and the unit direction of every axis at home, each of shape (n, 3)."""
        return lines_of(self.linkage.axes)

    @cached_property
    def origin(self) -> np.ndarray:
        """The origin of the coupler's frame at home, shape (3,)."""
        return as_float(act(self.linkage.home, [0, 0, 0]))

    @property
    def ends(self) -> np.ndarray:
        """The two ends of every link at home, on the axes that it joins; shape (n, 2, 3), link 0 first."""
        return self.linkage.bars() if self.given is None else self.given

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


def common_feet(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The feet of the common perpendicular of two lines, shape (2, 3); near the points if they are parallel."""
    system = np.stack([-directions[0], directions[1]], axis=1)
    along = np.linalg.lstsq(system, points[0] - points[1], rcond=1e-7)[0]
    return points + along[:, None] * directions


def _radius(points: np.ndarray) -> float:
    """Half of the longest side of the box about some points."""
    points = points.reshape(-1, 3)
    return np.ptp(points, axis=0).max() / 2
