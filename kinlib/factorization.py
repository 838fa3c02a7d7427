"""Splitting motion polynomials into linear factors: turns about fixed axes.

The norm polynomial C C̄ of a motion polynomial of degree n is a product of n real quadratic polynomials.
Each order of them gives one factorization C = (t − h_1) ⋯ (t − h_n) with the n-th of these quadratics as
(t − h_n)(t − h̄_n) (Hegedüs, Schicho & Schröcker 2013, Theorem 1).  Splitting the real polynomial is the only
irrational step; it is done in :func:`quadratic_factors`.

In floats the parameter t is first moved to the middle of the roots and measured in their unit: neither matters to
the linear factors, both matter to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from itertools import pairwise, permutations
from numbers import Rational
from operator import index, mul
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form, one
from kinlib.errors import DegenerateError, Fault, first_fault, report_faults
from kinlib.motion_polynomial import Coefficient, MotionPolynomial, check_monic
from kinlib.number_field import NumberField, NumberFieldElement, square_root
from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, Degenerate

__all__ = ["bennett_flip", "exchange", "factorizations", "factorize", "quadratic_factors", "quadratic_of"]

Orders: TypeAlias = Sequence[Sequence[int]]
"""Permutations of the numbers of the quadratic factors."""

Quadratic: TypeAlias = list[Any]
"""The exact coefficients 1, b, c of a quadratic polynomial."""


class FactorFault(Fault):
    """Why a motion polynomial has no factors."""

    REAL_ROOT = 1, "the polynomial has a real root: the motion passes through the exceptional space"
    REAL_FACTOR = (
        2,
        "the primal part has a real factor (a remainder modulo a quadratic factor of the norm polynomial has no "
        "inverse): no linear factor is determined",
    )
    UNSPLIT = 3, "the polynomial has no factorization with its quadratic factors in this order"


SAME_ROOT = 1e-9
"""Real parts of roots that differ by less than this, relative to the spread of the roots, count as equal."""

PRODUCT_RTOL = 1e-9
"""How far the product of the factors may be from the polynomial, relative to the numbers that are added."""

POLISH_RTOL = 1e-12
"""From which such distance on the factors are polished."""


NO_INVERSE = 1e-3
"""How small a remainder may be before it is blamed, where there are no factors."""


def quadratic_factors(polynomial: ArrayLike) -> np.ndarray:
    """Split a real polynomial without real roots into monic quadratic polynomials.

    Parameters
    ----------
    polynomial : array_like, shape (..., 2n+1)
        Real coefficients, highest power first.  For exact numbers the factors are exact, over ℚ or over the
        number field that they need.

    Returns
    -------
    numpy.ndarray, shape (..., n, 3)
        Coefficients 1, b, c of the factors, sorted by the real part of their roots, then by the imaginary.  Real
        parts that differ by 1e-9 of the spread of the roots count as equal, so that rounding does not change the
        order.

    Raises
    ------
    DegenerateError
        If there are real roots.
    ValueError
        If the exact factors would need a number field that this function does not build (it builds those of
        irreducible quartics); convert to floats then.

    Examples
    --------
    >>> quadratic_factors([1, 0, 5, 0, 4]).astype(int).tolist()
    [[1, 0, 1], [1, 0, 4]]
    >>> quadratic_factors([1, 0, 3, 0, 1])[0].tolist()
    [1, Fraction(0, 1), 3/2 - 1/2*a]
    """
    polynomial = as_scalars(polynomial)
    if polynomial.ndim == 0 or polynomial.shape[-1] % 2 == 0:
        raise ValueError(f"expected 2n+1 coefficients of a polynomial of even degree, got shape {polynomial.shape}")
    if polynomial.dtype.kind == "c":
        raise ValueError("expected real coefficients, got complex ones")
    if np.any(is_zero(polynomial[..., 0], rtol=0)):
        raise ValueError("expected a leading coefficient other than zero")
    if polynomial.ndim == 1 and polynomial.dtype.kind == "f" and not np.all(np.isfinite(polynomial)):
        raise ValueError("expected finite coefficients, got NaN or infinity")
    if not is_exact(polynomial):
        return quadratics_with(upper_roots(as_float(polynomial)))
    rows = polynomial.reshape(-1, polynomial.shape[-1])
    factors = np.array([_split_exact(row) for row in rows], dtype=object)
    return factors.reshape(*polynomial.shape[:-1], polynomial.shape[-1] // 2, 3)


def quadratics_with(roots: np.ndarray) -> np.ndarray:
    """The monic real quadratic polynomials with these complex roots, shape (..., 3)."""
    return np.stack([np.ones(roots.shape), -2 * roots.real, roots.real**2 + roots.imag**2], axis=-1)


def upper_roots(polynomial: np.ndarray) -> np.ndarray:
    """The roots with positive imaginary part of real polynomials, shape (..., 2n+1), in order; (..., n)."""
    degree = polynomial.shape[-1] - 1
    with np.errstate(all="ignore"):
        centre = np.expand_dims(-polynomial[..., 1] / (degree * polynomial[..., 0]), -1)
        rows = shifted([polynomial[..., n] for n in range(degree + 1)], centre[..., 0])
        unit = np.expand_dims(_unit_of(rows), -1)
        moved = np.stack(rows, axis=-1) / unit ** np.arange(degree + 1)
        roots = _improved(moved, eigenvalue_roots(moved))
    report_faults((roots.imag <= 0).any(axis=-1) * FactorFault.REAL_ROOT, FactorFault, "raise")
    return centre + unit * in_order(roots)


def shifted(coefficients: Sequence[Coefficient], centre: Array) -> list[Coefficient]:
    """The coefficients of a polynomial in u = t − centre."""
    shifted = list(coefficients)
    for n in range(len(shifted) - 1, 0, -1):
        for m in range(1, n + 1):
            shifted[m] = shifted[m] + shifted[m - 1] * centre
    return shifted


def _unit_of(rows: Sequence[Array]) -> np.ndarray:
    """The geometric mean of the roots of a polynomial, as a power of two."""
    return _power_of_two((rows[-1] / rows[0]) ** (1 / (len(rows) - 1)))


def _power_of_two(mean: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(mean) & (mean > 0), np.exp2(np.round(np.log2(mean))), 1.0)


def eigenvalue_roots(polynomial: np.ndarray) -> np.ndarray:
    """As many roots as the half degree says, those with the largest imaginary parts; NaN for NaN; (..., n)."""
    monic = polynomial[..., 1:] / polynomial[..., :1]
    degree = monic.shape[-1]
    companion = np.zeros((*monic.shape[:-1], degree, degree))
    companion[..., 0, :] = -monic
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1
    defined = np.isfinite(monic).all(axis=-1, keepdims=True)
    roots = np.linalg.eigvals(companion if defined.all() else np.where(defined[..., None], companion, 0)) + 0j
    upper = np.take_along_axis(roots, np.argsort(-roots.imag, axis=-1)[..., : degree // 2], -1)
    return np.where(defined, upper, np.nan + 1j)


def _improved(polynomial: np.ndarray, roots: np.ndarray) -> np.ndarray:
    """Roots after one step of Newton's method, where it is a small one."""
    rows = [polynomial[..., n, None] for n in range(polynomial.shape[-1])]
    value, slope = rows[0] + 0 * roots, 0 * roots
    for c in rows[1:]:
        value, slope = value * roots + c, slope * roots + value
    return _stepped(roots, value / slope)


def _stepped(roots: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Roots less a correction, where that is much smaller than their distance from all other roots."""
    between = np.abs(roots[..., :, None] - roots[..., None, :])
    between[..., range(roots.shape[-1]), range(roots.shape[-1])] = np.inf
    distance = np.minimum(between.min(axis=-1), 2 * roots.imag)
    return np.where(np.abs(step) < 1e-3 * distance, roots - step, roots)


def in_order(roots: np.ndarray) -> np.ndarray:
    """Roots sorted by their real parts, then by their imaginary parts."""
    return np.take_along_axis(roots, order_of(roots.real, roots.imag), -1)


def order_of(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    """The numbers of roots by their real parts, then by their imaginary parts; nearly equal real parts are equal."""
    by_real = np.argsort(real, axis=-1)
    ascending = np.take_along_axis(real, by_real, -1)
    spread = np.maximum(ascending[..., -1:] - ascending[..., :1], np.abs(imaginary).max(axis=-1, keepdims=True))
    level = np.zeros(real.shape, dtype=int)
    np.put_along_axis(level, by_real[..., 1:], np.cumsum(np.diff(ascending) > SAME_ROOT * spread, axis=-1), -1)
    return np.lexsort((imaginary, level), axis=-1)


def _split_exact(row: np.ndarray) -> list[Quadratic]:
    if any(getattr(c, "free_symbols", None) for c in row):
        return _split_symbols(row)
    from sympy import QQ, Poly, Symbol

    field = next((c.field for c in row if isinstance(c, NumberFieldElement)), None)
    polynomial = Poly([_in_domain(c, field) for c in row], Symbol("t"), domain=field.domain if field else QQ)
    split = []
    for factor, power in polynomial.factor_list()[1]:
        coefficients = [_out_of_domain(c, field) for c in factor.monic().rep.to_list()]
        split += _split_irreducible(coefficients, field) * power
    if any(b * b - 4 * c >= 0 for _, b, c in split):
        raise DegenerateError(FactorFault.REAL_ROOT.message)
    return _sorted(split)


def _sorted(quadratics: list[Quadratic]) -> list[Quadratic]:
    """Exact quadratic polynomials in the order of their roots."""
    if not quadratics:
        return quadratics
    real = np.array([-float(b) / 2 for _, b, _ in quadratics])
    imaginary = np.array([float(4 * c - b * b) ** 0.5 / 2 for _, b, c in quadratics])
    return [quadratics[n] for n in order_of(real, imaginary)]


def _split_symbols(row: np.ndarray) -> list[Quadratic]:
    """The factors over the rational functions of the symbols; all of them must be quadratic there."""
    from sympy import Poly, Symbol

    factors = [(f.monic().all_coeffs(), power) for f, power in Poly(list(row), Symbol("t")).factor_list()[1]]
    if any(len(coefficients) != 3 for coefficients, _ in factors):
        raise ValueError(
            "the polynomial has no quadratic factors with rational functions of the symbols as coefficients"
        )
    return [coefficients for coefficients, power in factors for _ in range(power)]


def _in_domain(c: Any, field: NumberField | None) -> Any:
    from sympy import QQ

    if isinstance(c, NumberFieldElement) and c.field == field:
        return c.value
    if not isinstance(c, Rational):
        raise ValueError(f"expected rational numbers or numbers of one field ℚ(a), got {c!r}")
    rational = QQ(int(c.numerator), int(c.denominator))
    return field.domain(rational) if field else rational


def _split_irreducible(coefficients: list[Any], field: NumberField | None) -> list[Quadratic]:
    """Quadratic factors of an irreducible monic polynomial."""
    degree = len(coefficients) - 1
    if degree == 1:
        raise DegenerateError(FactorFault.REAL_ROOT.message)
    if degree == 2:
        return [coefficients]
    if degree == 4 and field is None:
        return _split_quartic(*coefficients[1:])
    raise ValueError(
        f"the factors of an irreducible polynomial of degree {degree} over {field or 'ℚ'} need a number field that is "
        "too large to be of use: convert the coefficients to floats"
    )


def _out_of_domain(c: Any, field: NumberField | None) -> NumberFieldElement | Fraction:
    return NumberFieldElement(field, c) if field else Fraction(int(c.numerator), int(c.denominator))


def _split_quartic(c3: Fraction, c2: Fraction, c1: Fraction, c0: Fraction) -> list[Quadratic]:
    """The two real factors of an irreducible quartic, over the field of its largest real sum of two roots.

    With the cubic term removed the quartic t⁴ + pt² + qt + r is (t² + at + b)(t² − at + c), where a is a root of
    a⁶ + 2pa⁴ + (p² − 4r)a² − q².  For conjugate pairs of roots a is real, and it is the largest real root.
    """
    s = divide(c3, 4)
    p = c2 - 6 * s**2
    q = c1 - 2 * c2 * s + 8 * s**3
    r = c0 - c1 * s + c2 * s**2 - 3 * s**4
    a = _largest_real_root([1, 0, 2 * p, 0, p**2 - 4 * r, 0, -(q**2)])
    if a == 0:  # then q = 0, and both pairs of roots are purely imaginary
        root = square_root(p**2 - 4 * r)
        constants = (p - root) / 2, (p + root) / 2
    else:
        constants = (p + a * a - q / a) / 2, (p + a * a + q / a) / 2
    return [[1, 2 * s + a, s * s + a * s + b] for a, b in zip((a, -a), constants, strict=True)]


def _largest_real_root(coefficients: Sequence[int | Fraction]) -> NumberFieldElement | Fraction:
    from sympy import CRootOf, Poly, Symbol

    polynomial = Poly([_in_domain(c, None) for c in coefficients], Symbol("a"), domain="QQ")
    factors = [factor for factor, _ in polynomial.factor_list()[1] if factor.count_roots()]
    largest = max((CRootOf(f, f.count_roots() - 1, radicals=False) for f in factors), key=float)
    return _out_of_domain_root(largest)


def _out_of_domain_root(root: Any) -> NumberFieldElement | Fraction:
    if root.is_Rational:
        return _out_of_domain(root, None)
    return NumberField(root).generator


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
    return [_masked(h, bad) for h in placed.outward(factors)]


def _masked(h: DualQuaternion, rows: np.ndarray) -> DualQuaternion:
    return DualQuaternion(np.where(rows[..., None, None], np.nan, h.coeffs)) if rows.any() else h


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
        unit = _power_of_two(mean)
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
        roots = _stepped(roots, (value * value).sum(axis=0) / (2 * (value * slope).sum(axis=0)))
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
    return [with_rows(h, rows, new[gain]) for h, new in zip(factors, better, strict=True)], missing


def with_rows(q: DualQuaternion, rows: tuple[Any, ...], new: DualQuaternion) -> DualQuaternion:
    """The same dual quaternions but for some rows of the batch."""
    components = q.components.copy()
    components[(slice(None), *rows)] = new.components
    return DualQuaternion.from_components(components)


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
                    matrix[..., row, :, j, :] = _two_sided(before / size, after)
            matrix = matrix.reshape(*right.shape[:-2], 8 * n, 8 * n)
            moves = DualQuaternion(solved(matrix, right.reshape(*right.shape[:-2], 8 * n, 1)).reshape(right.shape))
            factors = [h + moves[..., j] for j, h in enumerate(factors)]
    return factors


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solutions of linear systems in floats; the shortest ones where a matrix of the batch is singular."""
    matrix, right = (np.nan_to_num(x, posinf=0, neginf=0) for x in (matrix, right))
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrix, rcond=1e-14) @ right


def _derivative(factors: Sequence[DualQuaternion], shape: tuple[int, ...]) -> np.ndarray:
    """The matrix of the change of all coefficients of the product with all factors, shape (..., 8n, 8n)."""
    n = len(factors)
    matrix = np.zeros((*shape, n, 8, n, 8))
    for j in range(n):
        before, after = product_of(factors[:j]), product_of(factors[j + 1 :])
        for a, left in enumerate(before):
            for b, right in enumerate(after):
                matrix[..., a + b, :, j, :] -= _two_sided(left, right)
    return matrix.reshape(*shape, 8 * n, 8 * n)


def _two_sided(left: DualQuaternion, right: DualQuaternion) -> np.ndarray:
    """The matrix of x ↦ left · x · right, shape (..., 8, 8)."""
    images = left[..., None] * DualQuaternion(np.eye(8)) * right[..., None]
    return np.swapaxes(images.coeffs, -1, -2)


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
