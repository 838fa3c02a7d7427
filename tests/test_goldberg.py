"""Goldberg linkages (5R) through three poses: the z-plane, the bad places in it, and what the linkages must satisfy.

For a dyad with axes A (turning twice) and B each pose is (s_A − h_A)(s_B − h_B).  The triangle of the z-plane has the
vertices s_B1, s_B2 and z*, where the lines through s_Bn with direction s_An − √−1 meet.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    Linkage,
    MotionPolynomial,
    as_matrix,
    dyads_through_poses,
    factorizations,
    goldberg_linkages,
    i,
    j,
    k,
    linear_factor,
    null_form,
    one,
    same_point,
    study_eigenvalues,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.testing import assert_closes, assert_same_point, assert_visits, random_poses
from problems import pose_error, random_displacement, random_half_turns, reach

SIDES = ("base", "moving")
GROUPS = [(number, side) for number in (0, 1) for side in SIDES]  # two linkages each, in this order
ADJACENT = [(n, (n + 1) % 5) for n in range(5)]

REAL = "z is real"
BENNETT = "Bennett linkage through the poses: its partner"
CIRCUMCIRCLE = "circumcircle"
MISSES_1, MISSES_2 = "misses pose 1", "misses pose 2"
NO_5R = "there is no 5R"
CENTRE = "incentre or excentre"


def as_floats(poses):
    return [pose.astype(float) for pose in poses]


# --- the triangle, in complex numbers over any field: pairs (x, y) --------------------------------------------------


def parameters_of(dyad, side: str, poses):
    """(s_A, s_B) of the second and third pose, with A the joint that turns twice."""
    return [dyad.parameters(pose)[:: 1 if side == "base" else -1] for pose in poses[1:]]


def triangle(dyad, side: str, poses):
    """The vertices s_B1, s_B2, z* as pairs (x, y); for half-turns of length 1."""
    (a1, b1), (a2, b2) = parameters_of(dyad, side, poses)
    y = (b2 - b1) / (a2 - a1)  # b1 + a1 (−y) = b2 + a2 (−y), with z = b + λ(a − √−1), λ = −y
    return (b1, 0 * y), (b2, 0 * y), (b1 - a1 * y, y)


def minus(p, q):
    return p[0] - q[0], p[1] - q[1]


def cross(p, q):
    return p[0] * q[1] - p[1] * q[0]


def dot(p, q):
    return p[0] * q[0] + p[1] * q[1]


def line_through(p, q, z):
    """0 if z is on the line p ∨ q."""
    return cross(minus(q, p), minus(z, p))


def on_circle(p, q, r, z):
    """0 if z is on the circle through p, q, r."""
    (a, b), (d, e), (g, h) = (minus(v, z) for v in (p, q, r))
    c, f, k = a * a + b * b, d * d + e * e, g * g + h * h
    return a * (e * k - f * h) - b * (d * k - f * g) + c * (d * h - e * g)


def isogonal(corners, z):
    """The isogonal conjugate in barycentric coordinates: a²/u : b²/v : c²/w."""
    p, q, r = corners
    squares = [dot(minus(x, y), minus(x, y)) for x, y in ((q, r), (r, p), (p, q))]
    areas = [line_through(q, r, z), line_through(r, p, z), line_through(p, q, z)]
    weights = [s / a for s, a in zip(squares, areas, strict=True)]
    return tuple(sum(w * v[n] for w, v in zip(weights, corners, strict=True)) / sum(weights) for n in (0, 1))


def bad_place(corners, z) -> str | None:
    """The name of a bad z by its geometry, exactly."""
    p, q, r = corners
    if z[1] == 0:
        return REAL
    if z == r:
        return BENNETT
    if on_circle(p, q, r, z) == 0:
        return CIRCUMCIRCLE
    if line_through(p, r, z) == 0:
        return MISSES_2
    if line_through(q, r, z) == 0:
        return MISSES_1
    partner = isogonal(corners, z)
    if z in ((0, 1), (0, -1)) or partner in ((0, 1), (0, -1)):
        return NO_5R
    return CENTRE if partner == z else None


def rational(value) -> Fraction:
    return Fraction(float(value)).limit_denominator(10**4)


def rational_triangle(dyad, side, poses):
    return [tuple(map(rational, corner)) for corner in triangle(dyad, side, poses)]


def poses_of_parameters(first, second):
    """Exact poses on a dyad with rational axes, from s_A and s_B of the second and of the third pose."""
    h_a, h_b = i, translation([2, 0, 4]) * (3 * j + 4 * k) / 5 * translation([-2, 0, -4])
    return [one, *((s_a - h_a) * (s_b - h_b) for s_a, s_b in (first, second))]


OBLIQUE = poses_of_parameters((2, 1), (-1, 3))
THREE_FOUR_FIVE = poses_of_parameters((0, 0), (Fraction(4, 3), 4))  # the triangle 0, 4, 3√−1: rational centres


# --- what every 5R linkage must satisfy -----------------------------------------------------------------------------

SEEDS = range(3)
Z = [0.3 + 0.7j, -1.2 - 0.4j, 2 - 3j]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("z", Z)
def test_three_poses_are_visited_and_the_loop_closes(seed, z):
    poses = random_poses(3, seed=seed)
    linkages = goldberg_linkages(*poses, z)
    assert len(linkages) == 8
    for linkage in linkages:
        assert_visits(linkage, *poses)
        assert_closes(linkage, rtol=1e-11)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("z", Z)
def test_five_different_axes_mobility_one_rank_four(seed, z):
    for linkage in goldberg_linkages(*random_poses(3, seed=seed), z):
        lines = linkage.axes.coeffs[:, [1, 2, 3, 5, 6, 7]]
        pairs = [(m, n) for m in range(5) for n in range(m)]
        assert not any(same_point(lines[m], lines[n]) for m, n in pairs)
        assert np.linalg.matrix_rank(lines, rtol=1e-8) == 4
        assert linkage.mobility() == linkage.mobility(0.4) == 1


@pytest.mark.parametrize("seed", SEEDS)
def test_the_eight_linkages_are_different(seed):
    linkages = goldberg_linkages(*random_poses(3, seed=seed), Z[0])
    axes = [linkage.axes.coeffs for linkage in linkages]
    assert not any(np.all(same_point(axes[m], axes[n])) for m in range(8) for n in range(m))


@pytest.mark.parametrize("seed", SEEDS)
def test_each_contains_its_dyad_with_the_right_joint_turning_twice(seed):
    poses = random_poses(3, seed=seed)
    dyads = dyads_through_poses(*poses)
    linkages = goldberg_linkages(*poses, Z[1])
    for group, (number, side) in enumerate(GROUPS):
        for linkage in linkages[2 * group : 2 * group + 2]:
            assert same_point(linkage.axes[0], dyads[number].h1)
            assert same_point(linkage.axes[1], dyads[number].h2)
            assert linkage.joints == ((2, 1, 1, 1, 1) if side == "base" else (1, 2, 1, 1, 1))


@pytest.mark.parametrize("seed", range(10))
def test_goldbergs_conditions(seed):
    """Four links share distance / sine of twist; two are congruent; offsets vanish but for an equal pair."""
    poses = random_poses(3, seed=seed)
    mu1, _, mu3 = study_eigenvalues(*poses)
    for linkage in goldberg_linkages(*poses, Z[0]):
        rows = linkage.denavit_hartenberg()
        ratios = np.abs([row.distance / np.sin(row.twist) for row in rows])
        shared = np.isclose(ratios, (mu3 - mu1) / 2, rtol=1e-7)
        assert shared.sum() == 4
        double, scale = linkage.joints.index(2), max(row.distance for row in rows)
        other = int(np.flatnonzero(~shared)[0])
        assert {other, (other + 1) % 5} & {double, (double + 1) % 5} == set()  # the odd link is opposite the joint
        offsets = np.array([row.offset for row in rows])
        ends = [other, (other + 1) % 5]
        assert np.isclose(abs(offsets[ends[0]]), abs(offsets[ends[1]]), rtol=1e-7)
        assert abs(offsets[ends[0]]) > 1e-6 * scale
        assert np.all(np.abs(np.delete(offsets, ends)) < 1e-7 * scale)
        before, after = rows[other - 1], rows[(other + 1) % 5]
        assert np.isclose(before.distance, after.distance, rtol=1e-7)
        assert np.isclose(abs(np.sin(before.twist)), abs(np.sin(after.twist)), rtol=1e-7)


def degrees(linkage) -> dict:
    pairs = [(m, n) for n in range(5) for m in range(n)]
    return {pair: linkage.relative_motion(*pair).degree for pair in pairs if pair not in ADJACENT and pair != (0, 4)}


@pytest.mark.parametrize("seed", SEEDS)
def test_degrees_of_relative_motions(seed):
    """The link opposite the joint that turns twice sees degree two on both sides."""
    linkages = goldberg_linkages(*random_poses(3, seed=seed), Z[2])
    for linkage in linkages:
        if linkage.joints[0] == 2:
            assert degrees(linkage) == {(0, 2): 3, (1, 4): 3, (0, 3): 2, (1, 3): 2, (2, 4): 2}
        else:
            assert degrees(linkage) == {(0, 2): 3, (1, 3): 3, (0, 3): 2, (1, 4): 2, (2, 4): 2}


# --- the two admissible partners and no others -----------------------------------------------------------------------


def five_axes(first, second) -> bool:
    """Whether two factorizations of a cubic make a loop of five different axes."""
    loop = Linkage.from_chains(first, second)
    lines = [h.coeffs[[1, 2, 3, 5, 6, 7]] for h in loop.axes]
    distinct = [n for n in range(6) if not same_point(lines[n], lines[n - 1], rtol=1e-6)]
    return len(distinct) == 5 and not any(
        same_point(lines[m], lines[n], rtol=1e-6) for m in distinct for n in distinct if m < n
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_the_two_partners_and_no_others(seed):
    """Of the six factorizations two have A twice in a row; of the other four just two close a loop of five axes."""
    linkages = goldberg_linkages(*random_poses(3, seed=seed), Z[0])
    for group in range(4):
        pair = linkages[2 * group : 2 * group + 2]
        first = pair[0].factors[:3]
        assert all(same_point(f, g) for f, g in zip(first, pair[1].factors[:3], strict=True))
        motion = pair[0].coupler_motion * pair[0].home.inverse()
        good = [chain for chain in factorizations(motion) if five_axes(first, chain)]
        assert len(good) == 2
        for linkage in pair:
            second = [f.conjugate() for f in reversed(linkage.factors[3:])]
            assert sum(all(same_point(h, k, rtol=1e-6) for h, k in zip(second, c, strict=True)) for c in good) == 1


@pytest.mark.parametrize("seed", SEEDS)
def test_swapping_the_turns_about_one_axis_changes_nothing(seed):
    for linkage in goldberg_linkages(*random_poses(3, seed=seed), Z[0]):
        twice = linkage.joints.index(2)
        a, b = linkage.joint_factors(twice)
        assert_same_point(a * b, b * a)
        assert not same_point(a, b)


# --- z and its partner ----------------------------------------------------------------------------------------------


def z_pair(linkage, dyads, group: int):
    """The complex numbers z1, z2 of the two factors that share an axis, with the dyad's half-turn as √−1."""
    number, side = GROUPS[group]
    axis = dyads[number].h1 if side == "base" else dyads[number].h2
    return [complex(f.scalar_part, null_form(f, axis)) for f in linkage.joint_factors(linkage.joints.index(2))]


@pytest.mark.parametrize("seed", range(10))
def test_the_partner_of_z_is_its_isogonal_conjugate(seed):
    poses = random_poses(3, seed=seed)
    dyads = dyads_through_poses(*poses)
    for z in Z:
        linkages = goldberg_linkages(*poses, z)
        for group, (number, side) in enumerate(GROUPS):
            corners = triangle(dyads[number], side, poses)
            expected = complex(*isogonal(corners, (z.real, z.imag)))
            found = z_pair(linkages[2 * group], dyads, group)
            found = found if np.isclose(found[0], z) else found[::-1]
            assert np.allclose(found, [z, expected], rtol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_z_and_its_partner_give_the_same_linkages(seed):
    poses = random_poses(3, seed=seed)
    dyads, linkages = dyads_through_poses(*poses), goldberg_linkages(*poses, Z[0])
    for group in range(4):
        pair = linkages[2 * group : 2 * group + 2]
        partner = next(z for z in z_pair(pair[0], dyads, group) if not np.isclose(z, Z[0]))
        again = goldberg_linkages(*poses, partner)[2 * group : 2 * group + 2]
        for linkage in pair:
            assert sum(np.all(same_point(linkage.axes, other.axes, rtol=1e-6)) for other in again) == 1


def test_z_star_belongs_to_the_bennett_linkage():
    """(t − z*)(t − h_B) is a conic through the poses."""
    poses = random_poses(3, seed=4)
    for dyad in dyads_through_poses(*poses):
        (_, b1), (_, b2) = parameters_of(dyad, "base", poses)
        x, y = triangle(dyad, "base", poses)[2]
        for t, pose in ((b1, poses[1]), (b2, poses[2])):
            assert_same_point((t - x - y * dyad.h1) * (t - dyad.h2) * dyad.home, pose)


@pytest.mark.parametrize("seed", range(10))
def test_the_joint_turns_twice_or_swings(seed):
    random = np.random.default_rng(seed)
    z = complex(*random.normal(size=2))
    poses = random_poses(3, seed=seed)
    dyads = dyads_through_poses(*poses)
    for n, linkage in enumerate(goldberg_linkages(*poses, z)):
        z1, z2 = z_pair(linkage, dyads, n // 2)
        rounds = linkage.joint_angles(-math.inf) / (2 * math.pi)
        twice = linkage.joints.index(2)
        assert np.isclose(abs(rounds[twice]), 2 if z1.imag * z2.imag > 0 else 0)
        assert np.allclose(np.abs(np.delete(rounds, twice)), 1)


# --- bad places -----------------------------------------------------------------------------------------------------


def bad_numbers(corners):
    """One exact z for each bad place of a rational triangle, and its name."""
    p, q, r = corners
    middle = [tuple((x[n] + 2 * y[n]) / 3 for n in (0, 1)) for x, y in ((p, r), (q, r))]
    reflected = (p[0] + q[0] - r[0], -r[1])  # point reflection of z* in the middle of the real side
    return {
        "real axis": ((p[0] + Fraction(1, 7), 0), REAL),
        "z*": (r, BENNETT),
        "circumcircle": (second_meeting(corners, Fraction(1, 3)), CIRCUMCIRCLE),
        "circumcircle again": (second_meeting(corners, Fraction(-7, 2)), CIRCUMCIRCLE),
        "side s_B1 z*": (middle[0], MISSES_2),
        "side s_B2 z*": (middle[1], MISSES_1),
        "longer side s_B1 z*": (tuple(3 * r[n] - 2 * p[n] for n in (0, 1)), MISSES_2),
        "z = i": ((0, 1), NO_5R),
        "z = -i": ((0, -1), NO_5R),
        "partner i": (isogonal(corners, (Fraction(0), Fraction(1))), NO_5R),
        "parallelogram": (reflected, None),
    }


def second_meeting(corners, slope):
    """Where the line through s_B1 with a slope meets the circumcircle again."""
    p, q, r = corners
    # x² + y² + a x + b y = 0 in coordinates with s_B1 = 0
    (u, _), (v, w) = minus(q, p), minus(r, p)
    a = -u
    b = -(v * v + w * w + a * v) / w
    x = -(a + b * slope) / (1 + slope * slope)
    return p[0] + x, slope * x


PLACES = [
    "real axis", "z*", "circumcircle", "circumcircle again", "side s_B1 z*", "side s_B2 z*", "longer side s_B1 z*",
    "z = i", "z = -i", "partner i", "parallelogram",
]  # fmt: skip


@cache
def oblique_dyads():
    return dyads_through_poses(*OBLIQUE)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("group", range(4))
def test_exact_bad_numbers_are_named(group, place):
    number, side = GROUPS[group]
    corners = triangle(oblique_dyads()[number], side, OBLIQUE)
    z, name = bad_numbers(corners)[place]
    assert bad_place(corners, z) == name
    if name is None:
        return
    with pytest.raises(DegenerateError, match=rf"dyad \d, (base|moving) joint turning twice: .*{name}") as caught:
        goldberg_linkages(*OBLIQUE, z)
    others = [bad_place(triangle(oblique_dyads()[n], s, OBLIQUE), z) for n, s in GROUPS[:group]]
    if others == [None] * group:
        assert f"dyad {number + 1}, {side}" in str(caught.value)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("group", range(4))
def test_bad_numbers_in_floats_spoil_only_their_linkages(group, place):
    poses = as_floats(OBLIQUE)
    dyads = dyads_through_poses(*poses)
    number, side = GROUPS[group]
    (x, y), name = bad_numbers(rational_triangle(dyads[number], side, poses))[place]
    z = complex(x, y)
    linkages = goldberg_linkages(*poses, z, degenerate="nan")
    for n, (other, kind) in enumerate(GROUPS):
        expected = bad_place(rational_triangle(dyads[other], kind, poses), (x, y))
        for linkage in linkages[2 * n : 2 * n + 2]:
            assert np.isnan(linkage.closure_residual()) == (expected is not None)
            assert np.isnan(linkage.axes.coeffs).all() == (expected is not None)
    if name:
        with pytest.raises(DegenerateError, match=r"dyad \d, (base|moving) joint turning twice: "):
            goldberg_linkages(*poses, z)


@pytest.mark.parametrize("kind", [int, float])
def test_centres_of_the_triangle_are_their_own_partners(kind):
    poses = as_floats(THREE_FOUR_FIVE) if kind is float else THREE_FOUR_FIVE
    dyads, tried = dyads_through_poses(*poses), 0
    for number, side in GROUPS:
        corners = rational_triangle(dyads[number], side, poses)
        p, q, r = corners
        squares = [dot(minus(x, y), minus(x, y)) for x, y in ((q, r), (r, p), (p, q))]
        sides = [Fraction(math.sqrt(s)).limit_denominator(1000) for s in squares]
        if any(a * a != s for a, s in zip(sides, squares, strict=True)):
            continue
        for signs in ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)):
            weights = [sign * a for sign, a in zip(signs, sides, strict=True)]
            z = tuple(sum(w * v[n] for w, v in zip(weights, corners, strict=True)) / sum(weights) for n in (0, 1))
            given = complex(*z) if kind is float else z
            with pytest.raises(DegenerateError, match=CENTRE):
                goldberg_linkages(*poses, given)
            tried += 1
    assert tried >= 4


def test_no_linkage_that_misses_a_pose_is_returned_for_small_rational_z():
    """A scan: what comes back visits the poses, and NaN comes back at just the bad places."""
    values = sorted({Fraction(n, d) for d in (1, 2, 3) for n in range(-4 * d, 4 * d + 1)})
    grid = [(x, y) for x in values for y in values]
    z = np.array([complex(x, y) for x, y in grid])
    for exact in (THREE_POSES, THREE_FOUR_FIVE, OBLIQUE):
        poses = as_floats(exact)
        dyads = dyads_through_poses(*poses)
        linkages = goldberg_linkages(*poses, z, degenerate="nan")
        for group, (number, side) in enumerate(GROUPS):
            corners = rational_triangle(dyads[number], side, poses)
            bad = np.array([bad_place(corners, point) is not None for point in grid])
            assert bad.sum() > len(values)
            for linkage in linkages[2 * group : 2 * group + 2]:
                residual, error = linkage.closure_residual(), pose_error(linkage, poses)
                assert np.array_equal(np.isnan(residual), bad)
                assert np.nanmax(residual) < 1e-9
                assert np.nanmax(error) < 1e-7


def test_exact_linkages_for_small_rational_z_never_miss_a_pose():
    dyads = oblique_dyads()
    triangles = [triangle(dyads[number], side, OBLIQUE) for number, side in GROUPS]
    returned = refused = 0
    for z in product(range(-3, 4), (-2, -1, 1, 2)):
        names = {bad_place(corners, z) for corners in triangles} - {None}
        if names:
            with pytest.raises(DegenerateError, match="|".join(names)):
                goldberg_linkages(*OBLIQUE, z)
            refused += 1
            continue
        for linkage in goldberg_linkages(*OBLIQUE, z):
            assert linkage.closure_residual() == 0
            assert_visits(linkage, *OBLIQUE)
        returned += 1
    assert returned > 5
    assert refused > 5


def test_nearly_real_numbers_are_named_real():
    for z in (1 + 1e-13j, -3 - 1e-13j):
        with pytest.raises(DegenerateError, match=REAL):
            goldberg_linkages(*as_floats(OBLIQUE), z)


@pytest.mark.parametrize("distance", [1e-3, 1e-5, 1e-7])
def test_next_to_the_bad_places_linkages_still_visit_the_poses(distance):
    poses = as_floats(OBLIQUE)
    dyads = dyads_through_poses(*poses)
    for group, (number, side) in enumerate(GROUPS):
        corners = rational_triangle(dyads[number], side, poses)
        for (x, y), _ in bad_numbers(corners).values():
            z = complex(x, y) + distance * (0.6 + 0.8j)
            for linkage in goldberg_linkages(*poses, z, degenerate="nan")[2 * group : 2 * group + 2]:
                if not np.isnan(linkage.closure_residual()):
                    assert pose_error(linkage, poses) < 1e-8 / distance
                    assert linkage.closure_residual() < 1e-8 / distance


def all_signs(poses, z):
    """The linkages for z, up to the orientation of the axes A and B: that of A conjugates z, that of B negates it."""
    signs = (z, -z, z.conjugate(), -z.conjugate())  # some of them may be badly placed
    return [linkage for w in signs for linkage in goldberg_linkages(*poses, w, degenerate="nan")]


# --- exact in, exact out --------------------------------------------------------------------------------------------

EXACT = {"rational": THREE_POSES, "equal linear terms": LINEAR_TERMS_EQUAL, "degree six": FIELD_OF_DEGREE_SIX}


@pytest.mark.parametrize("name", EXACT)
def test_exact_linkages_close_as_an_identity(name):
    poses = EXACT[name]
    linkages = goldberg_linkages(*poses, (Fraction(1, 2), 2))
    for number, linkage in enumerate(linkages):
        product_around = MotionPolynomial([one.coeffs])
        for f in linkage.factors if number in (0, 7) else ():
            product_around = product_around * linear_factor(f)
        assert all(c == c.scalar_part for c in product_around.coefficients)
        assert linkage.closure_residual() == 0
        for t, pose in zip(linkage.parameters, poses, strict=True):
            assert same_point(linkage.coupler_motion(t), pose)
        assert not any(isinstance(x, (float, np.floating)) for f in linkage.factors for x in f.coeffs)
    assert linkages[0].mobility() == linkages[2].mobility() == 1


def test_exact_linkages_are_those_of_floats():
    exact = goldberg_linkages(*THREE_POSES, (1, 3))
    floats = all_signs(as_floats(THREE_POSES), 1 + 3j)
    for linkage in exact:
        axes = linkage.axes.astype(float)
        assert any(np.all(same_point(axes, other.axes, rtol=1e-7)) for other in floats)


def test_a_pair_of_whole_numbers_is_exact_and_a_complex_number_is_not():
    assert goldberg_linkages(*THREE_POSES, (1, 3))[0].closure_residual() == 0
    floats = goldberg_linkages(*THREE_POSES, 1 + 3j)[0]
    assert floats.axes.coeffs.dtype == float
    assert_visits(floats, *as_floats(THREE_POSES))


# --- frames, batches, kinds of input --------------------------------------------------------------------------------


def same_linkages(first, second, move=lambda h: h) -> bool:
    """Whether two sets of linkages agree, in any order, after a displacement of the axes."""
    return all(any(np.all(same_point(move(a.axes), b.axes, rtol=1e-6)) for b in second) for a in first)


@pytest.mark.parametrize("seed", range(4))
def test_displacing_the_fixed_frame_displaces_the_linkages(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed + 20)
    here = all_signs(poses, Z[0])
    there = goldberg_linkages(*(g * pose for pose in poses), Z[0])
    assert same_linkages(there, here, lambda axes: g.conjugate() * axes * g)
    for linkage in there:
        assert_visits(linkage, *(g * pose for pose in poses))


@pytest.mark.parametrize("seed", range(4))
def test_displacing_the_moving_frame_leaves_the_linkages(seed):
    poses, g = random_poses(3, seed=seed), random_displacement(seed=seed + 20)
    there = goldberg_linkages(*(pose * g for pose in poses), Z[0])
    here = all_signs(poses, Z[0])
    assert same_linkages(there, here)
    for linkage in there:
        assert_visits(linkage, *(pose * g for pose in poses))


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("angle", [None, 0.3])
def test_every_scale(length, angle):
    poses = random_poses(3, seed=9, shape=(500,), length=length, angle=angle)
    for linkage in goldberg_linkages(*poses, Z[0]):
        assert np.quantile(pose_error(linkage, poses, length), 0.99) < 1e-9
        assert np.quantile(linkage.closure_residual(), 0.99) < 1e-9


def test_small_turns_keep_accuracy_relative_to_the_mechanism():
    poses = random_poses(3, seed=9, shape=(500,), angle=1e-3)
    for linkage in goldberg_linkages(*poses, Z[0]):
        assert np.quantile(pose_error(linkage, poses, reach(linkage)), 0.99) < 1e-9
        assert pose_error(linkage, poses, reach(linkage)).max() < 1e-8
        assert np.quantile(linkage.closure_residual(), 0.99) < 1e-9


def test_a_batch_is_the_loop_of_its_rows():
    poses, z = random_poses(3, seed=10, shape=(4,)), np.array([1 + 1j, -2 + 0.5j, 0.3 - 1j, 2j])
    together = goldberg_linkages(*poses, z)
    for n in range(4):
        single = goldberg_linkages(*(pose[n] for pose in poses), z[n])
        for batch, one_linkage in zip(together, single, strict=True):
            assert np.all(same_point(batch.axes[n], one_linkage.axes))
            assert np.allclose([t if np.ndim(t) == 0 else t[n] for t in batch.parameters], one_linkage.parameters)


def test_many_z_for_one_set_of_poses():
    poses, z = random_poses(3, seed=11), np.array([[1 + 1j, -2 + 0.5j], [0.3 - 1j, 2j]])
    together = goldberg_linkages(*poses, z)
    assert together[0].shape == (2, 2)
    for index in np.ndindex(2, 2):
        for batch, single in zip(together, goldberg_linkages(*poses, z[index]), strict=True):
            assert np.all(same_point(batch.axes[index], single.axes))
            assert_visits(batch[index], *poses)


def test_rows_with_bad_z_or_bad_poses_are_named_or_nan():
    poses = random_poses(3, seed=12, shape=(4,))
    coeffs = poses[1].coeffs.copy()
    coeffs[1] = ((0.5 - random_half_turns(1, seed=1)[0]) * poses[0][1]).coeffs  # a tangent plane
    poses[1] = DualQuaternion(coeffs)
    z = np.array([1 + 1j, 1 + 1j, 3, 1 + 1j])
    with pytest.raises(DegenerateError) as caught:
        goldberg_linkages(*poses, z)
    assert caught.value.rows in ((1,), (2,), (1, 2))
    for linkage in goldberg_linkages(*poses, z, degenerate="nan"):
        assert np.isnan(linkage.closure_residual()).tolist() == [False, True, True, False]
        assert np.isnan(linkage.axes.coeffs).all((-1, -2)).tolist() == [False, True, True, False]


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        ((one, one, THREE_POSES[1]), "poses 0 and 1 are equal"),
        ((one, 2 - i, THREE_POSES[2]), "tangent"),
        ((one, translation([0, 2, 0]), THREE_POSES[1]), "pure translation"),
    ],
)
def test_poses_without_5r_are_named(poses, message):
    for case in (poses, as_floats(poses)):
        with pytest.raises(DegenerateError, match=message):
            goldberg_linkages(*case, (1, 2))


@pytest.mark.parametrize("z", [math.nan, complex(1, math.inf), "z", None, [1 + 1j, math.nan], (1, math.nan), (1, None)])
def test_z_must_be_a_finite_number(z):
    with pytest.raises((ValueError, TypeError), match="expected"):
        goldberg_linkages(*random_poses(3, seed=13), z)


def test_matrices_and_transforms():
    poses = random_poses(3, seed=14)
    matrices = [as_matrix(pose) for pose in poses]
    expected = goldberg_linkages(*poses, Z[0])
    for given in (matrices, [RigidTransform.from_matrix(matrix) for matrix in matrices]):
        found = goldberg_linkages(*given, Z[0])
        for linkage in found:
            assert_visits(linkage, *poses)
        assert len(found) == len(expected)


def test_the_home_pose_of_the_dyads_is_the_first_pose():
    poses = random_poses(3, seed=15)
    dyad = dyads_through_poses(*poses)[0]
    assert isinstance(dyad, Dyad)
    for linkage in goldberg_linkages(*poses, Z[0]):
        assert_same_point(linkage.coupler_motion(math.inf), poses[0])
