"""Splitting motion polynomials into linear factors: turns about fixed axes.

The norm polynomial C C̄ of a motion polynomial of degree n is a product of n real quadratic polynomials.
Each order of them gives one factorization C = (t − h_1) ⋯ (t − h_n) with the n-th of these quadratics as
(t − h_n)(t − h̄_n) (Hegedüs, Schicho & Schröcker 2013, Theorem 1).  Splitting the real polynomial is the only
irrational step.

In floats the parameter t is first moved to the middle of the roots and measured in their unit: neither matters to
the linear factors, both matter to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations
from operator import index
from typing import NamedTuple, TypeAlias

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.errors import Fault, first_fault, report_faults
from kinlib.motion_polynomial import MotionPolynomial, check_monic
from kinlib.polishing import polished, residual
from kinlib.poses import power_of_two
from kinlib.quadratics import (
    RootFault,
    eigenvalue_roots,
    in_order,
    quadratic_factors,
    quadratics_with,
    shifted,
    stepped,
)
from kinlib.rows import masked, replaced
from kinlib.scalar import as_float, as_scalars, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, Degenerate

__all__ = ["bennett_flip", "exchange", "factorizations", "factorize", "quadratic_of"]

Orders: TypeAlias = Sequence[Sequence[int]]
"""Permutations of the numbers of the quadratic factors."""


class FactorFault(Fault):
    """Why a motion polynomial has no factors."""

    REAL_ROOT = 1, RootFault.REAL.message
    REAL_FACTOR = (
        2,
        "the primal part has a real factor (a remainder modulo a quadratic factor of the norm polynomial has no "
        "inverse): no linear factor is determined",
    )
    UNSPLIT = 3, "the polynomial has no factorization with its quadratic factors in this order"


PRODUCT_RTOL = 1e-9
"""How far the product of the factors may be from the polynomial, relative to the numbers that are added."""

POLISH_RTOL = 1e-12
"""From which such distance on the factors are polished."""


NO_INVERSE = 1e-3
"""How small a remainder may be before it is blamed, where there are no factors."""


def quadratic_of(h: DualQuaternion) -> np.ndarray:
    """The real polynomial (t − h)(t − h̄) = t² − (h + h̄)t + h h̄, shape (..., 3)."""
    real = h.scalar_part
    return np.stack([real * 0 + 1, -2 * real, h.norm().scalar_part], axis=-1)


def factorizations(C: MotionPolynomial, *, degenerate: Degenerate = "raise") -> list[tuple[DualQuaternion, ...]]:
    """All n! factorizations of a monic motion polynomial, one for each order of its quadratic factors.

    Parameters
    ----------
    C : MotionPolynomial
        Monic, of degree n.
    degenerate : {"raise", "nan"}
        What becomes of rows of a batch without factorizations: an error that names them, or NaN.

    Returns
    -------
    list of tuples
        (h_1, …, h_n) with C = (t − h_1) ⋯ (t − h_n), in the order of ``itertools.permutations`` of the
        quadratic factors.

    Raises
    ------
    DegenerateError
        If an order has no factorization, as with translations or repeated factors that do not split.

    Examples
    --------
    >>> from kinlib import linear_factor
    >>> C = linear_factor(i) * linear_factor(2 * j - 2 * eps * i)
    >>> for h1, h2 in factorizations(C):
    ...     print(h1, "|", h2)
    i | 2 j - 2 εi
    8/5 i + 6/5 j - 18/25 εi + 24/25 εj | -3/5 i + 4/5 j - 32/25 εi - 24/25 εj
    """
    bad = check_monic(C, degenerate)
    if C.degree == 0:
        return [()]
    orders = list(permutations(range(C.degree)))
    factors = _factors(C, orders, None, bad, degenerate)
    return [tuple(h[..., n] for h in factors) for n in range(len(orders))]


def factorize(
    C: MotionPolynomial,
    order: Sequence[int],
    quadratics: ArrayLike | None = None,
    *,
    degenerate: Degenerate = "raise",
) -> tuple[DualQuaternion, ...]:
    """The factorization in which the n-th factor has the quadratic polynomial number ``order[n]``.

    Parameters
    ----------
    C : MotionPolynomial
        Monic, of degree n.
    order : sequence of int
        A permutation of 0, …, n−1.
    quadratics : array_like, shape (..., n, 3), optional
        The factors of C C̄ in a numbering of your own; by default that of :func:`quadratic_factors`.
    degenerate : {"raise", "nan"}
        What becomes of rows of a batch without this factorization: an error that names them, or NaN.

    Examples
    --------
    >>> from kinlib import linear_factor
    >>> h1, h2 = factorize(linear_factor(i) * linear_factor(2 * j - 2 * eps * i), (1, 0))
    >>> linear_factor(h1) * linear_factor(h2) == linear_factor(i) * linear_factor(2 * j - 2 * eps * i)
    True
    """
    bad = check_monic(C, degenerate)
    order = _checked_order(order, C.degree)
    if quadratics is not None:
        quadratics = as_scalars(quadratics)
        if quadratics.shape[-2:] != (C.degree, 3):
            raise ValueError(f"expected quadratics of shape (..., {C.degree}, 3), got {quadratics.shape}")
    return tuple(h[..., 0] for h in _factors(C, [order], quadratics, bad, degenerate)) if C.degree else ()


def _checked_order(order: Sequence[int], degree: int) -> tuple[int, ...]:
    try:
        numbers = tuple(index(n) for n in order)
    except TypeError:
        raise TypeError(f"expected an order: a permutation of whole numbers, got {order!r}") from None
    if sorted(numbers) != list(range(degree)):
        raise ValueError(f"expected a permutation of 0, …, {degree - 1}, got {numbers}")
    return numbers


def _factors(
    C: MotionPolynomial, orders: Orders, quadratics: np.ndarray | None, bad: np.ndarray, degenerate: Degenerate
) -> list[DualQuaternion]:
    """The factors for several orders at once, checked; orders on the last axis, NaN in the bad rows."""
    if all(is_exact(c.components) for c in C.coefficients) and (quadratics is None or is_exact(quadratics)):
        factors, faults = factored(C, orders, quadratics)
        report_faults(faults, FactorFault, "raise")
        return factors
    placed = centred(C)
    factors, faults = factored(placed.C, orders, placed.moved(quadratics))
    bad = bad | report_faults(np.where(bad, 0, faults), FactorFault, degenerate)
    return [masked(h, bad[..., None]) for h in placed.outward(factors)]


class Centred(NamedTuple):
    """A motion polynomial in u = (t − centre) / unit, in which its roots are about zero and of size about one."""

    C: MotionPolynomial
    centre: np.ndarray
    unit: np.ndarray

    def moved(self, quadratics: np.ndarray | None) -> np.ndarray | None:
        """Quadratic polynomials in t as such in u."""
        if quadratics is None:
            return None
        _, b, c = np.moveaxis(as_float(quadratics), -1, 0)
        centre, unit = self.centre[..., None], self.unit[..., None]
        return np.stack(
            [np.ones(np.shape(b + centre)), (2 * centre + b) / unit, (centre**2 + b * centre + c) / unit**2], axis=-1
        )

    def outward(self, factors: Sequence[DualQuaternion]) -> list[DualQuaternion]:
        """Linear factors in u as such in t."""
        return [h * self.unit[..., None] + self.centre[..., None] for h in factors]


def centred(C: MotionPolynomial) -> Centred:
    """A monic polynomial in floats, in the parameter that suits its roots."""
    n = C.degree
    coefficients = [DualQuaternion(as_float(c.coeffs)) for c in C.coefficients]
    with np.errstate(all="ignore"):
        centre = -coefficients[1].scalar_part / n
        coefficients = shifted(coefficients, centre)
        mean = null_form(coefficients[-1], coefficients[-1]) ** (0.5 / n)
        unit = power_of_two(mean)
        coefficients = [coefficients[0], *(c * unit**-m for m, c in enumerate(coefficients[1:], start=1))]
        return Centred(MotionPolynomial.from_coefficients(coefficients), np.asarray(centre), unit)


def factored(
    C: MotionPolynomial, orders: Orders, quadratics: np.ndarray | None = None
) -> tuple[list[DualQuaternion], Array]:
    """The factors of a monic polynomial for several orders, on the last axis, and the fault of each row.

    In floats the roots should be about zero and of size about one, see :func:`centred`.
    """
    exact = all(is_exact(c.components) for c in C.coefficients)
    real = np.zeros(C.shape, dtype=bool)
    if quadratics is None and exact:
        quadratics = quadratic_factors(C.norm_polynomial())
    elif quadratics is None:
        quadratics, real = split_motion(C)
    with np.errstate(all="ignore"):
        factors, least = divided_off(C, quadratics, orders)
        missing = residual([c[..., None] for c in C.coefficients], factors)
        if not exact:
            factors, missing = _repaired(C, factors, missing)
    unsplit = ~(missing <= (0 if exact else PRODUCT_RTOL))
    no_inverse = unsplit & (least <= (0 if exact else NO_INVERSE))
    faults = first_fault(
        (real, FactorFault.REAL_ROOT),
        (no_inverse.any(axis=-1), FactorFault.REAL_FACTOR),
        (unsplit.any(axis=-1), FactorFault.UNSPLIT),
    )
    return factors, faults


def split_motion(C: MotionPolynomial) -> tuple[np.ndarray, np.ndarray]:
    """The quadratic factors of C C̄ in floats, and where there are real roots.

    The roots are improved by Newton's method for ⟨C(t), C(t)⟩ = 0, which cancels less than the expanded polynomial.
    """
    with np.errstate(all="ignore"):
        roots = eigenvalue_roots(as_float(C.norm_polynomial()))
        value, slope = _value_and_slope(C, roots)
        roots = stepped(roots, (value * value).sum(axis=0) / (2 * (value * slope).sum(axis=0)))
        return quadratics_with(in_order(roots)), np.any(roots.imag <= 0, axis=-1)


def _value_and_slope(C: MotionPolynomial, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The primal parts of C and of its derivative, components first, at several parameters of each row."""
    coefficients = [
        c.components[:4].reshape(4, *(1,) * (t.ndim - c.components.ndim), *c.shape, 1) for c in C.coefficients
    ]
    value, slope = coefficients[0] + 0 * t, 0 * t
    for c in coefficients[1:]:
        slope = slope * t + value
        value = value * t + c
    return value, slope


def factor_in_orders(C: MotionPolynomial, quadratics: np.ndarray, orders: Orders) -> list[DualQuaternion]:
    """The factors h_1, …, h_n for several orders at once, each of shape (..., len(orders)), unchecked."""
    factors, least = divided_off(C, quadratics, orders)
    report_faults((np.asarray(least) == 0).any(axis=-1) * FactorFault.REAL_FACTOR, FactorFault, "raise")
    return factors


def divided_off(C: MotionPolynomial, quadratics: np.ndarray, orders: Orders) -> tuple[list[DualQuaternion], np.ndarray]:
    """The factors for several orders, divided off from the right, and how far the least remainder is from zero."""
    rest = [c[..., None] for c in C.coefficients]
    factors: list[DualQuaternion] = []
    least = np.full(len(orders), np.inf)
    for place in range(C.degree - 1, 0, -1):
        numbers = [order[place] for order in orders]
        h, size = _right_root(rest, quadratics[..., numbers, :])
        rest, least = _divide_off(rest, h), np.minimum(least, size)
        factors.insert(0, h)
    return [-rest[1] * np.ones(len(orders), dtype=int), *factors], least


def _right_root(coefficients: Sequence[DualQuaternion], M: np.ndarray) -> tuple[DualQuaternion, np.ndarray]:
    """The h for which t − h divides the polynomial from the right and (t − h)(t − h̄) = M.

    The remainder modulo M is r1 t + r0, and h = −r1⁻¹ r0.  The second number is how large r1 is in this, at most 1.
    """
    _, (r1, r0) = divide_by_quadratic(coefficients, M)
    square = null_form(r1, r1)
    none = np.asarray(is_zero(square, rtol=0))
    if none.any():
        r1 = r1 + np.where(none, 1, 0)
    h = -(r1.inverse() * r0)
    if is_exact(h.components):
        return h, np.where(none, 0.0, 1.0)
    return h, np.where(none, 0.0, np.sqrt(square / (1 + square + null_form(r0, r0))))


def divide_by_quadratic(
    coefficients: Sequence[DualQuaternion], M: np.ndarray
) -> tuple[list[DualQuaternion], list[DualQuaternion]]:
    """Quotient and remainder (two coefficients) of a polynomial divided by t² + bt + c, M = (1, b, c)."""
    rest, b, c = list(coefficients), M[..., 1], M[..., 2]
    for n in range(len(rest) - 2):
        rest[n + 1] = rest[n + 1] - rest[n] * b
        rest[n + 2] = rest[n + 2] - rest[n] * c
    return rest[:-2], rest[-2:]


def _divide_off(coefficients: Sequence[DualQuaternion], h: DualQuaternion) -> list[DualQuaternion]:
    """The quotient of a polynomial by t − h from the right, where there is no remainder."""
    quotient = [coefficients[0]]
    for c in coefficients[1:-1]:
        quotient.append(c + quotient[-1] * h)
    return quotient


def _repaired(
    C: MotionPolynomial, factors: list[DualQuaternion], missing: np.ndarray
) -> tuple[list[DualQuaternion], np.ndarray]:
    """Better factors where the product misses C by more than rounding, and by how much it still does."""
    poor = (missing > POLISH_RTOL) & (missing < 1)
    if not poor.any():
        return factors, missing
    wide = [DualQuaternion(np.broadcast_to(c.coeffs[..., None, :], (*missing.shape, 8))) for c in C.coefficients]
    part = MotionPolynomial.from_coefficients(c[poor] for c in wide)
    better = polished(part, [h[poor] for h in factors], steps=2)
    off = residual(part.coefficients, better)
    gain = off < missing[poor]
    rows = tuple(axis[gain] for axis in np.nonzero(poor))
    missing = missing.copy()
    missing[rows] = off[gain]
    return [replaced(h, rows, new[gain]) for h, new in zip(factors, better, strict=True)], missing


def exchange(factors: Sequence[DualQuaternion], n: int) -> tuple[DualQuaternion, ...]:
    """The same product with the quadratic polynomials of the neighbours n and n + 1 (counted from 0) exchanged.

    Examples
    --------
    >>> h1, h2, h3 = i, 2 * j - 2 * eps * i, 3 * k
    >>> exchange((h1, h2, h3), 0) == (*bennett_flip(h1, h2), h3)
    True
    """
    if not 0 <= index(n) < len(factors) - 1:
        raise ValueError(f"expected neighbours among {len(factors)} factors: n = 0, …, {len(factors) - 2}, got {n}")
    return (*factors[:n], *bennett_flip(factors[n], factors[n + 1]), *factors[n + 2 :])


class ExchangeFault(Fault):
    """Why two factors cannot be exchanged."""

    CONJUGATE = 1, "the two factors have conjugate primal parts: they cannot be exchanged"


def bennett_flip(h1: DualQuaternion, h2: DualQuaternion) -> tuple[DualQuaternion, DualQuaternion]:
    """The k1, k2 with (t − h1)(t − h2) = (t − k1)(t − k2) and the quadratic polynomials exchanged.

    Modulo (t − h1)(t − h̄1) the product leaves the remainder (t − h1)v with v = h̄1 − h2, so k2 = v⁻¹ h1 v.

    Raises
    ------
    DegenerateError
        If h̄1 = h2 (or differs from it by a dual part only).

    Examples
    --------
    >>> k1, k2 = bennett_flip(i, 2 * j - 2 * eps * i)
    >>> k1 + k2 == i + 2 * j - 2 * eps * i, k1 * k2 == i * (2 * j - 2 * eps * i)
    (True, True)
    """
    v = h1.conjugate() - h2
    report_faults(np.asarray(is_zero(null_form(v, v), rtol=0)) * ExchangeFault.CONJUGATE, ExchangeFault, "raise")
    k2 = v.inverse() * h1 * v
    return h1 + h2 - k2, k2
