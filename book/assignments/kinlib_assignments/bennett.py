"""The assignment on Theorem 2: each student has three poses and builds the Bennett linkage through them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
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
from kinlib_assignments.checks import assert_equal, numbers, several
from kinlib_assignments.lot import Lot
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of

__all__ = [
    "Data", "check_angle", "check_body", "check_conic", "check_conic_on_quadric", "check_distance",
    "check_first_factorization", "check_loop", "check_quadratics", "check_quartic", "check_ratio", "check_right_factor",
    "check_second_factorization", "data",
]  # fmt: skip

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
    -12 + 3 i - 18 j - 3 k - 45 ε + 15 εi + 30 εj + 15 εk
    """
    lot = Lot("bennett", student)
    h1, h2 = map(DualQuaternion, lot.until(lambda: (_factor(lot), _factor(lot)), _is_good))
    return Data(*(_scaled(lot, pose) for pose in (h1 * h2, (1 - h1) * (1 - h2))))


def _factor(lot: Lot) -> list[int]:
    """The coefficients of a whole number, not 0, and a half-turn about a line with whole direction and points."""
    l, m, n = lot.until(lambda: lot.wholes(3, 2), any)
    a, b, c = lot.wholes(3, 2)
    return [lot.choice((-2, -1, 1, 2)), l, m, n, 0, b * n - c * m, c * l - a * n, a * m - b * l]


def _scaled(lot: Lot, pose: DualQuaternion) -> DualQuaternion:
    """The same pose with other whole coefficients, so that the weights of the conic are not 1."""
    row = pose.components.tolist()
    divisor, factor = math.gcd(*row), lot.choice((-3, -2, 2, 3))
    return DualQuaternion([x // divisor * factor for x in row])


def _is_good(pair) -> bool:
    """Whether the linkage is well proportioned, the roots are apart, and no two poses are nearly conjugate."""
    if not (_are_skew(*pair) and _roots_are_apart(*pair)):
        return False
    h1, h2 = map(DualQuaternion, pair)
    return _is_telling(h1 + h2, h1 * h2) and _is_proportioned(h1, h2)


def _is_telling(total: DualQuaternion, product: DualQuaternion) -> bool:
    """Whether no product of two coefficients of t² − total t + product drops out of the quartic."""
    return 0 not in (total.scalar_part, product.scalar_part, null_form(total, product))


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
    if 100 * max(first, second) > 99:  # a right angle would hide what a sine is for
        return False
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


def _split(p1: DualQuaternion, p2: DualQuaternion) -> tuple[list[DualQuaternion], np.ndarray, list[tuple]]:
    """The conic of 1, p1, p2 as its coefficients, its two quadratics, and its two factorizations.

    The last factor of the first pair belongs to the second quadratic, that of the second pair to the first.

    Examples
    --------
    >>> C, quadratics, pairs = _split(*data("ada"))
    >>> [h.scalar_part == -quadratics[n][1] / 2 for n, h in enumerate(pairs[0])]
    [True, True]
    """
    C = conic_through(one, p1, p2)
    return list(C.coefficients), quadratic_factors(C.norm_polynomial()), factorizations(C)


def _points(answer, count: int, what: str) -> list[DualQuaternion]:
    """An answer that must be a number of dual quaternions."""
    return [DualQuaternion(numbers(x, (8,), what)) for x in several(answer, count, what, "dual quaternions")]


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


def _assert_passes(C, p1: DualQuaternion, p2: DualQuaternion) -> None:
    """Fail unless the three coefficients are those of a monic curve that passes p1 at t = 0 and p2 at t = 1.

    Examples
    --------
    >>> _assert_passes([one, -i - j, k], k, 1 - i - j + k)
    >>> _assert_passes([one, -i - j, k], 1 - i - j + k, k)
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


def _assert_at(answer, pair, t) -> None:
    """Fail unless the answer is the pose at t of the chain of a pair (h1, h2).

    Examples
    --------
    >>> _assert_at((1 - j) * (1 - i), (i, j), 1)
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


def _assert_on_quadric(C, what: str = "the conic") -> None:
    """Fail unless all points of a curve of degree two are poses.

    Examples
    --------
    >>> _assert_on_quadric([one, -i - j + eps, k])
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


def _assert_quartic(answer, C: list[DualQuaternion]) -> None:
    """Fail unless the answer holds the five coefficients of C C̄, highest power first; say which slip it looks like.

    Examples
    --------
    >>> _assert_quartic((1, 0, 0, 0, 1), [one, -i - j, k])
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


def _assert_quadratics(answer, quadratics: np.ndarray) -> None:
    """Fail unless the answer holds the two factors (1, b, c) of a quartic, in any order.

    Examples
    --------
    >>> _assert_quadratics([(1, 2, 2), (1, 0, 4)], np.array([(1, 0, 4), (1, -2, 2)]))
    Traceback (most recent call last):
        ...
    AssertionError: the quadratics: (t − r)(t − r̄) = t² − (r + r̄) t + r r̄: the sign of b is wrong
    """
    rows = [several(row, 3, "the quadratics", "numbers") for row in several(answer, 2, "the quadratics", "triples")]
    found, right = numbers(rows, (2, 3), "the quadratics"), np.asarray(quadratics)
    if right[0, 1] > right[1, 1] or (right[0, 1] == right[1, 1] and right[0, 2] > right[1, 2]):
        right = right[::-1]
    slips = {
        "(t − r)(t − r̄) = t² − (r + r̄) t + r r̄: the sign of b is wrong": right * [1, -1, 1],
        "(t − r)(t − r̄) = t² − (r + r̄) t + r r̄: b is −2 Re r": right * [1, Fraction(1, 2), 1],
        "c is r r̄ = |r|², not |r|": np.array([(1.0, b, math.sqrt(c)) for _, b, c in right]),
        "c is r r̄ = |r|², the square of the real part and that of the imaginary part": np.array(
            [(1, b, c - b * b / 4) for _, b, c in right]
        ),
        "c is r r̄ = |r|², not the square of the real part": np.array([(1, b, b * b / 4) for _, b, c in right]),
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


def _assert_right_factor(answer, C, M) -> None:
    """Fail unless t − h divides C from the right and (t − h)(t − h̄) = M; say which slip it looks like.

    Examples
    --------
    >>> _assert_right_factor(j, [one, -i - 2 * j, 2 * k], (1, 0, 4))
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


def _assert_factors(pair, C, M) -> None:
    """Fail unless (t − h1)(t − h2) is C and h2 belongs to the quadratic M.

    Examples
    --------
    >>> _assert_factors((2 * j, i), [one, -i - 2 * j, 2 * k], (1, 0, 4))
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


def _assert_loop(factors, first, second) -> None:
    """Fail unless the four factors go round the loop of two chains, out along the first and back along the second.

    Examples
    --------
    >>> h1, h2 = i, 2 * j - 2 * eps * i
    >>> k1, k2 = bennett_flip(h1, h2)
    >>> _assert_loop([h1, h2, k1.conjugate(), k2.conjugate()], (h1, h2), (k1, k2))
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


def _assert_link(answer, h: DualQuaternion, k: DualQuaternion, which: str) -> None:
    """Fail unless the distance, or the angle, of a pair (a, α) is that of the axes of two factors.

    Examples
    --------
    >>> _assert_link((1, 90), i, j - eps * i, "angle")
    Traceback (most recent call last):
        ...
    AssertionError: the angle: that is in degrees
    """
    number = {"distance": 0, "angle": 1}[which]
    answer = several(answer, 2, "the link", "numbers, the distance and the angle")
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
            "a distance is not negative: it is |b(l, k)| / sin α": -a,
            "that is a cos α / sin α or so: divide by the sine, not by the tangent": a * math.cos(alpha),
            "leave out the real parts: the half-turns are those of l and k": moment
            / math.sqrt(float(null_form(h, h) * null_form(k, k))),
            "leave out the real parts before you make the length 1": moment
            / math.sqrt(float(null_form(h, h) * null_form(k, k)))
            / math.sin(math.acos(cosine)),
        },
        "angle": {
            "that is in degrees": math.degrees(alpha),
            "that is between 1 and k as well: leave out the real parts": math.acos(cosine),
            "it is between 0 and π, and may be more than π/2: the cosine has a sign": math.pi - alpha,
            "that is the cosine of it": math.cos(alpha),
            "that is the sine of it": math.sin(alpha),
            "that is twice the angle": 2 * alpha,
        },
    }
    assert_equal(answer[number], (a, alpha)[number], f"the {which}", slips[which], rtol=RTOL)


def _assert_ratio(answer, p1: DualQuaternion, p2: DualQuaternion) -> None:
    """Fail unless the answer is a / sin α of the linkage through 1, p1, p2."""
    linkage = bennett_linkage(one, p1, p2)
    link = linkage.denavit_hartenberg()[0]
    right = abs(link.distance / math.sin(link.twist))
    mu = study_eigenvalues(one, p1, p2)
    points = one, p1, p2
    S, N = (np.array([[float(form(x, y)) for y in points] for x in points]) for form in (study_form, null_form))
    slips = {
        "the null form is missing: they are the eigenvalues of N⁻¹ S": _spread(S) / 2,
        "the eigenvalues of S N, not of N⁻¹ S, were taken": _spread(N @ S) / 2,
        "halve the difference": 2 * right,
        "it is the largest less the smallest that counts": (mu[1] - mu[0]) / 2,
        "it is the largest less the smallest, not less the second": (mu[2] - mu[1]) / 2,
        "the sign is wrong": -right,
        "that is a sin α": link.distance * abs(math.sin(link.twist)),
    }
    assert_equal(answer, right, "a / sin α", slips, rtol=RTOL)


def _spread(matrix: np.ndarray) -> float:
    values = np.linalg.eigvals(matrix).real
    return values.max() - values.min()


# ---- checks of functions, on the poses of a student ------------------------------------------------------


def _factored(student: str) -> tuple[list[DualQuaternion], np.ndarray, list[tuple]]:
    return _split(*data(student))


def check_conic(conic: Callable, student: str) -> None:
    """Fail unless a function gives a monic curve through the student's poses."""
    poses = data(student)
    _assert_passes(answer_of(conic, *poses, without=SHORTCUTS), *poses)


def check_conic_on_quadric(conic: Callable, student: str) -> None:
    """Fail unless that curve, which has the student's poses on it, lies on the Study quadric."""
    p1, p2 = data(student)
    answer = answer_of(conic, p1, p2, without=SHORTCUTS)
    _assert_on_quadric(answer)
    c2, c1, c0 = _points(answer, 3, "the conic")
    at_0, at_1 = c0, c2 + c1 + c0
    if not any(_same_pose(at_0, x) and _same_pose(at_1, y) for x, y in ((p1, p2), (p2, p1))):
        raise AssertionError(f"the conic: it does not pass [{p1}] and [{p2}] at t = 0 and t = 1")


def check_quartic(quartic: Callable, student: str) -> None:
    """Fail unless a function multiplies the student's conic by its conjugate."""
    C, *_ = _factored(student)
    _assert_quartic(answer_of(quartic, list(C), without=SHORTCUTS), C)


def check_quadratics(quadratics: Callable, student: str) -> None:
    """Fail unless a function finds the two quadratics of the student's quartic."""
    _, right, _ = _factored(student)
    _assert_quadratics(answer_of(quadratics, list(np.convolve(*right)), without=SHORTCUTS), right)


def check_right_factor(right_factor: Callable, student: str) -> None:
    """Fail unless a function gives both right factors of the student's conic."""
    C, Ms, _ = _factored(student)
    for M in Ms:
        _assert_right_factor(answer_of(right_factor, list(C), tuple(M), without=SHORTCUTS), C, M)


def _check_factorization(both: Callable, student: str, which: int) -> None:
    C, Ms, _ = _factored(student)
    pairs = several(answer_of(both, list(C), *map(tuple, Ms), without=SHORTCUTS), 2, "the factorizations", "pairs")
    _assert_factors(pairs[which], C, Ms[1 - which])


def check_first_factorization(both: Callable, student: str) -> None:
    """Fail unless the first pair of factors is that whose last one belongs to the second quadratic."""
    _check_factorization(both, student, 0)


def check_second_factorization(both: Callable, student: str) -> None:
    """Fail unless the second pair of factors is that whose last one belongs to the first quadratic."""
    _check_factorization(both, student, 1)


def check_body(body: Callable, student: str) -> None:
    """Fail unless a function gives the poses of both chains of the student's linkage."""
    for pair in _factored(student)[2]:
        for t in (0, 1, -2, Fraction(7, 3), math.inf):
            _assert_at(answer_of(body, pair, t, without=SHORTCUTS), pair, t)


def check_loop(loop: Callable, student: str) -> None:
    """Fail unless a function joins the student's two chains."""
    *_, pairs = _factored(student)
    _assert_loop(answer_of(loop, *pairs, without=SHORTCUTS), *pairs)


def _links(student: str) -> Iterator[tuple[DualQuaternion, DualQuaternion]]:
    """Links of the student's linkage, one of them more than a right angle, with factors that are not of length 1."""
    (h1, h2), (k1, k2) = _factored(student)[2]
    for f, g in ((h1, h2), (h2, k2.conjugate()), (2 * h1, k1)):
        yield f, g
        yield f, g.conjugate()


def check_distance(link: Callable, student: str) -> None:
    """Fail unless a function gives the distance of the axes of two factors."""
    for f, g in _links(student):
        _assert_link(answer_of(link, f, g, without=SHORTCUTS), f, g, "distance")


def check_angle(link: Callable, student: str) -> None:
    """Fail unless a function gives the angle of the axes of two factors."""
    for f, g in _links(student):
        _assert_link(answer_of(link, f, g, without=SHORTCUTS), f, g, "angle")


def check_ratio(ratio: Callable, student: str) -> None:
    """Fail unless a function gives a / sin α of the student's linkage, from the poses alone."""
    poses = data(student)
    _assert_ratio(answer_of(ratio, *poses, without=SHORTCUTS), *poses)


# ---- what is withheld ------------------------------------------------------------------------------------

SHORTCUTS = (
    bennett_linkage, dyads_through_poses, study_eigenvalues, conic_through, quadratic_factors, factorize,
    factorizations, bennett_flip, quadratic_of, linear_factor, MotionPolynomial.__init__,
    MotionPolynomial.from_coefficients.__func__, Linkage.from_chains.__func__, Linkage.denavit_hartenberg,
    Line.distance, Line.angle, common_perpendicular, _split, _factored, _remainder,
)  # fmt: skip
"""What is withheld while an answer works."""


def __dir__() -> list[str]:
    return __all__


seal()
