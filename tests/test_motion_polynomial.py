"""Motion polynomials: SymPy's polynomials and the values at all t as second sources."""

import math
import pickle
from fractions import Fraction
from operator import add, mul, sub

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinlib import (
    DualQuaternion,
    MotionPolynomial,
    RationalCurve,
    act,
    as_matrix,
    eps,
    i,
    j,
    k,
    linear_factor,
    one,
    same_point,
    square_root,
    translation,
)
from strategies import dual_quaternions, fractions, in_field, lines, motion_polynomials, poses, vectors, whole

t = sympy.Symbol("t")
a = square_root(2)
C = linear_factor(i) * linear_factor(j - eps * i)
polynomials = st.integers(0, 3).flatmap(motion_polynomials)
exact_pairs = st.sampled_from([whole, fractions, in_field]).flatmap(
    lambda scalars: st.tuples(motion_polynomials(1, scalars), motion_polynomials(1, scalars))
)


def expanded(q: DualQuaternion) -> list:
    return [sympy.expand(c) for c in q.coeffs]


def by_sympy(C: MotionPolynomial) -> list[sympy.Poly]:
    """The eight components as SymPy's polynomials in t."""
    return [sympy.Poly(list(column), t) for column in C.coeffs.T]


@st.composite
def motions(draw, degree=2):
    """Products of turns about lines anywhere."""
    factors = [draw(fractions) + draw(lines()).as_dual_quaternion() for _ in range(degree)]
    return math.prod([linear_factor(h) for h in factors], start=MotionPolynomial([one.coeffs]))


# The ring


@pytest.mark.parametrize("operate", [add, sub, mul])
@given(polynomials, polynomials)
def test_values_at_all_t_add_and_multiply(operate, C, D):
    assert expanded(operate(C, D)(t)) == expanded(operate(C(t), D(t)))


@settings(max_examples=12)
@given(exact_pairs, whole)
def test_values_at_numbers_add_and_multiply(pair, s):
    C, D = pair
    assert (C * D)(s) == C(s) * D(s)
    assert (D * C)(s) == D(s) * C(s)
    assert (C + D)(s) == (D + C)(s) == C(s) + D(s)
    assert (D - C)(s) == D(s) - C(s)


@given(polynomials, polynomials)
def test_products_as_sympy_multiplies_polynomials(C, D):
    c, d = by_sympy(C), by_sympy(D)
    first = c[0] * d[0] - c[1] * d[1] - c[2] * d[2] - c[3] * d[3]
    fifth = (
        c[0] * d[5] + c[1] * d[4] + c[2] * d[7] - c[3] * d[6] + c[4] * d[1] + c[5] * d[0] + c[6] * d[3] - c[7] * d[2]
    )
    product = by_sympy(C * D)
    assert product[0] == first
    assert product[5] == fifth


@given(polynomials, polynomials, polynomials)
def test_the_laws_of_a_ring(C, D, E):
    assert (C * D) * E == C * (D * E)
    assert C * (D + E) == C * D + C * E
    assert (C + D) * E == C * E + D * E
    assert C + D == D + C
    assert C - C == 0


@given(polynomials, polynomials)
def test_conjugation_reverses_products(C, D):
    assert (C * D).conjugate() == D.conjugate() * C.conjugate()


@given(polynomials)
def test_the_norm_polynomial(C):
    product = C * C.conjugate()
    assert C.norm_polynomial().tolist() == product.coeffs[:, 0].tolist()
    assert C.study_polynomial().tolist() == product.coeffs[:, 4].tolist()
    assert not np.delete(product.coeffs, (0, 4), axis=1).any()


@given(polynomials, dual_quaternions())
def test_constants_multiply_on_either_side(C, q):
    constant = MotionPolynomial([q.coeffs])
    assert q * C == constant * C
    assert C * q == C * constant
    assert q + C == C + q == C + constant
    assert q - C == constant - C
    assert q == constant
    assert constant == q


@pytest.mark.parametrize("scalar", [3, Fraction(1, 3), a, t, 0.5, 2j, np.float64(2), sympy.sqrt(3)])
def test_scalars_multiply_on_either_side(scalar):
    assert scalar * C == C * scalar == MotionPolynomial.from_coefficients([c * scalar for c in C.coefficients])
    assert (scalar + C)(0) == C(0) + scalar
    assert (scalar - C)(0) == scalar - C(0)


@given(polynomials, polynomials.filter(lambda D: D.leading.primal != 0))
def test_division_from_the_right(C, D):
    quotient, remainder = divmod(C, D)
    assert quotient * D + remainder == C
    assert remainder.degree < D.degree or (remainder == 0)


@given(polynomials, polynomials.filter(lambda D: D.leading.primal != 0))
def test_division_undoes_multiplication_from_the_right(C, D):
    quotient, remainder = divmod(C * D, D)
    assert quotient == C
    assert remainder == 0


@given(polynomials, dual_quaternions())
def test_the_remainder_by_a_linear_factor_is_the_value(C, h):
    """C(h), with the powers of h on the right."""
    _, remainder = divmod(C, linear_factor(h))
    powers = [h**n for n in range(C.degree, -1, -1)]
    assert remainder == sum((c * p for c, p in zip(C.coefficients, powers, strict=True)), start=0 * one)


def test_division_by_a_constant():
    assert divmod(C, 2 * i)[0] * (2 * i) == C
    with pytest.raises(ZeroDivisionError):
        divmod(C, linear_factor(i) * eps)


# Values


@given(motions(), fractions)
def test_horner_agrees_with_powers(C, s):
    powers = [s**n for n in range(C.degree, -1, -1)]
    assert C(s) == sum((c * p for c, p in zip(C.coefficients, powers, strict=True)), start=0 * one)


@pytest.mark.parametrize("infinity", [math.inf, -math.inf, sympy.oo, np.inf])
def test_at_infinity_the_leading_coefficient(infinity):
    assert (3 * C)(infinity) == 3
    assert C(infinity).coeffs.dtype == object


@pytest.mark.parametrize("s", [2, Fraction(1, 3), a, 0.5, 1j, t])
def test_every_scalar_may_be_a_parameter(s):
    assert C(s) == (s - i) * (s - (j - eps * i))


def test_many_parameters():
    s = np.array([[0.0, 1.0, math.inf], [2.0, -math.inf, 0.5]])
    values = C(s)
    assert values.shape == (2, 3)
    assert values[0, 2] == values[1, 1] == 1
    assert values[1, 0] == C(2.0)
    exact = C([0, Fraction(1, 2), 3])
    assert exact[1] == C(Fraction(1, 2))
    assert not any(isinstance(c, float) for c in exact.coeffs.ravel())


@pytest.mark.parametrize("s", [10**5, 10**10, 10**30])
def test_large_whole_parameters_do_not_overflow(s):
    C4 = C * C
    exact = C4(Fraction(s))
    assert C4(s) == exact
    assert C4([s, -s])[0] == exact
    curve = C4.trajectory([1, 0, 0])
    assert (curve(s) == act(exact, [1, 0, 0])).all()
    assert (curve([s, 1])[0] == curve(s)).all()


@pytest.mark.parametrize("s", [1e150, -1e200, 1e308])
def test_parameters_whose_powers_are_too_large(s):
    """The pose is that of C(s)/sⁿ."""
    D = 1.0 * C
    assert same_point(D(s), one + (-i - j + eps * i) / s)
    assert same_point(D(np.array([s, 2.0]))[0], one)
    assert D(np.array([s, 2.0]))[1] == D(2.0)
    batch = MotionPolynomial(np.stack([D.coeffs, D.coeffs]))
    assert same_point(batch(np.array([s, 2.0]))[0], one)


@given(motions(3), fractions)
def test_a_polynomial_from_factors(D, s):
    factors = [i, j - eps * i, 2 + k]
    product = MotionPolynomial.from_factors(factors, D(s))
    assert product == linear_factor(i) * linear_factor(j - eps * i) * linear_factor(2 + k) * D(s)


def test_values_from_factors_keep_the_digits_that_coefficients_lose():
    near, exact = 1 + 1e-9 * i, 1 + Fraction(1, 10**9) * i
    D = MotionPolynomial.from_factors([near, 1 + 1e-9 * j, 1.0 * k])
    E = MotionPolynomial.from_factors([exact, 1 + Fraction(1, 10**9) * j, k])
    t = np.array([1 + 2.0**-30, 0.5, 1e200, math.inf])
    wanted = E(Fraction(1) + Fraction(1, 2**30)).coeffs.astype(float)
    for value in (D(t)[0], D(float(t[0])), pickle.loads(pickle.dumps(D))(t)[0]):
        assert value.coeffs == pytest.approx(wanted, rel=1e-6, abs=1e-25)
    assert D(t)[3] == D(math.inf) == 1
    assert same_point(D(t)[2], one)
    batch = MotionPolynomial.from_factors([DualQuaternion.stack([near, 1.0 * j]), 1.0 * k])
    assert batch(0.5)[1] == (0.5 - j) * (0.5 - k)
    assert batch(np.array([0.5, math.inf]))[1] == 1


def test_batches_have_a_length_and_entries():
    batch = linear_factor(DualQuaternion.stack([i, j])) * linear_factor(k)
    assert len(batch) == 2
    assert [single == batch[n] for n, single in enumerate(batch)] == [True, True]
    curves = batch.trajectory([1, 0, 0])
    assert (len(curves), curves.shape) == (2, (2,))
    assert [(curve(2) == curves(2)[n]).all() for n, curve in enumerate(curves)] == [True, True]
    for single in (C, C.trajectory([1, 0, 0])):
        with pytest.raises(TypeError, match="no length"):
            len(single)


def test_a_batch_of_polynomials():
    factors = DualQuaternion(np.random.default_rng(0).normal(size=(4, 8)))
    batch = linear_factor(factors) * linear_factor(i)
    single = linear_factor(factors[2]) * linear_factor(i)
    assert (batch.shape, batch.degree, batch.coeffs.shape) == ((4,), 2, (4, 3, 8))
    assert batch[2] == single
    assert batch(0.5)[2] == single(0.5)
    assert batch(np.full(4, 0.5))[2] == single(0.5)
    assert batch(math.inf)[2] == 1
    assert batch(np.array([0.5, 0.5, math.inf, 0.5]))[2] == 1
    assert batch(np.linspace(0, 1, 3)[:, None]).shape == (3, 4)
    assert batch.norm_polynomial()[2] == pytest.approx(single.norm_polynomial())
    assert (batch == single).tolist() == [False, False, True, False]
    assert (batch != single).tolist() == [True, True, False, True]
    assert divmod(batch, linear_factor(i))[1].coeffs == pytest.approx(np.zeros((4, 1, 8)))


# Motions


@given(lines(), fractions)
def test_a_linear_factor_turns_about_its_axis(line, s):
    """By −2 arccot s about the axis of the unit half-turn h."""
    length = math.sqrt(sum(float(c) ** 2 for c in line.direction))
    turn = linear_factor(line.as_dual_quaternion() / length)(float(s))
    angle = -2 * math.atan2(1, float(s))
    expected = Rotation.from_rotvec(np.array(line.direction, dtype=float) / length * angle)
    assert as_matrix(turn)[:3, :3] == pytest.approx(expected.as_matrix(), abs=1e-9)
    assert act(turn, line.foot().astype(float)) == pytest.approx(line.foot().astype(float), abs=1e-9)


@given(motions(), vectors, fractions)
def test_trajectories_are_the_paths_of_points(C, point, s):
    curve = C.trajectory(point)
    assert curve.degree == 2 * C.degree
    assert (curve(s) == act(C(s), point)).all()
    assert (curve(math.inf) == point).all()


@given(motions(3))
def test_products_of_turns_are_motions(C):
    assert C.is_motion()
    assert not C.study_polynomial().any()


@pytest.mark.parametrize(
    "D", [C + eps, linear_factor(1 + eps), MotionPolynomial([eps.coeffs, (eps * i).coeffs]), 0 * C]
)
def test_what_is_no_motion(D):
    assert not D.is_motion()
    assert not (1.0 * D).is_motion()


def test_turns_about_axes_through_the_origin_are_motions_up_to_rounding():
    """Dual parts that are rounding are not judged by their own size."""
    random = np.random.default_rng(1)
    for _ in range(200):
        g = translation(random.normal(size=3))
        h1, h2 = (DualQuaternion([*random.normal(size=4), 0, 0, 0, 0]) for _ in range(2))
        assert (g.inverse() * (g * linear_factor(h1) * linear_factor(h2) * g.inverse()) * g).is_motion()


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_motions_at_every_scale(length):
    g = translation([length, 2 * length, -length])
    D = g * linear_factor(0.6 * i + 0.8 * j) * linear_factor(1.0 * k) * g.inverse()
    assert D.is_motion()
    assert not (D + 1e-6 * length * eps).is_motion()


@given(motions(), poses(), fractions)
def test_factors_of_numbers_do_not_change_a_motion(C, g, s):
    assert C.same_motion(C * MotionPolynomial([one.coeffs, (s * one).coeffs]))
    assert (g * C).same_motion(3 * g * C)
    assert C.same_motion(C * g) == same_point(g, one)


def test_nearly_equal_motions_far_away_differ():
    g = translation([1e6, 0, 0])
    D = g * linear_factor(1.0 * i)
    assert D.same_motion(D * 2.0)
    assert not D.same_motion(D * (1 + 1e-4 * j))
    assert not D.same_motion(translation([1, 0, 0]) * D)


def test_trajectories_in_floats_and_infinity():
    curve = C.trajectory([1, 0, 0])
    points = curve(np.array([0.5, math.inf]))
    assert points.dtype == float
    assert points[0] == pytest.approx(np.array(act(C(Fraction(1, 2)), [1, 0, 0]), dtype=float))
    assert points[1] == pytest.approx([1, 0, 0])
    assert curve(sympy.oo).tolist() == curve(math.inf).tolist() == [1, 0, 0]


def test_trajectories_of_a_batch():
    """As many curves as a single one has coefficients, so that the axes could be mistaken."""
    batch = linear_factor(DualQuaternion.stack([i, j, k, i + j, i - k])) * linear_factor(j - eps * i)
    curves = batch.trajectory([1, 2, 3])
    assert curves.degree == 4
    assert curves(Fraction(1, 2)).shape == (5, 3)
    assert all((curves(2)[n] == batch[n].trajectory([1, 2, 3])(2)).all() for n in range(5))
    assert (curves(np.arange(5))[3] == batch[3].trajectory([1, 2, 3])(3)).all()


# Shapes, reading, wrong use


def test_values_do_not_change():
    source = np.eye(8)[:2].copy()
    D = MotionPolynomial(source)
    source[:] = 0
    assert D.leading == 1
    for array in (D.coeffs, D.leading.coeffs, C.trajectory([1, 0, 0]).coeffs):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 7
    for name in ("coefficients", "_coefficients", "other"):
        with pytest.raises(AttributeError):
            setattr(D, name, ())
    with pytest.raises(AttributeError, match="does not change"):
        del D._coefficients
    assert pickle.loads(pickle.dumps(D)) == D
    with pytest.raises(TypeError, match="unhashable"):
        hash(D)


@pytest.mark.parametrize("shape", [(8,), (2, 7), (0, 8), (), (3, 0)])
def test_coefficients_have_a_shape(shape):
    with pytest.raises(ValueError, match=r"expected coefficients of shape \(\.\.\., n\+1, 8\), got"):
        MotionPolynomial(np.zeros(shape))


@pytest.mark.parametrize("shape", [(4,), (2, 3)])
def test_curves_have_a_shape(shape):
    with pytest.raises(ValueError, match=r"expected coefficients of shape \(\.\.\., m\+1, 4\), got"):
        RationalCurve(np.zeros(shape))


@pytest.mark.parametrize("index", [0, slice(0, 1), Ellipsis])
def test_a_single_polynomial_has_no_entries(index):
    with pytest.raises(TypeError, match="no entries"):
        C[index]


def test_the_degree_is_formal():
    assert MotionPolynomial([[0] * 8, [1] + [0] * 7]).degree == 1
    assert MotionPolynomial([[0] * 8, [1] + [0] * 7]) == 1
    assert C - C == 0
    assert (C + MotionPolynomial([i.coeffs])).degree == 2


@pytest.mark.parametrize("other", [None, "C", object()])
def test_other_things_are_not_equal(other):
    assert other != C
    with pytest.raises(TypeError):
        C + other


@pytest.mark.parametrize(
    ("D", "text"),
    [
        (linear_factor(i), "t - i"),
        (C, "t^2 + (-i - j + εi) t + k + ε"),
        (MotionPolynomial([i.coeffs]), "i"),
        (0 * C, "0"),
        (MotionPolynomial([[[1] * 8]] * 3), "MotionPolynomial of degree 0, shape (3,)"),
    ],
)
def test_reading(D, text):
    assert repr(D) == text
