"""ℚ(a) is an ordered field, and SymPy agrees about its numbers."""

import math
import pickle
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from kinlib import NumberField, NumberFieldElement, i, quadratic_factors, square_root
from strategies import fractions, whole

x = sympy.Symbol("x")
SEXTIC = NumberField(sympy.CRootOf(x**6 + 8 * x**4 + 8 * x**2 - 16, 1))
FIELDS = [NumberField(sympy.sqrt(2)), NumberField(sympy.cbrt(2)), SEXTIC]
a = FIELDS[0].generator
b = square_root(3)


@st.composite
def elements(draw, count):
    """Numbers of one field."""
    field = draw(st.sampled_from(FIELDS))
    return [field.element(draw(st.lists(fractions, min_size=1, max_size=field.degree))) for _ in range(count)]


@pytest.mark.parametrize("field", FIELDS)
def test_the_generator_is_a_root_of_its_minimal_polynomial(field):
    minimal = [Fraction(int(c.numerator), int(c.denominator)) for c in field.domain.mod.to_list()]
    assert len(minimal) == field.degree + 1
    assert np.polyval(minimal, field.generator) == 0


@given(elements(3))
def test_the_axioms_of_a_field(numbers):
    u, v, w = numbers
    assert u + v == v + u
    assert u * v == v * u
    assert (u + v) + w == u + (v + w)
    assert (u * v) * w == u * (v * w)
    assert u * (v + w) == u * v + u * w
    assert u - u == 0
    assert u + -u == 0
    assert u - v == -(v - u)


@given(elements(2))
def test_division_undoes_multiplication(numbers):
    u, v = numbers
    assume(v != 0)
    assert u * v / v == u
    assert u / v * v == u
    assert 1 / v * v == 1


@given(elements(1), st.integers(0, 4))
def test_powers_are_products(numbers, n):
    (u,) = numbers
    assert u**n == math.prod([u] * n)


@given(elements(2))
def test_sympy_computes_the_same_numbers(numbers):
    u, v = (number.as_sympy() for number in numbers)
    product = numbers[0] * numbers[1] - numbers[0]
    assert float(product) == pytest.approx(float((u * v - u).evalf(30)), rel=1e-15)


@given(elements(2))
def test_the_order_is_that_of_the_real_numbers(numbers):
    u, v = numbers
    assert (u < v) == (u.as_sympy().evalf(40) < v.as_sympy().evalf(40))
    assert [u < v, u == v, u > v].count(True) == 1
    assert abs(u) >= 0
    assert abs(u) in (u, -u)


@given(elements(1), fractions)
def test_fractions_mix_exactly(numbers, r):
    (u,) = numbers
    lifted = u.field.element([r])
    assert u + r == r + u == u + lifted
    assert u * r == r * u == u * lifted
    assert u - r == u - lifted == -(r - u)
    assert lifted == r
    assert hash(lifted) == hash(r)


@pytest.mark.parametrize("n", [3, Fraction(1, 3), np.int64(3), True])
def test_rational_numbers_of_every_type_mix(n):
    exact = int(n) if isinstance(n, (np.int64, bool)) else n
    for mixed in (n * a, a * n):
        assert isinstance(mixed, NumberFieldElement)
        assert mixed * mixed == 2 * exact**2
    assert (a + n) - a == (n + a) - a == exact
    assert (a / n) * (n / a) == 1


@pytest.mark.parametrize("number", [0.5, np.float64(0.5), 0.5j])
def test_floats_make_floats(number):
    assert a * number == number * a == pytest.approx(math.sqrt(2) * number)
    assert a + number == number + a == pytest.approx(math.sqrt(2) + number)
    assert number - a == pytest.approx(number - math.sqrt(2))


def test_symbols_mix_exactly_on_either_side():
    root = sympy.sqrt(2)
    assert a * x == root * x
    assert x * a == root * x
    assert x + a == a + x == x + root
    assert x - a == x - root
    assert sympy.Integer(3) * a == 3 * root
    assert sympy.sympify(a) == root


def test_floats_survive_cancellation():
    convergent = Fraction(665857, 470832)  # of √2, off by 1.6e-12
    for power in (1, 2, 5):
        exact = (sympy.sqrt(2) - sympy.Rational(665857, 470832)) ** power
        assert float((a - convergent) ** power) == pytest.approx(float(exact.evalf(30)), rel=1e-14)


def test_a_number_far_below_one_keeps_its_sign():
    small = (a - Fraction(665857, 470832)) ** 9
    assert small < 0 < -small
    assert abs(small) > 0


@pytest.mark.parametrize("operate", [lambda: a + b, lambda: a * b, lambda: a - b, lambda: b / a])
def test_two_fields_do_not_mix(operate):
    with pytest.raises(ValueError, match="numbers of two fields do not mix"):
        operate()


def test_equality_reaches_across_fields():
    twice = NumberField(2 * sympy.sqrt(2)).generator
    assert square_root(8) == 2 * square_root(2) == twice
    assert hash(twice) == hash(2 * a)
    assert {twice} == {2 * a}
    assert not twice < 2 * a
    assert not twice > 2 * a
    assert square_root(2) != square_root(3)
    assert square_root(2) - square_root(2) == square_root(3) - square_root(3)


@pytest.mark.parametrize("other", [None, "a", object()])
def test_other_things_are_not_equal(other):
    assert a != other
    assert a not in [other]


def test_other_things_do_not_add():
    with pytest.raises(TypeError):
        a + "1"


def test_zero_has_no_inverse():
    for divide in (lambda: 1 / (a - a), lambda: a / 0, lambda: (a - a) ** -1):
        with pytest.raises(ZeroDivisionError):
            divide()


def test_numbers_read_well():
    assert [repr(n) for n in (a, -a, 1 - a, a / 2 + 1, 3 * a * a, a - a)] == ["a", "-a", "1 - a", "1 + 1/2*a", "6", "0"]
    assert repr(FIELDS[1]) == "ℚ(a), a = 1.25992 a root of a**3 - 2"
    assert repr(FIELDS[1].generator ** 2) == "a**2"


def test_numbers_can_be_copied_by_pickle():
    assert pickle.loads(pickle.dumps(1 + a)) == 1 + a


@given(st.fractions(0, 50, max_denominator=30))
def test_a_square_root_of_a_fraction(r):
    root = square_root(r)
    assert root * root == r
    assert root >= 0
    assert float(root) == pytest.approx(math.sqrt(r))


@given(whole.filter(bool))
def test_roots_of_squares_are_fractions(n):
    assert square_root(n * n) == abs(n)
    assert isinstance(square_root(n * n), Fraction)


@given(elements(1))
def test_a_square_root_in_the_field(numbers):
    (u,) = numbers
    assert square_root(u * u) == abs(u)


def test_square_root_of_other_scalars():
    assert square_root(2.25) == 1.5
    assert square_root(np.array([4.0, 9.0])).tolist() == [2, 3]
    assert square_root(4 * x**2).subs(x, 3) == 6
    assert square_root(np.array([4, Fraction(1, 4)])).tolist() == [2, Fraction(1, 2)]


def test_square_roots_of_whole_arrays_stay_exact():
    assert [r * r for r in square_root(np.array([4, 2, 0]))] == [4, 2, 0]
    assert not any(isinstance(r, float) for r in square_root(np.array([4, 2, 0])).tolist())


@pytest.mark.parametrize("number", [-1, Fraction(-1, 4), -a, -1.0])
def test_negative_numbers_have_no_root(number):
    with pytest.raises(ValueError, match="no"):
        square_root(number)


def test_a_root_outside_the_field_is_refused():
    with pytest.raises(ValueError, match="has no square root in ℚ"):
        square_root(1 + a)


def test_the_field_of_a_sextic_has_its_degree():
    factor = quadratic_factors([1, 1, 5, 2, 3])[0]
    assert factor[1].field.degree == 6


def test_equal_numbers_of_different_fields_have_equal_hashes():
    both = NumberField(sympy.sqrt(2) + sympy.sqrt(3)).generator
    assert both**2 == 5 + 2 * square_root(6)
    assert hash(both**2) == hash(5 + 2 * square_root(6))
    assert (both**2 - 5) ** 2 == 24
    assert hash((both**2 - 5) ** 2) == hash(24)


def test_elements_are_reduced():
    assert a.field.element([1, 0, 0]) == 2
    assert hash(a.field.element([1, 0, 0])) == hash(2)
    assert FIELDS[1].element([1, 0, 0, 0, 0]) == 2 * FIELDS[1].generator


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("power", [-290, -30, 0, 30, 300])
def test_the_nearest_float_at_every_size(field, power):
    number = (field.generator - 2) * Fraction(10) ** power
    exact = sympy.Rational(float(number)) - number.as_sympy()
    assert abs(exact.evalf(60)) <= abs(float(number)) * 2**-53


def test_numbers_beyond_all_floats():
    large = a * 10**400
    with pytest.raises(OverflowError, match="too large for a float"):
        float(large)
    assert 10**400 < large < 2 * 10**400
    assert hash(large) == hash(large + 0)
    assert float(a / 10**400) == 0
    assert 0 < a / 10**400 < Fraction(1, 10**300)


def test_comparisons_are_exact():
    convergent = Fraction(665857, 470832)
    close = convergent
    for _ in range(6):  # Newton's steps from above: hundreds of digits of √2
        close = (close + 2 / close) / 2
    assert a < close
    assert a != close
    assert float(close) == float(a)
    assert square_root(8) / 2 < close


def test_floats_are_compared_at_their_exact_value():
    assert a != math.sqrt(2)
    assert a < math.sqrt(2)
    assert a / a == 1.0
    assert a < math.inf
    assert a > -math.inf
    assert not a < math.nan
    assert not a > math.nan


def test_a_number_of_sympy_is_compared_as_such():
    assert a < sympy.sqrt(3)
    assert a == sympy.sqrt(2)


@pytest.mark.parametrize("wrong", ["a", None, [1, 2]])
def test_a_field_needs_a_number(wrong):
    with pytest.raises(TypeError, match="expected a real algebraic number"):
        NumberField(wrong)


@pytest.mark.parametrize("wrong", [sympy.I, sympy.pi, x, sympy.oo])
def test_a_field_needs_a_real_algebraic_number(wrong):
    with pytest.raises(ValueError, match="expected a real algebraic number"):
        NumberField(wrong)


@pytest.mark.parametrize("wrong", [0.5, "1", None, x])
def test_coefficients_of_an_element_are_rational(wrong):
    with pytest.raises(TypeError, match="expected"):
        a.field.element([wrong])


@pytest.mark.parametrize("wrong", [None, "2", {}, i])
def test_square_roots_are_of_numbers(wrong):
    with pytest.raises(TypeError, match="expected numbers"):
        square_root(wrong)


def test_square_roots_of_the_numbers_of_other_packages():
    assert square_root(sympy.Rational(1, 4)) == Fraction(1, 2)
    assert square_root(sympy.Integer(2)) == a
    assert square_root([4, Fraction(1, 9)]).tolist() == [2, Fraction(1, 3)]
    assert square_root(mpmath.mpf(4)) == 2
    with pytest.raises(ValueError, match="negative"):
        square_root(np.array([1.0, -1.0]))
