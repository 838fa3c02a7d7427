"""Laws of dyads, linkages and synthesis, tried on all shapes, forms, frames, units and representatives."""

import math
from fractions import Fraction

import numpy as np
import pytest

from kinlib import (
    ConstantPointSpeed,
    ConstantSpeed,
    DegenerateError,
    DualQuaternion,
    Dyad,
    Linkage,
    RestAtPoses,
    act,
    as_matrix,
    as_rigid_transform,
    axis_of,
    bennett_linkage,
    conic_through,
    cubics_through,
    dyads_through_poses,
    eps,
    fourth_parameters,
    goldberg_linkages,
    i,
    j,
    k,
    linear_factor,
    one,
    primal_coordinates,
    recognise,
    same_point,
    six_r_linkages,
    study_eigenvalues,
    study_projection,
    unit,
    z_planes,
)  # fmt: skip
from kinlib.gallery import FOUR_POSES, LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.testing import random_poses
from laws import (
    COVERED,
    REAL,
    SHAPES,
    Draw,
    arrays_of,
    assert_same,
    assert_same_linkages,
    assert_same_numbers,
    assert_same_poses,
    assert_zero,
    law,
    row_of,
)  # fmt: skip

# --- dyads ------------------------------------------------------------------------------------------------------


@law("Dyad", "TwoRSpace", kinds=("float", "fraction"), dyad="dyad", s="scalar", t="scalar")
def test_a_dyad_knows_its_own_poses(dyad, s, t):
    pose = dyad(s, t)
    assert_same(list(dyad.parameters(pose)), [s, t], rtol=1e-6)
    assert np.all(dyad.space().contains(pose))
    assert dyad.shape == pose.shape


@law("Dyad", kinds=("float", "fraction"), dyad="dyad")
def test_the_home_of_a_dyad_is_at_infinity(dyad):
    for t in dyad.parameters(dyad.home):
        assert np.all(np.abs(np.asarray(t, dtype=float)) > 1e12)


@law("Dyad", kinds=("float",), shapes=((),), dyad="dyad", pose="pose")
def test_a_dyad_refuses_a_pose_that_it_does_not_reach(dyad, pose):
    with pytest.raises(DegenerateError, match=r"miss|reach|contain"):
        dyad.parameters(pose)


@law("Dyad", kinds=("float",), shapes=((),), dyad="dyad", s="scalar", t="scalar")
def test_a_dyad_takes_poses_of_any_form(dyad, s, t):
    pose = dyad(s, t)
    for form in (as_matrix(pose), as_rigid_transform(pose)):
        assert_same(list(dyad.parameters(form)), [s, t], rtol=1e-6)
        assert form in dyad.space()


@law(
    "recognise", "Dyad", "TwoRSpace", kinds=("float", "fraction"), shapes=((),), h="half_turn", g="half_turn", q="pose"
)
def test_recognise_finds_the_dyad_of_a_space(h, g, q):
    found = recognise(Dyad(h, g).space())
    assert_same_poses(found.h1, h, rtol=1e-6)
    assert_same_poses(found.h2, g, rtol=1e-6)


@law("Dyad", "Line", kinds=("float",), dyad="dyad", s="scalar", t="scalar")
def test_a_dyad_turns_about_its_axes(dyad, s, t):
    foot = dyad.axes[0].foot()
    assert_same(act(dyad(s, math.inf), act(dyad.home.inverse(), foot)), foot, rtol=1e-7)


@law("primal_coordinates", "Dyad", kinds=REAL, h="half_turn", g="half_turn", q="dual_quaternion")
def test_primal_coordinates_are_coordinates(h, g, q):
    x0, x1, x2, x3 = primal_coordinates(q, h, g)
    assert_same((one * x0 + h * x1 + g * x2 + h * g * x3).primal, q.primal, rtol=1e-6)


# --- linkages ---------------------------------------------------------------------------------------------------


def _synthesised(shape=()):
    return bennett_linkage(*random_poses(3, seed=3, shape=shape))


COVERED.update(("Linkage", "DHRow", "DegenerateError", "Bond"))


@pytest.mark.parametrize("shape", SHAPES)
def test_axes_give_the_motion_back_and_bonds_the_degrees(shape):
    poses = random_poses(3, seed=3, shape=shape)
    for linkage in (bennett_linkage(*poses), goldberg_linkages(*poses, 0.4 + 0.7j)[0]):
        found = Linkage.from_axes(linkage.axes)
        assert (found.shape, found.joints) == (linkage.shape, linkage.joints)
        assert np.all(found.closure_residual() < 1e-9)
        assert [bond.joints for bond in found.bonds()] == [bond.joints for bond in linkage.bonds()]
        assert all(bond.quadratic.shape == (*shape, 3) for bond in found.bonds())
        degrees = [found.relative_motion(0, n).degree for n in range(found.joint_count)]
        assert found.degrees()[0].tolist() == degrees


@pytest.mark.parametrize("shape", SHAPES)
def test_a_loop_stays_closed_and_joined(shape):
    linkage = _synthesised(shape)
    assert np.all(linkage.closure_residual() < 1e-9)
    assert linkage.shape == shape
    links = linkage.link_displacements(0.3)
    assert links.shape == (*shape, 4)
    assert linkage.configuration(0.3).shape == (*shape, 4)
    assert linkage.joint_angles(0.3).shape == (*shape, 4)
    assert np.all(np.asarray(linkage.mobility()) == 1)
    relative = linkage.relative_motion(0, linkage.coupler)
    reached = relative(0.3) if not shape else relative(np.full(shape, 0.3))
    motion = linkage.coupler_motion(0.3) if not shape else linkage.coupler_motion(np.full(shape, 0.3))
    assert_same_poses(reached * linkage.home, motion, rtol=1e-7)


@pytest.mark.parametrize("shape", SHAPES)
def test_denavit_hartenberg_rows_do_not_depend_on_the_frame(shape):
    poses = random_poses(3, seed=4, shape=shape)
    (frame,) = random_poses(1, seed=5)
    rows = bennett_linkage(*poses).denavit_hartenberg()
    moved = bennett_linkage(*[frame * p for p in poses]).denavit_hartenberg()
    assert len(rows) == 4
    for a, b in zip(rows, moved, strict=True):
        assert_same([a.distance, a.twist], [b.distance, b.twist], rtol=1e-6)
        assert_zero([a.offset, b.offset], 10)


@pytest.mark.parametrize("shape", [(1,), (3, 1, 2)])
def test_length_index_and_iteration_of_linkages_mean_the_batch(shape):
    linkage = _synthesised(shape)
    assert len(linkage) == shape[0]
    assert [part.shape for part in linkage] == [shape[1:]] * shape[0]
    assert linkage.joint_count == 4


def test_a_linkage_that_does_not_close_cannot_be_made():
    with pytest.raises(ValueError, match="clos"):
        Linkage((i, j - eps * i, k + eps * j, i + eps * k), (1, 1, 1, 1), 2)


COVERED.update(("Collision", "CollisionFault", "Collisions"))


@pytest.mark.parametrize("shape", SHAPES)
def test_bars_that_meet_have_no_clearance(shape):
    linkage = _synthesised(shape)
    hits = linkage.collisions()
    assert hits.shape == np.shape(hits.count) == shape
    assert hits.point.shape == (*hits.t.shape, 3)
    assert hits.links.shape == (*hits.t.shape, 2)
    assert np.all((linkage.clearance() == 0) == (np.asarray(hits.count) > 0))


COVERED.update(("NearestPose", "ConstantSpeed", "ConstantPointSpeed", "RestAtPoses", "Timetable"))


@pytest.mark.parametrize("shape", SHAPES)
def test_parameters_angles_and_poses_belong_together(shape):
    linkage = _synthesised(shape)
    t = np.broadcast_to(np.array(0.3), shape)[()]
    found = linkage.parameters_of_pose(linkage.coupler_motion(t))
    assert found.shape == linkage.parameter_of(1.0, 2).shape == (*shape, 1)
    assert_same_numbers(found[..., 0], t)
    assert_same_numbers(linkage.parameter_of(linkage.joint_angles(t)[..., 2], 2)[..., 0], t)
    nearest = linkage.nearest_pose(linkage.coupler_motion(t))
    assert np.shape(nearest.t) == np.shape(nearest.shift) == shape
    assert linkage.twist(t, 2).shape == (*shape, 6)
    assert linkage.joint_rates(t).shape == linkage.turns().shape == (*shape, 4)
    assert linkage.joint_ranges().shape == (*shape, 4, 2)
    assert linkage.order_of_visits().shape == (*shape, 3)
    assert linkage.dead_points(1).shape == (*shape, 0)
    for pace in (ConstantSpeed(), ConstantPointSpeed([1, 2, 3]), RestAtPoses()):
        table = linkage.drive(pace, [0.0, 0.5])
        assert table.t.shape == table.poses.shape == (*shape, 2)
        assert table.angles.shape == (*shape, 2, 4)


COVERED.add("Families")


@pytest.mark.parametrize("shape", SHAPES)
def test_families_say_when_they_are_in_which_pose(shape):
    poses = random_poses(4, seed=4, shape=shape)
    cubics = cubics_through(*poses, degenerate="nan")
    for cubic, parameters in zip(cubics, cubics.parameters, strict=True):
        for t, pose in zip(parameters, poses, strict=True):
            reached = cubic(np.asarray(t, dtype=float)[()])
            there = np.isfinite(reached.coeffs).all(-1)
            assert np.all(same_point(reached, pose, rtol=1e-6) | ~there)


@pytest.mark.parametrize("function", [dyads_through_poses, bennett_linkage])
def test_errors_name_the_rows(function):
    poses = random_poses(3, seed=6, shape=(4,))
    spoiled = DualQuaternion.stack([poses[0][n] if n in (1, 3) else poses[1][n] for n in range(4)])
    with pytest.raises(DegenerateError) as caught:
        function(poses[0], spoiled, poses[2])
    assert caught.value.rows == (1, 3)
    assert "equal" in str(caught.value)


# --- synthesis: what all of it keeps to --------------------------------------------------------------------------


def _dyads(poses, **options):
    return dyads_through_poses(*poses[:3], **options)


def _bennett(poses, **options):
    return (bennett_linkage(*poses[:3], **options),)


def _goldberg(poses, z=0.4 + 0.7j, **options):
    return goldberg_linkages(*poses[:3], z, **options)


def _six_r(poses, **options):
    return six_r_linkages(*poses, **options)


SYNTHESES = [_dyads, _bennett, _goldberg, _six_r]
COVERED.update(
    ("dyads_through_poses", "bennett_linkage", "goldberg_linkages", "six_r_linkages", "conic_through", "cubics_through")
)
synthesis = pytest.mark.parametrize("build", SYNTHESES, ids=lambda build: build.__name__.strip("_"))


def four(seed: int = 1, shape=(), **options) -> list[DualQuaternion]:
    """Four poses with real families of cubics (of which three may be used), each row the same kind of problem."""
    return random_poses(4, seed=seed, shape=shape, **options)


def moved(result, q: DualQuaternion, g: DualQuaternion):
    """The same dyads and linkages, seen after a change q of the fixed and g of the moving frame."""
    back = q.inverse()
    if isinstance(result, Dyad):
        return Dyad(axis_of(q * result.h1 * back), axis_of(q * result.h2 * back), q * result.home * g)
    factors = [q * f * back for f in result.factors]
    return Linkage(factors, result.joints, result.coupler, q * result.home * g, result.parameters)


@synthesis
def test_frames_change_linkages_with_them(build):
    poses = four()
    q, g = random_poses(2, seed=9)
    expected = [moved(part, q, g) for part in build(poses)]
    assert_same_linkages(build([q * p * g for p in poses]), expected)


@synthesis
@pytest.mark.parametrize("power", [-12, -5, 3, 12])
@pytest.mark.parametrize("which", range(3))
def test_representatives_do_not_matter(build, power, which):
    poses = four()
    scaled = [p * (-(10.0**power)) if n == which else p for n, p in enumerate(poses)]
    assert_same_linkages(build(scaled), build(poses))


@synthesis
def test_the_form_of_the_poses_does_not_matter(build):
    poses = four()
    expected = build(poses)
    assert_same_linkages(build([as_matrix(p) for p in poses]), expected)
    assert_same_linkages(build([as_rigid_transform(p) for p in poses]), expected)


@synthesis
@pytest.mark.parametrize("length", [1e-6, 1e-3, 1e3, 1e6])
def test_the_unit_of_length_does_not_matter(build, length):
    poses = four()
    stretched = [DualQuaternion(p.coeffs * np.array([1] * 4 + [length] * 4)) for p in poses]
    scale = np.array([1] * 4 + [length] * 4)

    def stretch(q):
        return DualQuaternion(q.coeffs * scale)

    expected = []
    for part in build(poses):
        if isinstance(part, Dyad):
            expected.append(Dyad(stretch(part.h1), stretch(part.h2), stretch(part.home)))
        else:
            factors = [stretch(f) for f in part.factors]
            expected.append(Linkage(factors, part.joints, part.coupler, stretch(part.home), part.parameters))
    assert_same_linkages(build(stretched), expected, length=length)


@synthesis
@pytest.mark.parametrize("shape", [(1,), (3, 1, 2)])
def test_a_batch_is_synthesised_row_by_row(build, shape):
    row_poses = four()
    q = Draw("float", shape, seed=3).pose()
    q = unit(q)
    poses = [q * p for p in row_poses]
    together = build(poses)
    for index in np.ndindex(*shape):
        alone = build([p[index] for p in poses])
        assert len(alone) == len(together)
        for a, b in zip(alone, together, strict=True):
            for x, y in zip([x for x, _ in arrays_of(a)], row_of(b, shape, index), strict=True):
                assert_same_numbers(x, y, rtol=1e-7)


@synthesis
def test_single_poses_and_batches_broadcast(build):
    poses = four()
    batch = DualQuaternion.stack([poses[1], random_poses(1, seed=77)[0] * 0.01 + poses[1]], axis=0)
    batch = study_projection(batch)
    together = build([poses[0], batch, *poses[2:]])
    alone = build([poses[0], poses[1], *poses[2:]])
    for a, b in zip(alone, together, strict=True):
        for x, y in zip([x for x, _ in arrays_of(a)], row_of(b, (2,), (0,)), strict=True):
            assert_same_numbers(x, y, rtol=1e-7)


@synthesis
def test_a_nan_row_or_a_degenerate_row_stays_a_row(build):
    poses = [one * 1.0 * p for p in four()]
    rows = [DualQuaternion.stack([p] * 3) for p in poses]
    rows[1] = DualQuaternion.stack([poses[1], poses[0], DualQuaternion(np.full(8, np.nan))])
    with np.errstate(all="ignore"):
        together = build(rows, degenerate="nan")
    alone = build(poses)
    for a, b in zip(alone, together, strict=True):
        for x, y in zip([x for x, _ in arrays_of(a)], row_of(b, (3,), (0,)), strict=True):
            assert_same_numbers(x, y, rtol=1e-7)
        for bad in (1, 2):
            assert np.isnan(np.concatenate([np.ravel(x) for x in row_of(b, (3,), (bad,))])).any()


def test_exchanging_poses_reverses_half_turns_and_order():
    p0, p1, p2 = four()[:3]
    first, second = dyads_through_poses(p0, p1, p2)
    reversed_pair = [Dyad(-dyad.h1, -dyad.h2, dyad.home) for dyad in (second, first)]
    assert_same_linkages(dyads_through_poses(p0, p2, p1), reversed_pair)


# --- the plane of z ---------------------------------------------------------------------------------------------

COVERED.update(("ZPlane", "z_planes", "ZFault"))


@pytest.mark.parametrize("shape", SHAPES)
def test_partners_are_mutual_and_the_linkages_are_goldbergs(shape):
    poses = random_poses(3, seed=8, shape=shape)
    z = np.full(shape, 0.4 + 0.7j)[()]
    planes = z_planes(*poses)
    linkages = [linkage for plane in planes for linkage in plane.linkages(z)]
    assert_same_linkages(linkages, goldberg_linkages(*poses, z))
    for plane in planes:
        assert_same(plane.partner(plane.partner(z)), z, rtol=1e-6)
        first, *others = plane.chains(z)
        cubic = _product(first)
        for chain in others:
            assert_same(_product(chain), cubic, rtol=1e-6)


def _product(factors):
    total = linear_factor(factors[0])
    for h in factors[1:]:
        total = total * linear_factor(h)
    return total


def test_the_plane_of_z_is_the_same_in_all_frames_and_units():
    poses = random_poses(3, seed=8)
    q, g = random_poses(2, seed=9)
    seen = [DualQuaternion((q * p * g).coeffs * np.array([1] * 4 + [1e3] * 4)) for p in poses]
    for plane, other in zip(z_planes(*poses), z_planes(*seen), strict=True):
        assert_same([x for corner in plane.corners for x in corner], [x for c in other.corners for x in c], rtol=1e-7)
        assert_same(plane.partner(1 + 2j), other.partner(1 + 2j), rtol=1e-7)


def test_exact_planes_are_those_in_floats():
    exact, floats = z_planes(*THREE_POSES), z_planes(*[p.astype(float) for p in THREE_POSES])
    for plane, other in zip(exact, floats, strict=True):
        assert_same_numbers(np.array(plane.partner((1, 3)), dtype=float), np.array(other.partner((1, 3)), dtype=float))


@pytest.mark.parametrize("poses", [THREE_POSES, LINEAR_TERMS_EQUAL], ids=["rational", "equal linear terms"])
@pytest.mark.parametrize("build", SYNTHESES[:2], ids=["dyads", "bennett"])
def test_exact_poses_give_the_same_in_the_same_order(build, poses):
    exact = build(poses)
    floats = build([p.astype(float) for p in poses])
    for a, b in zip(exact, floats, strict=True):
        if isinstance(a, Dyad):
            assert_same_linkages([Dyad(unit(a.h1.astype(float)), unit(a.h2.astype(float)), a.home)], [b])
        else:
            assert_same_linkages([a], [b])


def test_exact_goldberg_linkages_are_those_in_floats():
    exact = goldberg_linkages(*THREE_POSES, (1, Fraction(2, 3)))
    assert_same_linkages(exact, goldberg_linkages(*[p.astype(float) for p in THREE_POSES], (1, Fraction(2, 3))))
    assert_same_linkages(exact, goldberg_linkages(*THREE_POSES, 1 + 2j / 3))


def test_exact_cubics_are_those_in_floats():
    exact, floats = cubics_through(*FOUR_POSES), cubics_through(*[p.astype(float) for p in FOUR_POSES])
    assert len(exact) == len(floats) == 2
    for C, D in zip(exact, floats, strict=True):
        assert C.same_motion(D)


@law("conic_through", kinds=("float", "fraction"), p="pose", q="pose", r="pose")
def test_conics_pass_through_their_poses(p, q, r):
    C = conic_through(p, q, r)
    for t, pose in ((math.inf, p), (0, q), (1, r)):
        assert_same_poses(C(t), pose, rtol=1e-7)
    assert np.all(C.is_motion(rtol=1e-7))


def test_cubics_pass_through_their_poses():
    poses = four()
    for C in cubics_through(*poses, free=0.3):
        for t, pose in ((math.inf, poses[0]), (0, poses[1]), (1, poses[2])):
            assert_same_poses(C(t), pose)
        assert C.is_motion()


def test_cubics_reach_the_fourth_pose_at_its_parameter():
    for poses in (four(), list(FOUR_POSES)):
        for C, t in zip(cubics_through(*poses), fourth_parameters(*poses), strict=True):
            assert_same_poses(C(t), poses[3], rtol=1e-7)


COVERED.update(("fourth_parameters", "ADMISSIBLE_PAIRS"))


@law("study_eigenvalues", kinds=("float",), p="pose", q="pose", r="pose", f="pose", g="pose")
def test_study_eigenvalues_belong_to_the_three_displacements(p, q, r, f, g):
    values = study_eigenvalues(p, q, r)
    assert values.shape == (*p.shape, 3)
    assert_same(study_eigenvalues(f * p * g, f * q * g, f * r * g), values, rtol=1e-6)
    assert_same(study_eigenvalues(r, p, q), values, rtol=1e-6)
    first, _ = dyads_through_poses(p, q, r)
    distance, angle = first.axes[0].distance(first.axes[1]), first.axes[0].angle(first.axes[1])
    assert_same(distance**2, -values[..., 0] * values[..., 2], rtol=1e-6)
    assert_same(distance / np.sin(angle), (values[..., 2] - values[..., 0]) / 2, rtol=1e-6)
