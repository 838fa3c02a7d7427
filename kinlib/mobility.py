"""The degree of freedom of the motion of a loop: the rank of its axes at general parameters."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from kinlib.chain import Chain, count_or_nan, plain
from kinlib.loop import Loop
from kinlib.scalar import RTOL
from kinlib.typing import Array

__all__ = ["general_mobility"]

SAMPLES = (0.37, -1.71, 3.3, -0.59, 0.11)
"""Where the mobility of a motion is looked at, from the middle of its parameters and in units of their spread."""


def general_mobility(loop: Loop, *, rtol: float = RTOL) -> Any:
    """The least number of joints less the rank of the axes' Plücker coordinates, over general t."""
    bound = min(6, loop.joint_count - 1)  # the joints do turn, so their axes are dependent
    if loop.is_exact:
        rows = [_exact_rank(row, bound, rtol) for row in loop.rows()]
        return plain(loop.joint_count - np.reshape(rows, loop.shape))
    return plain(count_or_nan(loop.joint_count - _general_rank(loop, bound, rtol)))


def _general_rank(loop: Loop, bound: int, rtol: float) -> Array:
    """The largest rank of the axes' Plücker coordinates over some general t, at most the bound."""
    rank = np.full(loop.shape, -1)
    for t in _samples(loop):
        rank = np.fmin(
            np.maximum(rank, Chain.wrap(loop.configuration(t)).rank(rtol)), bound
        )  # NaN stays where the axes are NaN
        rank = np.where(np.isnan(loop.chain.lines.length), np.nan, rank)
        if np.all((rank == bound) | np.isnan(rank)):
            break
    return rank


def _samples(loop: Loop) -> list[Array]:
    """General values of t, neither bunched together nor far from where the motion turns."""
    return [loop.centred.middle + loop.centred.spread * x for x in SAMPLES]


def _exact_rank(loop: Loop, bound: int, rtol: float) -> int:
    """The rank of the axes of a single exact loop at general t.

    No rank is above the bound, so floats that reach it decide; else the ranks at some fractions do.
    """
    try:
        floats = loop.astype(float)
        if _general_rank(floats, bound, rtol) == bound:
            return bound
        samples = [Fraction(float(t)).limit_denominator(10**3) for t in _samples(floats)[:3]]
    except TypeError:  # there are symbols
        samples = [Fraction(37, 100)]
    return max(loop.exact_rank(t) for t in samples)
