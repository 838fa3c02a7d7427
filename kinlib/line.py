"""Oriented lines of space in Plücker coordinates (direction, moment)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.errors import DegenerateError
from kinlib.number_field import square_root
from kinlib.scalar import RTOL, as_float, as_scalars, divide, is_zero, promote, size

__all__ = ["Line", "common_perpendicular"]


@dataclass(frozen=True, eq=False)
class Line:
    """An oriented line: all points x with x × direction = moment.

    Parameters
    ----------
    direction : array_like, shape (..., 3)
        Any vector along the line, not zero; it need not have length 1.
    moment : array_like, shape (..., 3)
        a × direction for any point a of the line.

    Raises
    ------
    ValueError
        If a direction is zero, or not perpendicular to its moment.

    Examples
    --------
    >>> Line.through([0, 0, 1], [1, 0, 1]).as_dual_quaternion()
    i + εj
    """

    direction: np.ndarray
    moment: np.ndarray

    def __post_init__(self):
        direction, moment = np.broadcast_arrays(*promote(_vectors(self.direction), _vectors(self.moment)))
        if direction.dtype.kind == "f" and not (np.isfinite(direction).all() and np.isfinite(moment).all()):
            raise ValueError("expected finite direction and moment, got NaN or infinity")
        if np.any(np.all(is_zero(direction, rtol=0), axis=-1)):
            raise ValueError("expected a direction that is not zero")
        product = _dot(direction, moment)[..., 0]
        if not np.all(is_zero(product, size(direction, -1) * size(moment, -1))):
            raise ValueError("expected direction and moment to be perpendicular, as a × l is to l")
        object.__setattr__(self, "direction", _read_only(direction))
        object.__setattr__(self, "moment", _read_only(moment))

    @classmethod
    def from_components(cls, components: np.ndarray) -> Line:
        """Wrap Plücker coordinates with the six components first, shape (6, ...), that are known to be a line's."""
        self = object.__new__(cls)
        components.setflags(write=False)
        coordinates = np.moveaxis(components, 0, -1)
        object.__setattr__(self, "direction", coordinates[..., :3])
        object.__setattr__(self, "moment", coordinates[..., 3:])
        return self

    @classmethod
    def through(cls, a, b) -> Line:
        """The line from point a to point b, of shape (..., 3)."""
        a, b = _vectors(a), _vectors(b)
        return cls(b - a, np.cross(a, b - a))

    @classmethod
    def at(cls, point, direction) -> Line:
        """The line through a point with a given direction.

        Examples
        --------
        >>> Line.at([0, 0, 1], [1, 0, 0]).moment.tolist()
        [0, 1, 0]
        """
        point, direction = _vectors(point), _vectors(direction)
        return cls(direction, np.cross(point, direction))

    @classmethod
    def from_dual_quaternion(cls, h: DualQuaternion) -> Line:
        """The axis of a half-turn, or of any rotation: its vector part l + εm."""
        return cls(h.coeffs[..., 1:4], h.coeffs[..., 5:8])

    def as_dual_quaternion(self) -> DualQuaternion:
        """The dual quaternion l + εm, a point of the Study quadric: the half-turn about the line."""
        zero = np.zeros_like(self.direction[..., :1])
        return DualQuaternion(np.concatenate([zero, self.direction, zero, self.moment], axis=-1))

    def contains(self, point, *, rtol: float = RTOL):
        """Whether the line passes through a point, shape (..., 3)."""
        point = as_scalars(point)
        gap = np.cross(point, self.direction) - self.moment
        scale = size(point, -1) * size(self.direction, -1) + size(self.moment, -1)
        return np.all(is_zero(gap, np.asarray(scale)[..., None], rtol), axis=-1)[()]

    def foot(self, point=(0, 0, 0)) -> np.ndarray:
        """The point of the line that is nearest to a given point (the origin), shape (..., 3)."""
        point, l = as_scalars(point), self.direction
        return divide(np.cross(l, self.moment) + _dot(point, l) * l, _dot(l, l))

    def angle(self, other: Line) -> np.ndarray:
        """The angle between the directions, in radians from 0 to π (floats)."""
        l, k = as_float(self.direction), as_float(other.direction)
        return np.arctan2(np.linalg.norm(np.cross(l, k), axis=-1), (l * k).sum(-1))

    def distance(self, other: Line) -> np.ndarray:
        """The shortest distance of two lines, in units of length; exact where a square root allows.

        Examples
        --------
        >>> Line.at([0, 0, 0], [1, 0, 0]).distance(Line.at([0, 0, 3], [0, 2, 0]))
        Fraction(3, 1)
        """
        if self.direction.ndim == 1 and np.all(_are_parallel(self, other)):
            first = self.foot()
            second = other.foot(first)
        else:
            first, second = common_perpendicular(self, other)
        return square_root(_dot(first - second, first - second)[..., 0])


def _vectors(x) -> np.ndarray:
    array = as_scalars(x)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"expected vectors of shape (..., 3), got shape {array.shape}")
    return array


def _read_only(array: np.ndarray) -> np.ndarray:
    array = np.array(array)
    array.setflags(write=False)
    return array


def common_perpendicular(first: Line, second: Line) -> tuple[np.ndarray, np.ndarray]:
    """The feet of the common perpendicular, on the first and on the second line.

    The formula is rational: exact for exact lines.

    Returns
    -------
    pair of numpy.ndarray, shape (..., 3)

    Raises
    ------
    DegenerateError
        If the lines are parallel: they have a whole strip of common perpendiculars.

    Examples
    --------
    >>> feet = common_perpendicular(Line.at([0, 0, 0], [1, 0, 0]), Line.at([5, 7, 3], [0, 2, 0]))
    >>> [[int(x) for x in foot] for foot in feet]
    [[5, 0, 0], [5, 0, 3]]
    """
    if np.any(_are_parallel(first, second)):
        raise DegenerateError("the lines are parallel: their common perpendicular is not determined")
    normal = np.cross(first.direction, second.direction)
    return _foot(first, second, normal), _foot(second, first, normal)


def _are_parallel(first: Line, second: Line):
    l, k = first.direction, second.direction
    return np.all(is_zero(np.cross(l, k), np.expand_dims(size(l, -1) * size(k, -1), -1), rtol=1e-14), axis=-1)


def _dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The inner product of vectors, shape (..., 1)."""
    return (x * y).sum(axis=-1, keepdims=True)


def _foot(line: Line, other: Line, normal: np.ndarray) -> np.ndarray:
    """Where the line meets the plane of the other line and the normal.

    That plane has the normal vector n × k; a point a + s l of the line is in it for one s.
    """
    a, b = line.foot(), other.foot()
    plane = np.cross(normal, other.direction)
    return a + divide(_dot(b - a, plane), _dot(line.direction, plane)) * line.direction
