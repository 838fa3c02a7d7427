"""6R linkages through four poses: both families where they are real, nine pairs each, all poses visited."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import combinations, permutations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from kinlib import (
    ADMISSIBLE_PAIRS,
    DegenerateError,
    DualQuaternion,
    Dyad,
    Line,
    Linkage,
    as_matrix,
    cubics_through,
    eps,
    factorizations,
    i,
    j,
    k,
    one,
    rotation,
    same_point,
    six_r_linkages,
    study_form,
    translation,
)
from kinlib.gallery import FOUR_POSES
from kinlib.testing import assert_closes, assert_visits, random_poses
from problems import pose_error, random_displacement, random_half_turns

FLOATS = [pose.astype(float) for pose in FOUR_POSES]
OPPOSITE = [(0, 3), (1, 4), (2, 5)]
TWO_APART = [(0, 2), (0, 4), (1, 3), (1, 5), (2, 4), (3, 5)]


def gram_determinant(poses) -> float:
    """The determinant of the Study form on four poses."""
    return np.linalg.det([[study_form(p, q) for q in poses] for p in poses])


def fourth_parameters(poses) -> np.ndarray:
    """The values of t3 for which the Study condition can be solved, from the skew matrix itself, by numpy.roots.

    With poses at ∞, 0, 1, t3 the skew matrix A_mn = b_mn / (t_m − t_n) must have the right-hand side orthogonal to
    its kernel: b01 A23 − b02 A13 + b03 A12 = 0.  Multiplied by t3 (t3 − 1) it is a quadratic polynomial.
    """
    b = np.array([[study_form(p, q) for q in poses] for p in poses], dtype=float)

    def condition(t):
        a12, a13, a23 = b[1, 2] / (0 - 1), b[1, 3] / (0 - t), b[2, 3] / (1 - t)
        return (b[0, 1] * a23 - b[0, 2] * a13 + b[0, 3] * a12) * t * (t - 1)

    nodes = np.array([2.0, 3.0, -1.0])
    return np.roots(np.polyfit(nodes, [condition(t) for t in nodes], 2))


def real_problems(count: int) -> list:
    """Random poses with two real families."""
    problems = (random_poses(4, seed=seed) for seed in range(10 * count))
    return [poses for poses in problems if gram_determinant(poses) > 1e-3][:count]


# --- reality of the families ---------------------------------------------------------------------------------------


def test_no_family_is_missed_and_none_is_invented():
    """Reality by the Gram determinant of the poses, against the roots of the Study condition."""
    problems = [random_poses(4, seed=seed) for seed in range(1500)]
    together = [DualQuaternion.stack(poses) for poses in zip(*problems, strict=True)]
    roots = [fourth_parameters(poses) for poses in problems]
    real = np.array([np.abs(t.imag).max() < 1e-9 * np.abs(t).max() for t in roots])
    assert np.array_equal([gram_determinant(poses) > 0 for poses in problems], real)
    assert 300 < real.sum() < 1450
    for poses in (problems[n] for n in np.flatnonzero(~real)[:50]):
        with pytest.raises(DegenerateError, match="neither family is real"):
            cubics_through(*poses)
    cubics = cubics_through(*together, 0.3, degenerate="nan")
    found = np.array([~np.isnan(cubic.coeffs).any(axis=(-1, -2)) for cubic in cubics])
    assert not found[:, ~real].any()
    assert (~found[:, real]).sum() < 10
    assert all("neither family is real" in text or "powers of t lose a pose" in text for text in cubics.missing)
    assert all(np.all(cubic[there].is_motion(rtol=1e-6)) for cubic, there in zip(cubics, found, strict=True))


def test_both_families_pass_through_the_poses():
    """Where a cubic comes near to missing a pose digits are lost, but rarely."""
    errors = []
    for poses in real_problems(60):
        t3 = np.sort(fourth_parameters(poses).real)
        linkages = six_r_linkages(*poses, 0.3)
        assert all(linkage.parameters[:3] == (math.inf, 0, 1) for linkage in linkages)
        found = [linkage.parameters[3] for linkage in linkages]
        assert np.allclose(np.sort(found), np.repeat(t3, 9), rtol=1e-5)
        errors += [pose_error(linkage, poses) for linkage in linkages]
    assert np.quantile(errors, 0.95) < 1e-9
    assert max(errors) < 1e-5


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
def test_solvable_problems_are_not_refused_at_any_scale(length):
    errors = []
    for seed in range(30):
        poses = random_poses(4, seed=seed, length=length)
        if gram_determinant(random_poses(4, seed=seed)) < 0:
            with pytest.raises(DegenerateError, match="neither family is real"):
                six_r_linkages(*poses)
            continue
        linkages = six_r_linkages(*poses)
        assert len(linkages) == 18
        errors += [pose_error(linkage, poses, length) for linkage in linkages]
        assert max(linkage.closure_residual() for linkage in linkages) < 1e-6
    assert len(errors) > 10 * 18
    assert np.quantile(errors, 0.95) < 1e-9
    assert max(errors) < 1e-5


# --- the linkages --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("poses", [FLOATS, *real_problems(3)])
def test_nine_linkages_of_each_family_visit_close_and_move(poses):
    linkages = six_r_linkages(*poses, 0.2)
    assert len(linkages) == 18
    for linkage in linkages:
        assert linkage.joint_count == 6
        assert_visits(linkage, *poses, rtol=1e-7)
        assert_closes(linkage, rtol=1e-7)
        assert linkage.mobility(0.4) == 1
        lines = linkage.axes.coeffs[:, [1, 2, 3, 5, 6, 7]]
        assert not any(same_point(lines[m], lines[n]) for m, n in combinations(range(6), 2))


@pytest.mark.parametrize("poses", [FLOATS, *real_problems(2)])
def test_degrees_of_relative_motions(poses):
    """Two links apart degree two; opposite ones 3, 3, 3 for three linkages and 3, 3, 1 for six."""
    for family in (six_r_linkages(*poses, 0.2)[:9], six_r_linkages(*poses, 0.2)[9:]):
        opposite = []
        for linkage in family:
            assert {linkage.relative_motion(*pair).degree for pair in TWO_APART} == {2}
            opposite.append(tuple(sorted(linkage.relative_motion(*pair).degree for pair in OPPOSITE)))
        assert opposite.count((3, 3, 3)) == 3
        assert opposite.count((1, 3, 3)) == 6


def test_admissible_pairs_by_closing_all_fifteen():
    """Pairs with one first factor or one last factor make shorter loops: they share an axis."""
    cubic = cubics_through(*FLOATS, 0.2)[0]
    chains = factorizations(cubic * cubic.leading.inverse())
    six_axes = []
    for m, n in combinations(range(6), 2):
        axes = Linkage.from_chains(chains[m], chains[n]).axes.coeffs[:, [1, 2, 3, 5, 6, 7]]
        if not any(same_point(axes[a], axes[a - 1], rtol=1e-6) for a in range(6)):
            six_axes.append((m, n))
    assert tuple(six_axes) == ADMISSIBLE_PAIRS
    assert len(six_axes) == 9


def test_different_first_factors_alone_admit_bennett_loops():
    orders = list(permutations(range(3)))
    either = [
        (m, n) for m, n in combinations(range(6), 2) if orders[m][0] != orders[n][0] or orders[m][2] != orders[n][2]
    ]
    assert len(either) == 15


def test_the_free_parameter_moves_the_linkage_along_its_family():
    first, second = (six_r_linkages(*FLOATS, free)[0] for free in (0.2, 0.5))
    assert first.parameters == second.parameters
    assert not np.all(same_point(first.axes, second.axes))


def test_of_a_family_that_misses_a_pose_the_other_is_left():
    """At free = −160/201 the cubic of the first family misses pose 2, whatever the factor of that pose."""
    for factor in (1.0, 1e-4, 1e5):
        poses = [FLOATS[0], FLOATS[1], FLOATS[2] * factor, FLOATS[3]]
        linkages = six_r_linkages(*poses, -160 / 201)
        assert len(linkages) == 9
        assert linkages.missing == ("first family: for this value of the free parameter the cubic misses pose 2",)
        assert linkages.parameters == (linkages[0].parameters,)
        assert linkages[0].parameters[3] == pytest.approx(-1)
        for linkage in linkages:
            assert_visits(linkage, *poses)


# --- batches --------------------------------------------------------------------------------------------------------


def test_a_batch_of_linkages_is_the_linkages_of_its_rows():
    poses = random_poses(4, seed=3, shape=(40,))
    unreal = np.array([gram_determinant([p[n] for p in poses]) < 0 for n in range(40)])
    assert 0 < unreal.sum() < 40
    batch = six_r_linkages(*poses, 0.2, degenerate="nan")
    assert len(batch) == 18
    for linkage in batch:
        assert (np.isnan(linkage.axes.coeffs).any(axis=(-1, -2)) == unreal).all()
        assert np.nanmax(pose_error(linkage, poses)) < 1e-8
    for n in np.flatnonzero(~unreal)[:8]:
        singles = six_r_linkages(*(p[n] for p in poses), 0.2)
        for linkage, single in zip(batch, singles, strict=True):
            assert linkage.axes[n].coeffs == pytest.approx(single.axes.coeffs, rel=1e-7, abs=1e-7)
            assert linkage.parameters[3][n] == pytest.approx(single.parameters[3])
    with pytest.raises(DegenerateError, match=r"^rows? .*neither family is real") as caught:
        six_r_linkages(*poses)
    assert caught.value.rows == tuple(np.flatnonzero(unreal))


def test_a_sweep_over_the_free_parameter():
    sweep = np.linspace(-1.05, 2, 7)
    batch = six_r_linkages(*FLOATS, sweep)
    assert [linkage.shape for linkage in batch] == [(7,)] * 18
    for n in (0, 6):
        for linkage, single in zip(batch, six_r_linkages(*FLOATS, sweep[n]), strict=True):
            assert linkage.axes[n].coeffs == pytest.approx(single.axes.coeffs)
    assert six_r_linkages(*FLOATS[:3], random_poses(1, seed=1, shape=(2, 1))[0], sweep, degenerate="nan")[0].shape == (
        2,
        7,
    )


def test_no_rows():
    poses = random_poses(4, seed=3, shape=(0,))
    assert [linkage.shape for linkage in six_r_linkages(*poses, degenerate="nan")] == [(0,)] * 18


def test_rows_that_are_no_poses_are_named_or_nan():
    poses = random_poses(4, seed=3, shape=(2,))
    broken = poses[1].coeffs.copy()
    broken[0] = np.nan
    poses[1] = type(poses[1])(broken)
    with pytest.raises(ValueError, match=r"row 0: pose 1: expected finite"):
        six_r_linkages(*poses)
    linkages = six_r_linkages(*poses, degenerate="nan")
    assert np.isnan(linkages[0].axes.coeffs[0]).all()
    assert linkages.missing[0].startswith("row 0: first family: a pose is not defined")


# --- near degeneracies ----------------------------------------------------------------------------------------------


def screw(random, angle: float, slide: float):
    """A turn about a random line and a translation along it."""
    line = Line.at(random.normal(size=3), random.normal(size=3))
    return translation(slide * line.direction / np.linalg.norm(line.direction)) * rotation(line, angle)


def nearly(kind: str, how_near: float, seed: int) -> list:
    """Four poses of which two all but differ by a rotation or a translation."""
    random, poses = np.random.default_rng(seed), random_poses(4, seed=seed)
    if kind == "p0, p1 a rotation":
        poses[1] = screw(random, 1.3, how_near) * poses[0]
    elif kind == "p0, p1 a translation":
        poses[1] = screw(random, how_near, 1.0) * poses[0]
    elif kind == "p0, p3 a rotation":
        poses[3] = screw(random, 1.3, how_near) * poses[0]
    elif kind == "p2, p3 a rotation":
        poses[3] = screw(random, 1.3, how_near) * poses[2]
    elif kind == "p0, p1 equal":
        poses[1] = screw(random, how_near, how_near) * poses[0]
    elif kind == "two pairs":
        poses[1], poses[3] = screw(random, 1.3, how_near) * poses[0], screw(random, 0.9, how_near) * poses[2]
    return poses


KINDS = [
    "p0, p1 a rotation",
    "p0, p1 a translation",
    "p0, p3 a rotation",
    "p2, p3 a rotation",
    "two pairs",
    "p0, p1 equal",
]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("how_near", [1e-2, 1e-4, 1e-6, 1e-9, 1e-11])
def test_near_a_degeneracy_poses_are_met_or_the_family_is_named(kind, how_near):
    """One family goes on; the other, whose t3 nears one of ∞, 0, 1, is met while floats can tell them apart."""
    refusals = []
    for seed in range(6):
        poses = nearly(kind, how_near, seed)
        try:
            linkages = six_r_linkages(*poses)
        except DegenerateError as error:
            refusals.append(str(error))
            continue
        assert len(linkages) == 18 - 9 * len(linkages.missing)
        for text in linkages.missing:
            assert how_near <= 1e-4
            assert any(word in text for word in ("nearly", "all but misses", "falls on", "two families are one"))
        for linkage in linkages:
            assert pose_error(linkage, poses) < 1e-8
            assert linkage.closure_residual() < 1e-8
        if how_near >= 1e-2:
            assert len(linkages) == 18
    assert kind == "p0, p1 equal" or all("neither family is real" in text for text in refusals)


@pytest.mark.parametrize("distance", [1e3, 1e5])
def test_far_from_the_origin_nothing_is_lost_but_the_digits_of_the_poses(distance):
    g = translation(distance * np.array([1.0, 2.0, -1.0]))
    poses = [g * pose for pose in FLOATS]
    for linkage, here in zip(six_r_linkages(*poses, 0.2), six_r_linkages(*FLOATS, 0.2), strict=True):
        assert pose_error(linkage, poses, distance) < 1e-13
        assert (g.inverse() * linkage.axes * g).coeffs == pytest.approx(here.axes.coeffs, abs=1e-13 * distance)


def test_a_star_of_rotations_says_what_is_not_built():
    poses = (one, 1 + i, 2 + j - eps * i, 1 + k + eps * (3 * i - j))
    with pytest.raises(DegenerateError, match=r"one pose differs from all others .* is not built: poses 0 and 1"):
        six_r_linkages(*(1.0 * pose for pose in poses))


@pytest.mark.parametrize("free", [0, 1, -0.5])
def test_two_pairs_that_differ_by_rotations_are_joined_by_nine_linkages(free):
    p2 = translation([1, -1, 2]) * (1 + 2 * j)
    poses = [1.0 * pose for pose in (one, 1 + 2 * i, p2, p2 * (3 + j - eps * i))]
    linkages = six_r_linkages(*poses, free)
    assert len(linkages) == 9
    assert linkages.missing[0].startswith("second family: the fourth pose falls on pose 2")
    for linkage in linkages:
        assert_visits(linkage, *poses)
        assert_closes(linkage)


# --- exact, frames, input ------------------------------------------------------------------------------------------


def test_exact_cubics_pass_through_exact_poses():
    for cubic, t3 in zip(cubics_through(*FOUR_POSES, Fraction(1, 3)), (Fraction(4, 3), -1), strict=True):
        assert not any(cubic.study_polynomial())
        for t, pose in zip((math.inf, 0, 1, t3), FOUR_POSES, strict=True):
            assert same_point(cubic(t), pose)


def test_exact_poses_that_need_too_large_a_field_say_so():
    with pytest.raises(ValueError, match=r"number field .* convert"):
        six_r_linkages(*FOUR_POSES)


@pytest.mark.parametrize("seed", range(3))
def test_displacing_either_frame_displaces_the_linkages(seed):
    g, h = (random_displacement(seed=n) for n in (seed, seed + 9))
    here, there = six_r_linkages(*FLOATS, 0.2), six_r_linkages(*(g * pose * h for pose in FLOATS), 0.2)
    for linkage in there:
        assert_visits(linkage, *(g * pose * h for pose in FLOATS), rtol=1e-7)
        moved = g.conjugate() * linkage.axes * g
        assert any(np.all(same_point(moved, other.axes, rtol=1e-6)) for other in here)


def test_matrices_and_transforms():
    matrices = [as_matrix(pose) for pose in FLOATS]
    for given in (matrices, [RigidTransform.from_matrix(matrix) for matrix in matrices]):
        linkages = six_r_linkages(*given, 0.2)
        assert len(linkages) == 18
        for linkage in linkages[::4]:
            assert_visits(linkage, *FLOATS, rtol=1e-7)


def test_four_poses_on_one_dyad_are_reached_by_5r_and_have_a_gram_determinant_of_rulings():
    """On a 2R quadric both families of cubics are real."""
    dyad = Dyad(*random_half_turns(2, seed=5))
    poses = [dyad(*t) for t in ((math.inf, math.inf), (0.3, 1.2), (-1.0, 0.4), (2.0, -0.7))]
    assert gram_determinant(poses) > 0
    assert len(cubics_through(*poses)) == 2


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ((one, one, *FOUR_POSES[2:]), "equal|differ|position"),
        (
            (one, translation([0, 2, 0]), translation([2, 0, 0]), translation([2, 2, 2])),
            "exceptional|Study quadric|pos",
        ),
    ],
)
def test_poses_in_special_position_are_named(poses, message):
    for case in (poses, [pose.astype(float) for pose in poses]):
        with pytest.raises(DegenerateError, match=message):
            six_r_linkages(*case)
