"""Recorded formulas: they are the functions, in Python and in a browser, or there is an error that says why not."""

import random

import numpy as np
import pytest

import kinlib as kl
from kinlib import common_perpendicular, eps, i, j, k
from kinlib.gallery import THREE_POSES
from kinlib.pictures import record

PLANE = {"x": (-1.0, 3.0), "y": (0.3, 2.0)}


def random_expression(chance: random.Random, depth: int = 6):
    """A function of x and y made of sums, products, quotients, powers, roots and angles at random."""
    if depth == 0:
        constant = chance.randrange(-9, 10) / 8
        return chance.choice([lambda x, y: x, lambda x, y: y, lambda x, y: constant])
    f, g = random_expression(chance, depth - 1), random_expression(chance, depth - 1)
    return chance.choice([
        lambda x, y: f(x, y) + g(x, y),
        lambda x, y: f(x, y) - g(x, y),
        lambda x, y: f(x, y) * g(x, y),
        lambda x, y: f(x, y) / (1 + g(x, y) * g(x, y)),
        lambda x, y: -f(x, y) ** 2,
        lambda x, y: np.sqrt(1 + f(x, y) ** 2 + x * x),
        lambda x, y: np.arctan2(x + f(x, y) ** 2, 2 + y * y),
    ])  # fmt: skip


def close(a, b, rtol: float) -> bool:
    """Whether rows of numbers agree, relative to the largest of each."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return bool(np.all(np.abs(a - b).max(axis=-1) <= rtol * np.abs(b).max(axis=-1)))


def length(h):
    square = kl.dual_quaternion.null_form(h, h)
    return np.sqrt(square if hasattr(square, "sqrt") else float(square))


def axes_of_all_eight(x, y):
    linkages = kl.goldberg_linkages(*THREE_POSES, (x, y))
    return [h / length(h) for linkage in linkages for h in linkage.axes]


def factors_of_all_eight(x, y):
    return [linkage.factors for linkage in kl.goldberg_linkages(*THREE_POSES, (x, y))]


@pytest.fixture(scope="module")
def eight():
    return record(factors_of_all_eight, PLANE)


# ---- what is recorded --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_random_expressions_are_recorded(seed):
    function = random_expression(random.Random(seed))
    formula = record(lambda x, y: [function(x, y), x], {"x": (-2, 2), "y": (-2, 2)}, seed=seed)
    x, y = np.random.default_rng(seed).uniform(-2, 2, (2, 200))
    found = np.broadcast_arrays(*formula.evaluate(x=x, y=y))
    expected = np.broadcast_arrays(function(x, y) + 0.0, x)
    assert close(np.transpose(found), np.transpose(expected), 1e-9)


def test_eight_linkages_are_recorded_to_the_last_digits(eight):
    x, y = np.random.default_rng(0).uniform([[-1], [0.3]], [[3], [2]], (2, 20))
    found = eight.evaluate(x=x, y=y)
    for n in range(20):
        for linkage, factors in zip(kl.goldberg_linkages(*THREE_POSES, (x[n], y[n])), found, strict=True):
            for f, coefficients in zip(linkage.factors, factors, strict=True):
                assert close([np.broadcast_to(c, 20)[n] for c in coefficients], f.coeffs, 1e-11)


def test_the_text_is_the_same_each_time(eight):
    assert record(factors_of_all_eight, PLANE).javascript == eight.javascript


def test_eight_linkages_are_short(eight):
    assert len(eight.steps) < 2000
    assert len(eight.javascript) < 30_000


def test_what_is_the_same_is_written_once():
    formula = record(lambda x, y: [(x + y) * (x - y), x * x - y * y, (y - x) * (x + y)], {"x": (1, 2), "y": (1, 2)})
    assert len(formula.steps) == 2 + 3 + 1


def test_what_no_result_needs_is_left_out():
    def function(x):
        _ = np.sqrt(x + 17)
        return x * x

    assert record(function, {"x": (0, 1)}).javascript == "(x)=>{const $1=x*x;return $1}"


@pytest.mark.parametrize(
    "neutral", [lambda x: 1 * x + 0, lambda x: x / 1 - 0, lambda x: 0 + x * 1, lambda x: -(-1 * x), lambda x: x**1]
)
def test_zeros_and_ones_leave_no_trace(neutral):
    assert record(neutral, {"x": (0, 1)}).javascript == "(x)=>{return x}"


def test_an_identity_is_decided_exactly():
    seen = []

    def function(x, y):
        seen.append(((x + y) ** 3 == x**3 + 3 * x * x * y + 3 * x * y * y + y**3, x == y, bool(x - x)))
        return x + y

    record(function, {"x": (0, 1), "y": (0, 1)})
    assert seen[0] == (True, False, False)


def test_a_product_that_is_a_number_has_zeros_in_its_other_places():
    formula = record(lambda x: (i * x + 1) * (1 - i * x), {"x": (-1, 1)})
    assert formula.outputs[1:] == [0.0] * 7


def test_results_may_be_nested():
    formula = record(
        lambda a, b: {"point": np.array([a, b]), "line": (a * i + b * eps * j), "n": 3}, {"a": (0, 1), "b": (0, 1)}
    )
    found = formula.evaluate(a=0.25, b=0.5)
    assert found == {"point": [0.25, 0.5], "line": [0, 0.25, 0, 0, 0, 0, 0.5, 0], "n": 3}
    assert formula.javascript.endswith('return {"point":[a,b],"line":[0,a,0,0,0,0,b,0],"n":3}}')


def test_feet_of_a_common_perpendicular_are_recorded():
    def feet(a, b):
        first, second = (kl.Line.from_dual_quaternion(h) for h in (k + a * eps * i, j + b * k - b * eps * j + eps * k))
        return common_perpendicular(first, second)

    assert len(record(feet, {"a": (1, 2), "b": (1, 2)}).steps) < 40


# ---- what cannot be recorded -------------------------------------------------------------------------


def test_a_comparison_that_changes_is_named_with_its_line_and_a_place():
    with pytest.raises(ValueError, match=r"test_formula\.py:\d+: the answer of the comparison > changes .* x = "):
        record(lambda x: x if x > 0 else -x, {"x": (-1, 1)})


def test_a_comparison_that_does_not_change_is_no_matter():
    assert record(lambda x: x if x > 0 else -x, {"x": (1, 2)}).javascript == "(x)=>{return x}"


def test_a_parameter_that_is_lost_is_noticed():
    with pytest.raises(ValueError, match=r"the formula is not the function: at x = .* lost track"):
        record(lambda x: float(x) ** 2, {"x": (0, 1)})


def test_a_choice_by_a_value_without_its_trace_is_noticed():
    with pytest.raises(ValueError, match="the formula is not the function"):
        record(lambda x: x if float(x) > 0.5 else 2 * x, {"x": (0, 1)})


def test_equality_after_a_root_is_refused():
    with pytest.raises(ValueError, match=r"test_formula\.py:\d+: whether two numbers are equal cannot be told"):
        record(lambda x: int(np.sqrt(x) ** 2 == x), {"x": (1, 2)})


def test_a_range_goes_from_less_to_more():
    with pytest.raises(ValueError, match="expected a range"):
        record(lambda x: x, {"x": (1, 1)})


def test_all_values_are_asked_for():
    with pytest.raises(TypeError, match="expected values for x, got y"):
        record(lambda x: x, {"x": (0, 1)}).evaluate(y=1)


# ---- in a browser ------------------------------------------------------------------------------------

EVALUATE = "const f = eval(arguments[0]); return arguments[1].map((p) => f(...p));"


def in_the_page(chromium, formula, points):
    """What the text of a formula gives in a browser."""
    return chromium.execute_script(EVALUATE, formula.javascript, np.asarray(points).tolist())


@pytest.mark.parametrize("function", [factors_of_all_eight, axes_of_all_eight])
def test_the_page_computes_what_kinlib_computes(chromium, function):
    points = np.random.default_rng(1).uniform([-1, 0.3], [3, 2], (1000, 2))
    chromium.get("about:blank")
    found = in_the_page(chromium, record(function, PLANE), points)
    linkages = kl.goldberg_linkages(*THREE_POSES, points @ [1, 1j])
    if function is factors_of_all_eight:
        expected = np.stack([[np.broadcast_to(f.coeffs, (1000, 8)) for f in linkage.factors] for linkage in linkages])
        found = np.moveaxis(np.array(found), 0, 2)
    else:
        expected = np.stack([h for linkage in linkages for h in np.moveaxis(linkage.axes.coeffs, -2, 0)])
        found = np.moveaxis(np.array(found), 0, 1)
    gap = np.abs(found - expected).max(axis=-1) / np.abs(expected).max(axis=-1)
    assert np.median(gap) < 1e-15
    assert np.quantile(gap, 0.9995) < 1e-12
    assert gap.max() < 1e-11  # next to a bad place both lose digits


@pytest.mark.parametrize("seed", range(5))
def test_the_page_and_python_agree_on_random_expressions(chromium, seed):
    function = random_expression(random.Random(seed))
    formula = record(lambda x, y: [function(x, y), x], {"x": (-2, 2), "y": (-2, 2)}, seed=seed)
    points = np.random.default_rng(seed).uniform(-2, 2, (200, 2))
    chromium.get("about:blank")
    found = np.array(in_the_page(chromium, formula, points), dtype=float)
    expected = np.broadcast_arrays(*formula.evaluate(x=points[:, 0], y=points[:, 1]))
    assert close(found, np.transpose(expected), 1e-12)
