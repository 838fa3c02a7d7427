"""The assignment on Theorem 1: each student has seven three-spaces and finds out which are 2R spaces."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from kinlib import (
    DualQuaternion,
    Dyad,
    Quadric,
    Subspace,
    as_float,
    divide,
    eps,
    is_exact,
    is_zero,
    join,
    meet,
    null_form,
    one,
    recognise,
    same_point,
    size,
    study_form,
)
from kinlib_assignments.checks import assert_equal, numbers, several, truth
from kinlib_assignments.lot import Lot
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of

__all__ = [
    "VERDICTS", "check_axes", "check_contains", "check_half_turn_line", "check_kappa", "check_meets_exceptional",
    "check_missing_kappa", "check_null_matrix", "check_order_of_axes", "check_proportions", "check_space_matrix",
    "check_study_matrix", "check_verdict", "check_verdicts", "data",
]  # fmt: skip

VERDICTS = ("2R space", "misses the identity", "lies on S", "meets E", "no kappa", "kappa is zero")
"""What can be said of a three-space; the first condition that fails, in this order."""


class Space(NamedTuple):
    """A three-space: what is to be said of it, four points that span it, and h1, h2 if it is a 2R space."""

    verdict: str
    points: list[DualQuaternion]
    axes: tuple[DualQuaternion, DualQuaternion] | None


def data(student: str) -> list[list[DualQuaternion]]:
    """Seven three-spaces, each as four dual quaternions with whole coefficients.

    Every verdict of `VERDICTS` belongs to at least one of them; their order is the student's own.  The points are
    mixed by a whole matrix with determinant ±1, so that no one of them shows what the space is.

    Examples
    --------
    >>> spaces = data("ada")
    >>> len(spaces), spaces[0][0]
    (7, -1 + 4 i + 2 j + 2 k + 18 ε + 14 εi - 17 εj + 6 εk)
    """
    return [space.points for space in _answers(student)]


def _answers(student: str) -> list[Space]:
    """The spaces of `data`, with what is to be found out about them.

    Examples
    --------
    >>> sorted({space.verdict for space in _answers("ada")}) == sorted(VERDICTS)
    True
    """
    lot = Lot("two_r_spaces", student)
    verdicts = lot.shuffled([*VERDICTS, lot.choice(VERDICTS)])
    return [_space(lot, verdict) for verdict in verdicts]


def _space(lot: Lot, verdict: str) -> Space:
    return lot.until(lambda: _drawn(lot, verdict), _is_fair)


def _drawn(lot: Lot, verdict: str) -> Space:
    lines = lot.until(lambda: (_line(lot), _line(lot)), _are_skew)
    h1, h2 = (DualQuaternion([0, *direction, 0, *moment]) for direction, moment in lines)
    points = _mixed(lot, _MAKERS[verdict](lot, h1, h2))
    return Space(verdict, points, (h1, h2) if verdict == VERDICTS[0] else None)


def _mixed(lot: Lot, points: list[DualQuaternion]) -> list[DualQuaternion]:
    """The points in another order, each mixed with one other at least; the matrix that does it has determinant ±1."""
    rows = lot.shuffled([x.components.tolist() for x in points])
    for target, source in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2)):
        sign = lot.choice((-1, 1))
        rows[target] = [x + sign * y for x, y in zip(rows[target], rows[source], strict=True)]
    return [DualQuaternion(row) for row in lot.shuffled(rows)]


def _is_fair(space: Space) -> bool:
    """Whether no point is the identity or without a primal part, and no number is large."""
    rows = [x.components.tolist() for x in space.points]
    return all(any(row[1:]) and any(row[:4]) and max(map(abs, row)) < 60 for row in rows)


def _line(lot: Lot) -> tuple:
    """Direction and moment of a line with a whole direction through a whole point."""
    direction = lot.until(lambda: lot.wholes(3, 2), any)
    return direction, _moment(lot.wholes(3, 2), direction)


def _moment(point, direction) -> list[int]:
    (a, b, c), (l, m, n) = point, direction
    return [b * n - c * m, c * l - a * n, a * m - b * l]


def _through(point, direction) -> DualQuaternion:
    """The half-turn about the line through a point."""
    return DualQuaternion([0, *direction, 0, *_moment(point, direction)])


def _are_skew(lines) -> bool:
    """Whether two lines are skew, neither at right angles nor nearly parallel, and not far apart."""
    (l, m), (k, n) = lines
    c, moment = _dot(l, k), _dot(l, n) + _dot(m, k)
    area = _dot(l, l) * _dot(k, k) - c * c
    return moment != 0 and c != 0 and c * c <= 4 * area and moment * moment <= 16 * area


def _dot(x, y) -> int:
    return sum(a * b for a, b in zip(x, y, strict=True))


def _two_r(lot: Lot, h1, h2) -> list[DualQuaternion]:
    return [one, h1, h2, h1 * h2]


def _without_identity(lot: Lot, h1, h2) -> list[DualQuaternion]:
    """A 2R space, shifted: all the rest is as in a 2R space."""
    shift = one + eps * DualQuaternion([0, *lot.until(lambda: lot.wholes(3, 2), any), 0, 0, 0, 0])
    return [shift * x for x in _two_r(lot, h1, h2)]


def _on_the_study_quadric(lot: Lot, h1, h2) -> list[DualQuaternion]:
    """The space of two axes that meet."""
    point = lot.wholes(3, 2)
    return _two_r(lot, *(_through(point, h.coeffs[1:4]) for h in (h1, h2)))


def _meeting_e(lot: Lot, h1, h2) -> list[DualQuaternion]:
    """The space of a turning joint and a sliding one."""
    return _two_r(lot, h1, eps * h2)


def _without_kappa(lot: Lot, h1, h2) -> list[DualQuaternion]:
    """A 2R space, one of its points pushed out along E.

    Its quadric would be singular at b(h1, h2), and at twice that it would be the 2R space of the axes exchanged.
    """
    moment = study_form(h1, h2)
    step = lot.until(lambda: lot.choice((-1, 1)) * lot.whole(2, 5), lambda s: s not in (moment, 2 * moment))
    return [one, h1, h2, h1 * h2 + step * eps]


def _with_vanishing_kappa(lot: Lot, h1, h2) -> list[DualQuaternion]:
    """Three axes at right angles in a point, two of them pushed out along E: the Study quadric cuts two planes."""
    l, k = (h.coeffs[1:4] for h in (h1, h2))
    normal = np.cross(l, k)
    point, push = lot.wholes(3, 2), 1 + lot.choice((-1, 1)) * lot.whole(1, 3) * eps
    first, second = _through(point, l), _through(point, normal // np.gcd.reduce(normal))
    return [one, first, second * push, first * second * push]


_MAKERS = dict(
    zip(
        VERDICTS,
        (_two_r, _without_identity, _on_the_study_quadric, _meeting_e, _without_kappa, _with_vanishing_kappa),
        strict=True,
    )
)


# ---- checks --------------------------------------------------------------------------------------------


def _matrices(points) -> tuple:
    """The matrices of the Study form and of the null form on a basis, as SymPy matrices."""
    from sympy import Matrix

    return tuple(Matrix([[form(x, y) for y in points] for x in points]) for form in (study_form, null_form))


def _two_r_spaces(student: str) -> list[Space]:
    """The first 2R space of a student, and another one."""
    found = [space for name in (student, f"{student}, to try") for space in _answers(name) if space.axes]
    return [found[0], found[-1]]


def check_study_matrix(study_matrix: Callable, student: str) -> None:
    """Fail unless a function gives the matrix of the Study form on a student's spaces; say which slip it looks like."""
    from sympy import Matrix

    for number, points in enumerate(data(student)):
        answer = answer_of(study_matrix, list(points), without=SHORTCUTS)
        right, null = _matrices(points)
        half = Matrix([[sum(x.coeffs[:4] * y.coeffs[4:]) for y in points] for x in points])
        slips = {
            "that is the null form": null,
            "a form is symmetric: d with r counts too": half,
            "a form is symmetric: p with e counts too": half.T,
            "each product counts once: it is twice as large": 2 * right,
            "that is x · y, number by number: p goes with e, and d with r": _whole(points),
        }
        assert_equal(answer, right, f"S of space {number}", slips)


def check_null_matrix(null_matrix: Callable, student: str) -> None:
    """Fail unless a function gives the matrix of the null form on a student's spaces; say which slip it looks like."""
    for number, points in enumerate(data(student)):
        answer = answer_of(null_matrix, list(points), without=SHORTCUTS)
        study, right = _matrices(points)
        slips = {
            "that is the Study form": study,
            "only the primal parts count": _whole(points),
            "it is twice as large": 2 * right,
        }
        assert_equal(answer, right, f"N of space {number}", slips)


def _whole(points):
    from sympy import Matrix

    return Matrix([[sum(x.coeffs * y.coeffs) for y in points] for x in points])


def check_contains(contains: Callable, student: str) -> None:
    """Fail unless a function says whether a student's spaces contain 1, a sum of their points, and a point beside."""
    for number, space in enumerate(_answers(student)):
        first, second, third, last = space.points
        inside = space.verdict != "misses the identity"
        beside = (
            "points have a dual part too, and it counts" if inside else "[1] is not in it: its dual part counts too"
        )
        cases = [
            (one, inside, "[1] is in it, though it is none of the four" if inside else beside),
            (first - 2 * third + last, True, "the sum of points of a space is in it"),
            (second + 3 * eps, False, "a point of it that is pushed out along E is not in it: dual parts count too"),
        ]
        for point, right, why in cases:
            what = f"whether space {number} contains [{point}]"
            if truth(answer_of(contains, list(space.points), point, without=SHORTCUTS), what) != right:
                raise AssertionError(f"{what}: {why}")


def check_meets_exceptional(meets: Callable, student: str) -> None:
    """Fail unless a function says which of a student's spaces meet E."""
    for number, space in enumerate(_answers(student)):
        what = f"whether space {number} meets E"
        right = space.verdict == "meets E"
        why = "a sum of its points has no primal part" if right else "the primal parts of the four are independent"
        if truth(answer_of(meets, list(space.points), without=SHORTCUTS), what) != right:
            raise AssertionError(f"{what}: {why}")


def check_space_matrix(space_matrix: Callable, student: str) -> None:
    """Fail unless a function gives N⁻¹ S on a student's spaces; say which slip it looks like."""
    for space in _answers(student):
        S, N = _matrices(space.points)
        if N.det() == 0:
            continue
        slips = {
            "that is S N⁻¹: the factors are in the wrong order": S * N.inv(),
            "that is N S: it is the inverse of N that is needed": N * S,
            "that is the transposed matrix": (N.inv() * S).T,
        }
        if S.det() != 0:
            slips["that is S⁻¹ N: it is N that is inverted"] = S.inv() * N
        assert_equal(answer_of(space_matrix, S, N, without=SHORTCUTS), N.inv() * S, "A", slips)


def check_kappa(kappa: Callable, student: str) -> None:
    """Fail unless a function gives the κ of a student's 2R spaces; say which slip it looks like.

    Examples
    --------
    >>> check_kappa(lambda A: A.trace() * A[0, 0] - (A**2)[0, 0], "ada")
    Traceback (most recent call last):
        ...
    AssertionError: κ: half the trace is needed, not all of it
    """
    for space in _two_r_spaces(student):
        S, N = _matrices(space.points)
        A = N.inv() * S
        answer = answer_of(kappa, A.copy(), without=SHORTCUTS)
        if answer is None:
            raise AssertionError("κ: None was returned, but there is a κ: A² is A A, and half the trace is needed")
        entry, square, trace = A[0, 0], (A**2)[0, 0], A.trace()
        right = trace * entry / 2 - square
        slips = {
            "the sign is wrong": -right,
            "half the trace is needed, not all of it": trace * entry - square,
            "half the trace is needed, not a quarter of it": trace * entry / 4 - square,
            "that is a number for each place: κ is one of them": trace * A / 2 - A**2,
            "the square of A is the matrix A A, not the squares of its entries": trace * entry / 2 - entry**2,
            "that is the determinant, κ²": right**2,
        }
        assert_equal(answer, right, "κ", slips)


def check_missing_kappa(kappa: Callable, student: str) -> None:
    """Fail unless a function gives None where there is no κ, also if the diagonal has one, and 0 where κ is 0."""
    from sympy import diag, zeros

    lot = Lot("two_r_spaces, kappa", student)
    x, y = lot.until(lambda: lot.wholes(2, 4), lambda pair: pair[0] != pair[1] and all(pair) and sum(pair))
    nilpotent = zeros(4)
    nilpotent[0, 1] = lot.whole(1, 4)
    for A, why in (
        (diag(x, x, x, y), "½ tr A is not the sum of its two eigenvalues"),
        (diag(x, x, y, y) + nilpotent, "look at all entries of A² − ½ tr(A) A, not at the diagonal only"),
    ):
        if answer_of(kappa, A.copy(), without=SHORTCUTS) is not None:
            raise AssertionError(f"there is no κ for A = {A.tolist()}, so None is right: {why}")
    for space in _answers(student):
        S, N = _matrices(space.points)
        if space.verdict == "no kappa" and answer_of(kappa, N.inv() * S, without=SHORTCUTS) is not None:
            raise AssertionError("there is no κ for this A, so None is right: look at all entries of A² − ½ tr(A) A")
        if space.verdict == "kappa is zero":
            answer = answer_of(kappa, N.inv() * S, without=SHORTCUTS)
            if answer is None:
                raise AssertionError("κ is 0 for this A, which is not the same as none: None was returned")
            assert_equal(answer, 0, "the κ of an A whose κ is 0")


def check_proportions(proportions: Callable, student: str) -> None:
    """Fail unless a function gives a² and cot²α of a student's 2R spaces; say which slip it looks like."""
    for space in _two_r_spaces(student):
        S, N = _matrices(space.points)
        _assert_proportions(answer_of(proportions, N.inv() * S, without=SHORTCUTS), space.axes)


def _assert_proportions(answer, axes) -> None:
    h1, h2 = axes
    n1, n2, c_squared = null_form(h1, h1), null_form(h2, h2), null_form(h1, h2) ** 2
    area = n1 * n2 - c_squared
    a, cot = divide(study_form(h1, h2) ** 2, area), divide(c_squared, area)
    slips = {
        "there are four eigenvalues, each of them twice: look at the trace again": (a, 4 * cot),
        "the trace is that of A, not a half of it or twice as much": (a, cot / 4),
        "the square of the trace is 16 times a² cot²α": (a, 16 * cot),
        "cot²α is divided by a²": (a, cot * a),
        "the second number is cos²α": (a, divide(c_squared, n1 * n2)),
        "the second number is the square of the tangent, not of the cotangent": (a, 1 / cot),
        "they are squares: a, not a², was given": (float(a) ** 0.5, cot),
        "they are squares: a and cot α were given": (float(a) ** 0.5, float(cot) ** 0.5),
        "a² is positive": (-a, cot),
        "a² is positive, and so is cot²α": (-a, -cot),
        "they are exchanged: a² comes first": (cot, a),
        "the first number is a² sin²α": (a / (1 + cot), cot),
    }
    assert_equal(answer, (a, cot), "a² and cot²α", slips)


REASONS = {
    "misses the identity": "[1] is in it",
    "lies on S": "the Study form does not vanish on it",
    "meets E": "the null form is not singular on it",
    "no kappa": "there is a κ for it",
    "kappa is zero": "κ is not 0",
}
"""Why a space is not of a kind."""


def check_verdict(verdict: Callable, student: str) -> None:
    """Fail unless a function says of spaces of every kind what they are, and, if not, why."""
    _assert_verdicts(
        [answer_of(verdict, list(space.points), without=SHORTCUTS) for space in _answers(f"{student}, to try")],
        _answers(f"{student}, to try"),
        tell=True,
    )


def check_verdicts(verdicts, student: str) -> None:
    """Fail unless each of the student's spaces has got its verdict; the right one is not told."""
    _assert_verdicts(verdicts, _answers(student), tell=False)


def _assert_verdicts(verdicts, spaces: list[Space], *, tell: bool) -> None:
    verdicts = several(verdicts, len(spaces), "the verdicts", "texts, one for each space")
    for number, (verdict, space) in enumerate(zip(verdicts, spaces, strict=True)):
        what = f"the space of {', '.join(map(str, space.points))}" if tell else f"space {number}"
        if type(verdict) is not str or verdict not in VERDICTS:
            raise AssertionError(f"{what}: expected one of {', '.join(VERDICTS)}, got {str(verdict)[:80]!r}")
        if verdict != space.verdict:
            raise AssertionError(f"{what} is not of the kind {verdict!r}: {_reason(verdict, space.verdict, tell=tell)}")


ORDER = (*VERDICTS[1:], VERDICTS[0])


def _reason(given: str, right: str, *, tell: bool) -> str:
    if ORDER.index(given) < ORDER.index(right):
        return REASONS[given]
    return f"it is {right!r}" if tell else "a condition that comes earlier in the table fails already"


def check_half_turn_line(half_turn_line: Callable, student: str) -> None:
    """Fail unless a function gives two points of the line of half-turns in a student's 2R spaces."""
    for space in _two_r_spaces(student):
        _assert_half_turns(answer_of(half_turn_line, list(space.points), without=SHORTCUTS), space.points)


def _assert_half_turns(answer, points) -> None:
    """Fail unless the answer spans the line of all l + εm in a space, up to 1e-7 of its size for floats."""
    found = []
    answer = several(answer, 2, "the line of half-turns", "points of it")
    for name, x in zip(("first", "second"), answer, strict=True):
        x = DualQuaternion(numbers(x, (8,), f"the {name} point"))
        found.append(x)
        scale = size(x.coeffs)
        if scale == 0:
            raise AssertionError(f"the {name} point: all coefficients vanish, which is no point of P⁷")
        if not np.all(is_zero(x.coeffs[[0, 4]], scale, 1e-7)):
            raise AssertionError(f"the {name} point: l + εm has no 1 and no ε in it, [{x}] has")
        if not _contains(points, x):
            raise AssertionError(f"the {name} point: it is not in the space")
    if same_point(*found):
        raise AssertionError("the line of half-turns: two different points are needed, these are one")


def _contains(points, x: DualQuaternion) -> bool:
    rows = np.array([point.coeffs for point in points])
    if is_exact(x.coeffs):
        return Subspace(rows).contains(x)
    rows, x = as_float(rows), as_float(x.coeffs)
    rest = x - np.linalg.lstsq(rows.T, x, rcond=None)[0] @ rows
    return bool(np.all(is_zero(rest, size(x), 1e-7)))


def _same_line(h: DualQuaternion, axis: DualQuaternion) -> bool:
    if is_exact(h.coeffs):
        return same_point(h, axis)
    return same_point(as_float(h.coeffs), as_float(axis.coeffs), rtol=1e-7, length=size(axis.coeffs))


def check_axes(axes: Callable, student: str) -> None:
    """Fail unless a function gives the half-turns about the axes of a student's 2R spaces, in any order."""
    _check_axes(axes, _two_r_spaces(student), ordered=False)


def check_order_of_axes(axes: Callable, student: str) -> None:
    """Fail unless a function gives them with h1 first; several spaces, so that chance does not do."""
    names = (student, *(f"{student}, order {n}" for n in range(5)))
    _check_axes(axes, [space for name in names for space in _answers(name) if space.axes], ordered=True)


def _check_axes(axes: Callable, spaces: list[Space], *, ordered: bool) -> None:
    for space in spaces:
        answer = answer_of(axes, list(space.points), without=SHORTCUTS)
        _assert_axes(answer, space.axes, ordered=ordered)


def _assert_axes(answer, axes, *, ordered: bool) -> None:
    """Fail unless the answer is the pair of half-turns h1, h2, each up to a factor."""
    answer = several(answer, 2, "the axes", "half-turns h1, h2")
    found = [DualQuaternion(numbers(h, (8,), name)) for h, name in zip(answer, ("h1", "h2"), strict=True)]
    straight, crossed = (
        all(_same_line(h, axis) for h, axis in zip(found, pair, strict=True)) for pair in (axes, axes[::-1])
    )
    if straight or (crossed and not ordered):
        return
    if crossed:
        raise AssertionError("the axes: h1 and h2 are exchanged; it is h1 h2 that is in the space, not h2 h1")
    if same_point(*(as_float(h.coeffs) for h in found)):
        raise AssertionError("the axes: both are the same point, but there are two roots")
    signs = [DualQuaternion([0, *h.coeffs[1:4], 0, *(-h.coeffs[5:])]) for h in found]
    if all(any(_same_line(h, axis) for axis in axes) for h in signs):
        raise AssertionError("the axes: the moments have the wrong sign")
    off = [f"[{h}]" for h in found if not any(_same_line(h, axis) for axis in axes)]
    raise AssertionError(f"the axes: not on the Study quadric, or not on the line of half-turns: {', '.join(off)}")


# ---- what is withheld ------------------------------------------------------------------------------------

SHORTCUTS = (
    recognise, Dyad.space, join, meet, study_form, null_form, Subspace.contains, Subspace.equations, Quadric.form,
    Quadric.gram, Quadric.restrict, Quadric.rank, Quadric.contains, Quadric.signature, _answers, _matrices, _reason,
    _contains,
)  # fmt: skip
"""What is withheld while an answer works."""


def __dir__() -> list[str]:
    return __all__


seal()
