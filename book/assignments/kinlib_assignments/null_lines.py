"""The assignment on null lines: each student has two dyads, a prismatic joint and four three-spaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt
from typing import NamedTuple

import numpy as np

from kinlib import (
    DualQuaternion,
    Dyad,
    Quadric,
    Subspace,
    TwoRSpace,
    as_float,
    is_null_line,
    is_zero,
    meet,
    null_form,
    null_space,
    one,
    recognise,
    same_point,
    size,
    study_form,
)
from kinlib_assignments.checks import assert_equal, numbers, several, truth
from kinlib_assignments.lot import PYTHAGOREAN, Lot
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of

__all__ = [
    "KINDS", "Data", "check_forms", "check_inside_study_quadric", "check_kinds", "check_meets_exceptional_space",
    "check_null_line", "check_null_line_products", "check_null_lines", "check_places", "check_pose_at",
    "check_quadrilateral", "check_real_pair", "check_stray", "check_three_lines", "data", "spaces",
]  # fmt: skip

KINDS = ("skew axes", "parallel axes", "intersecting axes", "prismatic joint")
"""What two joints in a row may be: two hinges, or a hinge and a slide."""


class Data(NamedTuple):
    """Four half-turns of length 1 as eight numbers each, another one, and a vector."""

    h1: tuple[Fraction, ...]
    h2: tuple[Fraction, ...]
    g1: tuple[Fraction, ...]
    g2: tuple[Fraction, ...]
    h: tuple[Fraction, ...]
    v: tuple[int, ...]


def data(student: str) -> Data:
    """Two pairs of skew axes, the second at right angles and the first far from it, and a hinge with a slide.

    Examples
    --------
    >>> h1, h2, *_ = (DualQuaternion(x) for x in data("ada")[:4])
    >>> h1.norm() == h2.norm() == 1
    True
    """
    lot = Lot("null_lines", student)
    h1, h2 = lot.until(lambda: (_axis(lot), _axis(lot)), lambda pair: _are_skew(*pair) and _is_oblique(*pair))
    g1, g2 = lot.until(lambda: _square(lot), lambda pair: _are_skew(*pair))
    h, v = lot.until(lambda: (_axis(lot), lot.wholes(3, 3)), lambda pair: _is_oblique(*pair))
    return Data(*(_unit_half_turn(line) for line in (h1, h2, g1, g2, h)), tuple(v))


def _axis(lot: Lot) -> list[int]:
    """A line as six whole Plücker coordinates, its direction of whole length."""
    *vector, _ = lot.choice(PYTHAGOREAN)
    return _line(lot.wholes(3, 3), [lot.choice((-1, 1)) * x for x in lot.shuffled(vector)])


def _line(point, l) -> list[int]:
    """The line through a point, as direction and moment."""
    a1, a2, a3 = point
    return [*l, a2 * l[2] - a3 * l[1], a3 * l[0] - a1 * l[2], a1 * l[1] - a2 * l[0]]


def _square(lot: Lot) -> tuple[list[int], list[int]]:
    """Two lines at right angles: a rotation with the quaternion p has turned the first two axes of space."""
    p0, p1, p2, p3 = lot.until(lambda: lot.wholes(4, 3), lambda p: p.count(0) <= 1)
    first = p0 * p0 + p1 * p1 - p2 * p2 - p3 * p3, 2 * (p1 * p2 + p0 * p3), 2 * (p1 * p3 - p0 * p2)
    second = 2 * (p1 * p2 - p0 * p3), p0 * p0 - p1 * p1 + p2 * p2 - p3 * p3, 2 * (p2 * p3 + p0 * p1)
    return _line(lot.wholes(3, 3), first), _line(lot.wholes(3, 3), second)


def _unit_half_turn(line) -> tuple[Fraction, ...]:
    length = isqrt(_dot(line[:3], line[:3]))
    l1, l2, l3, m1, m2, m3 = (Fraction(x, length) for x in line)
    return (Fraction(0), l1, l2, l3, Fraction(0), m1, m2, m3)


def _dot(x, y) -> int:
    return sum(a * b for a, b in zip(x, y, strict=True))


def _study(x, y) -> int:
    return _dot(x[:3], y[3:]) + _dot(x[3:], y[:3])


def _are_skew(x, y) -> bool:
    """Whether |b(x, y)| is at least a quarter for the unit half-turns about two lines."""
    return 16 * _study(x, y) ** 2 >= _dot(x[:3], x[:3]) * _dot(y[:3], y[:3])


def _is_oblique(x, y) -> bool:
    """Whether the cosine of the angle between two lines, or a line and a vector, is from 1/10 to 9/10."""
    squares = _dot(x[:3], x[:3]) * _dot(y[:3], y[:3])
    return squares > 0 and squares <= 100 * _dot(x[:3], y[:3]) ** 2 <= 81 * squares


# ---- four three-spaces -------------------------------------------------------------------------------


def _kinds(student: str) -> dict[str, str]:
    """Which of the spaces A, B, C, D belongs to which two joints.

    Examples
    --------
    >>> sorted(_kinds("ada").values()) == sorted(KINDS)
    True
    """
    return dict(zip("ABCD", Lot("null_lines, kinds", student).shuffled(KINDS), strict=True))


def spaces(student: str) -> dict[str, DualQuaternion]:
    """Four three-spaces of P⁷, each given by four points with whole coordinates, a batch of shape (4,).

    Examples
    --------
    >>> spaces("ada")["A"].shape
    (4,)
    """
    lot = Lot("null_lines, spaces", student)
    return {name: DualQuaternion(_mixed(lot, _joints(lot, kind))) for name, kind in _kinds(student).items()}


def _joints(lot: Lot, kind: str) -> list:
    """The points 1, x, y, xy for two joints of a kind."""
    x, y = (
        DualQuaternion([0, *line[:3], 0, *line[3:]])
        for line in lot.until(lambda: _pair(lot, kind), lambda pair: _is_of(kind, *pair))
    )
    return [point.coeffs for point in (one, x, y, x * y)]


def _pair(lot: Lot, kind: str) -> tuple[list[int], list[int]]:
    a, l, b, r = (lot.wholes(3, 2) for _ in range(4))
    if kind == "parallel axes":
        return _line(a, l), _line(b, l)
    if kind == "intersecting axes":
        return _line(a, l), _line(a, r)
    return _line(a, l), _line(b, r) if kind == "skew axes" else [0, 0, 0, *r]


def _is_of(kind: str, x, y) -> bool:
    l, r = x[:3], y[3:] if kind == "prismatic joint" else y[:3]
    if kind == "parallel axes":
        return any(l) and x != y
    independent = _dot(l, r) ** 2 < _dot(l, l) * _dot(r, r)
    return independent and (kind == "intersecting axes" or _study(x, y) != 0)


def _mixed(lot: Lot, points: list) -> list:
    """Four other points of the space: whole combinations, so that no point is 1 or in E by itself."""

    def is_good(rows) -> bool:
        return all(row.count(0) <= 1 for row in rows) and round(np.linalg.det(rows)) != 0

    rows = lot.until(lambda: [lot.wholes(4, 2) for _ in range(4)], is_good)
    return [sum(c * point for c, point in zip(row, points, strict=True)) for row in rows]


# ---- checks ------------------------------------------------------------------------------------------


def _assert_true_or_false(answer, expected: bool, what: str, why: str = "") -> None:
    """Fail unless an answer is the expected one of True and False."""
    if truth(answer, what) != expected:
        raise AssertionError(f"{what}: it is {expected}{': ' + why if why else ''}")


def _assert_forms(answer, x: DualQuaternion, y: DualQuaternion) -> None:
    """Fail unless the answer holds the null form and the Study form of two points."""
    right = null_form(x, y), study_form(x, y)
    half = sum(a * b for a, b in zip(x.coeffs[:4], y.coeffs[4:], strict=True))
    square = (x * y + y * x) / 2
    slips = {
        "the conjugates are missing: x ȳ and y x̄": square.coeffs[[0, 4]],
        "both are twice too large: x ȳ + y x̄ holds each product twice": (2 * right[0], 2 * right[1]),
        "the Study form is half as large: p of the first with d of the second, and the other way round": (
            right[0],
            half,
        ),
        "the Study form is half of what it should be": (right[0], right[1] / 2),
        "they are exchanged: the null form comes first": right[::-1],
        "the null form does not see the dual parts": ((x.coeffs * y.coeffs).sum(), right[1]),
    }
    assert_equal(answer, right, "the two forms", slips)


def _assert_pose_at(answer, h1: DualQuaternion, h2: DualQuaternion, t1, t2) -> None:
    """Fail unless the answer is the pose (t1 − h1)(t2 − h2), up to a factor."""
    point = _point(answer, "the pose R(t1, t2)")
    if same_point(point, (t1 - h1) * (t2 - h2)):
        return
    slips = {
        "the joint at the base is the left factor": (t2 - h2) * (t1 - h1),
        "the sign of the half-turns is wrong": (t1 + h1) * (t2 + h2),
        "the two parameters are exchanged": (t2 - h1) * (t1 - h2),
    }
    found = [said for said, value in slips.items() if same_point(point, value)]
    raise AssertionError(f"the pose R(t1, t2): {found[0] if found else 'expected (t1 − h1)(t2 − h2)'}")


def _assert_null_lines(answer, h1: DualQuaternion, h2: DualQuaternion) -> None:
    """Fail unless the answer holds two points on each of the four null lines of a dyad."""
    pairs = _pairs(answer, 4)
    space = _equations(one, h1, h2, h1 * h2)
    for number, pair in enumerate(pairs, 1):
        _assert_null_line_in(space, pair, f"line {number}")
    _assert_all_there(
        pairs,
        {
            "t1 = √−1": lambda x: (1j + h1) * x,
            "t1 = −√−1": lambda x: (1j - h1) * x,
            "t2 = √−1": lambda x: x * (1j + h2),
            "t2 = −√−1": lambda x: x * (1j - h2),
        },
    )


def _assert_three_lines(answer, h: DualQuaternion, v) -> None:
    """Fail unless the answer holds two points on each of the three null lines of a hinge h with a slide along v."""
    pairs = _pairs(answer, 3)
    slide = DualQuaternion([0, 0, 0, 0, 0, *v])
    space = _equations(one, h, slide, h * slide)
    for number, pair in enumerate(pairs, 1):
        _assert_null_line_in(space, pair, f"line {number}")
    _assert_all_there(
        pairs,
        {
            "t = √−1": lambda x: (1j + h) * x,
            "t = −√−1": lambda x: (1j - h) * x,
            "s = 0": lambda x: x.primal,
        },
    )


def _assert_quadrilateral(answer, h1: DualQuaternion, h2: DualQuaternion) -> None:
    """Fail unless the answer holds the vertices of the null quadrilateral of a dyad, in their order round."""
    points = _points(answer, 4, "the quadrilateral")
    space = _equations(one, h1, h2, h1 * h2)
    for number, point in enumerate(points):
        _assert_null_line_in(space, (points[number - 1], point), f"the edge to vertex {number + 1}")
    for first, second in ((0, 2), (1, 3)):
        if is_null_line(points[first], points[second]):
            raise AssertionError(f"vertices {first + 1} and {second + 1} are opposite: no null line joins them")


def _assert_stray(answer, g1: DualQuaternion, g2: DualQuaternion) -> None:
    """Fail unless the answer is a point of the dyad's space, on the null cone and off the Study quadric."""
    point = _point(answer, "the point")
    if not _contains(_equations(one, g1, g2, g1 * g2), point):
        raise AssertionError("the point is not in the space of 1, g1, g2, g1 g2")
    if not is_zero(null_form(point, point), size(point.components[:4]) ** 2):
        raise AssertionError("the point is not on the null cone: p p̄ does not vanish")
    if is_zero(study_form(point, point), size(point.components) ** 2):
        raise AssertionError("the point is on the Study quadric, so it is on one of the four null lines")


def _assert_real_null_line(answer) -> None:
    """Fail unless the answer is a pair of real points that a null line joins."""
    pair = _points(answer, 2, "the real null line")
    if any(x.imag for point in pair for x in point.coeffs):
        raise AssertionError("the real null line: both points must be real")
    _assert_null_line(pair, "the real null line")


def _point(answer, what: str) -> DualQuaternion:
    """An answer as a point with complex floats for coordinates: exact ones of SymPy would take minutes to compare."""
    point = DualQuaternion(as_float(numbers(answer, (8,), what)).astype(complex))
    if not size(point.components):
        raise AssertionError(f"{what}: all coefficients vanish, which is no point of P⁷")
    return point


def _points(answer, count: int, what: str) -> list[DualQuaternion]:
    points = several(answer, count, what, "points")
    return [_point(point, what) for point in points]


def _pairs(answer, count: int) -> list[list[DualQuaternion]]:
    pairs = several(answer, count, "the null lines", "pairs of points")
    return [_points(pair, 2, f"line {number}") for number, pair in enumerate(pairs, 1)]


def _assert_null_line(pair: Sequence[DualQuaternion], what: str) -> None:
    x, y = pair
    if same_point(x, y):
        raise AssertionError(f"{what}: its two points are the same")
    if is_null_line(x, y):
        return
    conditions = {"x x̄": x.norm(), "y ȳ": y.norm(), "x ȳ + y x̄": x * y.conjugate() + y * x.conjugate()}
    failing = [
        name for name, value in conditions.items() if not np.all(is_zero(value.components, size(value.components)))
    ]
    raise AssertionError(f"{what} is no null line: {', '.join(failing)} should be 0")


def _assert_null_line_in(space: np.ndarray, pair: Sequence[DualQuaternion], what: str) -> None:
    _assert_null_line(pair, what)
    if not all(_contains(space, point) for point in pair):
        raise AssertionError(
            f"{what} is a null line, but it does not lie in the space; are the factors in their order?"
        )


def _contains(space: np.ndarray, point: DualQuaternion) -> bool:
    """Whether a space, which is given by linear equations, contains a point."""
    return bool(np.all(is_zero(space @ point.coeffs, size(space) * size(point.coeffs))))


def _equations(*points: DualQuaternion) -> np.ndarray:
    """Linear equations of the three-space that is spanned by four points."""
    return null_space(DualQuaternion.stack(points).coeffs).astype(float)


def _assert_all_there(pairs, lines: dict[str, Callable]) -> None:
    """Fail unless each of the named lines is one of the pairs; on a line its function vanishes."""
    for name, defect in lines.items():
        on_line = [all(_vanishes(defect(x), x) for x in pair) for pair in pairs]
        if not any(on_line):
            raise AssertionError(f"the line {name} is missing; is another there twice?")


def _vanishes(value: DualQuaternion, x: DualQuaternion) -> bool:
    return bool(np.all(is_zero(value.components, size(x.components))))


# ---- checks of functions, on the numbers of a student ----------------------------------------------------


def _half_turns(student: str) -> list[DualQuaternion]:
    return [DualQuaternion(row) for row in data(student)[:5]]


def check_forms(forms: Callable, student: str) -> None:
    """Fail unless a function gives both forms of a student's half-turns, of their products, and of symbols."""
    from sympy import symbols

    h1, h2, g1, _, h = _half_turns(student)
    pairs = [((2 - h1) * (1 - h2), g1 * h), (h1, h2), (h2, h2), tuple(DualQuaternion(symbols(f"{x}:8")) for x in "xy")]
    for x, y in pairs:
        _assert_forms(answer_of(forms, x, y, without=SHORTCUTS), x, y)


PLACES = {
    "the Study quadric": "the dual part of q q̄ must vanish",
    "the null cone": "the primal part of q q̄ must vanish, and it may for complex points with p ≠ 0",
    "E": "the whole primal part p must vanish, not p p̄ only",
}


def check_places(places: Callable, student: str) -> None:
    """Fail unless a function says where points are, real and complex ones."""
    from sympy import I

    h1, h2, *_ = _half_turns(student)
    points = [
        (h1, (True, False, False)),
        ((2 - h1) * (3 - h2), (True, False, False)),
        (h1 + h1 * DualQuaternion([0, 0, 0, 0, 1, 0, 0, 0]), (False, False, False)),
        (I * one - h1, (True, True, False)),
        (DualQuaternion([1, 0, I, 0, 1, 0, 0, 0]), (False, True, False)),
        (DualQuaternion([0, 0, 0, 0, 1, 0, 0, I]), (True, True, True)),
    ]
    for point, right in points:
        found = several(answer_of(places, point, without=SHORTCUTS), 3, f"[{point}]", "answers")
        for answer, expected, (place, why) in zip(found, right, PLACES.items(), strict=True):
            _assert_true_or_false(answer, expected, f"whether [{point}] is on {place}", why)


def check_null_line(null_line: Callable, student: str) -> None:
    """Fail unless a function tells null lines of a student's dyad from others."""
    from sympy import I

    h1, h2, *_ = _half_turns(student)
    third = "the third product x ȳ + y x̄ counts too"
    pairs = [
        ((I - h1, (I - h1) * h2), True, "t1 = √−1 of your dyad", "look at the conjugate, which leaves √−1 alone"),
        ((I + h2, h1 * (I + h2)), True, "t2 = −√−1 of your dyad", "look at the conjugate, which leaves √−1 alone"),
        ((2 - h1, (2 - h1) * h2), False, "t1 = 2 of your dyad", "x x̄ is not 0"),
        (((I - h1) * (I - h2), (I + h1) * (I + h2)), False, "a diagonal of your quadrilateral", third),
    ]
    _check_null_lines_told(null_line, pairs)


def check_null_line_products(null_line: Callable, student: str) -> None:
    """Fail unless a function needs all three products of Lemma 1, with both of their parts."""
    from sympy import I

    h1, *_ = _half_turns(student)
    null = 1 + I * h1  # a point of the null cone and of the Study quadric
    one_, eps_ = DualQuaternion([1, *[0] * 7]), DualQuaternion([0, 0, 0, 0, 1, 0, 0, 0])
    axis = DualQuaternion([*h1.coeffs[:4], 0, 0, 0, 0])
    pairs = [
        ((null, eps_), False, "x x̄ = y ȳ = 0, but x ȳ + y x̄ = 2ε", "the dual part of the third product counts"),
        ((null, 1 - I * h1), False, "x x̄ = y ȳ = 0, but x ȳ + y x̄ = 4", "the third product counts too"),
        ((1 + I * axis + eps_, eps_ * axis), False, "x x̄ = 2ε", "the dual part of x x̄ counts"),
        ((eps_ * axis, 1 + I * axis + eps_), False, "y ȳ = 2ε", "the dual part of y ȳ counts"),
        ((h1, eps_ * (2 + h1)), False, "x x̄ = 1", "x x̄ counts"),
        ((eps_ * (2 + h1), h1), False, "y ȳ = 1", "y ȳ counts"),
        ((null, null * (axis + 2 * one_)), True, "x and x y for a null x", "all three products vanish"),
        ((eps_ * (1 + h1), eps_ * h1), True, "two points of E", "all three products vanish"),
    ]
    _check_null_lines_told(null_line, pairs)


def _check_null_lines_told(null_line: Callable, pairs) -> None:
    for (x, y), right, what, why in pairs:
        _assert_true_or_false(answer_of(null_line, x, y, without=SHORTCUTS), right, what, why)


def check_pose_at(pose_at: Callable, student: str) -> None:
    """Fail unless a function gives poses of a student's dyads, complex ones too."""
    from sympy import I

    h1, h2, g1, g2, _ = _half_turns(student)
    for pair, t1, t2 in (((h1, h2), 2, -3), ((g1, g2), I, 5)):
        _assert_pose_at(answer_of(pose_at, *pair, t1, t2, without=SHORTCUTS), *pair, t1, t2)


def _check_dyads(function: Callable, check: Callable, student: str) -> None:
    h1, h2, g1, g2, _ = _half_turns(student)
    for pair in ((h1, h2), (g1, g2)):
        answer = answer_of(function, *pair, without=SHORTCUTS)
        check(answer, *pair)


def check_null_lines(null_lines: Callable, student: str) -> None:
    """Fail unless a function gives the four null lines of a student's dyads."""
    _check_dyads(null_lines, _assert_null_lines, student)


def check_quadrilateral(quadrilateral: Callable, student: str) -> None:
    """Fail unless a function gives the null quadrilaterals of a student's dyads."""
    _check_dyads(quadrilateral, _assert_quadrilateral, student)


def check_stray(stray, student: str) -> None:
    """Fail unless a point is in the space of g1 and g2, on the null cone and off the Study quadric."""
    _assert_stray(stray, *_half_turns(student)[2:4])


def check_real_pair(pair, student: str) -> None:
    """Fail unless a null line joins two real points."""
    _assert_real_null_line(pair)


def _cases(student: str) -> list:
    """Spaces of each kind that a student can have, not those that the student is to name."""
    h1, h2, *_ = _half_turns(student)
    found = [("skew axes", [one, h1, h2, h1 * h2])]
    for name in (f"{student}, to try", f"{student}, again"):
        four = spaces(name)
        found += [(kind, list(four[letter])) for letter, kind in _kinds(name).items()]
    return found


def check_inside_study_quadric(inside: Callable, student: str) -> None:
    """Fail unless a function says which spaces lie in the Study quadric."""
    for kind, points in _cases(student):
        right = kind in ("parallel axes", "intersecting axes")
        why = "" if right else "the four points are on it, but is b(x, y) = 0 for each two of them?"
        _assert_true_or_false(answer_of(inside, points, without=SHORTCUTS), right, f"a space of {kind}", why)


def check_meets_exceptional_space(meets: Callable, student: str) -> None:
    """Fail unless a function says which spaces have a point in E."""
    for kind, points in _cases(student):
        right = kind in ("parallel axes", "prismatic joint")
        why = "a sum of the four has no primal part" if right else "the four primal parts are independent"
        _assert_true_or_false(answer_of(meets, points, without=SHORTCUTS), right, f"a space of {kind}", why)


def check_kinds(found, student: str) -> None:
    """Fail unless a student's spaces are called what they are; what a wrong one is, is not told."""
    right = _kinds(student)
    given = found if type(found) is dict else {}
    if sorted(map(str, given.values())) != sorted(KINDS) or set(given) != set(right):
        raise AssertionError(f"expected a dictionary in which each of {', '.join(KINDS)} occurs once")
    wrong = [letter for letter in right if given[letter] != right[letter]]
    if wrong:
        raise AssertionError(f"{len(wrong)} of the four are wrong: let your two functions tell you")


def check_three_lines(three_lines: Callable, student: str) -> None:
    """Fail unless a function gives the three null lines of a hinge with a slide."""
    for name in (student, f"{student}, to try"):
        *_, hinge, vector = data(name)
        answer = answer_of(three_lines, DualQuaternion(hinge), vector, without=SHORTCUTS)
        _assert_three_lines(answer, DualQuaternion(hinge), vector)


# ---- what is withheld --------------------------------------------------------------------------------

SHORTCUTS = (
    null_form, study_form, is_null_line, recognise, meet, Dyad.__post_init__, TwoRSpace.contains,
    TwoRSpace.null_quadrilateral, Subspace.contains, Quadric.form, Quadric.gram, Quadric.contains, Quadric.restrict,
    _kinds, _cases,
)  # fmt: skip
"""Functions that are the answer to a task, or nearly so: refused while answers are marked."""


def __dir__() -> list[str]:
    return __all__


seal()
