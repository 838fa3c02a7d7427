"""The assignment on Theorem 2: each student has three poses and builds the Bennett linkage through them."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from kinlib import (
    DualQuaternion,
    Line,
    Linkage,
    MotionPolynomial,
    as_float,
    bennett_flip,
    bennett_linkage,
    common_perpendicular,
    conic_through,
    dyads_through_poses,
    factorizations,
    factorize,
    is_exact,
    is_zero,
    linear_factor,
    null_form,
    one,
    quadratic_factors,
    quadratic_of,
    same_point,
    size,
    study_eigenvalues,
    study_form,
)
from kinlib_assignments.checks import assert_equal, numbers
from kinlib_assignments.lot import Lot

__all__ = [
    "SHORTCUTS", "Data", "assert_at", "assert_factors", "assert_link", "assert_loop", "assert_on_quadric",
    "assert_passes", "assert_quadratics", "assert_quartic", "assert_ratio", "assert_right_factor", "data", "split",
]  # fmt: skip

SHORTCUTS = (
    bennett_linkage, dyads_through_poses, study_eigenvalues, conic_through, quadratic_factors, factorize,
    factorizations, bennett_flip, quadratic_of, linear_factor, MotionPolynomial.__init__,
    MotionPolynomial.from_coefficients.__func__, Linkage.from_chains.__func__, Linkage.denavit_hartenberg,
    Line.distance, Line.angle, common_perpendicular,
)  # fmt: skip
"""What is withheld while the answers are marked."""

RTOL = 1e-7


class Data(NamedTuple):
    """Two poses; with the identity they are the three poses of the linkage."""

    p1: DualQuaternion
    p2: DualQuaternion


def data(student: str) -> Data:
    """Two poses with whole coefficients; everything about the linkage through them and the identity is rational.

    They lie on a conic (t − h1)(t − h2) with whole h1, h2, at t = 0 and t = 1.

    Examples
    --------
    >>> data("ada").p1
    -6 + 12 i - 2 j - 4 k - 32 ε - 16 εi + 48 εj - 24 εk
    """
    lot = Lot("bennett", student)
    h1, h2 = map(DualQuaternion, lot.until(lambda: (_factor(lot), _factor(lot)), _is_good))
    return Data(*(_scaled(lot, pose) for pose in (h1 * h2, (1 - h1) * (1 - h2))))


def _factor(lot: Lot) -> list[int]:
    """The coefficients of a whole number and a half-turn about a line with whole direction through a whole point."""
    l, m, n = lot.until(lambda: lot.wholes(3, 2), any)
    a, b, c = lot.wholes(3, 2)
    return [lot.whole(-2, 2), l, m, n, 0, b * n - c * m, c * l - a * n, a * m - b * l]


def _scaled(lot: Lot, pose: DualQuaternion) -> DualQuaternion:
    """The same pose with other whole coefficients, so that the weights of the conic are not 1."""
    row = pose.components.tolist()
    divisor, factor = math.gcd(*row), lot.choice((-3, -2, 2, 3))
    return DualQuaternion([x // divisor * factor for x in row])


def _is_good(pair) -> bool:
    """Whether the linkage is well proportioned, the roots are apart, and no two poses are nearly conjugate."""
    return _are_skew(*pair) and _roots_are_apart(*pair) and _is_proportioned(*map(DualQuaternion, pair))


def _are_skew(h1, h2) -> bool:
    """Whether the axes make an angle of 30° at least, and do not meet."""
    return _dot(h1[1:4], h2[5:]) + _dot(h1[5:], h2[1:4]) != 0 and 4 * _sine_squared(h1[1:4], h2[1:4]) >= 1


def _roots_are_apart(h1, h2) -> bool:
    """Whether the quadratics t² − 2xt + x² + l·l of two factors x + l + εm differ enough."""
    return abs(h1[0] - h2[0]) >= 2 or abs(_dot(h1[1:4], h1[1:4]) - _dot(h2[1:4], h2[1:4])) >= 3


def _is_proportioned(h1: DualQuaternion, h2: DualQuaternion) -> bool:
    """Whether the links are from 1/2 to 4 long, the second angle is 30° at least, and the poses are apart."""
    v = (h1.conjugate() - h2).primal
    k2 = v.conjugate() * h1.primal * v  # the direction of the axis with which the loop closes
    if k2 == 0:
        return False
    l, k = h1 - h1.scalar_part, h2 - h2.scalar_part
    first, second = (_sine_squared(x.components[1:4].tolist(), k.components[1:4].tolist()) for x in (l, k2))
    ratio = Fraction(study_form(l, k) ** 2, null_form(l, l) * null_form(k, k)) / first**2
    lengths = ratio * first, ratio * second
    return 4 * min(lengths) >= 1 and max(lengths) <= 16 and 4 * second >= 1 and _poses_are_apart(h1, h2)


def _sine_squared(l, k) -> Fraction:
    """The square of the sine of the angle of two whole vectors."""
    return 1 - Fraction(_dot(l, k) ** 2, _dot(l, l) * _dot(k, k))


def _dot(x, y) -> int:
    return sum(a * b for a, b in zip(x, y, strict=True))


def _poses_are_apart(h1: DualQuaternion, h2: DualQuaternion) -> bool:
    """Whether the Study form of each two of the three poses is not small beside their primal parts."""
    p1, p2 = h1 * h2, (1 - h1) * (1 - h2)
    pairs = ((one, p1), (one, p2), (p1, p2))
    return all(25 * study_form(x, y) ** 2 >= null_form(x, x) * null_form(y, y) for x, y in pairs)


# ---- checks --------------------------------------------------------------------------------------------


def split(p1: DualQuaternion, p2: DualQuaternion) -> tuple[list[DualQuaternion], np.ndarray, list[tuple]]:
    """The conic of 1, p1, p2 as its coefficients, its two quadratics, and its two factorizations.

    The last factor of the first pair belongs to the second quadratic, that of the second pair to the first.

    Examples
    --------
    >>> C, quadratics, pairs = split(*data("ada"))
    >>> [h.scalar_part == -quadratics[n][1] / 2 for n, h in enumerate(pairs[0])]
    [True, True]
    """
    C = conic_through(one, p1, p2)
    return list(C.coefficients), quadratic_factors(C.norm_polynomial()), factorizations(C)


def _points(answer, count: int, what: str) -> list[DualQuaternion]:
    """An answer that must be a number of dual quaternions."""
    if answer is None:
        raise AssertionError(f"{what}: nothing was returned; is there a `return`?")
    answer = list(answer)
    if len(answer) != count:
        raise AssertionError(f"{what}: expected {count} dual quaternions, got {len(answer)}")
    return [DualQuaternion(numbers(x, (8,), what)) for x in answer]


def _agree(x: DualQuaternion, y: DualQuaternion) -> bool:
    """Whether two dual quaternions are equal, up to rounding if they are floats."""
    return all(
        np.all(is_zero((x - y).coeffs[half], max(size(x.coeffs[half]), size(y.coeffs[half])), RTOL))
        for half in (slice(0, 4), slice(4, 8))
    )


def _same_pose(x: DualQuaternion, y: DualQuaternion) -> bool:
    if is_exact(x.coeffs) and is_exact(y.coeffs):
        return same_point(x, y)
    length = max(1.0, size(y.coeffs[4:]) / size(y.coeffs[:4]))
    return same_point(as_float(x.coeffs), as_float(y.coeffs), rtol=RTOL, length=length)


def assert_passes(C, p1: DualQuaternion, p2: DualQuaternion) -> None:
    """Fail unless the three coefficients are those of a monic curve that passes p1 at t = 0 and p2 at t = 1.

    Examples
    --------
    >>> assert_passes([one, -i - j, k], k, 1 - i - j + k)
    >>> assert_passes([one, -i - j, k], 1 - i - j + k, k)
    Traceback (most recent call last):
        ...
    AssertionError: the conic: p1 and p2 are exchanged
    """
    c2, c1, c0 = _points(C, 3, "the conic")
    if not _agree(c2, one):
        raise AssertionError(f"the conic: the leading coefficient must be 1, it is {c2}: divide by it")
    at_0, at_1 = c0, c2 + c1 + c0
    if _same_pose(at_0, p1) and _same_pose(at_1, p2):
        return
    if _same_pose(at_0, p2) and _same_pose(at_1, p1):
        raise AssertionError("the conic: p1 and p2 are exchanged")
    where, got, wanted = ("t = 0", at_0, p1) if not _same_pose(at_0, p1) else ("t = 1", at_1, p2)
    raise AssertionError(f"the conic: at {where} it passes [{got}], not [{wanted}]")


def assert_at(answer, pair, t) -> None:
    """Fail unless the answer is the pose at t of the chain of a pair (h1, h2).

    Examples
    --------
    >>> assert_at((1 - j) * (1 - i), (i, j), 1)
    Traceback (most recent call last):
        ...
    AssertionError: the pose at t = 1: the chain turns about its axes in the wrong order
    """
    (h1, h2), what = pair, f"the pose at t = {t}"
    (pose,) = _points([answer], 1, what)
    if math.isinf(t):
        right = wrong = one
    else:
        right, wrong = (t - h1) * (t - h2), (t - h2) * (t - h1)
    if _same_pose(pose, right):
        return
    if _same_pose(pose, wrong):
        raise AssertionError(f"{what}: the chain turns about its axes in the wrong order")
    raise AssertionError(f"{what}: expected [{right}], got [{pose}]")


def assert_on_quadric(C, what: str = "the conic") -> None:
    """Fail unless all points of a curve of degree two are poses.

    Examples
    --------
    >>> assert_on_quadric([one, -i - j + eps, k])
    Traceback (most recent call last):
        ...
    AssertionError: the conic: at t = 1 it is not on the Study quadric: look at the weights of p1 and p2
    """
    c2, c1, c0 = _points(C, 3, what)
    for t in (0, 1, 2, -1, -2):
        x = c2 * t * t + c1 * t + c0
        scale = size(x.coeffs[:4]) * size(x.coeffs[4:]) + size(x.coeffs[:4]) ** 2
        if not is_zero(study_form(x, x), scale, RTOL):
            raise AssertionError(f"{what}: at t = {t} it is not on the Study quadric: look at the weights of p1 and p2")


def assert_quartic(answer, C: list[DualQuaternion]) -> None:
    """Fail unless the answer holds the five coefficients of C C̄, highest power first; say which slip it looks like.

    Examples
    --------
    >>> assert_quartic((1, 0, 0, 0, 1), [one, -i - j, k])
    Traceback (most recent call last):
        ...
    AssertionError: the quartic: expected (1, 0, 2, 0, 1), got (1, 0, 0, 0, 1)
    """
    right = MotionPolynomial.from_coefficients(C).norm_polynomial()
    square = [
        x.scalar_part
        for x in (MotionPolynomial.from_coefficients(C) * MotionPolynomial.from_coefficients(C)).coefficients
    ]
    norms = [null_form(c, c) for c in C]
    slips = {
        "the lowest power comes last": right[::-1],
        "that is C², the conjugate is missing": square,
        "the products of different coefficients are missing": [norms[0], 0, norms[1], 0, norms[2]],
    }
    assert_equal(answer, right, "the quartic", slips, rtol=RTOL)


def assert_quadratics(answer, quadratics: np.ndarray) -> None:
    """Fail unless the answer holds the two factors (1, b, c) of a quartic, in any order.

    Examples
    --------
    >>> assert_quadratics([(1, 2, 2), (1, 0, 4)], np.array([(1, 0, 4), (1, -2, 2)]))
    Traceback (most recent call last):
        ...
    AssertionError: the quadratics: (t − r)(t − r̄) = t² − (r + r̄) t + r r̄: the sign of b is wrong
    """
    if answer is None or len(answer) != 2:
        raise AssertionError("the quadratics: expected two triples (1, b, c)")
    found, right = numbers([list(row) for row in answer], (2, 3), "the quadratics"), np.asarray(quadratics)
    if right[0, 1] > right[1, 1] or (right[0, 1] == right[1, 1] and right[0, 2] > right[1, 2]):
        right = right[::-1]
    slips = {
        "(t − r)(t − r̄) = t² − (r + r̄) t + r r̄: the sign of b is wrong": right * [1, -1, 1],
        "(t − r)(t − r̄) = t² − (r + r̄) t + r r̄: b is −2 Re r": right * [1, Fraction(1, 2), 1],
    }
    messages = []
    for rows in (found, found[::-1]):
        try:
            return assert_equal(rows, right, "the quadratics", slips, rtol=RTOL)
        except AssertionError as error:
            messages.append(str(error))
    raise AssertionError(next((m for m in messages if "expected" not in m), messages[0]))


def _remainder(C, M) -> tuple[DualQuaternion, DualQuaternion]:
    """The r1 and r0 of the remainder of a quadratic polynomial modulo M."""
    return C[1] - C[0] * M[1], C[2] - C[0] * M[2]


def assert_right_factor(answer, C, M) -> None:
    """Fail unless t − h divides C from the right and (t − h)(t − h̄) = M; say which slip it looks like.

    Examples
    --------
    >>> assert_right_factor(j, [one, -i - 2 * j, 2 * k], (1, 0, 4))
    Traceback (most recent call last):
        ...
    AssertionError: the factor: expected 2 j, got j
    """
    (h,) = _points([answer], 1, "the factor")
    r1, r0 = _remainder(C, M)
    right = -(r1.inverse() * r0)
    if _agree(h, right):
        return
    slips = {
        "the sign is wrong: r1 h + r0 = 0": -right,
        "that is −r0 r1⁻¹, which divides from the left: the order counts": -(r0 * r1.inverse()),
        "the order counts, and r1 h + r0 = 0": r0 * r1.inverse(),
    }
    for said, wrong in slips.items():
        if _agree(h, wrong):
            raise AssertionError(f"the factor: {said}")
    raise AssertionError(f"the factor: expected {right}, got {h}")


def assert_factors(pair, C, M) -> None:
    """Fail unless (t − h1)(t − h2) is C and h2 belongs to the quadratic M.

    Examples
    --------
    >>> assert_factors((2 * j, i), [one, -i - 2 * j, 2 * k], (1, 0, 4))
    Traceback (most recent call last):
        ...
    AssertionError: the factorization: that is (t − h2)(t − h1), in the wrong order
    """
    h1, h2 = _points(pair, 2, "the factorization")
    total, product = -C[1], C[2]
    if not _agree(h1 + h2, total) or not (_agree(h1 * h2, product) or _agree(h2 * h1, product)):
        raise AssertionError(f"the factorization: (t − h1)(t − h2) is not C for h1 = {h1}, h2 = {h2}")
    if not _agree(h1 * h2, product):
        raise AssertionError("the factorization: that is (t − h2)(t − h1), in the wrong order")
    quadratic = [1, -2 * h2.scalar_part, null_form(h2, h2)]
    if not np.all(is_zero(np.array(quadratic) - np.asarray(M), max(map(float, M)), RTOL)):
        raise AssertionError("the factorization: its last factor belongs to the other quadratic")


def assert_loop(factors, first, second) -> None:
    """Fail unless the four factors go round the loop of two chains, out along the first and back along the second.

    Examples
    --------
    >>> h1, h2 = i, 2 * j - 2 * eps * i
    >>> k1, k2 = bennett_flip(h1, h2)
    >>> assert_loop([h1, h2, k1.conjugate(), k2.conjugate()], (h1, h2), (k1, k2))
    Traceback (most recent call last):
        ...
    AssertionError: the loop: on the way back the last joint comes first
    """
    found = _points(factors, 4, "the loop")
    (k1, k2), back = second, [x.conjugate() for x in second]
    right = [*first, back[1], back[0]]
    slips = {
        "on the way back each joint turns backwards: conjugate": [*first, k2, k1],
        "on the way back the last joint comes first": [*first, *back],
        "on the way back the last joint comes first, and each turns backwards": [*first, k1, k2],
    }
    if all(_agree(x, y) for x, y in zip(found, right, strict=True)):
        return
    for said, wrong in slips.items():
        if all(_agree(x, y) for x, y in zip(found, wrong, strict=True)):
            raise AssertionError(f"the loop: {said}")
    raise AssertionError(
        "the loop: these are not the factors of the first chain, then those of the second one backwards"
    )


def assert_link(answer, h: DualQuaternion, k: DualQuaternion, which: str) -> None:
    """Fail unless the distance, or the angle, of a pair (a, α) is that of the axes of two factors.

    Examples
    --------
    >>> assert_link((1, 90), i, j - eps * i, "angle")
    Traceback (most recent call last):
        ...
    AssertionError: the angle: that is in degrees
    """
    number = {"distance": 0, "angle": 1}[which]
    if answer is None or len(answer) != 2:
        raise AssertionError("the link: expected two numbers, the distance and the angle")
    first, second = (Line.from_dual_quaternion(x) for x in (h, k))
    a, alpha = float(first.distance(second)), float(first.angle(second))
    l, m = h - h.scalar_part, k - k.scalar_part
    cosine = float(null_form(h, k)) / math.sqrt(null_form(h, h) * null_form(k, k))
    moment = abs(float(study_form(l, m)))
    slips = {
        "distance": {
            "b(l, k) of unit half-turns is a sin α": a * math.sin(alpha),
            "the half-turns must have length 1": moment,
            "the half-turns must have length 1, and b(l, k) is a sin α then": moment / math.sin(alpha),
            "a distance is not negative": -a,
        },
        "angle": {
            "that is in degrees": math.degrees(alpha),
            "that is between 1 and k as well: leave out the real parts": math.acos(cosine),
            "the order or the sign of a direction is wrong": math.pi - alpha,
        },
    }
    assert_equal(answer[number], (a, alpha)[number], f"the {which}", slips[which], rtol=RTOL)


def assert_ratio(answer, p1: DualQuaternion, p2: DualQuaternion) -> None:
    """Fail unless the answer is a / sin α of the linkage through 1, p1, p2."""
    linkage = bennett_linkage(one, p1, p2)
    link = linkage.denavit_hartenberg()[0]
    right = abs(link.distance / math.sin(link.twist))
    mu = study_eigenvalues(one, p1, p2)
    slips = {
        "halve the difference": 2 * right,
        "it is the largest less the smallest that counts": (mu[1] - mu[0]) / 2,
        "it is the largest less the smallest, not less the second": (mu[2] - mu[1]) / 2,
        "the sign is wrong": -right,
    }
    assert_equal(answer, right, "a / sin α", slips, rtol=RTOL)
