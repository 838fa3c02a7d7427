"""The assignment on a Goldberg linkage: each student has a dyad, two poses that it reaches, and a design brief."""

from __future__ import annotations

import math
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
    act,
    as_float,
    bennett_flip,
    common_perpendicular,
    is_zero,
    same_point,
    size,
)
from kinlib_assignments.checks import assert_equal, numbers
from kinlib_assignments.lot import Lot
from kinlib_assignments.seal import seal

__all__ = [
    "Brief", "Data", "Measures", "assert_chain", "assert_lengths", "assert_linkage", "assert_room", "assert_travel",
    "bad_places", "brief", "candidates", "circumcentre", "corners", "data", "draw_map", "keeps", "linkage_for",
    "measures", "partner_of", "second_chain", "stops",
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


def _room_about(z: complex, turns: list[Pair]) -> float:
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


def stops(found: Data) -> tuple[Pair, Pair]:
    """The parameters s_A, s_B of both joints in the two poses; whole numbers.

    Examples
    --------
    >>> stops(data("ada"))
    ((-1, 3), (1, 2))
    """
    dyad = Dyad(found.hA, found.hB)
    first, second = (tuple(int(s) for s in dyad.parameters(pose)) for pose in (found.p1, found.p2))
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


def circumcentre(b1: complex, b2: complex, corner: complex) -> complex:
    """The centre of the circle through two real numbers and a third point.

    Examples
    --------
    >>> circumcentre(-1, 1, 3j)
    1.3333333333333333j
    """
    middle = (b1 + b2) / 2
    return middle + 1j * (abs(corner - middle) ** 2 - abs(b1 - middle) ** 2) / (2 * corner.imag)


def partner_of(z, s1: Pair, s2: Pair):
    """The second root z2 for the first root z, complex or an array of complex.

    Examples
    --------
    >>> partner_of(2j, (2, 1), (-1, 2))
    (2+0.75j)
    """
    w1, w2 = ((s_b - z) * (s_a + 1j) for s_a, s_b in (s1, s2))
    right1, right2 = s1[1] * w1.imag, s2[1] * w2.imag
    determinant = w1.imag * w2.real - w1.real * w2.imag
    x, y = right1 * w2.real - w1.real * right2, w1.imag * right2 - right1 * w2.imag
    return (x + 1j * y) / determinant


def bad_places(s1: Pair, s2: Pair) -> list[tuple[complex, str]]:
    """Values of z of every kind for which there is no 5R linkage through the poses, with what is wrong."""
    b1, b2, corner = corners(s1, s2)
    centre = circumcentre(b1, b2, corner)
    sides = [(b2 + u * (corner - b2), "misses pose 1") for u in (-0.7, 0.4, 1.6)]
    sides += [(b1 + u * (corner - b1), "misses pose 2") for u in (-0.6, 0.3, 1.7)]
    circle = [(centre + (b1 - centre) * np.exp(1j * u), "circumcircle") for u in (1.0, 2.3, 4.0)]
    off_axis = [(complex(z), what) for z, what in circle if abs(z.imag) > 1e-3 * abs(b1 - b2) < abs(z - corner)]
    real = [(complex(b1 + u * (b2 - b1)), "real") for u in (-0.8, 0.3, 2.1)]
    return [*sides, *off_axis, *real, (corner, "Bennett")]


def linkage_for(found: Data, z) -> Linkage:
    """The 5R linkage whose joint A turns by z and then by its partner z2, for one z or an array of them.

    The second chain has the quadratic polynomials of h_B, h1 and h2 in this order.
    """
    s1, s2 = stops(found)
    hA, hB = (DualQuaternion(as_float(h.coeffs)) for h in (found.hA, found.hB))
    z = np.asarray(z, dtype=complex)
    h1, h2 = (hA * root.imag + root.real for root in (z, partner_of(z, s1, s2)))
    options = {"joints": (2, 1, 1, 1, 1), "parameters": (math.inf, s1[1], s2[1])}
    return Linkage.from_chains((h1, h2, hB), second_chain(h1, h2, hB), **options)


def second_chain(h1: DualQuaternion, h2: DualQuaternion, hB: DualQuaternion) -> tuple[DualQuaternion, ...]:
    """The factors k1, k2, k3 of the same cubic with the quadratic polynomials of h_B, h1, h2 in this order.

    Examples
    --------
    >>> from kinlib import eps, i, j
    >>> k1, k2, k3 = second_chain(1 + 2 * i, 3 * i, j - eps * i)
    >>> k1 + k2 + k3 == 1 + 5 * i + j - eps * i
    True
    """
    middle, k3 = bennett_flip(h2, hB)
    k1, k2 = bennett_flip(h1, middle)
    return k1, k2, k3


class Measures(NamedTuple):
    """What a linkage needs: the largest |x|, |y|, |z| of its link ends, its lengths, and the travel of A in degrees."""

    reach: np.ndarray
    lengths: np.ndarray
    travel: np.ndarray


def measures(linkage: Linkage, steps: int = 720) -> Measures:
    """What a linkage needs on a whole round, seen at some positions; batches give one row each.

    Examples
    --------
    >>> measures(linkage_for(data("ada"), 1 + 2j)).lengths.round(3).tolist()
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
    lot, found = Lot("goldberg, brief", student), data(student)
    needs = measures(linkage_for(found, candidates(*stops(found))), 60)
    suits = (needs.travel > TWICE - 1) == lot.choice((True, False))
    briefs = [_with_slack(Measures(*(values[n] for values in needs))) for n in np.flatnonzero(suits)]
    shares = [keeps(asked, needs).all(axis=0).mean() for asked in briefs]
    enough = min(SHARE, max(shares))
    return min((asked for asked, share in zip(briefs, shares, strict=True) if share >= enough), key=_generosity)


def _generosity(asked: Brief) -> float:
    return math.prod(asked.room) * asked.longest / asked.shortest * asked.travel


def candidates(s1: Pair, s2: Pair) -> np.ndarray:
    """Some hundred values of z about the triangle, none of them near a place where there is no linkage."""
    triangle = corners(s1, s2)
    middle, size = sum(triangle) / 3, max(abs(x - y) for x in triangle for y in triangle)
    steps = np.linspace(-1.4, 1.4, 21) + 0.01
    grid = (middle + size * (steps + 1j * steps[:, None])).ravel()
    return np.array([z for z in grid if _room_about(z, [s1, s2]) > 0.03 and min(abs(z - 1j), abs(z + 1j)) > 0.05])


def _with_slack(known: Measures) -> Brief:
    room = tuple(math.ceil(10 * SLACK * x) / 10 for x in known.reach)
    shortest, longest = min(known.lengths) / SLACK, max(known.lengths) * SLACK
    travel = TWICE if known.travel > TWICE - 1 else 5 * math.ceil(known.travel * SLACK / 5)
    return Brief(room, max(1, math.floor(20 * shortest)) / 20, math.ceil(20 * longest) / 20, travel)


def keeps(asked: Brief, needs: Measures) -> np.ndarray:
    """Whether linkages keep to the room, to the lengths and to the travel of A, shape (3, ...).

    Examples
    --------
    >>> keeps(brief("ada"), measures(linkage_for(data("ada"), [2j, 1 - 1j]))).tolist()
    [[False, False], [True, True], [False, False]]
    """
    room = np.all(needs.reach <= np.array(asked.room), axis=-1)
    lengths = (needs.lengths.min(axis=-1) >= asked.shortest) & (needs.lengths.max(axis=-1) <= asked.longest)
    travel = needs.travel > TWICE - 1 if asked.travel == TWICE else needs.travel <= asked.travel
    return np.array([room, lengths, travel])


def assert_room(z, student: str) -> None:
    """Fail unless the linkage of a student's z keeps to the room of the brief."""
    needs, asked = _judged(z, student), brief(student)
    for axis, reach, most in zip("xyz", needs.reach, asked.room, strict=True):
        if reach > most:
            raise AssertionError(f"the link ends reach {axis} = ±{reach:.3f}, but the room ends at ±{most:g}")


def assert_lengths(z, student: str) -> None:
    """Fail unless all links of the linkage of a student's z are as long as the brief allows."""
    needs, asked = _judged(z, student), brief(student)
    for length in needs.lengths:
        if not asked.shortest <= length <= asked.longest:
            allowed = f"{asked.shortest:g} to {asked.longest:g}"
            raise AssertionError(f"a link is {length:.3f} long; the brief allows {allowed}")


def assert_travel(z, student: str) -> None:
    """Fail unless joint A of the linkage of a student's z travels as the brief has it."""
    travel, asked = _judged(z, student).travel, brief(student)
    if asked.travel == TWICE and travel < TWICE - 1:
        raise AssertionError(f"joint A swings to and fro over {travel:.1f}°, but it must turn twice all round")
    if asked.travel != TWICE and travel > asked.travel:
        raise AssertionError(f"joint A travels {travel:.1f}°, more than the {asked.travel}° of the brief")


def _judged(z, student: str) -> Measures:
    """What the linkage of a student's z needs, if z gives one."""
    found, z = data(student), complex(numbers(z, (), "z")[()])
    turns = stops(found)
    badly = _room_about(z, turns) < 1e-6 or min(abs(w * w + 1) for w in (z, partner_of(z, *turns))) < 1e-6
    if badly:
        raise AssertionError(f"z = {z} gives no linkage through your poses: see the table of bad places")
    try:
        return measures(linkage_for(found, z))
    except DegenerateError as error:
        raise AssertionError(f"z = {z}: {error}") from error


def assert_chain(answer, h1: DualQuaternion, h2: DualQuaternion, hB: DualQuaternion) -> None:
    """Fail unless the answer is the second chain of h1, h2, h_B; say which other chain it looks like."""
    assert answer is not None, "the second chain: nothing was returned; is there a `return`?"
    assert len(answer) == 3, f"the second chain: expected three factors, got {len(answer)}"
    right, other = second_chain(h1, h2, hB), second_chain(h2, h1, hB)
    slips = {
        "that is the first chain": (h1, h2, hB),
        "the quadratics of h1 and h2 are in the wrong order": other,
        "its factors are in the reverse order": right[::-1],
        "the factors are conjugate: joining the chains backwards is the next task": [k.conjugate() for k in right],
    }
    rows = np.array([numbers(k, (8,), "the second chain") for k in answer])
    stacked = {said: np.array([h.coeffs for h in chain]) for said, chain in slips.items()}
    assert_equal(rows, np.array([k.coeffs for k in right]), "the second chain", stacked, rtol=1e-8)


def assert_linkage(answer, right: Linkage) -> None:
    """Fail unless a linkage has the joints, axes and motion of another."""
    assert isinstance(answer, Linkage), f"expected a Linkage, got {answer!r}"
    joints = f"joint A comes first and has two factors: joints=(2, 1, 1, 1, 1), not {answer.joints}"
    assert tuple(answer.joints) == right.joints, joints
    residual = answer.closure_residual()
    assert residual < 1e-8, f"the loop does not close: its product is off a real polynomial by {residual:.1e}"
    wrong = [
        n
        for n, (axis, expected) in enumerate(zip(answer.axes, right.axes, strict=True))
        if not same_point(axis, expected)
    ]
    assert not wrong, f"the loop closes, but it is another one: joints {wrong} have other axes than asked for"
    motions = zip(answer.coupler_motion.coefficients, right.coupler_motion.coefficients, strict=True)
    assert all(is_zero((c - d).coeffs, size(d.coeffs)).all() for c, d in motions), "the coupler has another motion"
    told = f"parameters=(math.inf, s_B1, s_B2) says where the poses are; yours: {answer.parameters}"
    assert tuple(map(float, answer.parameters)) == tuple(map(float, right.parameters)), told


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
    outline, centre = np.array([*triangle, b1]), circumcentre(*triangle)
    circle = centre + (b1 - centre) * np.exp(1j * np.linspace(0, 2 * np.pi, 200))
    ax.plot(outline.real, outline.imag, color="#d55e00")
    ax.plot(circle.real, circle.imag, color="#d55e00", linestyle="--")
    for name, z in (("$s_{B1}$", b1), ("$s_{B2}$", b2), ("$z^*$", corner)):
        ax.annotate(name, (z.real, z.imag), xytext=(5, 5), textcoords="offset points", color="#d55e00")
    ax.set(aspect="equal", xlabel="real part of z", ylabel="imaginary part of z")
    ax.set(xlim=(grid.real.min(), grid.real.max()), ylim=(grid.imag.min(), grid.imag.max()))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)


def __dir__() -> list[str]:
    return ["Brief", "Data", "brief", "corners", "data", "draw_map"]


seal()
