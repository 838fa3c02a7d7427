"""A linkage as rods and balls: bars with sleeves at their ends, and pins through the sleeves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kinlib.pictures.bars import Bars
from kinlib.pictures.colours import COUPLER, PIN, link_colours
from kinlib.pictures.parts import Ball, Rod

__all__ = ["JointEnd", "body_of", "coupler_parts", "holder", "joint", "link_parts", "linkage_parts", "pin"]


class JointEnd(NamedTuple):
    """Where a link ends at a joint: the foot of its bar, shape (3,), and its sleeve on the axis, shape (2, 3)."""

    foot: np.ndarray
    sleeve: np.ndarray


def body_of(link: int) -> str:
    """The name of the body that carries a link; the base stands still, and has none."""
    return f"link {link}" if link else ""


def linkage_parts(bars: Bars, unit: float) -> list[Rod | Ball]:
    """All links of a linkage at home, with a sleeve at every end and a pin in every joint.

    Parameters
    ----------
    bars : Bars
        Of the linkage.
    unit : float
        The length in which thicknesses are measured.
    """
    ends, directions = bars.ends, bars.lines[1]
    count = len(ends)
    joints = [joint(directions[n], ends[n, 1], ends[(n + 1) % count, 0], unit) for n in range(count)]
    links = [
        part
        for link, colour in enumerate(link_colours(bars.linkage))
        for part in link_parts(joints[link - 1][1], joints[link][0], colour, body_of(link), unit)
    ]
    return links + [pin(before, after, body_of(n), unit) for n, (before, after) in enumerate(joints)]


def joint(direction: np.ndarray, before: np.ndarray, after: np.ndarray, unit: float) -> tuple[JointEnd, JointEnd]:
    """The ends of the link before a joint and of the link after it.

    The joint is half-way between the feet.  Where these are close together, the bars end in the sleeves.
    """
    middle, gap = (before + after) / 2, (after - before) @ direction
    step = 0.1 * unit * (direction if gap >= 0 else -direction)
    sleeves = middle + np.array([[-1.03], [-0.03]]) * step, middle + np.array([[0.03], [1.03]]) * step
    feet = (before, after) if abs(gap) > 0.25 * unit else [sleeve.mean(axis=0) for sleeve in sleeves]
    return JointEnd(feet[0], sleeves[0]), JointEnd(feet[1], sleeves[1])


def link_parts(first: JointEnd, second: JointEnd, colour: str, body: str, unit: float) -> list[Rod | Ball]:
    """A bar from foot to foot, the sleeves, and an arm along the axis to each sleeve that is not at its foot."""
    radius = (0.03 if body else 0.042) * unit
    parts = _rod(first.foot, second.foot, colour, radius, body)
    for foot, sleeve in (first, second):
        middle = sleeve.mean(axis=0)
        parts += [Rod(sleeve[0], sleeve[1], colour, 0.065 * unit, body)]
        if np.linalg.norm(foot - middle) > radius:
            parts += [Rod(foot, middle, colour, radius, body), Ball(foot, colour, radius, body)]
    return parts


def _rod(start: np.ndarray, end: np.ndarray, colour: str, radius: float, body: str) -> list[Rod | Ball]:
    """A rod, or a ball if its ends agree."""
    return [Rod(start, end, colour, radius, body) if np.any(start != end) else Ball(start, colour, radius, body)]


def pin(before: JointEnd, after: JointEnd, body: str, unit: float) -> Rod:
    """The pin through two sleeves, a little longer than both."""
    step = 0.4 * (before.sleeve[1] - before.sleeve[0])
    return Rod(before.sleeve[0] - step, after.sleeve[1] + step, PIN, 0.025 * unit, body)


def coupler_parts(bars: Bars, point: np.ndarray, unit: float) -> list[Rod | Ball]:
    """Thin rods at home from the coupler's bar to the origin of its frame, and on to a point, shape (3,)."""
    coupler = bars.linkage.coupler
    start = _nearest(bars.ends[coupler], bars.origin)
    return holder((start, bars.origin, point), body_of(coupler), unit)


def holder(stations: Sequence[np.ndarray], body: str, unit: float) -> list[Rod | Ball]:
    """Thin rods from station to station in the coupler's colour, and a ball at the last."""
    rods = [Rod(a, b, COUPLER, 0.018 * unit, body) for a, b in pairwise(stations) if np.any(a != b)]
    return [*rods, Ball(stations[-1], COUPLER, 0.035 * unit, body)]


def _nearest(ends: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The point of a segment that is nearest to a given point; its ends have shape (2, 3)."""
    start, bar = ends[0], ends[1] - ends[0]
    length = bar @ bar
    return start + (np.clip((point - start) @ bar / length, 0, 1) if length > 0 else 0) * bar
