"""The quadrics of kinematics: Study quadric, null cone, exceptional three-space, null lines."""

from __future__ import annotations

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, as_dual_quaternion, dual_size, eps_times, primal_size
from kinlib.errors import DegenerateError, check_degenerate, named_rows, rows_where
from kinlib.projective import Subspace
from kinlib.quadric import Quadric
from kinlib.scalar import RTOL, as_float, is_zero, size
from kinlib.typing import Degenerate

__all__ = ["EXCEPTIONAL_SPACE", "NULL_CONE", "STUDY_QUADRIC", "is_null_line", "study_projection"]

_I, _O = np.eye(4, dtype=int), np.zeros((4, 4), dtype=int)

STUDY_QUADRIC = Quadric(np.block([[_O, _I], [_I, _O]]))
"""𝒮: the points [q] whose norm q q̄ is real; form b(x, y) = Σ (x_k y_{k+4} + x_{k+4} y_k)."""

NULL_CONE = Quadric(np.block([[_I, _O], [_O, _O]]))
"""𝒩: the points [q] whose norm has no real part; form ⟨x, y⟩ = Σ x_k y_k over the primal parts."""

EXCEPTIONAL_SPACE = Subspace(np.hstack([_O, _I]))
"""E: the points [εd], singular on the null cone and contained in the Study quadric."""


def is_null_line(x: DualQuaternion, y: DualQuaternion, *, rtol: float = RTOL) -> bool:
    """Whether the line [x] ∨ [y] lies on the Study quadric and on the null cone.

    By Lemma 1 this is so exactly when ``x x̄ = y ȳ = x ȳ + y x̄ = 0``.

    Parameters
    ----------
    x, y : DualQuaternion
        Two different points of P⁷, real or complex.
    rtol : float
        What counts as zero, relative to the size of x and y; exact scalars are compared exactly.

    Raises
    ------
    ValueError
        If x or y is a batch: one line is asked about.

    Examples
    --------
    >>> h1, h2 = i, j - eps * i                  # skew axes, one apart
    >>> is_null_line(1j - h1, (1j - h1) * h2)    # t1 = √−1 in equation (2)
    True
    """
    if as_dual_quaternion(x).shape or as_dual_quaternion(y).shape:
        raise ValueError(f"expected two single points, got batches of shapes {x.shape} and {y.shape}")
    conditions = (x.norm(), y.norm(), x * y.conjugate() + y * x.conjugate())
    (p, d), (r, e) = ((size(primal_size(q)), size(dual_size(q))) for q in (x, y))
    scales = ((p * p, p * d), (r * r, r * e), (p * r, p * e + d * r))
    return all(
        np.all(is_zero(c.coeffs[..., half], scale, rtol))
        for c, pair in zip(conditions, scales, strict=True)
        for half, scale in zip((slice(0, 4), slice(4, 8)), pair, strict=True)
    )


def study_projection(q: DualQuaternion, *, degenerate: Degenerate = "raise") -> DualQuaternion:
    """The point of the Study quadric outside E on the line that joins [q] to the point [εp] of E, p its primal part.

    With q q̄ = a + εb this is [q (2a − εb)]; it has the same orientation as q.  The line has just two points in common
    with the quadric, this one and [εp].

    Parameters
    ----------
    q : DualQuaternion, shape (...)
        Not in the exceptional space.
    degenerate : {"raise", "nan"}
        What becomes of rows in the exceptional space.

    Raises
    ------
    DegenerateError
        If q lies in the exceptional space: it has no orientation.

    Examples
    --------
    >>> study_projection(1 + eps)
    2
    """
    check_degenerate(degenerate)
    a, b = as_dual_quaternion(q).norm().components[[0, 4]]
    zero = np.asarray(is_zero(a, rtol=0))
    if zero.any() and degenerate == "raise":
        rows = rows_where(zero)
        message = "the point lies on the null cone: its primal part has no direction"
        raise DegenerateError(named_rows(rows) + message, rows=rows)
    projected = q * (2 * a) - eps_times(q) * b
    if not zero.any():
        return projected
    return DualQuaternion(np.where(zero[..., None], np.nan, as_float(projected.coeffs)))
