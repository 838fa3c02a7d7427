"""Scalars of every kind: nothing is rounded that need not be."""

import math
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from kinlib import (
    DualQuaternion,
    as_float,
    as_scalars,
    bennett_linkage,
    divide,
    i,
    is_exact,
    is_zero,
    j,
    one,
    same_point,
    size,
    square_root,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX
from kinlib.scalar import (
    as_vectors,
    imaginary_unit,
    is_infinite,
)
from strategies import fractions, large, whole

x = sympy.Symbol("x")
a = square_root(2)
half = Fraction(1, 2)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([1, 2], "O"),
        ([True, False], "O"),
        (np.array([1, 2], dtype=np.uint8), "O"),
        ([2**80, 1], "O"),
        ([2**63, -1], "O"),  # NumPy alone makes floats of these
        ([half, 2], "O"),
        ([x, 2], "O"),
        ([a, 2], "O"),
        ([0.5, 1], "f"),
        ([half, 0.5], "f"),
        ([a, 0.5], "f"),
        ([1j, 1], "c"),
        ([half, 1j], "c"),
        ([x, 0.5], "O"),
    ],
)
def test_numbers_keep_their_kind(values, kind):
    assert as_scalars(values).dtype.kind == kind


@given(st.lists(large, min_size=1))
def test_whole_numbers_of_any_size_are_kept(values):
    assert as_scalars(values).tolist() == values


def test_whole_numbers_are_pythons_own():
    assert all(type(n) is int for n in as_scalars(np.arange(3)).tolist())
    assert all(type(n) is int for n in as_scalars([np.int64(1), half]).tolist() if n == 1)


@given(st.lists(st.one_of(whole, fractions), min_size=1))
def test_fractions_are_kept(values):
    assert as_scalars(values).tolist() == values


@pytest.mark.parametrize(
    "values", ["one", ["1", "2"], None, [1, None], [half, "2"], {1: 2}, {1, 2}, [b"1"], np.array(["2026"], "M8[Y]")]
)
def test_only_numbers_are_numbers(values):
    with pytest.raises(TypeError, match="expected numbers, got"):
        as_scalars(values)


def test_ragged_rows_are_refused():
    with pytest.raises(ValueError, match="inhomogeneous"):
        as_scalars([[1, 2], [3]])


def test_the_source_can_change_without_changing_the_scalars():
    source = np.array([1.0, 2.0])
    scalars = as_scalars(source)
    source[0] = 7
    assert scalars.tolist() == [1, 2]


@given(whole, whole.filter(bool))
def test_whole_numbers_divide_exactly(n, m):
    quotient = divide(n, m)
    assert isinstance(quotient, Fraction)
    assert quotient * m == n


@given(st.lists(large, min_size=1), large.filter(bool))
def test_division_undoes_multiplication(values, m):
    assert divide(as_scalars([v * m for v in values]), m).tolist() == values


@pytest.mark.parametrize("number", [1, half, x, a, np.int64(3)])
def test_a_quotient_is_exact_for_exact_numbers(number):
    assert divide(number, 3) * 3 == number
    assert is_exact(np.array(divide(number, 3)))


@pytest.mark.parametrize("number", [1, half, a])
def test_exact_numbers_beside_floats_become_floats(number):
    quotient = divide(np.array([number, number]), np.array([2.0, 4.0]))
    assert quotient.dtype == float
    assert quotient == pytest.approx([float(number) / 2, float(number) / 4])


@pytest.mark.parametrize("number", [1, half, a])
def test_exact_division_by_zero_is_an_error(number):
    with pytest.raises(ZeroDivisionError):
        divide(number, 0)


@pytest.mark.parametrize(
    "zero", [0, Fraction(0), a * a - 2, (x + 1) ** 2 - x**2 - 2 * x - 1, sympy.sqrt(6) - sympy.sqrt(2) * sympy.sqrt(3)]
)
def test_exact_zeros_are_recognised(zero):
    assert is_zero(zero) is True


@pytest.mark.parametrize("number", [Fraction(1, 10**30), a - Fraction(141421356237, 10**11), x / 10**30])
def test_exact_numbers_however_small_are_not_zero(number):
    assert is_zero(number) is False


def test_floats_are_compared_with_the_size_of_the_problem():
    assert is_zero(1e-10)
    assert not is_zero(1e-8)
    assert is_zero(1e-4, scale=1e6)
    assert not is_zero(1e-10, scale=1e-6)
    assert is_zero([1e-4, 1e-4], scale=[1e6, 1]).tolist() == [True, False]


@pytest.mark.parametrize("number", [math.nan, math.inf, complex(0, math.nan)])
def test_what_is_not_finite_is_not_zero(number):
    assert not is_zero(number)


def test_sympy_floats_are_no_exact_numbers():
    assert not is_exact(np.array([sympy.Float(0.5), 1], dtype=object))
    assert is_zero(sympy.Float(1e-12))


@given(st.lists(fractions, min_size=1), whole)
def test_size_is_homogeneous(values, factor):
    assert size([factor * v for v in values]) == pytest.approx(abs(factor) * size(values))


def test_size_is_the_largest_absolute_value():
    values = np.array([[3, -4], [0, half]], dtype=object)
    assert size(values) == 4
    assert size(values, axis=-1).tolist() == [4, 0.5]
    assert size(values, axis=(-1, -2)) == 4
    assert size([3 + 4j]) == 5
    assert size([a]) == pytest.approx(math.sqrt(2))


def test_a_symbol_counts_as_one():
    assert size([x, 0]) == size([x**2 + 1, half]) == 1
    assert size(np.array([[x, 100], [0, 0]]), axis=-1).tolist() == [100, 0]


def test_the_nearest_floats():
    assert as_float([Fraction(1, 3), 2, a]).tolist() == [1 / 3, 2, math.sqrt(2)]
    assert as_float([sympy.I, half]).tolist() == [1j, 0.5]
    with pytest.raises(TypeError):
        as_float([x])


@pytest.mark.parametrize("values", [[1.0], [1j], [1], [half], [x], [a]])
def test_the_imaginary_unit_is_a_root_of_minus_one(values):
    unit = imaginary_unit(as_scalars(values))
    assert unit * unit == -1
    assert is_exact(np.array(unit)) == is_exact(as_scalars(values))


@pytest.mark.parametrize("t", [math.inf, -math.inf, np.float64("inf"), sympy.oo])
def test_infinity_is_known(t):
    assert is_infinite(t)


@pytest.mark.parametrize("t", [0, 1e300, math.nan, half, a, x, sympy.pi])
def test_other_numbers_are_not_infinite(t):
    assert not is_infinite(t)


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        (sympy.Integer(3), 3),
        (sympy.Rational(1, 3), Fraction(1, 3)),
        (np.int64(3), 3),
        (Decimal("0.1"), Fraction(1, 10)),
        (sympy.Float(0.5), 0.5),
        (0.5 * sympy.sqrt(4), 1.0),
        (sympy.Float(2) * sympy.sqrt(2), 2 * math.sqrt(2)),
        (mpmath.mpf("0.5"), 0.5),
        (mpmath.mpc(0.5, 1), 0.5 + 1j),
        (sympy.oo, math.inf),
    ],
)
def test_numbers_of_every_package_enter_by_one_door(number, expected):
    for stored in (as_scalars([number]).tolist()[0], as_scalars([[number, number]]).tolist()[0][1]):
        assert type(stored) is type(expected)
        assert stored == pytest.approx(expected, rel=1e-15)
    assert type(DualQuaternion([number] * 8).coeffs.tolist()[0]) is type(expected)


@pytest.mark.parametrize("number", [sympy.sqrt(2), sympy.pi, sympy.I, x, x / 2])
def test_irrational_numbers_and_symbols_of_sympy_stay(number):
    assert as_scalars([number]).tolist() == [number]


def test_sympys_whole_numbers_cost_what_pythons_cost():
    """The arithmetic behind a product is the same, since the numbers are."""
    q = DualQuaternion([sympy.Integer(n) for n in range(1, 9)])
    assert {type(c) for c in (q * q.inverse()).coeffs.tolist()} <= {int, Fraction}


@pytest.mark.parametrize("number", [sympy.Integer, sympy.Rational, lambda n: np.int64(int(n))])
def test_a_problem_in_the_numbers_of_another_package_is_the_same_problem(number):
    poses = [pose.map(number) for pose in FIELD_OF_DEGREE_SIX]
    assert [type(c) for pose in poses for c in pose.coeffs.tolist()] == [int] * 24
    assert (bennett_linkage(*poses).axes == bennett_linkage(*FIELD_OF_DEGREE_SIX).axes).all()


@pytest.mark.parametrize("wrong", [sympy.true, sympy.FiniteSet(1), i, [i, j], [[i]]])
def test_other_algebras_are_no_numbers(wrong):
    with pytest.raises(TypeError, match="expected numbers, got"):
        as_scalars(wrong)


def test_whole_numbers_beyond_all_floats():
    q = 10**400 * one + i
    assert q * q.inverse() == 1
    assert same_point(q, 10**400 * q)
    assert size([10**400]) == math.inf
    for use in (lambda: q.astype(float), lambda: q * 0.5, lambda: as_scalars([10**400, 0.5])):
        with pytest.raises(OverflowError, match="too large for a float"):
            use()


@pytest.mark.parametrize("dtype", [np.float32, np.complex64])
def test_single_precision_is_judged_by_its_own(dtype):
    noise = np.array([3e-7], dtype=dtype)
    assert is_zero(noise).all()
    assert not is_zero(noise, rtol=0).any()
    assert not is_zero(1e3 * noise).any()
    assert not is_zero(noise.astype(np.complex128)).any()


def test_vectors_are_real_and_finite_but_for_rows_of_a_batch():
    for wrong in ([math.nan, 0, 0], [0, math.inf, 0]):
        with pytest.raises(ValueError, match="expected finite"):
            as_vectors(wrong)
        rows = as_vectors([wrong, [1, 2, 3]])
        assert np.isnan(rows[0]).all()
        assert rows[1].tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="expected real"):
        as_vectors([1j, 0, 0])
