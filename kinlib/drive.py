"""A loop driven by one of its joints: parameters of an angle, rates, twists, dead points, numbers of turns.

A joint about the half-turn h with the factors t − (x_k + y_k h) turns by θ with e^{iθ/2} ~ Π (t − x_k − i y_k), and so
at the rate dθ/dt = Σ 2 y_k / ((t − x_k)² + y_k²).  Turns are right-handed about the joint's axis, which h orients.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from kinlib.chain import count_or_nan
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.factorization import quadratic_of
from kinlib.loop import Loop, whole
from kinlib.number_field import square_root
from kinlib.quadric import binary_roots
from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_infinite, is_zero
from kinlib.typing import Array, ArrayLike

__all__ = [
    "dead_points",
    "exact_real_roots",
    "joint_number",
    "joint_ranges",
    "joint_rates",
    "order_of_visits",
    "parameters_of_angle",
    "turns_of",
    "twist_of",
    "weighted_twist",
]

DOUBLE = 1e-13
"""How far below zero rounding brings the discriminant of a double root, relative to its terms."""


def joint_number(loop: Loop, joint: Any) -> int:
    """The number of a joint, from 0, checked."""
    joint = whole(joint, "the joint as a whole number")
    if not 0 <= joint < loop.joint_count:
        raise ValueError(f"expected a joint among 0, …, {loop.joint_count - 1}, got {joint}")
    return joint


def _terms(loop: Loop, joint: int) -> list[tuple[Array, Array]]:
    """The x_k and y_k of a joint; exact ones as long as the length of h is a number of their field, or a root."""
    factors = loop.joint_factors(joint)
    axis = loop.axes[..., joint]
    square = null_form(axis, axis)
    length = 1 if np.all(is_zero(square - 1)) else square_root(square)
    return [(f.scalar_part, divide(null_form(f, axis), length)) for f in factors]


# ---- parameters of an angle --------------------------------------------------------------------------


def parameters_of_angle(loop: Loop, angle: ArrayLike, joint: int) -> Array:
    """All t at which a joint has turned by an angle from t = ∞, up to whole rounds; NaN where there are fewer.

    Returns
    -------
    array, shape (..., m)
        In the order of t, ∞ at the end; m is the number of factors of the joint.
    """
    joint = joint_number(loop, joint)
    given = as_scalars(angle)
    if loop.is_exact and is_exact(given):
        return _exact_parameters(given, _terms(loop, joint))
    half = as_float(given) / 2
    sine, cosine = np.sin(half), np.cos(half)
    sine = np.where(np.abs(sine) <= 4e-16 * np.maximum(1, np.abs(half)), 0.0, sine)
    return _real_roots(_angle_polynomial(sine, cosine, [(as_float(x), as_float(y)) for x, y in _terms(loop, joint)]))


def _angle_polynomial(sine: Any, cosine: Any, terms: Sequence[tuple[Any, Any]]) -> list[Any]:
    """sine · Re Π − cosine · Im Π for Π = Π (t − x_k − i y_k), highest power of t first."""
    real: list[Any] = [1]
    imaginary: list[Any] = [0]
    for x, y in terms:
        shifted = zip([*real, 0], [0, *real], [*imaginary, 0], [0, *imaginary], strict=True)
        pairs = [(a - x * b + y * d, c - x * d - y * b) for a, b, c, d in shifted]
        real, imaginary = [re for re, _ in pairs], [im for _, im in pairs]
    return [sine * re - cosine * im for re, im in zip(real, imaginary, strict=True)]


def _real_roots(coefficients: Sequence[Any]) -> Array:
    """The real roots of polynomials in floats in their order, ∞ where leading coefficients vanish, then NaN."""
    rows = np.stack(np.broadcast_arrays(*coefficients), axis=-1)
    if rows.shape[-1] == 1:
        return np.zeros((*rows.shape[:-1], 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        if rows.shape[-1] == 2:
            return np.where(rows[..., :1] == 0, np.inf, -rows[..., 1:] / rows[..., :1])
        if rows.shape[-1] == 3:
            return np.sort(_quadratic_roots(*np.moveaxis(rows, -1, 0)), axis=-1)
    found = [_companion_roots(row) for row in rows.reshape(-1, rows.shape[-1])]
    return np.reshape(found, (*rows.shape[:-1], -1))


def _quadratic_roots(a: Array, b: Array, c: Array) -> Array:
    discriminant = b * b - 4 * a * c
    nearly = np.abs(discriminant) <= DOUBLE * np.maximum(b * b, np.abs(4 * a * c))
    root = np.sqrt(np.where(nearly, 0.0, discriminant))
    q = -(b + np.where(b < 0, -root, root)) / 2
    first = np.where(a == 0, np.inf, q / a)
    second = np.where(q == 0, np.where(a == 0, np.inf, 0.0), c / q)
    return np.where(np.isnan(root)[..., None], np.nan, np.stack([first, second], axis=-1))


def _companion_roots(row: Array) -> Array:
    count = len(row) - 1
    if not np.isfinite(row).all():
        return np.full(count, np.nan)
    trimmed = np.trim_zeros(row, "f")
    roots = np.roots(trimmed)
    real = np.sort(roots.real[np.abs(roots.imag) <= 1e-8 * (1 + np.abs(roots))])
    infinite = len(row) - len(trimmed) if len(trimmed) else 0
    return np.concatenate([real, np.full(infinite, np.inf), np.full(count - len(real) - infinite, np.nan)])


def _exact_parameters(angle: Array, terms: Sequence[tuple[Any, Any]]) -> Array:
    import sympy

    sines, cosines = np.empty(angle.shape, dtype=object), np.empty(angle.shape, dtype=object)
    for index, value in np.ndenumerate(angle):
        half = sympy.sympify(value) / 2
        ends = sympy.sin(half) == 0
        sines[index], cosines[index] = (0, 1) if ends else as_scalars([1, sympy.cot(half)])
    return exact_real_roots(_angle_polynomial(sines[()], cosines[()], terms))


def exact_real_roots(coefficients: Sequence[Any]) -> Array:
    """The real roots of exact polynomials of degree 1 or 2, as in floats; ∞ and NaN are floats among them."""
    columns = np.broadcast_arrays(*(np.asarray(c, dtype=object) for c in coefficients))
    count = len(columns) - 1
    if count > 2:
        raise ValueError(f"expected a polynomial of degree 1 or 2 for exact numbers, got {count}: use .astype(float)")
    roots = np.empty((*columns[0].shape, count), dtype=object)
    for index in np.ndindex(columns[0].shape):
        row = [as_scalars(column[index])[()] for column in columns]
        roots[index] = _exact_roots(row)
    return as_scalars(roots) if is_exact(roots) or count == 0 else roots


def _exact_roots(row: Sequence[Any]) -> list[Any]:
    if len(row) == 1:
        return []
    if len(row) == 2:
        return [math.inf if is_zero(row[0]) else divide(-row[1], row[0])]
    try:
        pairs = binary_roots(row[0], divide(row[1], 2), row[2])
    except ValueError as error:
        if "complex" not in str(error):
            raise
        return [math.nan, math.nan]
    roots = [math.inf if is_zero(t) else divide(s, t) for s, t in pairs]
    return sorted(roots, key=float)


# ---- rates -------------------------------------------------------------------------------------------


def joint_rates(loop: Loop, t: ArrayLike, joint: int | None) -> Array:
    """How fast all joints turn at t: per radian of one of them, or per unit of t; shape (..., n)."""
    each, weight = _axis_rates(loop, t)
    columns = [rate * length for rate, length in zip(each, _lengths(loop), strict=True)]
    rates = np.stack(np.broadcast_arrays(*columns), axis=-1)
    if joint is None:
        return np.asarray(divide(rates, weight[..., None]))
    return _per(rates, rates[..., joint_number(loop, joint), None])


def twist_of(loop: Loop, t: ArrayLike, link: int, joint: int | None) -> Array:
    """The twist of a link against link 0 at t, per radian of a joint or per unit of t; shape (..., 6)."""
    coordinates, weight, rates = weighted_twist(loop, t, link)
    if joint is None:
        return np.asarray(divide(coordinates, weight[..., None]))
    joint = joint_number(loop, joint)
    return _per(coordinates, np.asarray(rates[joint] * _lengths(loop)[joint])[..., None])


def weighted_twist(loop: Loop, t: ArrayLike, link: int) -> tuple[Array, Array, list[Any]]:
    """The twist of a link per unit of t times a weight, the weight, and all rates in the same way.

    For floats the weight is 1 + t², so that nothing is lost at infinity.
    """
    link = whole(link, "the link as a whole number")
    if not 0 <= link < loop.joint_count:
        raise ValueError(f"expected a link among 0, …, {loop.joint_count - 1}, got {link}")
    rates, weight = _axis_rates(loop, t)
    links = loop.link_displacements(t)
    twist = links[..., 0] * 0
    for n in range(link):
        frame = links[..., n]
        axis = frame * loop.axes[..., n] * frame.conjugate() * divide(1, null_form(frame, frame))
        twist = twist + axis * rates[n]
    return twist.coeffs[..., [1, 2, 3, 5, 6, 7]], weight, rates


def _per(values: Array, rate: Array) -> Array:
    """Values for a rate of 1; at a dead point of that joint infinite, or NaN."""
    if is_exact(rate) and not np.any(is_zero(rate)):
        return divide(values, rate)
    with np.errstate(divide="ignore", invalid="ignore"):
        return as_float(values) / as_float(rate)


def _lengths(loop: Loop) -> list[Any]:
    """The lengths of the half-turns of all joints; 1 but for exact ones whose length is no number of their field."""
    squares = [null_form(axis, axis) for axis in (loop.axes[..., n] for n in range(loop.joint_count))]
    return [1 if np.all(is_zero(square - 1)) else square_root(square) for square in squares]


def _axis_rates(loop: Loop, t: ArrayLike) -> tuple[list[Any], Array]:
    """How fast the joints turn with t, in units of their half-turns, times a weight that makes them finite at t = ∞.

    For exact t the weight is 1, and ∞ at infinity; for floats it is 1 + t².
    """
    t = as_scalars(t)[()]
    at_infinity = t.ndim == 0 and is_infinite(t[()]) if isinstance(t, np.ndarray) else is_infinite(t)
    exact = loop.is_exact and (at_infinity or is_exact(np.asarray(t)))
    weight = np.asarray(np.inf if at_infinity else 1) if exact else _scale(as_float(t)) ** 2
    rates = []
    for n in range(loop.joint_count):
        axis = loop.axes[..., n]
        terms = [
            _exact_rate(f, axis, None if at_infinity else t) if exact else _float_rate(f, axis, as_float(t))
            for f in loop.joint_factors(n)
        ]
        rates.append(reduce(operator.add, terms))
    return rates, weight


def _scale(t: Array) -> Array:
    return np.where(np.isinf(t), np.inf, np.sqrt(1 + np.minimum(np.abs(t), 1e150) ** 2))


def _exact_rate(f: DualQuaternion, axis: DualQuaternion, t: Any) -> Any:
    top = divide(2 * null_form(f, axis), null_form(axis, axis))
    if t is None:
        return top
    v = f - f.scalar_part
    return divide(top, (t - f.scalar_part) * (t - f.scalar_part) + null_form(v, v))


def _float_rate(f: DualQuaternion, axis: DualQuaternion, t: Array) -> Any:
    f, axis = f.astype(float), axis.astype(float)
    scale, v = _scale(t), f - f.scalar_part
    with np.errstate(invalid="ignore"):
        far = np.where(np.isinf(t), 1.0, (t - f.scalar_part) / scale)
    return 2 * null_form(f, axis) / null_form(axis, axis) / (far**2 + null_form(v, v) / scale**2)


# ---- the whole motion --------------------------------------------------------------------------------


def dead_points(loop: Loop, joint: int) -> Array:
    """Where a joint turns back, so that it can not drive the loop: all such t, ∞ included; shape (..., 2m − 2).

    They are the roots of Σ y_k Π M_l over the other l, with M_l = (t − x_l)² + y_l²; NaN where there are fewer.
    """
    joint = joint_number(loop, joint)
    axis, factors = loop.axes[..., joint], loop.joint_factors(joint)
    total: list[Any] = [0] * (2 * len(factors) - 1)
    for n, f in enumerate(factors):
        others = [quadratic_of(g) for m, g in enumerate(factors) if m != n]
        product = reduce(_times, ([M[..., p] for p in range(3)] for M in others), [null_form(f, axis)])
        total = [a + b for a, b in zip(total, product, strict=True)]
    if loop.is_exact:
        return exact_real_roots(total)
    return _real_roots([np.where(_cancelled(total[0], factors, axis), 0.0, total[0]), *total[1:]])


def _cancelled(leading: Array, factors: Sequence[DualQuaternion], axis: DualQuaternion) -> Any:
    """Where the y_k of a joint add up to 0 but for rounding."""
    return np.abs(leading) <= DOUBLE * reduce(operator.add, [np.abs(null_form(f, axis)) for f in factors])


def _times(first: Sequence[Any], second: Sequence[Any]) -> list[Any]:
    """The product of two polynomials."""
    product: list[Any] = [0] * (len(first) + len(second) - 1)
    for n, a in enumerate(first):
        for m, b in enumerate(second):
            product[n + m] = product[n + m] + a * b
    return product


def turns_of(loop: Loop) -> Array:
    """How often each joint turns round while t runs from −∞ to ∞; shape (..., n)."""
    turns = []
    for n in range(loop.joint_count):
        axis = loop.axes[..., n]
        signs = [np.sign(as_float(null_form(f, axis))) for f in loop.joint_factors(n)]
        turns.append(reduce(operator.add, signs))
    return count_or_nan(np.stack(np.broadcast_arrays(*turns), axis=-1))


def joint_ranges(loop: Loop) -> Array:
    """The least and the greatest angle of each joint while t runs from ∞ to −∞; radians, shape (..., n, 2)."""
    ranges = []
    for n in range(loop.joint_count):
        turning = as_float(dead_points(loop, n))
        t = np.concatenate([np.full((*loop.shape, 1), np.inf), np.full((*loop.shape, 1), -np.inf), turning], axis=-1)
        angles = loop.angles(np.moveaxis(t, -1, 0))[..., n]
        with np.errstate(invalid="ignore"):
            ranges.append(np.stack([np.fmin.reduce(angles), np.fmax.reduce(angles)], axis=-1))
    return np.stack(ranges, axis=-2)


def order_of_visits(parameters: Sequence[Any]) -> Array:
    """In which order parameter values are passed while t grows, from the first one on; shape (..., m)."""
    t = np.stack(np.broadcast_arrays(*(as_float(as_scalars(t)) for t in parameters)), axis=-1)
    order = np.argsort(np.where(np.isinf(t), np.inf, t), axis=-1, kind="stable")
    first = np.argmax(order == 0, axis=-1)[..., None]
    return np.take_along_axis(order, (np.arange(t.shape[-1]) + first) % t.shape[-1], axis=-1)
