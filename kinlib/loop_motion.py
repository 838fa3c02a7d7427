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

import numpy as np

from kinlib.chain import Chain
from kinlib.closing import closed_chains, moves_on, tables_of
from kinlib.dual_quaternion import DualQuaternion
from kinlib.errors import DegenerateError, check_degenerate, named_rows, report_faults
from kinlib.joint_rates import LoopFault, Rates, closes, rates_of
from kinlib.rows import masked
from kinlib.scalar import as_float, divide, is_exact
from kinlib.several_turns import Found, joint_with_more
from kinlib.typing import Array, ArrayLike, Degenerate

__all__ = ["LoopFault", "motion_of_axes", "moving_chain"]


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


def moving_chain(
    rows: Sequence[Sequence[ArrayLike]], angle: ArrayLike, joint: int, *, rtol: float, degenerate: Degenerate = "raise"
) -> Chain:
    """The chain of a table where one joint has a given angle: the first one that is found from which it moves.

    Parameters
    ----------
    rows : sequence of n triples (distance, twist, offset) of numbers or arrays of shape (...)
    angle : array_like, shape (...)
    joint : int
        The number of the joint, from 0.
    rtol, degenerate
        As in :func:`motion_of_axes`.
    """
    check_degenerate(degenerate)
    table, angles = tables_of(rows, angle)
    if not 0 <= joint < table.shape[-2]:
        raise ValueError(f"expected a joint among 0, …, {table.shape[-2] - 1}, got {joint}")
    axes = np.full((*angles.shape, table.shape[-2], 8), np.nan)
    for number, index in enumerate(np.ndindex(angles.shape)):
        if not np.isfinite([*table[index].flat, angles[index]]).all():
            continue
        try:
            axes[index] = as_float(_first_that_moves(table[index], float(angles[index]), joint, rtol).axes.coeffs)
        except ValueError as error:
            if degenerate == "raise":
                kind, row = type(error), (number,) * bool(angles.ndim)
                raise kind(named_rows(row) + str(error)) from None
    return Chain(DualQuaternion(axes))


def _first_that_moves(table: Array, angle: float, joint: int, rtol: float) -> Chain:
    """The first chain of a single table, at a position that closes it, from which a motion is found."""
    chains, refused = closed_chains(table, angle, joint, rtol=rtol), []
    for chain in chains:
        try:
            motion_of_axes(chain, rtol=rtol)
        except DegenerateError as error:
            refused.append(error)
        else:
            return chain
    raise DegenerateError(f"the loop closes at this angle in {len(chains)} ways, but {refused[0]}")


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
    rates = rates_of(chain, rtol)
    turns = [np.stack([x, y], axis=-1)[..., None, :] for x, y in _columns(rates)]
    found = joint_with_more(rates, turns, _closed_by_single_turns(rates, turns, rtol), rtol)
    undefined = np.isnan(as_float(chain.axes.coeffs)).any(axis=(-1, -2))
    faults = np.where(undefined, 0, _faults(chain, rates, found))
    bad = report_faults(faults, LoopFault, degenerate) | undefined
    turns[found.joint] = found.roots
    return _in_own_parameter(chain, turns, bad)


def _columns(rates: Rates) -> list[tuple[Array, Array]]:
    """x and y, joint by joint."""
    return [(rates.x[..., n], rates.y[..., n]) for n in range(len(rates.axes))]


def _closed_by_single_turns(rates: Rates, turns: Sequence[Array], rtol: float) -> Array:
    """Where the loop closes if each joint turns once; never for an odd number of joints."""
    if len(turns) % 2:
        return np.zeros(np.shape(rates.faults), dtype=bool)
    return np.asarray(rates.faults == 0) & ~rates.still.any(axis=-1) & closes(rates.axes, turns, rtol)


def _faults(chain: Chain, rates: Rates, found: Found) -> Array:
    """Why a chain has no motion, row by row; 0 where it has."""
    faults = np.where(rates.faults > 0, rates.faults, np.where(found.other, LoopFault.OTHER_JOINT, 0))
    open_rows = ~found.closed & (faults == 0)
    faults = np.where(open_rows & found.idle, LoopFault.IDLE, faults)
    open_rows = open_rows & ~found.idle
    if not open_rows.any():
        return faults
    moves = moves_on(chain, rates.y, open_rows)
    return np.where(open_rows, np.where(moves, LoopFault.OTHER_KIND, LoopFault.SHAKY), faults)


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
