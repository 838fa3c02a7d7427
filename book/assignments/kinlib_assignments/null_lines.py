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
from kinlib_assignments.checks import assert_equal, numbers
from kinlib_assignments.lot import PYTHAGOREAN, Lot

__all__ = [
    "KINDS", "SHORTCUTS", "Data", "assert_answers", "assert_forms", "assert_null_lines", "assert_pose_at",
    "assert_quadrilateral", "assert_real_null_line", "assert_stray", "assert_three_lines", "data", "kinds", "spaces",
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


def kinds(student: str) -> dict[str, str]:
    """Which of the spaces A, B, C, D belongs to which two joints.

    Examples
    --------
    >>> sorted(kinds("ada").values()) == sorted(KINDS)
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
    return {name: DualQuaternion(_mixed(lot, _joints(lot, kind))) for name, kind in kinds(student).items()}


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


def assert_answers(answer, expected: Sequence[bool] | bool, what: str) -> None:
    """Fail unless each of the answers, or the only one, is the expected True or False.

    Examples
    --------
    >>> assert_answers((True, False), (True, True), "a pose")
    Traceback (most recent call last):
        ...
    AssertionError: a pose: expected (True, True), got (True, False)
    """
    expected = expected if isinstance(expected, bool) else tuple(expected)
    try:
        given = answer if np.ndim(answer) else [answer]
        truths = tuple(bool(x) for x in given if x in (True, False))
    except TypeError as error:
        raise AssertionError(f"{what}: expected True or False, got {answer!r}") from error
    truths = truths[0] if isinstance(expected, bool) and len(truths) == 1 else truths
    if truths != expected:
        raise AssertionError(f"{what}: expected {expected}, got {answer if truths == () else truths}")


def assert_forms(answer, x: DualQuaternion, y: DualQuaternion) -> None:
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


def assert_pose_at(answer, h1: DualQuaternion, h2: DualQuaternion, t1, t2) -> None:
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


def assert_null_lines(answer, h1: DualQuaternion, h2: DualQuaternion) -> None:
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


def assert_three_lines(answer, h: DualQuaternion, v) -> None:
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


def assert_quadrilateral(answer, h1: DualQuaternion, h2: DualQuaternion) -> None:
    """Fail unless the answer holds the vertices of the null quadrilateral of a dyad, in their order round."""
    points = _points(answer, 4, "the quadrilateral")
    space = _equations(one, h1, h2, h1 * h2)
    for number, point in enumerate(points):
        _assert_null_line_in(space, (points[number - 1], point), f"the edge to vertex {number + 1}")
    for first, second in ((0, 2), (1, 3)):
        if is_null_line(points[first], points[second]):
            raise AssertionError(f"vertices {first + 1} and {second + 1} are opposite: no null line joins them")


def assert_stray(answer, g1: DualQuaternion, g2: DualQuaternion) -> None:
    """Fail unless the answer is a point of the dyad's space, on the null cone and off the Study quadric."""
    point = _point(answer, "the point")
    if not _contains(_equations(one, g1, g2, g1 * g2), point):
        raise AssertionError("the point is not in the space of 1, g1, g2, g1 g2")
    if not is_zero(null_form(point, point), size(point.components[:4]) ** 2):
        raise AssertionError("the point is not on the null cone: p p̄ does not vanish")
    if is_zero(study_form(point, point), size(point.components) ** 2):
        raise AssertionError("the point is on the Study quadric, so it is on one of the four null lines")


def assert_real_null_line(answer) -> None:
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
    if answer is None:
        raise AssertionError(f"{what}: nothing was returned; is there a `return`?")
    points = list(answer)
    if len(points) != count:
        raise AssertionError(f"{what}: expected {count} points, got {len(points)}")
    return [_point(point, what) for point in points]


def _pairs(answer, count: int) -> list[list[DualQuaternion]]:
    if answer is None:
        raise AssertionError("the null lines: nothing was returned; is there a `return`?")
    pairs = list(answer)
    if len(pairs) != count:
        raise AssertionError(f"the null lines: expected {count} pairs of points, got {len(pairs)}")
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


# ---- what is withheld --------------------------------------------------------------------------------

SHORTCUTS = (
    null_form, study_form, is_null_line, recognise, meet, Dyad.__post_init__, TwoRSpace.contains,
    TwoRSpace.null_quadrilateral, Subspace.contains, Quadric.form, Quadric.gram, Quadric.contains, Quadric.restrict,
)  # fmt: skip
"""Functions that are the answer to a task, or nearly so: refused while answers are marked."""
