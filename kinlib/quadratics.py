"""Splitting real polynomials into quadratic ones: the one irrational step of the theory.

Floats are split by the eigenvalues of companion matrices, exact numbers over the number field that their factors need.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from numbers import Rational
from typing import Any, TypeAlias

import numpy as np

from kinlib.errors import DegenerateError, Fault, report_faults
from kinlib.motion_polynomial import Coefficient
from kinlib.number_field import NumberField, NumberFieldElement, square_root
from kinlib.poses import power_of_two
from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_zero
from kinlib.typing import Array, ArrayLike

__all__ = ["quadratic_factors"]

Quadratic: TypeAlias = list[Any]
"""The exact coefficients 1, b, c of a quadratic polynomial."""

SAME_ROOT = 1e-9
"""Real parts of roots that differ by less than this, relative to the spread of the roots, count as equal."""


class RootFault(Fault):
    """Why a real polynomial is no product of quadratic ones without real roots."""

    REAL = 1, "the polynomial has a real root: the motion passes through the exceptional space"


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
    report_faults((roots.imag <= 0).any(axis=-1) * RootFault.REAL, RootFault, "raise")
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
    return power_of_two((rows[-1] / rows[0]) ** (1 / (len(rows) - 1)))


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
    return stepped(roots, value / slope)


def stepped(roots: np.ndarray, step: np.ndarray) -> np.ndarray:
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
        raise DegenerateError(RootFault.REAL.message)
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
        raise DegenerateError(RootFault.REAL.message)
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
