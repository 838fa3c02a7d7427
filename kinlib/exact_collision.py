"""Where the bars of a closed chain meet, exactly: roots of polynomials over ℚ, and signs in the fields of the roots."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial, reduce
from itertools import pairwise
from numbers import Rational
from typing import Any, NamedTuple

import numpy as np

from kinlib.collision import Collision
from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, one, study_form
from kinlib.errors import DegenerateError
from kinlib.line import Line, common_perpendicular
from kinlib.motion_polynomial import MotionPolynomial, RationalCurve, evaluate, multiply
from kinlib.moving_bars import Pair, cross, distance, dot, pairs_without_joint
from kinlib.number_field import NumberField
from kinlib.scalar import as_float, divide
from kinlib.typing import Array

__all__ = ["exact_bars", "exact_collisions"]


def exact_bars(axes: DualQuaternion, bars: Array) -> Array:
    """Exact ends of the bars of one chain, where the given ones in floats are; shape (n, 2, 3).

    Each is the common perpendicular of its axes if the given one is; else it goes between the points of the axes that
    are nearest to the given ends, taken as fractions.
    """
    lines = [Line.from_dual_quaternion(axis) for axis in axes]
    middle = bars.mean(axis=(0, 1))
    size = np.abs(bars - middle).max()
    ends = np.empty(bars.shape, dtype=object)
    for n, (first, second) in enumerate(zip([lines[-1], *lines], lines, strict=False)):
        feet = _feet(first, second)
        if feet is None:  # parallel axes: all bars in one plane
            feet = first.foot(_fractions(middle)), second.foot(_fractions(middle))
        if np.abs(np.array(feet).astype(float) - bars[n]).max() > 1e-6 * size:
            feet = first.foot(_fractions(bars[n, 0])), second.foot(_fractions(bars[n, 1]))
        ends[n] = feet
    return ends


def _fractions(point: Array) -> list[Fraction]:
    return [Fraction(float(x)) for x in point]


def _feet(first: Line, second: Line) -> tuple[Array, Array] | None:
    try:
        return common_perpendicular(first, second)
    except DegenerateError:
        return None


def exact_collisions(factors: Sequence[DualQuaternion], joints: Sequence[int], bars: Array) -> list[Collision] | None:
    """Where bars of links that share no joint meet, for one exact linkage, in the order of t; None if two bars always
    lie in one plane.

    Parameters
    ----------
    factors : sequence of DualQuaternion
        In loop order, over ℚ.
    joints : sequence of int
        How many consecutive factors share an axis.
    bars : array, shape (n, m, 3)
        The points of each link's bar at home, exact.

    Raises
    ------
    ValueError
        If there are numbers that are not rational.
    """
    _check_rational([*(f.components for f in factors), bars])
    starts = np.cumsum([0, *joints])
    groups = [factors[a:b] for a, b in pairwise(starts)]
    hits: list[Collision] = []
    for pair in pairs_without_joint(joints):
        way = MotionPolynomial.from_coefficients(_product([f for n in pair.joints for f in groups[n]]))
        back = [f for group in groups[: pair.held] for f in group]
        found = _hits_of(pair, way, bars)
        if found is None:
            return None
        hits += [hit._replace(point=_outward(back, hit)) for hit in found]
    return sorted(hits, key=lambda hit: (float(hit.t), hit.links))


def _check_rational(arrays: Sequence[Array]) -> None:
    for x in (x for array in arrays for x in np.asarray(array).ravel()):
        if not isinstance(x, (Rational, np.integer)):
            raise ValueError(
                f"where bars meet is found exactly over the rational numbers, got {x!r}: "
                "linkage.astype(float).collisions() finds it in floats"
            )


def _product(factors: Sequence[DualQuaternion]) -> list[DualQuaternion]:
    return reduce(multiply, [[one, -f] for f in factors])


def _outward(factors: Sequence[DualQuaternion], hit: Collision) -> Array:
    """The point of a collision in the fixed frame, from that of the held link at home."""
    if not factors or hit.t == math.inf:
        return hit.point
    place = reduce(lambda q, f: q * f, [one * hit.t - f for f in factors])
    return np.asarray(act(place, hit.point))


def _hits_of(pair: Pair, way: MotionPolynomial, bars: Array) -> list[Collision] | None:
    """The collisions of two bars, points seen from the held link, one for each parameter."""
    links = (min(pair[:2]), max(pair[:2]))
    moving = [way.trajectory(point) for point in bars[pair.moving]]
    floats = MotionPolynomial(as_float(way.coeffs))
    hits: list[Collision] = []
    for a, b in pairwise(bars[pair.held]):
        for n, (c, d) in enumerate(pairwise(bars[pair.moving])):
            polynomial = _meeting_polynomial(way, (a, b), (c, d))
            if not any(polynomial):
                return None
            for root in _roots(polynomial, partial(_is_near, floats, (a, b, c, d))):
                start, end = (_at(curve, root.t) for curve in moving[n : n + 2])
                met = _meeting(a, b, start, end)
                if met:
                    hits.append(Collision(root.t, links, met.point, met.across and root.odd))
    return list(_each_once(hits))


def _each_once(hits: Sequence[Collision]) -> Iterator[Collision]:
    seen: list[Collision] = []
    for hit in sorted(hits, key=lambda hit: not hit.crossing):
        if all(hit.t != other.t for other in seen):
            seen.append(hit)
            yield hit


# ---- the polynomial and its roots --------------------------------------------------------------------


def _meeting_polynomial(way: MotionPolynomial, held: tuple[Array, Array], moving: tuple[Array, Array]) -> list[Any]:
    """What vanishes where the lines of two pieces meet: the form of Study of l and C k C̄, highest power first."""
    l, k = (_line(*piece) for piece in (held, moving))
    carried = multiply([c * k for c in way.coefficients], way.conjugate().coefficients)
    return [study_form(l, c) for c in carried]


def _line(a: Array, b: Array) -> DualQuaternion:
    """The line through two points; through one point twice any line will do, here one of no special direction."""
    direction = b - a if np.any(b != a) else np.array([3, 5, 7], dtype=object)
    return DualQuaternion(np.concatenate([[0], direction, [0], np.cross(a, direction)]))


class _Root(NamedTuple):
    """A parameter t, exact, and whether the polynomial changes sign there."""

    t: Any
    odd: bool


def _roots(polynomial: Sequence[Any], is_near: Callable[[float], bool]) -> Iterator[_Root]:
    """The real roots, and ∞ where leading coefficients vanish; irrational ones as generators of their fields.

    Irrational roots where the pieces are far from each other are left out.
    """
    from sympy import QQ, Poly, Symbol

    zeros = next(n for n, c in enumerate(polynomial) if c)
    if zeros:
        yield _Root(math.inf, zeros % 2 == 1)
    rational = [QQ(int(Fraction(c).numerator), int(Fraction(c).denominator)) for c in polynomial]
    for factor, power in Poly(rational, Symbol("t"), domain=QQ).factor_list()[1]:
        for t in _real_roots(factor, is_near):
            yield _Root(t, power % 2 == 1)


def _real_roots(factor: Any, is_near: Callable[[float], bool]) -> Iterator[Any]:
    """The real roots of an irreducible polynomial."""
    from sympy import CRootOf

    if factor.degree() == 1:
        high, low = factor.all_coeffs()
        root = -low / high
        yield Fraction(int(root.p), int(root.q))
        return
    count = factor.count_roots()
    estimates = _estimates(factor, count)
    for n in range(count):
        if estimates is None or is_near(estimates[n]):
            yield NumberField(CRootOf(factor, n, radicals=False)).generator


def _estimates(factor: Any, count: int) -> list[float] | None:
    """The real roots in floats in ascending order, if so many are found; their number is known exactly."""
    roots = np.roots([float(c) for c in factor.all_coeffs()])
    real = np.sort(roots[np.abs(roots.imag) <= 1e-9 * (1 + np.abs(roots))].real)
    return [float(t) for t in real] if len(real) == count else None


FAR = 1e-3
"""Pieces that are farther from each other in floats, in units of their size, do not meet: no sign need be asked."""


def _is_near(way: MotionPolynomial, piece: tuple[Array, Array, Array, Array], t: float) -> bool:
    """Whether two pieces may meet at t, by floats."""
    a, b, c, d = (as_float(x) for x in piece)
    c, d = act(way(t), np.array([c, d]))
    size = max(np.abs(x - a).max() for x in (b, c, d))
    return bool(distance(a, b, c, d)[0] <= FAR * size)


# ---- at one parameter --------------------------------------------------------------------------------


def _at(curve: RationalCurve, t: Any) -> Array:
    """A point of a rational curve by homogeneous coordinates, shape (4,)."""
    return np.array([evaluate(list(row), t) for row in curve.coeffs.T], dtype=object)


class _Meeting(NamedTuple):
    """Where two segments meet, and whether at an inner point of both, across each other."""

    point: Array
    across: bool


def _meeting(a: Array, b: Array, c: Array, d: Array) -> _Meeting | None:
    """Where the segments ab and cd of one plane meet; c and d are given by homogeneous coordinates.

    All is decided by signs, without a division: a + s u = c + r v gives s u × v = (c − a) × v, and so on.
    """
    weight, u, v, way = c[0], b - a, d[1:] - c[1:], c[1:] - c[0] * a
    normal = cross(u, v)
    square = dot(normal, normal)
    if not square:
        return _along(a, b, c, d)
    first, second = dot(cross(way, v), normal), dot(cross(way, u), normal)
    if _outside(first, weight * square) or _outside(second, square):
        return None
    inner = bool(first and second and first != weight * square and second != square)
    return _Meeting(a + divide(first, weight * square) * u, inner)


def _outside(x: Any, length: Any) -> bool:
    """Whether x is not between 0 and a positive length."""
    return bool(x < 0 or x > length)


def _along(a: Array, b: Array, c: Array, d: Array) -> _Meeting | None:
    """What parallel segments share, if they are on one line: its middle."""
    start, end = (divide(x[1:], x[0]) for x in (c, d))
    if not np.any(a != b):
        a, b, start, end = start, end, a, b
    u = b - a
    if np.any(cross(start - a, u)) or np.any(cross(end - a, u)):
        return None
    if not np.any(u):
        return _Meeting(a, False) if np.all(a == start) else None
    x, y = dot(start - a, u), dot(end - a, u)
    first, last = (x, y) if x <= y else (y, x)
    low, high = (first if first > 0 else 0), (last if last < dot(u, u) else dot(u, u))
    return _Meeting(a + divide(low + high, 2 * dot(u, u)) * u, False) if low <= high else None
