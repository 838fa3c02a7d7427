"""Closed chains: closure along the whole motion, links that stay rigid, DH parameters, mobility."""

from __future__ import annotations

import math
from functools import cache, reduce
from itertools import permutations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Linkage,
    act,
    bennett_flip,
    bennett_linkage,
    eps,
    goldberg_linkages,
    i,
    j,
    k,
    null_form,
    one,
    same_point,
    six_r_linkages,
    translation,
)
from kinlib.gallery import FOUR_POSES, THREE_POSES
from kinlib.testing import assert_closes, assert_same_point, random_poses
from problems import random_displacement

TIMES = (-3.0, -0.4, 0.2, 1.7, 40.0)


@cache
def examples() -> dict[str, Linkage]:
    """One linkage of each kind, from poses in any frame."""
    poses = random_poses(3, seed=2)
    found = {"Bennett": bennett_linkage(*poses)}
    for number, linkage in enumerate(goldberg_linkages(*poses, 0.4 - 0.7j)):
        found[f"Goldberg {number}"] = linkage
    four = [pose.astype(float) * random_displacement(seed=3) for pose in FOUR_POSES]
    for number, linkage in enumerate(six_r_linkages(*four)):
        found[f"6R {number}"] = linkage
    return found


NAMES = ["Bennett", *(f"Goldberg {n}" for n in range(8)), *(f"6R {n}" for n in range(18))]
SOME = ["Bennett", "Goldberg 0", "Goldberg 3", "6R 0", "6R 10"]


def point_and_direction(h: DualQuaternion):
    l, m = h.coeffs[1:4], h.coeffs[5:8]
    return np.cross(l, m) / (l @ l), l / np.linalg.norm(l)


def turn(h: DualQuaternion, angle: float) -> RigidTransform:
    """SciPy's rotation about the axis of h."""
    point, direction = point_and_direction(h)
    there = RigidTransform.from_translation(point)
    return there * RigidTransform.from_rotation(Rotation.from_rotvec(angle * direction)) * there.inv()


def feet(h: DualQuaternion, g: DualQuaternion):
    """The feet of the common perpendicular: the nearest points of two lines, by least squares."""
    (a, l), (b, k) = point_and_direction(h), point_and_direction(g)
    (s, t), *_ = np.linalg.lstsq(np.stack([l, -k], axis=1), b - a, rcond=None)
    return a + s * l, b + t * k


def signed_angle(x, y, axis) -> float:
    return math.atan2(np.cross(x, y) @ axis, x @ y)


def link_shapes(axes) -> np.ndarray:
    """Distance, cosine of the angle and moment of each two neighbouring axes: what a rigid link keeps."""
    shapes = []
    for h, g in zip(axes, [*list(axes)[1:], axes[0]], strict=True):
        (a, l), (b, k) = point_and_direction(h), point_and_direction(g)
        start, end = feet(h, g)
        shapes.append([np.linalg.norm(end - start), l @ k, (b - a) @ np.cross(l, k)])
    return np.array(shapes)


# --- the motion ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_turning_about_the_axes_closes_the_loop(name):
    """SciPy's rotations about the axes by the joint angles have the identity as product."""
    linkage = examples()[name]
    axes = list(linkage.axes)
    for t in TIMES:
        angles = linkage.joint_angles(t)
        around = reduce(lambda x, y: x * y, [turn(h, angle) for h, angle in zip(axes, angles, strict=True)])
        assert np.allclose(around.as_matrix(), np.eye(4), atol=1e-8 * np.abs(linkage.axes.coeffs).max())


@pytest.mark.parametrize("name", NAMES)
def test_axes_move_with_their_links(name):
    """Second source: each axis carried along by the rotations before it."""
    linkage = examples()[name]
    axes = list(linkage.axes)
    for t in TIMES[1:4]:
        carried, link = linkage.configuration(t), RigidTransform.identity()
        for n, angle in enumerate(linkage.joint_angles(t)):
            point, direction = point_and_direction(axes[n])
            moved, turned = link.apply(point), link.rotation.apply(direction)
            l, m = carried[n].coeffs[1:4], carried[n].coeffs[5:8]
            assert np.allclose(l, turned, atol=1e-8)
            assert np.allclose(m, np.cross(moved, turned), atol=1e-7)
            link = link * turn(axes[n], angle)


@pytest.mark.parametrize("name", NAMES)
def test_links_are_rigid(name):
    linkage = examples()[name]
    shapes = link_shapes(linkage.axes)
    for t in TIMES:
        assert np.allclose(link_shapes(linkage.configuration(t)), shapes, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_the_linkage_does_move(name):
    linkage = examples()[name]
    ends = linkage.configuration(0.2), linkage.configuration(1.7)
    assert not np.any(same_point(*ends)[1:-1])
    assert np.all(same_point(*ends)[[0, -1]])  # the two axes of the base stand still


@pytest.mark.parametrize("name", NAMES)
def test_mobility_is_one(name):
    linkage = examples()[name]
    assert linkage.mobility() == linkage.mobility(0.3) == 1
    plucker = linkage.configuration(0.3).coeffs[:, [1, 2, 3, 5, 6, 7]]
    singular = np.linalg.svd(plucker, compute_uv=False)
    rank = linkage.joint_count - 1
    assert singular[rank:].max(initial=0) < 1e-6 * singular[0]
    assert singular[rank - 1] > 1e-6 * singular[0]


@pytest.mark.parametrize(
    ("axes", "mobility"),
    [
        ([i, j, k, i + j + k, 2 * i - j], 2),  # through one point: rank three
        ([k, k + eps * i, k + eps * j, k + eps * (i + j)], 1),  # parallel: rank three
        ([i, j - eps * i, k + eps * j, i + j + k + eps * (i - k)], 0),  # four skew lines: rank four
        ([i, i, i, i], 3),
    ],
)
def test_mobility_of_axes_in_special_position(axes, mobility):
    linkage = Linkage(axes, [1] * len(axes), 2)
    assert linkage.mobility() == mobility
    assert Linkage([h.astype(float) for h in axes], [1] * len(axes), 2).mobility() == mobility


@pytest.mark.parametrize("shift", [[0, 0, 0], [1e4, -3e4, 2e4]])
@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])
def test_mobility_and_closure_do_not_depend_on_place_or_size(length, shift):
    place = translation(length * np.array(shift))
    poses = [place * pose for pose in random_poses(3, seed=4, length=length)]
    linkage = bennett_linkage(*poses)
    assert linkage.mobility() == 1
    assert linkage.closure_residual() < 1e-9


# --- angles --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SOME)
def test_angles_start_at_zero_and_end_after_whole_rounds(name):
    linkage = examples()[name]
    assert np.all(linkage.joint_angles(math.inf) == 0)
    rounds = linkage.joint_angles(-math.inf) / (2 * math.pi)
    expected = np.array([1 if count == 1 else 0 for count in linkage.joints])
    assert np.allclose(rounds, np.round(rounds))
    assert np.all((np.abs(rounds) == expected) | (np.array(linkage.joints) == 2))


@pytest.mark.parametrize("name", SOME)
def test_angles_are_continuous(name):
    linkage = examples()[name]
    t = np.tan(np.linspace(-np.pi / 2, np.pi / 2, 40001)[1:-1])
    assert np.abs(np.diff(linkage.joint_angles(t), axis=0)).max() < 0.1


def test_the_angle_of_a_half_turn_is_that_of_the_factor():
    """t − h turns by −2 arccot t."""
    linkage = examples()["Bennett"]
    f, axis = linkage.factors[0], linkage.axes[0]
    for t in TIMES:
        angle = linkage.joint_angles(t)[0]
        assert_same_point(t - f, np.cos(angle / 2) + np.sin(angle / 2) * axis)


# --- DH parameters -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_denavit_hartenberg_against_direct_coordinates(name):
    linkage = examples()[name]
    axes, count = list(linkage.axes), linkage.joint_count
    for n, row in enumerate(linkage.denavit_hartenberg()):
        before, this, after = axes[n - 1], axes[n], axes[(n + 1) % count]
        start, end = feet(this, after)
        assert np.isclose(row.distance, np.linalg.norm(end - start), rtol=1e-8, atol=1e-8)
        (_, l), (_, k) = point_and_direction(this), point_and_direction(after)
        assert np.isclose(row.twist, signed_angle(l, k, (end - start) / np.linalg.norm(end - start)), atol=1e-8)
        assert np.isclose(row.offset, (start - feet(before, this)[1]) @ l, atol=1e-7)


def dh_step(angle: float, row) -> np.ndarray:
    """Turn about z and shift along z, then shift along x and turn about x."""
    z = RigidTransform.from_components([0, 0, row.offset], Rotation.from_rotvec([0, 0, angle]))
    x = RigidTransform.from_components([row.distance, 0, 0], Rotation.from_rotvec([row.twist, 0, 0]))
    return (z * x).as_matrix()


@pytest.mark.parametrize("name", NAMES)
def test_denavit_hartenberg_rows_and_joint_angles_close_the_loop(name):
    linkage = examples()[name]
    axes, count = list(linkage.axes), linkage.joint_count
    normals = [np.subtract(*feet(axes[n], axes[(n + 1) % count])[::-1]) for n in range(count)]
    directions = [point_and_direction(h)[1] for h in axes]
    rest = [signed_angle(normals[n - 1], normals[n], directions[n]) for n in range(count)]
    for t in (math.inf, *TIMES):
        angles = np.array(rest) + linkage.joint_angles(t)
        steps = [dh_step(angle, row) for angle, row in zip(angles, linkage.denavit_hartenberg(), strict=True)]
        assert np.allclose(reduce(np.matmul, steps), np.eye(4), atol=1e-6)


def test_intersecting_axes_have_distance_zero_and_no_undefined_twist():
    linkage = Linkage([i, j, k + eps * i, i + j], [1] * 4, 2)
    first = linkage.denavit_hartenberg()[0]
    assert first.distance == 0
    assert np.isclose(first.twist, math.pi / 2)


def test_parallel_neighbours_have_no_common_perpendicular():
    linkage = Linkage([k, k + eps * i, j, i], [1] * 4, 2)
    with pytest.raises(DegenerateError, match="parallel"):
        linkage.denavit_hartenberg()


def test_exact_linkages_have_float_parameters():
    exact = bennett_linkage(*THREE_POSES)
    floats = bennett_linkage(*(pose.astype(float) for pose in THREE_POSES))
    table = {tuple(np.round(np.abs(row[:2]), 9)) for row in exact.denavit_hartenberg()}
    assert table == {tuple(np.round(np.abs(row[:2]), 9)) for row in floats.denavit_hartenberg()}


# --- links and couplers --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SOME)
def test_relative_motions_compose(name):
    linkage = examples()[name]
    for t in TIMES[1:4]:
        links = linkage.link_displacements(t)
        for a, b in permutations(range(linkage.joint_count), 2):
            seen = links[a].inverse() * links[b]
            assert_same_point(linkage.relative_motion(a, b)(t), seen, rtol=1e-6)
    assert linkage.relative_motion(1, 1) == 1


@pytest.mark.parametrize("name", NAMES)
def test_relative_motions_are_inverse_to_each_other(name):
    linkage = examples()[name]
    for a, b in permutations(range(linkage.joint_count), 2):
        forth, back = linkage.relative_motion(a, b), linkage.relative_motion(b, a)
        assert forth.degree == back.degree
        assert forth.same_motion(back.conjugate(), rtol=1e-6)


@pytest.mark.parametrize("name", SOME)
def test_neighbours_turn_about_their_joint(name):
    linkage = examples()[name]
    for n in range(linkage.joint_count):
        motion = linkage.relative_motion(n, (n + 1) % linkage.joint_count)
        assert motion.degree == linkage.joints[n]
        line = motion(0.7).coeffs[[1, 2, 3, 5, 6, 7]]
        assert same_point(line, linkage.axes[n].coeffs[[1, 2, 3, 5, 6, 7]])


@pytest.mark.parametrize("name", SOME)
def test_the_coupler_is_a_link(name):
    linkage = examples()[name]
    motion = linkage.relative_motion(0, linkage.coupler) * linkage.home
    assert linkage.coupler_motion.same_motion(motion)
    assert 0 < linkage.coupler < linkage.joint_count


@pytest.mark.parametrize("name", SOME)
def test_coupler_curves_are_paths_of_points(name):
    linkage = examples()[name]
    point = np.array([0.3, -1.0, 2.0])
    curve = linkage.coupler_curve(point)
    for t in (math.inf, *TIMES):
        assert np.allclose(curve(t), act(linkage.coupler_motion(t), point), atol=1e-8)


def test_exact_linkages_move_exactly():
    linkage = bennett_linkage(*THREE_POSES)
    for t in (0, 1, 5):
        links = linkage.link_displacements(t)
        back = links[-1] * (t - linkage.factors[-1])
        assert same_point(back, one)
        assert all(h.norm().dual == 0 and null_form(h, h) == 1 for h in linkage.configuration(t))


# --- closure -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-2, 1e-5, 1e-8])
def test_a_loop_that_does_not_close_says_by_how_much(size):
    h1, h2 = i.astype(float), 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    for wrong in (k1 + size * k, k1 + size * eps * k):
        residual = Linkage.from_chains([h1, h2], [wrong, k2]).closure_residual()
        assert size / 30 < residual < size
        with pytest.raises(AssertionError, match="does not close"):
            assert_closes(Linkage.from_chains([h1, h2], [wrong, k2]))


def test_an_exact_loop_that_does_not_close_is_not_called_closed():
    h1, h2 = i, 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    assert Linkage.from_chains([h1, h2], [k1, k2]).closure_residual() == 0
    assert Linkage.from_chains([h1, h2], [k2, k1]).closure_residual() > 0.1
    assert Linkage.from_chains([h1, h2], [k1 + eps * k / 10**9, k2]).closure_residual() > 0


@pytest.mark.parametrize("name", NAMES)
def test_closure_of_the_examples(name):
    assert examples()[name].closure_residual() < 1e-11


# --- shapes and input ----------------------------------------------------------------------------------------------


def test_counts_must_fit():
    with pytest.raises(ValueError, match="expected 4 factors for joints"):
        Linkage([i, j, k], [2, 1, 1], 1)
    for coupler in (0, 3, -1):
        with pytest.raises(ValueError, match="coupler among links"):
            Linkage([i, j, k], [1, 1, 1], coupler)


def test_the_number_of_joints_is_the_length():
    assert [examples()[name].joint_count for name in SOME] == [4, 5, 5, 6, 6]
    assert all(linkage.axes.shape == (linkage.joint_count,) for linkage in examples().values())


BATCHES = {
    "Bennett": lambda poses: bennett_linkage(*poses),
    "Goldberg": lambda poses: goldberg_linkages(*poses, 0.4 - 0.7j)[1],
    "mirrored Goldberg": lambda poses: goldberg_linkages(*poses, 0.4 - 0.7j)[6],
}


@pytest.mark.parametrize("shape", [(3,), (2, 3)])
@pytest.mark.parametrize("name", BATCHES)
def test_a_batch_is_the_loop_of_its_rows(name, shape):
    poses = random_poses(3, seed=5, shape=shape)
    together, point = BATCHES[name](poses), np.array([1.0, 2.0, -1.0])
    count = together.joint_count
    assert together.shape == shape
    for index in np.ndindex(shape):
        single = BATCHES[name]([pose[index] for pose in poses])
        assert np.allclose(together.axes.coeffs[index], single.axes.coeffs)
        assert np.allclose(together[index].axes.coeffs, single.axes.coeffs)
        for t in (math.inf, 0.6):
            assert np.allclose(together.configuration(t).coeffs[index], single.configuration(t).coeffs)
            assert np.allclose(together.link_displacements(t).coeffs[index], single.link_displacements(t).coeffs)
            assert np.allclose(together.joint_angles(t)[index], single.joint_angles(t))
            assert np.allclose(together.coupler_motion(t).coeffs[index], single.coupler_motion(t).coeffs)
            assert np.allclose(together.coupler_curve(point)(t)[index], single.coupler_curve(point)(t))
        for row, other in zip(together.denavit_hartenberg(), single.denavit_hartenberg(), strict=True):
            assert np.allclose([part[index] for part in row], other)
        assert together.mobility()[index] == 1
        assert together.closure_residual()[index] < 1e-12
        assert_same_point(together.relative_motion(0, 2)(0.6)[index], single.relative_motion(0, 2)(0.6))
    times = np.linspace(-1, 1, 4).reshape(4, *[1] * len(shape))
    assert together.joint_angles(times).shape == (4, *shape, count)
    assert together.configuration(times).shape == (4, *shape, count)


def test_an_exact_batch_keeps_its_exactness():
    poses = [DualQuaternion.stack([pose, pose * (1 + k)]) for pose in THREE_POSES]
    linkage = bennett_linkage(*poses)
    assert linkage.closure_residual().tolist() == [0, 0]
    assert linkage.mobility().tolist() == [1, 1]
    assert not any(isinstance(x, float) for x in linkage.axes.coeffs.ravel())


@pytest.mark.parametrize("name", SOME)
def test_many_parameters_at_once(name):
    linkage, times = examples()[name], np.array([0.1, 0.5, math.inf, 2.0])
    for method in (linkage.configuration, linkage.link_displacements, linkage.coupler_motion):
        together = method(times).coeffs
        assert np.allclose(together, [method(t).coeffs for t in times])
    assert np.allclose(linkage.joint_angles(times), [linkage.joint_angles(t) for t in times])
