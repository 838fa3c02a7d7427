"""The circle of all parameters of a loop: t = middle − spread · cot(φ/2), so that φ grows with t and t = ∞ is φ = 0."""

from __future__ import annotations

import numpy as np

from kinlib.loop import Loop
from kinlib.scalar import as_float, as_scalars
from kinlib.typing import Array, ArrayLike

__all__ = ["phases_of", "t_at", "weight_of_phase"]


TINY = 1e-60
"""Phases below this are those of t = ∞: powers of greater t could overflow."""


def t_at(loop: Loop, phase: ArrayLike) -> Array:
    """The parameters at phases φ in radians, shape (...) of the batch or broadcasting against it."""
    turned: Array = np.remainder(as_float(phase), 2 * np.pi)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        t = loop.centred.middle - loop.centred.spread / np.tan(turned / 2)
    infinite = (turned < TINY) | (turned == 2 * np.pi)
    return np.where(infinite, np.where(np.isnan(loop.centred.spread), np.nan, np.inf), t + 0.0)


def phases_of(loop: Loop, t: ArrayLike) -> Array:
    """The phases φ from 0 on, below 2π, of parameters t."""
    t = as_float(as_scalars(t))
    with np.errstate(invalid="ignore"):
        phase = 2 * np.arctan2(loop.centred.spread, loop.centred.middle - t)
    return np.where(np.isinf(t), np.where(np.isnan(phase), np.nan, 0.0), phase)


def weight_of_phase(loop: Loop, phase: Array) -> Array:
    """dt/dφ / (1 + t²), which is smooth all round."""
    sine, cosine = np.sin(phase / 2), np.cos(phase / 2)
    middle, spread = loop.centred.middle, loop.centred.spread
    return np.asarray(spread / (2 * (sine**2 + (middle * sine - spread * cosine) ** 2)))
