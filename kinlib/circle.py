"""The circle of parameters t = middle + spread · cot φ: where polynomials on it vanish, where a function dips.

A polynomial of degree n in t, times sinⁿ φ, is a trigonometric one of the angle φ from 0 to π, and t = ∞ is φ = 0, an
angle like all others.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from kinlib.typing import Array

__all__ = ["middle_of_turns", "narrowed", "roots_of", "samples", "turned_charts"]


def middle_of_turns(x: Array, y: Array) -> tuple[Array, Array]:
    """The middle and the spread of parameters in which the factors t − (x + y h) turn as evenly as can be.

    They belong to the sum of the quadratic polynomials ((t − x)² + y²) / |y|: whichever rational parameter the motion
    has, φ is the same but for its beginning.

    Parameters
    ----------
    x, y : array, shape (factors, ...)

    Examples
    --------
    >>> x, y = np.array([0.0, 1000.0]), np.array([1.0, 1.0])
    >>> [round(float(value), 3) for value in middle_of_turns(x, y)]
    [500.0, 500.001]
    """
    weight = 1 / np.abs(y)
    middle = (x * weight).sum(axis=0) / weight.sum(axis=0)
    return middle, np.sqrt((((x - middle) ** 2 + y**2) * weight).sum(axis=0) / weight.sum(axis=0))


def samples(degree: int) -> Array:
    """Angles at which the values of a trigonometric polynomial say what it is."""
    return np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)


@lru_cache
def turned_charts(degree: int) -> Array:
    """Matrices from values at the samples to coefficients in τ = cot(φ − φ_j), for angles φ_j = πj/(2 degree + 2).

    Some φ_j is far from all roots, so that none is far away in its τ.
    """
    start = np.pi * np.arange(2 * degree + 2) / (2 * degree + 2)
    away = samples(degree) - start[:, None]
    powers = np.arange(degree + 1)
    values = np.cos(away[..., None]) ** (degree - powers) * np.sin(away[..., None]) ** powers
    return np.linalg.inv(values)


def roots_of(polynomials: Array) -> Array:
    """All roots of real polynomials, shape (rows, degree + 1), as the eigenvalues of their companion matrices."""
    degree = polynomials.shape[-1] - 1
    companion = np.zeros((len(polynomials), degree, degree))
    companion[:, 0] = -polynomials[:, 1:] / polynomials[:, :1]
    companion[:, np.arange(1, degree), np.arange(degree - 1)] = 1
    return np.linalg.eigvals(companion) + 0j


# ---- a dip ---------------------------------------------------------------------------------------------

GOLDEN = (math.sqrt(5) - 1) / 2


def narrowed(function: Callable[[Array], Array], low: Array, high: Array, steps: int = 40) -> tuple[Array, Array]:
    """Where a function with one dip between low and high is least, and its value, by golden sections."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_a, at_b = function(a), function(b)
    for _ in range(steps):
        left = at_a < at_b
        low, high = np.where(left, low, a), np.where(left, b, high)
        new = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        value = function(new)
        a, b = np.where(left, new, b), np.where(left, a, new)
        at_a, at_b = np.where(left, value, at_b), np.where(left, at_a, value)
    return np.where(at_a < at_b, a, b), np.minimum(at_a, at_b)
