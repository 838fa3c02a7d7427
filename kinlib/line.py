"""Oriented lines of space in Plücker coordinates (direction, moment)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, as_dual_quaternion, primal_size, wrap
from kinlib.errors import Fault, check_degenerate, first_fault, named_rows, report_faults, rows_where
from kinlib.number_field import square_root
from kinlib.scalar import (
    PARALLEL,
    ROUNDING,
    RTOL,
    as_float,
    as_scalars,
    as_vectors,
    divide,
    is_exact,
    is_zero,
    own_precision,
    promote,
    size,
)
from kinlib.shown import as_text
from kinlib.typing import Array, Degenerate, PointLike, VectorLike

__all__ = ["Line", "common_perpendicular"]


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Line:
    """An oriented line: all points x with x × direction = moment; or a batch of lines.

    Parameters
    ----------
    direction : array_like, shape (..., 3)
        Any vector along the line, not zero; it need not have length 1.
    moment : array_like, shape (..., 3)
        a × direction for any point a of the line.

    Raises
    ------
    ValueError
        If a direction is zero, or not perpendicular to its moment; if a single line is not finite.  In a batch, rows
        with NaN stay rows of NaN.

    Examples
    --------
    >>> line = Line.through([0, 0, 1], [1, 0, 1])
    >>> line
    Line(direction=(1, 0, 0), moment=(0, 1, 0))
    >>> line.as_dual_quaternion()
    i + εj
    """

    direction: np.ndarray
    moment: np.ndarray

    def __init__(self, direction: VectorLike, moment: VectorLike):
        l, m = _together(as_vectors(direction, "directions"), as_vectors(moment, "moments"))
        _take(self, _coordinates(l, m, size(l, -1)))

    @classmethod
    def from_components(cls, components: VectorLike) -> Line:
        """The line of Plücker coordinates with the six components first, shape (6, ...)."""
        array = as_scalars(components)
        if array.ndim == 0 or len(array) != 6:
            raise ValueError(f"expected Plücker coordinates of shape (6, ...), got {array.shape}")
        rows = np.moveaxis(array, 0, -1)
        return cls(rows[..., :3], rows[..., 3:])

    @classmethod
    def through(cls, a: PointLike, b: PointLike) -> Line:
        """The line from point a to point b, of shape (..., 3)."""
        a, b = _together(as_vectors(a, "points"), as_vectors(b, "points"))
        return _line_at(a, b - a)

    @classmethod
    def at(cls, point: PointLike, direction: VectorLike) -> Line:
        """The line through a point with a given direction.

        Examples
        --------
        >>> Line.at([0, 0, 1], [1, 0, 0]).moment.tolist()
        [0, 1, 0]
        """
        return _line_at(*_together(as_vectors(point, "points"), as_vectors(direction, "directions")))

    @classmethod
    def from_dual_quaternion(cls, h: DualQuaternion) -> Line:
        """The axis of a half-turn, or of any rotation: its vector part l + εm."""
        coeffs = as_dual_quaternion(h, "a rotation as DualQuaternion").coeffs
        l, m = _together(as_vectors(coeffs[..., 1:4], "directions"), as_vectors(coeffs[..., 5:8], "moments"))
        return wrap_line(_coordinates(l, m, primal_size(h)))

    def as_dual_quaternion(self) -> DualQuaternion:
        """The dual quaternion l + εm, a point of the Study quadric: the half-turn about the line."""
        components = np.zeros((8, *self.shape), dtype=self.direction.dtype)
        components[1:4], components[5:8] = np.moveaxis(self.direction, -1, 0), np.moveaxis(self.moment, -1, 0)
        return wrap(components)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch; ``()`` for a single line."""
        return self.direction.shape[:-1]

    def contains(self, point: PointLike, *, rtol: float = RTOL) -> Any:
        """Whether the line passes through a point, shape (..., 3)."""
        point, l, m = promote(as_vectors(point, "points"), self.direction, self.moment)
        gap = np.cross(point, l) - m
        length = np.asarray(size(l, -1))[..., None]
        scale = np.asarray(size(point, -1))[..., None] * length + np.asarray(size(m, -1))[..., None]
        return np.all(is_zero(gap, scale, rtol) | is_zero(gap, length, ROUNDING), axis=-1)[()]

    def foot(self, point: PointLike = (0, 0, 0)) -> Array:
        """The point of the line that is nearest to a given point (the origin), shape (..., 3)."""
        point, l, m = promote(as_vectors(point, "points"), self.direction, self.moment)
        return divide(np.cross(l, m) + _dot(point, l) * l, _dot(l, l))

    def angle(self, other: Line) -> Any:
        """The angle between the directions, in radians from 0 to π (floats)."""
        l, k = as_float(self.direction), as_float(_as_line(other).direction)
        return np.arctan2(np.linalg.norm(np.cross(l, k), axis=-1), (l * k).sum(-1))

    def is_parallel(self, other: Line) -> Any:
        """Whether two lines are parallel; floats up to an angle of :data:`~kinlib.scalar.PARALLEL`."""
        l, k = promote(self.direction, _as_line(other).direction)
        scale = np.expand_dims(size(l, -1) * size(k, -1), -1)
        return np.all(is_zero(np.cross(l, k), scale, PARALLEL), axis=-1)[()]

    def distance(self, other: Line) -> Any:
        """The shortest distance of two lines, in units of length; exact where a square root allows.

        For points a, b of the lines with directions l, k it is |(b − a) · (l × k)| / |l × k|, and for parallel
        lines the distance of their points that are opposite each other.

        Examples
        --------
        >>> Line.at([0, 0, 0], [1, 0, 0]).distance(Line.at([0, 0, 3], [0, 2, 0]))
        Fraction(3, 1)
        """
        parallel = np.asarray(self.is_parallel(other))[..., None]
        way, normal = _way_and_normal(*_alike(self, other))
        along = _dot(way, normal)
        square = np.where(parallel, 1, _dot(normal, normal))
        return square_root(np.where(parallel, _dot(way, way), divide(along * along, square))[..., 0])

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single line has no length")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Line:
        """Entries of the batch, indexed as an array of shape ``self.shape``."""
        index = (*index, slice(None)) if isinstance(index, tuple) else (index, slice(None))
        if not self.shape and None not in index and Ellipsis not in index:
            raise IndexError("a single line has no entries")
        return wrap_line(np.concatenate([self.direction[index], self.moment[index]], axis=-1))

    def __iter__(self) -> Iterator[Line]:
        return (self[n] for n in range(len(self)))

    def __repr__(self) -> str:
        if self.shape:
            return f"Line of shape {self.shape}, {self.direction.dtype}"
        l, m = (", ".join(as_text(x) for x in row.tolist()) for row in (self.direction, self.moment))
        return f"Line(direction=({l}), moment=({m}))"

    def __copy__(self) -> Line:
        return self  # its value never changes

    def __deepcopy__(self, memo: Any) -> Line:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return wrap_line, (np.concatenate([self.direction, self.moment], axis=-1),)


def wrap_line(coordinates: np.ndarray) -> Line:
    """The line of Plücker coordinates, shape (..., 6), without a copy or a check.

    For formulas that have just made the array and know that it is a line's; it can no longer be written to.
    """
    line = object.__new__(Line)
    _take(line, coordinates)
    return line


def _take(line: Line, coordinates: np.ndarray) -> None:
    coordinates.setflags(write=False)
    object.__setattr__(line, "direction", coordinates[..., :3])
    object.__setattr__(line, "moment", coordinates[..., 3:])


def _as_line(x: Any) -> Line:
    if isinstance(x, Line):
        return x
    raise TypeError(f"expected a Line, got {type(x).__name__}: Line.from_dual_quaternion(h) is the axis of a rotation")


def _alike(first: Line, second: Line) -> tuple[Line, Line]:
    """Two lines, both in floats if one is."""
    lines = [np.concatenate([line.direction, line.moment], axis=-1) for line in (_as_line(first), _as_line(second))]
    first, second = (wrap_line(coordinates) for coordinates in promote(*lines))
    return first, second


def _together(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two arrays of vectors that may be combined, of one shape; a row of NaN in one is a row of NaN in both."""
    a, b = np.broadcast_arrays(*promote(a, b))
    if a.dtype.kind == "f" or b.dtype.kind == "f":
        bad = (_is_nan(a) | _is_nan(b))[..., None]
        if bad.any():
            a, b = np.where(bad, np.nan, a), np.where(bad, np.nan, b)
    return a, b


def _is_nan(rows: np.ndarray) -> np.ndarray:
    return np.isnan(rows[..., 0]) if rows.dtype.kind == "f" else np.zeros(rows.shape[:-1], dtype=bool)


def _line_at(point: np.ndarray, direction: np.ndarray) -> Line:
    """The line through a point; a moment that is only rounding of its terms is that of a line through the origin."""
    moment, noise = np.cross(point, direction), np.asarray(size(point, -1) * size(direction, -1))
    through_origin = np.all(is_zero(moment, noise[..., None], ROUNDING), axis=-1, keepdims=True)
    return wrap_line(_coordinates(direction, np.where(through_origin, 0, moment).astype(moment.dtype), noise))


def _coordinates(l: np.ndarray, m: np.ndarray, noise: Any) -> np.ndarray:
    """Checked Plücker coordinates, shape (..., 6); a moment that is only rounding of numbers of that size is mended."""
    zero = np.all(is_zero(l, rtol=0), axis=-1)
    if np.any(zero):
        raise ValueError(f"{named_rows(rows_where(zero))}expected a direction that is not zero")
    product = (l * m).sum(axis=-1)
    fits = np.asarray(is_zero(product, size(l, -1) * size(m, -1)))
    if not np.all(fits | np.isnan(size(l, -1))):
        rounded = is_zero(product, size(l, -1) * np.maximum(noise, size(l, -1)), own_precision(l, ROUNDING))
        wrong = ~(fits | rounded | np.isnan(size(l, -1)))
        if np.any(wrong):
            raise ValueError(
                f"{named_rows(rows_where(wrong))}expected direction and moment to be perpendicular, as a × l is to l"
            )
        m = np.where(fits[..., None], m, m - divide(product, (l * l).sum(axis=-1))[..., None] * l)
    return np.concatenate([l, m], axis=-1)


def _dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The inner product of vectors, shape (..., 1)."""
    return (x * y).sum(axis=-1, keepdims=True)


def _way_and_normal(first: Line, second: Line) -> tuple[np.ndarray, np.ndarray]:
    """From the point of the first line nearest the origin to the opposite point of the second; and l × k."""
    start = first.foot()
    return second.foot(start) - start, np.cross(first.direction, second.direction)


class _Feet(Fault):
    PARALLEL = 1, "the lines are parallel: their common perpendicular is not determined"
    NEARLY_PARALLEL = 2, "the lines are so nearly parallel that rounding alone moves the feet of their perpendicular"


FOOT = 1e-3
"""How far rounding may move the foot of a perpendicular, relative to the size of the lines, until it is no answer."""


def common_perpendicular(
    first: Line, second: Line, *, degenerate: Degenerate = "raise"
) -> tuple[np.ndarray, np.ndarray]:
    """The feet of the common perpendicular, on the first and on the second line.

    The formula is rational: exact for exact lines.

    Parameters
    ----------
    first, second : Line
        Batches broadcast.
    degenerate : {"raise", "nan"}
        What becomes of rows with parallel lines.

    Returns
    -------
    pair of numpy.ndarray, shape (..., 3)

    Raises
    ------
    DegenerateError
        If the lines are parallel, since they have a whole strip of common perpendiculars; or so nearly parallel that
        rounding decides where the feet are: at an angle θ and a distance a, by about 1e-16 a/θ².

    Examples
    --------
    >>> feet = common_perpendicular(Line.at([0, 0, 0], [1, 0, 0]), Line.at([5, 7, 3], [0, 2, 0]))
    >>> [[int(x) for x in foot] for foot in feet]
    [[5, 0, 0], [5, 0, 3]]
    """
    check_degenerate(degenerate)
    first, second = _alike(first, second)
    parallel = np.asarray(first.is_parallel(second))
    way, normal = _way_and_normal(first, second)
    faults = first_fault((parallel, _Feet.PARALLEL), (_is_loose(first, second, way, normal), _Feet.NEARLY_PARALLEL))
    bad = report_faults(faults, _Feet, degenerate)[..., None]
    square = np.where(bad, 1, _dot(normal, normal))
    along_first = divide(_dot(np.cross(way, second.direction), normal), square)
    along_second = divide(_dot(np.cross(way, first.direction), normal), square)
    start = first.foot()
    feet = start + along_first * first.direction, start + way + along_second * second.direction
    if bad.any():
        return np.where(bad, np.nan, as_float(feet[0])), np.where(bad, np.nan, as_float(feet[1]))
    return feet


def _is_loose(first: Line, second: Line, way: np.ndarray, normal: np.ndarray) -> Any:
    """Whether rounding of the directions alone may move the feet by a part of the size of the lines."""
    if is_exact(normal) and is_exact(way):
        return False
    sine = _length(normal) / (_length(first.direction) * _length(second.direction))
    square = np.where(sine > 0, sine, 1) ** 2
    gap = np.abs(as_float(_dot(way, normal)[..., 0])) / np.where(sine > 0, _length(normal), 1)
    return 2.0**-52 * gap / square > FOOT * (gap + _length(first.foot()) + _length(way))


def _length(x: np.ndarray) -> np.ndarray:
    return np.linalg.norm(as_float(x), axis=-1)
