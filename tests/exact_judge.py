"""Floats read as the rational numbers that they are, multiplied without rounding, by no code of kinlib."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

Numbers = list[Fraction]


def exactly(coeffs) -> Numbers:
    """Eight floats or fractions as fractions."""
    return [Fraction(float(c)) if isinstance(c, (float, np.floating)) else Fraction(c) for c in coeffs]


def quaternion_product(a: Numbers, b: Numbers) -> Numbers:
    (a0, *u), (b0, *v) = a, b
    cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    dot = sum(x * y for x, y in zip(u, v, strict=True))
    return [a0 * b0 - dot, *(a0 * y + b0 * x + z for x, y, z in zip(u, v, cross, strict=True))]


def product(a: Numbers, b: Numbers) -> Numbers:
    crossed = zip(quaternion_product(a[:4], b[4:]), quaternion_product(a[4:], b[:4]), strict=True)
    return [*quaternion_product(a[:4], b[:4]), *(x + y for x, y in crossed)]


def matrix(q: Numbers) -> tuple[list[Numbers], Numbers]:
    """The rotation matrix, column by column, and the position of the origin."""
    p, conjugate = q[:4], [q[0], -q[1], -q[2], -q[3]]
    square = sum(x * x for x in p)
    units = [[Fraction(int(m == n)) for m in range(4)] for n in (1, 2, 3)]
    columns = [[x / square for x in quaternion_product(quaternion_product(p, u), conjugate)[1:]] for u in units]
    return columns, [2 * x / square for x in quaternion_product(q[4:], conjugate)[1:]]


def difference(a: Numbers, b: Numbers, size: Fraction) -> float:
    """The largest difference of the two displacements' matrices, positions in units of the size."""
    (turn, x), (other, y) = matrix(a), matrix(b)
    turns = [
        abs(r - s) for column, wanted in zip(turn, other, strict=True) for r, s in zip(column, wanted, strict=True)
    ]
    return float(max(*turns, *(abs(r - s) / size for r, s in zip(x, y, strict=True))))


def size_of(poses: list[Numbers]) -> Fraction:
    """The largest coordinate of the step from one position to another; 1 if there is none."""
    places = [matrix(pose)[1] for pose in poses]
    return max(abs(r - s) for x in places for y in places for r, s in zip(x, y, strict=True)) or Fraction(1)


def miss(linkage, poses) -> float:
    """By how much a single linkage misses its poses, along either chain from the base to the coupler."""
    wanted = [exactly(pose.coeffs) for pose in poses]
    size, count = size_of(wanted), sum(linkage.joints[: linkage.coupler])
    factors, home = [exactly(f.coeffs) for f in linkage.factors], exactly(linkage.home.coeffs)
    back = [[q[0], -q[1], -q[2], -q[3], q[4], -q[5], -q[6], -q[7]] for q in reversed(factors[count:])]
    worst = 0.0
    for chain in (factors[:count], back):
        for t, pose in zip(linkage.parameters, wanted, strict=True):
            worst = max(worst, difference(_reached(chain, t, home), pose, size))
    return worst


def _reached(chain, t, home: Numbers) -> Numbers:
    q = home
    if not math.isinf(t):
        for f in reversed(chain):
            (t_exact, *_) = exactly([t])
            q = product([t_exact - f[0], *(-c for c in f[1:])], q)
    return q
