"""Theorem 2: the 2R dyads through three poses, by three routes that must agree."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    NumberFieldElement,
    as_matrix,
    bennett_linkage,
    conic_through,
    dyads_through_poses,
    eps,
    i,
    j,
    k,
    null_form,
    one,
    same_point,
    study_eigenvalues,
    study_form,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.testing import random_poses
from problems import (
    distance_of_axes,
    distance_of_dyads,
    distance_of_pairs,
    random_displacement,
    random_half_turns,
    rational_half_turns,
    whole_poses,
)

METHODS = ("eigenvalues", "factorization", "null_quadrilateral")
MEETS_E = "meets the exceptional three-space"
TANGENT = "tangent to the Study quadric"
INSIDE = "lies in the Study quadric"
DOUBLE = "double roots: one 2R dyad"


def as_floats(poses):
    return [pose.astype(float) for pose in poses]


def double_root_poses(h1, h2):
    """Poses on the dyad of unit half-turns h1, h2 for which the quartic is (t² + 1)²."""
    return one, h1 * h2, (1 - h1) * (1 - h2)


def tangent_poses(shape, seed: int, pair: int):
    """Three poses two of which differ by a rotation: 0 and 1, 0 and 2, or 1 and 2."""
    random = np.random.default_rng(seed)
    home, p = random_poses(2, seed=seed, shape=shape)
    h = random_half_turns(1, seed=seed, shape=shape)[0]
    turned = (random.normal(size=shape) - h) * home
    return {0: (home, turned, p), 1: (home, p, turned), 2: (p, home, turned)}[pair]


def ratio_and_distance(dyad):
    """a / sin α and a of the axes of a dyad, from direct coordinates."""
    l1, l2 = dyad.h1.coeffs[..., 1:4], dyad.h2.coeffs[..., 1:4]
    a1, a2 = (np.cross(h.coeffs[..., 1:4], h.coeffs[..., 5:8]) for h in (dyad.h1, dyad.h2))
    normal = np.cross(l1, l2)
    sine = np.linalg.norm(normal, axis=-1)
    distance = np.abs(((a1 - a2) * normal).sum(-1)) / sine
    return distance / sine, distance


# --- three routes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2))
def test_the_three_routes_agree_on_thousands_of_problems(seed):
    poses = random_poses(3, seed=seed, shape=(3000,))
    pairs = [dyads_through_poses(*poses, method=method) for method in METHODS]
    size = np.maximum.reduce([np.abs(h.coeffs).max(-1) for d in pairs[0] for h in (d.h1, d.h2)])
    for other in pairs[1:]:
        assert np.max(distance_of_pairs(pairs[0], other) / size) < 1e-9


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("angle", [None, 0.1])
def test_both_dyads_pass_through_the_poses(method, length, angle):
    poses = random_poses(3, seed=5, shape=(500,), length=length, angle=angle)
    for dyad in dyads_through_poses(*poses, method=method):
        for pose in poses:
            assert dyad.space().contains(pose).all()
            x = np.array(dyad.coordinates(pose))
            assert np.all(np.abs(x[0] * x[3] - x[1] * x[2]) <= 1e-9 * np.abs(x).max(0) ** 2)


@pytest.mark.parametrize("method", METHODS)
def test_the_two_dyads_are_different(method):
    first, second = dyads_through_poses(*random_poses(3, seed=6, shape=(1000,)), method=method)
    assert distance_of_dyads(first, second).min() > 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_axes_are_unit_half_turns(method):
    for dyad in dyads_through_poses(*random_poses(3, seed=7, shape=(200,)), method=method):
        for h in (dyad.h1, dyad.h2):
            assert np.allclose(null_form(h, h), 1, rtol=1e-12)
            assert np.allclose(study_form(h, h), 0, atol=1e-9)
            assert (h.coeffs[..., [0, 4]] == 0).all()


def test_a_third_2r_space_is_not_missed():
    """The number two is exact: a dyad through the poses that we choose is always one of them."""
    random = np.random.default_rng(8)
    h1, h2 = random_half_turns(2, seed=8, shape=(2000,))
    t = random.normal(size=(4, 2000))
    poses = one, Dyad(h1, h2)(t[0], t[1]), Dyad(h1, h2)(t[2], t[3])
    first, second = dyads_through_poses(*poses)
    size = np.maximum(np.abs(h1.coeffs).max(-1), np.abs(h2.coeffs).max(-1))
    nearest = np.minimum(distance_of_dyads(first, Dyad(h1, h2)), distance_of_dyads(second, Dyad(h1, h2))) / size
    assert np.quantile(nearest, 0.99) < 1e-9
    assert nearest.max() < 1e-6


def test_an_unknown_route_is_refused():
    with pytest.raises(ValueError, match="expected a method among eigenvalues, factorization, null_quadrilateral"):
        dyads_through_poses(*THREE_POSES, method="newton")


# --- exact in, exact out -------------------------------------------------------------------------------------------

EXACT = [THREE_POSES, LINEAR_TERMS_EQUAL, FIELD_OF_DEGREE_SIX]


@pytest.mark.parametrize("poses", EXACT)
def test_exact_dyads_pass_through_the_poses_exactly(poses):
    for dyad in dyads_through_poses(*poses):
        numbers = [x for h in (dyad.h1, dyad.h2) for x in h.coeffs]
        assert all(isinstance(x, (int, Fraction, NumberFieldElement)) for x in numbers)
        for pose in poses:
            coordinates = dyad.coordinates(pose)
            assert sum((x * y for x, y in zip(coordinates, dyad.basis, strict=True)), one * 0) == pose
            assert coordinates[0] * coordinates[3] == coordinates[1] * coordinates[2]


@pytest.mark.parametrize("poses", EXACT)
def test_the_exact_route_is_the_float_route(poses):
    exact = [Dyad(*as_floats((d.h1, d.h2))) for d in dyads_through_poses(*poses)]
    exact = [Dyad(*(h / np.sqrt(null_form(h, h)) for h in (d.h1, d.h2))) for d in exact]
    for method in METHODS:
        floats = dyads_through_poses(*as_floats(poses), method=method)
        assert distance_of_pairs(exact, floats) < 1e-9


def test_whole_poses_have_exact_dyads_with_any_first_pose():
    home = translation([2, 4, 6]) * (1 + 2 * i - k)
    for dyad in dyads_through_poses(*(pose * home for pose in THREE_POSES)):
        assert dyad.home == home
        assert all(pose * home in dyad.space() for pose in THREE_POSES)


def test_an_exact_batch_is_the_loop_of_its_rows():
    rows = (THREE_POSES, LINEAR_TERMS_EQUAL)
    batch = [DualQuaternion.stack(column) for column in zip(*rows, strict=True)]
    together = dyads_through_poses(*batch)
    for n, poses in enumerate(rows):
        for dyad, single in zip(together, dyads_through_poses(*poses), strict=True):
            assert dyad.h1[n] == single.h1
            assert dyad.h2[n] == single.h2


# --- the sharp form: eigenvalues of the Study form relative to the null form ----------------------------------------


def test_eigenvalues_are_those_of_the_gram_matrices():
    poses = random_poses(3, seed=9, shape=(300,))
    study, null = (
        np.array([[form(x, y) for x in poses] for y in poses]).transpose(2, 0, 1) for form in (study_form, null_form)
    )
    expected = np.sort(np.linalg.eigvals(np.linalg.solve(null, study)).real, axis=-1)
    assert np.allclose(study_eigenvalues(*poses), expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_both_dyads_have_distance_and_ratio_by_the_eigenvalues(method):
    poses = random_poses(3, seed=10, shape=(1000,))
    mu1, _, mu3 = study_eigenvalues(*poses).T
    for dyad in dyads_through_poses(*poses, method=method):
        ratio, distance = ratio_and_distance(dyad)
        assert np.allclose(distance**2, -mu1 * mu3, rtol=1e-7)
        assert np.allclose(ratio, (mu3 - mu1) / 2, rtol=1e-7)


def test_the_middle_eigenvalue_is_another_number():
    poses = random_poses(3, seed=10, shape=(1000,))
    mu1, mu2, _ = study_eigenvalues(*poses).T
    ratio, _ = ratio_and_distance(dyads_through_poses(*poses)[0])
    assert not np.isclose(ratio, (mu2 - mu1) / 2, rtol=1e-6).any()


def test_eigenvalues_do_not_depend_on_frames():
    poses = random_poses(3, seed=11)
    g, h = (random_displacement(seed=seed) for seed in (1, 2))
    moved = [g * pose * h * 2 for pose in poses]
    assert np.allclose(study_eigenvalues(*moved), study_eigenvalues(*poses), rtol=1e-9)
    assert np.allclose(study_eigenvalues(*poses[::-1]), study_eigenvalues(*poses), rtol=1e-9)


# --- tangent planes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", range(3))
def test_on_tangent_planes_the_eigenvalues_find_two_dyads(pair):
    poses = tangent_poses((500,), 12, pair)
    first, second = dyads_through_poses(*poses)
    assert distance_of_dyads(first, second).min() > 1e-7
    for dyad in (first, second):
        assert all(dyad.space().contains(pose).all() for pose in poses)


@pytest.mark.parametrize("pair", range(3))
@pytest.mark.parametrize("method", METHODS[1:])
def test_on_tangent_planes_the_other_routes_name_the_geometry(pair, method):
    for seed in range(20):
        with pytest.raises(DegenerateError, match=TANGENT):
            dyads_through_poses(*tangent_poses((), seed, pair), method=method)


@pytest.mark.parametrize("kind", [int, float])
def test_tangent_planes_have_no_conic_and_no_bennett_linkage(kind):
    home = translation([2, 0, 4]) * (1 + i)
    poses = [pose.astype(kind) for pose in (home, (2 - j + eps * i) * home, THREE_POSES[1])]
    for synthesis in (conic_through, bennett_linkage):
        with pytest.raises(DegenerateError, match="tangent"):
            synthesis(*poses)
    first, second = dyads_through_poses(*poses, method="eigenvalues")
    assert all(pose in dyad.space() for dyad in (first, second) for pose in poses)


def test_exact_tangent_planes_point_to_the_route_that_works():
    with pytest.raises(DegenerateError, match="method='eigenvalues'"):
        dyads_through_poses(one, 2 - i, THREE_POSES[2])


def test_the_tangent_plane_of_two_axes_has_both_orders():
    """⟨1, h1, h2⟩ lies in ⟨1, h1, h2, h1h2⟩ and in ⟨1, h1, h2, h2h1⟩."""
    h1, h2 = random_half_turns(2, seed=13, shape=(200,))
    pair = dyads_through_poses(one, 2 - h1, 3 - h2)
    size = np.maximum(np.abs(h1.coeffs).max(-1), np.abs(h2.coeffs).max(-1))
    assert np.max(distance_of_pairs(pair, (Dyad(h1, h2), Dyad(h2, h1))) / size) < 1e-8


# --- double roots --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("home", [one, translation([2, 4, 6]) * (1 + 2 * i)])
def test_double_roots_leave_one_dyad_exactly(home):
    tried = 0
    for seed in range(40):
        h1, h2 = rational_half_turns(2, seed=seed)
        if study_form(h1, h2) == 0 or not np.cross(h1.coeffs[1:4], h2.coeffs[1:4]).any():
            continue
        poses = [pose * home for pose in double_root_poses(h1, h2)]
        with pytest.raises(DegenerateError, match=DOUBLE) as caught:
            dyads_through_poses(*poses)
        dyad, tried = caught.value.dyad, tried + 1
        assert same_point(dyad.h1, h1)
        assert same_point(dyad.h2, h2)
        assert all(pose in dyad.space() for pose in poses)
    assert tried > 20


@pytest.mark.parametrize("method", METHODS)
def test_double_roots_leave_one_dyad_in_floats(method):
    for seed in range(60):
        h1, h2 = random_half_turns(2, seed=seed)
        home = random_displacement(seed=seed)
        poses = [pose * home for pose in double_root_poses(h1, h2)]
        with pytest.raises(DegenerateError, match=DOUBLE) as caught:
            dyads_through_poses(*poses, method=method)
        assert distance_of_dyads(caught.value.dyad, Dyad(h1, h2)) < 1e-7
        assert all(pose in caught.value.dyad.space() for pose in poses)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
def test_double_roots_are_seen_in_every_row_of_a_batch(length):
    h1, h2 = random_half_turns(2, seed=14, shape=(2000,), length=length)
    with pytest.raises(DegenerateError, match=DOUBLE) as caught:
        dyads_through_poses(*double_root_poses(h1, h2))
    assert caught.value.rows == tuple(range(2000))


@pytest.mark.parametrize("step", [1e-3, 1e-5])
def test_next_to_double_roots_there_are_two_dyads_again(step):
    h1, h2 = random_half_turns(2, seed=15, shape=(500,))
    poses = one, h1 * h2, (1 - h1) * (1 + step - h2)
    first, second = dyads_through_poses(*poses, degenerate="nan")
    found = ~np.isnan(first.h1.coeffs[:, 1])
    assert found.mean() > 0.99
    assert distance_of_dyads(first, second)[found].min() > step / 1e3
    assert all(dyad.space().contains(pose)[found].all() for dyad in (first, second) for pose in poses[1:])


def test_regular_poses_are_never_taken_for_double_roots():
    for seed in range(3):
        for dyad in dyads_through_poses(*random_poses(3, seed=seed, shape=(20000,))):
            assert np.isfinite(dyad.h1.coeffs).all()
            assert np.isfinite(dyad.h2.coeffs).all()


# --- degenerate planes ---------------------------------------------------------------------------------------------

REGULAR = THREE_POSES[2]
DEGENERATE = {
    "equal first two": ((one, -2 * one, REGULAR), "poses 0 and 1 are equal"),
    "equal outer two": ((one, REGULAR, one), "poses 0 and 2 are equal"),
    "equal last two": ((one, REGULAR, 3 * REGULAR), "poses 1 and 2 are equal"),
    "all equal": ((one, one, one), "poses 0 and 1 are equal"),
    "collinear": ((one, 1 + i, 2 + i), f"{MEETS_E}: the three orientations"),
    "translation": ((one, translation([0, 0, 2]), REGULAR), f"{MEETS_E}: poses 0 and 1 differ by a pure translation"),
    "late translation": ((REGULAR, one, translation([2, 0, 0])), f"{MEETS_E}: poses 1 and 2 .* pure translation"),
    "parallel axes": ((one, 1 + k + eps * i, 2 + k + 3 * eps * j), f"{MEETS_E}: .* parallel axes"),
    "screws about parallel axes": (
        (one, translation([0, 0, 2]) * (1 + k), translation([2, 0, 4]) * (2 - k)),
        f"{MEETS_E}: .* parallel axes",
    ),
    "spherical": ((one, 1 + i, 2 + j), INSIDE),
    "spherical off the origin": (tuple(translation([2, 2, 0]) * x for x in (one, 1 + i, 2 + j)), INSIDE),
}


@pytest.mark.parametrize("kind", [int, float])
@pytest.mark.parametrize("name", DEGENERATE)
def test_a_degenerate_plane_is_named(name, kind):
    poses, message = DEGENERATE[name]
    for home in (one, translation([2, 4, 0]) * (1 - i)):
        with pytest.raises(DegenerateError, match=message):
            dyads_through_poses(*((pose * home).astype(kind) for pose in poses))


@pytest.mark.parametrize("method", METHODS)
def test_degenerate_rows_are_named_or_nan_and_the_others_right(method):
    poses = random_poses(3, seed=16, shape=(6,))
    coeffs = [pose.coeffs.copy() for pose in poses]
    coeffs[1][1] = coeffs[0][1]
    h1, h2 = random_half_turns(2, seed=16)
    for array, pose in zip(coeffs, double_root_poses(h1, h2), strict=True):
        array[4] = pose.coeffs
    poses = [DualQuaternion(array) for array in coeffs]
    with pytest.raises(DegenerateError, match=r"rows 1, 4: poses 0 and 1 are equal.*; .*double roots") as caught:
        dyads_through_poses(*poses, method=method)
    assert caught.value.rows == (1, 4)
    for n, dyad in enumerate(dyads_through_poses(*poses, method=method, degenerate="nan")):
        assert np.isnan(dyad.h1.coeffs).all(-1).tolist() == [False, True, False, False, True, False]
        for row in (0, 2, 3, 5):
            single = dyads_through_poses(*(pose[row] for pose in poses), method=method)[n]
            assert distance_of_axes(single.h1, dyad.h1[row]) < 1e-9
            assert distance_of_axes(single.h2, dyad.h2[row]) < 1e-9


def test_a_single_degenerate_problem_can_be_nan():
    for poses in (DEGENERATE["translation"][0], DEGENERATE["spherical"][0], double_root_poses(i, j - eps * i)):
        for dyad in dyads_through_poses(*as_floats(poses), degenerate="nan"):
            assert np.isnan(dyad.h1.coeffs).all()


def test_exact_numbers_have_no_nan():
    with pytest.raises(ValueError, match="needs floats"):
        dyads_through_poses(*DEGENERATE["spherical"][0], degenerate="nan")


@pytest.mark.parametrize("poses", [THREE_POSES, as_floats(THREE_POSES), DEGENERATE["spherical"][0]])
def test_other_words_for_degenerate_are_refused(poses):
    with pytest.raises(ValueError, match="'raise' or 'nan'"):
        dyads_through_poses(*poses, degenerate="ignore")


# --- frames, batches, kinds of input ---------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_displacing_the_fixed_frame_displaces_the_axes(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed)
    expected = [Dyad(*(g * h * g.conjugate() for h in (d.h1, d.h2))) for d in dyads_through_poses(*poses)]
    assert distance_of_pairs(dyads_through_poses(*(g * pose for pose in poses)), expected) < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_displacing_the_moving_frame_leaves_the_axes(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed)
    moved = dyads_through_poses(*(pose * g * -2 for pose in poses))
    assert distance_of_pairs(moved, dyads_through_poses(*poses)) < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_the_dyads_are_those_of_the_set_of_poses(seed):
    """With another pose as home the axes are in another place: at t1 = t2 = ∞ the chain is at home."""
    p0, p1, p2 = random_poses(3, seed=seed)
    expected = []
    for dyad in dyads_through_poses(p0, p1, p2):
        t1, _ = dyad.parameters(p1)
        turn = t1 - dyad.h1
        expected.append(Dyad(dyad.h1, turn * dyad.h2 * turn.inverse()))
    assert distance_of_pairs(dyads_through_poses(p1, p0, p2), expected) < 1e-8


@pytest.mark.parametrize("method", METHODS)
def test_a_batch_is_the_loop_of_its_rows(method):
    poses = random_poses(3, seed=17, shape=(4, 5))
    together = dyads_through_poses(*poses, method=method)
    for index in np.ndindex(4, 5):
        single = dyads_through_poses(*(pose[index] for pose in poses), method=method)
        for first, second in zip(together, single, strict=True):
            assert distance_of_axes(first.h1[index], second.h1) < 1e-9
            assert distance_of_axes(first.h2[index], second.h2) < 1e-9


def test_batches_broadcast():
    p0, p1 = random_poses(2, seed=18)
    p2 = random_poses(1, seed=19, shape=(7,))[0]
    first, _ = dyads_through_poses(p0, p1, p2)
    assert first.shape == (7,)
    assert first.space().contains(p1).all()


def test_poses_are_given_as_quaternions_matrices_or_transforms():
    poses = random_poses(3, seed=20)
    expected = dyads_through_poses(*poses)
    matrices = [as_matrix(pose) for pose in poses]
    transforms = [RigidTransform.from_matrix(matrix) for matrix in matrices]
    for given in (matrices, transforms, [poses[0], matrices[1], transforms[2]]):
        assert distance_of_pairs(dyads_through_poses(*given), expected) < 1e-9


def test_transforms_may_be_batches():
    poses = random_poses(3, seed=21, shape=(5,))
    transforms = [RigidTransform.from_matrix(as_matrix(pose)) for pose in poses]
    assert np.max(distance_of_pairs(dyads_through_poses(*transforms), dyads_through_poses(*poses))) < 1e-9


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (DualQuaternion([math.nan, 0, 0, 0, 0, 0, 0, 0]), "finite"),
        (DualQuaternion([1, 0, 0, 0, 0, math.inf, 0, 0]), "finite"),
        (1 + eps, "Study quadric"),
        (1.0 + i + 1e-6 * eps, "Study quadric"),
        (eps * i, "exceptional three-space"),
        (np.eye(3), r"\(\.\.\., 4, 4\)"),
        (np.diag([1, 1, -1, 1]), "rotation"),
    ],
)
def test_what_is_no_pose_is_refused(place, bad, message):
    poses = list(random_poses(3, seed=22))
    poses[place] = bad
    with pytest.raises(ValueError, match=message):
        dyads_through_poses(*poses)


def test_exact_poses_of_many_kinds_stay_exact():
    """Whole poses need a field; the axes are in it and satisfy the equations exactly."""
    for seed in (3, 5):
        poses = whole_poses(3, seed=seed)
        try:
            dyads = dyads_through_poses(*poses)
        except DegenerateError:
            continue
        assert all(pose in dyad.space() for dyad in dyads for pose in poses)
