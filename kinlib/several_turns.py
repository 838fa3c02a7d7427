"""The joint of a chain that turns several times: its polynomial is what closes the product of all other factors.

Let Q be the product of the factors of all joints but one, beginning behind it.  The chain closes with a polynomial P
over ℂ(h) for that joint, h its half-turn, exactly if Q lies in ℝ(h)[t]; then P is the conjugate of Q without its real
factors, which is a linear system.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.factorization import factorizations
from kinlib.joint_rates import Rates, closes, small
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import product_of
from kinlib.projective import null_space
from kinlib.scalar import as_float, divide, is_exact, is_zero
from kinlib.typing import Array

__all__ = ["Found", "joint_with_more"]


class Found(NamedTuple):
    """A joint of a batch of chains that turns several times.

    Attributes
    ----------
    joint : int
        Its number; the first that was found in any row.
    roots : array, shape (..., m, 2)
        The pairs x, y of its factors t + x + y h, where it closes the loop.
    closed : array of bool, shape (...)
        Where the loop is closed.
    idle, other : array of bool, shape (...)
        Where a joint does not turn at all, and where another joint than this one turns several times.
    """

    joint: int
    roots: Array
    closed: Array
    idle: Array
    other: Array


def joint_with_more(rates: Rates, turns: Sequence[Array], closed: Array, rtol: float) -> Found:
    """The joint that turns several times, in the rows that are not closed yet.

    Parameters
    ----------
    rates : Rates
    turns : sequence of arrays, shape (..., 1, 2)
        The pairs x, y of all joints as if each turned once.
    closed : array of bool, shape (...)
        Where the loop is closed with these.
    rtol : float
        How far the product of the factors may be from a real polynomial, relative to its size.
    """
    found = Found(0, turns[0], closed, np.zeros_like(closed), np.zeros_like(closed))
    rows = np.asarray(rates.faults == 0) & ~closed
    if not rows.any():
        return found
    for n, roots, fine, stands in _joints_with_more(rates, turns, rows, rtol):
        found = _with(found._replace(idle=found.idle | stands), n, roots, fine)
        rows = rows & ~fine
        if not rows.any():
            break
    return found


def _with(found: Found, joint: int, roots: Array, fine: Array) -> Found:
    """What was found before, and rows that another number of turns or another joint closes."""
    if not fine.any():
        return found
    if not found.closed.any():
        return found._replace(joint=joint, roots=roots, closed=fine)
    if joint == found.joint and roots.shape == found.roots.shape:
        roots = np.where(fine[..., None, None], roots, found.roots)
        return found._replace(roots=roots, closed=found.closed | fine)
    return found._replace(other=found.other | fine)


def _joints_with_more(
    rates: Rates, turns: Sequence[Array], rows: Array, rtol: float
) -> Iterator[tuple[int, Array, Array, Array]]:
    """For each joint: its factors if it turns 2, 3, … times and closes the loop, where it does, where it is idle."""
    count = len(rates.axes)
    for n in range(count):
        behind = [(n + 1 + m) % count for m in range(count - 1)]
        others = [-(rates.axes[m] * turns[m][..., 0, 1] + turns[m][..., 0, 0]) for m in behind]
        product = product_of(others)
        along, across = _parts(product, rates.axes[n])
        moving = ~rates.still[..., behind].any(axis=-1)
        fits = rows & moving & small(across[1:], others, rtol)
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
) -> Iterator[tuple[int, Array, Array, Array]]:
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
        fine = rows & closes(rates.axes, tried, rtol)
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
