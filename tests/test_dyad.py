"""2R dyads, their spaces and null quadrilaterals, and Theorem 1 as a procedure."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from kinlib import (
    EXCEPTIONAL_SPACE,
    NULL_CONE,
    STUDY_QUADRIC,
    DegenerateError,
    DualQuaternion,
    Dyad,
    Line,
    act,
    as_matrix,
    eps,
    i,
    is_null_line,
    j,
    join,
    k,
    meet,
    one,
    recognise,
    same_point,
    study_form,
    translation,
    unit,
)
from kinlib.testing import assert_same_point
from problems import (
    distance_of_axes,
    distance_of_dyads,
    random_displacement,
    random_half_turns,
    rational_half_turns,
    whole_half_turns,
)

H1, H2 = i, j - eps * i  # skew axes, at right angles and one apart
PARAMETERS = [math.inf, 0, 1, -2, 5]


def skew_pairs(make, count: int) -> list:
    """Pairs of half-turns about skew axes."""
    pairs = (make(2, seed=seed) for seed in range(10 * count))
    return [(h1, h2) for h1, h2 in pairs if study_form(h1, h2) != 0 and meets_only_in_zero(h1, h2)][:count]


def meets_only_in_zero(h1, h2) -> bool:
    return bool(np.cross(h1.coeffs[1:4], h2.coeffs[1:4]).any())


def unimodular(seed: int) -> np.ndarray:
    """A whole 4×4 matrix of determinant 1."""
    random = np.random.default_rng(seed)
    lower, upper = (np.tril(random.integers(-2, 3, (4, 4)), -1) + np.eye(4, dtype=int) for _ in range(2))
    return lower @ upper.T


def rotation_about(h: DualQuaternion, angle: float) -> RigidTransform:
    """SciPy's rotation about the axis l + εm, with the point l × m on it."""
    l, m = h.coeffs[1:4], h.coeffs[5:8]
    point = np.cross(l, m)
    turn = RigidTransform.from_rotation(Rotation.from_rotvec(angle * l))
    return RigidTransform.from_translation(point) * turn * RigidTransform.from_translation(-point)


# --- the chain -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_a_dyad_turns_about_the_moving_axis_and_then_about_the_base_axis(seed):
    h1, h2 = random_half_turns(2, seed=seed)
    for t1, t2 in product([-2.0, 0.0, 0.7], repeat=2):
        first, second = (rotation_about(h, -2 * np.arctan2(1, t)) for h, t in ((h1, t1), (h2, t2)))
        assert np.allclose(as_matrix(Dyad(h1, h2)(t1, t2)), (first * second).as_matrix(), atol=1e-12)


def test_infinity_is_no_turn():
    dyad = Dyad(H1, H2)
    assert dyad(math.inf, math.inf) == 1
    assert dyad(2, math.inf) == 2 - H1
    assert dyad(math.inf, 3) == 3 - H2


@pytest.mark.parametrize(("t1", "t2"), list(product(PARAMETERS, repeat=2)))
def test_parameters_invert_the_chain(t1, t2):
    for (h1, h2), home in product(skew_pairs(whole_half_turns, 3), (one, translation([2, 0, -4]) * (1 + i - k))):
        dyad = Dyad(h1, h2, home)
        assert dyad.parameters(dyad(t1, t2) * -3) == (t1, t2)


def test_parameters_of_a_batch_are_those_of_its_entries():
    random = np.random.default_rng(1)
    h1, h2 = random_half_turns(2, seed=1, shape=(50,))
    t1, t2 = random.normal(size=(2, 50))
    found = Dyad(h1, h2).parameters(Dyad(h1, h2)(t1, t2))
    assert np.allclose(found, (t1, t2), rtol=1e-9)


def test_poses_of_a_dyad_lie_on_its_quadric_and_others_do_not():
    for h1, h2 in skew_pairs(whole_half_turns, 5):
        dyad = Dyad(h1, h2)
        for t1, t2 in product((0, 2, -3), repeat=2):
            assert tuple(dyad.coordinates(dyad(t1, t2))) == (t1 * t2, -t2, -t1, 1)
        quadric = dyad.space().quadric()
        saddle = [[0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]]
        assert same_point(np.ravel(quadric.matrix), np.ravel(saddle))


def test_the_axes_are_lines_of_the_half_turns():
    first, second = Dyad(H1, H2).axes
    assert first.as_dual_quaternion() == H1
    assert second.as_dual_quaternion() == H2


@pytest.mark.parametrize("bad", [1 + i, i + eps, one, eps * i, i + eps * i, one * 0])
def test_what_is_no_half_turn_is_refused(bad):
    with pytest.raises(ValueError, match="h1 is no half-turn"):
        Dyad(bad, H2)
    with pytest.raises(ValueError, match="h2 is no half-turn"):
        Dyad(H1, bad)


@pytest.mark.parametrize("same", [H2, -H2, 3 * H2, H2.astype(float)])
def test_a_dyad_needs_two_axes(same):
    with pytest.raises(DegenerateError, match="axes agree"):
        Dyad(H2, same)


def test_axes_far_from_the_origin_are_told_apart():
    far = translation([1e9, 2e9, 0.0])
    h1, h2 = (far * h * far.conjugate() for h in (H1.astype(float), i + 1e-3 * j + eps * k * 0.0))
    assert Dyad(h1, h2).h2 is h2


def test_parallel_and_intersecting_axes_make_dyads_too():
    assert j * i in Dyad(j, i).space()
    assert i * (i + eps * j) in Dyad(i, i + eps * j).space()


# --- the space -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("home", [one, 1 + 2 * i, translation([2, 4, 6]) * (1 - j)])
def test_a_space_holds_its_dyad_and_not_the_reversed_one(home):
    for h1, h2 in skew_pairs(whole_half_turns, 10):
        space = Dyad(h1, h2, home).space()
        assert all(x * home in space for x in (one, h1, h2, h1 * h2, (2 - h1) * (3 - h2)))
        assert h2 * h1 * home not in space
        assert home * eps not in space


def test_membership_measures_the_dual_part_as_well():
    pose = Dyad(H1, H2)(2.0, 3.0)
    assert pose in Dyad(H1, H2).space()
    assert pose + 1e-6 * eps * k not in Dyad(H1, H2).space()
    assert pose + 1e-6 * k not in Dyad(H1, H2).space()


def test_membership_agrees_with_linear_algebra():
    for seed in range(20):
        h1, h2 = random_half_turns(2, seed=seed)
        space = Dyad(h1, h2).space()
        random = np.random.default_rng(seed)
        inside = DualQuaternion(random.normal(size=4) @ space.points.coeffs)
        for point in (inside, DualQuaternion(random.normal(size=8))):
            rank = np.linalg.matrix_rank(np.vstack([space.points.coeffs, point.coeffs]), tol=1e-9)
            assert (point in space) == (rank == 4)


def test_a_space_takes_matrices_and_transforms():
    pose = Dyad(H1, H2)(2, 3)
    space = Dyad(H1, H2).space()
    assert as_matrix(pose) in space
    assert RigidTransform.from_matrix(as_matrix(pose).astype(float)) in space


def test_membership_of_a_batch_has_one_answer_an_entry():
    poses = DualQuaternion.stack([Dyad(H1, H2)(t, 2) for t in (0, 1)] + [H2 * H1])
    assert Dyad(H1, H2).space().contains(poses).tolist() == [True, True, False]


# --- null quadrilaterals -------------------------------------------------------------------------------------------


def edges(quadrilateral):
    return zip(quadrilateral, (*quadrilateral[1:], quadrilateral[0]), strict=True)


@pytest.mark.parametrize("make", [rational_half_turns, whole_half_turns])
def test_the_null_quadrilateral_is_exact(make):
    for h1, h2 in skew_pairs(make, 2):
        quadrilateral = Dyad(h1, h2).space().null_quadrilateral()
        assert all(is_null_line(x, y) for x, y in edges(quadrilateral))
        assert not is_null_line(quadrilateral.u1, quadrilateral.u2)
        assert not is_null_line(quadrilateral.v1, quadrilateral.v2)


@pytest.mark.parametrize("home", [one, random_displacement(seed=3)])
def test_the_null_quadrilateral_by_lemma_1(home):
    for seed in range(20):
        space = Dyad(*random_half_turns(2, seed=seed), home).space()
        quadrilateral = space.null_quadrilateral()
        u1, v1, u2, v2 = quadrilateral
        assert all(is_null_line(x, y) for x, y in edges(quadrilateral))
        assert not is_null_line(u1, u2)
        assert not is_null_line(v1, v2)
        assert np.allclose(u1.coeffs.conj(), u2.coeffs)
        assert np.allclose(v1.coeffs.conj(), v2.coeffs)
        assert np.linalg.matrix_rank([x.coeffs for x in quadrilateral], tol=1e-9) == 4
        assert all(space.contains(x) for x in quadrilateral)


def test_real_rulings_and_wrong_diagonals_are_not_null():
    dyad = Dyad(H1, H2)
    assert not is_null_line(dyad(2, 0), dyad(2, 1))
    assert not is_null_line(dyad(1j, 0), dyad(0, 1j))


# --- Theorem 1 as a procedure --------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [rational_half_turns, whole_half_turns])
def test_theorem_1_round_trip_is_exact(make):
    for seed, (h1, h2) in enumerate(skew_pairs(make, 12)):
        points = DualQuaternion(unimodular(seed) @ Dyad(h1, h2).space().points.coeffs)
        found = recognise(points)
        assert same_point(found.h1, h1)
        assert same_point(found.h2, h2)
        assert all(isinstance(x, (int, np.integer, Fraction)) for x in found.h1.coeffs)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
def test_theorem_1_round_trip_in_any_real_basis(length):
    for seed in range(40):
        h1, h2 = random_half_turns(2, seed=seed, length=length)
        basis = np.random.default_rng(seed).normal(size=(4, 4)) @ Dyad(h1, h2).space().points.coeffs
        found = recognise(basis)
        assert_same_point(found.h1, h1, rtol=1e-7, length=length)
        assert_same_point(found.h2, h2, rtol=1e-7, length=length)


def test_the_order_of_the_axes_is_recognised():
    forward, backward = recognise(Dyad(H1, H2).space()), recognise(Dyad(H2, H1).space())
    assert same_point(forward.h1, H1)
    assert same_point(backward.h1, H2)


def test_a_space_is_recognised_however_it_is_given():
    points = DualQuaternion.stack([one, H1, H2, H1 * H2])
    for basis in (points, points.coeffs, points.coeffs.tolist(), join(*points), Dyad(H1, H2).space()):
        found = recognise(basis)
        assert same_point(found.h1, H1)
        assert same_point(found.h2, H2)


def test_more_points_than_needed_are_welcome():
    points = DualQuaternion.stack([one, H1, H2, H1 * H2, one + H1, 2 * H2 - H1])
    assert same_point(recognise(points).h1, H1)


V = i + j + 2 * k  # direction of a prismatic joint

FAILURES = {
    "intersecting axes": ([one, i, j, k], "lies in the Study quadric: the axes would be coplanar"),
    "intersecting axes off the origin": (
        [translation([2, 4, 6]) * x * translation([-2, -4, -6]) for x in (one, i, j, k)],
        "lies in the Study quadric: the axes would be coplanar",
    ),
    "parallel axes": ([one, k, k + eps * i, eps * j], "lies in the Study quadric: the axes would be coplanar"),
    "prismatic joint": ([one, k, eps * V, eps * k * V], "meets the exceptional three-space: .* prismatic"),
    "cylinder joint": ([one, k, eps * k, eps], "meets the exceptional three-space"),
    "complex axes": ([one, i + eps * i, j + eps * j, k + eps], "without real lines: the axes would be complex"),
    "singular quadric": ([one, i, j + eps * j, k + eps * k], "singular quadric, of rank 2"),
    "no null quadrilateral": ([one, i, j - eps * i, k + 2 * eps + eps * k], "contains no null quadrilateral"),
    "too few points": ([one, i, j], "span a 3-space, got a span of dimension 2"),
    "dependent points": ([one, i, j, i + j], "span a 3-space, got a span of dimension 2"),
    "too many points": ([one, i, j, k, eps], "span a 3-space, got a span of dimension 4"),
    "no identity": ([x * (1 + k) for x in (H1, H2, H1 * H2, eps * k)], r"does not contain \[1\]"),
}


@pytest.mark.parametrize("kind", [int, float])
@pytest.mark.parametrize("name", FAILURES)
def test_each_condition_that_fails_has_its_own_message(name, kind):
    points, message = FAILURES[name]
    with pytest.raises(DegenerateError, match=message):
        recognise(DualQuaternion.stack([x.astype(kind) for x in points]))


def test_the_space_of_parallel_axes_lies_in_the_study_quadric():
    h1, h2 = k, k + eps * i
    space = join(one, h1, h2, h1 * h2)
    assert STUDY_QUADRIC.contains(space)
    assert meet(space, EXCEPTIONAL_SPACE).dimension == 1


def test_a_space_that_fails_item_1_alone():
    """⟨1, i, j + εj, k + εk⟩ misses E and contains a null quadrilateral."""
    points = [one, i, j + eps * j, k + eps * k]
    assert meet(join(*points), EXCEPTIONAL_SPACE).dimension == -1
    assert NULL_CONE.restrict(join(*points)).rank() == 4
    a, b, c, d = points
    vertices = [1j * a + b, 1j * c + d, -1j * a + b, -1j * c + d]
    assert all(is_null_line(x, y) for x, y in edges(vertices))


def test_a_space_next_to_a_2r_space_is_refused():
    points = DualQuaternion.stack([one, H1, H2, H1 * H2 + 1e-4 * eps * k])
    with pytest.raises(DegenerateError, match="no null quadrilateral"):
        recognise(points)


def test_points_that_are_no_numbers_are_refused():
    points = np.array([one.coeffs, H1.coeffs, H2.coeffs, (H1 * H2).coeffs], dtype=float)
    for bad in (math.nan, math.inf):
        points[3, 0] = bad
        with pytest.raises(ValueError, match="finite"):
            recognise(points)


def test_points_of_another_space_are_refused():
    with pytest.raises(ValueError, match="8"):
        recognise(np.eye(4))


@pytest.mark.parametrize("seed", range(5))
def test_a_displaced_space_is_a_2r_space_through_another_pose(seed):
    """Left multiplication by g moves the axes, once [1] is in the space again."""
    g = random_displacement(seed=seed)
    h1, h2 = random_half_turns(2, seed=seed)
    moved = [g * x * g.conjugate() for x in (one, h1, h2, h1 * h2)]
    found = recognise(DualQuaternion.stack(moved))
    expected = Dyad(*(g * h * g.conjugate() for h in (h1, h2)))
    assert distance_of_dyads(found, expected) < 1e-9
    assert np.allclose(act(g, Dyad(h1, h2).axes[0]).direction, expected.axes[0].direction)


@pytest.mark.parametrize("seed", range(40))
def test_coplanar_axes_in_floats_are_named(seed):
    rng = np.random.default_rng(seed)
    point, l1, l2 = rng.normal(size=(3, 3))
    space = Dyad(*(unit(Line.at(point, l).as_dual_quaternion()) for l in (l1, l2))).space()
    with pytest.raises(DegenerateError, match="the axes would be coplanar"):
        recognise(space.points)


@pytest.mark.parametrize("scalar", [1.0, 1e-9])
def test_the_exceptional_space_is_no_space_of_a_dyad(scalar):
    with pytest.raises(DegenerateError, match="exceptional three-space"):
        recognise(scalar * np.eye(8, dtype=type(scalar))[4:])


# --- what a dyad reaches --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_a_pose_that_is_not_reached_has_no_parameters(seed):
    dyad = Dyad(*random_half_turns(2, seed=seed))
    pose = translation([0, 0, 1]) * dyad(0.3, -1.2)
    with pytest.raises(DegenerateError, match=r"does not reach the pose: it passes by at \d"):
        dyad.parameters(pose)
    matrices = np.array([as_matrix(dyad(0.3, -1.2)), as_matrix(pose)])
    with pytest.raises(DegenerateError, match="row 1: the dyad does not reach"):
        dyad.parameters(matrices)
    for t, expected in zip(dyad.parameters(matrices, degenerate="nan"), (0.3, -1.2), strict=True):
        assert np.allclose(t, [expected, np.nan], equal_nan=True)


@pytest.mark.parametrize("pose", [translation([1, 2, 3]), 1 + k, translation([3, -1, 2]) * (2 - i + 3 * k)])
def test_exact_and_float_poses_that_are_missed_are_missed_by_the_same(pose):
    messages = []
    for q, (h1, h2) in ((pose, (2 * i, j - eps * i)), (pose.astype(float), (1.0 * i, 1.0 * (j - eps * i)))):
        with pytest.raises(DegenerateError, match=r"passes by at \d") as error:
            Dyad(h1, h2).parameters(q)
        messages.append(str(error.value))
    assert messages[0] == messages[1]


def test_exact_poses_next_to_the_exact_dyad_are_not_reached():
    dyad = Dyad(i, j - eps * i)
    with pytest.raises(DegenerateError, match="does not reach"):
        dyad.parameters(translation([0, 0, Fraction(1, 10**30)]) * dyad(2, 3))


def test_at_home_both_parameters_are_infinite():
    for seed in range(200):
        home = random_displacement(seed=seed)
        dyad = Dyad(*random_half_turns(2, seed=seed), home)
        assert dyad.parameters(home) == (math.inf, math.inf)


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-6, 1e-8])
def test_near_home_no_digits_are_lost_but_those_of_the_angle(angle):
    for seed in range(50):
        dyad = Dyad(*random_half_turns(2, seed=seed))
        t1, t2 = dyad.parameters(dyad(1 / angle, -2 / angle))
        assert math.isclose(t1, 1 / angle, rel_tol=1e-13 / angle)
        assert math.isclose(t2, -2 / angle, rel_tol=1e-13 / angle)


@pytest.mark.parametrize("tilt", [0.0, 1e-12, 1e-8, 1e-4])
def test_nearly_parallel_axes_have_parameters_too(tilt):
    dyad = Dyad(k * 1.0, unit(k + tilt * i - eps * j))
    for t1, t2 in dyad.parameters(dyad(0.4, -1.7)), dyad.parameters(as_matrix(dyad(0.4, -1.7))):
        assert math.isclose(t1, 0.4, rel_tol=1e-12)
        assert math.isclose(t2, -1.7, rel_tol=1e-12)


@pytest.mark.parametrize("distance", [1e3, 1e6])
def test_far_from_the_origin_a_dyad_reaches_its_poses(distance):
    for seed in range(20):
        h1, h2 = random_half_turns(2, seed=seed)
        move = translation([distance, -distance, 2 * distance])
        dyad = Dyad(*(unit(move * h * move.conjugate()) for h in (h1, h2)))
        t1, t2 = dyad.parameters(move * Dyad(h1, h2)(0.7, 1.9) * move.conjugate())
        assert math.isclose(t1, 0.7, rel_tol=1e-14 * distance)
        assert math.isclose(t2, 1.9, rel_tol=1e-14 * distance)


@pytest.mark.parametrize("home", [eps * i, 1 + eps, DualQuaternion([0] * 8)])
def test_the_home_pose_is_a_pose(home):
    with pytest.raises(ValueError, match=r"Study quadric|exceptional"):
        Dyad(i, j - eps * i, home)
    with pytest.raises(TypeError, match="expected h1 as a DualQuaternion"):
        Dyad([0, 1, 0, 0, 0, 0, 0, 0], j - eps * i)


# --- many spaces, and far away ---------------------------------------------------------------------------------------


def test_a_batch_of_spaces_has_a_batch_of_dyads_each_row_with_its_own_fate():
    dyads = Dyad(*random_half_turns(2, seed=5, shape=(2, 3)))
    points = dyads.space().points.coeffs.copy()
    found = recognise(points)
    assert found.shape == (2, 3)
    assert np.all(distance_of_axes(found.h1, dyads.h1) < 1e-9)
    points[1, 0, 2] = points[1, 0, 1]
    with pytest.raises(DegenerateError, match="row 3: expected points that span a 3-space") as caught:
        recognise(points)
    assert caught.value.rows == (3,)
    spoiled = np.isnan(recognise(points, degenerate="nan").h1.coeffs).any(-1)
    assert spoiled.tolist() == [[False] * 3, [True, False, False]]


@pytest.mark.parametrize("distance", [1e2, 1e4, 1e6])
def test_far_from_the_origin_spaces_are_recognised_as_well_as_the_distance_allows(distance):
    place = np.array([distance, -2 * distance, distance])
    for seed in range(10):
        h1, h2 = random_half_turns(2, seed=seed)
        move = translation(place)
        far = [unit(move * h * move.conjugate()) for h in (h1, h2)]
        mixed = np.random.default_rng(seed).normal(size=(4, 4)) @ Dyad(*far).space().points.coeffs
        found = recognise(mixed)
        back = [move.conjugate() * h * move for h in (found.h1, found.h2)]
        for h, expected in zip(back, (h1, h2), strict=True):
            assert distance_of_axes(unit(h), expected) < 1e-8 + 1e-12 * distance
