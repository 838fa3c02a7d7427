"""Joint angles at which a chain closes, by Newton's method from many starts at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinlib.chain import Chain
from kinlib.dual_quaternion import DualQuaternion, eps, i, k, one
from kinlib.scalar import RTOL, as_float, as_scalars
from kinlib.typing import Array, ArrayLike

__all__ = ["closed_chains", "closing_angles", "moves_on", "tables_of"]

STEPS = 60
LONGEST = 0.7
"""No joint turns further in one step, in radians."""

CLOSED = 1e-11
"""What is left of a loop that is closed, in radians and parts of its length."""


def residual_and_slope(axes: Sequence[DualQuaternion], end: DualQuaternion, angles: Array) -> tuple[Array, Array]:
    """How far Π (turn about axis n) · end is from the identity, and how this changes with the angles.

    Parameters
    ----------
    axes : sequence of n half-turns of length 1
    end : DualQuaternion
        The displacement behind the last joint.
    angles : array, shape (..., n)

    Returns
    -------
    pair of arrays, shape (..., 6) and (..., 6, n)
        Half-angles and half-lengths.
    """
    frames, columns = one.astype(float), []
    for n, h in enumerate(axes):
        columns.append(frames * h * frames.conjugate())
        frames = frames * (h * np.sin(angles[..., n] / 2) + np.cos(angles[..., n] / 2))
    last = frames * end
    sign = np.where(last.scalar_part < 0, -1.0, 1.0)
    vectors = [(q * last * 0.5).coeffs[..., PLUECKER] for q in columns]
    slope = np.stack(np.broadcast_arrays(*vectors), axis=-1)
    return last.coeffs[..., PLUECKER] * sign[..., None], slope * sign[..., None, None]


PLUECKER = [1, 2, 3, 5, 6, 7]


def closed(axes: Sequence[DualQuaternion], end: DualQuaternion, angles: Array, fixed: int) -> tuple[Array, Array]:
    """Angles that close a loop while one joint keeps its angle, and how far from closed they are.

    Gauss and Newton's method with bounded steps; a start from which it finds nothing keeps a large residual.
    """
    free = [n for n in range(len(axes)) if n != fixed]
    angles = np.array(angles, dtype=float)
    for _ in range(STEPS):
        off, slope = residual_and_slope(axes, end, angles)
        if np.abs(off).max(axis=-1).max() < CLOSED / 100:
            break
        step = -np.einsum("...ij,...j->...i", np.linalg.pinv(slope[..., free], rcond=1e-9), off)
        step *= np.minimum(1, LONGEST / np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1e-300))
        angles[..., free] += step
    off, _ = residual_and_slope(axes, end, angles)
    return angles, np.abs(off).max(axis=-1) + (np.cos(_half_turned(axes, end, angles)) < 0)


def _half_turned(axes: Sequence[DualQuaternion], end: DualQuaternion, angles: Array) -> Array:
    """0 if the end is turned by less than a half-turn, as the identity is, else π."""
    frames = one.astype(float)
    for n, h in enumerate(axes):
        frames = frames * (h * np.sin(angles[..., n] / 2) + np.cos(angles[..., n] / 2))
    return np.where(np.abs((frames * end).scalar_part) > 0.5, 0.0, np.pi)


def closing_angles(
    rows: Sequence[tuple[Any, Any, Any]], angle: float, joint: int = 0, *, starts: int = 96, rtol: float = CLOSED
) -> list[Array]:
    """All joint angles that are found to close the chain of a table, if one joint has a given angle.

    Parameters
    ----------
    rows : sequence of n triples (distance, twist, offset)
        Floats, of a single chain.
    angle : float
        In radians.
    joint : int
        The number of the joint, from 0.
    starts : int
        From how many starts the search begins, always the same ones.
    rtol : float
        How far the loop may be from closed, in radians and relative to the longest distance or offset.

    Returns
    -------
    list of arrays, shape (n,)
        From −π to π, first those with the smallest angles; empty if nothing is found.

    Examples
    --------
    >>> square = [(1.0, 0.0, 0.0)] * 4
    >>> [np.degrees(angles).round(6).tolist()[:3:2] for angles in closing_angles(square, math.pi / 2)]
    [[90.0, 90.0], [90.0, -90.0]]
    """
    length = max(max(abs(row[0]), abs(row[2])) for row in rows) or 1.0
    axes, end = _at_zero([(a / length, twist, d / length) for a, twist, d in rows])
    first = np.random.default_rng(0).uniform(-np.pi, np.pi, (starts, len(axes)))
    first[:, joint] = angle
    angles, off = closed(axes, end, first, joint)
    angles = np.remainder(angles[off <= max(rtol, CLOSED)] + np.pi, 2 * np.pi) - np.pi
    angles[:, joint] = angle
    return _different(angles)


def closed_chains(rows: Array, angle: float, joint: int, *, rtol: float) -> list[Chain]:
    """The chains of a table, shape (n, 3), at all positions that are found in which one joint has a given angle.

    Raises
    ------
    ValueError
        If no position is found.
    """
    triples = [tuple(row) for row in rows.tolist()]
    found = closing_angles(triples, angle, joint, rtol=rtol)
    if not found:
        raise ValueError(f"no position was found in which the loop closes and joint {joint} has the angle {angle:.6g}")
    return [Chain.from_denavit_hartenberg(triples, angles, rtol=max(10 * rtol, RTOL)) for angles in found]


def tables_of(rows: Sequence[Sequence[ArrayLike]], angle: ArrayLike) -> tuple[Array, Array]:
    """Rows and angles of a batch as arrays, shapes (..., n, 3) and (...).

    Raises
    ------
    ValueError
        If a row has not three entries, or an entry is infinite, or NaN in a single table.
    """
    try:
        entries = [
            as_float(as_scalars(entry)) for distance, twist, offset in rows for entry in (distance, twist, offset)
        ]
    except (TypeError, ValueError):
        raise ValueError(f"expected rows of three numbers: distance, twist and offset, got {rows!r}") from None
    *entries, angles = np.broadcast_arrays(*entries, as_float(as_scalars(angle)))
    table = np.stack(entries, axis=-1).reshape(*angles.shape, len(rows), 3)
    if np.isinf(table).any() or np.isinf(angles).any() or not (angles.ndim or np.isfinite([*table.flat, angles]).all()):
        raise ValueError(f"expected finite rows (distance, twist, offset) and an angle, got {rows!r} and {angle!r}")
    return table, angles


def _different(angles: Array) -> list[Array]:
    kept: list[Array] = []
    for row in angles:
        if not any(np.abs(np.exp(1j * row) - np.exp(1j * other)).max() < 1e-6 for other in kept):
            kept.append(row)
    return sorted(kept, key=lambda row: tuple(-np.cos(row).round(6)) + tuple(-np.sin(row).round(6)))


def _at_zero(rows: Sequence[tuple[float, float, float]]) -> tuple[list[DualQuaternion], DualQuaternion]:
    """The axes of the chain of a table with all angles zero, and the displacement to its end."""
    frame, axes = one.astype(float), []
    for distance, twist, offset in rows:
        axes.append(frame * k * frame.conjugate())
        frame = frame * (eps * k * (offset / 2) + 1.0) * (eps * i * (distance / 2) + 1.0)
        frame = frame * (i * math.sin(twist / 2) + math.cos(twist / 2))
    return axes, frame


ARC = (0.05, 0.02)
"""How far the fastest joint is turned to see whether a chain moves, in radians."""


def moves_on(chain: Chain, rates: Array, rows: Array) -> Array:
    """Where a chain can be closed again when its fastest joint has turned a little.

    Parameters
    ----------
    chain : Chain
    rates : array, shape (..., n)
        The joint rates, in which direction to look.
    rows : array of bool, shape (...)
        Which rows to look at.
    """
    answer = np.zeros(np.shape(rows), dtype=bool)
    lines, rates = chain.lines, as_float(rates)
    for index in map(tuple, np.argwhere(rows)):
        length = lines.length[index] if lines.length[index] > lines.noise[index] else np.inf
        moments = np.cross(lines.points[index], lines.directions[index]) / length
        coeffs = np.zeros((chain.joint_count, 8))
        coeffs[:, 1:4], coeffs[:, 5:] = lines.directions[index], moments
        rate = rates[index]
        norms = np.linalg.norm(as_float(chain.axes.coeffs[index][..., 1:4]), axis=-1)
        rate = rate * norms  # of half-turns that have another length
        fastest = int(np.abs(rate).argmax())
        first = np.array([arc * sign * rate / rate[fastest] for arc in ARC for sign in (1, -1)])
        _, off = closed([DualQuaternion(row) for row in coeffs], one.astype(float), first, fastest)
        answer[index] = bool((off <= 1e-10).any())
    return answer
