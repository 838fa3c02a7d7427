"""Three poses near each place where Theorem 2 fails, at a chosen distance."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from kinlib import DualQuaternion, as_matrix, from_matrix
from kinlib.testing import random_poses
from problems import random_half_turns


def displacement(rotation: Rotation, position) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), position
    return matrix


def _followed(pose: DualQuaternion, rotation: Rotation, position) -> DualQuaternion:
    return from_matrix(np.asarray(as_matrix(pose), float) @ displacement(rotation, position))


def almost_planar(random, distance: float) -> list:
    angles, places = random.uniform(-1.5, 1.5, 3), random.normal(size=(3, 2))
    return [
        displacement(
            Rotation.from_rotvec([0, 0, angle]) * Rotation.from_rotvec(distance * random.normal(size=3)),
            [*place, 0] + distance * random.normal(size=3),
        )
        for angle, place in zip(angles, places, strict=True)
    ]


def _poses(random) -> list[DualQuaternion]:
    return random_poses(3, seed=int(random.integers(2**31)))


def almost_a_rotation(random, distance: float) -> list:
    """Poses 1 and 2 differ by a screw of small pitch."""
    poses, axis = _poses(random), random.normal(size=3)
    axis /= np.linalg.norm(axis)
    poses[1] = _followed(poses[2], Rotation.from_rotvec(0.8 * axis), distance * axis)
    return poses


def almost_a_translation(random, distance: float) -> list:
    poses = _poses(random)
    poses[1] = _followed(poses[0], Rotation.from_rotvec(distance * random.normal(size=3)), random.normal(size=3))
    return poses


def almost_equal(random, distance: float) -> list:
    poses, step = _poses(random), distance * random.normal(size=(2, 3))
    poses[1] = _followed(poses[0], Rotation.from_rotvec(step[0]), step[1])
    return poses


def almost_spherical(random, distance: float) -> list:
    return [displacement(Rotation.from_quat(random.normal(size=4)), distance * random.normal(size=3)) for _ in range(3)]


def almost_double(random, distance: float) -> list:
    """Near 1, h1h2, (1 − h1)(1 − h2), through which there is one dyad instead of two."""
    h1, h2 = random_half_turns(2, seed=int(random.integers(2**31)))
    step = distance * random.normal(size=(2, 3))
    return [h1 * 0 + 1, h1 * h2, _followed((1 - h1) * (1 - h2), Rotation.from_rotvec(step[0]), step[1])]


def small_turns(random, distance: float) -> list:
    return random_poses(3, seed=int(random.integers(2**31)), angle=distance)


PLACES = {
    "planar": almost_planar, "rotation": almost_a_rotation, "translation": almost_a_translation, "equal": almost_equal,
    "spherical": almost_spherical, "double": almost_double, "small turns": small_turns,
}  # fmt: skip
