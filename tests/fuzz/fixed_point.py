"""Dual quaternions in whole numbers: fixed point with 384 bits behind the point, some 115 digits.

A float or a fraction is a whole number times a power of two (or nearly), so it is read without loss; then products
need Python's integers only.  Arrays have dtype object and the eight components first, shape (8, ...).
Written plainly and without kinlib, since kinlib is what is judged with it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

BITS = 384
ONE = 1 << BITS


def fixed(values) -> np.ndarray:
    """Numbers of any exact or floating kind in fixed point, the same shape."""
    array = np.asarray(values)
    whole = np.empty(array.size, dtype=object)
    whole[:] = [_fixed(x) for x in array.ravel().tolist()]
    return whole.reshape(array.shape)


def _fixed(x) -> int:
    if isinstance(x, int):
        return x << BITS
    if hasattr(x, "field"):
        return _of_field(x)
    numerator, denominator = x.as_integer_ratio()
    return (numerator << BITS) // denominator


def _of_field(x) -> int:
    """An element of a number field: its rational coefficients at the root, by Horner's rule."""
    root, total = _root(x.field), 0
    for c in x.coefficients:
        total = ((total * root) >> BITS) + (c.numerator << BITS) // c.denominator
    return total


@lru_cache
def _root(field) -> int:
    import sympy

    return int(sympy.floor(field.root.evalf(150) * ONE))


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(p + εd)(r + εe) = pr + ε(pe + dr)."""
    p, d, r, e = a[:4], a[4:], b[:4], b[4:]
    pe, dr = _hamilton(p, e), _hamilton(d, r)
    rows = [x >> BITS for x in (*_hamilton(p, r), *(x + y for x, y in zip(pe, dr, strict=True)))]
    return np.array(rows, dtype=object)


def _hamilton(p, r) -> tuple:
    """The product of quaternions, before the point is moved back."""
    return (
        p[0] * r[0] - p[1] * r[1] - p[2] * r[2] - p[3] * r[3],
        p[0] * r[1] + p[1] * r[0] + p[2] * r[3] - p[3] * r[2],
        p[0] * r[2] - p[1] * r[3] + p[2] * r[0] + p[3] * r[1],
        p[0] * r[3] + p[1] * r[2] - p[2] * r[1] + p[3] * r[0],
    )


def conjugate(a: np.ndarray) -> np.ndarray:
    return a * np.array([1, -1, -1, -1] * 2, dtype=object).reshape((8,) + (1,) * (a.ndim - 1))


def loop_polynomial(factors: list[np.ndarray]) -> list[np.ndarray]:
    """The coefficients of Π (t − f), highest power first; each factor of shape (8, ...)."""
    one = np.zeros_like(factors[0])
    one[0] = ONE
    total = [one]
    for f in factors:
        tail = [-product(c, f) for c in total]
        total = [a + b for a, b in zip([*total, 0 * one], [0 * one, *tail], strict=True)]
    return total


def value(polynomial: list[np.ndarray], t) -> np.ndarray:
    """A polynomial at t in fixed point, by Horner's rule; t broadcasts against the batch."""
    total = polynomial[0]
    for c in polynomial[1:]:
        total = ((total * t) >> BITS) + c
    return total


def _square(vector) -> np.ndarray:
    return sum(x * x for x in vector)


def ratio(a, b) -> np.ndarray:
    """The float nearest to a/b for arrays of whole numbers; NaN for 0/0, ∞ for a/0."""
    return _ratio(a, b).astype(float)


def _true_ratio(a: int, b: int) -> float:
    if b == 0:
        return math.inf if a else math.nan
    try:
        return a / b
    except OverflowError:
        return math.inf


_ratio = np.frompyfunc(_true_ratio, 2, 1)


def turn_of(e: np.ndarray) -> np.ndarray:
    """The angle of the displacement e in radians, from 0 to π; floats."""
    primal = _square(e[:4])
    return 2 * np.arcsin(np.minimum(np.sqrt(ratio(_square(e[1:4]), primal)), 1))


def shift_of(e: np.ndarray, c: np.ndarray) -> np.ndarray:
    """How far the displacement e moves the point c, shape (3, ...) in fixed point; floats.

    With e = p + εd and p = p0 + u this is the length of 2 (p0 u × c + u × (u × c) + vector part of d p̄) / (p p̄).
    """
    p0, u, d0, v = e[0], e[1:4], e[4], e[5:8]
    turned = _cross(u, c)
    again = _cross(u, turned)
    crossed = _cross(u, v)  # vector part of d p̄ = p0 v − d0 u + u × v
    moved = [
        p0 * a + b + ((p0 * v[n] - d0 * u[n] + crossed[n]) << BITS)
        for n, (a, b) in enumerate(zip(turned, again, strict=True))
    ]
    # turned holds two factors of 2^BITS, so p0 turned and again hold three, as do the shifted terms
    primal = _square(e[:4]) << BITS
    return 2 * np.linalg.norm([ratio(x, primal) for x in moved], axis=0)


def _cross(a, b) -> list:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
