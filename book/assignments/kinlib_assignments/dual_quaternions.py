"""The assignment on the algebra: each student has two dual quaternions with whole coefficients, and some poses."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

from kinlib import DualQuaternion, act
from kinlib_assignments.checks import assert_equal, assert_refuses, numbers, several
from kinlib_assignments.lot import Lot
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of

__all__ = [
    "Data", "check_conjugate", "check_counterexample", "check_d0", "check_exact_inverse", "check_missing_inverse",
    "check_moved", "check_norm", "check_norm_law", "check_product", "check_product_for_all", "check_quaternion_product",
    "check_reversal_law", "data",
]  # fmt: skip

ALGEBRA = (
    DualQuaternion.__init__, DualQuaternion.__mul__, DualQuaternion.conjugate, DualQuaternion.eps_conjugate,
    DualQuaternion.norm, DualQuaternion.inverse, act,
)  # fmt: skip
"""What is withheld while an answer works: all answers calculate with plain lists."""


class Data(NamedTuple):
    """Two dual quaternions, as tuples of eight whole numbers."""

    q: tuple[int, ...]
    r: tuple[int, ...]


def data(student: str) -> Data:
    """Two dual quaternions that don't commute; no coefficient is zero, so that no slip goes unseen.

    Examples
    --------
    >>> data("ada").q
    (4, 4, 5, -1, -3, -2, 1, -1)
    """
    lot = Lot("dual_quaternions", student)
    return lot.until(lambda: Data(_coefficients(lot), _coefficients(lot)), _is_telling)


def _coefficients(lot: Lot) -> tuple[int, ...]:
    return tuple(lot.choice((-1, 1)) * lot.whole(1, 5) for _ in range(8))


def _is_telling(found: Data) -> bool:
    """Whether what slips give is always something else: of the products, the norms, and the point on the quadric."""
    q, r = map(DualQuaternion, found)
    products = [q * r, *_wrong_products(q, r).values()]
    different = all(a != b for n, a in enumerate(products) for b in products[:n])
    return different and _d0(found.q).denominator > 1 and all(map(_has_telling_norm, (q, r)))


def _has_telling_norm(q: DualQuaternion) -> bool:
    right, *wrong = ((a, b) for a, b in (_norm(q), *_wrong_norms(q).values()))
    return right[1] != 0 and right not in wrong


def _d0(q) -> Fraction:
    """The number in place of d0 with which a dual quaternion lies on the Study quadric."""
    p0, p1, p2, p3, _, d1, d2, d3 = q
    return -Fraction(p1 * d1 + p2 * d2 + p3 * d3, p0)


# ---- quaternions and their products ----------------------------------------------------------------------


def _quaternion(row) -> DualQuaternion:
    return DualQuaternion([*row, 0, 0, 0, 0])


def check_quaternion_product(product: Callable, student: str) -> None:
    """Fail unless a function multiplies quaternions, the units and those of a student."""
    q, r = data(student)
    units = ((0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
    for a, b in (*((x, y) for x in units for y in units), (q[:4], r[:4]), (q[4:], r[4:])):
        answer = answer_of(product, list(a), list(b), without=ALGEBRA)
        x, y = _quaternion(a), _quaternion(b)
        right, swapped = (value.coeffs[:4] for value in (x * y, y * x))
        outer = a[0] * b[0] + sum(s * t for s, t in zip(a[1:], b[1:], strict=True))
        slips = {
            "the factors are in the wrong order: i j = k, but j i = −k": swapped,
            "i² = j² = k² = −1: the squares of the units have the wrong sign": [outer, *right[1:]],
            "products of different units are missing: i j = k": [right[0], *((right + swapped) / 2)[1:]],
            "that multiplies number by number; each of the one meets each of the other": [
                s * t for s, t in zip(a, b, strict=True)
            ],
        }
        assert_equal(answer, right, f"the product of {a} and {b}", slips)


def _wrong_products(q: DualQuaternion, r: DualQuaternion) -> dict[str, DualQuaternion]:
    """What slips make of the product of two dual quaternions."""
    first, second = (q.primal * r.dual).coeffs[:4], (q.dual * r.primal).coeffs[:4]
    primal, turned = (q.primal * r.primal).coeffs[:4], (r.primal * q.dual).coeffs[:4]
    return {
        "the factors are in the wrong order": r * q,
        "the dual part has the wrong sign": (q * r).eps_conjugate(),
        "the dual part lacks one of its two products, d of the first with p of the second is there": q * r.primal,
        "the dual part lacks one of its two products, p of the first with d of the second is there": q.primal * r,
        "the two products in the dual part must be added": DualQuaternion([*primal, *(second - first)]),
        "the two products in the dual part must be added, not subtracted": DualQuaternion([*primal, *(first - second)]),
        "the order counts in the dual part too: d of the first stands left of p of the second": DualQuaternion(
            [*primal, *(first + turned)]
        ),
        "ε² is 0, not 1": q * r + q.dual * r.dual,
        "ε² is 0, not −1": q * r - q.dual * r.dual,
        "the dual part is not the product of the dual parts: ε² = 0": DualQuaternion(
            [*primal, *(q.dual * r.dual).coeffs[:4]]
        ),
    }


def _assert_product(product: Callable, q, r) -> None:
    answer = answer_of(product, list(q), list(r), without=ALGEBRA)
    q, r = DualQuaternion(q), DualQuaternion(r)
    assert_equal(answer, q * r, "the product", _wrong_products(q, r))


def check_product(product: Callable, student: str) -> None:
    """Fail unless a function multiplies a student's dual quaternions; say which slip it looks like.

    Examples
    --------
    >>> check_product(lambda q, r: (DualQuaternion(r) * DualQuaternion(q)).coeffs, "ada")
    Traceback (most recent call last):
        ...
    AssertionError: DualQuaternion.__init__ of kinlib is the answer itself: write your own
    """
    _assert_product(product, *data(student))


def check_product_for_all(product: Callable, student: str) -> None:
    """Fail unless a function multiplies in either order, by 1, and symbols: that is all numbers at once."""
    q, r = data(student)
    for first, second in ((r, q), ((1, 0, 0, 0, 0, 0, 0, 0), q), (_symbols("q"), _symbols("r"))):
        _assert_product(product, first, second)


def _symbols(letter: str, **options):
    from sympy import symbols

    return symbols(f"{letter}:8", **options)


# ---- conjugate and norm ----------------------------------------------------------------------------------


def check_conjugate(conjugate: Callable, student: str) -> None:
    """Fail unless a function conjugates a student's dual quaternions; say which slip it looks like."""
    for row in data(student):
        answer = answer_of(conjugate, list(row), without=ALGEBRA)
        q = DualQuaternion(row)
        right, p, d = q.conjugate(), row[:4], row[4:]
        slips = {
            "the signs of i, j, k in the dual part change too": [*right.coeffs[:4], *d],
            "the sign of ε stays: only those of i, j, k change": right.eps_conjugate(),
            "that is the conjugate in ε; it is i, j, k that change their signs": q.eps_conjugate(),
            "the signs of i, j, k in the primal part change too": [*p, *right.coeffs[4:]],
            "d0 keeps its sign: it belongs to ε, not to i, j, k": [*right.coeffs[:4], *(-x for x in d)],
            "the first number keeps its sign": -right,
            "all signs have changed: the first number of each part keeps its own": [-x for x in row],
        }
        assert_equal(answer, right, "the conjugate", slips)


def _norm(q: DualQuaternion) -> tuple:
    return tuple(q.norm().coeffs[[0, 4]])


def _wrong_norms(q: DualQuaternion) -> dict[str, tuple]:
    """What slips make of the two coefficients of q q̄."""
    a, b = _norm(q)
    return {
        "b is twice as large: p d̄ and d p̄ both count": (a, Fraction(b) / 2),
        "b is twice too large: p d̄ + d p̄ is 2 p·d": (a, 2 * b),
        "b has the wrong sign": (a, -b),
        "that is q², the conjugate is missing": tuple((q * q).coeffs[[0, 4]]),
        "the dual part d d̄ does not count, since ε² = 0": (a + _norm(DualQuaternion(q.dual))[0], b),
        "the numbers are exchanged: a comes first": (b, a),
        "that is the square root: the norm is q q̄": (float(a) ** 0.5, b),
        "the dual number has a second part: 2 p·d": (a, 0),
    }


def check_norm(norm: Callable, student: str) -> None:
    """Fail unless a function gives a and b of q q̄ = a + εb for a student's q and r; say which slip it looks like."""
    for row in data(student):
        answer = answer_of(norm, list(row), without=ALGEBRA)
        q = DualQuaternion(row)
        assert_equal(answer, _norm(q), "the norm", _wrong_norms(q))


def check_d0(d0, student: str) -> None:
    """Fail unless the student's q lies on the Study quadric with the number d0; the right one is not told."""
    q = data(student).q
    right = _d0(q)
    a, b = _norm(DualQuaternion(q))
    slips = {
        "0 would be right only where p1 d1 + p2 d2 + p3 d3 vanishes (was it rounded? divide by Fraction(…, …))": 0,
        "the sign is wrong: p0 d0 + p1 d1 + p2 d2 + p3 d3 must vanish": -right,
        "divide by p0: d0 is multiplied by it": right * q[0],
        "that is rounded to a whole number: divide by Fraction(…, …)": right.__floor__(),
        "half of it is enough, or twice as much": right / 2,
        "b holds your own d0 too: leave its product out": -Fraction(b, 2 * q[0]),
        "it is divided by a, not by p0": right * q[0] / a,
    }
    assert_equal(d0, right, "d0", slips, exact=True, secret=True)


# ---- laws ------------------------------------------------------------------------------------------------


def _assert_vanishes(defect: Callable, count: int, why: str) -> None:
    """Fail unless a defect is zero for all numbers, but not so where a b is not b a."""
    from sympy import expand

    found = several(answer_of(defect, _symbols("q"), _symbols("r"), without=ALGEBRA), count, "the defect")
    left = [expand(x) for x in numbers(found, (count,), "the defect").tolist()]
    if any(x != 0 for x in left):
        raise AssertionError(f"the defect is not 0, but {', '.join(map(str, left))[:200]}: {why}")
    strange = answer_of(defect, *(_symbols(x, commutative=False) for x in "qr"), without=ALGEBRA)
    if all(expand(x) == 0 for x in strange):
        raise AssertionError("the defect is 0 even for numbers with a b ≠ b a, so it does not come from your product")


def check_reversal_law(defect: Callable, student: str) -> None:
    """Fail unless a defect shows, by symbols, that conjugation reverses products.

    For coefficients that don't commute it is no law, so a defect that is 0 for these as well was not computed.
    """
    _assert_vanishes(defect, 8, "is r̄ q̄ in its order, and is it the product that is conjugated?")


def check_norm_law(defect: Callable, student: str) -> None:
    """Fail unless a defect shows, by symbols, that the norm is multiplicative."""
    _assert_vanishes(defect, 2, "multiply the norms as dual numbers: (c + εd)(e + εf) = ce + ε(cf + de)")


def check_counterexample(pair, student: str) -> None:
    """Fail unless the conjugate of the product of two dual quaternions is not that of the factors in the same order."""
    rows = several(pair, 2, "the counterexample", "dual quaternions")
    first, second = (DualQuaternion(numbers(row, (8,), "the counterexample")) for row in rows)
    if first * second == second * first:
        raise AssertionError("the counterexample: these two commute, so the order does not matter")


# ---- inverse and motion ----------------------------------------------------------------------------------


def check_exact_inverse(inverse: Callable, student: str) -> None:
    """Fail unless a function inverts a student's dual quaternions exactly; say which slip it looks like."""
    for row in data(student):
        answer = answer_of(inverse, list(row), without=ALGEBRA)
        q = DualQuaternion(row)
        a, b = map(Fraction, _norm(q))
        right, q_bar = q.inverse(), q.conjugate()
        slips = {
            "divide by the whole norm, its part εb too": q_bar / a,
            "the dual part is missing": right.primal,
            "the sign of εb/a² is wrong": q_bar * _dual_number(1 / a, b / a**2),
            "it is b/a², with the square of a": q_bar * _dual_number(1 / a, -b / a),
            "1/(a + εb) is not 1/a + ε/b": q_bar * _dual_number(1 / a, 1 / b),
            "it is the conjugate of q that is divided by the norm": q * _dual_number(1 / a, -b / a**2),
            "each number for itself is not inverted": [Fraction(1, x) for x in row],
            "it is divided by the norm of q, not by a root of it": q_bar / float(a) ** 0.5,
        }
        assert_equal(answer, right, "the inverse", slips, exact=True)


def _dual_number(a, b) -> DualQuaternion:
    return DualQuaternion([a, 0, 0, 0, b, 0, 0, 0])


def check_missing_inverse(inverse: Callable, student: str) -> None:
    """Fail unless a function refuses what has no inverse, and nothing else."""
    q, r = data(student)
    without = [0, 0, 0, 0, *q[4:]]
    assert_refuses(lambda: answer_of(inverse, without, without=ALGEBRA), ZeroDivisionError, f"the inverse of {without}")
    for row in (q, [*r[:4], 0, 0, 0, 0]):
        try:
            answer = answer_of(inverse, list(row), without=ALGEBRA)
        except ZeroDivisionError as error:
            raise AssertionError(f"the inverse of {row}: there is one, since a ≠ 0") from error
        numbers(answer, (8,), f"the inverse of {row}")


class Move(NamedTuple):
    """A pose as eight whole numbers, and a point."""

    pose: tuple[int, ...]
    point: tuple[int, ...]


def _move(lot: Lot) -> Move:
    return Move(tuple(int(x) for x in lot.pose().coeffs), tuple(lot.wholes(3, 5)))


def _images(move: Move) -> dict[str, DualQuaternion]:
    """Where slips carry a point, and first of all where it goes."""
    q, x = DualQuaternion(move.pose), move.point
    right, turned, a = act(q, x), act(q.primal, x), _norm(q)[0]
    point = _dual_vector(x)
    return {
        "": right,
        "the sign of ε in the last factor is wrong: the point is turned, but not shifted": turned,
        "that is where the pose with the other sign of ε carries it": 2 * turned - right,
        "the last factor is not conjugated": (q * point * q.eps_conjugate()).coeffs[5:] / Fraction(a),
        "it is not divided by p p̄": right * a,
        "it is divided by the root of p p̄ only": right * float(a) ** 0.5,
        "that is the way back: the conjugate comes last": act(q.conjugate(), x),
        "that is a half of the motion: the last factor is missing": (q * point).coeffs[5:],
        "that is 2x too far: the point is 1 + εx": right + (right - turned),
    }


def _dual_vector(x) -> DualQuaternion:
    return DualQuaternion([1, 0, 0, 0, 0, *x])


def _shows_slips(move: Move) -> bool:
    values = [tuple(float(x) for x in value) for value in _images(move).values()]
    return len({tuple(round(x, 6) for x in value) for value in values}) == len(values)


def check_moved(moved: Callable, student: str) -> None:
    """Fail unless a function carries a point by a student's pose, and by one that shifts only; say how it looks."""
    lot = Lot("dual_quaternions, moved", student)
    for _ in range(2):
        move = lot.until(lambda: _move(lot), _shows_slips)
        answer = answer_of(moved, list(move.pose), list(move.point), without=ALGEBRA)
        right, *wrong = _images(move).items()
        assert_equal(answer, right[1], f"the point {move.point} moved by {move.pose}", dict(wrong))


def __dir__() -> list[str]:
    return __all__


seal()
