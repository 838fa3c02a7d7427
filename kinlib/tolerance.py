"""How much linkages change when the poses from which they are made are a little wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinlib.displacement import rotation, translation
from kinlib.dual_quaternion import DualQuaternion
from kinlib.goldberg import goldberg_linkages
from kinlib.line import Line
from kinlib.linkage import Linkage
from kinlib.linkage_search import Choice
from kinlib.measures import bar_lengths
from kinlib.poses import as_pose
from kinlib.typing import Array, PoseLike

__all__ = ["Spread", "spread_under_errors"]


class Spread(NamedTuple):
    """The largest changes of each linkage of a choice under errors of its poses; arrays of shape (k,).

    Attributes
    ----------
    bar, offset : array
        Of the length of a bar, and of an offset.
    twist : array
        Of a twist, in radians.
    clearance : array
        No change, but the least clearance that is left.
    lost : array
        The part of the errors with which there is no such linkage.
    """

    bar: Array
    offset: Array
    twist: Array
    clearance: Array
    lost: Array


def spread_under_errors(
    p0: PoseLike,
    p1: PoseLike,
    p2: PoseLike,
    found: Choice,
    *,
    shift: float,
    turn: float,
    samples: int = 64,
    seed: int = 0,
) -> Spread:
    """How much the linkages of a choice change when their poses are wrong by given amounts, each at the same z.

    The three poses are shifted and turned by the full amounts in random directions, the same ones for all linkages.

    Parameters
    ----------
    p0, p1, p2 : pose
        As in `search`.
    found : Choice
        The linkages that are compared.
    shift, turn : float
        How far the origin of each pose is shifted, and by which angle it is turned, in radians.
    samples : int
        How many triples of wrong poses are tried.
    seed : int
        Of the random directions.

    Raises
    ------
    ValueError
        If the amounts are negative or not finite, or nothing is to be tried.

    Examples
    --------
    >>> from kinlib import Brief, ZGrid, gallery, search
    >>> found = search(*gallery.THREE_POSES, ZGrid(-2 - 2j, 2 + 2j, (12, 12)), Brief(longest_bar=1.5), keep=2)
    >>> spread = spread_under_errors(*gallery.THREE_POSES, found, shift=1e-3, turn=1e-3, samples=16)
    >>> spread.bar.shape, bool(np.all(spread.bar < 0.02)), spread.lost.tolist()
    ((2,), True, [0.0, 0.0])
    """
    if not (0 <= shift < np.inf and 0 <= turn < np.inf):
        raise ValueError(f"expected finite amounts that are not negative, got {shift=} and {turn=}")
    if samples < 1:
        raise ValueError(f"expected at least one sample, got {samples}")
    random = np.random.default_rng(seed)
    wrong = [as_pose(pose).astype(float) * _errors(random, samples, shift, turn) for pose in (p0, p1, p2)]
    spreads = [_spread(linkage, wrong, complex(z)) for linkage, z in zip(found.linkages, found.z, strict=True)]
    return Spread(*np.reshape(spreads, (-1, 5)).T)


def _errors(random: np.random.Generator, samples: int, shift: float, turn: float) -> DualQuaternion:
    """Displacements by the full amounts, in random directions; shape (samples,)."""
    ways, axes = random.normal(size=(2, samples, 3))
    ways = shift * ways / np.linalg.norm(ways, axis=-1, keepdims=True)
    return translation(ways) * rotation(Line.through(np.zeros(3), axes), np.full(samples, turn))


def _spread(linkage: Linkage, poses: list[DualQuaternion], z: complex) -> list[float]:
    """The largest changes of one linkage, the least clearance, and how often it is lost."""
    q0, q1, q2 = poses
    wrong = goldberg_linkages(q0, q1, q2, z, degenerate="nan")
    which = _the_same(linkage, wrong)
    changes = np.full((len(which), 4), np.nan)
    for number in np.unique(which[which >= 0]):
        rows = np.flatnonzero(which == number)
        changes[rows] = _changes(linkage, wrong[number][rows])
    if np.isnan(changes).all():
        return [np.nan, np.nan, np.nan, np.nan, 1.0]
    bar, offset, twist, _ = np.nanmax(changes, axis=0)
    return [bar, offset, twist, np.nanmin(changes[:, 3]), float(np.mean(which < 0))]


def _the_same(linkage: Linkage, wrong: Sequence[Linkage]) -> Array:
    """Which of eight linkages is the given one but for the errors, row by row: that with the nearest axes; −1 if none.

    Which dyad is the first one may change with the poses.
    """
    size = np.where(np.arange(8) < 4, 1.0, 1 / float(linkage.chain.lines.length))
    apart = np.stack([(((other.axes - linkage.axes).coeffs * size) ** 2).sum(axis=(-1, -2)) for other in wrong])
    nearest = np.argmin(np.where(np.isnan(apart), np.inf, apart), axis=0)
    return np.where(np.isnan(apart).all(axis=0), -1, nearest)


def _changes(linkage: Linkage, wrong: Linkage) -> Array:
    """The largest changes of bars, offsets and twists, and the clearance, row by row."""
    bar = np.abs(bar_lengths(wrong) - bar_lengths(linkage)).max(axis=-1)
    pairs = list(zip(linkage.denavit_hartenberg(), wrong.denavit_hartenberg(), strict=True))
    offset = np.max([np.abs(b.offset - a.offset) for a, b in pairs], axis=0)
    twist = np.max([np.abs(np.angle(np.exp(1j * (b.twist - np.asarray(a.twist))))) for a, b in pairs], axis=0)
    return np.stack([bar, offset, twist, np.asarray(wrong.clearance())], axis=-1)
