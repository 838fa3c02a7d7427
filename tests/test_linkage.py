"""Closed chains: closure along the whole motion, links that stay rigid, DH parameters, mobility."""

from __future__ import annotations

import copy
import math
import pickle
from fractions import Fraction
from functools import cache, reduce
from itertools import permutations, product

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from kinlib import (
    DualQuaternion,
    Linkage,
    act,
    as_matrix,
    as_rigid_transform,
    bennett_flip,
    bennett_linkage,
    eps,
    factorizations,
    goldberg_linkages,
    i,
    j,
    k,
    linear_factor,
    null_form,
    one,
    same_point,
    six_r_linkages,
    translation,
)
from kinlib.gallery import FOUR_POSES, THREE_POSES
from kinlib.linkage import verified_loop
from kinlib.testing import assert_closes, assert_same_point, assert_visits, random_poses
from problems import random_displacement

H1, H2 = i, 2 * j - 2 * eps * i
K1, K2 = bennett_flip(H1, H2)

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


def four_bar(h1, h2) -> Linkage:
    """The loop of two half-turns and of their exchange: spherical if they meet, planar if they are parallel."""
    return Linkage.from_chains([h1, h2], bennett_flip(h1, h2))


FOUR_BARS = {
    "spherical": four_bar(i, 2 * j + k),
    "in a plane at home": four_bar(i, 2 * j),
    "planar": four_bar(k, 3 * k + 2 * eps * (i + j)),
    "Bennett": four_bar(i, 2 * j - 2 * eps * i),
    "almost planar Bennett": four_bar(k, 2000 * k + i + eps * (2000 * i - k)),
}


@pytest.mark.parametrize("name", FOUR_BARS)
def test_mobility_is_that_of_the_motion(name):
    """Also where the axes at home have more freedom than the motion has."""
    linkage = FOUR_BARS[name]
    assert linkage.mobility() == linkage.astype(float).mobility() == 1
    assert linkage.mobility(Fraction(1, 3)) == linkage.mobility(0.3) == 1


def flat_six_bars() -> list[Linkage]:
    """6R linkages with all axes in a plane at home, so that all joints turn freely there for an instant."""
    motion = linear_factor(i) * linear_factor(3 * j + eps * k) * linear_factor(i + j - 2 * eps * k)
    six = factorizations(motion)
    return [Linkage.from_chains(six[m], six[n]) for m, n in ((0, 3), (0, 4), (1, 2), (2, 5))]


def test_a_flat_position_has_more_freedom_than_the_motion():
    for linkage in flat_six_bars():
        for one_of_both in (linkage, linkage.astype(float)):
            assert one_of_both.mobility(math.inf) == 3
            assert one_of_both.mobility() == one_of_both.mobility(Fraction(1, 3)) == 1


def test_a_joint_in_common_leaves_two_freedoms():
    """Two chains with the same first factor: its joint and that of the other chain turn as one."""
    h1, h2, h3 = i, 2 * j - 2 * eps * i, 3 * k + eps * j
    loop = Linkage.from_chains([h1, h2, h3], [h1, *bennett_flip(h2, h3)])
    assert loop.mobility() == loop.astype(float).mobility() == 2


def test_a_linkage_from_rounded_numbers_has_the_mobility_of_its_motion():
    """A table with six decimals: the axes alone look rigid, but the loop moves as far as it closes."""
    h1, h2 = 3 * i + eps * k, 2 * j - 2 * eps * i
    factors = [h1, h2, *(h.conjugate() for h in reversed(bennett_flip(h1, h2)))]
    rounded = [DualQuaternion(np.round(f.coeffs.astype(float), 6)) for f in factors]
    with pytest.raises(ValueError, match="rtol="):
        Linkage(rounded, [1] * 4, 2)
    linkage = Linkage(rounded, [1] * 4, 2, rtol=1e-5)
    assert linkage.mobility() == 1
    assert linkage.mobility(0.3) == 0
    assert linkage.mobility(0.3, rtol=1e-5) == 1


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


def exact_linkages() -> dict[str, Linkage]:
    """Linkages of all kinds with axes that are not unit vectors."""
    poses = one, translation([0, 1, 2]) * (1 + 2 * i + k), translation([1, 0, 2]) * (1 - i + 2 * j)
    goldberg = {f"Goldberg {n}": linkage for n, linkage in enumerate(goldberg_linkages(*poses, (1, 2)))}
    bennett = {"Bennett of the poses": bennett_linkage(*poses), "gallery": bennett_linkage(*THREE_POSES)}
    six = {f"flat 6R {n}": linkage for n, linkage in enumerate(flat_six_bars())}
    motion = linear_factor(i) * linear_factor(2 * j - eps * k + 2 * eps * i) * linear_factor(i + 3 * k + eps * j)
    skew = factorizations(motion)
    return {**goldberg, **bennett, **six, **FOUR_BARS, "6R": Linkage.from_chains(skew[0], skew[3])}


EXACT = exact_linkages()


@pytest.mark.parametrize("name", EXACT)
def test_exact_linkages_rebuild_their_loop(name):
    """SciPy's steps along the rows close at every t: the angles at home, and then those of the motion."""
    exact = EXACT[name]
    for linkage in (exact, exact.astype(float)):
        rows = linkage.denavit_hartenberg()
        for t in (math.inf, *TIMES):
            angles = linkage.chain.angles() + linkage.joint_angles(t)
            steps = [dh_step(angle, row) for angle, row in zip(angles, rows, strict=True)]
            assert np.allclose(reduce(np.matmul, steps), np.eye(4), atol=1e-9)


@pytest.mark.parametrize("name", EXACT)
def test_exact_and_float_linkages_say_the_same_about_themselves(name):
    exact, floats = EXACT[name], EXACT[name].astype(float)
    assert np.allclose(exact.denavit_hartenberg(), floats.denavit_hartenberg(), atol=1e-9)
    assert np.allclose(exact.bars(), floats.bars(), atol=1e-9)
    assert exact.mobility() == floats.mobility() == 1
    for t in TIMES:
        assert np.allclose(exact.joint_angles(t), floats.joint_angles(t), atol=1e-9)
    for a, b in ((0, 2), (1, 2), (3, 1), (0, 0), (2, exact.joint_count - 1)):
        exactly, nearly = exact.relative_motion(a, b), floats.relative_motion(a, b)
        assert exactly.degree == nearly.degree
        assert exactly.same_motion(nearly, rtol=1e-7)


def test_offsets_of_an_exact_linkage():
    linkage = EXACT["Goldberg 0"]
    offsets = [row.offset for row in linkage.denavit_hartenberg()]
    assert np.allclose(offsets, [0, 0, -1.9525157, -1.9525157, 0], atol=1e-6)


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


@pytest.mark.parametrize("size", [1e-2, 1e-5])
def test_a_loop_that_does_not_close_is_refused_and_says_by_how_much(size):
    h1, h2 = i.astype(float), 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    for wrong in (k1 + size * k, k1 + size * eps * k):
        with pytest.raises(ValueError, match=r"does not close: .* by [0-9.e-]+ of its size"):
            Linkage.from_chains([h1, h2], [wrong, k2])


@pytest.mark.parametrize("size", [1e-2, 1e-5, 1e-8])
def test_a_residual_is_as_large_as_what_is_wrong(size):
    h1, h2 = i.astype(float), 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    for wrong in (k1 + size * k, k1 + size * eps * k):
        linkage = Linkage.from_chains([h1, h2], [wrong, k2], rtol=1.0)
        assert size / 30 < linkage.closure_residual() < size
        with pytest.raises(AssertionError, match="does not close"):
            assert_closes(linkage)


def test_four_axes_are_no_linkage():
    axes = [i, j - eps * i, k + eps * j, i + j + k + eps * (i - k)]
    for scalars in (int, float):
        with pytest.raises(ValueError, match="does not close"):
            Linkage([h.astype(scalars) for h in axes], (1, 1, 1, 1), 2)


def test_exact_loops_close_exactly_or_not_at_all():
    h1, h2 = i, 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    assert Linkage.from_chains([h1, h2], [k1, k2]).closure_residual() == 0
    for wrong in ([k2, k1], [k1 + eps * k / 10**9, k2], [k1 + eps * k / 10**50, k2]):
        with pytest.raises(ValueError, match="does not close"):
            Linkage.from_chains([h1, h2], wrong, rtol=1.0)


def test_rows_of_a_batch_that_do_not_close_are_named():
    h1, h2 = i.astype(float), 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    wrong = DualQuaternion.stack([k1, k1 + 0.1 * k, k1 * np.nan, k1 + eps * k])
    with pytest.raises(ValueError, match="rows 1, 3: the loop does not close"):
        Linkage.from_chains([h1, h2], [wrong, k2])
    assert Linkage.from_chains([h1, h2], [wrong[::2], k2]).shape == (2,)


def test_a_loop_need_not_be_two_chains_of_one_length():
    h1, h2 = i, 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    for coupler in (1, 3):
        assert Linkage([h1, h2, -k2, -k1], [1] * 4, coupler).closure_residual() == 0
        assert Linkage([f.astype(float) for f in (h1, h2, -k2, -k1)], [1] * 4, coupler).closure_residual() < 1e-15


@pytest.mark.parametrize("size", [1e-3, 1e-6])
@pytest.mark.parametrize(("length", "away"), [(1e-6, 0), (1e6, 0), (1.0, 1e4), (1e-6, 1e4), (1e6, 1e4)])
def test_the_residual_depends_on_no_unit_and_no_origin(size, length, away):
    h1, h2 = i.astype(float), 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)

    def residual(factors):
        return Linkage(factors, [1] * 4, 2, rtol=1.0).closure_residual()

    for wrong in (k1 + size * k, k1 + size * eps * k):
        factors = [h1, h2, -k2, wrong.conjugate()]
        place = translation(length * away * np.array([1.0, 2.0, -1.0]))
        units = [DualQuaternion(f.coeffs * ([1.0] * 4 + [length] * 4)) for f in factors]
        elsewhere = [place * f * place.inverse() for f in units]
        for a, b in ((1.0, 0.0), (1e3, 0.0), (1.0, 10.0), (1e-3, 1.0)):  # t becomes at + b
            assert math.isclose(residual([f * a + b for f in elsewhere]), residual(factors), rel_tol=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_closure_of_the_examples(name):
    assert examples()[name].closure_residual() < 1e-11


# --- shapes and input ----------------------------------------------------------------------------------------------


def test_counts_must_fit():
    for joints in ([2, 1, 1], [0, 1, 2], [1, 1, 1, 1], []):
        with pytest.raises(ValueError, match="expected joints with 3 factors"):
            Linkage([i, j, k], joints, 1)
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


ASKED = {
    "rows": lambda linkage: np.stack([np.stack(row, axis=-1) for row in linkage.denavit_hartenberg()], axis=-1),
    "mobility": lambda linkage: linkage.mobility(),
    "instantaneous mobility": lambda linkage: linkage.mobility(0.3),
    "bars": lambda linkage: linkage.bars(),
    "angles": lambda linkage: linkage.joint_angles(0.3),
    "configuration": lambda linkage: linkage.configuration(0.3).coeffs,
    "links": lambda linkage: linkage.link_displacements(0.3).coeffs,
    "coupler motion": lambda linkage: linkage.coupler_motion(0.3).coeffs,
    "coupler curve": lambda linkage: linkage.coupler_curve([1, 2, 3])(0.3),
    "closure": lambda linkage: linkage.closure_residual(),
    "chain": lambda linkage: linkage.at(0.3).angles(),
    "last": lambda linkage: np.stack([linkage[n].axes.coeffs for n in range(3)]),
}


@pytest.mark.parametrize("question", ASKED)
@pytest.mark.parametrize("name", BATCHES)
def test_a_row_of_nan_stays_a_row(name, question):
    """What a linkage says of the other rows is as without it."""
    linkage = BATCHES[name](random_poses(3, seed=5, shape=(3,)))
    hole = np.array([[False], [True], [False]])
    factors = [DualQuaternion(np.where(hole, np.nan, f.coeffs)) for f in linkage.factors]
    holed = Linkage(factors, linkage.joints, linkage.coupler, linkage.home, linkage.parameters)
    values, expected = np.asarray(ASKED[question](holed)), np.asarray(ASKED[question](linkage))
    assert np.isnan(values[1]).any()
    assert np.allclose(values[[0, 2]], expected[[0, 2]])


@pytest.mark.parametrize("name", BATCHES)
def test_relative_motions_beside_a_row_of_nan(name):
    linkage = BATCHES[name](random_poses(3, seed=5, shape=(3,)))
    hole = np.array([[False], [True], [False]])
    factors = [DualQuaternion(np.where(hole, np.nan, f.coeffs)) for f in linkage.factors]
    holed = Linkage(factors, linkage.joints, linkage.coupler)
    for a, b in product(range(linkage.joint_count), repeat=2):
        motion, expected = holed.relative_motion(a, b), linkage.relative_motion(a, b)
        assert (motion.degree, motion.shape) == (expected.degree, (3,))
        values = motion(0.3).coeffs
        assert np.isnan(values[1]).any()
        assert np.allclose(values[[0, 2]], expected(0.3).coeffs[[0, 2]])


@pytest.mark.parametrize("name", SOME)
def test_a_link_does_not_move_against_itself(name):
    linkage = examples()[name]
    for link in range(linkage.joint_count):
        assert linkage.relative_motion(link, link) == 1
        assert linkage.relative_motion(link, link + linkage.joint_count) == 1  # counted on round the loop


def test_a_batch_has_a_length_and_a_single_linkage_has_not():
    single, batch = examples()["Goldberg 0"], BATCHES["Goldberg"](random_poses(3, seed=5, shape=(2, 3)))
    assert (len(batch), batch.shape, batch.joint_count) == (2, (2, 3), 5)
    assert [entry.shape for entry in batch] == [(3,), (3,)]
    assert (batch[1, 2].shape, batch[..., 0].shape, batch[:1].shape) == ((), (2,), (1, 3))
    assert batch[0].parameters[1].shape == (3,)
    for ask in (len, list, lambda linkage: linkage[0]):
        with pytest.raises(TypeError, match="a single linkage"):
            ask(single)
    with pytest.raises(IndexError):
        batch[0, 0, 0]


def test_home_and_parameters_may_be_the_batch():
    place = translation(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 9]]))
    linkage = Linkage.from_chains([H1, H2], [K1, K2], home=place, parameters=(math.inf, np.array([1.0, 2, 3])))
    assert linkage.shape == (3,)
    assert linkage.axes.shape == (3, 4)
    assert linkage.mobility().tolist() == [1, 1, 1]
    assert linkage[1].parameters == (math.inf, 2.0)
    assert same_point(linkage[1].coupler_motion(math.inf), place[1])
    assert linkage.relative_motion(1, 1).shape == (3,)


def test_a_batch_without_rows():
    linkage = BATCHES["Goldberg"](random_poses(3, seed=5, shape=(2,)))[:0]
    assert (linkage.shape, len(linkage), list(linkage)) == ((0,), 0, [])
    assert linkage.mobility().shape == linkage.closure_residual().shape == (0,)
    assert linkage.bars().shape == (0, 5, 2, 3)
    assert linkage.denavit_hartenberg()[0].distance.shape == (0,)
    assert linkage.joint_angles(0.3).shape == (0, 5)


def test_what_costs_is_computed_once():
    linkage = examples()["6R 0"]
    for name in ("axes", "chain", "coupler_motion"):
        assert getattr(linkage, name) is getattr(linkage, name)
    assert linkage.bars() is linkage.bars()


def test_the_chain_at_home_and_elsewhere():
    linkage = examples()["Goldberg 0"]
    assert np.array_equal(linkage.chain.axes.coeffs, linkage.axes.coeffs)
    assert np.array_equal(linkage.at(0.3).axes.coeffs, linkage.configuration(0.3).coeffs)
    assert linkage.at(np.linspace(-1, 1, 7)).shape == (7,)
    assert np.allclose(linkage.at(0.3).denavit_hartenberg(), linkage.denavit_hartenberg())


def test_a_known_motion_is_kept():
    first, second = (i, 2 * j - 2 * eps * i), bennett_flip(i, 2 * j - 2 * eps * i)
    motion = linear_factor(first[0]) * linear_factor(first[1])
    linkage = verified_loop(first, second, motion=motion)
    assert linkage.coupler_motion is motion
    assert linkage.closure_residual() == 0
    assert Linkage.from_chains(first, second).coupler_motion == motion


def test_a_linkage_is_shown_in_a_line():
    linkage = examples()["Bennett"]
    assert repr(linkage) == "Linkage 4R, coupler 2, poses at t = ∞, 0, 1"
    assert repr(four_bar(i, 2 * j)) == "Linkage 4R, coupler 2"
    goldberg = EXACT["Goldberg 0"]
    assert repr(goldberg) == ("Linkage 5R, joint 1 with 2 factors, coupler 2, poses at t = ∞, -1.42809, -0.428095")
    batch = BATCHES["Goldberg"](random_poses(3, seed=5, shape=(2,)))
    assert repr(batch) == "Linkage 5R of shape (2,), joint 1 with 2 factors, coupler 2, poses at 3 values of t"


def test_a_linkage_is_shown_as_a_table():
    html = EXACT["Goldberg 0"]._repr_html_()
    assert html.count("<tr>") == 6
    assert "<td>-1.95252</td>" in html
    assert "e-1" not in html  # rounding is no offset
    assert "poses at t = ∞, -1.42809, -0.428095" in html
    assert "of shape (2,)" in BATCHES["Bennett"](random_poses(3, seed=5, shape=(2,)))._repr_html_()


def test_rows_of_one_linkage_are_plain_numbers():
    for linkage in (examples()["Goldberg 0"], EXACT["Goldberg 0"]):
        assert {type(x) for row in linkage.denavit_hartenberg() for x in row} == {float}


def test_a_linkage_can_be_kept():
    linkage = examples()["Goldberg 0"]
    for other in (pickle.loads(pickle.dumps(linkage)), copy.deepcopy(linkage)):
        assert other.denavit_hartenberg() == linkage.denavit_hartenberg()
        assert np.array_equal(other.coupler_motion(0.3).coeffs, linkage.coupler_motion(0.3).coeffs)
    assert {linkage: 1}[linkage] == 1
    with pytest.raises(AttributeError):
        linkage.coupler = 1


def test_other_numbers():
    exact = bennett_linkage(*THREE_POSES)
    floats = exact.astype(float)
    assert floats.axes.coeffs.dtype == float
    assert all(isinstance(t, float) for t in floats.parameters)
    assert np.allclose(floats.axes.coeffs, exact.axes.coeffs.astype(float))
    assert_visits(floats, *(pose.astype(float) for pose in THREE_POSES))


def test_home_is_a_pose_of_any_kind():
    h1, h2 = i, 2 * j - 2 * eps * i
    chains = [h1, h2], bennett_flip(h1, h2)
    place = translation([1, 2, 3])
    for home in (place, as_matrix(place), as_rigid_transform(place)):
        assert same_point(Linkage.from_chains(*chains, home=home).coupler_motion(math.inf), place)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Linkage(H1, [1], 1), TypeError, "expected a sequence of dual quaternions"),
        (lambda: Linkage(None, [1], 1), TypeError, "expected a sequence of dual quaternions"),
        (lambda: Linkage([H1, H2, 3, -K1], [1] * 4, 2), TypeError, "expected a dual quaternion f .* got 3"),
        (lambda: Linkage.from_chains([H1, H2], 5), TypeError, "expected a sequence of dual quaternions"),
        (lambda: Linkage.from_chains([H1, 1j * H2], [K1, K2]), ValueError, "expected real factors"),
        (lambda: Linkage.from_chains([H1, DualQuaternion([0, math.inf] + [0] * 6)], [K1, K2]), ValueError, "finite"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], joints=(1, 2, 1)), ValueError, "a joint to end"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], joints=(2, 1, 1)), ValueError, "have one axis"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], joints=(1, 1.0, 1, 1)), TypeError, "whole numbers"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], home=one * 0), ValueError, "exceptional"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], home="here"), TypeError, "expected"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], parameters=3), TypeError, "parameters"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2], parameters=("a",)), TypeError, "expected numbers"),
        (lambda: Linkage([H1, H2, -K2, -K1], 4, 2), TypeError, "joints"),
        (lambda: Linkage([H1, H2, -K2, -K1], [1] * 4, 2.0), TypeError, "whole number"),
        (lambda: Linkage([one, one, one], [1] * 3, 1), ValueError, "no axis"),
        (lambda: four_bar(H1, H2 + eps * j), ValueError, "factor number 1 is no rotation"),
        (lambda: four_bar(H1.astype(float), H2 + 1e-5 * eps), ValueError, r"off by 2.78e-06 of its size \(rtol="),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2]).joint_angles(None), TypeError, "expected numbers"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2]).at("0"), TypeError, "expected numbers"),
        (lambda: Linkage.from_chains([H1, H2], [K1, K2]).relative_motion(0, 1.5), TypeError, "whole numbers"),
    ],
)
def test_what_is_no_linkage_gets_words(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize("away", [1e3, 1e6])
@pytest.mark.parametrize("seed", range(3))
def test_far_from_the_origin_digits_are_lost_only_as_the_distance(seed, away):
    shift = away * np.array([1.0, -0.6, 0.3])
    near = bennett_linkage(*random_poses(3, seed=seed))
    factors = [translation(shift) * f * translation(-shift) for f in near.factors]
    far = Linkage(factors, near.joints, near.coupler, translation(shift) * near.home, near.parameters)
    assert far.mobility() == 1
    assert np.allclose(far.denavit_hartenberg(), near.denavit_hartenberg(), atol=1e-13 * away)
    assert np.allclose(far.joint_angles(0.3), near.joint_angles(0.3))
    assert np.allclose(far.bars() - shift, near.bars(), atol=1e-13 * away)
    assert far.closure_residual() < 1e-14 * away
    for a, b in product(range(4), repeat=2):
        assert far.relative_motion(a, b).degree == near.relative_motion(a, b).degree
