"""The algebra of dual quaternions: its laws, exactly, for scalars of every kind."""

import copy
import pickle
from fractions import Fraction
from operator import add, mul, sub

import numpy as np
import pytest
import sympy
from hypothesis import given

from kinlib import (
    DualQuaternion,
    Line,
    MotionPolynomial,
    eps,
    i,
    j,
    k,
    linear_factor,
    null_form,
    one,
    square_root,
    study_form,
)
from kinlib.dual_quaternion import dual_size, eps_times, primal_size
from strategies import as_fractions, dual_quaternions, fractions, in_field, large, several, whole

x, y = sympy.symbols("x y")
a = square_root(2)


def generic(name: str) -> DualQuaternion:
    """A dual quaternion whose coefficients are symbols."""
    return DualQuaternion(sympy.symbols(f"{name}:8"))


def test_hamiltons_rules():
    assert i * i == j * j == k * k == i * j * k == -1
    assert (i * j, j * k, k * i) == (k, i, j)
    assert (j * i, k * j, i * k) == (-k, -i, -j)


def test_eps_squares_to_zero_and_commutes():
    assert eps * eps == 0
    assert [eps * u for u in (i, j, k)] == [u * eps for u in (i, j, k)]


def test_coefficients_belong_to_the_units_in_order():
    units = (one, i, j, k, eps, eps * i, eps * j, eps * k)
    assert [u.coeffs.tolist() for u in units] == np.eye(8).tolist()


def test_primal_and_dual_part():
    q = DualQuaternion(range(1, 9))
    assert q == q.primal + eps * q.dual
    assert q.primal == 1 + 2 * i + 3 * j + 4 * k
    assert q.dual == 5 + 6 * i + 7 * j + 8 * k
    assert q.scalar_part == 1


@given(several(3))
def test_the_product_is_associative_and_distributes(three):
    q, r, s = three
    assert (q * r) * s == q * (r * s)
    assert q * (r + s) == q * r + q * s
    assert (q + r) * s == q * s + r * s


@given(several(2))
def test_sums(two):
    q, r = two
    assert q + r == r + q
    assert q - r == -(r - q)
    assert q - q == 0
    assert q + 0 == q


@given(several(2))
def test_conjugation_reverses_products(two):
    q, r = two
    assert (q * r).conjugate() == r.conjugate() * q.conjugate()
    assert q.conjugate().conjugate() == q


@given(several(2))
def test_eps_conjugation_keeps_products(two):
    q, r = two
    assert (q * r).eps_conjugate() == q.eps_conjugate() * r.eps_conjugate()
    assert q.eps_conjugate() == q.primal - eps * q.dual


@given(several(2))
def test_the_norm_is_a_dual_number_and_multiplies(two):
    q, r = two
    assert q.norm() == q * q.conjugate() == q.conjugate() * q
    assert (q * r).norm() == q.norm() * r.norm()
    assert not np.delete(q.norm().coeffs, (0, 4)).any()


def test_the_laws_hold_for_all_scalars_at_once():
    q, r = generic("q"), generic("r")
    assert (q * r).conjugate() == r.conjugate() * q.conjugate()
    assert (q * r).norm() == q.norm() * r.norm()
    assert q.norm() == q * q.conjugate()
    assert (q * r) * (x + y * j) == q * (r * (x + y * j))


@given(several(1, kinds=(whole, fractions, in_field)))
def test_inverses(one_only):
    (q,) = one_only
    if q.primal == 0:
        with pytest.raises(ZeroDivisionError, match="divides zero"):
            q.inverse()
    else:
        assert q * q.inverse() == q.inverse() * q == 1
        assert q / q == 1
        assert 2 / q == 2 * q.inverse()


def test_an_inverse_in_symbols():
    q = generic("q")
    assert q * q.inverse() == 1


@pytest.mark.parametrize("divisor", [0 * one, eps, eps * (i + 2 * j), 1j + i, 0.0 * one])
def test_zero_divisors_have_no_inverse(divisor):
    assert (divisor * (eps * divisor.conjugate())) == 0
    with pytest.raises(ZeroDivisionError, match="divides zero"):
        divisor.inverse()


def test_one_zero_divisor_in_a_batch_is_enough():
    with pytest.raises(ZeroDivisionError):
        DualQuaternion.stack([i, eps, j]).inverse()


@given(dual_quaternions(whole), dual_quaternions(whole))
def test_quaternion_products_as_sympy_computes_them(q, r):
    p, d, s, e = (sympy.Quaternion(*half) for v in (q, r) for half in (v.coeffs[:4], v.coeffs[4:]))
    primal, dual = p * s, p * e + d * s
    assert (q * r).coeffs.tolist() == [*primal.args[:4], *dual.args[:4]]


@given(dual_quaternions(large), dual_quaternions(large), large)
def test_whole_numbers_never_overflow(q, r, n):
    for operate in (add, sub, mul):
        assert operate(q, r) == operate(as_fractions(q), as_fractions(r))
    assert (q * n).coeffs.tolist() == (n * q).coeffs.tolist() == [c * n for c in q.coeffs.tolist()]
    assert q.norm() == as_fractions(q).norm()
    assert (q + n).coeffs[0] == int(q.coeffs[0]) + n


@pytest.mark.parametrize("bits", [26, 27, 28, 29, 31, 32, 40, 62, 63, 64])
def test_whole_numbers_about_the_limits_of_int64(bits):
    for n in (2**bits - 1, 2**bits, -(2**bits)):
        q = DualQuaternion([n] * 8)
        assert q * q == as_fractions(q) * as_fractions(q)
        assert q * n == as_fractions(q) * n
        assert (q + q) * (q - n) == (as_fractions(q) * 2) * (as_fractions(q) - n)
        assert DualQuaternion([[n] * 8]) * q == as_fractions(q) * as_fractions(q)
        assert (one * n).coeffs[0] == n


def test_long_products_stay_whole():
    q, exact = DualQuaternion([3, -2, 5, 7, 1, 1, 4, -6]), one
    for _ in range(30):
        exact = exact * as_fractions(q)
    assert q**30 == exact


KINDS = {
    "whole": one + 2 * i,
    "fraction": one / 2 + i,
    "field": a * one + i,
    "symbol": x * one + i,
    "float": 0.5 * one + i,
    "complex": 1j * one + i,
}
MIXED = {
    ("whole", "whole"): "O",
    ("whole", "fraction"): "O",
    ("whole", "field"): "O",
    ("whole", "symbol"): "O",
    ("whole", "float"): "f",
    ("whole", "complex"): "c",
    ("fraction", "field"): "O",
    ("fraction", "symbol"): "O",
    ("fraction", "float"): "f",
    ("fraction", "complex"): "c",
    ("field", "symbol"): "O",
    ("field", "float"): "f",
    ("field", "complex"): "c",
    ("symbol", "float"): "O",
    ("symbol", "complex"): "O",
    ("float", "complex"): "c",
}


@pytest.mark.parametrize("operate", [add, sub, mul])
@pytest.mark.parametrize("kinds", MIXED)
def test_mixed_operands_promote(kinds, operate):
    q, r = (KINDS[kind] for kind in kinds)
    for result in (operate(q, r), operate(r, q), operate(DualQuaternion.stack([q, q]), r)):
        assert result.coeffs.dtype.kind == MIXED[kinds]
        if not {"float", "complex"} & set(kinds):
            assert not any(isinstance(c, (float, sympy.Float)) for c in result.coeffs.ravel())


@pytest.mark.parametrize("scalar", [3, Fraction(1, 3), a, x, 0.5, 2j, np.int64(3), np.float64(0.5), sympy.sqrt(3)])
def test_scalars_commute_with_everything(scalar):
    q = DualQuaternion(range(1, 9))
    assert scalar * q == q * scalar == DualQuaternion([scalar * c for c in range(1, 9)])
    assert scalar + q == q + scalar == q + scalar * one
    assert scalar - q == -(q - scalar)
    assert q * scalar / scalar == q


def test_division_of_whole_numbers_is_exact():
    third = (i + 2 * j) / 3
    assert third.coeffs.tolist()[:3] == [0, Fraction(1, 3), Fraction(2, 3)]
    assert third * 3 == i + 2 * j
    assert (1 + i).inverse() * 2 == 1 - i


def test_powers():
    q = 1 + 2 * i - eps * j
    assert q**0 == 1
    assert q**3 == q * q * q
    assert q**-2 == (q * q).inverse()


def test_a_batch_multiplies_entry_by_entry():
    rows = np.random.default_rng(1).integers(-9, 9, (2, 5000, 8))  # more than a block of rows
    q, r = map(DualQuaternion, rows)
    product = q * r
    assert product.shape == (5000,)
    assert all(product[n] == q[n] * r[n] for n in range(0, 5000, 99))
    assert (product == q * r).all()


@pytest.mark.parametrize("kind", KINDS)
def test_batches_broadcast(kind):
    q = DualQuaternion.stack([KINDS[kind], i, eps])
    grid = q[:, None] * DualQuaternion.stack([j, k])
    assert grid.shape == (3, 2)
    assert grid[1, 0] == k
    assert grid[0, 1] == KINDS[kind] * k
    assert (q * j)[2] == eps * j
    assert (j * q)[2] == eps * j
    assert (q + 1)[1] == i + 1
    assert (q * [1, 2, 3])[2] == 3 * eps
    assert ([[1], [2]] * q).shape == (2, 3)
    assert q.conjugate()[1] == -i
    assert (q.norm() == q * q.conjugate()).all()


def test_an_empty_batch():
    empty = DualQuaternion(np.zeros((0, 8)))
    assert (empty * i).shape == (empty + i).shape == (0,)
    assert list(empty) == []


def test_batches_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="broadcast"):
        DualQuaternion(np.ones((2, 8))) * DualQuaternion(np.ones((3, 8)))


def test_a_batch_is_a_sequence():
    q = DualQuaternion.stack([i, j, k])
    assert len(q) == 3
    assert list(q) == [i, j, k]
    assert q[-1] == k
    assert list(q[1:]) == [j, k]
    assert list(q[np.array([True, False, True])]) == [i, k]
    assert DualQuaternion.stack([q, q], axis=-1).shape == (3, 2)


def test_a_single_one_is_no_sequence():
    with pytest.raises(TypeError, match="no length"):
        len(i)
    with pytest.raises(IndexError):
        i[0]


def test_values_do_not_change():
    source = np.arange(8.0)
    q = DualQuaternion(source)
    source[:] = 0
    assert q == DualQuaternion(range(8))
    for array in (q.coeffs, q.components, (q * q).coeffs, (q + 1).coeffs, q.primal.coeffs, (q / 2).coeffs):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 7
    with pytest.raises(AttributeError):
        q.coeffs = source
    with pytest.raises(AttributeError):
        q.name = "q"


def test_entries_do_not_share_memory_that_can_change():
    q = DualQuaternion.stack([i, j])
    with pytest.raises(ValueError, match="read-only"):
        q[0].coeffs[1] = 7


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda q: pickle.loads(pickle.dumps(q))])
@pytest.mark.parametrize("kind", KINDS)
def test_copies_are_equal_and_do_not_change(kind, duplicate):
    assert duplicate(KINDS[kind]) == KINDS[kind]
    with pytest.raises(ValueError, match="read-only"):
        duplicate(KINDS[kind]).components[0] = 7


def test_the_matrix_view_of_numpy_agrees():
    q = DualQuaternion(np.arange(16).reshape(2, 8))
    assert q.coeffs.tolist() == np.arange(16).reshape(2, 8).tolist()
    assert q.components.tolist() == q.coeffs.T.tolist()
    assert DualQuaternion(q.coeffs)[1] == q[1]


def test_change_of_scalars():
    assert (i / 2).astype(float).coeffs.dtype == float
    assert DualQuaternion([a] * 8).astype(float).coeffs == pytest.approx([2**0.5] * 8)
    assert i.astype(complex) * 1j == 1j * i


@pytest.mark.parametrize("shape", [(), (7,), (9,), (8, 4), (8, 0), (0,)])
def test_eight_coefficients_are_expected(shape):
    with pytest.raises(ValueError, match=r"expected coefficients of shape \(\.\.\., 8\), got"):
        DualQuaternion(np.zeros(shape))


@pytest.mark.parametrize("wrong", ["12345678", ["1"] * 8, [None] * 8, [object()] * 8, [linear_factor(i)] * 8])
def test_coefficients_are_numbers(wrong):
    with pytest.raises(TypeError, match="expected numbers, got"):
        DualQuaternion(wrong)


@pytest.mark.parametrize("operate", [add, sub, mul, lambda q, x: x * q, lambda q, x: x - q])
@pytest.mark.parametrize("wrong", [None, "i", {}])
def test_other_things_do_not_mix(operate, wrong):
    with pytest.raises(TypeError):
        operate(i, wrong)


def test_polynomials_on_the_right_are_multiplied_as_polynomials():
    C = linear_factor(j)
    constant = MotionPolynomial([i.coeffs])
    assert i * C == constant * C
    assert i + C == constant + C
    assert i - C == constant - C
    assert i == constant
    assert (i * C)(3) == i * C(3)
    batch = DualQuaternion.stack([i, k]) * C
    assert [batch[n] for n in (0, 1)] == [i * C, k * C]


def test_equality_compares_coefficients():
    assert one == 1
    assert i != 2 * i
    assert 2 * i == 2.0 * i
    assert i / 2 == 0.5 * i
    assert a * i != 1.4142 * i
    assert (DualQuaternion.stack([i, j]) == i).tolist() == [True, False]
    assert (DualQuaternion.stack([i, j]) != i).tolist() == [False, True]
    assert one * float("nan") != one * float("nan")


@pytest.mark.parametrize("other", [None, "i", object(), [], {}])
def test_other_things_are_not_equal(other):
    if not isinstance(other, list):
        assert i != other
        assert (i == other) is False


def test_values_that_compare_by_coefficients_are_not_hashed():
    with pytest.raises(TypeError, match="unhashable"):
        hash(i)


@pytest.mark.parametrize(
    ("q", "text"),
    [
        (0 * one, "0"),
        (one, "1"),
        (-i, "-i"),
        (1 - 2 * i + 3 * eps * j, "1 - 2 i + 3 εj"),
        (i / 2 - eps / 3, "1/2 i - 1/3 ε"),
        (0.5 * i - k, "0.5 i - k"),
        (1j * i, "√−1 i"),
        ((1 + 2j) * i, "(1 + 2 √−1) i"),
        ((1 / 3 + 2j / 3) * i, "(0.333333 + 0.666667 √−1) i"),
        (2j / 3 * i, "0.666667 √−1 i"),
        (DualQuaternion([np.float64(0.5), Fraction(1, 3), 0, 0, 0, 0, 0, 0]), "0.5 + 0.333333 i"),
        (DualQuaternion(np.float32([0.1, 0, 0, 0, 0, 0, 0, 0])), "0.1"),
        (x * i + (x + 1) * k, "x i + (x + 1) k"),
        ((1 - a) * j, "(1 - a) j"),
        ((x * (x + 1) + 2) * j, "(x*(x + 1) + 2) j"),
        (((x + 1) * y + 2) * j, "(y*(x + 1) + 2) j"),
        (((x + 1) * (y + 2) + 3) * j, "((x + 1)*(y + 2) + 3) j"),
        (DualQuaternion.stack([i, j]), "DualQuaternion of shape (2,), object"),
    ],
)
def test_reading(q, text):
    assert repr(q) == text


# As a user of NumPy expects


def test_numpy_sees_the_coefficients():
    q = DualQuaternion(np.arange(16.0).reshape(2, 8))
    assert np.asarray(q).tolist() == np.array(q).tolist() == q.coeffs.tolist()
    assert np.asarray(i).dtype == object
    assert np.asarray(i, dtype=float).tolist() == [0, 1, 0, 0, 0, 0, 0, 0]
    copied = np.array(q)
    copied[0, 0] = 7
    assert q.coeffs[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        np.asarray(q)[0, 0] = 7


def test_a_dual_quaternion_of_dual_quaternions():
    assert DualQuaternion(1 + i) == 1 + i
    assert list(DualQuaternion([i, j / 2, eps])) == [i, j / 2, eps]
    q = DualQuaternion.stack([i, j])
    assert (DualQuaternion(q) == q).all()


def test_arrays_are_compared_as_coefficients():
    q = 1 + 2 * i
    batch = DualQuaternion.stack([q, i])
    assert q == q.coeffs
    assert q.coeffs == q
    assert q == q.coeffs.tolist()
    assert (batch == batch.coeffs).all()
    assert (batch.coeffs == batch).all()
    assert (batch == q.coeffs).tolist() == [True, False]
    assert (q == np.ones(3)) is False
    assert q != np.ones(8)


@pytest.mark.parametrize("dtype", [np.float32, np.complex64])
def test_single_precision_is_kept(dtype):
    q = DualQuaternion(np.arange(8, dtype=dtype))
    batch = DualQuaternion(np.ones((3, 8), dtype=dtype))
    for r in (q, batch):
        for result in (r * r, r + r, -r, r * 2, 0.5 * r, r / 3, r + 1, 1.5 - r, r.conjugate(), r.norm(), r[..., None]):
            assert result.coeffs.dtype == dtype
    assert (q * np.ones(3)).coeffs.dtype == np.result_type(dtype, float)


def test_only_zero_is_false():
    assert i
    assert eps
    assert 1e-300 * i
    assert x * i - x * j
    assert not 0 * i
    assert not 0.0 * i
    assert not (x + 1) ** 2 * i - (x**2 + 2 * x + 1) * i
    assert DualQuaternion([float("nan")] * 8)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_batch_has_no_truth_value(count):
    with pytest.raises(ValueError, match="no truth value"):
        bool(DualQuaternion(np.ones((count, 8))))


@pytest.mark.parametrize("source", [np.arange(8.0), np.arange(8), np.array([Fraction(1, 2)] * 8)])
def test_arrays_of_the_caller_stay_theirs(source):
    before = source.tolist()
    made = DualQuaternion.from_components(source), DualQuaternion(source)
    source[0] = 7
    assert [q.coeffs.tolist() for q in made] == [before, before]


@pytest.mark.parametrize("shape", [(), (7,), (0,), (7, 8)])
def test_components_come_first(shape):
    with pytest.raises(ValueError, match=r"expected components of shape \(8, \.\.\.\)"):
        DualQuaternion.from_components(np.ones(shape))


def test_elements_of_rings_and_fields_of_polynomials_on_either_side():
    for number in (sympy.ring("u", sympy.QQ)[1], sympy.field("u", sympy.QQ)[1]):
        q = 1 + i - 2 * eps * k
        assert number * q == q * number
        assert number + q == q + number
        assert number - q == -(q - number)
        assert (number * q) * (number * q) == number * number * (q * q)


# Sizes, forms, wrong types


@given(dual_quaternions(fractions))
def test_sizes_are_those_of_the_largest_coefficients(q):
    assert primal_size(q) == max(abs(float(c)) for c in q.coeffs[:4])
    assert dual_size(q) == max(abs(float(c)) for c in q.coeffs[4:])
    assert primal_size(DualQuaternion.stack([q, 2 * q])).tolist() == [primal_size(q), 2 * primal_size(q)]
    assert dual_size(eps_times(q)) == primal_size(q)
    assert eps_times(q) == eps * q


@pytest.mark.parametrize("wrong", [None, "i", [1] * 8, np.ones(8), np.eye(4), Line([1, 0, 0], [0, 0, 0]), 3])
def test_what_is_expected_is_said(wrong):
    for use in (
        lambda w: study_form(i, w),
        lambda w: null_form(w, i),
        eps_times,
        primal_size,
        dual_size,
        lambda w: DualQuaternion.stack([i, w]),
    ):
        with pytest.raises(TypeError, match=r"expected a dual quaternion, got \w+: "):
            use(wrong)


@pytest.mark.parametrize("operate", [add, sub, mul])
@pytest.mark.parametrize("wrong", [Line([1, 0, 0], [0, 0, 0]), object(), [None] * 3, [i, j]])
def test_operands_are_numbers_or_dual_quaternions(operate, wrong):
    for pair in ((i, wrong), (wrong, i)):
        with pytest.raises(TypeError):
            operate(*pair)


@pytest.mark.parametrize("exponent", [0.5, None, Fraction(1, 2), i])
def test_exponents_are_whole(exponent):
    with pytest.raises(TypeError, match="expected a whole number as exponent"):
        i**exponent


def test_nothing_to_stack():
    with pytest.raises(ValueError, match="at least one"):
        DualQuaternion.stack([])
