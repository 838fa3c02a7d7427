"""The checks themselves: they pass what is right and fail what is wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kinlib import DualQuaternion, as_matrix, bennett_linkage, eps, i, j, k, null_form, one, study_form
from kinlib.gallery import THREE_POSES
from kinlib.testing import assert_closes, assert_same_point, assert_visits, random_poses

POSES = random_poses(3, seed=1)
LINKAGE = bennett_linkage(*POSES)


@pytest.mark.parametrize("factor", [1, -1, 2.5, -1e-6, 1e6])
def test_multiples_are_one_point(factor):
    assert_same_point(factor * (1 + 2 * i + eps * j), 1 + 2 * i + eps * j)


@pytest.mark.parametrize("wrong", [1 - i, 1 + i + 1e-6 * j, 1 + i + 1e-6 * eps * j, one * 0, one * math.nan])
def test_other_points_are_not(wrong):
    with pytest.raises(AssertionError, match="expected the point"):
        assert_same_point(wrong, 1 + i)


def test_one_wrong_entry_of_a_batch_is_enough():
    right = DualQuaternion.stack([one, i, j])
    assert_same_point(2 * right, right)
    with pytest.raises(AssertionError):
        assert_same_point(DualQuaternion.stack([one, i, k]), right)


def test_tolerance_and_length_can_be_set():
    assert_same_point(1 + 1e-4 * i, one, rtol=1e-3)
    assert_same_point(1 + eps * i * 1e-4, one.astype(float), length=1e6)
    with pytest.raises(AssertionError):
        assert_same_point(1 + eps * i * 1e-4, one.astype(float), length=1e-3)


def test_a_linkage_closes_or_not():
    assert_closes(LINKAGE)
    open_loop = replace(LINKAGE, factors=(LINKAGE.factors[0] + 1e-6 * k, *LINKAGE.factors[1:]), rtol=1e-4)
    with pytest.raises(AssertionError, match="the loop does not close"):
        assert_closes(open_loop)
    assert_closes(open_loop, rtol=1e-4)


def test_nan_is_no_closed_loop():
    broken = replace(LINKAGE, factors=(LINKAGE.factors[0] * math.nan, *LINKAGE.factors[1:]))
    with pytest.raises(AssertionError, match="does not close"):
        assert_closes(broken)


@pytest.mark.parametrize("number", range(3))
def test_a_missed_pose_is_named(number):
    assert_visits(LINKAGE, *POSES)
    for change in (1e-6 * k, 1e-6 * eps * k):
        poses = list(POSES)
        poses[number] = poses[number] * (1 + change)
        with pytest.raises(AssertionError, match=f"misses pose {number}"):
            assert_visits(LINKAGE, *poses)


def test_poses_are_visited_in_their_order():
    with pytest.raises(AssertionError, match="misses pose"):
        assert_visits(LINKAGE, POSES[0], POSES[2], POSES[1])


def test_the_number_of_poses_counts():
    with pytest.raises(AssertionError, match="3 poses, not 2"):
        assert_visits(LINKAGE, *POSES[:2])


def test_a_linkage_without_numbers_visits_nothing():
    broken = replace(LINKAGE, factors=tuple(f * math.nan for f in LINKAGE.factors))
    with pytest.raises(AssertionError, match="misses pose"):
        assert_visits(broken, *POSES)


def test_exact_linkages_visit_exactly():
    linkage = bennett_linkage(*THREE_POSES)
    assert_visits(linkage, *THREE_POSES)
    with pytest.raises(AssertionError, match="misses pose 2"):
        assert_visits(linkage, *THREE_POSES[:2], THREE_POSES[2] * (10**12 + k))


def test_random_poses_are_poses_and_repeat():
    poses, again = (random_poses(4, seed=3, shape=(50,)) for _ in range(2))
    for pose, same in zip(poses, again, strict=True):
        assert np.array_equal(pose.coeffs, same.coeffs)
        assert np.allclose(null_form(pose, pose), 1)
        assert np.allclose(study_form(pose, pose), 0)
    assert not np.array_equal(poses[0].coeffs, random_poses(1, seed=4, shape=(50,))[0].coeffs)


@pytest.mark.parametrize("length", [1e-3, 1e6])
@pytest.mark.parametrize("angle", [1e-3, 0.3])
def test_random_poses_have_the_size_that_is_asked_for(length, angle):
    matrices = as_matrix(random_poses(1, seed=5, length=length, angle=angle, shape=(4000,))[0])
    assert np.isclose(matrices[:, :3, 3].std(), length, rtol=0.05)
    turns = np.arccos(np.clip((np.trace(matrices[:, :3, :3], axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert angle / 2 < np.median(turns) < 3 * angle
