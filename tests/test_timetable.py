"""Laws of motion in time: steady joints, steady points, rests at the poses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kinlib import (
    ConstantPointSpeed,
    ConstantSpeed,
    Linkage,
    RestAtPoses,
    Timetable,
    act,
    as_matrix,
    bennett_linkage,
    goldberg_linkages,
    same_point,
    six_r_linkages,
)
from kinlib.gallery import THREE_POSES
from kinlib.testing import random_poses

THREE = random_poses(3, seed=1)
FIVE = next(x for x in goldberg_linkages(*THREE, 0.4 + 0.9j) if 2 in x.turns())
LINKAGES = [bennett_linkage(*THREE), FIVE, six_r_linkages(*random_poses(4, seed=5))[0], bennett_linkage(*THREE_POSES)]
TIMES = np.linspace(-4.0, 17.0, 211)


def assert_is_a_motion(linkage, table: Timetable) -> None:
    """Angles and poses belong to t, and the angles go on without a jump."""
    floats = linkage.astype(float)
    assert np.abs(np.sin((table.angles - floats.joint_angles(table.t)) / 2)).max() < 1e-9
    steps = np.diff(table.angles, axis=0) * np.sign(table.time[1] - table.time[0])
    assert np.abs(steps).max() < 2 * np.pi
    assert np.all(steps >= -1e-9) or np.all(steps <= 1e-9)  # all these joints turn on
    reached = floats.coupler_motion(table.t)
    assert np.all(same_point(table.poses, reached, rtol=1e-9, length=10))
    assert np.allclose(table.matrices, as_matrix(reached))


@pytest.mark.parametrize("linkage", LINKAGES, ids=repr)
@pytest.mark.parametrize("speed", [0.7, -1.3])
def test_the_driven_joint_turns_steadily_over_whole_motions(linkage, speed):
    for joint in range(linkage.joint_count):
        table = linkage.drive(ConstantSpeed(joint, speed, start=0.5), TIMES)
        assert np.allclose(np.diff(table.angles[:, joint]), speed * np.diff(TIMES), atol=1e-9)
        assert math.isclose(np.interp(0.0, TIMES, table.angles[:, joint]), table.angles[40, joint], abs_tol=1e-12)
        assert math.isclose(table.t[40], 0.5, rel_tol=1e-12)
        assert_is_a_motion(linkage, table)


def test_a_joint_that_turns_twice_drives_one_motion_in_two_rounds():
    joint = FIVE.turns().tolist().index(2)
    table = FIVE.drive(ConstantSpeed(joint, 2 * np.pi), np.array([0.0, 0.25, 1.0, 2.0, 2.25]))
    assert table.t[0] == table.t[3] == math.inf
    assert np.isfinite(table.t[2])
    assert np.all(same_point(table.poses[1], table.poses[4], length=10))


@pytest.mark.parametrize("linkage", LINKAGES[1:3], ids=repr)
def test_a_point_moves_steadily_along_its_path(linkage):
    point, times = np.array([0.4, -0.3, 0.2]), np.linspace(0, 12, 241)
    table = linkage.drive(ConstantPointSpeed(point, speed=1.5, start=0.25), times)
    assert math.isclose(table.t[0], 0.25, rel_tol=1e-9)
    path = act(table.poses, point)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=-1) / (1.5 * times[1])
    assert steps.max() < 1 + 1e-6  # a chord is no longer than its arc
    assert np.median(steps) > 1 - 1e-2
    assert_is_a_motion(linkage, table)
    t = -1 / np.tan(np.linspace(0, np.pi, 50001)[1:-1])
    around = np.linalg.norm(np.diff(act(linkage.astype(float).coupler_motion(t), point), axis=0), axis=-1).sum()
    back = linkage.drive(ConstantPointSpeed(point, speed=around, start=0.25), np.array([0.0, 1.0]))
    assert np.all(same_point(back.poses[0], back.poses[1], rtol=1e-3, length=10))


@pytest.mark.parametrize("linkage", LINKAGES, ids=repr)
def test_the_coupler_rests_at_its_poses_and_moves_between_them_smoothly(linkage):
    law, count = RestAtPoses(move=2.0, rest=1.0, joint=1), len(linkage.parameters)
    for n in range(2 * count + 1):
        at_rest = linkage.drive(law, 3.0 * n + np.array([0.0, 0.4, 1.0]))
        number = linkage.order_of_visits()[n % count]
        expected = linkage.astype(float).coupler_motion(float(linkage.parameters[number]))
        assert np.all(same_point(at_rest.poses, expected, rtol=1e-7, length=10))
        assert np.ptp(at_rest.angles, axis=0).max() < 1e-9
    step = 1e-3
    for edge in (1.0, 3.0, 4.0):
        angles = linkage.drive(law, edge + step * np.arange(-2, 3)).angles[:, 1]
        speed, acceleration = np.gradient(angles, step)[2], np.diff(angles, 2)[1] / step**2
        assert abs(speed) < 1e-4
        assert abs(acceleration) < 0.1
    assert_is_a_motion(linkage, linkage.drive(law, np.linspace(0, 20, 401)))


def test_batches_are_driven_row_by_row():
    linkages = bennett_linkage(*random_poses(3, seed=6, shape=(2, 3)))
    for law in (ConstantSpeed(2, 1.1), ConstantPointSpeed([0.1, 0.2, 0.3]), RestAtPoses()):
        table = linkages.drive(law, [0.0, 0.7, 2.5])
        assert table.t.shape == (2, 3, 3)
        assert table.angles.shape == (2, 3, 3, 4)
        assert table.matrices.shape == (2, 3, 3, 4, 4)
        alone = linkages[1, 2].drive(law, [0.0, 0.7, 2.5])
        assert np.allclose(alone.angles, table.angles[1, 2], atol=1e-8)
        assert np.allclose(alone.matrices, table.matrices[1, 2], atol=1e-8)


def test_what_can_not_drive_is_refused():
    swinging = next(x for x in goldberg_linkages(*THREE, 0.2 - 0.2j) if 0 in x.turns())
    joint = swinging.turns().tolist().index(0)
    with pytest.raises(ValueError, match=rf"joint {joint} turns back at t = .* and can not drive the linkage there"):
        swinging.drive(ConstantSpeed(joint), [0.0])
    linkage = LINKAGES[0]
    foot = np.cross(linkage.axes[0].coeffs[1:4], linkage.axes[0].coeffs[5:])  # on the first axis
    with pytest.raises(ValueError, match="the point stays where it is on the whole motion"):
        Linkage(linkage.factors, linkage.joints, 1).drive(ConstantPointSpeed(foot), [0.0])
    with pytest.raises(ValueError, match="expected a linkage made from poses"):
        Linkage(linkage.factors, linkage.joints, 2).drive(RestAtPoses(), [0.0])
    with pytest.raises(ValueError, match="expected a list of finite times"):
        linkage.drive(ConstantSpeed(), [0.0, math.nan])
