"""How values are shown: as text, as formulas, as tables."""

import re

import numpy as np
import pytest
from sympy import I, Rational, symbols

from kinlib import (
    DualQuaternion,
    Dyad,
    Line,
    MotionPolynomial,
    bennett_linkage,
    eps,
    half_turn,
    i,
    j,
    k,
    linear_factor,
    one,
    square_root,
)
from kinlib.gallery import THREE_POSES

x, root = symbols("x"), square_root(5)


@pytest.mark.parametrize(
    ("q", "text", "formula"),
    [
        (0 * one, "0", "0"),
        (1 - 2 * i + 3 * eps * j, "1 - 2 i + 3 εj", r"1 - 2 \mathbf{i} + 3 \varepsilon \mathbf{j}"),
        (k / 2, "1/2 k", r"\frac{1}{2} \mathbf{k}"),
        (2e-7 * k, "2e-07 k", r"2 \cdot 10^{-7} \mathbf{k}"),
        (1j * i, "√−1 i", r"\sqrt{-1} \mathbf{i}"),
        (I * i, "√−1 i", r"\sqrt{-1} \mathbf{i}"),
        ((1 - 2j) * j, "(1 - 2 √−1) j", r"(1 - 2 \sqrt{-1}) \mathbf{j}"),
        ((1 - 2 * I) * j, "(1 - 2 √−1) j", r"(1 - 2 \sqrt{-1}) \mathbf{j}"),
        (I * Rational(-6, 5) * k, "(-6/5 √−1) k", None),
        (x * I * k, "x*√−1 k", r"\sqrt{-1} x \mathbf{k}"),
        ((1 - root) * j, "(1 - a) j", r"(1 - \sqrt{5}) \mathbf{j}"),
    ],
)
def test_no_imaginary_unit_is_read_as_a_quaternion(q, text, formula):
    if formula is None:
        text = text.replace("(", "").replace(")", "")
    assert repr(q) == text
    assert formula is None or q._repr_latex_() == f"${formula}$"


def test_long_formulas_take_two_lines_and_short_ones_one():
    assert DualQuaternion([1 / 3] * 8)._repr_latex_().count(r"\\") == 1
    assert DualQuaternion([1] * 8)._repr_latex_().count(r"\\") == 0
    assert linear_factor(i)._repr_latex_() == r"$t + \left(-\mathbf{i}\right)$"
    cubic = linear_factor(i) * linear_factor(j / 3 - eps * i) * linear_factor(k)
    assert cubic._repr_latex_().count(r"\\") == 3  # a line for each power


def test_batches_have_no_formula():
    assert DualQuaternion.stack([i, j])._repr_latex_() is None
    assert MotionPolynomial([[[1] * 8]] * 3)._repr_latex_() is None
    dyads = Dyad(DualQuaternion.stack([i, i]), j - eps * i)  # and a single second axis beside two first ones
    assert dyads._repr_html_() == "<p>2R dyads of shape (2,)</p>"
    assert dyads.space().null_quadrilateral()._repr_latex_() is None


def cells(html: str) -> list[str]:
    return re.findall("<td>(.*?)</td>", html)


def test_a_dyad_shows_its_axes():
    table = Dyad(2 * i, j - eps * i)._repr_html_()
    assert "axes 1 apart, at 90°; home 1" in table
    assert cells(table) == ["at the base (h1)", "1, 0, 0", "0, 0, 0", "moving (h2)", "0, 1, 0", "0, 0, 1"]


def test_what_rounding_left_is_not_shown():
    tilted = half_turn(Line.at([0, 0, 3], [np.sqrt(2), 1e-17, 1e-16]))
    assert cells(Dyad(i.astype(float), eps * k * 0 + tilted * j * tilted.conjugate())._repr_html_())[4:] == [
        "0, -1, 0", "0, 0, 6",
    ]  # fmt: skip


def test_a_null_quadrilateral_shows_its_vertices():
    formula = Dyad(i, j - eps * i).space().null_quadrilateral()._repr_latex_()
    assert [formula.count(f"{name} &=") for name in ("u_1", "v_1", "u_2", "v_2")] == [1, 1, 1, 1]
    assert r"\sqrt{-1} \mathbf{i}" in formula


def test_rows_of_tables_are_plain_floats():
    rows = bennett_linkage(*THREE_POSES).denavit_hartenberg()
    assert {type(number) for row in rows for number in row} == {float}
