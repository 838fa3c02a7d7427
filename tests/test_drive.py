"""The drive: parameters of angles and poses, rates and twists, dead points, turns and ranges."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    Linkage,
    NearestPose,
    act,
    as_float,
    as_matrix,
    as_rigid_transform,
    bennett_flip,
    bennett_linkage,
    eps,
    goldberg_linkages,
    i,
    is_exact,
    j,
    k,
    six_r_linkages,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, THREE_POSES
from kinlib.testing import random_poses

THREE = random_poses(3, seed=1)
LINKAGES = [
    bennett_linkage(*THREE),
    *goldberg_linkages(*THREE, 0.4 + 0.9j)[:3],
    *six_r_linkages(*random_poses(4, seed=5))[:2],
]
SWINGING = next(x for x in goldberg_linkages(*THREE, 0.2 - 0.2j) if 0 in x.turns())
TIMES = (-40.0, -1.3, 0.0, 0.2, 1.7, 3e5, math.inf)
H1, H2 = i, 2 * j - 2 * eps * i


def near(found, expected) -> float:
    """How far parameters are apart on their circle."""
    found, expected = (2 * np.arctan2(1, -np.asarray(t, dtype=float)) for t in (found, expected))
    return float(np.abs(np.sin((found - expected) / 2)).max())


# ---- parameters of an angle --------------------------------------------------------------------------


@pytest.mark.parametrize("linkage", [*LINKAGES, SWINGING], ids=repr)
def test_the_parameters_of_an_angle_are_all_at_which_the_joint_has_it(linkage):
    for joint, count in enumerate(linkage.joints):
        for t in TIMES:
            angle = linkage.joint_angles(t)[..., joint]
            found = linkage.parameter_of(angle, joint)
            assert found.shape == (count,)
            assert min(near(found[n], t) for n in range(count)) < 1e-9
            again = linkage.joint_angles(found)[~np.isnan(found), joint]
            assert np.abs(np.sin((again - angle) / 2)).max() < 1e-9
            assert np.all(np.diff(found[~np.isnan(found)]) > 0)


def test_a_joint_that_turns_twice_has_each_angle_at_two_parameters():
    linkage = next(x for x in LINKAGES if 2 in x.turns())
    joint = linkage.joints.index(2)
    found = linkage.parameter_of(np.linspace(-3, 3, 13), joint)
    assert found.shape == (13, 2)
    assert not np.isnan(found).any()


def test_a_joint_that_swings_reaches_its_range_only():
    joint = SWINGING.joints.index(2)
    low, high = SWINGING.joint_ranges()[joint]
    inside = np.linspace(low, high, 9)[1:-1]
    assert not np.isnan(SWINGING.parameter_of(inside, joint)).any()
    assert np.isnan(SWINGING.parameter_of([low - 0.1, high + 0.1], joint)).all()


def test_parameters_of_an_angle_are_exact_for_angles_of_sympy():
    linkage = Linkage.from_chains([H1, H2], bennett_flip(H1, H2))
    (t,) = linkage.parameter_of(sympy.pi / 3)
    assert t == -sympy.sqrt(3)
    assert linkage.parameter_of(sympy.pi / 2).tolist() == [-1]
    assert linkage.parameter_of(0).tolist() == linkage.parameter_of(2 * sympy.pi).tolist() == [math.inf]
    double = goldberg_linkages(*THREE_POSES, (1, 2))[0]
    found = double.parameter_of(sympy.pi, 0)
    assert is_exact(found)
    assert np.abs(np.cos(double.joint_angles(as_float(found))[:, 0] / 2)).max() < 1e-12


def test_parameters_of_angles_broadcast_and_leave_nan_rows_alone():
    poses = random_poses(3, seed=4, shape=(4,))
    linkages = bennett_linkage(*poses)
    found = linkages.parameter_of(np.full((3, 1), 0.7), 2)
    assert found.shape == (3, 4, 1)
    assert near(found[0, 2], linkages[2].parameter_of(0.7, 2)) < 1e-12
    assert np.isnan(linkages.parameter_of([0.1, np.nan, 0.2, 0.3])).ravel().tolist() == [False, True, False, False]


@pytest.mark.parametrize("joint", [-1, 4, 0.5])
def test_joints_that_there_are_not_are_refused(joint):
    with pytest.raises((ValueError, TypeError), match=r"expected (a joint among 0, …, 3|the joint as a whole number)"):
        LINKAGES[0].parameter_of(0.3, joint)


# ---- rates and twists --------------------------------------------------------------------------------


@pytest.mark.parametrize("linkage", [*LINKAGES, SWINGING], ids=repr)
def test_rates_are_the_slopes_of_the_angles(linkage):
    linkage, step = linkage.astype(float), 1e-6
    for t in TIMES[:-2]:
        slope = (linkage.joint_angles(t + step) - linkage.joint_angles(t - step)) / (2 * step)
        assert np.allclose(linkage.joint_rates(t, None), slope, rtol=1e-6, atol=1e-7)
        rates = linkage.joint_rates(t, None)
        assert np.allclose(linkage.joint_rates(t, 1), rates / rates[1], rtol=1e-12)
    far = linkage.joint_angles([1e7, -1e7])
    change = np.remainder(far[1] - far[0] + np.pi, 2 * np.pi) - np.pi
    assert np.allclose(linkage.joint_rates(math.inf, 1), change / change[1], rtol=1e-5, atol=1e-6)
    assert not linkage.joint_rates(math.inf, None).any()


@pytest.mark.parametrize("linkage", LINKAGES, ids=repr)
@pytest.mark.parametrize("t", TIMES[:-2])
def test_twists_are_the_velocities_of_scipys_transforms(linkage, t):
    step = 1e-5
    for link in range(linkage.joint_count):
        ends = [as_rigid_transform(linkage.astype(float).link_displacements(s)[link]) for s in (t + step, t - step)]
        small = (ends[0] * ends[1].inv()).as_exp_coords() / (2 * step)
        assert np.allclose(as_float(linkage.twist(t, link, None)), small, rtol=1e-6, atol=1e-6 * np.abs(small).max())


def test_turns_are_right_handed_and_velocities_are_those_of_points():
    linkage = Linkage.from_chains([k, H2], bennett_flip(k, H2))
    twist = as_float(linkage.twist(0, 1))
    assert twist.tolist() == [0, 0, 1, 0, 0, 0]  # about z: from x to y
    a, b = (act(linkage.link_displacements(linkage.parameter_of(angle)[0])[1], [1.0, 0.0, 0.0]) for angle in (0, 0.1))
    assert np.allclose(b - a, [math.cos(0.1) - 1, math.sin(0.1), 0])
    loop, point, t = LINKAGES[1], np.array([0.3, -0.2, 1.1]), 0.4
    w, v = np.split(loop.twist(t, 2, None), 2)
    ahead, behind = (act(loop.link_displacements(s)[2], point) for s in (t + 1e-6, t - 1e-6))
    place = act(loop.link_displacements(t)[2], point)
    assert np.allclose((ahead - behind) / 2e-6, v + np.cross(w, place), rtol=1e-6)


def test_rates_and_twists_are_exact_and_broadcast():
    linkage = bennett_linkage(*THREE_POSES)
    t = Fraction(1, 3)
    assert is_exact(linkage.twist(t, 2))
    assert is_exact(linkage.joint_rates(math.inf))
    field = bennett_linkage(*FIELD_OF_DEGREE_SIX)
    assert is_exact(field.twist(t, 2, None))  # no root is needed
    assert np.allclose(as_float(field.twist(t, 2, None)), field.astype(float).twist(1 / 3, 2, None))
    many = bennett_linkage(*random_poses(3, seed=7, shape=(3, 1)))
    assert many.twist([0.1, 0.2, math.inf, 4.0], 3).shape == (3, 4, 6)
    assert np.allclose(many.twist([0.1, math.inf], 3)[2, 1], many[2, 0].twist(math.inf, 3))
    assert many.joint_rates([0.1, math.inf]).shape == (3, 2, 4)


def test_the_base_rests_and_links_that_there_are_not_are_refused():
    assert not as_float(LINKAGES[0].twist(0.3, 0)).any()
    with pytest.raises(ValueError, match="expected a link among 0, …, 3, got 4"):
        LINKAGES[0].twist(0.3, 4)


# ---- the whole motion --------------------------------------------------------------------------------


@pytest.mark.parametrize("linkage", [*LINKAGES, SWINGING], ids=repr)
def test_turns_and_ranges_are_those_of_a_dense_sample(linkage):
    t = -1 / np.tan(np.linspace(0, np.pi, 20001)[1:-1])
    angles = linkage.astype(float).joint_angles(t)
    assert linkage.turns().tolist() == np.rint((angles[-1] - angles[0]) / (2 * np.pi)).tolist()
    sampled = np.stack([angles.min(axis=0), angles.max(axis=0)], axis=-1)
    assert np.abs(linkage.joint_ranges() - sampled).max() < 1e-2
    assert np.all(linkage.joint_ranges()[:, 0] <= sampled[:, 0] + 1e-9)


def test_a_joint_turns_back_at_its_dead_points_only():
    joint = SWINGING.joints.index(2)
    dead = SWINGING.dead_points(joint)
    assert dead.shape == (2,)
    for t in dead:
        rates = SWINGING.joint_rates([t - 1e-4, t, t + 1e-4], None)[:, joint]
        assert abs(rates[1]) < 1e-12
        assert rates[0] * rates[2] < 0
    assert [SWINGING.dead_points(n).shape for n in range(5) if n != joint] == [(0,)] * 4
    turning = next(x for x in LINKAGES if 2 in x.turns())
    assert np.isnan(turning.dead_points(turning.joints.index(2))).all()


def test_poses_are_visited_in_the_order_of_their_parameters():
    linkage = Linkage.from_chains([H1, H2], bennett_flip(H1, H2), parameters=[2, 5, math.inf, -1, 3])
    assert linkage.order_of_visits().tolist() == [0, 4, 1, 2, 3]
    linkages = Linkage.from_chains([H1, H2], bennett_flip(H1, H2), parameters=[np.array([0, 4]), 1, 2])
    assert linkages.order_of_visits().tolist() == [[0, 1, 2], [0, 1, 2]]


# ---- poses -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("linkage", [*LINKAGES, SWINGING], ids=repr)
def test_the_parameters_of_poses_on_the_motion_are_found(linkage):
    floats = linkage.astype(float)
    found = floats.parameters_of_pose(floats.coupler_motion(np.array(TIMES)))
    assert found.shape == (len(TIMES), 1)
    assert near(found[:, 0], TIMES) < 1e-12


def test_the_parameters_of_exact_poses_are_exact():
    for linkage in (goldberg_linkages(*THREE_POSES, (1, 2))[3], bennett_linkage(*FIELD_OF_DEGREE_SIX)):
        pose = linkage.coupler_motion(Fraction(2, 7))
        (t,) = linkage.parameters_of_pose(pose)
        assert is_exact(np.array(t))
        assert t == Fraction(2, 7)
        assert linkage.parameters_of_pose(linkage.home).tolist() == [math.inf]


def test_a_pose_that_is_passed_twice_has_two_parameters():
    exact = next(x for x in goldberg_linkages(*THREE_POSES, (1, 2)) if x.joints[0] == 2)
    exact = Linkage(exact.factors, exact.joints, 1)  # the link behind the joint that turns twice
    t = exact.parameters_of_pose(exact.coupler_motion(3))
    assert is_exact(t)
    assert 3 in t.tolist()
    assert t.shape == (2,)
    floats = exact.astype(float)
    assert near(floats.parameters_of_pose(floats.coupler_motion(3)), t) < 1e-12
    angle = floats.joint_angles(3.0)[0]
    assert near(floats.parameter_of(angle, 0), t) < 1e-12


def test_a_pose_beside_the_motion_is_refused_with_its_distance():
    linkage = LINKAGES[0]
    beside = linkage.coupler_motion(0.3) * translation([0, 0, 1e-3])
    with pytest.raises(DegenerateError, match=r"does not reach the pose: .* nearest, at t = 0\.\d+, it is turned"):
        linkage.parameters_of_pose(beside)
    two = linkage.coupler_motion([0.3, 0.3]) * translation([[0, 0, 0], [0, 0, 0.1]])
    with pytest.raises(DegenerateError, match="row 1: the coupler does not reach"):
        linkage.parameters_of_pose(two)
    found = linkage.parameters_of_pose(
        linkage.coupler_motion([0.3, 0.3]) * translation([[0, 0, 0], [0, 0, 0.1]]), degenerate="nan"
    )
    assert np.isnan(found).ravel().tolist() == [False, True]
    assert near(linkage.parameters_of_pose(beside, rtol=1e-2), 0.3) < 1e-2


@pytest.mark.parametrize("seed", range(3))
def test_the_nearest_pose_is_that_of_a_dense_sample(seed):
    linkage = LINKAGES[seed]
    (pose,) = random_poses(1, seed=seed + 20)
    nearest = linkage.nearest_pose(pose)
    assert isinstance(nearest, NearestPose)
    size = float(linkage.chain.lines.length)
    t = -1 / np.tan(np.linspace(0, np.pi, 4001)[1:-1])
    gap = as_matrix(linkage.coupler_motion(t)) - as_matrix(pose)
    square = (gap[:, :3, 3] ** 2).sum(axis=-1) + size**2 / 3 * (gap[:, :3, :3] ** 2).sum(axis=(1, 2))
    assert abs(t[square.argmin()] - nearest.t) < 1e-2 * (1 + nearest.t**2)
    there = RigidTransform.from_matrix(as_matrix(linkage.coupler_motion(nearest.t)))
    apart = RigidTransform.from_matrix(as_matrix(pose)).inv() * there
    assert math.isclose(apart.rotation.magnitude(), nearest.angle, rel_tol=1e-6)
    assert math.isclose(np.linalg.norm(apart.translation), nearest.shift, rel_tol=1e-6)
    assert nearest.shift**2 + size**2 / 3 * 8 * math.sin(nearest.angle / 2) ** 2 <= square.min() * (1 + 1e-9)


def test_the_nearest_pose_moves_with_the_fixed_frame():
    linkage, (pose, frame) = LINKAGES[1], random_poses(2, seed=3)
    moved = Linkage([frame * f * frame.inverse() for f in linkage.factors], linkage.joints, 2, frame * linkage.home)
    assert np.allclose(moved.nearest_pose(frame * pose), linkage.nearest_pose(pose), rtol=1e-6)


def test_a_fast_joint_is_not_overlooked():
    h, g = i, 1e-6 * (j - 2 * eps * i) + 0.3  # the second joint turns round while the first one hardly moves
    linkage = Linkage.from_chains([h, g], bennett_flip(h, g))
    for t in (0.3 + 1e-6, 0.3 - 3e-6):
        (found,) = linkage.parameters_of_pose(linkage.coupler_motion(t))
        assert abs(found - t) < 1e-13


def test_nan_rows_stay_nan_rows():
    linkages = bennett_linkage(*random_poses(3, seed=9, shape=(2,)))
    rows = linkages[[0, 0, 1]]
    lost = Linkage([f * np.array([1.0, np.nan, 1.0]) for f in rows.factors], rows.joints, 2, rows.home)
    pose = linkages[[0, 0, 1]].coupler_motion(0.4)
    found, nearest = lost.parameters_of_pose(pose), lost.nearest_pose(pose)
    for values in (
        found[:, 0],
        nearest.t,
        nearest.shift,
        lost.twist(0.4, 2)[:, 0],
        lost.dead_points(0).sum(-1) * 0 + found[:, 0],
    ):
        assert np.isnan(values).tolist() == [False, True, False]
    assert np.isnan(lost.turns()).any(axis=-1).tolist() == [False, True, False]
    assert np.isnan(lost.joint_ranges()).any(axis=(-1, -2)).tolist() == [False, True, False]


def test_the_nearest_place_may_be_home_itself():
    """Values next to a minimum say half of its digits only: t = ∞ would come out as −3·10⁸."""
    for linkage in (bennett_linkage(*THREE_POSES), *goldberg_linkages(*THREE_POSES, (1, 2))[:2]):
        nearest = linkage.nearest_pose(1 + Fraction(3, 10) * eps * i)
        assert nearest.t == math.inf
        assert nearest.shift == pytest.approx(0.6)
        assert nearest.angle == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_pose_is_level_to_the_last_digits(seed):
    """The distance is as great on both sides, and its derivative vanishes, by mpmath."""
    linkage, (pose,) = LINKAGES[seed], random_poses(1, seed=seed + 40)
    t = linkage.nearest_pose(pose).t
    size = mpmath.mpf(float(linkage.chain.lines.length))
    with mpmath.workdps(40):
        C = [[mpmath.mpf(float(x)) for x in c.coeffs] for c in linkage.coupler_motion.coefficients]
        wanted = [mpmath.mpf(float(x)) for x in as_matrix(pose).ravel()]

        def square(t):
            q = [mpmath.polyval([c[n] for c in C], t) for n in range(8)]
            matrix = as_matrix_of(q)
            turned = sum((matrix[r][c] - wanted[4 * r + c]) ** 2 for r in range(3) for c in range(3))
            return sum((matrix[r][3] - wanted[4 * r + 3]) ** 2 for r in range(3)) + size**2 / 3 * turned

        first, second = mpmath.diff(square, t), mpmath.diff(square, t, 2)
        assert second > 0
        assert abs(first / second) < 1e-12 * (1 + t * t)


def as_matrix_of(q):
    """The first three rows of the matrix of a pose, by the usual formulas for quaternions."""
    w, x, y, z, d0, d1, d2, d3 = q
    n = w * w + x * x + y * y + z * z
    return [
        [
            (w * w + x * x - y * y - z * z) / n,
            2 * (x * y - w * z) / n,
            2 * (x * z + w * y) / n,
            2 * (-d0 * x + d1 * w - d2 * z + d3 * y) / n,
        ],
        [
            2 * (x * y + w * z) / n,
            (w * w - x * x + y * y - z * z) / n,
            2 * (y * z - w * x) / n,
            2 * (-d0 * y + d1 * z + d2 * w - d3 * x) / n,
        ],
        [
            2 * (x * z - w * y) / n,
            2 * (y * z + w * x) / n,
            (w * w - x * x - y * y + z * z) / n,
            2 * (-d0 * z - d1 * y + d2 * x + d3 * w) / n,
        ],
    ]


@pytest.mark.parametrize("apart", [1e-1, 1e-2, 1e-4])
def test_a_pose_on_both_sides_of_a_dead_point_has_two_parameters(apart):
    """However near they are: the link behind the joint that swings passes the same pose twice."""
    assert SWINGING.joints[0] == 2
    linkage = Linkage(SWINGING.factors, SWINGING.joints, 1)
    dead = linkage.dead_points(0)[0]
    pose = linkage.coupler_motion(dead + apart)
    found = linkage.parameters_of_pose(pose)
    assert found.shape == (2,)
    assert np.abs(found - (dead + apart)).min() < 1e-8
    assert np.allclose(
        linkage.joint_angles(found)[:, 0] % (2 * np.pi), linkage.joint_angles(dead + apart)[0] % (2 * np.pi)
    )


def test_batches_of_no_linkage_have_no_answers():
    none = goldberg_linkages(*random_poses(3, seed=9, shape=(0,)), 0.4 + 0.7j)[0]
    assert none.parameters_of_pose(1.0 * i).shape == (0, 1)
    assert none.nearest_pose(1.0 * i).t.shape == (0,)
    assert none.collisions().shape == none.clearance().shape == (0,)
    assert none.twist(0.3, 2).shape == (0, 6)


@pytest.mark.parametrize("t", [1e100, -1e151, 1e200, 1e300])
@pytest.mark.parametrize("linkage", [LINKAGES[0], LINKAGES[1], LINKAGES[4]], ids=repr)
def test_parameters_far_out_are_those_of_home(linkage, t):
    home, far = (as_matrix(linkage.link_displacements(x)) for x in (math.inf, t))
    assert np.abs(far - home).max() < 1e-90
    assert np.abs(as_matrix(linkage.coupler_motion(t)) - as_matrix(linkage.home)).max() < 1e-15
    mixed = as_matrix(linkage.coupler_motion(np.array([0.3, t, -t])))
    assert np.allclose(mixed[1:], as_matrix(linkage.home))
    assert np.allclose(linkage.twist(t, 2), linkage.twist(math.inf, 2))
    assert linkage.mobility(t) == linkage.mobility(math.inf)
    assert np.allclose(linkage.coupler_curve([1, 2, 3])(t), act(linkage.home, [1, 2, 3]))
