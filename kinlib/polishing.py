"""Products of linear factors: their coefficients, how far they are from a polynomial, and factors that are nearer."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise
from operator import mul
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, left_matrix, null_form, one, right_matrix
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.scalar import is_exact, is_zero
from kinlib.typing import Array

__all__ = ["polished", "polished_at", "product_of", "residual", "solved"]


def product_of(factors: Sequence[DualQuaternion]) -> list[DualQuaternion]:
    """The coefficients of (t − h_1) ⋯ (t − h_n)."""
    product = [DualQuaternion([1] + [0] * 7)]
    for h in factors:
        last = [-h] if len(product) == 1 else [-(product[-1] * h)]
        product = [product[0], *(c - b * h if n else c - h for n, (b, c) in enumerate(pairwise(product))), *last]
    return product


def residual(coefficients: Sequence[DualQuaternion], factors: Sequence[DualQuaternion]) -> np.ndarray:
    """How far the product of factors is from a polynomial, relative to the numbers that are added; 0 or ∞ if exact.

    Each coefficient is compared with that of Π(t + |h|), dual parts with the longest dual part besides.
    """
    differences = [c - d for c, d in zip(coefficients[1:], product_of(factors)[1:], strict=True)]
    if all(is_exact(d.components) for d in differences):
        equal = np.all([np.all(is_zero(d.components), axis=0) for d in differences], axis=0)
        return np.where(equal, 0.0, np.inf)
    primal = [np.sqrt((h.components[:4] ** 2).sum(axis=0)) for h in factors]
    dual = reduce(np.maximum, [np.abs(h.components[4:]).max(axis=0) / r for h, r in zip(factors, primal, strict=True)])
    bounds = [1.0]
    for r in primal:
        bounds = [1.0, *(a + b * r for a, b in zip([*bounds[1:], 0.0], bounds, strict=True))]
    return reduce(
        np.maximum,
        [
            np.maximum(np.abs(d.components[:4]).max(axis=0), np.abs(d.components[4:]).max(axis=0) / (1 + dual)) / bound
            for d, bound in zip(differences, bounds[1:], strict=True)
        ],
    )


def polished(C: MotionPolynomial, factors: Sequence[DualQuaternion], steps: int = 3) -> list[DualQuaternion]:
    """Factors nearer to those of C, in floats: Newton's method for (t − h_1) ⋯ (t − h_n) = C in all coefficients.

    Moving h_j by δ changes the product by −(t − h_1) ⋯ δ ⋯ (t − h_n), a sum of left and right multiplications.
    """
    n, factors = len(factors), list(factors)
    with np.errstate(invalid="ignore", over="ignore"):
        for _ in range(steps):
            missing = [c - d for c, d in zip(C.coefficients[1:], product_of(factors)[1:], strict=True)]
            right = DualQuaternion.stack(missing, axis=-1).coeffs
            shape = right.shape[:-2]
            right = right.reshape(*shape, 8 * n, 1)
            moves = DualQuaternion(solved(_derivative(factors, shape), right).reshape(*shape, n, 8))
            factors = [h + moves[..., j] for j, h in enumerate(factors)]
    return factors


def polished_at(
    t: Sequence[Any] | Array, values: Sequence[DualQuaternion], factors: Sequence[DualQuaternion], steps: int = 2
) -> list[DualQuaternion]:
    """Factors whose product is nearer to given values at n parameters: Newton's method as in :func:`polished`.

    Where the values are of very different sizes these digits do not drown in the coefficients of the polynomial.
    """
    n, factors = len(factors), list(factors)
    sizes = [np.sqrt(null_form(v, v)) for v in values]
    with np.errstate(all="ignore"):
        for _ in range(steps):
            turns = [[s - h for h in factors] for s in t]
            missing = [(reduce(mul, x) - v) / size for x, v, size in zip(turns, values, sizes, strict=True)]
            right = DualQuaternion.stack(missing, axis=-1).coeffs
            matrix = np.zeros((*right.shape[:-2], n, 8, n, 8))
            for row, (x, size) in enumerate(zip(turns, sizes, strict=True)):
                for j in range(n):
                    before, after = reduce(mul, x[:j], one), reduce(mul, x[j + 1 :], one)
                    matrix[..., row, :, j, :] = left_matrix(before / size) @ right_matrix(after)
            matrix = matrix.reshape(*right.shape[:-2], 8 * n, 8 * n)
            moves = DualQuaternion(solved(matrix, right.reshape(*right.shape[:-2], 8 * n, 1)).reshape(right.shape))
            factors = [h + moves[..., j] for j, h in enumerate(factors)]
    return factors


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solutions of linear systems in floats; the shortest one where a matrix of the batch is singular."""
    matrix, right = (np.nan_to_num(x, posinf=0, neginf=0) for x in (matrix, right))
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return _shortest_where_singular(matrix, right)


def _shortest_where_singular(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Each singular system by itself: the others are solved as if it were not there."""
    rows = matrix.reshape(-1, *matrix.shape[-2:]), right.reshape(-1, *right.shape[-2:])
    if len(rows[0]) == 1:
        return np.linalg.pinv(matrix, rcond=1e-14) @ right
    halves = zip(*(np.array_split(x, 2) for x in rows), strict=True)
    return np.concatenate([solved(*half) for half in halves]).reshape(right.shape)


def _derivative(factors: Sequence[DualQuaternion], shape: tuple[int, ...]) -> np.ndarray:
    """The matrix of the change of all coefficients of the product with all factors, shape (..., 8n, 8n)."""
    n = len(factors)
    matrix = np.zeros((*shape, n, 8, n, 8))
    for j in range(n):
        lefts = [left_matrix(q) for q in product_of(factors[:j])]
        rights = [right_matrix(q) for q in product_of(factors[j + 1 :])]
        for a, left in enumerate(lefts):
            for b, right in enumerate(rights):
                matrix[..., a + b, :, j, :] -= left @ right
    return matrix.reshape(*shape, 8 * n, 8 * n)
