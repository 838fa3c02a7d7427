"""What a linkage needs and offers: lengths of its bars, room, angles of its axes, travel of its joints, clearance."""

from __future__ import annotations

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import null_form
from kinlib.linkage import Linkage
from kinlib.moving_bars import MovingBars, pairs_without_joint
from kinlib.rows import broadcast
from kinlib.scalar import as_float
from kinlib.typing import Array

__all__ = ["bar_lengths", "clearance_at_most", "folds", "moving_bars", "room_about", "smallest_angle", "travel"]

POSITIONS = 32
"""At how many positions of one turn the room is measured."""

LOOKS, STRIDE = 12, 5
"""At how many positions bars are looked at before their clearance is searched for, and in which order."""

ON_IT = 1e-9
"""How near bars are at a joint without an offset, in units of their lengths."""


def bar_lengths(linkage: Linkage) -> Array:
    """The lengths of all bars, link 0 first; shape (..., n).

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> bar_lengths(bennett_linkage(*gallery.THREE_POSES)).round(9).tolist()
    [1.666666667, 1.0, 1.666666667, 1.0]
    """
    ends = linkage.bars()
    return np.asarray(np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1))


def smallest_angle(linkage: Linkage) -> Array:
    """The smallest angle of neighbouring axes, from 0 to π/2; shape (...)."""
    directions = linkage.chain.lines.directions
    following = np.roll(directions, -1, axis=-2)
    sine = np.linalg.norm(np.cross(directions, following), axis=-1)
    cosine = np.abs((directions * following).sum(axis=-1))
    return np.asarray(np.arctan2(sine, cosine).min(axis=-1))


def room_about(linkage: Linkage, centre: Array) -> Array:
    """The radius about a point of space that holds all bars in 32 positions of one turn; shape (...)."""
    way = np.pi * (np.arange(POSITIONS) + 0.5) / POSITIONS
    real = np.stack(np.broadcast_arrays(*(as_float(f.scalar_part) for f in linkage.factors)))
    spread = np.sqrt(np.max([as_float(null_form(f, f)) for f in linkage.factors], axis=0))
    t = real.mean(axis=0) + spread * (1 / np.tan(way)).reshape(-1, *[1] * len(linkage.shape))
    ends = as_float(act(linkage.link_displacements(t)[..., None], linkage.bars()))
    return np.asarray(np.linalg.norm(ends - centre, axis=-1).max(axis=(0, -2, -1)))


def travel(linkage: Linkage) -> Array:
    """The largest angle that a joint is moved on the best way through all poses; radians, shape (...).

    A linkage meets its poses once in each round; the best way leaves out one of the gaps between them.
    """
    t = np.stack(np.broadcast_arrays(*(as_float(x) for x in linkage.parameters)))
    t = np.broadcast_to(t.reshape(len(t), *[1] * (1 + len(linkage.shape) - t.ndim), *t.shape[1:]),
                        (len(t), *linkage.shape))  # fmt: skip
    t = -np.sort(-np.where(np.isinf(t), np.inf, t), axis=0)
    angles = linkage.joint_angles(t)
    full = linkage.joint_angles(np.full(linkage.shape, -np.inf))
    ways = []
    for n in range(len(t)):
        stops = np.concatenate([angles[n:], angles[:n] + full])
        low, high = stops.min(axis=0), stops.max(axis=0)
        for joint, count in enumerate(linkage.joints):
            if count > 1:
                turned = _turned_back(linkage, joint, t, n, full[..., joint])
                low[..., joint] = np.fmin(low[..., joint], np.fmin.reduce(turned))
                high[..., joint] = np.fmax(high[..., joint], np.fmax.reduce(turned))
        ways.append((high - low).max(axis=-1))
    return np.asarray(np.min(ways, axis=0))


def _turned_back(linkage: Linkage, joint: int, t: Array, first: int, full: Array) -> Array:
    """The angles at which a joint turns back on the way that begins at the stop number first; NaN elsewhere."""
    places = np.moveaxis(as_float(linkage.dead_points(joint)), -1, 0)
    angles = linkage.joint_angles(np.where(np.isnan(places), 0.0, places))[..., joint]
    if first == 0:
        return np.where((places <= t[0]) & (places >= t[-1]), angles, np.nan)
    later = np.where(places >= t[first - 1], angles + full, np.nan)
    return np.where(places <= t[first], angles, later)


def folds(linkage: Linkage) -> Array:
    """Where it is known that bars touch because a joint folds; shape (...).

    Three neighbouring joints have no offset, and the middle one turns all the way round: when its two bars point in the
    same direction, the shorter one ends on the longer one, where the next bar begins.
    """
    ends, lengths = linkage.bars(), bar_lengths(linkage)
    size = lengths.max(axis=-1)[..., None]
    meets = np.linalg.norm(ends[..., 1, :] - np.roll(ends, -1, axis=-3)[..., 0, :], axis=-1) <= ON_IT * size
    upright = np.abs((np.diff(ends, axis=-2)[..., 0, :] * linkage.chain.lines.directions).sum(axis=-1)) <= ON_IT * size
    following = np.diff(np.roll(ends, -1, axis=-3), axis=-2)[..., 0, :]
    upright &= np.abs((following * linkage.chain.lines.directions).sum(axis=-1)) <= ON_IT * size
    nearer, farther = lengths, np.roll(lengths, -1, axis=-1)
    touched = ((nearer >= farther) & np.roll(meets, -1, axis=-1)) | ((nearer <= farther) & np.roll(meets, 1, axis=-1))
    return np.asarray((meets & upright & touched & (np.abs(linkage.turns()) == linkage.joints)).any(axis=-1))


def moving_bars(linkage: Linkage) -> MovingBars:
    """The usual bars of a batch of shape (rows,), in motion."""
    return MovingBars.of([broadcast(f, linkage.shape) for f in linkage.factors], linkage.joints, linkage.bars())


def clearance_at_most(linkage: Linkage, least: Array | float = 0.0) -> Array:
    """A bound of the clearance from above, for a batch of shape (rows,): 0 where bars are known to touch, else the
    least distance of bars in up to 12 positions, no more of them than show that it is below ``least``."""
    least = np.broadcast_to(least, linkage.shape)
    most = np.where(np.isnan(linkage.bars()).any(axis=(-1, -2, -3)), np.nan, 0.0)
    rows = np.flatnonzero(~np.isnan(most) & (least < np.inf) & ~folds(linkage))
    most[rows] = np.inf
    moving, pairs = moving_bars(linkage[rows]), pairs_without_joint(linkage.joints)
    for number in range(LOOKS):
        open_ones = most[rows] >= least[rows]
        if np.count_nonzero(open_ones) < len(rows) / 2:
            rows, moving = rows[open_ones], moving.pick(open_ones)
        angle = np.full(len(rows), np.pi * (number * STRIDE % LOOKS + 0.5) / LOOKS)
        most[rows] = np.minimum(most[rows], np.min([moving.distance(pair, angle) for pair in pairs], axis=0))
    return most
