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
    Dyad,
    Linkage,
    as_matrix,
    cubics_through,
    factorizations,
    one,
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
    real = 0
    for seed in range(1500):
        poses = random_poses(4, seed=seed)
        roots = fourth_parameters(poses)
        expected = 2 if np.abs(roots.imag).max() < 1e-9 * np.abs(roots).max() else 0
        assert (gram_determinant(poses) > 0) == (expected == 2)
        if expected == 0:
            with pytest.raises(DegenerateError, match="neither family is real"):
                cubics_through(*poses)
            continue
        real += 1
        cubics = cubics_through(*poses, 0.3)
        assert len(cubics) == 2
        assert all(cubic.is_motion(rtol=1e-6) for cubic in cubics)
    assert 300 < real < 1450


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
        assert len(linkage) == 6
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


def test_a_cubic_that_misses_a_pose_is_refused():
    """Each weight vanishes for one value of the free parameter: it is affine in it, so two values tell where."""
    poses = FLOATS
    t3 = six_r_linkages(*poses)[0].parameters[3]

    def weights(free):
        cubic = cubics_through(*poses, free)[0]
        return [
            float(np.dot(cubic(t).coeffs, p.coeffs) / np.dot(p.coeffs, p.coeffs))
            for t, p in zip((0, 1, t3), poses[1:], strict=True)
        ]

    at_0, at_1 = weights(0.0), weights(1.0)
    for number, (a, b) in enumerate(zip(at_0, at_1, strict=True), start=1):
        with pytest.raises(DegenerateError, match=f"misses pose {number}"):
            six_r_linkages(*poses, a / (a - b))


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
