"""Points and subspaces of projective space."""

import copy
import pickle
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from kinlib import DualQuaternion, Line, Subspace, eps, i, j, join, k, meet, null_space, one, same_point, square_root
from strategies import dual_quaternions, fractions, several, whole

a = square_root(2)
x = sympy.Symbol("x")


def matrices(columns=5, scalars=whole):
    return st.lists(st.lists(scalars, min_size=columns, max_size=columns), min_size=1, max_size=columns + 1)


def rank(rows) -> int:
    return sympy.Matrix(rows).rank()


@given(dual_quaternions(), fractions.filter(bool))
def test_multiples_are_one_point(q, factor):
    assert same_point(q, factor * q) == (q != 0)


@given(several(2))
def test_points_are_the_same_exactly_if_all_minors_vanish(two):
    q, r = two
    minors = np.outer(q.coeffs, r.coeffs) - np.outer(r.coeffs, q.coeffs)
    assert same_point(q, r) == (not minors.any() and q != 0 and r != 0)


@pytest.mark.parametrize("factor", [-1, Fraction(2, 7), a, x, 1e-200, -1e200, 1e-3j])
def test_a_factor_of_any_kind_does_not_matter(factor):
    q = 3 - 2 * i + eps * j
    assert same_point(q, factor * q)
    assert not same_point(q, factor * (q + k))


def test_zero_is_no_point():
    zero = 0 * one
    assert not same_point(zero, zero)
    assert not same_point(zero, i)
    assert not same_point(0.0 * one, 1.0 * i)
    assert zero not in join(one, i)


def test_floats_agree_up_to_their_relative_tolerance():
    q = 1.0 + 2 * i
    assert same_point(q, (1 + 1e-10) * q + 1e-10 * k)
    assert not same_point(q, q + 1e-7 * k)
    assert same_point(q, q + 1e-4 * k, rtol=1e-3)


def test_exact_points_have_no_tolerance():
    assert not same_point(one, one + eps * Fraction(1, 10**30))
    assert not same_point(one, one + eps * Fraction(1, 10**30), length=1000)
    assert not same_point(10**30 * one, 10**30 * one + i)
    assert same_point(one * 10**400, one)
    assert same_point(one * Fraction(1, 10**400), one)


@pytest.mark.parametrize("length", [0.01, 1.5, 6.0, 1e6])
def test_a_float_and_an_exact_point_are_measured_alike(length):
    q = 1 + i + 6 * eps * j - Fraction(1, 3) * eps * k
    assert same_point(-0.7 * q.astype(float), q, length=length)
    assert same_point(q, -0.7 * q.astype(float), length=length)
    assert not same_point(q.astype(float), q.eps_conjugate(), length=length)


def test_lengths_are_measured_in_the_given_unit():
    q = 1.0 + 1e9 * eps * i
    assert same_point(q, q + 1e-2 * j)  # beside a dual part of 10⁹ the primal part is not seen
    assert not same_point(q, q + 1e-2 * j, length=1e9)


def test_not_a_number_is_no_point():
    assert not same_point(one * float("nan"), one * float("nan"))


def test_a_batch_is_answered_entry_by_entry():
    q = DualQuaternion.stack([one, i, 0 * one])
    assert same_point(q, 2 * one).tolist() == [True, False, False]
    assert same_point([[1, 2], [2, 4]], [1, 2]).tolist() == [True, True]


@given(matrices())
def test_the_null_space_is_all_that_is_mapped_to_zero(matrix):
    kernel = null_space(matrix)
    assert not (np.array(matrix, dtype=object) @ kernel.T).any()
    assert len(kernel) == 5 - rank(matrix)
    if len(kernel):
        assert rank(kernel) == len(kernel)


@given(matrices(3), st.integers(-6, 6))
def test_the_null_space_of_floats_has_the_same_dimension(matrix, power):
    scaled = np.array(matrix) * 10.0**power
    assert len(null_space(scaled)) == 3 - rank(matrix)


def test_the_null_space_over_other_scalars():
    assert null_space([[a, 1]]).tolist() == [[-1 / a, 1]]
    assert null_space([[x, 1]]).tolist() == [[-1 / x, 1]]
    assert null_space([[1j, 1]]).tolist() == [[1j, 1]]
    assert null_space(np.zeros((1, 2), dtype=int)).tolist() == [[1, 0], [0, 1]]


@given(matrices(), matrices())
def test_the_dimension_formula(first, second):
    assume(rank(first) and rank(second))
    A, B = join(*first), join(*second)
    assert join(A, B).dimension + meet(A, B).dimension == A.dimension + B.dimension
    assert join(A, B).dimension == rank(first + second) - 1


@given(matrices(), matrices())
def test_join_and_meet_bound_their_operands(first, second):
    assume(rank(first) and rank(second))
    A, B = join(*first), join(*second)
    assert A in join(A, B)
    assert B in join(A, B)
    assert meet(A, B) in A
    assert meet(A, B) in B


@given(matrices(), st.lists(whole, min_size=5, max_size=5).filter(any))
def test_a_point_is_in_the_join_exactly_if_it_depends_on_it(rows, point):
    assume(rank(rows))
    assert (point in join(*rows)) == (rank([*rows, point]) == rank(rows))


@given(matrices())
def test_the_equations_of_a_subspace(rows):
    assume(rank(rows))
    A = join(*rows)
    assert not (A.equations() @ A.basis.T).any()
    assert len(A.equations()) == 4 - A.dimension


def test_subspaces_of_dual_quaternions():
    line = join(one + i, 2 * one)
    assert line.dimension == 1
    assert i in line
    assert j not in line
    assert (line.points * j).shape == (2,)
    assert join(line, j) in join(one, i, j, k)
    assert meet(join(one, i, j), join(i, k)).contains(i)


@pytest.mark.parametrize("number", [a, 0.3, 1j])
def test_subspaces_over_other_numbers(number):
    line = join(one + number * i, k)
    assert one * number + number * number * i + 3 * k in line
    assert one + i not in line
    assert meet(line, join(one, i)).dimension == 0


def test_independence_does_not_depend_on_the_size_of_the_points():
    assert Subspace(np.diag([1e-20, 1.0, 1e20])).dimension == 2


def test_the_empty_set():
    empty = meet(join(one, i), join(j, k))
    assert empty.dimension == -1
    assert empty in join(one, i)
    assert one not in empty
    assert join(empty, i).dimension == 0
    assert meet(empty, join(one, i)).dimension == -1


def test_a_basis_is_independent():
    with pytest.raises(ValueError, match="expected independent points, got 2 of rank 1"):
        Subspace([[1, 2], [2, 4]])
    with pytest.raises(ValueError, match="expected independent points"):
        Subspace([[0.1, 0.2, 0.3], [0.3, 0.6, 0.9 + 1e-15]])


def test_a_basis_is_a_matrix():
    with pytest.raises(ValueError, match=r"expected a basis of shape \(d\+1, n\+1\), got \(3,\)"):
        Subspace([1, 2, 3])


def test_a_subspace_does_not_change():
    source = np.eye(3)
    plane = Subspace(source[:2])
    source[:] = 0
    assert [1, 1, 0] in plane
    with pytest.raises(ValueError, match="read-only"):
        plane.basis[0, 0] = 7
    with pytest.raises(AttributeError):
        plane.basis = source


# What is asked, and what is not


@pytest.mark.parametrize("number", [np.nan, np.inf, complex(0, np.nan)])
def test_subspaces_are_finite(number):
    for use in (
        lambda: join(one, [number, 0, 0, 0, 0, 0, 0, 0]),
        lambda: Subspace([[number, 1]]),
        lambda: null_space([[number, 1]]),
        lambda: join(one, i).contains(DualQuaternion([number] * 8)),
    ):
        with pytest.raises(ValueError, match="expected finite"):
            use()
    assert not same_point([number, 1], [number, 1])
    assert same_point([[number, 1], [1, 2]], [2, 4]).tolist() == [False, True]


def test_points_of_different_spaces():
    for use in (
        lambda: join(one, [1, 2, 3]),
        lambda: same_point(one, [1, 2, 3]),
        lambda: join(one, i).contains([1, 2, 3]),
        lambda: meet(join(one, i), join([1, 2, 3])),
    ):
        with pytest.raises(ValueError, match="one projective space, got 3 and 8 coordinates"):
            use()


@pytest.mark.parametrize("wrong", [None, "x", {}, Line([1, 0, 0], [0, 0, 0]), [None]])
def test_other_things_are_no_points(wrong):
    for use in (join, Subspace, lambda w: same_point(one, w), lambda w: w in join(one, i)):
        with pytest.raises(TypeError, match="expected numbers"):
            use(wrong)
    with pytest.raises(TypeError, match="expected a Subspace"):
        meet(join(one, i), wrong)


def test_shapes_are_said():
    with pytest.raises(ValueError, match="got the number 3"):
        join(3)
    with pytest.raises(ValueError, match="got nothing"):
        join()
    with pytest.raises(ValueError, match=r"a matrix of shape \(m, n\)"):
        null_space([1, 2])
    with pytest.raises(ValueError, match=r"a basis of shape"):
        Subspace([1, 2])


def test_batches_of_any_shape_are_joined():
    grid = DualQuaternion.stack([DualQuaternion.stack([one, i]), DualQuaternion.stack([j, one])])
    assert join(grid).dimension == 2


def test_copies_of_a_subspace_do_not_change():
    source = np.array([[1.0, 0, 0], [0, 1, 0]])
    for space in (Subspace(source), pickle.loads(pickle.dumps(Subspace(source))), copy.deepcopy(Subspace(source))):
        assert space.dimension == 1
        with pytest.raises(ValueError, match="read-only"):
            space.basis[0, 0] = 7
    source[:] = 0


def test_null_spaces_of_rounding():
    noise = 1e-17 * np.random.default_rng(0).normal(size=(3, 3))
    assert len(null_space(noise)) == 0
    assert len(null_space(noise, scale=1.0)) == 3


@pytest.mark.parametrize("number", [sympy.Integer, sympy.Rational, np.int64])
def test_numbers_of_every_package_span_alike(number):
    rows = [[number(n) for n in row] for row in ([1, 2, 3], [4, 5, 6], [7, 8, 9])]
    assert join(rows).dimension == 1
    assert {type(c) for c in null_space(rows).ravel().tolist()} <= {int, Fraction}
