"""Bennett linkages: four axes, opposite links equal, through three poses and closed along the motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    MotionPolynomial,
    as_matrix,
    bennett_linkage,
    conic_through,
    dyads_through_poses,
    eps,
    i,
    j,
    one,
    same_point,
    study_eigenvalues,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.testing import assert_closes, assert_visits, random_poses
from problems import distance_of_pairs, pose_error, random_displacement, random_half_turns, reach

EXACT = [THREE_POSES, LINEAR_TERMS_EQUAL, FIELD_OF_DEGREE_SIX]


# --- the poses -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("angle", [None, 0.1])
def test_the_coupler_visits_the_poses_at_every_scale(length, angle):
    poses = random_poses(3, seed=1, shape=(2000,), length=length, angle=angle)
    linkage = bennett_linkage(*poses)
    assert pose_error(linkage, poses, length).max() < 1e-9
    assert linkage.closure_residual().max() < 1e-9
    assert linkage.parameters == (math.inf, 0, 1)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
def test_small_turns_keep_accuracy_relative_to_the_mechanism(length):
    """With turns of a thousandth the axes are a thousand lengths away: that is the size to compare with."""
    poses = random_poses(3, seed=1, shape=(2000,), length=length, angle=1e-3)
    linkage = bennett_linkage(*poses)
    assert pose_error(linkage, poses, reach(linkage)).max() < 1e-9
    assert linkage.closure_residual().max() < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_the_coupler_motion_is_the_conic_through_the_poses(seed):
    poses = random_poses(3, seed=seed)
    assert bennett_linkage(*poses).coupler_motion.same_motion(conic_through(*poses))
    assert_visits(bennett_linkage(*poses), *poses)


@pytest.mark.parametrize("poses", EXACT)
def test_exact_poses_have_an_exact_linkage(poses):
    for home in (one, translation([2, 0, 4]) * (1 + i - j)):
        moved = [pose * home for pose in poses]
        linkage = bennett_linkage(*moved)
        assert linkage.closure_residual() == 0
        assert linkage.mobility() == 1
        assert all(same_point(linkage.coupler_motion(t), p) for t, p in zip((math.inf, 0, 1), moved, strict=True))
        assert not any(isinstance(x, (float, np.floating)) for f in linkage.factors for x in f.coeffs)
        product = MotionPolynomial([one.coeffs])
        for f in linkage.factors:
            product = product * MotionPolynomial([one.coeffs, (-f).coeffs])
        assert all(c == c.scalar_part for c in product.coefficients)


# --- the linkage ---------------------------------------------------------------------------------------------------


def test_it_is_made_of_the_two_dyads():
    poses = random_poses(3, seed=2, shape=(200,))
    a1, a2, b2, b1 = (bennett_linkage(*poses).axes[:, n] for n in range(4))
    assert np.max(distance_of_pairs((Dyad(a1, a2), Dyad(b1, b2)), dyads_through_poses(*poses))) < 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_bennetts_conditions(seed):
    poses = random_poses(3, seed=seed, shape=(500,))
    first, second, third, fourth = rows = bennett_linkage(*poses).denavit_hartenberg()
    for row, opposite in ((first, third), (second, fourth)):
        assert np.allclose(row.distance, opposite.distance, rtol=1e-6)
        assert np.allclose(row.twist, opposite.twist, rtol=1e-6)
    ratios = [row.distance / np.sin(row.twist) for row in rows]
    assert np.allclose(np.abs(ratios), np.abs(ratios[0]), rtol=1e-6)
    scale = np.max([row.distance for row in rows], axis=0)
    assert all(np.all(np.abs(row.offset) < 1e-6 * scale) for row in rows)


def test_neighbouring_links_are_not_congruent():
    first, second, *_ = bennett_linkage(*random_poses(3, seed=3, shape=(500,))).denavit_hartenberg()
    assert not np.isclose(first.distance, second.distance, rtol=1e-6).all()


def test_the_ratio_comes_straight_from_the_poses():
    poses = random_poses(3, seed=4, shape=(500,))
    mu1, _, mu3 = study_eigenvalues(*poses).T
    rows = bennett_linkage(*poses).denavit_hartenberg()
    for row in rows:
        assert np.allclose(np.abs(row.distance / np.sin(row.twist)), (mu3 - mu1) / 2, rtol=1e-6)
    assert np.allclose(rows[0].distance ** 2, -mu1 * mu3, rtol=1e-6)


def test_mobility_is_one_and_the_rank_three():
    poses = random_poses(3, seed=5, shape=(200,))
    linkage = bennett_linkage(*poses)
    assert np.all(linkage.mobility() == 1)
    lines = linkage.axes.coeffs[..., [1, 2, 3, 5, 6, 7]]
    assert np.all(np.linalg.matrix_rank(lines, rtol=1e-7) == 3)


def test_opposite_links_move_by_conics():
    linkage = bennett_linkage(*random_poses(3, seed=6))
    assert linkage.relative_motion(0, 2).degree == linkage.relative_motion(1, 3).degree == 2


# --- frames and input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_displacing_the_fixed_frame_displaces_the_linkage(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed + 50)
    here, there = bennett_linkage(*poses), bennett_linkage(*(g * pose for pose in poses))
    moved = g * here.axes * g.conjugate()
    axes = [(moved[a], moved[b], moved[c], moved[d]) for a, b, c, d in ((0, 1, 2, 3), (3, 2, 1, 0))]
    assert any(all(same_point(x, y) for x, y in zip(there.axes, order, strict=True)) for order in axes)


@pytest.mark.parametrize("seed", range(5))
def test_displacing_the_moving_frame_leaves_the_linkage(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed + 50)
    here, there = bennett_linkage(*poses), bennett_linkage(*(pose * g for pose in poses))
    assert any(np.all(same_point(there.axes, order)) for order in (here.axes, here.axes[::-1]))
    assert_visits(there, *(pose * g for pose in poses))


def test_matrices_and_transforms():
    poses = random_poses(3, seed=7)
    matrices = [as_matrix(pose) for pose in poses]
    for given in (matrices, [RigidTransform.from_matrix(matrix) for matrix in matrices]):
        linkage = bennett_linkage(*given)
        assert_visits(linkage, *poses)
        assert_closes(linkage)


# --- where there is none -------------------------------------------------------------------------------------------


def test_degenerate_rows_are_named_or_nan():
    poses = random_poses(3, seed=8, shape=(5,))
    h1, h2 = random_half_turns(2, seed=8)
    coeffs = [pose.coeffs.copy() for pose in poses]
    coeffs[1][0] = ((2 - h1) * poses[0][0]).coeffs  # a rotation
    coeffs[2][2] = (translation([1.0, 2, 3]) * poses[0][2]).coeffs  # a translation
    for array, pose in zip(coeffs, (one, h1 * h2, (1 - h1) * (1 - h2)), strict=True):
        array[4] = pose.coeffs  # double roots
    poses = [DualQuaternion(array) for array in coeffs]
    with pytest.raises(DegenerateError) as caught:
        bennett_linkage(*poses)
    assert set(caught.value.rows) <= {0, 2, 4}
    linkage = bennett_linkage(*poses, degenerate="nan")
    bad = [True, False, True, False, True]
    assert np.isnan(linkage.closure_residual()).tolist() == bad
    assert np.isnan(linkage.axes.coeffs).any((-1, -2)).tolist() == bad
    good = [pose[[1, 3]] for pose in poses]
    assert np.allclose(linkage[[1, 3]].axes.coeffs, bennett_linkage(*good).axes.coeffs)


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ((one, i * (j - eps * i), (1 - i) * (1 - j + eps * i)), "double roots"),
        ((one, 2 - i, THREE_POSES[2]), "tangent"),
        ((one, one, THREE_POSES[1]), "poses 0 and 1 are equal"),
        ((one, translation([0, 2, 0]), THREE_POSES[1]), "pure translation"),
        ((one, 1 + i, 1 + j), "lies in the Study quadric"),
    ],
)
@pytest.mark.parametrize("kind", [int, float])
def test_the_geometry_is_named(poses, message, kind):
    with pytest.raises(DegenerateError, match=message):
        bennett_linkage(*(pose.astype(kind) for pose in poses))


def test_a_single_degenerate_problem_can_be_nan():
    linkage = bennett_linkage(one.astype(float), 2 - i, THREE_POSES[2], degenerate="nan")
    assert np.isnan(linkage.axes.coeffs).all()
