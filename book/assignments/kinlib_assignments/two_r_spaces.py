"""The assignment on Theorem 1: each student has seven three-spaces and finds out which are 2R spaces."""

from __future__ import annotations

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
from kinlib_assignments.checks import assert_equal, numbers
from kinlib_assignments.lot import Lot

__all__ = [
    "SHORTCUTS", "VERDICTS", "Space", "answers", "assert_axes", "assert_half_turns", "assert_kappa",
    "assert_proportions", "assert_verdicts", "data", "matrices",
]  # fmt: skip

VERDICTS = ("2R space", "misses the identity", "lies on S", "meets E", "no kappa", "kappa is zero")
"""What can be said of a three-space; the first condition that fails, in this order."""

SHORTCUTS = (
    recognise, Dyad.space, join, meet, Subspace.contains, Subspace.equations,
    Quadric.form, Quadric.gram, Quadric.restrict, Quadric.rank, Quadric.contains, Quadric.signature,
)  # fmt: skip
"""What is withheld while the answers are marked."""


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
    return [space.points for space in answers(student)]


def answers(student: str) -> list[Space]:
    """The spaces of `data`, with what is to be found out about them.

    Examples
    --------
    >>> sorted({space.verdict for space in answers("ada")}) == sorted(VERDICTS)
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


def matrices(points) -> tuple:
    """The matrices of the Study form and of the null form on a basis, as SymPy matrices.

    Examples
    --------
    >>> S, N = matrices([one, eps])
    >>> S.tolist(), N.tolist()
    ([[0, 1], [1, 0]], [[1, 0], [0, 0]])
    """
    from sympy import Matrix

    return tuple(Matrix([[form(x, y) for y in points] for x in points]) for form in (study_form, null_form))


def assert_kappa(answer, A) -> None:
    """Fail unless the answer is the κ of a SymPy matrix with A² − ½ tr(A) A + κ = 0; say which slip it looks like.

    Examples
    --------
    >>> from sympy import diag
    >>> assert_kappa(-2, diag(1, 1, 2, 2))
    Traceback (most recent call last):
        ...
    AssertionError: κ: the sign is wrong
    """
    if answer is None:
        raise AssertionError("κ: None was returned, but there is a κ for this A")
    entry, square, trace = A[0, 0], (A**2)[0, 0], A.trace()
    right = trace * entry / 2 - square
    slips = {
        "the sign is wrong": -right,
        "half the trace is needed, not all of it": trace * entry - square,
        "half the trace is needed, not a quarter of it": trace * entry / 4 - square,
    }
    assert_equal(answer, right, "κ", slips)


def assert_proportions(answer, axes) -> None:
    """Fail unless the answer is a² and cot²α for the distance a and the angle α of the axes of two half-turns.

    Examples
    --------
    >>> assert_proportions((1, 1), (i, j - eps * i))
    Traceback (most recent call last):
        ...
    AssertionError: a² and cot²α: expected (1, 0), got (1, 1)
    """
    h1, h2 = axes
    n1, n2, c_squared = null_form(h1, h1), null_form(h2, h2), null_form(h1, h2) ** 2
    area = n1 * n2 - c_squared
    a, cot = divide(study_form(h1, h2) ** 2, area), divide(c_squared, area)
    slips = {
        "there are four eigenvalues, each of them twice: look at the trace again": (a, 4 * cot),
        "the second number is cos²α": (a, divide(c_squared, n1 * n2)),
        "a² is positive": (-a, cot),
        "a² is positive, and so is cot²α": (-a, -cot),
    }
    if c_squared:
        slips["the second number is the square of the tangent, not of the cotangent"] = (a, 1 / cot)
    assert_equal(answer, (a, cot), "a² and cot²α", slips)


HINTS = {
    "2R space": "[1] is in it, it misses E, and A satisfies its equation with κ ≠ 0",
    "misses the identity": "[1] is not in it, whatever the two forms say",
    "lies on S": "the Study form vanishes on it, the two axes would be coplanar",
    "meets E": "the null form is singular on it, one of the joints would slide",
    "no kappa": "A² − ½ tr(A) A is no multiple of the unit matrix, there is no null quadrilateral in it",
    "kappa is zero": "A² = ½ tr(A) A, the Study quadric cuts it in a singular quadric",
}


def assert_verdicts(verdicts, spaces: list[Space]) -> None:
    """Fail unless each space has got its verdict; say for which one it is wrong, and why.

    Examples
    --------
    >>> assert_verdicts(["meets E"], [Space("lies on S", [one, i, j, k], None)])
    Traceback (most recent call last):
        ...
    AssertionError: space 0 is not of the kind 'meets E': the Study form vanishes on it, the two axes would be coplanar
    """
    verdicts = [] if verdicts is None else list(verdicts)
    assert len(verdicts) == len(spaces), f"expected {len(spaces)} verdicts, one for each space, got {len(verdicts)}"
    for number, (verdict, space) in enumerate(zip(verdicts, spaces, strict=True)):
        if verdict not in VERDICTS:
            raise AssertionError(f"space {number}: expected one of {', '.join(VERDICTS)}, got {verdict!r}")
        if verdict != space.verdict:
            raise AssertionError(f"space {number} is not of the kind {verdict!r}: {HINTS[space.verdict]}")


def assert_half_turns(answer, points) -> None:
    """Fail unless the answer spans the line of all l + εm in a space, up to 1e-7 of its size for floats.

    Examples
    --------
    >>> assert_half_turns((i, k), [one, i, j - eps * i, k + eps])
    Traceback (most recent call last):
        ...
    AssertionError: the second point: it is not in the space
    """
    if answer is None or len(answer) != 2:
        raise AssertionError("the line of half-turns: expected two points of it")
    found = []
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


def assert_axes(answer, axes, *, ordered: bool) -> None:
    """Fail unless the answer is the pair of half-turns h1, h2, each up to a factor.

    Parameters
    ----------
    answer : sequence of two DualQuaternions
    axes : tuple of two DualQuaternions
        The right ones.
    ordered : bool
        Whether their order counts.

    Examples
    --------
    >>> assert_axes((j, -i), (i, j), ordered=False)
    >>> assert_axes((j, -i), (i, j), ordered=True)
    Traceback (most recent call last):
        ...
    AssertionError: the axes: h1 and h2 are exchanged; it is h1 h2 that is in the space, not h2 h1
    """
    if answer is None or len(answer) != 2:
        raise AssertionError("the axes: expected two half-turns h1, h2")
    found = [DualQuaternion(numbers(h, (8,), name)) for h, name in zip(answer, ("h1", "h2"), strict=True)]
    straight, crossed = (
        all(_same_line(h, axis) for h, axis in zip(found, pair, strict=True)) for pair in (axes, axes[::-1])
    )
    if crossed and ordered:
        raise AssertionError("the axes: h1 and h2 are exchanged; it is h1 h2 that is in the space, not h2 h1")
    if not straight and not crossed:
        names = ", ".join(f"[{h}]" for h in found)
        raise AssertionError(f"the axes: {names} are not the two points of the line that lie on the Study quadric")
