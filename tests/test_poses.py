"""Poses are judged in each other's company, whatever their representative, frame, unit, precision or batch."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    DualQuaternion,
    as_matrix,
    as_pose,
    bennett_linkage,
    eps,
    i,
    one,
    same_point,
    study_form,
    translation,
)
from kinlib.poses import as_poses, gap, seen_together
from kinlib.testing import random_poses


@pytest.mark.parametrize("seed", range(200))
def test_what_rounding_makes_of_a_pose_is_one(seed):
    poses = random_poses(3, seed=seed)
    for pose in poses:
        assert as_pose(pose * pose.inverse()).coeffs == pytest.approx(one.astype(float).coeffs, abs=1e-12)
    back = [pose * poses[0].inverse() for pose in poses]
    assert bennett_linkage(*back).closure_residual() < 1e-9


def test_the_nearest_pose_is_taken():
    pose = random_poses(1, seed=1)[0]
    nudged = DualQuaternion(pose.coeffs + 1e-11)
    taken = as_pose(nudged)
    assert abs(study_form(taken, taken)) < 1e-15
    assert np.abs((taken - nudged).coeffs).max() < 1e-10


@pytest.mark.parametrize("power", [-100, -5, 5, 100])
def test_representatives_do_not_matter(power):
    poses = random_poses(3, seed=2)
    scaled = [poses[0] * -(10.0**power), poses[1], poses[2] * 10.0 ** (power // 2)]
    for f, g in zip(bennett_linkage(*poses).factors, bennett_linkage(*scaled).factors, strict=True):
        assert np.allclose(f.coeffs, g.coeffs, rtol=0, atol=1e-11)


def test_a_point_off_the_quadric_is_refused_with_its_size_and_a_remedy():
    with pytest.raises(ValueError, match=r"here it is 0\.71 times \|p\|\|d\|.*rtol=.*study_projection"):
        as_pose(1 + eps + eps * i)
    coeffs = random_poses(1, seed=3, shape=(4,))[0].coeffs.copy()
    coeffs[2, 4] += 0.1
    with pytest.raises(ValueError, match=r"row 2: expected a point of the Study quadric"):
        as_pose(DualQuaternion(coeffs))
    assert np.isnan(as_poses(DualQuaternion(coeffs), degenerate="nan")[0].coeffs).any(-1).tolist() == [0, 0, 1, 0]


def test_a_rough_pose_is_taken_if_asked():
    rough = DualQuaternion(random_poses(1, seed=4)[0].coeffs.round(5))
    with pytest.raises(ValueError, match="rtol="):
        as_pose(rough)
    taken = as_pose(rough, rtol=1e-4)
    assert abs(study_form(taken, taken)) < 1e-15


def test_single_precision_is_judged_by_its_own():
    pose = random_poses(1, seed=5)[0]
    assert same_point(as_pose(DualQuaternion(pose.coeffs.astype(np.float32))), pose, rtol=1e-6)


@pytest.mark.parametrize("wrong", [None, "pose", 3, [1, 0, 0], [1.0] * 8])
def test_what_is_no_pose_is_refused_in_words(wrong):
    with pytest.raises((TypeError, ValueError), match="expected"):
        as_pose(wrong)


def test_infinite_complex_and_exceptional_points_are_refused():
    with pytest.raises(ValueError, match="finite"):
        as_pose(DualQuaternion([np.nan, 0, 0, 0, 0, 0, 0, 0]))
    with pytest.raises(ValueError, match="complex"):
        as_pose(1j * one + i)
    with pytest.raises(DegenerateError, match="exceptional"):
        as_pose(eps * i * 1.0)


def test_every_kind_of_pose_is_one():
    pose = random_poses(1, seed=6)[0]
    matrix = as_matrix(pose)
    for other in (matrix, matrix.tolist(), RigidTransform.from_matrix(matrix)):
        assert same_point(as_pose(other), pose)


def test_a_problem_is_seen_alike_from_everywhere():
    poses, move = random_poses(3, seed=7), translation([3e4, -2e4, 1e4])
    near = seen_together(*poses)
    for other in (seen_together(*(move * pose for pose in poses)), seen_together(*(pose * move for pose in poses))):
        assert other.length == near.length
        assert np.allclose(other.forms, near.forms, rtol=0, atol=1e-10)
        for q, r in zip(near.others, other.others, strict=True):
            assert gap(q, r) < 1e-6


def test_what_goes_in_comes_out():
    problem = seen_together(*random_poses(3, seed=8, length=1e3))
    line = random_poses(1, seed=9)[0]
    assert gap(problem.outward(problem.inward(line)), line) < 1e-12


def test_steps_and_forms():
    problem = seen_together(*random_poses(4, seed=10))
    assert len(problem.steps) == len(problem.forms) == 6
    q1, q2, q3 = problem.others
    expected = [study_form(x, y) for x, y in ((one, q1), (one, q2), (one, q3), (q1, q2), (q1, q3), (q2, q3))]
    assert np.allclose(problem.forms, expected, rtol=1e-12)


def test_exact_poses_stay_as_they_are():
    problem = seen_together(one, i - 2 * eps, 1 + i)
    assert problem.is_exact
    assert problem.noise == 0
    assert problem.others[0] == i - 2 * eps
