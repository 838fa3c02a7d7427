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


def test_a_cubic_that_misses_a_pose_is_refused():
    """At one value of the free parameter the weight of a pose vanishes."""
    C, D = (cubics_through(*FOUR_POSES, free)[0] for free in (1, 2))
    first, second = C(0).coeffs, D(0).coeffs
    n = next(n for n in range(8) if first[n] != second[n])
    free = 1 - Fraction(first[n]) / (second[n] - first[n])
    with pytest.raises(DegenerateError, match="misses pose 1"):
        cubics_through(*FOUR_POSES, free)


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ((one, 1 - i, 1 - j, 1 - k), "differ by a rotation"),
        ((one, one, *skew), "differ by a rotation"),
        ((one, *skew, skew[0]), "differ by a rotation"),
        ((one, eps, *skew), "exceptional three-space"),
        ((one, 1 + eps, *skew), "expected a point of the Study quadric"),
        ((one, 1 + i * math.nan, *skew), "expected finite"),
    ],
)
def test_four_poses_in_special_position(poses, message):
    with pytest.raises(ValueError, match=message):
        cubics_through(*poses)


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
