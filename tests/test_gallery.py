"""The gallery: each example has the properties that it is there for."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

from kinlib import (
    Chain,
    DegenerateError,
    DualQuaternion,
    Line,
    Linkage,
    MotionPolynomial,
    bennett_linkage,
    conic_through,
    cubics_through,
    dyads_through_poses,
    factorizations,
    gallery,
    goldberg_linkages,
    is_null_line,
    null_form,
    one,
    quadratic_factors,
    same_point,
    study_eigenvalues,
    study_form,
)

TRIPLES = ["THREE_POSES", "LINEAR_TERMS_EQUAL", "FIELD_OF_DEGREE_SIX"]
POSES = [*TRIPLES, "FOUR_POSES"]
OF_THE_LITERATURE = [
    "POSES_OF_BRUNNTHALER", "BENNETT_OF_HEGEDUS", "PARALLELOGRAM", "THREE_ROTATIONS",
    "PLACES_OF_4R", "PLACES_OF_6R", "PLANE_FOLD", "LINE_SYMMETRIC",
]  # fmt: skip


def test_every_example_is_tested_here():
    assert sorted([*POSES, *OF_THE_LITERATURE]) == sorted(gallery.__all__)


@pytest.mark.parametrize("name", POSES)
def test_examples_are_exact_poses_in_general_position(name):
    poses = getattr(gallery, name)
    assert poses[0] == one
    assert all(isinstance(x, (int, np.integer, Fraction)) for pose in poses for x in pose.coeffs)
    assert all(study_form(pose, pose) == 0 and null_form(pose, pose) > 0 for pose in poses)
    assert all(study_form(p, q) != 0 for p, q in combinations(poses, 2))
    assert np.linalg.matrix_rank([pose.coeffs[:4].astype(float) for pose in poses]) == len(poses)
    assert not any(is_null_line(p, q) for p, q in combinations(poses, 2))


@pytest.mark.parametrize("name", TRIPLES)
def test_triples_have_two_dyads_with_skew_axes(name):
    poses = getattr(gallery, name)
    dyads = dyads_through_poses(*poses)
    for dyad in dyads:
        assert study_form(dyad.h1, dyad.h2) != 0
        assert null_form(dyad.h1, dyad.h2) ** 2 != null_form(dyad.h1, dyad.h1) * null_form(dyad.h2, dyad.h2)
    assert not same_point(dyads[0].h1.astype(float), dyads[1].h1.astype(float))
    mu = study_eigenvalues(*poses)
    assert np.diff(mu).min() > 1e-3 * (mu[-1] - mu[0])  # far from double roots


@pytest.mark.parametrize("name", TRIPLES)
def test_triples_have_quartics_without_double_roots(name):
    first, second = quadratic_factors(conic_through(*getattr(gallery, name)).norm_polynomial())
    assert (first != second).any()
    assert all(b * b - 4 * c < 0 for _, b, c in (first, second))


@pytest.mark.parametrize("name", TRIPLES)
def test_triples_have_linkages(name):
    poses = getattr(gallery, name)
    assert bennett_linkage(*poses).closure_residual() == 0
    assert len(goldberg_linkages(*(pose.astype(float) for pose in poses), 1 + 2j)) == 8


def test_three_poses_are_rational_throughout():
    assert all(float(x).is_integer() for pose in gallery.THREE_POSES for x in pose.coeffs)
    dyads = dyads_through_poses(*gallery.THREE_POSES)
    assert all(isinstance(x, (int, Fraction)) for d in dyads for h in (d.h1, d.h2) for x in h.coeffs)
    second = DualQuaternion([0, 0, 3, 4, 0, 0, -4, 3]) / 5
    axes = DualQuaternion([0, 0, 0, 1, 0, 0, 0, 0]), second
    assert any(same_point(d.h1, axes[0]) and same_point(d.h2, axes[1]) for d in dyads)


def test_the_linear_terms_are_equal():
    poses = gallery.LINEAR_TERMS_EQUAL
    norm = conic_through(*poses).norm_polynomial()
    assert norm.tolist() == [1, 0, 3, 0, 1]
    first, second = quadratic_factors(norm)
    assert first[1] == second[1]
    assert first[2] != second[2]


def test_the_field_has_degree_six():
    first, _ = quadratic_factors(conic_through(*gallery.FIELD_OF_DEGREE_SIX).norm_polynomial())
    fields = {x.field for x in first if hasattr(x, "field")}
    assert [field.degree for field in fields] == [6]
    a = fields.pop().generator
    assert a**6 + 8 * a**4 + 8 * a**2 == 16


def test_both_families_through_the_four_poses_are_real_and_rational():
    poses = gallery.FOUR_POSES
    assert all(float(x).is_integer() for pose in poses for x in pose.coeffs)
    for cubic, t3 in zip(cubics_through(*poses), (Fraction(4, 3), -1), strict=True):
        assert same_point(cubic(t3), poses[3])
        assert not any(cubic.study_polynomial())


# --- of the literature ------------------------------------------------------------------------------------------


def test_brunnthalers_poses_are_on_the_motion_that_is_published_with_them():
    """The coefficients are those of the documentation of rational-linkages, highest power first."""
    rows = [
        [0, 0, 0], [4440, 39870, 22134], [16428, 9927, -42966], [-37296, -73843, -115878],
        [0, 0, 0], [-1332, -14586, -7812], [-2664, -1473, 6510], [-1332, -1881, -3906],
    ]  # fmt: skip
    published = MotionPolynomial(np.array(rows).T).coefficients
    published = [
        DualQuaternion(c).eps_conjugate() if not isinstance(c, DualQuaternion) else c.eps_conjugate() for c in published
    ]
    corners = published[2], published[0] + published[1] + published[2], published[0]
    poses = gallery.POSES_OF_BRUNNTHALER
    assert all(any(same_point(pose, corner) for corner in corners) for pose in poses)
    assert all(study_form(p, p) == 0 and p.scalar_part == 0 for p in poses)
    linkage = bennett_linkage(*poses)
    assert linkage.closure_residual() == 0
    (a, alpha, _), (b, beta, _), *_ = linkage.denavit_hartenberg()
    assert abs(a / np.sin(alpha)) == pytest.approx(abs(b / np.sin(beta)))


def test_the_bennett_linkage_of_hegedus_moves():
    axes = gallery.BENNETT_OF_HEGEDUS
    assert all(h * h == -1 for h in axes)
    linkage = Linkage.from_axes(axes)
    assert linkage.closure_residual() == 0
    rows = linkage.denavit_hartenberg()
    assert [row.distance for row in rows] == pytest.approx([9, 45**0.5] * 2)
    assert [abs(row.twist) for row in rows] == pytest.approx([np.pi / 2, np.arccos(-2 / 3)] * 2)
    assert [abs(row.distance / np.sin(row.twist)) for row in rows] == pytest.approx([9] * 4)
    assert [row.offset for row in rows] == pytest.approx([0] * 4)


def test_the_parallelogram_has_equal_opposite_sides():
    linkage = Linkage.from_axes(gallery.PARALLELOGRAM)
    rows = linkage.denavit_hartenberg()
    assert [row.distance for row in rows] == pytest.approx([2, 2**0.5] * 2)
    assert linkage.relative_motion(0, 2).degree == 2


def test_the_three_rotations_give_rational_6r_of_both_kinds():
    first = gallery.THREE_ROTATIONS
    chains = factorizations(MotionPolynomial.from_factors(first))
    assert all(isinstance(x, (int, Fraction)) for chain in chains for f in chain for x in f.coeffs)
    loops = [Linkage.from_chains(first, chain) for chain in chains if chain[0] != first[0] and chain[2] != first[2]]
    assert len(loops) == 3
    kinds = [sorted(loop.degrees()[n, n + 3] for n in range(3)) for loop in loops]
    assert sorted(kinds) == [[1, 3, 3], [1, 3, 3], [3, 3, 3]]
    for loop in loops:
        found = Linkage.from_axes(loop.axes)
        assert found.closure_residual() == 0
        assert found.joints == (1,) * 6


def angle_symmetric(first):
    chains = factorizations(MotionPolynomial.from_factors(first))
    loops = [Linkage.from_chains(first, chain) for chain in chains]
    return next(loop for loop in loops if [bond.joints for bond in loop.bonds()] == [(0, 3), (1, 4), (2, 5)])


@pytest.mark.parametrize(
    ("linkage", "places", "clearance"),
    [
        (bennett_linkage(*(gallery.POSES_OF_BRUNNTHALER[n] for n in (2, 0, 1))), gallery.PLACES_OF_4R, 0.1071),
        (angle_symmetric(gallery.THREE_ROTATIONS), gallery.PLACES_OF_6R, 0.0389),
    ],
    ids=["4R", "6R"],
)
def test_joints_in_the_published_places_make_links_that_do_not_collide(linkage, places, clearance):
    """A link goes along the joint before it, and to where the next joint begins."""
    ends = np.array([line.foot([0, 0, 0]) + np.multiply.outer(place, line.direction)
                     for line, place in zip(map(Line.from_dual_quaternion, linkage.astype(float).axes), places,
                                            strict=True)])  # fmt: skip
    bent = np.concatenate([np.roll(ends, 1, axis=0), ends[:, :1]], axis=1)
    linkage = linkage.astype(float)
    assert linkage.clearance() == 0
    assert linkage.collisions(bars=bent).count == 0
    assert linkage.clearance(bars=bent) == pytest.approx(clearance, abs=1e-4)


def test_a_6r_folds_into_a_plane():
    linkage = angle_symmetric(gallery.PLANE_FOLD)
    assert all(h.coeffs[3] == h.coeffs[5] == h.coeffs[6] == 0 for h in linkage.axes)
    assert linkage.closure_residual() == 0
    assert linkage.mobility() == 1
    with pytest.raises(DegenerateError, match="flat or singular"):
        Linkage.from_axes(linkage.axes)
    assert Linkage.from_axes(linkage.at(1)).closure_residual() == 0


def test_the_line_symmetric_linkage_has_equal_opposite_links_and_another_motion():
    rows = Chain(gallery.LINE_SYMMETRIC).denavit_hartenberg()
    assert np.allclose(rows[:3], rows[3:])
    with pytest.raises(DegenerateError, match="is mobile, but its motion is not of this kind"):
        Linkage.from_axes(gallery.LINE_SYMMETRIC)
