"""The rational motion of a closed chain from its axes at one position, by linear systems.

The joints of the chain turn by polynomials P_i over ℂ(h_i), monic and equal to 1 at t = ∞, whose product around the
loop is real.  Let y_i h_i be the second coefficient of P_i without its real part x_i.  The highest powers of t say:

1. Σ y_i h_i = 0: the joint rates y are the kernel of the matrix J of the axes' Plücker coordinates;
2. J w = −Σ_{i<j} y_i y_j h_i h_j, in which w_i = −x_i y_i for each joint that turns once.

So all linear factors t + x_i + y_i h_i are known, up to an affine change of t.  One joint d may turn several times: it
is one for which the product Q of the factors of all others, beginning behind d, lies in ℝ(h_d)[t].  Then P_d is the
conjugate of Q without its real factors, which is a third linear system.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from kinlib.chain import Chain
from kinlib.closing import moves_on
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.errors import DegenerateError, Fault, named_rows, report_faults
from kinlib.factorization import factorizations
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import product_of
from kinlib.projective import null_space
from kinlib.rows import masked
from kinlib.scalar import as_float, divide, is_exact, is_zero
from kinlib.typing import Array, Degenerate

__all__ = ["LoopFault", "motion_of_axes"]


class LoopFault(Fault):
    """Why axes have no motion that is found here."""

    RIGID = 1, "the axes are independent: the chain is rigid"
    SINGULAR = (
        2,
        (
            "here the joints can start to turn in more than one way: the position is flat or singular, or the chain "
            "has more than one degree of freedom; give the axes at another position"
        ),
    )
    SHAKY = 3, "the chain is mobile only infinitesimally: its joints can start to turn, but not go on"
    IDLE = 4, "a joint does not turn: leave it out, the others are a linkage of fewer joints"
    OTHER_KIND = (
        5,
        (
            "the chain is mobile, but its motion is not of this kind: no product of linear factors with all joints but "
            "at most one turning once"
        ),
    )
    OTHER_JOINT = 6, "another joint turns several times than in the first rows: take these rows apart"
    INVALID = 7, "expected finite axes"


class Rates(NamedTuple):
    """What the two highest powers of t say, in the unit of length of the chain and about its middle.

    Attributes
    ----------
    axes : list of DualQuaternion
    y : array, shape (..., n)
        The joint rates.
    x : array, shape (..., n)
        The real parts, for joints that turn once.
    still : array of bool, shape (..., n)
        Which joints have no rate.
    faults : array of int, shape (...)
    """

    axes: list[DualQuaternion]
    y: Array
    x: Array
    still: Array
    faults: Array


def motion_of_axes(
    chain: Chain, *, rtol: float = 1e-7, degenerate: Degenerate = "raise"
) -> tuple[list[DualQuaternion], tuple[int, ...]]:
    """The linear factors f of a closed chain that moves with one degree of freedom, and how many each joint has.

    The first joint that turns once has the factor t − h, with h its half-turn: t is the cotangent of half its angle,
    with the sign changed.

    Parameters
    ----------
    chain : Chain
        Of four to six axes; exact ones give exact factors.
    rtol : float
        How far the product of the factors may be from a real polynomial, relative to its size.
    degenerate : {"raise", "nan"}
        What becomes of rows that do not move in this way.

    Raises
    ------
    DegenerateError
        Saying whether the chain is rigid, moves only infinitesimally, or in another way.

    Examples
    --------
    >>> from kinlib import bennett_flip
    >>> h1, h2 = i, 2 * j - 2 * eps * i
    >>> k1, k2 = bennett_flip(h1, h2)
    >>> motion_of_axes(Chain([h1, h2, -k2, -k1]))[0] == [h1, h2, -k2, -k1]
    True
    """
    if not 4 <= chain.joint_count <= 6:
        raise ValueError(f"expected four, five or six axes, got {chain.joint_count}")
    if is_exact(chain.axes.components) and chain.shape:
        return _exact_rows(chain, rtol, degenerate)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return _motion(chain, rtol, degenerate)


def _exact_rows(chain: Chain, rtol: float, degenerate: Degenerate) -> tuple[list[DualQuaternion], tuple[int, ...]]:
    """Exact batches row by row; they become floats where a row is left out."""
    rows = []
    for number, index in enumerate(np.ndindex(chain.shape)):
        try:
            rows.append(motion_of_axes(chain[index], rtol=rtol, degenerate=degenerate))
        except DegenerateError as error:
            raise DegenerateError(named_rows([number]) + str(error), rows=(number,)) from None
    kept = [joints for factors, joints in rows if not np.isnan(as_float(factors[0].coeffs)).any()]
    joints = kept[0] if kept else rows[0][1]
    wrong = [kept != [] and row != joints and row in kept for _, row in rows]
    report_faults(np.where(wrong, LoopFault.OTHER_JOINT, 0), LoopFault, degenerate)
    nan = np.full((sum(joints), 8), np.nan)
    table = [[f.coeffs for f in factors] if row == joints else nan for factors, row in rows]
    coeffs = np.moveaxis(np.reshape(np.array(table), (*chain.shape, sum(joints), 8)), -2, 0)
    return [DualQuaternion(part) for part in coeffs], joints


def _motion(chain: Chain, rtol: float, degenerate: Degenerate) -> tuple[list[DualQuaternion], tuple[int, ...]]:
    count, shape = chain.joint_count, chain.shape
    rates = _rates(chain, rtol)
    turns = [np.stack([rates.x[..., n], rates.y[..., n]], axis=-1)[..., None, :] for n in range(count)]
    open_rows = np.asarray(rates.faults == 0)
    joint, many = 0, turns[0]
    if count % 2 == 0:
        good = open_rows & ~rates.still.any(axis=-1) & _closes(rates.axes, turns, rtol)
        open_rows = open_rows & ~good
    else:
        good = np.zeros(shape, dtype=bool)
    idle = np.zeros(shape, dtype=bool)
    other = np.zeros(shape, dtype=bool)
    if open_rows.any():
        for n, roots, fine, stands in _joints_with_more(rates, turns, open_rows, rtol):
            idle |= stands
            if not fine.any():
                continue
            if not good.any():
                joint, many, good = n, roots, fine
            elif n == joint and roots.shape == many.shape:
                many, good = np.where(fine[..., None, None], roots, many), good | fine
            else:
                other |= fine
            open_rows = open_rows & ~fine
            if not open_rows.any():
                break
    faults = np.where(rates.faults > 0, rates.faults, np.where(other, LoopFault.OTHER_JOINT, 0))
    idle_rows = idle & ~good & (faults == 0)
    faults = np.where(idle_rows, LoopFault.IDLE, faults)
    unknown = ~good & (faults == 0)
    if unknown.any():
        faults = np.where(
            unknown, np.where(moves_on(chain, rates.y, unknown), LoopFault.OTHER_KIND, LoopFault.SHAKY), faults
        )
    undefined = np.isnan(as_float(chain.axes.coeffs)).any(axis=(-1, -2))
    bad = report_faults(np.where(undefined, 0, faults), LoopFault, degenerate) | undefined
    turns[joint] = many
    return _in_own_parameter(chain, turns, bad)


def _in_own_parameter(chain: Chain, turns: Sequence[Array], bad: Array) -> tuple[list[DualQuaternion], tuple[int, ...]]:
    """The factors x + y h, with t changed so that the first joint that turns once has 0 + 1 h."""
    joints = tuple(part.shape[-2] for part in turns)
    if is_exact(turns[0]) and bad:
        return [DualQuaternion(np.full(8, np.nan))] * sum(joints), joints
    first = turns[joints.index(1)]
    middle, unit = first[..., 0], -first[..., 1]  # with one more axis, for the factors of a joint
    if not is_exact(first):
        unit = np.where(np.asarray(bad)[..., None], np.nan, unit)
    factors = []
    for n, part in enumerate(turns):
        x, y = divide(middle - part[..., 0], unit), divide(-part[..., 1], unit)
        for real, imaginary in _in_order(x, y):
            factors.append(masked(chain.axes[..., n] * imaginary + real, bad))
    return factors, joints


def _in_order(x: Array, y: Array) -> list[tuple[Array, Array]]:
    """The factors x + y h of one joint, shape (..., m): by x, then by y."""
    if x.shape[-1] == 1:
        return [(x[..., 0], y[..., 0])]
    if is_exact(x):
        return sorted(zip(x, y, strict=True), key=lambda pair: (pair[0], pair[1]))
    order = np.lexsort((y, np.round(x, 9)), axis=-1)
    x, y = np.take_along_axis(x, order, axis=-1), np.take_along_axis(y, order, axis=-1)
    return [(x[..., n], y[..., n]) for n in range(x.shape[-1])]


# ---- the two highest powers --------------------------------------------------------------------------


def _rates(chain: Chain, rtol: float) -> Rates:
    axes, columns = _seen_from_the_middle(chain)
    if is_exact(columns):
        return _exact_rates(axes, columns)
    undefined = np.asarray(~np.isfinite(columns).all(axis=(-1, -2)))
    left, singular, right = np.linalg.svd(np.where(undefined[..., None, None], 0.0, columns), full_matrices=False)
    y, rank = right[..., -1, :], singular.shape[-1] - 1
    y = y / np.abs(y).max(axis=-1, keepdims=True)
    second = -_second_order(axes, y)
    part = np.einsum("...ij,...i->...j", left[..., :rank], second) / singular[..., :rank]
    w = np.einsum("...j,...jn->...n", part, right[..., :rank, :])
    off = np.abs(np.einsum("...in,...n->...i", columns, w) - second).max(axis=-1)
    still = np.abs(y) <= STILL
    x = np.where(still, 0.0, -w / np.where(still, 1.0, y))
    faults = np.select(
        [
            undefined,
            singular[..., -1] > rtol * singular[..., 0],
            singular[..., -2] <= rtol * singular[..., 0],
            off > SECOND * rtol * (1 + np.abs(w).max(axis=-1)),
        ],
        [int(f) for f in (LoopFault.INVALID, LoopFault.RIGID, LoopFault.SINGULAR, LoopFault.SHAKY)],
        0,
    )
    return Rates(axes, y, x, still, faults)


STILL = 1e-9
"""A joint that turns so much more slowly than the fastest one stands still."""

SECOND = 100.0
"""By how much more than the product of the factors the terms of second order may be off, until the product is known."""


def _seen_from_the_middle(chain: Chain) -> tuple[list[DualQuaternion], Array]:
    """The half-turns from the middle of the chain and in its unit of length, and their coordinates; exact as given."""
    count = chain.joint_count
    if is_exact(chain.axes.components):
        axes = [chain.axes[..., n] for n in range(count)]
        return axes, chain.axes.coeffs[..., [1, 2, 3, 5, 6, 7]].T
    lines = chain.lines
    length = np.where(lines.length > lines.noise, lines.length, np.inf)[..., None, None]
    moments = np.cross(lines.points, lines.directions) / length
    zero = np.zeros((*chain.shape, count, 1))
    coeffs = np.concatenate([zero, lines.directions, zero, moments], axis=-1)
    columns = np.swapaxes(np.concatenate([lines.directions, moments], axis=-1), -1, -2)
    return [DualQuaternion(coeffs[..., n, :]) for n in range(count)], columns


def _second_order(axes: Sequence[DualQuaternion], y: Array) -> Array:
    """Σ_{i<j} y_i y_j h_i h_j without its dual scalar part, which vanishes; shape (..., 6)."""
    turned = [h * y[..., n] for n, h in enumerate(axes)]
    total, before = turned[0] * turned[1], turned[0]
    for n in range(2, len(turned)):
        before = before + turned[n - 1]
        total = total + before * turned[n]
    return total.coeffs[..., [1, 2, 3, 5, 6, 7]]


def _exact_rates(axes: list[DualQuaternion], columns: Array) -> Rates:
    count = len(axes)
    none = np.zeros(count, dtype=object)
    kernel = null_space(columns)
    if len(kernel) != 1:
        fault = LoopFault.SINGULAR if len(kernel) else LoopFault.RIGID
        return Rates(axes, none, none, np.ones(count, dtype=bool), np.array(int(fault)))
    y = kernel[0]
    second = _second_order(axes, y)
    solutions = [v for v in null_space(np.concatenate([columns, second[:, None]], axis=1)) if not is_zero(v[-1])]
    still = np.array([bool(is_zero(rate)) for rate in y])
    if not solutions:
        return Rates(axes, y, none, still, np.array(int(LoopFault.SHAKY)))
    w = divide(solutions[0][:-1], solutions[0][-1])
    x = np.array([0 if s else divide(-a, b) for a, b, s in zip(w, y, still, strict=True)], dtype=object)
    return Rates(axes, y, x, still, np.array(0))


def _closes(axes: Sequence[DualQuaternion], turns: Sequence[Array], rtol: float) -> Array:
    """Where the product of all factors is real, relative to the product of their sizes."""
    factors = [
        -(h * part[..., n, 1] + part[..., n, 0])
        for h, part in zip(axes, turns, strict=True)
        for n in range(part.shape[-2])
    ]
    return _small([c.components[1:] for c in product_of(factors)[1:]], factors, rtol)


def _small(parts: Sequence[Array], factors: Sequence[DualQuaternion], rtol: float) -> Array:
    """Where the coefficients of a product vanish, compared with those of Π(t + |f|); shape (...)."""
    if is_exact(parts[0]):
        return np.asarray(np.all([np.all(is_zero(part), axis=0) for part in parts], axis=0))
    bound = [np.ones(factors[0].shape)]
    for f in factors:
        r = np.sqrt(null_form(f, f))
        bound = [high + low * r for high, low in zip([*bound, 0.0], [0.0, *bound], strict=True)]
    return np.logical_and.reduce([np.abs(p).max(axis=0) <= rtol * b for p, b in zip(parts, bound[1:], strict=True)])


# ---- the joint that turns several times ----------------------------------------------------------------


def _joints_with_more(rates: Rates, turns: Sequence[Array], rows: Array, rtol: float) -> Any:
    """For each joint: its factors if it turns 2, 3, … times and closes the loop, where it does, where it is idle."""
    count = len(rates.axes)
    for n in range(count):
        behind = [(n + 1 + m) % count for m in range(count - 1)]
        others = [-(rates.axes[m] * turns[m][..., 0, 1] + turns[m][..., 0, 0]) for m in behind]
        product = product_of(others)
        along, across = _parts(product, rates.axes[n])
        moving = ~rates.still[..., behind].any(axis=-1)
        fits = rows & moving & _small(across[1:], others, rtol)
        if not fits.any():
            continue
        real, imaginary = (np.stack(np.broadcast_arrays(*part), axis=-1) for part in along)
        stands = fits & _all_small(imaginary, real, rtol)
        yield from _with_numbers_of_turns(rates, turns, n, real, imaginary, fits & ~stands, stands, rtol)


def _parts(product: Sequence[DualQuaternion], h: DualQuaternion) -> tuple[tuple[list[Array], list[Array]], list[Array]]:
    """Coefficients as x + y h and a rest: all x, all y, and the components of the rests."""
    square = null_form(h, h)
    y = [divide(null_form(c, h), square) for c in product]
    rest = [(c - h * part).components[1:] for c, part in zip(product, y, strict=True)]
    return ([c.scalar_part for c in product], y), rest


def _all_small(part: Array, whole: Array, rtol: float) -> Array:
    if is_exact(part):
        return np.asarray(np.all(is_zero(part), axis=-1))
    return np.abs(part).max(axis=-1) <= rtol * np.abs(whole).max(axis=-1)


def _with_numbers_of_turns(
    rates: Rates, turns: Sequence[Array], n: int, real: Array, imaginary: Array, rows: Array, stands: Array, rtol: float
) -> Any:
    """Q = x + y h as c P̄ with a real polynomial c of as high a degree as there is."""
    count = len(rates.axes)
    nothing = np.zeros_like(rows)
    yield n, turns[n], nothing, stands
    for m in range(3 if count % 2 == 0 else 2, count, 2):
        if not rows.any():
            return
        roots = _roots(rates, n, m, real, imaginary)
        if roots is None:
            continue
        tried = [*turns[:n], roots, *turns[n + 1 :]]
        fine = rows & _closes(rates.axes, tried, rtol)
        rows = rows & ~fine
        yield n, roots, fine, nothing


def _roots(rates: Rates, n: int, m: int, real: Array, imaginary: Array) -> Array | None:
    """The pairs (x, y) of the factors t + x + y h of P_n, shape (..., m, 2); None if there are none."""
    matrix, right = _divisor_system(real, imaginary, m)
    if is_exact(real):
        solutions = [v for v in null_space(np.concatenate([matrix, -right[..., None]], axis=1)) if not is_zero(v[-1])]
        return _exact_roots(rates.axes[n], divide(solutions[0][:-1], solutions[0][-1]), m) if solutions else None
    finite = np.asarray(np.isfinite(matrix).all(axis=(-1, -2)) & np.isfinite(right).all(axis=-1))
    matrix = np.where(finite[..., None, None], matrix, 0.0)
    found = np.einsum("...ij,...j->...i", np.linalg.pinv(matrix, rcond=1e-13), np.where(finite[..., None], right, 0.0))
    return _float_roots(found[..., :m] - 1j * found[..., m:])


def _divisor_system(real: Array, imaginary: Array, m: int) -> tuple[Array, Array]:
    """The linear system real · B = imaginary · A for A = t^m + …, B of degree m − 1: Q = c (A + B h)."""
    degree = real.shape[-1] - 1
    rows = degree + m  # the powers t^(degree + m − 1), …, 1
    matrix = np.zeros((*real.shape[:-1], rows, 2 * m), dtype=real.dtype)
    for n in range(m):
        matrix[..., n + 1 : n + degree + 1, n] = -imaginary[..., 1:]  # A's coefficient of t^(m−1−n)
        matrix[..., n : n + degree + 1, m + n] = real
    right = np.zeros((*real.shape[:-1], rows), dtype=real.dtype)
    right[..., :degree] = imaginary[..., 1:]
    return matrix, right


def _float_roots(coefficients: Array) -> Array:
    """The factors t + x + y h of t^m + …, with h for √−1, by the eigenvalues of the companion matrix."""
    m = coefficients.shape[-1]
    if m == 2:
        half, last = coefficients[..., 0] / 2, coefficients[..., 1]
        root = np.sqrt(half * half - last)
        root = np.where((np.conj(half) * root).real < 0, -root, root)
        large = half + root
        small = np.where(large == 0, 0, last / np.where(large == 0, 1, large))
        shifts = np.stack([large, small], axis=-1)
    else:
        companion = np.zeros((*coefficients.shape, m), dtype=complex)
        companion[..., 0, :] = -coefficients
        companion[..., np.arange(1, m), np.arange(m - 1)] = 1
        shifts = -np.linalg.eigvals(companion)
    return np.stack([shifts.real, shifts.imag], axis=-1)


def _exact_roots(h: DualQuaternion, found: Array, m: int) -> Array | None:
    """The same for exact numbers, over the field that the roots need."""
    coefficients = [DualQuaternion([1] + [0] * 7), *(x - h * y for x, y in zip(found[:m], found[m:], strict=True))]
    square = null_form(h, h)
    double = coefficients[1] * Fraction(1, 2)
    if m == 2 and not np.any(as_float((double * double - coefficients[2]).components)):
        factors: Sequence[DualQuaternion] = [-double, -double]
    else:
        factors = factorizations(MotionPolynomial.from_coefficients(coefficients))[0]
    pairs = [[-f.scalar_part, -divide(null_form(f, h), square)] for f in factors]
    return np.array(pairs, dtype=object)
