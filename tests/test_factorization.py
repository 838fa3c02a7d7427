"""Factorizations are put back into the product; quadratic factors are multiplied out again."""

from fractions import Fraction
from functools import reduce
from itertools import permutations
from math import factorial

import numpy as np
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Line,
    MotionPolynomial,
    NumberFieldElement,
    act,
    bennett_flip,
    conic_through,
    eps,
    exchange,
    factorizations,
    factorize,
    i,
    j,
    k,
    linear_factor,
    one,
    quadratic_factors,
    quadratic_of,
    rotation,
    same_point,
    square_root,
    translation,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, LINEAR_TERMS_EQUAL
from kinlib.testing import random_poses
from strategies import fractions, rotations, whole

a = square_root(2)
x, y = sympy.symbols("x y", positive=True)
h1, h2, h3 = i, 2 * j - 2 * eps * i, 1 + k + eps * (3 * i - j)


def multiplied(factors) -> list:
    """The product of polynomials, with Python's own arithmetic."""
    return reduce(np.polymul, np.asarray(factors)).tolist()


def product(factors) -> MotionPolynomial:
    return reduce(lambda C, h: C * linear_factor(h), factors, MotionPolynomial([one.coeffs]))


@st.composite
def quadratics(draw):
    """t² + bt + c without real roots."""
    p, q = draw(fractions), draw(fractions.filter(bool))
    return [Fraction(1), -2 * p, p * p + q * q * draw(st.integers(1, 5))]


def random_turn(seed: int, shape=()) -> DualQuaternion:
    """A linear factor's root: any real part, half-turns of any length about lines anywhere."""
    random = np.random.default_rng(seed)
    line = Line.at(random.normal(size=(*shape, 3)), random.normal(size=(*shape, 3)))
    return random.normal(size=shape) + line.as_dual_quaternion()


# Quadratic factors of real polynomials


@settings(max_examples=25)
@given(st.lists(quadratics(), min_size=1, max_size=3))
def test_rational_factors_are_found(factors):
    found = quadratic_factors(multiplied(factors))
    assert sorted(found.tolist()) == sorted(factors)


@given(st.lists(quadratics(), min_size=2, max_size=3), whole.filter(bool))
def test_factors_multiply_to_the_polynomial(factors, leading):
    polynomial = [leading * c for c in multiplied(factors)]
    found = quadratic_factors(polynomial)
    assert [leading * c for c in multiplied(found)] == polynomial


@given(quadratics(), st.integers(1, 3))
def test_repeated_factors_are_found(quadratic, power):
    assert quadratic_factors(multiplied([quadratic] * power)).tolist() == [quadratic] * power


@settings(max_examples=30)
@given(st.lists(whole, min_size=4, max_size=4))
def test_irreducible_quartics_split_exactly(coefficients):
    polynomial = [1, *coefficients]
    roots = sympy.Poly(polynomial, sympy.Symbol("t")).count_roots()
    if roots:
        with pytest.raises(DegenerateError, match="real root"):
            quadratic_factors(polynomial)
        return
    factors = quadratic_factors(polynomial)
    assert multiplied(factors) == polynomial
    assert all(b * b < 4 * c for _, b, c in factors)


@pytest.mark.parametrize(
    ("polynomial", "degree"),
    [
        ([1, 0, 3, 0, 1], 2),  # a² = 5, equal linear terms
        ([1, 4, 9, 10, 5], 2),  # the same, moved by one
        ([1, 0, 0, 0, 1], 2),  # a² = 2, equal constant terms
        ([1, 0, 2, 0, 2], 4),
        ([1, 1, 1, 1, 1], 2),
        ([1, 0, 1, 1, 1], 6),
        ([1, 1, 5, 2, 3], 6),
    ],
)
def test_the_field_has_the_degree_that_is_needed(polynomial, degree):
    factors = quadratic_factors(polynomial)
    fields = {c.field for c in factors.ravel() if isinstance(c, NumberFieldElement)}
    assert [field.degree for field in fields] == [degree]
    assert multiplied(factors) == polynomial


@pytest.mark.parametrize("polynomial", [[1, 0, 5, 0, 4], [1, 0, 3, 0, 1], [2, 1, 5, 2, 3], [1, 0, 6, 0, 11, 0, 6]])
def test_floats_and_exact_numbers_give_the_same_factors_in_the_same_order(polynomial):
    exact = quadratic_factors(polynomial)
    assert quadratic_factors(np.array(polynomial, dtype=float)) == pytest.approx(exact.astype(float))


@given(quadratics(), quadratics())
def test_factors_are_sorted_by_the_real_part_of_their_roots(first, second):
    (_, b, c), (_, d, e) = quadratic_factors(multiplied([first, second]))
    assert (-b, c) <= (-d, e)


@settings(max_examples=12)
@given(quadratics(), st.integers(-4, 4), whole)
def test_factors_over_a_number_field(quadratic, n, m):
    moved = [1, 2 * n * a, 2 * n * n + 1 + m * m]
    assert sorted(quadratic_factors(multiplied([quadratic, moved])).tolist()) == sorted([quadratic, moved])


def test_factors_with_symbols():
    first, second = [1, 0, x**2], [1, -2 * y, y**2 + 1]
    factors = quadratic_factors([sympy.expand(c) for c in multiplied([first, second])])
    assert sorted(map(str, factors.tolist())) == sorted(map(str, ([1, 0, x**2], [1, -2 * y, y**2 + 1])))
    t = sympy.Symbol("t")
    assert quadratic_factors([1, 0, t**2]).tolist() == [[1, 0, t**2]]


@pytest.mark.parametrize("degree", [2, 4, 6, 8])
def test_factors_of_floats_in_batches(degree):
    random = np.random.default_rng(degree)
    half = degree // 2
    b = random.normal(size=(50, half))
    factors = np.stack([np.ones((50, half)), b, b**2 / 4 + random.uniform(0.5, 2, (50, half))], -1)
    polynomials = np.array([multiplied(row) for row in factors])
    found = quadratic_factors(polynomials)
    assert found.shape == (50, half, 3)
    assert np.array([multiplied(row) for row in found]) == pytest.approx(polynomials, rel=1e-9)
    assert np.all(np.diff(-found[..., 1]) >= 0)
    assert quadratic_factors(polynomials.reshape(10, 5, -1)) == pytest.approx(found.reshape(10, 5, half, 3))


def test_exact_batches_are_split_row_by_row():
    rows = [[1, 0, 5, 0, 4], [1, 0, 2, 0, 1], [1, 0, 3, 0, 1]]
    assert quadratic_factors(rows).tolist() == [quadratic_factors(row).tolist() for row in rows]


@pytest.mark.parametrize("power", [2, 3])
def test_repeated_factors_of_floats(power):
    polynomial = np.array(multiplied([[1.0, 1.0, 2.0]] * power))
    factors = quadratic_factors(polynomial)
    assert multiplied(factors) == pytest.approx(polynomial)
    assert factors == pytest.approx(np.array([[1, 1, 2]] * power), abs=1e-4)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_factors_of_floats_at_every_scale(scale):
    quadratics = [[1, scale, scale**2], [1, -scale, 3 * scale**2]]
    assert quadratic_factors(multiplied(quadratics)) == pytest.approx(np.array(quadratics))


REAL_ROOTS = [
    [1, 0, 0],
    [1, 0, -2],
    [1, -2, 1],
    [1, 0, 0, 0, -1],
    [1, 0, 0, 0, -2],  # irreducible, two real roots
    [1, 0, -10, 0, 1],  # irreducible, four
    [1, 0, -4, 0, 2],
    [1, 1, -3, 1, 2],
    [1, 0, 2, -2, 3, -2, -2],
]


@pytest.mark.parametrize("polynomial", REAL_ROOTS)
@pytest.mark.parametrize("scalars", [int, float])
def test_real_roots_are_refused(polynomial, scalars):
    with pytest.raises(DegenerateError, match="has a real root"):
        quadratic_factors(np.array(polynomial).astype(scalars))


def test_real_roots_over_a_field_and_in_batches_are_refused():
    for polynomial in ([1, 0 * a, -3], [1, 0, -a], [1, -a, 0], [[1, 0, 1], [1, 0, -1]], [[1.0, 0, 1], [1, 0, -1]]):
        with pytest.raises(DegenerateError, match="has a real root"):
            quadratic_factors(polynomial)


@pytest.mark.parametrize(
    ("polynomial", "message"),
    [
        ([1, 0, 0, 0, 0, 1, 1], "too large"),
        ([1, a, 5, 1, 7], "too large"),
        ([1, 0, sympy.sqrt(2)], "expected rational numbers"),
        ([1, a, 5, square_root(3), 7], "one field"),
        ([1, 0, x, 0, 1], "no quadratic factors"),
        ([1, 2, 3, 4], "even degree"),
        ([1, 2], "even degree"),
        (5, "even degree"),
        ([1, 0, 1 + 1j], "real coefficients"),
        ([0, 0, 1, 0, 1], "leading coefficient"),
        ([0.0, 0, 1, 0, 1], "leading coefficient"),
        ([0, 0, 0], "leading coefficient"),
        ([1.0, 0, np.nan], "finite"),
        ([1.0, 0, np.inf], "finite"),
    ],
)
def test_what_cannot_be_split(polynomial, message):
    with pytest.raises(ValueError, match=message):
        quadratic_factors(polynomial)


def test_undefined_rows_of_a_batch_stay_undefined():
    factors = quadratic_factors([[1.0, 0, np.nan], [1, 0, 4]])
    assert np.isnan(factors[0, 0, 1:]).all()
    assert factors[1, 0] == pytest.approx([1, 0, 4])


# Factorizations


@given(rotations())
def test_the_quadratic_of_a_factor(h):
    C = linear_factor(h)
    assert quadratic_of(h).tolist() == C.norm_polynomial().tolist()
    assert C * C.conjugate() == MotionPolynomial([(one * c).coeffs for c in quadratic_of(h)])


def check_all(C: MotionPolynomial) -> None:
    """n! factorizations, each of which gives C, with the norms in all orders."""
    found = factorizations(C)
    norms = quadratic_factors(C.norm_polynomial())
    assert len(found) == factorial(C.degree)
    for factors, order in zip(found, permutations(range(C.degree)), strict=True):
        assert product(factors) == C
        assert [quadratic_of(h).tolist() for h in factors] == norms[list(order)].tolist()
        assert factorize(C, order) == factors


@settings(max_examples=12)
@given(st.lists(rotations(), min_size=1, max_size=3))
def test_all_factorizations_of_generic_motions(factors):
    norms = {tuple(quadratic_of(h)) for h in factors}
    assume(len(norms) == len(factors))
    check_all(product(factors))


@pytest.mark.parametrize("poses", [LINEAR_TERMS_EQUAL, FIELD_OF_DEGREE_SIX])
def test_all_factorizations_over_a_number_field(poses):
    C = conic_through(*poses)
    check_all(C)
    assert any(isinstance(c, NumberFieldElement) for h in factorizations(C)[0] for c in h.coeffs)


def test_the_factorization_one_starts_from_is_among_them():
    assert (h1, h2, h3) in factorizations(product([h1, h2, h3]))


def test_no_factors_of_a_constant():
    assert factorizations(MotionPolynomial([one.coeffs])) == [()]


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", range(3))
def test_factorizations_in_floats(degree, seed):
    C = product([random_turn(10 * seed + n) for n in range(degree)])
    found = factorizations(C)
    assert len(found) == factorial(degree)
    for factors in found:
        assert product(factors).coeffs == pytest.approx(C.coeffs, rel=1e-7, abs=1e-7)
    assert len({tuple(factors[0].coeffs.round(6)) for factors in found}) == degree  # one for each quadratic


@pytest.mark.parametrize("length", [1e-3, 1e3, 1e6])
def test_factorizations_far_from_the_origin(length):
    g = translation([length, 2 * length, -length])
    C = g * product([random_turn(1), random_turn(2)]) * g.inverse()
    for factors in factorizations(C):
        expected = product(factors)
        assert all(same_point(c, d, length=length) for c, d in zip(expected.coefficients, C.coefficients, strict=True))


@pytest.mark.parametrize("shape", [(5,), (2, 3)])
def test_factorizations_of_a_batch(shape):
    C = product([random_turn(n, shape) for n in range(3)])
    found = factorizations(C)
    assert len(found) == 6
    last = factorizations(MotionPolynomial(C.coeffs[-1] if len(shape) == 1 else C.coeffs[-1, -1]))
    for factors, single in zip(found, last, strict=True):
        assert all(h.shape == shape for h in factors)
        assert product(factors).coeffs == pytest.approx(C.coeffs, rel=1e-7, abs=1e-7)
        index = -1 if len(shape) == 1 else (-1, -1)
        assert all(h[index].coeffs == pytest.approx(s.coeffs, rel=1e-6) for h, s in zip(factors, single, strict=True))


def test_factorizations_of_an_exact_batch():
    C = MotionPolynomial(np.stack([product([h1, h2]).coeffs, product([h3, h2]).coeffs]))
    for factors, first, second in zip(
        factorizations(C), factorizations(product([h1, h2])), factorizations(product([h3, h2])), strict=True
    ):
        assert [h[0] for h in factors] == list(first)
        assert [h[1] for h in factors] == list(second)


def test_a_numbering_of_ones_own():
    C = product([h1, h2, h3])
    own = np.stack([quadratic_of(h) for h in (h1, h2, h3)])
    assert factorize(C, (0, 1, 2), own) == (h1, h2, h3)
    assert [quadratic_of(h).tolist() for h in factorize(C, (2, 0, 1), own.tolist())] == own[[2, 0, 1]].tolist()


def test_a_repeated_factor_splits_in_one_way():
    assert factorizations(product([h1, h1])) == [(h1, h1)] * 2
    assert factorizations(product([i, j - eps * i])) == [(i, j - eps * i)] * 2


NOT_TO_BE_SPLIT = {
    "circular translation": product([k, -k + eps * i]),
    "circular translation and a turn": product([h2, k, -k + eps * i]),
    "a real factor": product([i, -i]) + 0,
    "Darboux-like": MotionPolynomial([one.coeffs, (eps * i).coeffs, one.coeffs]),
}


@pytest.mark.parametrize("name", NOT_TO_BE_SPLIT)
def test_motions_that_some_order_does_not_split(name):
    C = NOT_TO_BE_SPLIT[name]
    assert C.is_motion()
    with pytest.raises(DegenerateError, match=r"factor|translation"):
        factorizations(C)


@pytest.mark.parametrize("seed", range(5))
def test_motions_that_do_not_split_in_floats(seed):
    """Wherever rounding makes the remainder invertible, the product is checked."""
    (p,) = random_poses(1, seed=seed)
    axes = (act(p, Line.at(point, [0, 0, s])) for point, s in (([0.0, 0, 0], 1.0), ([1.0, 2, 0], -1.0)))
    C = product([axis.as_dual_quaternion() for axis in axes])
    try:
        found = factorizations(C)
    except DegenerateError:
        return
    assert all(product(factors).coeffs == pytest.approx(C.coeffs, abs=1e-6) for factors in found)


def test_a_translation_cannot_be_split_off():
    with pytest.raises(DegenerateError, match="real root"):
        factorizations(product([i, eps * j]))


@pytest.mark.parametrize(
    ("C", "error", "message"),
    [
        (2 * linear_factor(i), ValueError, "expected a monic polynomial"),
        (i * linear_factor(i), ValueError, "expected a monic polynomial"),
        (linear_factor(i + eps), DegenerateError, "leaves the Study quadric"),
        (linear_factor(i * float("nan")), DegenerateError, "Study quadric|finite"),
    ],
)
def test_what_has_no_factorization(C, error, message):
    with pytest.raises(error, match=message):
        factorizations(C)
    with pytest.raises(error, match=message):
        factorize(C, (0,))


@pytest.mark.parametrize("order", [(0,), (0, 0), (1, 2), (0, 1, 2), ()])
def test_an_order_is_a_permutation(order):
    with pytest.raises(ValueError, match="expected a permutation of 0, …, 1"):
        factorize(product([h1, h2]), order)


def test_quadratics_of_another_polynomial_are_refused():
    with pytest.raises(DegenerateError, match="no factorization"):
        factorize(product([h1, h2]), (0, 1), [[1, 0, 2], [1, 0, 3]])


REAL_FACTORS = {
    "three turns about parallel axes": [k, k + eps * i, -k],
    "a turn and a real quadratic": [k, i, -i],
    "a circular translation": [k, -k + eps * i],
}


@pytest.mark.parametrize("name", REAL_FACTORS)
@pytest.mark.parametrize("scalars", [1, 1.0])
def test_a_real_factor_of_the_primal_part_is_named(name, scalars):
    """These are all turns: it is not a translation that hinders."""
    C = scalars * product(REAL_FACTORS[name])
    with pytest.raises(DegenerateError, match=r"the primal part has a real factor|no factorization"):
        factorizations(C)
    if scalars == 1:
        with pytest.raises(DegenerateError, match=r"^the primal part has a real factor"):
            factorizations(C)


@pytest.mark.parametrize("centre", [100.0, -1000.0])
def test_factorizations_of_motions_whose_roots_lie_far_from_zero(centre):
    """Coefficients of size 100³ have lost ten digits; the rest must not be lost as well."""
    for seed in range(40):
        C = product([random_turn(10 * seed + n) + centre for n in range(3)])
        for factors in factorizations(C):
            difference = product(factors).coeffs - C.coeffs
            assert np.abs(difference).max() < 1e-12 * np.abs(C.coeffs).max()
    again = factorizations(product([h + centre for h in (1.0 * h1, 1.0 * h2, 1.0 * h3)]))
    for factors, expected in zip(again, factorizations(product([1.0 * h1, 1.0 * h2, 1.0 * h3])), strict=True):
        for h, g in zip(factors, expected, strict=True):
            assert (h - centre).coeffs == pytest.approx(g.coeffs, abs=1e-15 * abs(centre) ** 3)


def test_spherical_motions_about_a_point_up_to_rounding():
    """All axes pass through one point; dual parts about it are rounding."""
    for seed in range(30):
        random = np.random.default_rng(seed)
        g = translation(random.normal(size=3))
        turns = [DualQuaternion([*random.normal(size=4), 0, 0, 0, 0]) for _ in range(3)]
        C = g.inverse() * product([g * h * g.inverse() for h in turns]) * g
        assert C.is_motion()
        for factors in factorizations(C):
            assert product(factors).coeffs == pytest.approx(C.coeffs, abs=1e-9)


def test_the_order_does_not_flip_with_rounding():
    """Equal real parts are sorted by the imaginary ones, exactly and in floats, single and in a batch."""
    exact = factorizations(product([i, 2 * j - 2 * eps * i, 3 * k]))
    random = np.random.default_rng(0)
    C = product([1.0 * i, 2.0 * j - 2 * eps * i, 3.0 * k])
    polynomials = C.norm_polynomial() + 1e-14 * random.normal(size=(50, 7))
    assert quadratic_factors(polynomials) == pytest.approx(
        np.broadcast_to([[1, 0, 1], [1, 0, 4], [1, 0, 9]], (50, 3, 3))
    )
    for factors, expected in zip(factorizations(C), exact, strict=True):
        assert all(
            h.coeffs == pytest.approx(g.coeffs.astype(float), abs=1e-12) for h, g in zip(factors, expected, strict=True)
        )


def test_rows_without_factorizations_are_named_or_nan():
    rows = [product([h1, h2]).coeffs, product([i, eps * j]).coeffs, product([k, -k + eps * i]).coeffs]
    C = MotionPolynomial(np.array(rows).astype(float))
    with pytest.raises(DegenerateError, match=r"^rows 1, 2: the polynomial has a real root.*real factor") as caught:
        factorizations(C)
    assert caught.value.rows == (1, 2)
    for factors in factorizations(C, degenerate="nan"):
        assert all(np.isnan(h.coeffs).any(axis=-1).tolist() == [False, True, True] for h in factors)
        assert (factors[0] * factors[1])[0].coeffs == pytest.approx((h1 * h2).coeffs.astype(float))


@pytest.mark.parametrize("order", [(1.0, 0.0), None, 5, "ab"])
def test_an_order_is_made_of_whole_numbers(order):
    with pytest.raises(TypeError, match="expected an order"):
        factorize(product([h1, h2]), order)


@pytest.mark.parametrize("quadratics", [[[1, 0, 1]], [1, 0, 1], [[1, 0], [1, 0]]])
def test_there_are_as_many_quadratics_as_factors(quadratics):
    with pytest.raises(ValueError, match=r"expected quadratics of shape \(\.\.\., 2, 3\), got"):
        factorize(product([h1, h2]), (0, 1), quadratics)


@pytest.mark.parametrize("C", [None, [1, 2], h1])
def test_only_motion_polynomials_are_factored(C):
    for call in (lambda: factorizations(C), lambda: factorize(C, (0,))):
        with pytest.raises(TypeError, match="expected a MotionPolynomial"):
            call()


# Bennett flips


@given(rotations(), rotations(), rotations(), st.integers(0, 1))
def test_neighbours_are_exchanged(g, h, r, n):
    factors = (g, h, r)
    assume((factors[n].conjugate() - factors[n + 1]).primal != 0)
    exchanged = exchange(factors, n)
    assert product(exchanged) == product(factors)
    assert exchanged[2 - 2 * n] == factors[2 - 2 * n]
    assert quadratic_of(exchanged[n]).tolist() == quadratic_of(factors[n + 1]).tolist()


@pytest.mark.parametrize("n", [-1, 1, 2])
def test_only_neighbours_are_exchanged(n):
    with pytest.raises(ValueError, match="expected neighbours"):
        exchange((h1, h2), n)


def test_rows_that_cannot_be_exchanged_are_named():
    with pytest.raises(DegenerateError, match=r"^row 1: the two factors have conjugate") as caught:
        bennett_flip(DualQuaternion.stack([i, i]), DualQuaternion.stack([j, -i]))
    assert caught.value.rows == (1,)


@given(rotations(), rotations())
def test_a_flip_exchanges_the_quadratics_and_keeps_the_product(g, h):
    if (g.conjugate() - h).primal == 0:
        with pytest.raises(DegenerateError, match="conjugate"):
            bennett_flip(g, h)
        return
    first, second = bennett_flip(g, h)
    assert linear_factor(first) * linear_factor(second) == linear_factor(g) * linear_factor(h)
    assert quadratic_of(first).tolist() == quadratic_of(h).tolist()
    assert quadratic_of(second).tolist() == quadratic_of(g).tolist()


@given(rotations(), rotations())
def test_flipping_twice_changes_nothing(g, h):
    assume((g.conjugate() - h).primal != 0)
    first, second = bennett_flip(g, h)
    assume((first.conjugate() - second).primal != 0)
    assert bennett_flip(first, second) == (g, h)


def test_a_flip_is_the_other_factorization():
    assert set(map(repr, factorizations(product([h1, h2])))) == {repr((h1, h2)), repr(bennett_flip(h1, h2))}


def test_flips_in_symbols_and_in_batches():
    g, h = x * i, y * j - eps * i
    first, second = bennett_flip(g, h)
    assert linear_factor(first) * linear_factor(second) == linear_factor(g) * linear_factor(h)
    g, h = random_turn(1, (4,)), random_turn(2, (4,))
    first, second = bennett_flip(g, h)
    assert (first * second).coeffs == pytest.approx((g * h).coeffs)
    assert first[3].coeffs == pytest.approx(bennett_flip(g[3], h[3])[0].coeffs)


def test_turns_about_one_axis_commute():
    assert bennett_flip(k, 2 * k) == (2 * k, k)
    quarter = rotation(Line([0, 0, 1], [0, 0, 0]), 0.5)
    assert bennett_flip(quarter, quarter)[0].coeffs == pytest.approx(quarter.coeffs)
