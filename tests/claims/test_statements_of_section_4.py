"""Section 4: Theorem 2, Bennett linkages, factorizations, 5R and 6R linkages."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from itertools import combinations

import numpy as np
import pytest
import sympy

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    Linkage,
    MotionPolynomial,
    axis_of,
    bennett_flip,
    bennett_linkage,
    conic_through,
    cubics_through,
    dyads_through_poses,
    factorizations,
    goldberg_linkages,
    i,
    j,
    linear_factor,
    null_form,
    one,
    quadratic_factors,
    same_point,
    six_r_linkages,
    study_form,
    translation,
)
from kinlib.gallery import FOUR_POSES, THREE_POSES
from kinlib.testing import random_poses
from problems import distance_of_dyads, distance_of_pairs, random_half_turns, rational_half_turns


@cache
def exact_linkages():
    return goldberg_linkages(*THREE_POSES, (1, 3))


@cache
def exact_dyads():
    return dyads_through_poses(*THREE_POSES)


def skew(pair) -> bool:
    h1, h2 = pair
    return study_form(h1, h2) != 0 and bool(np.cross(h1.coeffs[1:4], h2.coeffs[1:4]).any())


PAIRS = [pair for pair in (rational_half_turns(2, seed=seed) for seed in range(30)) if skew(pair)][:8]


def product_of(factors) -> MotionPolynomial:
    product = MotionPolynomial([one.coeffs])
    for h in factors:
        product = product * linear_factor(h)
    return product


def test_the_plane_cuts_a_regular_conic_that_meets_the_null_cone_in_two_conjugate_pairs():
    """T2a: the norm is a quartic without real zeros."""
    for seed in range(200):
        conic = conic_through(*random_poses(3, seed=seed))
        assert conic.is_motion()
        roots = np.roots(conic.norm_polynomial())
        assert np.abs(roots.imag).min() > 0
        assert (roots.imag > 0).sum() == 2


def test_two_solutions_for_the_first_vertex_give_the_two_dyads():
    """T2b: the construction of the proof agrees with the factorizations of the conic."""
    poses = random_poses(3, seed=1, shape=(500,))
    pairs = [dyads_through_poses(*poses, method=method) for method in ("null_quadrilateral", "factorization")]
    assert np.max(distance_of_pairs(*pairs)) < 1e-6
    assert np.median(distance_of_pairs(*pairs)) < 1e-12


def test_exactly_two_spaces_through_three_poses():
    """T2c: two in general; the poses 1, h1h2, (1 − h1)(1 − h2) have one, and the quartic is (t² + 1)²."""
    first, second = dyads_through_poses(*random_poses(3, seed=2, shape=(1000,)))
    assert distance_of_dyads(first, second).min() > 1e-6
    for h1, h2 in PAIRS:
        poses = one, h1 * h2, (1 - h1) * (1 - h2)
        assert all(study_form(p, q) != 0 for p, q in combinations(poses, 2))
        first, second = quadratic_factors(conic_through(*poses).norm_polynomial())
        assert (first == second).all()
        with pytest.raises(DegenerateError, match="double roots") as caught:
            dyads_through_poses(*poses)
        assert same_point(caught.value.dyad.h1, h1)
        assert same_point(caught.value.dyad.h2, h2)


def test_the_conic_is_the_coupler_motion_of_a_bennett_linkage_of_the_two_dyads():
    """R1."""
    linkage = bennett_linkage(*THREE_POSES)
    assert linkage.closure_residual() == 0
    assert linkage.coupler_motion.same_motion(conic_through(*THREE_POSES))
    axes = linkage.axes
    assert same_point(axes[0], exact_dyads()[0].h1)
    assert same_point(axes[1], exact_dyads()[0].h2)
    assert same_point(axes[3], exact_dyads()[1].h1)
    assert same_point(axes[2], exact_dyads()[1].h2)


def flipped_pairs():
    """h1, h2 and k1, k2 with h1 + h2 = k1 + k2 and h1h2 = k1k2."""
    for (h1, h2), (x, y) in zip(PAIRS, ((1, 2), (2, 3), (3, 2), (-1, 4), (2, 5), (0, 3), (5, 3), (1, -3)), strict=True):
        f1, f2 = h1 * 2 + x, h2 * y
        yield f1, f2, *bennett_flip(f1, f2)


def test_the_two_dyads_of_a_bennett_linkage_are_congruent_by_a_half_turn():
    """R2: v = h1 − k2 = k1 − h2 has v h1 = k̄2 v and v h2 = k̄1 v; the spaces do not share ⟨1, h1, h2⟩."""
    for h1, h2, k1, k2 in flipped_pairs():
        assert h1 + h2 == k1 + k2
        assert h1 * h2 == k1 * k2
        v, turn = h1 - k2, axis_of(h1 - k2)
        assert v == k1 - h2
        assert v * h1 == k2.conjugate() * v
        assert v * h2 == k1.conjugate() * v
        assert turn * h1 == k2.conjugate() * turn
        assert turn * h2 == k1.conjugate() * turn
        assert study_form(turn, turn) == 0
        assert not same_point(h1 - h1.scalar_part, k1 - k1.scalar_part)


def test_the_two_spaces_share_the_plane_of_the_poses_and_not_the_axes():
    """R2: the other space is not ⟨1, h1, h2, h2h1⟩."""
    for dyad, other in (exact_dyads(), exact_dyads()[::-1]):
        assert dyad.h2 * dyad.h1 not in other.space()
        assert dyad.h1 not in other.space()
        assert all(pose in other.space() for pose in THREE_POSES)


def shape(h, k):
    """Cosine² and Study form² of two axes, over their lengths: congruent pairs have equal ones."""
    lengths = null_form(h, h) * null_form(k, k)
    return Fraction(null_form(h, k) ** 2) / lengths, Fraction(study_form(h, k) ** 2) / lengths


def test_opposite_links_are_congruent_and_opposite_axes_only_for_equal_lengths():
    """R3."""
    for h1, h2, k1, k2 in flipped_pairs():
        a, b, c, d = (x - x.scalar_part for x in (h1, h2, k1, k2))
        assert shape(a, b) == shape(c, d)
        assert shape(a, c) == shape(b, d)
        assert shape(a, b) != shape(a, c) or null_form(a, a) == null_form(b, b)
        assert (shape(a, d) == shape(b, c)) == (null_form(a, a) == null_form(b, b))


def test_three_general_poses_have_one_bennett_linkage():
    """I1: the conic is determined, and so are its two factorizations."""
    linkage = bennett_linkage(*THREE_POSES)
    conic = conic_through(*THREE_POSES)
    assert all(same_point(conic(t), pose) for t, pose in zip((math.inf, 0, 1), THREE_POSES, strict=True))
    chains = factorizations(conic * conic.leading.inverse())
    assert len(chains) == 2
    for chain in chains:
        assert any(same_point(chain[0], f) for f in (linkage.factors[0], linkage.factors[3].conjugate()))


def test_four_poses_have_two_families_of_cubics_with_nine_linkages_each():
    """I2."""
    for free in (0, Fraction(1, 3), 2):
        cubics = cubics_through(*FOUR_POSES, free)
        assert len(cubics) == 2
        for cubic, t3 in zip(cubics, (Fraction(4, 3), -1), strict=True):
            assert all(same_point(cubic(t), p) for t, p in zip((math.inf, 0, 1, t3), FOUR_POSES, strict=True))
            assert not any(cubic.study_polynomial())
    assert len(six_r_linkages(*(pose.astype(float) for pose in FOUR_POSES))) == 18


def test_a_cubic_has_six_factorizations_one_an_order():
    """M1."""
    h1, h2 = PAIRS[0]
    cubic = product_of([h1 * 2 + 1, h2 - 1, 3 * (i + j) + 2])
    chains = factorizations(cubic)
    assert len(chains) == 6
    assert all(product_of(chain) == cubic for chain in chains)
    orders = {tuple((h.scalar_part, h.norm().scalar_part) for h in chain) for chain in chains}
    assert len(orders) == 6


def bennett_loops(chains) -> int:
    """Pairs of factorizations that share a first or a last factor: they close a loop of four."""
    return sum(same_point(a[0], b[0]) or same_point(a[2], b[2]) for a, b in combinations(chains, 2))


def test_admissible_pairs_differ_first_and_last():
    """M2: of fifteen pairs six share a factor at an end; nine are left."""
    h1, h2 = PAIRS[1]
    chains = factorizations(product_of([h1 * 2 + 1, h2 - 1, 3 * (i + j) + 2]))
    assert len(list(combinations(chains, 2))) == 15
    assert bennett_loops(chains) == 6


def in_space(motion, dyad) -> bool:
    return all(c in dyad.space() for c in motion.coefficients)


def test_cubics_of_5r_linkages_lie_in_the_space_of_their_dyad():
    """G1: and the general cubic through four poses lies in neither space of three of them."""
    for n, linkage in enumerate(exact_linkages()):
        assert in_space(linkage.coupler_motion, exact_dyads()[n // 4])
        assert not in_space(linkage.coupler_motion, exact_dyads()[1 - n // 4])
    cubic = cubics_through(*(pose.astype(float) for pose in FOUR_POSES))[0]
    assert not any(in_space(cubic, dyad) for dyad in dyads_through_poses(*FOUR_POSES[:3], method="eigenvalues"))


def test_with_the_quadratic_of_the_other_axis_there_is_no_5r():
    """G1: at z = ±√−1 the cubic is in the space, and no factorization leaves axis A."""
    h_a, h_b = exact_dyads()[0].h1, exact_dyads()[0].h2
    cubic = product_of([h_a, 2 * h_a + 1, h_b])
    assert in_space(cubic, exact_dyads()[0])
    for quadratic in ((0, 1), (1, 5)):
        for chain in factorizations(cubic):
            if (chain[0].scalar_part, chain[0].norm().scalar_part) == quadratic:
                assert same_point(chain[0] - chain[0].scalar_part, h_a)
    with pytest.raises(DegenerateError, match="there is no 5R"):
        goldberg_linkages(*(pose.astype(float) for pose in random_poses(3, seed=3)), 1j)


def distinct_axes(first, second) -> int:
    lines = [h.coeffs[[1, 2, 3, 5, 6, 7]] for h in Linkage.from_chains(first, second).axes]
    return sum(not any(same_point(lines[m], lines[n]) for n in range(m)) for m in range(len(lines)))


def test_two_of_the_other_four_factorizations_close_a_5r():
    """G2."""
    for linkage in exact_linkages()[::2]:
        first = linkage.factors[:3]
        chains = factorizations(product_of(first))
        twice = linkage.joints.index(2)
        a, b = linkage.joint_factors(twice)
        assert a * b == b * a
        swapped = list(first)
        swapped[twice : twice + 2] = b, a
        assert product_of(swapped) == product_of(first)
        assert sum(distinct_axes(first, chain) == 5 for chain in chains) == 2


def test_a_shared_axis_on_the_right_is_the_same_for_the_conjugate_motion():
    """G3: the inverse motion of the mirrored linkage turns twice about its first axis."""
    for linkage in exact_linkages():
        first = linkage.factors[:3]
        inverse = [h.conjugate() for h in reversed(first)]
        assert product_of(first).conjugate() == product_of(inverse)
        commuting = [same_point(a * b, b * a) for a, b in (first[:2], first[1:])]
        assert commuting == ([True, False] if linkage.joints[0] == 2 else [False, True])


def test_degrees_of_relative_motions_of_a_5r():
    """G4: the link opposite the joint that turns twice sees degree two on both sides."""
    apart = [(0, 2), (1, 4), (0, 3), (1, 3), (2, 4)]
    for linkage in exact_linkages():
        degrees = [linkage.relative_motion(*pair).degree for pair in apart]
        assert degrees == ([3, 3, 2, 2, 2] if linkage.joints[0] == 2 else [3, 2, 2, 3, 2])


def crossings(motion, dyad, which: int) -> int:
    """How often the curve of a motion meets a general ruling t1 = 7/3 (or t2 = 7/3)."""
    t = sympy.Symbol("t")
    x = dyad.coordinates(motion(t))
    value = sympy.Rational(7, 3)
    condition = (x[2] + value * x[3]) if which == 0 else (x[1] + value * x[3])
    other = (x[0] + value * x[1]) if which == 0 else (x[0] + value * x[2])
    return sympy.gcd(sympy.Poly(sympy.expand(condition), t), sympy.Poly(sympy.expand(other), t)).degree()


def test_cubics_meet_the_rulings_of_the_joint_that_turns_twice_in_two_points():
    """C1."""
    for n, linkage in enumerate(exact_linkages()):
        meetings = [crossings(linkage.coupler_motion, exact_dyads()[n // 4], which) for which in (0, 1)]
        assert meetings == list(linkage.joints[:2])


def test_the_second_point_on_the_ruling_through_the_identity():
    """C3: where (t − z1)(t − z2) is real, the first axis has turned back and the pose lies on [1] ∨ [hB]."""
    for linkage, dyad in zip(
        exact_linkages()[:2] + exact_linkages()[4:6], exact_dyads()[:1] * 2 + exact_dyads()[1:] * 2, strict=True
    ):
        (x1, y1), (x2, y2) = ((f.scalar_part, null_form(f, dyad.h1)) for f in linkage.factors[:2])
        t0 = Fraction(x1 * y2 + x2 * y1) / (y1 + y2)
        pose = linkage.coupler_motion(t0)
        t1, t2 = dyad.parameters(pose)
        assert t1 == math.inf
        assert same_point(pose, t2 - dyad.h2)


def test_the_second_point_runs_to_infinity_where_the_sum_is_real():
    """C3: z = 1 + 2√−1 and 3 − 2√−1: the cubic touches the ruling at the identity."""
    h_a, h_b = exact_dyads()[0].h1, exact_dyads()[0].h2
    cubic = product_of([1 + 2 * h_a, 3 - 2 * h_a, h_b])
    assert cubic.coefficients[1] == -(4 * one + h_b)
    assert cubic.coefficients[0] == 1


def test_four_general_poses_are_not_on_one_dyad():
    """O1: the fourth pose is in neither space, unless it is chosen there."""
    dyads = dyads_through_poses(*FOUR_POSES[:3], method="eigenvalues")
    assert not any(FOUR_POSES[3] in dyad.space() for dyad in dyads)
    for seed in range(50):
        *three, fourth = random_poses(4, seed=seed)
        dyads = dyads_through_poses(*three)
        assert not any(fourth in dyad.space() for dyad in dyads)
    h1, h2 = random_half_turns(2, seed=1)
    poses = [one, *(Dyad(h1, h2)(*t) for t in ((0.2, 1.0), (-1.0, 0.7), (2.0, -0.4)))]
    assert sum(poses[3] in dyad.space() for dyad in dyads_through_poses(*poses[:3])) == 1


def test_two_freedoms_of_the_cubics_of_a_class():
    """O2: the curve moves with both coordinates of z, and z has two."""
    poses, step = random_poses(3, seed=4), 1e-6

    def curve(z):
        linkage = goldberg_linkages(*poses, z)[0]
        dyad = dyads_through_poses(*poses)[0]
        t1, t2 = dyad.parameters(linkage.coupler_motion(np.array([0.3, -1.2, 2.5])))
        assert np.allclose(t2, [0.3, -1.2, 2.5])
        return np.arctan2(1, t1)

    z = 0.4 + 0.9j
    derivatives = [(curve(z + d) - curve(z - d)) / (2 * step) for d in (step, step * 1j)]
    assert np.linalg.matrix_rank(derivatives, rtol=1e-4) == 2


def test_one_point_of_a_space_has_a_given_orientation_in_general_off_s():
    """O3."""
    for dyad in exact_dyads():
        for orientation in (DualQuaternion([1, 2, -1, 3, 0, 0, 0, 0]), DualQuaternion([0, 1, 1, 5, 0, 0, 0, 0])):
            coordinates = dyad.coordinates(orientation)
            point = sum((x * e for x, e in zip(coordinates, dyad.basis, strict=True)), one * 0)
            assert point.primal == orientation
            assert point in dyad.space()
            assert study_form(point, point) != 0


def test_one_more_position_is_in_general_not_reached():
    """O4: of the poses that carry a point to a given place, none is on the dyad: one equation too many."""
    dyad = exact_dyads()[0]
    t1, t2 = sympy.symbols("t1 t2")
    pose = dyad(t1, t2)
    path = pose * pose.conjugate().eps_conjugate()
    weight, place = path.scalar_part, path.coeffs[5:]
    equations = [sympy.expand(x - w * weight) for x, w in zip(place, (1, 2, 3), strict=True)]
    assert sympy.groebner(equations, t1, t2, order="grevlex").exprs != [0]
    solutions = sympy.groebner([*equations, 1], t1, t2).exprs
    assert solutions == [1]


@pytest.mark.parametrize("shift", [[2, 0, 0], [0, 4, -2]])
def test_statements_hold_with_any_first_pose(shift):
    """T2c, R1: everything is about the set of poses, in any frame."""
    home = translation(shift) * (1 + i)
    linkage = bennett_linkage(*(pose * home for pose in THREE_POSES))
    assert linkage.closure_residual() == 0
    assert same_point(linkage.coupler_motion(0), THREE_POSES[1] * home)
