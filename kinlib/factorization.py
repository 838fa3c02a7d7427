"""Splitting motion polynomials into linear factors: turns about fixed axes.

The norm polynomial C C̄ of a motion polynomial of degree n is a product of n real quadratic polynomials.
Each order of them gives one factorization C = (t − h_1) ⋯ (t − h_n) with the n-th of these quadratics as
(t − h_n)(t − h̄_n) (Hegedüs, Schicho & Schröcker 2013, Theorem 1).  Splitting the real polynomial is the only
irrational step; it is done in :func:`quadratic_factors`.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from numbers import Rational

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.errors import DegenerateError
from kinlib.motion_polynomial import MotionPolynomial, check_monic, multiply
from kinlib.number_field import NumberField, NumberFieldElement, square_root
from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_zero, size

__all__ = ["bennett_flip", "factorizations", "factorize", "quadratic_factors", "quadratic_of"]

REAL_ROOT = "the polynomial has a real root: the motion passes through the exceptional space"


def quadratic_factors(polynomial) -> np.ndarray:
    """Split a real polynomial without real roots into monic quadratic polynomials.

    Parameters
    ----------
    polynomial : array_like, shape (..., 2n+1)
        Real coefficients, highest power first.  For exact numbers the factors are exact, over ℚ or over the
        number field that they need.

    Returns
    -------
    numpy.ndarray, shape (..., n, 3)
        Coefficients 1, b, c of the factors, sorted by the real part of their roots, then by the imaginary.

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
        return _split_floats(as_float(polynomial))
    rows = polynomial.reshape(-1, polynomial.shape[-1])
    factors = np.array([_split_exact(row) for row in rows], dtype=object)
    return factors.reshape(*polynomial.shape[:-1], polynomial.shape[-1] // 2, 3)


def _split_floats(polynomial: np.ndarray) -> np.ndarray:
    roots = upper_roots(polynomial)
    return np.stack([np.ones(roots.shape), -2 * roots.real, np.abs(roots) ** 2], axis=-1)


def upper_roots(polynomial: np.ndarray) -> np.ndarray:
    """The roots with positive imaginary part of real polynomials, shape (..., 2n+1), as eigenvalues; (..., n)."""
    monic = polynomial[..., 1:] / polynomial[..., :1]
    degree = monic.shape[-1]
    companion = np.zeros((*monic.shape[:-1], degree, degree))
    companion[..., 0, :] = -monic
    companion[..., np.arange(1, degree), np.arange(degree - 1)] = 1
    defined = np.isfinite(monic).all(axis=-1, keepdims=True)
    roots = np.linalg.eigvals(np.where(defined[..., None], companion, np.eye(degree)))
    upper = np.take_along_axis(roots, np.argsort(-roots.imag, axis=-1)[..., : degree // 2], -1)
    if np.any(defined & (upper.imag <= 0)):
        raise DegenerateError(REAL_ROOT)
    unit = np.abs(roots).max(axis=-1, keepdims=True)
    order = np.lexsort((upper.imag, np.round(upper.real / unit, 9)), axis=-1)
    return np.where(defined, np.take_along_axis(upper, order, -1), np.nan)


def _split_exact(row: np.ndarray) -> list[list]:
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
        raise DegenerateError(REAL_ROOT)
    return sorted(split, key=lambda quadratic: (-float(quadratic[1]), float(quadratic[2])))


def _split_symbols(row: np.ndarray) -> list[list]:
    """The factors over the rational functions of the symbols; all of them must be quadratic there."""
    from sympy import Poly, Symbol

    factors = [(f.monic().all_coeffs(), power) for f, power in Poly(list(row), Symbol("t")).factor_list()[1]]
    if any(len(coefficients) != 3 for coefficients, _ in factors):
        raise ValueError(
            "the polynomial has no quadratic factors with rational functions of the symbols as coefficients"
        )
    return [coefficients for coefficients, power in factors for _ in range(power)]


def _in_domain(c, field: NumberField | None):
    from sympy import QQ

    if isinstance(c, NumberFieldElement) and c.field == field:
        return c.value
    if not isinstance(c, Rational):
        raise ValueError(f"expected rational numbers or numbers of one field ℚ(a), got {c!r}")
    rational = QQ(int(c.numerator), int(c.denominator))
    return field.domain(rational) if field else rational


def _split_irreducible(coefficients: list, field: NumberField | None) -> list[list]:
    """Quadratic factors of an irreducible monic polynomial."""
    degree = len(coefficients) - 1
    if degree == 1:
        raise DegenerateError(REAL_ROOT)
    if degree == 2:
        return [coefficients]
    if degree == 4 and field is None:
        return _split_quartic(*coefficients[1:])
    raise ValueError(
        f"the factors of an irreducible polynomial of degree {degree} over {field or 'ℚ'} need a number field that is "
        "too large to be of use: convert the coefficients to floats"
    )


def _out_of_domain(c, field: NumberField | None):
    return NumberFieldElement(field, c) if field else Fraction(int(c.numerator), int(c.denominator))


def _split_quartic(c3, c2, c1, c0) -> list[list]:
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
        linear, constants = (0, 0), ((p - root) / 2, (p + root) / 2)
    else:
        linear, constants = (a, -a), ((p + a * a - q / a) / 2, (p + a * a + q / a) / 2)
    return [[1, 2 * s + a, s * s + a * s + b] for a, b in zip(linear, constants, strict=True)]


def _largest_real_root(coefficients: list):
    from sympy import CRootOf, Poly, Symbol

    polynomial = Poly([_in_domain(c, None) for c in coefficients], Symbol("a"), domain="QQ")
    factors = [factor for factor, _ in polynomial.factor_list()[1] if factor.count_roots()]
    largest = max((CRootOf(f, f.count_roots() - 1, radicals=False) for f in factors), key=float)
    return _out_of_domain_root(largest)


def _out_of_domain_root(root):
    if root.is_Rational:
        return _out_of_domain(root, None)
    return NumberField(root).generator


def quadratic_of(h: DualQuaternion) -> np.ndarray:
    """The real polynomial (t − h)(t − h̄) = t² − (h + h̄)t + h h̄, shape (..., 3)."""
    real = h.scalar_part
    return np.stack([real * 0 + 1, -2 * real, h.norm().scalar_part], axis=-1)


def factorizations(C: MotionPolynomial) -> list[tuple[DualQuaternion, ...]]:
    """All n! factorizations of a monic motion polynomial, one for each order of its quadratic factors.

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
    check_monic(C)
    if C.degree == 0:
        return [()]
    quadratics = quadratic_factors(C.norm_polynomial())
    orders = list(permutations(range(C.degree)))
    factors = factor_in_orders(C, quadratics, orders)
    check_factors(C, factors)
    return [tuple(h[..., n] for h in factors) for n in range(len(orders))]


def factorize(C: MotionPolynomial, order, quadratics=None) -> tuple[DualQuaternion, ...]:
    """The factorization in which the n-th factor has the quadratic polynomial number ``order[n]``.

    Parameters
    ----------
    C : MotionPolynomial
        Monic, of degree n.
    order : sequence of int
        A permutation of 0, …, n−1.
    quadratics : array, shape (..., n, 3), optional
        The factors of C C̄ in a numbering of your own; by default that of :func:`quadratic_factors`.

    Examples
    --------
    >>> from kinlib import linear_factor
    >>> h1, h2 = factorize(linear_factor(i) * linear_factor(2 * j - 2 * eps * i), (1, 0))
    >>> linear_factor(h1) * linear_factor(h2) == linear_factor(i) * linear_factor(2 * j - 2 * eps * i)
    True
    """
    check_monic(C)
    if sorted(order) != list(range(C.degree)):
        raise ValueError(f"expected a permutation of 0, …, {C.degree - 1}, got {tuple(order)}")
    quadratics = quadratic_factors(C.norm_polynomial()) if quadratics is None else quadratics
    factors = factor_in_orders(C, np.asarray(quadratics), [order])
    check_factors(C, factors)
    return tuple(h[..., 0] for h in factors)


def factor_in_orders(C: MotionPolynomial, quadratics: np.ndarray, orders) -> list[DualQuaternion]:
    """The factors h_1, …, h_n for several orders at once, each of shape (..., len(orders)), unchecked."""
    rest = [c[..., None] for c in C.coefficients]
    factors = []
    for place in range(C.degree - 1, 0, -1):
        numbers = [order[place] for order in orders]
        h = _right_root(rest, quadratics[..., numbers, :])
        rest = _divide_off(rest, h)
        factors.insert(0, h)
    return [-rest[1] * np.ones(len(orders), dtype=int), *factors]


def _right_root(coefficients, M: np.ndarray) -> DualQuaternion:
    """The h for which t − h divides the polynomial from the right and (t − h)(t − h̄) = M.

    The remainder modulo M is r1 t + r0, and h = −r1⁻¹ r0.
    """
    _, (r1, r0) = divide_by_quadratic(coefficients, M)
    try:
        return -(r1.inverse() * r0)
    except ZeroDivisionError:
        raise DegenerateError("a remainder is not invertible: the motion has a translation among its factors") from None


def divide_by_quadratic(coefficients, M: np.ndarray) -> tuple[list, list]:
    """Quotient and remainder (two coefficients) of a polynomial divided by t² + bt + c, M = (1, b, c)."""
    rest, b, c = list(coefficients), M[..., 1], M[..., 2]
    for n in range(len(rest) - 2):
        rest[n + 1] = rest[n + 1] - rest[n] * b
        rest[n + 2] = rest[n + 2] - rest[n] * c
    return rest[:-2], rest[-2:]


def _divide_off(coefficients, h: DualQuaternion) -> list[DualQuaternion]:
    """The quotient of a polynomial by t − h from the right, where there is no remainder."""
    quotient = [coefficients[0]]
    for c in coefficients[1:-1]:
        quotient.append(c + quotient[-1] * h)
    return quotient


def product_of(factors) -> list[DualQuaternion]:
    """The coefficients of (t − h_1) ⋯ (t − h_n)."""
    product = [DualQuaternion([1] + [0] * 7)]
    for h in factors:
        product = multiply(product, [DualQuaternion([1] + [0] * 7), -h])
    return product


def check_factors(C: MotionPolynomial, factors) -> None:
    """Refuse factors whose product is not C."""
    for c, d in zip(C.coefficients, product_of(factors), strict=True):
        difference = (c[..., None] - d).coeffs
        scale = max(size(c.coeffs), size(factors[-1].coeffs), 1.0)
        if not np.all(is_zero(difference, scale, rtol=1e-5)):
            raise DegenerateError("the polynomial has no factorization with its quadratic factors in this order")


def polished(C: MotionPolynomial, factors, steps: int = 3) -> list[DualQuaternion]:
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


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solutions of linear systems in floats; the shortest ones where a matrix of the batch is singular."""
    matrix, right = (np.nan_to_num(x, posinf=0, neginf=0) for x in (matrix, right))
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.linalg.pinv(matrix, rcond=1e-14) @ right


def _derivative(factors, shape: tuple[int, ...]) -> np.ndarray:
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
    try:
        k2 = v.inverse() * h1 * v
    except ZeroDivisionError:
        raise DegenerateError("the two factors have conjugate primal parts: they cannot be exchanged") from None
    return h1 + h2 - k2, k2
