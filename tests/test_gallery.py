"""The gallery: each example has the properties that it is there for."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

from kinlib import (
    DualQuaternion,
    bennett_linkage,
    conic_through,
    cubics_through,
    dyads_through_poses,
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


def test_every_example_is_tested_here():
    assert sorted(POSES) == sorted(gallery.__all__)


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
