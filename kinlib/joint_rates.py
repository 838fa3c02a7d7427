"""The two highest powers of t in the product of linear factors around a chain: joint rates and real parts.

See :mod:`kinlib.loop_motion`: the rates are the kernel of the matrix of the axes' Plücker coordinates, and the real
parts solve a linear system with the same matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinlib.chain import Chain
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.errors import Fault
from kinlib.polishing import product_of
from kinlib.projective import null_space
from kinlib.scalar import divide, is_exact, is_zero
from kinlib.typing import Array

__all__ = ["LoopFault", "Rates", "closes", "rates_of", "small"]

STILL = 1e-9
"""A joint that turns so much more slowly than the fastest one stands still."""

SECOND = 100.0
"""By how much more than the product of the factors the terms of second order may be off, until the product is known."""


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


def rates_of(chain: Chain, rtol: float) -> Rates:
    """How the joints start to turn, and the real parts of their factors; in floats or exact."""
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


def closes(axes: Sequence[DualQuaternion], turns: Sequence[Array], rtol: float) -> Array:
    """Where the product of all factors is real, relative to the product of their sizes."""
    factors = [
        -(h * part[..., n, 1] + part[..., n, 0])
        for h, part in zip(axes, turns, strict=True)
        for n in range(part.shape[-2])
    ]
    return small([c.components[1:] for c in product_of(factors)[1:]], factors, rtol)


def small(parts: Sequence[Array], factors: Sequence[DualQuaternion], rtol: float) -> Array:
    """Where the coefficients of a product vanish, compared with those of Π(t + |f|); shape (...)."""
    if is_exact(parts[0]):
        return np.asarray(np.all([np.all(is_zero(part), axis=0) for part in parts], axis=0))
    bound = [np.ones(factors[0].shape)]
    for f in factors:
        r = np.sqrt(null_form(f, f))
        bound = [high + low * r for high, low in zip([*bound, 0.0], [0.0, *bound], strict=True)]
    return np.logical_and.reduce([np.abs(p).max(axis=0) <= rtol * b for p, b in zip(parts, bound[1:], strict=True)])
