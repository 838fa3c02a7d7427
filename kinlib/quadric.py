"""Quadrics of projective space, given by their bilinear form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kinlib.number_field import square_root
from kinlib.projective import Subspace, coordinates_of, null_space, same_point
from kinlib.scalar import (
    RTOL,
    ScalarLike,
    as_float,
    as_scalars,
    check_finite,
    divide,
    is_exact,
    is_zero,
    plain,
    promote,
    read_only,
    size,
)
from kinlib.typing import Array, HomogeneousLike, MatrixLike

__all__ = ["Quadric", "binary_roots"]


@dataclass(frozen=True, eq=False, init=False)
class Quadric:
    """The points x with form(x, x) = 0.

    Parameters
    ----------
    matrix : array_like, shape (n+1, n+1)
        The symmetric matrix of the bilinear form.
    scale : float
        The size of the numbers that were added up to the entries, where these may all be rounding: it is what floats
        are compared with.

    Examples
    --------
    >>> sphere = Quadric([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> sphere.contains([5, 3, 4, 0]), sphere.rank(), sphere.signature()
    (True, 4, (3, 1))
    """

    matrix: np.ndarray
    scale: float

    def __init__(self, matrix: MatrixLike, scale: float = 0.0):
        matrix = as_scalars(matrix)
        if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
            raise ValueError(f"expected a square matrix, got shape {matrix.shape}")
        check_finite(matrix, "coefficients of a quadric")
        scale = max(float(scale), size(matrix))
        if not np.all(is_zero(matrix - matrix.T, scale)):
            raise ValueError("expected a symmetric matrix: a quadric is given by a symmetric bilinear form")
        object.__setattr__(self, "matrix", read_only(matrix))
        object.__setattr__(self, "scale", scale)

    def __reduce__(self) -> tuple[Any, ...]:
        return Quadric, (self.matrix, self.scale)

    def _coordinates(self, x: HomogeneousLike) -> Array:
        array = coordinates_of(x)
        if array.shape[-1] != len(self.matrix):
            raise ValueError(f"expected points of shape (..., {len(self.matrix)}), got {array.shape}")
        return array

    def form(self, x: HomogeneousLike, y: HomogeneousLike) -> Any:
        """The bilinear form at points x, y of shape (..., n+1); batches broadcast."""
        return (self.tangent_hyperplane(x) * self._coordinates(y)).sum(axis=-1)

    def gram(self, points: Any) -> Array:
        """The matrix of the form on k points, shape (k, k): entry (r, s) is form(points[r], points[s]).

        Examples
        --------
        >>> saddle = Quadric([[0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]])   # x₀x₃ = x₁x₂
        >>> saddle.gram([[1, 1, 1, 1], [1, 0, 0, 0]]).tolist()
        [[0, 1], [1, 0]]
        """
        rows, matrix = promote(np.stack([self._coordinates(point) for point in points]), self.matrix)
        return _symmetric(rows @ matrix @ rows.T)

    def contains(self, x: HomogeneousLike | Subspace, *, rtol: float = RTOL) -> Any:
        """Whether points lie on the quadric, or whether a whole subspace does."""
        if isinstance(x, Subspace):
            return bool(np.all([is_zero(self.form(p, q), self._size(p, q), rtol) for p in x.basis for q in x.basis]))
        return is_zero(self.form(x, x), self._size(x, x), rtol)

    def _size(self, x: HomogeneousLike, y: HomogeneousLike) -> Any:
        """The sum of the terms of form(x, y) without their signs, as a float: what rounding is compared with."""
        x, y = self._coordinates(x), self._coordinates(y)
        if all(is_exact(z) for z in (x, y, self.matrix)):
            return 0.0
        x, y, matrix = (np.abs(as_float(z)) for z in (x, y, self.matrix))
        return (x @ matrix * y).sum(axis=-1)

    def tangent_hyperplane(self, x: HomogeneousLike) -> Array:
        """The linear form y ↦ form(x, y), as its coefficients, shape (..., n+1)."""
        x, matrix = promote(self._coordinates(x), self.matrix)
        return x @ matrix

    def rank(self, *, rtol: float = RTOL) -> int:
        """The rank of the form; the quadric is regular if it is n+1."""
        return len(self.matrix) - len(self.singular_points(rtol=rtol))

    def singular_points(self, *, rtol: float = RTOL) -> Array:
        """A basis of the points at which there is no tangent hyperplane, shape (n+1 − rank, n+1)."""
        return null_space(self.matrix, rtol=rtol, scale=self.scale)

    def signature(self, *, rtol: float = RTOL) -> tuple[int, int]:
        """How many positive and how many negative squares the form has, by Sylvester's law of inertia."""
        eigenvalues = np.linalg.eigvalsh(as_float(self.matrix))
        cut = rtol * max(np.abs(eigenvalues).max(initial=0), self.scale)
        return int((eigenvalues > cut).sum()), int((eigenvalues < -cut).sum())

    def restrict(self, subspace: Subspace) -> Quadric:
        """The intersection with a subspace, in the coordinates of its basis."""
        if not isinstance(subspace, Subspace):
            raise TypeError(f"expected a Subspace, got {type(subspace).__name__}: join(points) makes one")
        basis = subspace.basis
        return Quadric(self.gram(basis), size(self._size(basis[:, None], basis[None])))

    def rulings_through(self, x: HomogeneousLike) -> tuple[Subspace, Subspace]:
        """The two lines on a quadric surface of P³ that pass through its point x.

        Raises
        ------
        ValueError
            If x is not on the surface, the surface is singular at x, or the two lines are complex.

        Examples
        --------
        >>> saddle = Quadric([[0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]])   # x₀x₃ = x₁x₂
        >>> first, second = saddle.rulings_through([1, 0, 0, 0])
        >>> [0, 1, 0, 0] in first, [0, 0, 1, 0] in second
        (True, True)
        """
        if len(self.matrix) != 4 or not np.all(self.contains(x)):
            raise ValueError("expected a point on a quadric surface of three-dimensional space")
        x = self._coordinates(x)
        if x.ndim != 1:
            raise ValueError(f"expected a single point, got a batch of shape {x.shape[:-1]}")
        tangent = null_space(self.tangent_hyperplane(x)[None])
        if len(tangent) == 4:
            raise ValueError("the surface is singular at this point")
        directions = [y for y in tangent if not same_point(x, y)]
        pair = directions[:2] if _independent(x, directions[0], directions[1]) else directions[1:]
        roots = binary_roots(*(self.form(pair[a], pair[b]) for a, b in ((0, 0), (0, 1), (1, 1))))
        first, second = (Subspace(np.array([x, s * pair[0] + t * pair[1]])) for s, t in roots)
        return first, second


def _independent(*rows: Any) -> bool:
    return len(null_space(np.array(rows))) == len(rows[0]) - len(rows)


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    """A Gram matrix without the rounding that makes it unsymmetric."""
    return matrix if matrix.dtype.kind != "f" else (matrix + matrix.T) / 2


def binary_roots(a: ScalarLike, b: ScalarLike, c: ScalarLike) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """The two points (s, t) of the projective line with as² + 2bst + ct² = 0.

    Raises
    ------
    ValueError
        If they are not real, or every point is one.

    Examples
    --------
    >>> binary_roots(1, 0, -4)
    ((Fraction(2, 1), 1), (Fraction(-2, 1), 1))
    """
    if any(isinstance(x, (np.ndarray, list, tuple)) for x in (a, b, c)):
        raise TypeError("expected three numbers a, b, c, got arrays")
    return _binary_roots(*(plain(x) for x in (a, b, c)))


def _binary_roots(a: Any, b: Any, c: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    check_finite(as_scalars([a, b, c]), "coefficients")
    if any(isinstance(x, complex) for x in (a, b, c)):
        raise ValueError("expected a real form, got complex coefficients")
    scale = size([a, b, c])
    if np.all(is_zero(np.array([a, b, c]), rtol=0)):
        raise ValueError("every point is a root of the form 0")
    discriminant = b * b - a * c
    if discriminant < 0:
        raise ValueError("the two roots are complex")
    root = square_root(discriminant)
    q = -b - root if b > 0 else -b + root
    if is_zero(q, scale):  # then b and the root vanish: a double root
        return ((1, 0), (1, 0)) if is_zero(a, scale) else ((0, 1), (0, 1))
    return (_plain(q, a), _plain(c, q))


def _plain(s: Any, t: Any) -> tuple[Any, Any]:
    """Homogeneous coordinates (s, t), with t = 1 where it can be."""
    return (s, t) if is_zero(t, size([s, t])) else (divide(s, t), 1)
