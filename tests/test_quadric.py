"""Quadrics: their forms, tangents, sections and rulings."""

import copy
import pickle
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from kinlib import (
    STUDY_QUADRIC,
    DualQuaternion,
    Line,
    NumberFieldElement,
    Quadric,
    Subspace,
    binary_roots,
    j,
    join,
    one,
    same_point,
)
from strategies import fractions, large, whole

SADDLE = Quadric([[0, 0, 0, 1], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, 0, 0]])  # x₀x₃ = x₁x₂
SPHERE = Quadric(np.diag([-1, 1, 1, 1]))
HYPERBOLOID = Quadric(np.diag([-1, 1, 1, -1]))
CONE = Quadric(np.diag([0, 1, 1, -1]))
points = st.lists(whole, min_size=4, max_size=4).filter(any)


@st.composite
def quadrics(draw, scalars=whole, size=4):
    upper = np.array(draw(st.lists(scalars, min_size=size * size, max_size=size * size)), dtype=object)
    upper = np.triu(upper.reshape(size, size))
    return Quadric(upper + upper.T)


@given(quadrics(), points, points, points, whole)
def test_the_form_is_bilinear_and_symmetric(Q, x, y, z, n):
    x, y, z = map(np.array, (x, y, z))
    assert Q.form(x, y) == Q.form(y, x) == sum(Q.matrix[r, s] * x[r] * y[s] for r in range(4) for s in range(4))
    assert Q.form(n * x + y, z) == n * Q.form(x, z) + Q.form(y, z)


@given(quadrics(large, size=2), large, large)
def test_the_form_does_not_overflow(Q, x, y):
    (a, b), (_, c) = Q.matrix.tolist()
    assert Q.form([x, y], [x, y]) == a * x * x + 2 * b * x * y + c * y * y


@given(quadrics(), points)
def test_a_point_is_on_the_quadric_if_it_is_conjugate_to_itself(Q, x):
    assert Q.contains(x) == (Q.form(x, x) == 0)
    assert Q.tangent_hyperplane(x) @ np.array(x) == Q.form(x, x)


@given(quadrics())
def test_rank_and_singular_points(Q):
    assert Q.rank() == sympy.Matrix(Q.matrix).rank() == 4 - len(Q.singular_points())
    assert all(not Q.tangent_hyperplane(x).any() for x in Q.singular_points())


@given(st.lists(st.sampled_from([-1, 0, 1]), min_size=4, max_size=4), st.lists(whole, min_size=16, max_size=16))
def test_inertia_does_not_depend_on_coordinates(signs, entries):
    change = np.array(entries).reshape(4, 4)
    assume(sympy.Matrix(change).det())
    assert Quadric(change.T @ np.diag(signs) @ change).signature() == (signs.count(1), signs.count(-1))


@given(quadrics(), st.lists(points, min_size=2, max_size=3), st.lists(fractions, min_size=3, max_size=3))
def test_the_section_with_a_subspace(Q, rows, weights):
    assume(sympy.Matrix(rows).rank() == len(rows))
    A, weights = Subspace(rows), weights[: len(rows)]
    x = np.array(weights, dtype=object) @ np.array(rows)
    assert Q.restrict(A).form(weights, weights) == Q.form(x, x)


def test_batches():
    assert SPHERE.contains([[1, 1, 0, 0], [1, 1, 1, 0]]).tolist() == [True, False]
    assert SPHERE.contains(np.array([[1.0, 1, 0, 0], [1, 1, 1, 0]])).tolist() == [True, False]
    assert SPHERE.form([[1, 1, 0, 0], [1, 1, 1, 0]], [1, 0, 0, 0]).tolist() == [-1, -1]


def test_floats_are_on_the_quadric_up_to_rounding():
    assert SPHERE.contains([1e8, 0.6e8, 0.8e8, 0])
    assert not SPHERE.contains([1e-8, 0.6e-8, 0.8e-8, 1e-9])
    assert SPHERE.contains([1.0, 1, 0, 1e-4], rtol=1e-7)


def test_a_small_coordinate_is_not_lost_beside_a_large_one():
    cylinder = Quadric(np.diag([-1, 1, 1, 0]))
    assert cylinder.contains([1.0, 0.6, 0.8, 1e9])
    assert not cylinder.contains([1.0, 0.6, 0.7, 1e9])


def test_a_subspace_lies_on_the_quadric_or_not():
    assert SADDLE.contains(join([1, 0, 0, 0], [0, 1, 0, 0]))
    assert not SADDLE.contains(join([1, 0, 0, 0], [0, 0, 0, 1]))
    assert not SPHERE.contains(join([1, 1j, 1, -1], [1, -1j, 1, -1]))  # the join of two points of the sphere
    assert SPHERE.contains(join([1.0, 1, 0, 0], [0, 0, 0.6, 0.6j]))


@given(whole, whole, whole, whole)
def test_the_rulings_of_a_saddle(a, b, c, d):
    """With x = (ac, ad, bc, bd) on x₀x₃ = x₁x₂ the rulings fix the ratio a : b or c : d."""
    x = [a * c, a * d, b * c, b * d]
    assume(any(x))
    rulings = SADDLE.rulings_through(x)
    for ruling in rulings:
        assert x in ruling
        assert SADDLE.contains(ruling)
    expected = [join([a, 0, b, 0], [0, a, 0, b]), join([c, d, 0, 0], [0, 0, c, d])]
    assert any(all(A in B for A, B in zip(rulings, order, strict=True)) for order in (expected, expected[::-1]))


@pytest.mark.parametrize("scale", [1, 1.0, 1e-6, 1e6, Fraction(1, 3)])
def test_the_rulings_of_a_hyperboloid(scale):
    first, second = HYPERBOLOID.rulings_through([5 * scale, 3 * scale, 4 * scale, 0 * scale])
    assert first.dimension == second.dimension == 1
    assert HYPERBOLOID.contains(first)
    assert HYPERBOLOID.contains(second)
    assert first not in second


def test_irrational_rulings_are_exact():
    surface = Quadric(np.diag([-1, 1, 2, -1]))
    for ruling in surface.rulings_through([1, 1, 0, 0]):
        assert surface.contains(ruling)
        assert any(isinstance(c, NumberFieldElement) for c in ruling.basis.ravel())


def test_a_cone_has_one_line_through_a_point():
    first, second = CONE.rulings_through([7, 3, 4, 5])
    assert first in second
    assert [1, 0, 0, 0] in first


@pytest.mark.parametrize(
    ("surface", "point", "message"),
    [
        (SADDLE, [1, 0, 0, 1], "expected a point on a quadric surface"),
        (Quadric(np.diag([1, -1, 0])), [1, 1, 0], "expected a point on a quadric surface"),
        (CONE, [1, 0, 0, 0], "singular at this point"),
        (SPHERE, [1, 1, 0, 0], "complex"),
    ],
)
def test_where_there_are_no_two_rulings(surface, point, message):
    with pytest.raises(ValueError, match=message):
        surface.rulings_through(point)


@given(whole, whole, whole)
def test_roots_of_binary_forms(a, b, c):
    assume(any((a, b, c)) and b * b >= a * c)
    roots = binary_roots(a, b, c)
    assert all(a * s * s + 2 * b * s * t + c * t * t == 0 for s, t in roots)
    assert same_point(*roots) == (b * b == a * c)


@pytest.mark.parametrize(
    "form", [(1e-12, 1.0, 1.0), (1.0, 1e8, 1.0), (0.0, 1.0, 5.0), (1.0, 1.0, 0.0), (4.0, 2.0, 1.0)]
)
def test_roots_of_binary_forms_do_not_cancel(form):
    a, b, c = form
    for s, t in binary_roots(*form):
        terms = (a * s * s, 2 * b * s * t, c * t * t)
        assert abs(sum(terms)) <= 1e-14 * sum(map(abs, terms))


@pytest.mark.parametrize(("form", "message"), [((1, 0, 1), "complex"), ((0, 0, 0), "every point")])
def test_binary_forms_without_two_real_roots(form, message):
    with pytest.raises(ValueError, match=message):
        binary_roots(*form)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ([[1, 2, 3]], "expected a square matrix"),
        ([1, 2], "expected a square matrix"),
        ([[1, 2], [3, 4]], "expected a symmetric matrix"),
        ([[1.0, 2.0], [2.001, 4.0]], "expected a symmetric matrix"),
    ],
)
def test_the_matrix_is_square_and_symmetric(matrix, message):
    with pytest.raises(ValueError, match=message):
        Quadric(matrix)


def test_a_quadric_does_not_change():
    with pytest.raises(ValueError, match="read-only"):
        SPHERE.matrix[0, 0] = 7
    with pytest.raises(AttributeError):
        SPHERE.matrix = np.eye(4)


@given(quadrics(), st.lists(points, min_size=1, max_size=3))
def test_the_gram_matrix_holds_the_form_of_all_pairs(Q, rows):
    gram = Q.gram(rows)
    assert gram.shape == (len(rows), len(rows))
    assert gram.tolist() == [[Q.form(x, y) for y in rows] for x in rows]


def test_the_gram_matrix_takes_points_one_by_one():
    x, y = sympy.symbols("x y")
    Q = Quadric(np.diag([2, 0, 1, 0, 0, 0, 0, 0]))
    assert Q.gram([x * one + y * j, y * one]).tolist() == [[2 * x**2 + y**2, 2 * x * y], [2 * x * y, 2 * y**2]]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("far", [0.0, 1.0, 1e3])
def test_a_space_inside_the_study_quadric_is_known_in_floats(seed, far):
    """The axes of two joints that meet, or are parallel, span a space in the quadric: what is left is rounding."""
    rng = np.random.default_rng(seed)
    point, l1, l2 = np.array([far, 1, 1]) * rng.normal(size=3), *rng.normal(size=(2, 3))
    for other, direction in ((point, l2), (point + l2, l1)):
        h1, h2 = (Line.at(*pair).as_dual_quaternion() for pair in ((point, l1), (other, direction)))
        quadric = STUDY_QUADRIC.restrict(Subspace(DualQuaternion.stack([1.0 * one, h1, h2, h1 * h2]).coeffs))
        assert (quadric.rank(), quadric.signature()) == (0, (0, 0))
    skew = Line.at(point + np.cross(l1, l2), l2).as_dual_quaternion()
    quadric = STUDY_QUADRIC.restrict(Subspace(DualQuaternion.stack([1.0 * one, h1, skew, h1 * skew]).coeffs))
    assert (quadric.rank(), quadric.signature()) == (4, (2, 2))


def test_a_quadric_may_be_told_what_was_added_up():
    noise = Quadric([[1e-17, 0], [0, -1e-18]])
    assert (noise.rank(), noise.signature()) == (2, (1, 1))
    known = Quadric(noise.matrix, scale=1.0)
    assert (known.rank(), known.signature()) == (0, (0, 0))


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_quadrics_are_finite(number):
    with pytest.raises(ValueError, match="expected finite"):
        Quadric([[number, 0], [0, 1]])


@pytest.mark.parametrize("wrong", [None, "x", {}, [[None]]])
def test_other_things_are_no_points_and_matrices(wrong):
    for use in (
        Quadric,
        STUDY_QUADRIC.contains,
        STUDY_QUADRIC.tangent_hyperplane,
        lambda w: STUDY_QUADRIC.form(one, w),
    ):
        with pytest.raises(TypeError, match="expected numbers"):
            use(wrong)
    with pytest.raises(TypeError, match="expected a Subspace"):
        STUDY_QUADRIC.restrict(wrong)
    if wrong != [[None]] and wrong != {}:
        with pytest.raises(TypeError, match="expected numbers"):
            binary_roots(1, wrong, 2)


def test_points_of_another_space():
    for use in (STUDY_QUADRIC.contains, STUDY_QUADRIC.tangent_hyperplane, lambda x: STUDY_QUADRIC.gram([one, x])):
        with pytest.raises(ValueError, match=r"expected points of shape \(\.\.\., 8\), got \(3,\)"):
            use([1, 2, 3])


def test_copies_of_a_quadric_do_not_change():
    quadric = Quadric([[1.0, 0], [0, 1]], scale=2)
    for again in (pickle.loads(pickle.dumps(quadric)), copy.deepcopy(quadric)):
        assert again.scale == 2
        with pytest.raises(ValueError, match="read-only"):
            again.matrix[0, 0] = 7


def test_roots_are_of_real_forms():
    with pytest.raises(ValueError, match="expected a real form"):
        binary_roots(1j, 0, 1)


def test_roots_of_very_large_and_very_small_forms():
    tiny, huge = Fraction(1, 10**400), 10**400
    assert binary_roots(tiny, 0, -4 * tiny) == binary_roots(huge, 0, -4 * huge) == binary_roots(1, 0, -4)
    assert binary_roots(sympy.Integer(1), 0, sympy.Integer(-4)) == binary_roots(1, 0, -4)


@pytest.mark.parametrize("wrong", [[1, 2], np.ones(3)])
def test_roots_are_of_three_numbers(wrong):
    with pytest.raises(TypeError, match="expected three numbers"):
        binary_roots(1, wrong, 2)


def test_rulings_pass_through_one_point():
    with pytest.raises(ValueError, match="expected a single point"):
        SADDLE.rulings_through(np.eye(4, dtype=int))
