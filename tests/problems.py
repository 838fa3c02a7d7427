"""Seeded problems: lines, dyads and poses that theorems are tried on."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from kinlib import DualQuaternion, Line, null_form, one, translation, unit

PYTHAGOREAN = ((1, 2, 2, 3), (2, 3, 6, 7), (1, 4, 8, 9), (4, 4, 7, 9), (2, 6, 9, 11), (3, 4, 0, 5), (0, 0, 1, 1))


def random_half_turns(count: int, *, seed: int, shape=(), length: float = 1.0) -> list[DualQuaternion]:
    """Half-turns about random lines, with directions of length 1."""
    random = np.random.default_rng(seed)
    lines = (Line.at(length * random.normal(size=(*shape, 3)), random.normal(size=(*shape, 3))) for _ in range(count))
    return [unit(line.as_dual_quaternion()) for line in lines]


def whole_half_turns(count: int, *, seed: int) -> list[DualQuaternion]:
    """Half-turns about lines with whole Plücker coordinates; directions are not of length 1."""
    random = np.random.default_rng(seed)
    points, directions = random.integers(-3, 4, (2, count, 3))
    directions[(directions == 0).all(-1)] = (1, 2, 2)
    return [Line.at(a, l).as_dual_quaternion() for a, l in zip(points, directions, strict=True)]


def rational_half_turns(count: int, *, seed: int) -> list[DualQuaternion]:
    """Half-turns about lines with rational Plücker coordinates and directions of length 1."""
    random = np.random.default_rng(seed)
    turns = []
    for *direction, length in (PYTHAGOREAN[n] for n in random.integers(len(PYTHAGOREAN), size=count)):
        direction = random.permutation(direction) * random.choice([-1, 1], 3)
        point = [Fraction(int(x), 2) for x in random.integers(-4, 5, 3)]
        turns.append(Line.at(point, [Fraction(int(x), length) for x in direction]).as_dual_quaternion())
    return turns


def whole_poses(count: int, *, seed: int) -> list[DualQuaternion]:
    """[1] and more poses with small rational coefficients."""
    random = np.random.default_rng(seed)
    poses = [one]
    while len(poses) < count:
        primal = random.integers(-2, 3, 4)
        if primal.any():
            turn = DualQuaternion([*map(int, primal), 0, 0, 0, 0])
            poses.append(translation([int(2 * x) for x in random.integers(-2, 3, 3)]) * turn)
    return poses


def random_displacement(*, seed: int) -> DualQuaternion:
    """A unit dual quaternion on the Study quadric."""
    random = np.random.default_rng(seed)
    return translation(random.normal(size=3)) * unit(DualQuaternion([*random.normal(size=4), 0, 0, 0, 0]))


def distance_of_axes(h: DualQuaternion, k: DualQuaternion) -> np.ndarray:
    """How far two unit half-turns are from being about one unoriented line."""
    return np.minimum(np.abs((h - k).coeffs).max(-1), np.abs((h + k).coeffs).max(-1))


def distance_of_dyads(first, second) -> np.ndarray:
    """How far two dyads (with one home) are from having the same two axes."""
    return np.maximum(distance_of_axes(first.h1, second.h1), distance_of_axes(first.h2, second.h2))


def distance_of_pairs(first, second) -> np.ndarray:
    """How far two pairs of dyads are from agreeing, in either order."""
    (a, b), (c, d) = first, second
    straight = np.maximum(distance_of_dyads(a, c), distance_of_dyads(b, d))
    crossed = np.maximum(distance_of_dyads(a, d), distance_of_dyads(b, c))
    return np.minimum(straight, crossed)


def pose_error(linkage, poses, length=1.0) -> np.ndarray:
    """The largest distance of a pose that is reached from the one that was asked for, over unit quaternions.

    Dual parts are measured in the given unit of length, which may differ from row to row.
    """
    errors, weight = (
        [],
        np.concatenate([np.ones((*np.shape(length), 4)), np.ones(4) * np.asarray(length)[..., None]], -1),
    )
    for t, pose in zip(linkage.parameters, poses, strict=True):
        reached = linkage.coupler_motion(t)
        reached = reached / np.sqrt(null_form(reached, reached))
        wanted = pose / np.sqrt(null_form(pose, pose))
        difference = [np.abs((reached - sign * wanted).coeffs / weight).max(-1) for sign in (1, -1)]
        errors.append(np.minimum(*difference))
    return np.max(errors, axis=0)


def reach(linkage) -> np.ndarray:
    """How far from the origin the axes of a linkage are."""
    return np.linalg.norm(linkage.axes.coeffs[..., 5:], axis=-1).max(-1)
