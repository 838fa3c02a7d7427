"""Points and subspaces of projective space: equality, join and meet, over any scalars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.scalar import RTOL, as_scalars, check_finite, divide, is_exact, is_zero, promote, read_only, size
from kinlib.typing import Array, HomogeneousLike, MatrixLike

__all__ = ["Subspace", "coordinates_of", "join", "meet", "null_space", "same_point"]


def coordinates_of(point: HomogeneousLike) -> Array:
    """Homogeneous coordinates, shape (..., n+1), of a dual quaternion or an array."""
    if isinstance(point, DualQuaternion):
        return point.coeffs
    array = as_scalars(point)
    if array.ndim == 0:
        raise ValueError(f"expected homogeneous coordinates of shape (..., n+1), got the number {point!r}")
    return array


def same_point(x: HomogeneousLike, y: HomogeneousLike, *, rtol: float = RTOL, length: float = 1.0) -> Any:
    """Whether x and y are one point of projective space, that is, multiples of each other.

    Parameters
    ----------
    x, y : DualQuaternion or array_like, shape (..., n+1)
        Homogeneous coordinates; batches broadcast.
    rtol : float
        Relative tolerance for floats; exact scalars are compared exactly.
    length : float
        The unit in which the dual parts of dual quaternions are measured, where they are floats: give the size of
        the mechanism.

    Returns
    -------
    bool or numpy.ndarray of bool
        False wherever x or y vanishes, since zero is no point, and for NaN and infinity.

    Examples
    --------
    >>> same_point(1 + i, -2 - 2 * i), same_point(1 + i, 1 - i)
    (True, False)
    """
    x, y = promote(*(coordinates_of(point) for point in (x, y)))
    _check_dimensions(x, y)
    x, y = np.broadcast_arrays(*(_finite_or_nan(_measured(z, length)) for z in (x, y)))
    pivot = np.expand_dims(_largest(y), -1)
    minors = x * np.take_along_axis(y, pivot, -1) - y * np.take_along_axis(x, pivot, -1)
    scale = 0 if is_exact(minors) else (size(x, axis=-1) * size(y, axis=-1))[..., None]
    vanish = np.all(is_zero(minors, scale, rtol), axis=-1)
    answers = vanish & _is_point(x) & _is_point(y)
    return bool(answers) if answers.ndim == 0 else answers


def _check_dimensions(*points: np.ndarray) -> None:
    """Refuse points of projective spaces of different dimensions."""
    counts = sorted({x.shape[-1] for x in points})
    if len(counts) > 1:
        raise ValueError(f"expected points of one projective space, got {' and '.join(map(str, counts))} coordinates")


def _finite_or_nan(x: np.ndarray) -> np.ndarray:
    return x if x.dtype.kind not in "fc" or np.isfinite(x).all() else np.where(np.isfinite(x), x, np.nan)


def _is_point(x: np.ndarray) -> Any:
    return ~np.all(is_zero(x, rtol=0), axis=-1)


def _measured(x: np.ndarray, length: float) -> np.ndarray:
    if length == 1.0 or x.shape[-1] != 8 or is_exact(x):
        return x
    return x / np.array([1.0] * 4 + [length] * 4)


def _largest(x: np.ndarray) -> np.ndarray:
    """The index of the largest entry on the last axis; for exact scalars, of the first that is not zero."""
    if is_exact(x):
        return np.argmax(~np.asarray(is_zero(x)), axis=-1)
    return np.argmax(np.abs(x), axis=-1)


def _eliminate(matrix: np.ndarray, rtol: float, scale: float = 0.0) -> tuple[np.ndarray, list[int]]:
    """Reduced row echelon form by Gauss and Jordan with full pivoting, and its pivot columns."""
    check_finite(matrix, "coordinates")
    rows = np.array(divide(matrix, 1))
    scale, pivots = max(size(rows), scale), []
    for n in range(min(rows.shape)):
        position = np.unravel_index(_largest(rows[n:].ravel()), rows[n:].shape)
        row, column = int(position[0]) + n, int(position[1])
        if is_zero(rows[row, column], scale, rtol):
            break
        rows[[n, row]] = rows[[row, n]]
        rows[n] = rows[n] / rows[n, column]
        others = np.arange(len(rows)) != n
        rows[others] = rows[others] - rows[others, column][:, None] * rows[n]
        pivots.append(column)
    return rows[: len(pivots)], pivots


def null_space(matrix: MatrixLike, *, rtol: float = RTOL, scale: float = 0.0) -> Array:
    """A basis of all x with ``matrix @ x = 0``, one vector a row.

    Parameters
    ----------
    matrix : array_like, shape (m, n)
    rtol : float
        What counts as zero, relative to the largest entry; exact scalars are compared exactly.
    scale : float
        The size of the numbers that were added up to the entries, where these may all be rounding.

    Returns
    -------
    numpy.ndarray, shape (n − rank, n)

    Examples
    --------
    >>> null_space([[1, 1, 0], [0, 0, 1]]).tolist()
    [[Fraction(-1, 1), Fraction(1, 1), Fraction(0, 1)]]
    """
    matrix = as_scalars(matrix)
    if matrix.ndim != 2:
        raise ValueError(f"expected a matrix of shape (m, n), got {matrix.shape}")
    rows, pivots = _eliminate(matrix, rtol, scale)
    free = [column for column in range(matrix.shape[1]) if column not in pivots]
    basis = np.zeros((len(free), matrix.shape[1]), dtype=rows.dtype)
    for vector, column in zip(basis, free, strict=True):
        vector[column] = 1
        vector[pivots] = -rows[:, column]
    return divide(basis, 1)


@dataclass(frozen=True, eq=False, init=False)
class Subspace:
    """A subspace of projective space, spanned by independent points.

    Parameters
    ----------
    basis : array_like, shape (d+1, n+1), or DualQuaternion batch of shape (d+1,)
        Independent points; d is the dimension (0 a point, 1 a line, 2 a plane, 3 a three-space).
    rtol : float
        What counts as zero for floats.

    Raises
    ------
    ValueError
        If the points are dependent; use :func:`join` for the span of any points.

    Examples
    --------
    >>> plane = join(one, i, j)
    >>> plane.dimension, i + j in plane, k in plane
    (2, True, False)
    """

    basis: np.ndarray
    rtol: float

    def __init__(self, basis: HomogeneousLike, rtol: float = RTOL):
        basis = coordinates_of(basis)
        if basis.ndim != 2:
            raise ValueError(f"expected a basis of shape (d+1, n+1), got {basis.shape}")
        rank = len(_eliminate(_rows_of_size_one(basis), rtol)[1])
        if rank < len(basis):
            raise ValueError(f"expected independent points, got {len(basis)} of rank {rank}")
        object.__setattr__(self, "basis", read_only(basis))
        object.__setattr__(self, "rtol", rtol)

    def __reduce__(self) -> tuple[Any, ...]:
        return Subspace, (self.basis, self.rtol)

    @property
    def dimension(self) -> int:
        """The projective dimension: 0 for a point, 3 for a three-space, −1 for the empty set."""
        return len(self.basis) - 1

    @property
    def points(self) -> DualQuaternion:
        """The basis as dual quaternions, for a subspace of P⁷."""
        return DualQuaternion(self.basis)

    def contains(self, point: HomogeneousLike | Subspace) -> bool:
        """Whether the subspace contains a point, or another subspace."""
        rows = _rows(point)
        if not np.all(_is_point(rows)):
            return False  # zero is no point
        return join(self, *rows, rtol=self.rtol).dimension == self.dimension

    __contains__ = contains

    def equations(self) -> Array:
        """Linear forms, one a row, whose common zeros are the subspace; shape (n − d, n+1)."""
        return null_space(self.basis, rtol=self.rtol)


def _rows_of_size_one(rows: np.ndarray) -> np.ndarray:
    if is_exact(rows):
        return rows
    check_finite(rows, "coordinates")
    sizes = size(rows, axis=-1)
    return rows / np.where(sizes > 0, sizes, 1)[:, None]


def _rows(thing: Any) -> np.ndarray:
    if isinstance(thing, Subspace):
        return thing.basis
    rows = np.atleast_2d(coordinates_of(thing))
    if not rows.shape[-1]:
        raise ValueError("expected homogeneous coordinates of shape (..., n+1), got none")
    return rows.reshape(-1, rows.shape[-1])


def join(*things: HomogeneousLike | Subspace, rtol: float = RTOL) -> Subspace:
    """The smallest subspace that contains all the given points and subspaces.

    Raises
    ------
    ValueError
        If nothing is given, if a number is not finite, or if the points are of different spaces.

    Examples
    --------
    >>> join(one, i, 2 * one - i).dimension
    1
    """
    if not things:
        raise ValueError("expected points or subspaces to join, got nothing")
    given = [_rows(thing) for thing in things]
    _check_dimensions(*given)
    rows = _rows_of_size_one(np.concatenate(promote(*given)))
    reduced, _ = _eliminate(rows, rtol)
    return Subspace(reduced, rtol)


def meet(first: Subspace, second: Subspace) -> Subspace:
    """The common points of two subspaces; dimension −1 if there are none.

    Examples
    --------
    >>> meet(join(one, i, j), join(i, j, k)).dimension, meet(join(one, i), join(j, k)).dimension
    (1, -1)
    """
    for thing in (first, second):
        if not isinstance(thing, Subspace):
            raise TypeError(f"expected a Subspace, got {type(thing).__name__}: join(points) makes one")
    _check_dimensions(first.basis, second.basis)
    equations = np.concatenate(promote(first.equations(), second.equations()))
    return Subspace(null_space(equations, rtol=first.rtol), first.rtol)
