"""Conics through three poses and twisted cubics through four: put the parameters back in."""

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    DualQuaternion,
    NumberFieldElement,
    as_matrix,
    as_rigid_transform,
    conic_through,
    cubics_through,
    eps,
    fourth_parameters,
    i,
    j,
    k,
    linear_factor,
    one,
    quadratic_factors,
    same_point,
    study_form,
    study_projection,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, FOUR_POSES, LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.testing import random_poses
from strategies import fractions, poses


def gram(*poses):
    """The determinant of all study forms, by SymPy."""
    return sympy.Matrix(len(poses), len(poses), lambda m, n: sympy.sympify(study_form(poses[m], poses[n]))).det()


def gram_sign(poses) -> float:
    return np.sign(np.linalg.det([[study_form(p, q) for q in poses] for p in poses]))


def regular(*poses) -> bool:
    return all(study_form(p, q) != 0 for n, p in enumerate(poses) for q in poses[:n])


def visits(C, parameters, poses, **tolerance) -> bool:
    return all(np.all(same_point(C(t), p, **tolerance)) for t, p in zip(parameters, poses, strict=True))


# Conics


@given(poses(), poses(), poses())
def test_the_conic_visits_three_poses(p0, p1, p2):
    if not regular(p0, p1, p2):
        with pytest.raises(DegenerateError, match=r"tangent|equal|same"):
            conic_through(p0, p1, p2)
        return
    C = conic_through(p0, p1, p2)
    assert C.degree == 2
    assert C.is_motion()
    assert visits(C, (math.inf, 0, 1), (p0, p1, p2))


@given(poses(), poses(), poses(), poses(), poses())
def test_a_change_of_frames_changes_the_conic(p0, p1, p2, g, h):
    assume(regular(p0, p1, p2))
    moved = conic_through(g * p0 * h, g * p1 * h, g * p2 * h)
    assert moved == g * conic_through(p0, p1, p2) * h


@given(poses(), poses(), poses(), fractions.filter(bool), fractions.filter(bool))
def test_factors_of_the_poses_do_not_matter(p0, p1, p2, r, s):
    assume(regular(p0, p1, p2))
    C = conic_through(p0, p1, p2)
    assert conic_through(p0, r * p1, s * p2) == C
    assert conic_through(r * p0, p1, p2) == r * C


@given(poses(), poses(), poses(), fractions)
def test_the_conic_does_not_depend_on_the_order_of_the_poses(p0, p1, p2, t):
    assume(regular(p0, p1, p2) and t != 0)
    assert same_point(conic_through(p0, p1, p2)(t), conic_through(p1, p0, p2)(1 / t))
    assert same_point(conic_through(p0, p1, p2)(t), conic_through(p0, p2, p1)(1 - t))


def test_a_conic_in_symbols():
    x, y = sympy.symbols("x y")
    p1, p2 = (x - i) * (1 - (j - eps * i)), (1 - i) * (y - (j - eps * i))
    C = conic_through(one, p1, p2)
    assert C.is_motion()
    assert visits(C, (math.inf, 0, 1), (one, p1, p2))


@pytest.mark.parametrize("poses", [THREE_POSES, LINEAR_TERMS_EQUAL, FIELD_OF_DEGREE_SIX])
def test_poses_of_the_gallery(poses):
    C = conic_through(*poses)
    assert C.leading == 1
    assert C.is_motion()
    assert visits(C, (math.inf, 0, 1), poses)
    assert not any(isinstance(c, float) for c in C.coeffs.ravel())


@pytest.mark.parametrize("form", [lambda p: p, as_matrix, as_rigid_transform])
def test_poses_come_in_three_forms(form):
    poses = random_poses(3, seed=4)
    assert visits(conic_through(*map(form, poses)), (math.inf, 0, 1), poses)
    three = RigidTransform.from_matrix(np.stack([as_matrix(p) for p in poses]))
    assert visits(conic_through(*three), (math.inf, 0, 1), poses)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("angle", [None, 1e-3])
def test_conics_at_every_scale(length, angle):
    poses = random_poses(3, seed=5, length=length, angle=angle)
    C = conic_through(*poses)
    assert C.is_motion()
    assert visits(C, (math.inf, 0, 1), poses, length=length)


def test_a_batch_of_conics():
    poses = random_poses(3, seed=6, shape=(4,))
    C = conic_through(*poses)
    assert C.shape == (4,)
    assert C.is_motion().all()
    assert visits(C, (math.inf, 0, 1), poses)
    assert C[2].coeffs == pytest.approx(conic_through(*(p[2] for p in poses)).coeffs)
    assert conic_through(one, *poses[1:]).shape == (4,)


skew = ((1 - i) * (2 - j + eps * i), (2 - i) * (1 + j - eps * i))


@pytest.mark.parametrize(
    "poses",
    [
        (one, 1 - i, skew[0]),
        (one, skew[0], 1 - i),
        (skew[0], one, 1 - i),
        (one, one, skew[0]),
        (one, skew[0], 2 * skew[0]),
        (one, 1 - i, 3 - i),
        (one, 1.0 - i, 1.0 * skew[0]),
    ],
)
def test_a_tangent_plane_has_no_conic(poses):
    with pytest.raises(DegenerateError, match=r"tangent|equal|same|coincide"):
        conic_through(*poses)


def test_tangent_planes_in_a_batch_are_named():
    poses = random_poses(3, seed=7, shape=(4,))
    turned = DualQuaternion.stack(
        [q * (1 - i) if n == 2 else r for n, (q, r) in enumerate(zip(*poses[:2], strict=True))]
    )
    with pytest.raises(DegenerateError) as caught:
        conic_through(poses[0], turned, poses[2])
    assert caught.value.rows == (2,)


# Twisted cubics


def check_cubics(poses, free=0) -> tuple:
    parameters = fourth_parameters(*poses)
    cubics = cubics_through(*poses, free)
    assert len(cubics) == len(parameters)
    for C, t3 in zip(cubics, parameters, strict=True):
        assert C.degree == 3
        assert C.is_motion()
        assert visits(C, (math.inf, 0, 1, t3), poses)
    return cubics


@given(poses(), poses(), poses(), poses(), fractions)
def test_cubics_visit_four_poses_exactly_if_the_gram_determinant_is_not_negative(p0, p1, p2, p3, free):
    four = (p0, p1, p2, p3)
    assume(regular(*four))
    if gram(*four) < 0:
        with pytest.raises(DegenerateError, match="neither family is real"):
            cubics_through(*four, free)
        return
    try:
        check_cubics(four, free)
    except DegenerateError:  # for this value of the free parameter or in this position: named in tests below
        assume(False)


@pytest.mark.parametrize("seed", range(12))
def test_the_number_of_real_families_in_floats(seed):
    poses = random_poses(4, seed=seed)
    if gram_sign(poses) > 0:
        cubics = cubics_through(*poses)
        assert len(cubics) == 2
        for C, t3 in zip(cubics, fourth_parameters(*poses), strict=True):
            assert C.is_motion()
            assert visits(C, (math.inf, 0, 1, t3), poses)
    else:
        with pytest.raises(DegenerateError, match="neither family is real: the Gram determinant"):
            cubics_through(*poses)


def test_both_kinds_of_quadruples_occur():
    assert {gram_sign(random_poses(4, seed=seed)) for seed in range(12)} == {-1, 1}


def test_four_whole_poses_with_rational_families():
    cubics = check_cubics(FOUR_POSES, Fraction(1, 3))
    assert fourth_parameters(*FOUR_POSES) in ((Fraction(4, 3), -1), (-1, Fraction(4, 3)))
    assert not any(isinstance(c, float) for C in cubics for c in C.coeffs.ravel())


def test_families_over_a_number_field():
    p1, p2 = translation([1, 0, 2]) * (1 + i), translation([0, 3, 1]) * (2 + j)
    four = (one, p1, p2, translation([-2, -2, -1]) * (1 + k - i))
    assert gram(*four) == sympy.Rational(21, 4)
    cubics = check_cubics(four)
    assert any(isinstance(c, NumberFieldElement) for C in cubics for c in C.coeffs.ravel())


@pytest.mark.parametrize("scale", [300, 10**6])
def test_large_whole_coefficients_do_not_overflow(scale):
    rows = scale * np.array([p.coeffs for p in FOUR_POSES]) + np.eye(4, 8, dtype=int)
    four = [study_projection(DualQuaternion(row)) for row in rows]
    assert gram(*four) > 0
    t3 = fourth_parameters(*(1.0 * p for p in four))
    assert [float(t) for t in fourth_parameters(*four)] == pytest.approx(t3)
    check_cubics(four, 1)


def test_the_free_parameter_gives_other_motions_through_the_same_poses():
    first, second = (check_cubics(FOUR_POSES, free) for free in (Fraction(1, 3), 2))
    assert not any(C.same_motion(D) for C, D in zip(first, second, strict=True))
    t = Fraction(1, 2)
    for family in (0, 1):
        three = [cubics_through(*FOUR_POSES, free)[family](t).coeffs for free in (Fraction(1, 3), 2, 5)]
        assert sympy.Matrix(three).rank() == 2  # the motions of a family move in a line


def test_the_free_parameter_is_measured_alike_at_every_length():
    """Lengths in another unit change the dual parts only."""
    other = [p.primal + 1000 * eps * p.dual for p in FOUR_POSES]
    for C, D in zip(cubics_through(*FOUR_POSES, 2), cubics_through(*other, 2), strict=True):
        assert D.coeffs[:, :4].tolist() == C.coeffs[:, :4].tolist()
        assert D.coeffs[:, 4:].tolist() == (1000 * C.coeffs[:, 4:]).tolist()


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e6])
def test_cubics_at_every_scale(length):
    four = next(four for four in (random_poses(4, seed=n, length=length) for n in range(12)) if gram_sign(four) > 0)
    for C, t3 in zip(cubics_through(*four, 0.5), fourth_parameters(*four), strict=True):
        assert C.is_motion(rtol=1e-8)
        assert visits(C, (math.inf, 0, 1, t3), four, length=length)


@pytest.mark.parametrize("factors", [(3, 1, 1, 1), (-1, 1, 1, 1), (1, -1, 1, 1), (1, 2, Fraction(-1, 3), 7)])
def test_factors_of_four_poses_do_not_matter(factors):
    for one_or_float in (1, 1.0):
        four = [one_or_float * p for p in FOUR_POSES]
        other = [p * s for p, s in zip(four, factors, strict=True)]
        for C, D in zip(cubics_through(*four, 1), cubics_through(*other, 1), strict=True):
            assert C.same_motion(D)


def test_a_change_of_frame_changes_the_cubics():
    g = translation([1, 2, 3]) * (3 + 4 * k) / 5
    moved = cubics_through(*(g * p for p in FOUR_POSES), 1)
    assert [g * C == D for C, D in zip(cubics_through(*FOUR_POSES, 1), moved, strict=True)] == [True, True]


def value_that_misses(poses, family, pose=1):
    """The value of the free parameter for which the weight of a pose vanishes: the weights are affine in it."""
    t = cubics_through(*poses, 1).parameters[family][pose]
    first, second = (cubics_through(*poses, free)[family](t).coeffs for free in (1, 2))
    n = next(n for n in range(8) if first[n] != second[n])
    return 1 - Fraction(first[n]) / (second[n] - first[n])


@pytest.mark.parametrize("pose", [1, 2, 3])
@pytest.mark.parametrize("family", [0, 1])
def test_of_a_family_that_misses_a_pose_the_other_is_left_and_this_one_named(family, pose):
    free = value_that_misses(FOUR_POSES, family, pose)
    for four in (FOUR_POSES, [1.0 * p for p in FOUR_POSES]):
        cubics = cubics_through(*four, free)
        assert len(cubics) == len(cubics.parameters) == 1
        assert visits(cubics[0], cubics.parameters[0], four)
        assert cubics.missing == (
            f"{('first', 'second')[family]} family: for this value of the free parameter the cubic misses pose {pose}",
        )
        assert cubics.missing[0] in repr(cubics)


def test_values_of_the_free_parameter_in_a_batch():
    """A sweep over one problem; a row without one of the families is named, or NaN."""
    floats = [1.0 * p for p in FOUR_POSES]
    sweep = np.array([0.0, -160 / 201, 2.0])
    with pytest.raises(DegenerateError, match=r"row 1: first family: .* misses pose 2") as caught:
        cubics_through(*floats, sweep)
    assert caught.value.rows == (1,)
    first, second = cubics_through(*floats, sweep, degenerate="nan")
    assert np.isnan(first.coeffs).any(axis=(-1, -2)).tolist() == [False, True, False]
    for n, free in enumerate(sweep):
        singles = cubics_through(*floats, free)
        assert second[n].coeffs == pytest.approx(singles[-1].coeffs)


@pytest.mark.parametrize("factor", [Fraction(1, 10000), 10**5, -1])
@pytest.mark.parametrize("pose", [0, 1, 2, 3])
def test_representatives_do_not_decide_whether_a_pose_is_missed(factor, pose):
    for four in (list(FOUR_POSES), [1.0 * p for p in FOUR_POSES]):
        four[pose] = four[pose] * (factor if four[pose].coeffs.dtype == object else float(factor))
        assert len(cubics_through(*four)) == 2
        assert cubics_through(*four, Fraction(-160, 201)).missing == (
            "first family: for this value of the free parameter the cubic misses pose 2",
        )


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ((one, 1 - i, 1 - j, 1 - k), "each two of the four poses differ by a rotation or a translation: their span"),
        ((one, one, *skew), "two of the four poses are equal.*: poses 0 and 1 are equal$"),
        ((one, *skew, 2 * skew[0]), "two of the four poses are equal.*: poses 1 and 3 are equal$"),
        ((one, eps, *skew), "pose 1: .*exceptional three-space"),
        ((one, 1 + eps, *skew), "pose 1: expected a point of the Study quadric"),
        ((one, 1 + i * math.nan, *skew), "pose 1: expected finite"),
        (
            (translation([1, 2, 3]) * (2 + i - k), 1 + i, 1 + j, 1 + k),
            "each two of three of the poses differ .*: poses 1 and 2 differ by a rotation, poses 1 and 3 differ by a "
            "rotation, poses 2 and 3 differ by a rotation$",
        ),
        (
            (one, 1 + i, 2 + j - eps * i, translation([1, 3, 2])),
            "one pose differs from all others .* which is not built: poses 0 and 1 differ by a rotation, "
            "poses 0 and 2 differ by a rotation, poses 0 and 3 differ by a translation$",
        ),
        (
            (one, 1 + i, 2 + j - eps * i, skew[1]),
            "falls on pose 2 .*falls on pose 1",
        ),
        ((*THREE_POSES, conic_through(*THREE_POSES)(3)), "the four poses are dependent"),
    ],
)
def test_four_poses_in_special_position(poses, message):
    for four in (poses, [1.0 * p for p in poses]):
        with pytest.raises(ValueError, match=message):
            cubics_through(*four)


@given(poses(), poses(), poses(), fractions)
def test_a_fourth_pose_on_the_conic_of_the_others_is_named(p0, p1, p2, t):
    assume(regular(p0, p1, p2) and t not in (0, 1))
    with pytest.raises(DegenerateError, match="dependent"):
        cubics_through(p0, p1, p2, conic_through(p0, p1, p2)(t))


@pytest.mark.parametrize("seed", range(20))
def test_coplanar_poses_in_floats_are_named(seed):
    """Their Gram determinant vanishes; rounding decides its sign, and must not decide the message."""
    three = random_poses(3, seed=seed)
    with pytest.raises(DegenerateError, match="dependent"):
        cubics_through(*three, conic_through(*three)(0.3 + seed))


def two_pairs():
    """Poses 0, 1 and poses 2, 3 differ by rotations."""
    p2 = translation([1, -1, 2]) * (1 + 2 * j)
    return one, 1 + 2 * i, p2, p2 * (3 + j - eps * i)


def test_two_pairs_that_differ_by_rotations_have_one_family():
    floats = [1.0 * p for p in two_pairs()]
    for four in (two_pairs(), floats):
        cubics = cubics_through(*four)
        assert len(cubics) == 1
        assert cubics[0].is_motion()
        assert visits(cubics[0], cubics.parameters[0], four)
        assert cubics.missing == (
            "second family: the fourth pose falls on pose 2 (t3 = 1): poses 0 and 1 differ by a rotation, "
            "poses 2 and 3 differ by a rotation",
        )
    for free in (0, 1, -3):
        exact, rounded = cubics_through(*two_pairs(), free), cubics_through(*floats, free)
        assert rounded[0].coeffs == pytest.approx(exact[0].coeffs.astype(float))


@pytest.mark.parametrize("free", [math.nan, math.inf, 1j, [0.0, math.nan]])
def test_the_free_parameter_is_real_and_finite(free):
    with pytest.raises(ValueError, match="expected real and finite values of the free parameter"):
        cubics_through(*FOUR_POSES, free)


@pytest.mark.parametrize("free", [None, "a", [1, None], i])
def test_the_free_parameter_is_a_number(free):
    with pytest.raises(TypeError, match="expected"):
        cubics_through(*FOUR_POSES, free)


@pytest.mark.parametrize("pose", [None, [1, 0, 0, 0, 0, 0, 0, 0], 1.0])
def test_a_pose_is_a_pose(pose):
    with pytest.raises(TypeError, match="expected a pose"):
        cubics_through(*FOUR_POSES[:3], pose)


def test_a_batch_of_cubics_is_the_cubics_of_its_rows():
    four = random_poses(4, seed=8, shape=(30,))
    both = cubics_through(*four, 0.3, degenerate="nan")
    unreal = np.array([gram_sign([p[n] for p in four]) < 0 for n in range(30)])
    assert 0 < unreal.sum() < 30
    for C, parameters in zip(both, both.parameters, strict=True):
        assert (np.isnan(C.coeffs).any(axis=(-1, -2)) == unreal).all()
        assert (np.isnan(parameters[3]) == unreal).all()
    for n in np.flatnonzero(~unreal):
        singles = cubics_through(*(p[n] for p in four), 0.3)
        for C, single in zip(both, singles, strict=True):
            assert C[n].coeffs == pytest.approx(single.coeffs, rel=1e-9)
    with pytest.raises(DegenerateError, match="neither family is real") as caught:
        cubics_through(*four, 0.3)
    assert caught.value.rows == tuple(np.flatnonzero(unreal))


def test_batches_of_poses_and_values_are_broadcast():
    four = random_poses(4, seed=8, shape=(3, 1, 2))
    C, _ = cubics_through(FOUR_POSES[0].astype(float), *four[1:], np.linspace(0, 1, 5)[:, None], degenerate="nan")
    assert C.shape == (3, 5, 2)
    exact = cubics_through(*FOUR_POSES, [0, 1, 2])
    assert [C.shape for C in exact] == [(3,), (3,)]
    assert exact[0][2].coeffs.tolist() == cubics_through(*FOUR_POSES, 2)[0].coeffs.tolist()
    empty = [DualQuaternion(np.zeros((0, 8)))] * 4
    assert [C.shape for C in cubics_through(*empty, degenerate="nan")] == [(0,), (0,)]


@pytest.mark.parametrize("distance", [1e3, 1e6])
def test_cubics_far_from_the_origin(distance):
    """The same cubics, moved, up to the rounding of the poses."""
    g = translation(distance * np.array([1.0, 2.0, -1.0]))
    four = [1.0 * p for p in FOUR_POSES]
    for C, D in zip(cubics_through(*four, 1), cubics_through(*(g * p for p in four), 1), strict=True):
        assert (g.inverse() * D).coeffs == pytest.approx(C.coeffs, abs=1e-14 * distance)


@pytest.mark.parametrize("side", ["fixed", "moving"])
def test_frames_do_not_change_what_the_free_parameter_means(side):
    g = translation([1.0, -2.0, 0.5]) * (1 + 0.3 * i - 0.7 * k)
    for seed in (1, 2, 5):
        four = random_poses(4, seed=seed)
        if gram_sign(four) < 0:
            continue
        moved = [g * p if side == "fixed" else p * g for p in four]
        for C, D in zip(cubics_through(*four, 0.7), cubics_through(*moved, 0.7), strict=True):
            expected = g * C if side == "fixed" else C * g
            assert D.same_motion(expected, rtol=1e-8)


def test_the_order_of_the_families_does_not_depend_on_representatives():
    for seed in range(10):
        four = random_poses(4, seed=seed)
        if gram_sign(four) < 0:
            continue
        first, second = (t[3] for t in cubics_through(*four).parameters)
        assert abs(first) >= abs(second)
        for n in range(4):
            other = [p * (-2.0 if m == n else 1.0) for m, p in enumerate(four)]
            assert [t[3] for t in cubics_through(*other).parameters] == pytest.approx([first, second])


def test_motions_of_three_turns_are_found_again():
    """The cubic (t − h1)(t − h2)(t − h3) is one of those through four of its poses."""
    C = linear_factor(i) * linear_factor(j - eps * i) * linear_factor(k + eps * (i - 2 * j))
    four = [C(t) for t in (math.inf, 0, 1, 3)]
    assert any(t3 == 3 for t3 in fourth_parameters(*four))
    family = next(n for n, t3 in enumerate(fourth_parameters(*four)) if t3 == 3)
    first, second = (cubics_through(*four, free)[family](2).coeffs for free in (1, 2))
    assert sympy.Matrix([first, second, C(2).coeffs]).rank() == 2


def test_floats_and_exact_poses_give_the_same_cubics():
    floats = [1.0 * p for p in FOUR_POSES]
    for C, D in zip(cubics_through(*FOUR_POSES, 1), cubics_through(*floats, 1.0), strict=True):
        assert D.coeffs == pytest.approx(C.coeffs.astype(float))


def test_four_poses_in_three_forms():
    matrices = [as_matrix(p) for p in FOUR_POSES]
    for C, D in zip(cubics_through(*FOUR_POSES, 1), cubics_through(*matrices, 1), strict=True):
        assert all(same_point(C(t), D(t)) for t in (math.inf, 0, 1))


def test_a_plane_that_meets_the_exceptional_space_may_have_a_conic():
    """Screws about parallel axes: the primal parts of the poses are dependent, but no two poses are conjugate."""
    C = conic_through(one, translation([1, 0, 0]) * (1 + i), translation([2, 1, 0]) * (1 + 2 * i))
    assert C.is_motion()
    with pytest.raises(DegenerateError, match="real root"):
        quadratic_factors(C.norm_polynomial())
