"""The bars of a closed chain in motion, in floats: where they are at a parameter, how near, how fast at most."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kinlib.circle import middle_of_turns
from kinlib.displacement import axis_of
from kinlib.dual_quaternion import DualQuaternion
from kinlib.rows import broadcast
from kinlib.typing import Array

__all__ = ["Joint", "MovingBars", "Pair", "distance", "pairs_without_joint"]


class Pair(NamedTuple):
    """Two links that share no joint: one is held, the other moves by the joints between them, in this order."""

    held: int
    moving: int
    joints: tuple[int, ...]


def pairs_without_joint(joints: Sequence[int]) -> list[Pair]:
    """All pairs of links that share no joint, with the way between them that has fewest factors.

    Parameters
    ----------
    joints : sequence of int
        The number of factors of each joint.

    Examples
    --------
    >>> pairs_without_joint((1, 1, 1, 1))
    [Pair(held=0, moving=2, joints=(0, 1)), Pair(held=1, moving=3, joints=(1, 2))]
    """
    count = len(joints)
    pairs = []
    for a in range(count):
        for b in range(a + 2, min(count, a + count - 1)):
            ahead, around = range(a, b), (*range(b, count), *range(a))
            fewer = sum(joints[n] for n in around) < sum(joints[n] for n in ahead)
            pairs.append(Pair(b, a, tuple(around)) if fewer else Pair(a, b, tuple(ahead)))
    return pairs


class Joint(NamedTuple):
    """One joint: its axis at home, and its factors t − (x + y h) for t = middle + spread · cot φ.

    Attributes
    ----------
    point, direction : array, shape (3, rows)
        Of the axis, the direction of length 1.
    shift, rate : array, shape (factors, rows)
        (middle − x) / spread and y / spread.
    """

    point: Array
    direction: Array
    shift: Array
    rate: Array

    def pick(self, rows: Array) -> Joint:
        """The same joint, for some rows."""
        return Joint(*(part[:, rows] for part in self))

    def half_turn_number(self, angle: Array) -> Array:
        """The complex number whose argument is half the angle of the joint at φ."""
        cos, sin = np.cos(angle), np.sin(angle)
        return np.asarray(np.prod(cos + (self.shift - 1j * self.rate) * sin, axis=0))

    def turned(self, angle: Array, points: Array) -> Array:
        """Points, shape (3, m, rows), turned about the axis from home to φ."""
        number = self.half_turn_number(angle)
        turn = number**2 / (number.real**2 + number.imag**2)
        axis, start = self.direction[:, None], self.point[:, None]
        way = points - start
        along = dot(axis, way) * axis
        return np.asarray(start + along + turn.real * (way - along) + turn.imag * cross(axis, way))

    def distance_of(self, points: Array) -> Array:
        """How far points, shape (3, m, rows), are from the axis."""
        away = cross(self.direction[:, None], points - self.point[:, None])
        return np.sqrt(dot(away, away))

    def fastest(self, angle: Array, half: Array) -> Array:
        """A bound of how fast the joint turns for φ within ± half, in radians for one of 2φ.

        A factor turns by |y| / (A + R cos 2(φ − φ₀)), with A² − R² = y².
        """
        mean = (1 + self.shift**2 + self.rate**2) / 2
        even, odd = (1 - self.shift**2 - self.rate**2) / 2, self.shift
        radius, phase = np.hypot(even, odd), np.arctan2(odd, even)
        away = np.abs((2 * angle - phase + np.pi) % (2 * np.pi) - np.pi) + 2 * half
        least = mean + radius * np.cos(np.minimum(away, np.pi))
        return np.asarray((np.abs(self.rate) / np.maximum(least, self.rate**2 / (mean + radius))).sum(axis=0))


@dataclass(frozen=True, eq=False)
class MovingBars:
    """The bars of many loops of one kind, and the joints that move them, seen from the middle of the bars.

    Attributes
    ----------
    joints : list of Joint
    bars : array, shape (links, 3, m, rows)
        The m points of each link's bar at home.
    centre : array, shape (3, rows)
    size : array, shape (rows,)
        The distance of the farthest of these points from the middle.
    middle, spread : array, shape (rows,)
        Of the parameter t = middle + spread · cot φ.
    """

    joints: list[Joint]
    bars: Array
    centre: Array
    size: Array
    middle: Array
    spread: Array

    @classmethod
    def of(cls, factors: Sequence[DualQuaternion], joints: Sequence[int], bars: Array) -> MovingBars:
        """Of the factors of a loop, of its numbers of factors, and bars of shape (..., n, m, 3), all with one batch."""
        shape = bars.shape[:-3]
        rows = math.prod(shape)
        components = [broadcast(f, shape).astype(float).components.reshape(8, rows) for f in factors]
        turning = [np.sqrt((f[1:4] ** 2).sum(axis=0)) for f in components]
        middle, spread = middle_of_turns(np.stack([f[0] for f in components]), np.stack(turning))
        points = np.moveaxis(bars.reshape(rows, *bars.shape[-3:]), (1, 3, 2), (0, 1, 2))
        centre = points.mean(axis=(0, 2))
        points = points - centre[:, None]
        starts = np.cumsum([0, *joints])
        parts = [components[start:end] for start, end in pairwise(starts)]
        return cls(
            [_joint(part, centre, middle, spread) for part in parts],
            points,
            centre,
            np.sqrt((points**2).sum(axis=1).max(axis=(0, 1))),
            middle,
            spread,
        )

    def pick(self, rows: Array) -> MovingBars:
        """The same, for some rows."""
        joints = [joint.pick(rows) for joint in self.joints]
        parts = (self.bars, self.centre, self.size, self.middle, self.spread)
        return MovingBars(joints, *(part[..., rows] for part in parts))

    @property
    def defined(self) -> Array:
        """Which rows have no NaN."""
        numbers = np.concatenate([part for joint in self.joints for part in joint])
        return np.asarray(np.isfinite(numbers).all(axis=0) & np.isfinite(self.bars).all(axis=(0, 1, 2)))

    def moved(self, pair: Pair, points: Array, angle: Array) -> Array:
        """Points of the moving link at home, shape (3, m, rows), as they are at φ for the held link."""
        for n in reversed(pair.joints):
            points = self.joints[n].turned(angle, points)
        return points

    def outward(self, link: int, points: Array, angle: Array) -> Array:
        """Points of a link at home, as they are at φ in the fixed frame; shape (3, rows)."""
        return self.moved(Pair(0, link, tuple(range(link))), points[:, None], angle)[:, 0] + self.centre

    def parameter(self, angle: Array) -> Array:
        """The t of φ; ∞ where φ is a multiple of π up to rounding."""
        sine = np.sin(angle)
        far = np.abs(sine) < AT_INFINITY
        return np.where(far, np.inf, self.middle + self.spread * np.cos(angle) / np.where(far, 1.0, sine))

    def distance_and_speed(self, pair: Pair, angle: Array, half: Array) -> tuple[Array, Array]:
        """How far two bars are from each other at φ, and how fast that can change for φ within ± half.

        The speed is for 2φ, the angle of a full turn: no point of the moving bar is faster than the sum, over the
        joints, of their speeds times its distances from their axes.
        """
        points = self.bars[pair.moving]
        speed = np.zeros(points.shape[1:])
        for n in reversed(pair.joints):
            joint = self.joints[n]
            farthest = joint.distance_of(points) + 2 * half * speed
            speed = speed + joint.fastest(angle, half) * farthest
            points = joint.turned(angle, points)
        return self._distance(pair, points), speed.max(axis=0)

    def distance(self, pair: Pair, angle: Array) -> Array:
        """How far two bars are from each other at φ."""
        return self._distance(pair, self.moved(pair, self.bars[pair.moving], angle))

    def _distance(self, pair: Pair, points: Array) -> Array:
        held, pieces = self.bars[pair.held], range(points.shape[1] - 1)
        ends = [(held[:, n], held[:, n + 1], points[:, m], points[:, m + 1]) for n in pieces for m in pieces]
        return np.asarray(np.min([distance(*four)[0] for four in ends], axis=0))


AT_INFINITY = 1e-9
"""The angle within which a parameter counts as infinite."""


def _joint(factors: Sequence[Array], centre: Array, middle: Array, spread: Array) -> Joint:
    """The joint of some factors about one axis, components first."""
    axis = axis_of(DualQuaternion.from_components(factors[0])).components
    direction, moment = axis[1:4], axis[5:8] - cross(centre, axis[1:4])
    shift = np.stack([(middle - f[0]) / spread for f in factors])
    rate = np.stack([dot(f[1:4], direction) / spread for f in factors])
    return Joint(cross(direction, moment), direction, shift, rate)


def dot(x: Array, y: Array) -> Array:
    """The inner product of vectors with the three coordinates first."""
    return np.asarray(x[0] * y[0] + x[1] * y[1] + x[2] * y[2])


def cross(x: Array, y: Array) -> Array:
    """The vector product, coordinates first."""
    return np.stack([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])


def distance(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array, Array]:
    """The distance of the segments ab and cd, coordinates first, and where it is reached on both, from 0 to 1.

    Examples
    --------
    >>> a, b, c, d = np.array([[0.0, 0, 0], [2, 0, 0], [1, -1, 3], [1, 1, 3]])
    >>> [float(x) for x in distance(a, b, c, d)]
    [3.0, 0.5, 0.5]
    """
    u, v, way = b - a, d - c, a - c
    uu, vv, uv, uw, vw = dot(u, u), dot(v, v), dot(u, v), dot(u, way), dot(v, way)
    square = uu * vv - uv * uv
    uu, vv = np.where(uu > 0, uu, 1.0), np.where(vv > 0, vv, 1.0)
    first = _within((uv * vw - uw * vv) / np.where(square > 0, square, np.inf))
    second = _within((uv * first + vw) / vv)
    first = _within((uv * second - uw) / uu)
    gap = way + first * u - second * v
    return np.sqrt(dot(gap, gap)), first, second


def _within(x: Array) -> Array:
    return np.minimum(np.maximum(x, 0.0), 1.0)
