"""Near the places where Theorem 2 fails an answer is right, judged without rounding, or the place is named."""

import numpy as np
import pytest

from exact_judge import miss
from kinlib import DegenerateError, as_pose, bennett_linkage, dyads_through_poses, goldberg_linkages, translation
from kinlib.testing import random_poses
from near_degenerate import PLACES

NAMES = {
    "planar": "parallel axes", "rotation": "differ by a rotation", "translation": "differ by a pure translation",
    "equal": "are equal", "spherical": "lies in the Study quadric", "double": "double roots",
    "small turns": "differ by a pure translation",
}  # fmt: skip

SAFE = {
    "planar": 1e-9,
    "rotation": 1e-9,
    "translation": 1e-4,
    "equal": 1e-4,
    "spherical": 1e-9,
    "double": 1e-8,
    "small turns": 1e-5,
}
"""Down to this distance nothing may be refused."""

SEEDS = range(6)


def problem(place: str, distance: float, seed: int) -> list:
    return [as_pose(pose) for pose in PLACES[place](np.random.default_rng([seed, int(-np.log10(distance))]), distance)]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_a_bennett_linkage_visits_its_poses_or_is_refused_by_name(place, distance, seed):
    poses = problem(place, distance, seed)
    try:
        linkage = bennett_linkage(*poses)
    except DegenerateError as error:
        said = str(error)
        assert distance < SAFE[place], said
        assert NAMES[place] in said, said
    else:
        assert miss(linkage, poses) < 1e-9


@pytest.mark.parametrize("place", PLACES)
def test_goldberg_linkages_likewise(place):
    poses = problem(place, max(1e-3, 10 * SAFE[place]), 0)
    for linkage in goldberg_linkages(*poses, 0.7 + 1.3j):
        assert miss(linkage, poses) < 1e-9


@pytest.mark.parametrize("method", ["factorization", "null_quadrilateral"])
@pytest.mark.parametrize("place", PLACES)
def test_every_route_is_checked(place, method):
    for distance in (1e-3, 1e-7, 1e-11):
        poses = problem(place, distance, 1)
        try:
            pairs = zip(dyads_through_poses(*poses, method=method), dyads_through_poses(*poses), strict=True)
        except DegenerateError:
            continue
        for dyad, other in pairs:
            for pose in poses:
                assert np.shape(dyad.parameters(pose, rtol=1e-8)) == (2,)  # an error if it is not reached
                assert np.shape(other.parameters(pose, rtol=1e-8)) == (2,)


@pytest.mark.parametrize("distance", [1e2, 1e4, 1e6])
def test_far_from_the_origin_digits_are_lost_as_the_distance(distance):
    for seed in range(10):
        poses = [translation([distance, -2 * distance, distance]) * pose for pose in random_poses(3, seed=seed)]
        for linkage in (bennett_linkage(*poses), *goldberg_linkages(*poses, 1 + 2j)):
            assert miss(linkage, poses) < 1e-9 + 3e-14 * distance
