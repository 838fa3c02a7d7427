"""Random data that a true linkage meets, of many kinds: held out from the search, which sees the data alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinlib import (
    DualQuaternion,
    Line,
    MotionPolynomial,
    act,
    half_turn,
    task,
    translation,
    unit,
)  # fmt: skip

P, D, L, X, R, T, A = "pose", "point and direction", "line", "point", "orientation", "point on line", "direction"

FIVE_R = {
    "pose, line, point, orientation": (P, L, X, R),
    "four lines": (L, L, L, L),
    "six points": (X,) * 6,
    "two lines, three points": (L, L, X, X, X),
    "pose, line, two points": (P, L, X, X),
    "pose, point and direction, point, point on line": (P, D, X, T),
    "point and direction, two lines, point": (D, L, L, X),
    "two points and directions, point, orientation": (D, D, X, R),
    "pose, two lines, point on line": (P, L, L, T),
    "two poses, two points on lines": (P, P, T, T),
    "point and direction, three points, direction, point on line": (D, X, X, X, A, T),
    "orientation, line, three points, point on line": (R, L, X, X, X, T),
}
"""Kinds of data with Σ (codimension − 1) = 12."""

FOUR_R = {"two poses": (P, P), "two lines, point and direction": (L, L, D)}
SIX_R = {"eight points": (X,) * 8, "three poses, point on line": (P, P, P, T)}


@dataclass(frozen=True)
class Problem:
    """A home pose, data, and the coupler motion of a linkage that meets them at t."""

    home: DualQuaternion
    data: tuple[task.Datum, ...]
    motion: MotionPolynomial
    parameters: tuple[float, ...]


def random_problem(kinds, *, seed: int) -> tuple[DualQuaternion, tuple[task.Datum, ...]]:
    """A home pose and data of given kinds that have nothing to do with each other."""
    random = np.random.default_rng(seed)
    home = _pose(random, 1.0)
    return home, tuple(datum(kind, _pose(random, 1.0), random, 1.0) for kind in kinds)


def problem(kinds, joints=(2, 1), *, seed: int, length: float = 1.0, place=(0, 0, 0)) -> Problem:
    """Data of given kinds along a random motion of a chain whose joints have so many factors."""
    random = np.random.default_rng(seed)
    home = translation(place) * _pose(random, length)
    axes = [half_turn(Line.at(length * random.normal(size=3) + place, _direction(random))) for _ in joints]
    axes = [unit(h) for h in axes]
    factors = [
        random.normal() + (0.3 + abs(random.normal())) * h for h, n in zip(axes, joints, strict=True) for _ in range(n)
    ]
    motion = MotionPolynomial.from_factors(factors, home)
    parameters = tuple(np.tan(random.uniform(-1.4, 1.4, len(kinds))).tolist())
    data = tuple(datum(kind, motion(t), random, length) for kind, t in zip(kinds, parameters, strict=True))
    return Problem(home, data, motion, parameters)


def datum(kind: str, pose: DualQuaternion, random: np.random.Generator, length: float) -> task.Datum:
    """A random datum of a kind that a pose meets."""
    point, direction = length * random.normal(size=3), _direction(random)
    line = Line.at(point, direction)
    place, aim = act(pose, point), act(pose, direction) - act(pose, [0, 0, 0])
    return {
        P: lambda: task.Pose(pose),
        D: lambda: task.PointAndDirection(point, direction, place, aim),
        L: lambda: task.Line(line, act(pose, line)),
        X: lambda: task.Point(point, place),
        R: lambda: task.Orientation(pose),
        T: lambda: task.PointOnLine(point, Line.at(place, _direction(random))),
        A: lambda: task.Direction(direction, aim),
    }[kind]()


def _direction(random: np.random.Generator) -> np.ndarray:
    v = random.normal(size=3)
    return v / np.linalg.norm(v)


def _pose(random: np.random.Generator, length: float) -> DualQuaternion:
    turn = DualQuaternion(np.concatenate([random.normal(size=4), np.zeros(4)]))
    return translation(length * random.normal(size=3)) * unit(turn)
