"""A second judge, slow and plain: joints as 4×4 matrices in mpmath, against which the first one is tested."""

from __future__ import annotations

import mpmath as mp


def turn_about(axis, angle) -> mp.matrix:
    """The matrix of a turn about a line (direction, moment), of any scale, by Rodrigues' formula."""
    l, m = axis
    norm = mp.sqrt(sum(x * x for x in l))
    n = [x / norm for x in l]
    foot = [x / norm**2 for x in _cross(l, m)]
    K = mp.matrix([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    R = mp.eye(3) + mp.sin(angle) * K + (1 - mp.cos(angle)) * K * K
    shift = mp.matrix(foot) - R * mp.matrix(foot)
    return _homogeneous(R, shift)


def matrix_of_pose(q) -> mp.matrix:
    """The matrix of the displacement x ↦ (p x p̄ + d p̄ − p d̄) / (p p̄), entry by entry."""
    p0, p1, p2, p3, d0, d1, d2, d3 = map(mp.mpf, map(float, q))
    s = p0**2 + p1**2 + p2**2 + p3**2
    R = mp.matrix([
        [p0**2 + p1**2 - p2**2 - p3**2, 2 * (p1 * p2 - p0 * p3), 2 * (p1 * p3 + p0 * p2)],
        [2 * (p1 * p2 + p0 * p3), p0**2 - p1**2 + p2**2 - p3**2, 2 * (p2 * p3 - p0 * p1)],
        [2 * (p1 * p3 - p0 * p2), 2 * (p2 * p3 + p0 * p1), p0**2 - p1**2 - p2**2 + p3**2],
    ]) / s  # fmt: skip
    shift = [
        2 * (-d0 * p1 + d1 * p0 - d2 * p3 + d3 * p2) / s,
        2 * (-d0 * p2 + d1 * p3 + d2 * p0 - d3 * p1) / s,
        2 * (-d0 * p3 - d1 * p2 + d2 * p1 + d3 * p0) / s,
    ]
    return _homogeneous(R, shift)


def carried(factors, t) -> mp.matrix:
    """Where factors t − f carry the link behind them: turns by −2 arccot((t − s)/|l|) about the axes of f = s + h."""
    total = mp.eye(4)
    for f in factors:
        f = [mp.mpf(float(x)) for x in f]
        norm = mp.sqrt(sum(x * x for x in f[1:4]))
        angle = 0 if mp.isinf(t) else -2 * mp.atan2(norm, mp.mpf(t) - f[0])
        total = total * turn_about((f[1:4], f[5:8]), angle)
    return total


def shift_between(A: mp.matrix, B: mp.matrix, point) -> float:
    """How far the displacement A B⁻¹ moves a point."""
    x = mp.matrix([*map(mp.mpf, map(float, point)), 1])
    return float(mp.norm((A * mp.inverse(B) * x - x)[:3]))


def _homogeneous(R, shift) -> mp.matrix:
    total = mp.eye(4)
    for row in range(3):
        for column in range(3):
            total[row, column] = R[row, column]
        total[row, 3] = shift[row]
    return total


def _cross(a, b) -> list:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
