"""The assignment on a Goldberg linkage: each student has a dyad, two poses that it reaches, and a design brief."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    Line,
    Linkage,
    ZPlane,
    act,
    as_float,
    bennett_flip,
    common_perpendicular,
    goldberg_linkages,
    is_zero,
    primal_coordinates,
    same_point,
    size,
    z_planes,
)
from kinlib_assignments.checks import assert_equal, numbers, several
from kinlib_assignments.lot import Lot
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of, methods_of

__all__ = [
    "Brief", "Data", "brief", "check_bad_places", "check_bad_places_any_size", "check_coordinates", "check_dimensions",
    "check_five_bar", "check_lengths", "check_link_ends", "check_misfit", "check_parameters", "check_partner",
    "check_poses_met", "check_room", "check_second_chain", "check_travel", "check_travel_of_a", "corners", "data",
    "draw_map",
]  # fmt: skip

TWICE = 720
SHARE = 0.03  # of the linkages tried, at least so many keep to the brief
SLACK = 1.2  # how much more than one of them needs the brief allows

Pair = tuple[float, float]


class Data(NamedTuple):
    """The half-turns about the axes A and B of a dyad, and two poses that it reaches from the pose 1."""

    hA: DualQuaternion
    hB: DualQuaternion
    p1: DualQuaternion
    p2: DualQuaternion


def data(student: str) -> Data:
    """A dyad with exact half-turns and two poses with whole coefficients.

    Its axes are apart and at a wide angle; in the plane of z neither is the triangle flat, nor does ±√−1 lie on one
    of its sides or on its circumcircle.

    Examples
    --------
    >>> data("ada").p1
    23 + 19 i - 17 j + 21 k + 11 ε - 43 εi - 6 εj + 22 εk
    """
    lot = Lot("goldberg", student)
    axes = lot.until(lambda: [(lot.wholes(3, 2), _direction(lot)) for _ in range(2)], _are_wide)
    hA, hB = (Line.at(point, direction).as_dual_quaternion() for point, direction in axes)
    turns = lot.until(lambda: [(lot.whole(-3, 3), lot.whole(-3, 3)) for _ in range(2)], _is_telling)
    factors = [lot.choice((-2, -1, 1, 2)) for _ in turns]
    poses = (_whole(hA, s_a) * _whole(hB, s_b) for s_a, s_b in turns)
    return Data(hA, hB, *(pose * factor for pose, factor in zip(poses, factors, strict=True)))


def _direction(lot: Lot) -> list[Fraction]:
    """A rational vector of length 1 with small denominators, which keep the poses' coefficients short."""
    return lot.until(lot.direction, lambda direction: max(x.denominator for x in direction) <= 7)


def _are_wide(axes) -> bool:
    """Whether two lines, each a point and a direction, are from 1 to 3 apart, at more than 40°."""
    (a, k), (b, l) = np.array(axes, dtype=float)
    normal = np.cross(k, l)
    sine = np.linalg.norm(normal)
    return sine > 0.65 and 1 < abs((a - b) @ normal) / sine < 3


def _is_telling(turns: list[Pair]) -> bool:
    (a1, b1), (a2, b2) = turns
    if 0 in (a1, b1, a2, b2) or a1 == a2 or b1 == b2 or not 0.4 < abs((b2 - b1) / (a2 - a1)) < 2.5:
        return False
    return all(_room_about(z, turns) > 0.05 for z in (1j, -1j))


def _room_about(z: complex, turns: Sequence[Pair]) -> float:
    """How far z is from the lines and the circle on which there is no linkage, relative to its distance to corners."""
    b1, b2, corner = corners(*turns)
    away = [abs(z - other) for other in (b1, b2, corner)]
    if min(away) < 0.05:
        return 0.0
    sides = [((z - corner) / (b - corner)).imag / abs((z - corner) / (b - corner)) for b in (b1, b2)]
    circle = (z - b1) * (corner - b2) / ((z - b2) * (corner - b1))
    return min(abs(x) for x in (*sides, circle.imag / abs(circle), z.imag))


def _whole(h: DualQuaternion, s: int) -> DualQuaternion:
    """The turn s − h, times the common denominator of h."""
    denominator = math.lcm(*(x.denominator for x in h.coeffs))
    return DualQuaternion([int(x * denominator) for x in (s - h).coeffs])


@cache
def _plane(student: str) -> ZPlane:
    """The plane of z of a student's dyad, joint A turning twice."""
    hA, hB, p1, p2 = data(student)
    return ZPlane.of(Dyad(hA, hB), p1, p2)


def _stops(student: str) -> tuple[Pair, Pair]:
    """The parameters s_A, s_B of both joints in the two poses; whole numbers.

    Examples
    --------
    >>> _stops("ada")
    ((-1, 3), (1, 2))
    """
    first, second = (tuple(int(s) for s in stop) for stop in _plane(student).stops)
    return first, second


def corners(s1: Pair, s2: Pair) -> tuple[complex, complex, complex]:
    """The triangle s_B1, s_B2, z* in the plane of z; z* belongs to the Bennett linkage.

    Examples
    --------
    >>> corners((1, -1), (2, 1))
    ((-1+0j), (1+0j), (-3+2j))
    """
    (a1, b1), (a2, b2) = s1, s2
    y = (b2 - b1) / (a2 - a1)
    return complex(b1), complex(b2), complex(b1 - y * a1, y)


def _partner(student: str, z):
    """The second root z2 for the first root z, complex or an array of complex.

    Examples
    --------
    >>> complex(_partner("ada", 1 + 2j).round(3))
    (3+0.333j)
    """
    return np.asarray(_plane(student).partner(z), dtype=complex)[()]


def _circumcentre(b1: complex, b2: complex, corner: complex) -> complex:
    """The centre of the circle through two real numbers and a third point.

    Examples
    --------
    >>> _circumcentre(-1, 1, 3j)
    1.3333333333333333j
    """
    middle = (b1 + b2) / 2
    return middle + 1j * (abs(corner - middle) ** 2 - abs(b1 - middle) ** 2) / (2 * corner.imag)


def _bad_places(student: str) -> list[tuple[complex, str]]:
    """Values of z of every kind for which there is no 5R linkage through the poses, with what is wrong."""
    b1, b2, corner = corners(*_stops(student))
    centre = _circumcentre(b1, b2, corner)
    sides = [(b2 + u * (corner - b2), "misses pose 1") for u in (-0.7, 0.4, 1.6)]
    sides += [(b1 + u * (corner - b1), "misses pose 2") for u in (-0.6, 0.3, 1.7)]
    circle = [(centre + (b1 - centre) * np.exp(1j * u), "circumcircle") for u in (1.0, 2.3, 4.0)]
    off_axis = [(complex(z), what) for z, what in circle if abs(z.imag) > 1e-3 * abs(b1 - b2) < abs(z - corner)]
    real = [(complex(b1 + u * (b2 - b1)), "real") for u in (-0.8, 0.3, 2.1)]
    return [*sides, *off_axis, *real, (corner, "Bennett")]


def _linkage(student: str, z) -> Linkage:
    """The 5R linkage whose joint A turns by z and then by its partner z2, for one z or an array of them.

    Its second chain has the quadratic polynomials of h_B, h1 and h2 in this order.
    """
    first, _ = _plane(student).linkages(z)
    return first


class Measures(NamedTuple):
    """What a linkage needs: the largest |x|, |y|, |z| of its link ends, its lengths, and the travel of A in degrees."""

    reach: np.ndarray
    lengths: np.ndarray
    travel: np.ndarray


def _measures(linkage: Linkage, steps: int = 720) -> Measures:
    """What a linkage needs on a whole round, seen at some positions; batches give one row each.

    Examples
    --------
    >>> _measures(_linkage("ada", 1 + 2j)).lengths.round(3).tolist()
    [1.413, 1.364, 1.403, 0.049, 1.403]
    """
    axes = linkage.axes
    before = DualQuaternion(np.roll(axes.coeffs, 1, axis=-2))
    ends = np.stack(common_perpendicular(*(Line.from_dual_quaternion(h) for h in (before, axes))), axis=-2)
    turn = np.linspace(0, 2 * np.pi, steps + 1)[1:-1]
    t = np.concatenate([[np.inf], 1 / np.tan(turn / 2), [-np.inf]]).reshape(-1, *[1] * len(linkage.shape))
    moved = act(DualQuaternion(linkage.link_displacements(t).coeffs[..., None, :]), ends)
    return Measures(
        np.abs(moved).max(axis=(0, -2, -3)),
        np.linalg.norm(ends[..., 0, :] - ends[..., 1, :], axis=-1),
        np.degrees(np.ptp(linkage.joint_angles(t)[..., 0], axis=0)),
    )


class Brief(NamedTuple):
    """What a linkage must keep to.

    Attributes
    ----------
    room : tuple of three floats
        All link ends stay where ``|x|``, ``|y|``, ``|z|`` are not larger.
    shortest, longest : float
        Every link is as long as this or something between.
    travel : int
        How far joint A may turn in all, in degrees; 720 if it must turn twice all round.
    """

    room: tuple[float, float, float]
    shortest: float
    longest: float
    travel: int


@cache
def brief(student: str) -> Brief:
    """A brief that one linkage of the student's, found among some hundred, keeps to with a little to spare.

    Examples
    --------
    >>> brief("ada")
    Brief(room=(1.6, 2.1, 2.4), shortest=0.2, longest=1.65, travel=230)
    """
    lot = Lot("goldberg, brief", student)
    needs = _measures(_linkage(student, _candidates(student)), 60)
    suits = (needs.travel > TWICE - 1) == lot.choice((True, False))
    briefs = [_with_slack(Measures(*(values[n] for values in needs))) for n in np.flatnonzero(suits)]
    shares = [_keeps(asked, needs).all(axis=0).mean() for asked in briefs]
    enough = min(SHARE, max(shares))
    return min((asked for asked, share in zip(briefs, shares, strict=True) if share >= enough), key=_generosity)


def _generosity(asked: Brief) -> float:
    return math.prod(asked.room) * asked.longest / asked.shortest * asked.travel


def _candidates(student: str) -> np.ndarray:
    """Some hundred values of z about the triangle, none of them near a place where there is no linkage."""
    turns = _stops(student)
    triangle = corners(*turns)
    middle, size = sum(triangle) / 3, max(abs(x - y) for x in triangle for y in triangle)
    steps = np.linspace(-1.4, 1.4, 21) + 0.01
    grid = (middle + size * (steps + 1j * steps[:, None])).ravel()
    return np.array([z for z in grid if _room_about(z, turns) > 0.03 and min(abs(z - 1j), abs(z + 1j)) > 0.05])


def _with_slack(known: Measures) -> Brief:
    room = tuple(math.ceil(10 * SLACK * x) / 10 for x in known.reach)
    shortest, longest = min(known.lengths) / SLACK, max(known.lengths) * SLACK
    travel = TWICE if known.travel > TWICE - 1 else 5 * math.ceil(known.travel * SLACK / 5)
    return Brief(room, max(1, math.floor(20 * shortest)) / 20, math.ceil(20 * longest) / 20, travel)


def _keeps(asked: Brief, needs: Measures) -> np.ndarray:
    """Whether linkages keep to the room, to the lengths and to the travel of A, shape (3, ...).

    Examples
    --------
    >>> _keeps(brief("ada"), _measures(_linkage("ada", [1 + 2j, 1 - 1j]))).tolist()
    [[False, False], [False, True], [False, False]]
    """
    room = np.all(needs.reach <= np.array(asked.room), axis=-1)
    lengths = (needs.lengths.min(axis=-1) >= asked.shortest) & (needs.lengths.max(axis=-1) <= asked.longest)
    travel = needs.travel > TWICE - 1 if asked.travel == TWICE else needs.travel <= asked.travel
    return np.array([room, lengths, travel])


def draw_map(ax, triangle, grid, met) -> None:
    """Draw in the plane of z the triangle and its circumcircle, and some z by the demands that they meet.

    Parameters
    ----------
    ax : matplotlib Axes
    triangle : three complex numbers
    grid : sequence of complex
    met : array of bool, shape (n, 2)
        Whether the lengths, and whether the travel of A, are as the brief has them.
    """
    grid, (lengths, travel) = np.array(grid), np.array(met).T
    kinds = [
        ("neither", ~lengths & ~travel, ".", "#aaaaaa"),
        ("lengths only", lengths & ~travel, "s", "#56b4e9"),
        ("joint A only", travel & ~lengths, "^", "#e69f00"),
        ("both", lengths & travel, "o", "#000000"),
    ]
    for label, where, marker, colour in kinds:
        ax.scatter(grid.real[where], grid.imag[where], s=24, marker=marker, color=colour, label=label)
    b1, b2, corner = triangle
    outline, centre = np.array([*triangle, b1]), _circumcentre(*triangle)
    circle = centre + (b1 - centre) * np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    ax.plot(outline.real, outline.imag, color="#d55e00")
    ax.plot(circle.real, circle.imag, color="#d55e00", linestyle="--")
    for name, z in (("$s_{B1}$", b1), ("$s_{B2}$", b2), ("$z^*$", corner)):
        ax.annotate(name, (z.real, z.imag), xytext=(5, 5), textcoords="offset points", color="#d55e00")
    ax.set(aspect="equal", xlabel="real part of z", ylabel="imaginary part of z")
    ax.set(xlim=(grid.real.min(), grid.real.max()), ylim=(grid.imag.min(), grid.imag.max()))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)


# ---- checks --------------------------------------------------------------------------------------------


@cache
def _some_z(student: str) -> tuple[complex, complex, complex]:
    """Three points well off all bad places: joint A turns twice all round at the first, and swings at the second."""
    lot, z = Lot("goldberg, to try", student), _candidates(student)
    twice = z.imag * _partner(student, z).imag > 0
    first, second, third = (complex(lot.choice(some)) for some in (z[twice], z[~twice], z))
    return first, second, third


def _poses_to_try(student: str) -> list[tuple[DualQuaternion, Pair]]:
    """Poses that the student's dyad reaches, with s_A and s_B."""
    hA, hB, *poses = data(student)
    return [*zip(poses, _stops(student), strict=True), ((2 - hA) * (5 - hB) * 3, (2, 5))]


def check_coordinates(coordinates: Callable, student: str) -> None:
    """Fail unless a function gives the coordinates of the student's poses, exactly; say which slip it looks like.

    Examples
    --------
    >>> check_coordinates(lambda pose, hA, hB: (0, 0, 0, 1), "ada")
    Traceback (most recent call last):
        ...
    AssertionError: the coordinates: expected (27, 27, -9, -9), got (0, 0, 0, 1)
    """
    hA, hB, *_ = data(student)
    for pose, _ in _poses_to_try(student):
        x = Dyad(hA, hB).coordinates(pose)
        slips = {
            "the coordinates of hA and hB are exchanged": (x[0], x[2], x[1], x[3]),
            "that is the pose divided by its last coordinate: keep the factor": [n / x[3] for n in x],
            "that is the pose divided by its first coordinate: keep the factor": [n / x[0] for n in x],
            "the sign is wrong: the pose is x0 + x1 hA + x2 hB + x3 hA hB": [-n for n in x],
            "x0 comes first, x3 last": x[::-1],
        }
        assert_equal(answer_of(coordinates, pose, hA, hB, without=SHORTCUTS), x, "the coordinates", slips, exact=True)


def check_parameters(parameters: Callable, student: str) -> None:
    """Fail unless a function gives s_A and s_B in the student's poses; say which slip it looks like."""
    hA, hB, *_ = data(student)
    for pose, (s_A, s_B) in _poses_to_try(student):
        last = Dyad(hA, hB).coordinates(pose)[3]
        slips = {
            "s_A and s_B are exchanged: the coordinate of hA is −s_B": (s_B, s_A),
            "the signs are wrong: (s_A − hA)(s_B − hB) has −s_B hA and −s_A hB": (-s_A, -s_B),
            "exchanged, and the signs are wrong: the coordinate of hA is −s_B": (-s_B, -s_A),
            "upside down: divide by x3": (Fraction(1, s_A), Fraction(1, s_B)),
            "divide by x3: a pose is given up to a factor only": (s_A * last, s_B * last),
        }
        answer = answer_of(parameters, pose, hA, hB, without=SHORTCUTS)
        assert_equal(answer, (s_A, s_B), "s_A and s_B", slips)


def check_misfit(misfit: Callable, student: str) -> None:
    """Fail unless a function gives the imaginary part at the student's poses; say which slip it looks like."""
    for s in _stops(student):
        s_A, s_B = s
        for z1, z2 in ((2j, 1 + 1j), (0.25 - 1j, -1.5 + 3j)):
            value = (s_B - z1) * (s_A + 1j) * (s_B - z2)
            slips = {
                "the sign of √−1 is wrong: the factor is s_A + √−1": ((s_B - z1) * (s_A - 1j) * (s_B - z2)).imag,
                "that is the real part": value.real,
                "that is the whole product: its imaginary part is asked for": value,
                "s is (s_A, s_B), in this order": ((s_A - z1) * (s_B + 1j) * (s_A - z2)).imag,
                "the second factor is missing": ((s_B - z1) * (s_A + 1j)).imag,
                "the factor s_A + √−1 is missing": ((s_B - z1) * (s_B - z2)).imag,
            }
            assert_equal(answer_of(misfit, z1, z2, s, without=SHORTCUTS), value.imag, "the misfit", slips)


def check_partner(partner: Callable, student: str) -> None:
    """Fail unless a function gives z2 for some z1 and the student's poses; say which slip it looks like."""
    turns, plane = _stops(student), _plane(student)
    swapped = replace(plane, stops=tuple((s_B, s_A) for s_A, s_B in plane.stops))
    for z in _some_z(student):
        right = _partner(student, z)
        slips = {
            "the imaginary part has the wrong sign": right.conjugate(),
            "the sign of √−1 is wrong: the factor is s_A + √−1": _partner(student, z.conjugate()).conjugate(),
            "real and imaginary part are exchanged": complex(right.imag, right.real),
            "s is (s_A, s_B), in this order": swapped.partner(z),
            "that is z1": z,
        }
        assert_equal(answer_of(partner, z, *turns, without=SHORTCUTS), right, "z2", slips)


def check_poses_met(chain: Callable, pose_at: Callable, student: str) -> None:
    """Fail unless one function gives the factors of the cubic, and another one the poses on it."""
    hA, hB, p1, p2 = data(student)
    for z in _some_z(student):
        factors, _, _ = _plane(student).chains(z)
        roots = z, complex(_partner(student, z))
        _assert_factors(answer_of(chain, *roots, hA, hB, without=SHORTCUTS), *roots, hA, hB)
        for number, (pose, (_, s_B)) in enumerate(zip((p1, p2), _stops(student), strict=True), start=1):
            answer = answer_of(pose_at, tuple(factors), s_B, without=SHORTCUTS)
            _assert_value(answer, factors, s_B, f"C at t = {s_B}, where it meets pose {number}, [{pose}]")


def _assert_factors(answer, z1: complex, z2: complex, hA: DualQuaternion, hB: DualQuaternion) -> None:
    """Fail unless the answer is x1 + y1 hA, x2 + y2 hA, hB; say which slip it looks like."""
    answer = several(answer, 3, "the first chain", "factors")
    for number, (h, z) in enumerate(zip(answer, (z1, z2), strict=False), start=1):
        slips = {
            f"x{number} is the real part of z{number}, y{number} its imaginary part": hA * z.real + z.imag,
            f"y{number} is the imaginary part with its sign": z.real - hA * z.imag,
            "it turns about A: hA, not hB": hB * z.imag + z.real,
            f"that is hA times z{number}: the real part stays alone": hA * z.imag + hA * z.real,
            "that is the other one of the two": hA * (z1 + z2 - z).imag + (z1 + z2 - z).real,
        }
        assert_equal(h, hA * z.imag + z.real, f"h{number}", slips)
    assert_equal(answer[2], hB, "the third factor")


def _assert_value(answer, factors, t, what: str) -> None:
    """Fail unless the answer is (t − h1)(t − h2)(t − h3); say which slip it looks like."""
    h1, h2, h3 = factors
    slips = {
        "the factors are in the wrong order": (t - h3) * (t - h2) * (t - h1),
        "the factors are t − h, not t + h": (t + h1) * (t + h2) * (t + h3),
        "the third factor is missing": (t - h1) * (t - h2),
        "one of the factors of A is missing": (t - h1) * (t - h3),
    }
    assert_equal(answer, (t - h1) * (t - h2) * (t - h3), what, slips)


WORDS = ("Bennett", "real", "misses pose 1", "misses pose 2", "circumcircle", "same quadratic", "")


def check_bad_places(what_is_wrong: Callable, student: str) -> None:
    """Fail unless a function names bad places of all kinds in the student's plane, and finds nothing elsewhere."""
    turns = _stops(student)
    same = [(z, "same quadratic") for z in (1j, -1j, complex(_partner(student, 1j)))]
    fine = [(z, "") for z in _some_z(student)]
    for z, word in [*_bad_places(student), *same, *fine]:
        _assert_word(answer_of(what_is_wrong, z, *turns, without=SHORTCUTS), word, z, turns)


def check_bad_places_any_size(what_is_wrong: Callable, student: str) -> None:
    """Fail unless it does so however large or small the student's triangle is made."""
    for scale in (1e-8, 1e5):
        first, second = ((s_A, s_B * scale) for s_A, s_B in _stops(student))
        for z, word in _bad_places(student):
            beside = scale * (z + (1 + 1.7j) * 1e-3 * abs(first[1] - second[1]) / scale)
            for place, right in ((scale * z, word), (beside, "")):
                found = answer_of(what_is_wrong, place, first, second, without=SHORTCUTS)
                _assert_word(found, right, place, (first, second), f"; the triangle is about {scale:g} wide")


def _assert_word(found, right: str, z: complex, turns: Sequence[Pair], more: str = "") -> None:
    """Fail unless a place got its word; say what may be the reason."""
    if type(found) is str and found == right:
        return
    said = f"z = {z:.6g} for (s_A, s_B) = {turns[0]} and {turns[1]}{more}: expected {right!r}, got {str(found)[:40]!r}"
    raise AssertionError(f"{said}: {_why(found, right, z, bool(more))}")


def _why(found, right: str, z: complex, other_size: bool) -> str:
    """The reason why a place may have got a wrong word."""
    if found not in WORDS:
        return "that is none of the words of the table"
    if {found, right} == {"misses pose 1", "misses pose 2"}:
        return "the sides are exchanged; pose 1 is missed on the line through s_B2 and z*"
    if right == "Bennett":
        return "look for z* first, since it lies on two sides and on the circle, too"
    if other_size:
        return "what counts as there must grow and shrink with the triangle"
    if right == "":
        return "nothing is wrong there"
    if right == "same quadratic" and abs(z * z + 1) > 1e-6:
        return "it is z2 that is ±√−1 there"
    return "see the table"


def check_second_chain(second_chain: Callable, student: str) -> None:
    """Fail unless a function gives the second chain of the student's cubic; say which other chain it looks like."""
    for z in _some_z(student):
        factors, right, other = _plane(student).chains(z)
        slips = {
            "that is the first chain": factors,
            "the quadratics of h1 and h2 are in the wrong order": other,
            "its factors are in the reverse order": right[::-1],
            "the factors are conjugate: joining the chains backwards is the next task": [k.conjugate() for k in right],
            "k1 turns about A: bring the quadratic of hB to the front": (factors[0], *bennett_flip(*factors[1:])),
        }
        what = "the second chain"
        answer = several(answer_of(second_chain, *factors, without=SHORTCUTS), 3, what, "factors")
        rows = np.array([numbers(k, (8,), what) for k in answer])
        stacked = {said: np.array([h.coeffs for h in chain]) for said, chain in slips.items()}
        assert_equal(rows, np.array([k.coeffs for k in right]), what, stacked, rtol=1e-8)


def check_five_bar(five_bar: Callable, student: str) -> None:
    """Fail unless a function gives the student's linkage for some z."""
    hA, hB, *_ = data(student)
    for z in _some_z(student):
        try:
            answer = answer_of(five_bar, z, *_stops(student), hA, hB, without=SHORTCUTS)
        except ValueError as error:
            raise AssertionError(
                f"no linkage came of it: {error}; from_chains takes both chains from the base to the coupler as they "
                "are, and turns the second one back by itself"
            ) from error
        _assert_linkage(answer, *_plane(student).linkages(z))


def _assert_linkage(answer, right: Linkage, other: Linkage) -> None:
    """Fail unless a linkage has the joints, axes and motion of the right one; say if it is the other one."""
    if type(answer) is not Linkage:
        raise AssertionError(f"the linkage: expected a Linkage, got {str(answer)[:80]!r}")
    if tuple(answer.joints) != right.joints:
        raise AssertionError(f"joint A comes first and has two factors: joints=(2, 1, 1, 1, 1), not {answer.joints}")
    if not _agree(answer, right):
        if _agree(answer, other):
            raise AssertionError("that is the other linkage, with the quadratics of h1 and h2 exchanged")
        raise AssertionError("the loop closes, but it is another one: look at its axes")
    told = tuple(map(float, answer.parameters)), tuple(map(float, right.parameters))
    if told[0] != told[1]:
        raise AssertionError(f"parameters=(math.inf, s_B1, s_B2) says where the poses are; yours: {told[0]}")


def _agree(first: Linkage, second: Linkage) -> bool:
    """Whether two linkages have the same axes and the same motion."""
    motions = zip(first.coupler_motion.coefficients, second.coupler_motion.coefficients, strict=True)
    return all(
        same_point(*(as_float(h.coeffs) for h in pair)) for pair in zip(first.axes, second.axes, strict=True)
    ) and all(bool(np.all(is_zero((c - d).coeffs, size(d.coeffs)))) for c, d in motions)


def check_dimensions(dimensions: Callable, student: str) -> None:
    """Fail unless a function gives the distances and angles of the student's linkages."""
    for z in _some_z(student):
        linkage = _linkage(student, z)
        rows = [(row.distance, abs(np.degrees(row.twist))) for row in linkage.denavit_hartenberg()]
        right = np.roll(np.array(rows, dtype=float), 1, axis=0)
        distance, angle = right.T
        slips = {
            "the angles are in radians": np.column_stack([distance, np.radians(angle)]),
            "link 0 lies between the last joint and joint 0": np.roll(right, -1, axis=0),
            "link 0 lies between the last joint and joint 0, and link 1 comes next": np.roll(right, 1, axis=0),
            "the distance comes first": right[:, ::-1],
            "an angle may be more than 90°": np.column_stack([distance, np.minimum(angle, 180 - angle)]),
            "b(l, k) of half-turns is the distance times the sine": np.column_stack(
                [distance * np.sin(np.radians(angle)), angle]
            ),
        }
        answer = answer_of(dimensions, linkage, without=SHORTCUTS)
        assert_equal(answer, right, "the distances and angles", slips, rtol=1e-6)


def check_link_ends(link_ends: Callable, student: str) -> None:
    """Fail unless a function gives the ends of the links of the student's linkages at some t."""
    for z in _some_z(student)[:2]:
        linkage = _linkage(student, z)
        home = _ends([Line.from_dual_quaternion(h) for h in linkage.axes])
        for t in (-1.3, 0.8, math.inf):
            right = _ends([Line.from_dual_quaternion(h) for h in linkage.configuration(t)])
            slips = {
                "the two ends of each link are exchanged": right[:, ::-1],
                "the links have not moved: act on their ends at t = ∞": home,
                **_moved_by_others(linkage.link_displacements(t), home),
            }
            answer = answer_of(link_ends, linkage, t, without=SHORTCUTS)
            assert_equal(answer, right, f"the link ends at t = {t:g}", slips, rtol=1e-6)


def _ends(lines: list[Line]) -> np.ndarray:
    """The ends of the links between five lines, shape (5, 2, 3)."""
    return np.array([common_perpendicular(lines[n - 1], lines[n]) for n in range(5)], dtype=float)


def _moved_by_others(moves: DualQuaternion, home: np.ndarray) -> dict[str, np.ndarray]:
    """The ends of the links, carried along by what does not belong to them."""
    orders = {
        "link n is carried along by displacement n, not by n − 1": range(-1, 4),
        "link n is carried along by displacement n, not by n + 1": (1, 2, 3, 4, 0),
    }
    found = {said: np.array([act(moves[m], home[n]) for n, m in enumerate(order)]) for said, order in orders.items()}
    found["that is the way back: act by the displacement, not by its inverse"] = np.array(
        [act(moves[n].inverse(), home[n]) for n in range(5)]
    )
    return found


def check_travel(travel: Callable, student: str) -> None:
    """Fail unless a function tells how far the joints of the student's linkages travel, to one per cent."""
    half = 1 / np.tan(np.linspace(0, np.pi / 2, 500)[1:])
    for z in _some_z(student):
        linkage = _linkage(student, z)
        right = [float(_measures(linkage, 3000).travel), *[360.0] * 4]
        end = np.degrees(np.abs(linkage.joint_angles(-np.inf)))
        on_half = np.degrees(np.ptp(linkage.joint_angles(np.array([np.inf, *half])), axis=0))
        answer = numbers(answer_of(travel, linkage, without=SHORTCUTS), (5,), "the travel")
        for joint, name in enumerate(("A", "B", 2, 3, 4)):
            slips = {
                "that is in radians": math.radians(right[joint]),
                "that is where the joint ends; it swings to and fro, and its travel lies between": end[joint],
                "that is half of the way round: a round is all of 0 < φ < 2π": on_half[joint],
                "that is twice as much": 2 * right[joint],
            }
            assert_equal(answer[joint], right[joint], f"the travel of joint {name}", slips, rtol=0.01)


# ---- checks of a design ----------------------------------------------------------------------------------


def check_room(z, student: str) -> None:
    """Fail unless the linkage of a student's z keeps to the room of the brief."""
    needs, asked = _judged(z, student), brief(student)
    for axis, reach, most in zip("xyz", needs.reach, asked.room, strict=True):
        if reach > most:
            raise AssertionError(f"the link ends reach {axis} = ±{reach:.3f}, but the room ends at ±{most:g}")


def check_lengths(z, student: str) -> None:
    """Fail unless all links of the linkage of a student's z are as long as the brief allows."""
    needs, asked = _judged(z, student), brief(student)
    for length in needs.lengths:
        if not asked.shortest <= length <= asked.longest:
            allowed = f"{asked.shortest:g} to {asked.longest:g}"
            raise AssertionError(f"a link is {length:.3f} long; the brief allows {allowed}")


def check_travel_of_a(z, student: str) -> None:
    """Fail unless joint A of the linkage of a student's z travels as the brief has it."""
    travel, asked = float(_judged(z, student).travel), brief(student)
    if asked.travel == TWICE and travel < TWICE - 1:
        raise AssertionError(f"joint A swings to and fro over {travel:.1f}°, but it must turn twice all round")
    if asked.travel != TWICE and travel > asked.travel:
        raise AssertionError(f"joint A travels {travel:.1f}°, more than the {asked.travel}° of the brief")


def _judged(z, student: str) -> Measures:
    """What the linkage of a student's z needs, if z gives one."""
    z = complex(numbers(z, (), "z")[()])
    try:
        return _measures(_linkage(student, z))
    except DegenerateError as error:
        raise AssertionError(f"z = {z} gives no linkage through your poses: {error}") from error


# ---- what is withheld ------------------------------------------------------------------------------------

SHORTCUTS = (
    goldberg_linkages, z_planes, *methods_of(ZPlane), Dyad.coordinates, Dyad.parameters, primal_coordinates,
    Linkage.denavit_hartenberg, _partner, _stops, _linkage, _measures, _bad_places, _ends, _keeps,
)  # fmt: skip
"""What is withheld while an answer works."""


def __dir__() -> list[str]:
    return __all__


seal()
