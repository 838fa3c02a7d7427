"""The Study quadric, the null cone, the exceptional three-space and null lines."""

import numpy as np
import pytest
import sympy
from hypothesis import assume, given

from kinlib import (
    EXCEPTIONAL_SPACE,
    NULL_CONE,
    STUDY_QUADRIC,
    DegenerateError,
    DualQuaternion,
    act,
    eps,
    i,
    is_null_line,
    is_zero,
    j,
    join,
    k,
    null_form,
    one,
    same_point,
    study_form,
    study_projection,
    translation,
)
from strategies import dual_quaternions, poses, rotations, several

h1, h2 = i, j - eps * i


def norm_of(q: DualQuaternion) -> tuple:
    """The two parts of the dual number q q̄, by the product."""
    coeffs = (q * q.conjugate()).coeffs
    return coeffs[0], coeffs[4]


def test_ranks_and_signatures():
    assert (STUDY_QUADRIC.rank(), STUDY_QUADRIC.signature()) == (8, (4, 4))
    assert (NULL_CONE.rank(), NULL_CONE.signature()) == (4, (4, 0))


@given(several(1))
def test_the_study_quadric_is_where_the_norm_is_real(only):
    (q,) = only
    assert STUDY_QUADRIC.contains(q) == (norm_of(q)[1] == 0)


@given(several(1))
def test_the_null_cone_is_where_the_norm_has_no_real_part(only):
    (q,) = only
    assert NULL_CONE.contains(q) == (norm_of(q)[0] == 0)


@given(dual_quaternions())
def test_the_real_null_cone_is_the_exceptional_space(q):
    assume(q != 0)
    assert NULL_CONE.contains(q) == (q.primal == 0) == (q in EXCEPTIONAL_SPACE)


def test_the_exceptional_space_is_singular_on_the_null_cone_and_lies_on_the_study_quadric():
    assert EXCEPTIONAL_SPACE.dimension == 3
    assert all(x in EXCEPTIONAL_SPACE for x in DualQuaternion(NULL_CONE.singular_points()))
    assert STUDY_QUADRIC.contains(EXCEPTIONAL_SPACE)


@given(several(2))
def test_the_forms_are_the_parts_of_a_polarised_norm(two):
    x, y = two
    mixed = (x * y.conjugate() + y * x.conjugate()).coeffs
    assert 2 * null_form(x, y) == mixed[0]
    assert 2 * study_form(x, y) == mixed[4]
    assert study_form(x, y) == STUDY_QUADRIC.form(x, y)
    assert null_form(x, y) == NULL_CONE.form(x, y)


def test_forms_of_batches():
    x = DualQuaternion.stack([one, i, eps * i])
    assert study_form(x, eps * i).tolist() == [0, 1, 0]
    assert null_form(x, i).tolist() == [0, 1, 0]


@given(rotations(), rotations())
def test_two_rotations_about_one_line_or_intersecting_lines_are_conjugate(g, h):
    """The study form of two half-turns vanishes exactly if their axes have a common plane."""
    l, m = (q.coeffs[1:4] for q in (g, h))
    u, v = (q.coeffs[5:8] for q in (g, h))
    assert study_form(g, h) == l @ v + m @ u


@given(poses())
def test_displacements_are_on_the_study_quadric(q):
    assert STUDY_QUADRIC.contains(q)
    assert not NULL_CONE.contains(q)


def test_lemma_1_for_all_lines():
    """A point of the line x ∨ y has a norm that is a combination of the three conditions."""
    x, y = (DualQuaternion(sympy.symbols(f"{name}:8")) for name in "xy")
    s, t = sympy.symbols("s t")
    conditions = x.norm() * s**2 + y.norm() * t**2 + (x * y.conjugate() + y * x.conjugate()) * (s * t)
    assert (s * x + t * y).norm() == conditions


NULL_LINES = [
    (1j - h1, (1j - h1) * h2),
    (1j - h2, h1 * (1j - h2)),
    (eps, eps * i),
    (1j + i, eps * (1j + i)),
]


@pytest.mark.parametrize(("x", "y"), NULL_LINES)
def test_null_lines_lie_on_both_quadrics(x, y):
    assert is_null_line(x, y)
    for s, t in ((1, 0), (0, 1), (1, 1), (1, -1), (2j, 3)):
        assert STUDY_QUADRIC.contains(s * x + t * y)
        assert NULL_CONE.contains(s * x + t * y)


def test_null_lines_in_exact_complex_numbers():
    x = sympy.I - h1
    assert is_null_line(x, x * h2)
    assert not is_null_line(x, x.conjugate() * h2)


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (one, i),  # on the Study quadric, not on the null cone
        (1j - h1, 1j + h1),  # both points are null, the third condition fails
        (1j - h1, i + eps),  # only one point is null
        (i + eps, 1j - h1),
        (1j + i + eps, eps),  # on the null cone, not on the Study quadric
    ],
)
def test_each_condition_of_lemma_1_is_needed(x, y):
    assert not is_null_line(x, y)


def test_nearly_null_lines_are_not_null():
    x, y = 1j - h1, (1j - h1) * h2
    assert is_null_line(x + 1e-11 * one, y)
    assert not is_null_line(x + 1e-6 * one, y)
    assert not is_null_line(x, y + 1e-6 * k)
    assert not is_null_line(1e-6 * one, 1e-6 * i)


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6, 1e9])
def test_null_lines_at_every_length(length):
    h2 = j - length * eps * i
    assert is_null_line(1j - h1, (1j - h1) * h2)
    assert not is_null_line(translation([length, 0.0, 0]), translation([0, length, 0.0]))
    assert not NULL_CONE.contains(translation([length, 0.0, 0]))
    assert not STUDY_QUADRIC.contains(translation([length, 0.0, 0]) + 1e-3 * length * eps)


@given(dual_quaternions())
def test_the_projection_to_the_study_quadric(q):
    assume(q.primal != 0)
    p = study_projection(q)
    assert STUDY_QUADRIC.contains(p)
    assert same_point(p.primal, q.primal)
    assert p in join(q, eps * q.primal)


@given(poses())
def test_the_projection_fixes_displacements(q):
    assert same_point(study_projection(q), q)


@given(dual_quaternions(), poses(), poses())
def test_the_projection_commutes_with_changes_of_frames(q, g, h):
    assume(q.primal != 0)
    assert same_point(study_projection(g * q * h), g * study_projection(q) * h)


def test_the_projection_keeps_the_fixed_point_of_its_fibre():
    assert act(study_projection(1 + eps), [1, 2, 3]).tolist() == [1, 2, 3]
    x = sympy.Symbol("x")
    assert study_projection(1 + x * eps) == 2


def test_the_projection_of_a_batch():
    q = DualQuaternion(np.random.default_rng(0).normal(size=(5, 8)))
    assert STUDY_QUADRIC.contains(study_projection(q)).all()
    assert all(same_point(study_projection(q)[n], study_projection(q[n])) for n in range(5))


@pytest.mark.parametrize("q", [eps, eps * (i + k), 0 * one, 0.0 * one, DualQuaternion.stack([one, eps])])
def test_the_exceptional_space_has_no_projection(q):
    with pytest.raises(DegenerateError, match="primal part"):
        study_projection(q)


def test_the_form_of_skew_lines():
    assert study_form(h1, h2) == -1
    assert is_zero(study_form(h1, h1))


def test_rows_of_the_exceptional_space_may_become_nan():
    for q in (DualQuaternion.stack([1 + eps, eps, i]), 1.0 * DualQuaternion.stack([1 + eps, eps, i])):
        with pytest.raises(DegenerateError, match="row 1: ") as caught:
            study_projection(q)
        assert caught.value.rows == (1,)
        projected = study_projection(q, degenerate="nan")
        assert np.isnan(projected.coeffs).all(axis=-1).tolist() == [False, True, False]
        assert projected[0] == 2


@pytest.mark.parametrize("wrong", [None, [1] * 8, np.eye(4), "x"])
def test_other_things_are_no_points_of_the_seven_space(wrong):
    for use in (study_projection, lambda w: is_null_line(i, w), lambda w: is_null_line(w, i)):
        with pytest.raises(TypeError, match="expected a dual quaternion"):
            use(wrong)


def test_a_null_line_is_one_line():
    batch = DualQuaternion.stack([eps, eps * i])
    with pytest.raises(ValueError, match="expected two single points"):
        is_null_line(batch, eps * j)
