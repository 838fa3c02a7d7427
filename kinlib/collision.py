"""Where the bars of a closed chain meet, and how far from each other they stay."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from kinlib.chain import Lines, batch_index, first_row
from kinlib.errors import Fault, report_faults
from kinlib.moving_bars import AT_INFINITY, MovingBars, Pair, cross, distance, dot, pairs_without_joint
from kinlib.scalar import RTOL, as_float, as_scalars
from kinlib.shown import as_text
from kinlib.typing import Array, ArrayLike, Degenerate, Scalars

__all__ = ["Collision", "CollisionFault", "Collisions", "clearances", "collisions_in_floats"]

ONE_ROOT = 1e-4
"""Roots that are nearer than this angle count as one: so far can rounding move a double or a triple root."""

NEARLY = 1e-3
"""Bars that are nearer than this, in units of the size, at a root of the polynomial may meet next to it."""

SOMEWHERE = np.array([0.36, 0.48, 0.8])
"""A direction for a bar of length zero: its line may be any one through its point."""


class Collision(NamedTuple):
    """Two bars of links that share no joint meet.

    Attributes
    ----------
    t : scalar
        The parameter, ∞ included.
    links : tuple of two int
    point : array, shape (3,)
        Where, in the fixed frame; the middle of what they share if they lie along each other.
    crossing : bool
        Whether one bar goes through the other from side to side, at an inner point of both.  Otherwise they touch: with
        an end or a bend, along each other, or without changing sides.
    """

    t: Scalars
    links: tuple[int, int]
    point: Array
    crossing: bool


class CollisionFault(Fault):
    """Why the bars of a loop do not meet at single parameters."""

    IN_A_PLANE = (
        1,
        (
            "two bars always lie in one plane, so they meet over whole intervals of t and not at single parameters: "
            "clearance() says whether they do"
        ),
    )


@dataclass(frozen=True, eq=False, repr=False)
class Collisions:
    """Where bars meet, once for each t and two links, in the order of t.

    The last axis counts the collisions; short rows of a batch end in NaN.

    Attributes
    ----------
    t : array, shape (..., m)
    links : array of int, shape (..., m, 2)
        −1 behind the last collision.
    point : array, shape (..., m, 3)
    crossing : array of bool, shape (..., m)
    count : int, or array of shape (...)
        How many there are; NaN where a row is NaN or has no answer.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> hits = bennett_linkage(*gallery.THREE_POSES).collisions()
    >>> hits
    2 collisions
      t = 0, links 0 and 2 touch at (-1.33333, 0, 0)
      t = ∞, links 0 and 2 touch at (-0.333333, 0, 0)
    >>> hits.count, hits.entries[0].point.tolist()
    (2, [Fraction(-4, 3), Fraction(0, 1), Fraction(0, 1)])
    """

    t: Array
    links: Array
    point: Array
    crossing: Array
    count: Any

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch; ``()`` for a single linkage."""
        return self.t.shape[:-1]

    @property
    def entries(self) -> tuple[Collision, ...]:
        """The collisions of a single linkage, one by one."""
        if self.shape:
            raise TypeError("a batch has no entries of its own: index it, or iterate over it")
        columns = (self.t, self.links.tolist(), self.point, self.crossing.tolist())
        rows = list(zip(*columns, strict=True))[: 0 if np.isnan(self.count) else int(self.count)]
        return tuple(Collision(t, (a, b), point, crossing) for t, (a, b), point, crossing in rows)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("the collisions of a single linkage are in .entries, their number is .count")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Collisions:
        """Entries of the batch."""
        where = batch_index(index, self.shape, "answer")
        parts = (self.t[where], self.links[where], self.point[where], self.crossing[where])
        return Collisions(*parts, np.asarray(self.count)[where[:-1]][()])

    def __iter__(self) -> Iterator[Collisions]:
        return (self[n] for n in range(len(self)))

    def __repr__(self) -> str:
        if self.shape:
            return f"Collisions of shape {self.shape}"
        if np.isnan(self.count):
            return "no answer"
        head = f"{self.count} collision" + "s" * (self.count != 1)
        return "\n  ".join([head, *map(_in_words, self.entries)])


def _in_words(hit: Collision) -> str:
    t = as_text(float(hit.t)).replace("inf", "∞")
    place = ", ".join(as_text(float(x) + 0.0) for x in hit.point)
    return f"t = {t}, links {hit.links[0]} and {hit.links[1]} {'cross' if hit.crossing else 'touch'} at ({place})"


OFF_AXIS = 1e-6
"""How far the end of a bar may be from its axis, in units of the size of the chain and of where the bars are."""


def checked_bars(bars: ArrayLike, lines: Lines) -> Array:
    """Bars that a user gives, shape (..., n, m, 3), with the two ends of each on the axes that it joins.

    Raises
    ------
    ValueError
        If the shape is another, or an end lies beside its axis.
    """
    points, (*_, count, _) = as_scalars(bars), lines.directions.shape
    if points.ndim < 3 or points.shape[-3] != count or points.shape[-2] < 2 or points.shape[-1] != 3:
        raise ValueError(
            f"expected the points of {count} bars, at least two for each: shape (..., {count}, m, 3), "
            f"got {points.shape}"
        )
    seen = as_float(points) - lines.middle[..., None, None, :]
    size = np.maximum(lines.length, np.abs(seen).max(axis=(-3, -2, -1)))[..., None] + lines.noise[..., None]
    for end, shift, words in ((0, 1, "first"), (-1, 0, "last")):
        directions, feet = (np.roll(x, shift, axis=-2) for x in (lines.directions, lines.points))
        off = np.linalg.norm(np.cross(seen[..., end, :] - feet, directions), axis=-1) / size
        if np.any(off > OFF_AXIS):
            row, named = first_row((off > OFF_AXIS).any(axis=-1))
            link = int(np.nanargmax(off[row]))
            raise ValueError(
                f"{named}expected the {words} point of the bar of link {link} on axis {(link - shift) % count + 1}, "
                f"but it is off by {off[row][link] * size[row][0]:.3g}: bars go from axis to axis, link 0 from "
                "the last to the first"
            )
    return points


def listed_collisions(hits: Sequence[Sequence[Collision]], shape: tuple[int, ...], undefined: Array) -> Collisions:
    """The collisions of a batch of that shape, from those of each row."""
    rows = np.repeat(np.arange(len(hits)), [len(row) for row in hits])
    flat = [hit for row in hits for hit in row]
    t, point = np.empty(len(flat), dtype=object), np.empty((len(flat), 3), dtype=object)
    for n, hit in enumerate(flat):
        t[n], point[n] = hit.t, hit.point
    links = np.array([hit.links for hit in flat], dtype=int).reshape(-1, 2)
    crossing = np.array([hit.crossing for hit in flat], dtype=bool)
    return wrap_collisions(Found(rows, t, links, point, crossing), shape, undefined)


def wrap_collisions(found: Found, shape: tuple[int, ...], undefined: Array) -> Collisions:
    """The collisions of a batch of that shape, from a list of all."""
    order = np.lexsort((found.links[:, 0], found.t.astype(float), found.rows))
    rows, t, links, point, crossing = (column[order] for column in found)
    total = len(undefined)
    count = np.bincount(rows, minlength=total)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
    width = int(count.max(initial=0))
    columns = []
    for column, empty in ((t, np.nan), (links, -1), (point, np.nan), (crossing, False)):
        table = np.full((total, width, *column.shape[1:]), empty, dtype=column.dtype)
        table[rows, place] = column
        columns.append(table.reshape(*shape, *table.shape[1:]))
    number = np.where(undefined, np.nan, count) if undefined.any() else count
    number = number.reshape(shape)
    t, links, point, crossing = columns
    return Collisions(t, links, point, crossing, number if shape else number.item())


class Found(NamedTuple):
    """A list of collisions: the rows of the batch, and what Collision has."""

    rows: Array
    t: Array
    links: Array
    point: Array
    crossing: Array


# ---- floats ------------------------------------------------------------------------------------------


def collisions_in_floats(
    bars: MovingBars,
    joints: Sequence[int],
    shape: tuple[int, ...],
    *,
    rtol: float = RTOL,
    degenerate: Degenerate = "raise",
) -> Collisions:
    """Where bars meet, for a batch of that shape.

    The lines of two bars meet where a polynomial vanishes: with t = middle + spread · cot φ a trigonometric one, so
    that t = ∞ is no exception.  Its roots are polished, and there the bars must be nearer than rtol times their size.
    """
    defined = np.flatnonzero(bars.defined)
    inner = bars.pick(defined)
    pieces = range(bars.bars.shape[2] - 1)
    found, faults = [], np.zeros(len(bars.size), dtype=int)
    for pair in pairs_without_joint(joints) if len(defined) else []:
        lines = [_Lines(inner, pair, n, m) for n in pieces for m in pieces]
        in_plane = [line.always_meet for line in lines]
        faults[defined] |= np.any(in_plane, axis=0) * int(CollisionFault.IN_A_PLANE)
        found.append(_without_doubles([line.collisions(rtol) for line in lines], inner, pair))
    bad = report_faults(faults.reshape(shape), CollisionFault, degenerate).reshape(-1)
    hits = Found(*map(np.concatenate, zip(*found, strict=True))) if found else _nothing()
    hits = hits._replace(rows=defined[hits.rows])
    undefined = bad | ~bars.defined
    return wrap_collisions(Found(*(column[~undefined[hits.rows]] for column in hits)), shape, undefined)


def _nothing() -> Found:
    none = np.zeros(0)
    return Found(none.astype(int), none, np.zeros((0, 2), dtype=int), np.zeros((0, 3)), none.astype(bool))


class _Lines:
    """The lines of one piece of the held bar and one piece of the moving bar, and where they meet."""

    def __init__(self, bars: MovingBars, pair: Pair, held: int, moving: int):
        self.bars, self.pair = bars, pair
        self.first = bars.bars[pair.held][:, held : held + 2]
        self.second = bars.bars[pair.moving][:, moving : moving + 2]
        self.lines = [_with_direction(piece, bars.size) for piece in (self.first, self.second)]
        self.weight = [bars.joints[n] for n in pair.joints]
        self.degree = 2 * sum(len(joint.rate) for joint in self.weight)
        values = [self.volume(angle) for angle in _samples(self.degree)]
        self.always_meet = np.abs(values).max(axis=0) <= RTOL
        self.values = np.stack([v * w for v, w in zip(values, map(self.norm, _samples(self.degree)), strict=True)])

    def volume(self, angle: Any, rows: Array | slice = slice(None)) -> Array:
        """What vanishes where the lines meet: sine times distance, in units of the size; at φ, for some rows."""
        held, moving = (line[..., rows] for line in self.lines)
        bars = self.bars if isinstance(rows, slice) else self.bars.pick(rows)
        moving = bars.moved(self.pair, moving, angle)
        u, v = held[:, 1] - held[:, 0], moving[:, 1] - moving[:, 0]
        volume = dot(cross(u, v), moving[:, 0] - held[:, 0])
        return np.asarray(volume / np.sqrt(dot(u, u) * dot(v, v)) / bars.size)

    def norm(self, angle: Any, rows: Array | slice = slice(None)) -> Array:
        """The norm of the motion at φ, which makes the volume a trigonometric polynomial."""
        numbers = [joint.pick(rows).half_turn_number(angle) for joint in self.weight]  # type: ignore[arg-type]
        return np.asarray(np.prod([z.real**2 + z.imag**2 for z in numbers], axis=0))

    def collisions(self, rtol: float) -> Found:
        """Where the pieces themselves meet."""
        rows, angle, odd = self._roots()
        angle = self._nearest(rows, angle, rtol)
        bars, ends = self.bars.pick(rows), self._ends(rows, angle)
        gap, s, r = distance(*ends)
        near = gap <= rtol * bars.size
        u, v = ends[1] - ends[0], ends[3] - ends[2]
        lengths = np.sqrt(dot(u, u)), np.sqrt(dot(v, v))
        inside = [np.minimum(x, 1 - x) * length > rtol * bars.size for x, length in zip((s, r), lengths, strict=True)]
        across = np.sqrt(dot(cross(u, v), cross(u, v))) > ONE_ROOT**2 * lengths[0] * lengths[1]
        point = np.where(across, ends[0] + s * u, _middle_of_overlap(*ends))
        point = bars.outward(self.pair.held, point, angle)
        links = np.broadcast_to(sorted(self.pair[:2]), (len(rows), 2))
        found = Found(rows, angle, links, point.T, odd & across & inside[0] & inside[1])
        return Found(*(column[near] for column in found))

    def _ends(self, rows: Array, angle: Array) -> tuple[Array, Array, Array, Array]:
        """The ends of the two pieces at φ."""
        second = self.bars.pick(rows).moved(self.pair, self.second[..., rows], angle)
        return self.first[:, 0, rows], self.first[:, 1, rows], second[:, 0], second[:, 1]

    def _nearest(self, rows: Array, angle: Array, rtol: float) -> Array:
        """The angles, improved where the pieces nearly meet: next to fast turns rounding moves the roots."""
        gap = distance(*self._ends(rows, angle))[0] / self.bars.size[rows]
        poor = (gap > rtol / 10) & (gap < NEARLY)
        if poor.any():
            some, start = rows[poor], angle[poor]
            angle = angle.copy()
            angle[poor] = narrowed(lambda x: distance(*self._ends(some, x))[0], start - NEARLY, start + NEARLY)[0]
        return np.where(np.abs(np.sin(angle)) < AT_INFINITY, 0.0, angle % np.pi)

    def _roots(self) -> tuple[Array, Array, Array]:
        """The roots φ, each once: row, angle, and whether the polynomial changes sign there."""
        turned = _turned_charts(self.degree)
        best = np.abs(np.einsum("js,sr->jr", turned[:, 0], self.values)).argmax(axis=0)
        coefficients = np.einsum("rds,sr->rd", turned[best], self.values)
        roots = _roots_of(np.where(self.always_meet[:, None], np.eye(self.degree + 1)[0], coefficients))
        real = np.abs(roots.imag) <= ONE_ROOT * (1 + np.abs(roots) ** 2) if self.degree else roots.real > 0
        real &= ~self.always_meet[:, None]
        away = np.sort(np.where(real, np.arctan2(1.0, roots.real), np.inf), axis=-1)
        away, count, keep = _clusters(away)
        rows, column = np.nonzero(keep)
        away, count = away[rows, column], count[rows, column]
        angle = self._polished(rows, away, count, coefficients[rows], np.pi * best[rows] / len(turned))
        return rows, angle, count % 2 == 1

    def _polished(self, rows: Array, away: Array, count: Array, coefficients: Array, start: Array) -> Array:
        """The angle φ of simple roots after one step of Newton's method, with the volume itself as the value."""
        tau, sine = 1 / np.tan(away), np.sin(away)
        slope = 0.0 * tau
        value = 0.0 * tau
        for c in coefficients.T:
            value, slope = value * tau + c, slope * tau + value
        angle = start + away
        slope = -slope * sine ** (self.degree - 2) / self.norm(angle, rows)
        step = self.volume(angle, rows) / np.where(slope == 0, np.inf, slope)
        return (angle - np.where((count == 1) & (np.abs(step) < ONE_ROOT), step, 0.0)) % np.pi


def _with_direction(piece: Array, size: Array) -> Array:
    """The two ends of a piece; a second point somewhere instead of an end that is the same as the other."""
    u = piece[:, 1] - piece[:, 0]
    point = np.sqrt(dot(u, u)) <= 1e-12 * size
    return np.stack([piece[:, 0], np.where(point, piece[:, 0] + SOMEWHERE[:, None] * size, piece[:, 1])], axis=1)


def _middle_of_overlap(a: Array, b: Array, c: Array, d: Array) -> Array:
    """The middle of what two segments of one line share."""
    u, v = b - a, d - c
    longer = dot(u, u) >= dot(v, v)
    base, direction = np.where(longer, a, c), np.where(longer, u, v)
    square = np.where(dot(direction, direction) > 0, dot(direction, direction), 1.0)
    low, high = np.sort([dot(x - base, direction) / square for x in np.where(longer, (c, d), (a, b))], axis=0)
    return np.asarray(base + (np.maximum(low, 0.0) + np.minimum(high, 1.0)) / 2 * direction)


def _samples(degree: int) -> Array:
    return np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)


@lru_cache
def _turned_charts(degree: int) -> Array:
    """Matrices from values at the samples to coefficients in τ = cot(φ − φ_j), for angles φ_j = πj/(2 degree + 2).

    Some φ_j is far from all roots, so that none is far away in its τ.
    """
    start = np.pi * np.arange(2 * degree + 2) / (2 * degree + 2)
    away = _samples(degree) - start[:, None]
    powers = np.arange(degree + 1)
    values = np.cos(away[..., None]) ** (degree - powers) * np.sin(away[..., None]) ** powers
    return np.linalg.inv(values)


def _roots_of(polynomials: Array) -> Array:
    """All roots of real polynomials, shape (rows, degree + 1), as the eigenvalues of their companion matrices."""
    degree = polynomials.shape[-1] - 1
    companion = np.zeros((len(polynomials), degree, degree))
    companion[:, 0] = -polynomials[:, 1:] / polynomials[:, :1]
    companion[:, np.arange(1, degree), np.arange(degree - 1)] = 1
    return np.linalg.eigvals(companion) + 0j


def _clusters(angles: Array) -> tuple[Array, Array, Array]:
    """Ascending angles with those that are one put together: their mean, their number, and where they stand.

    The mean of what rounding makes of a double root is exact up to rounding itself.
    """
    real = np.isfinite(angles)
    angles = np.where(real, angles, 4.0)
    new = np.diff(angles, axis=-1, prepend=-1.0) > ONE_ROOT
    number = np.cumsum(new, axis=-1)
    together = (number[:, :, None] == number[:, None, :]) * 1.0
    count = together.sum(axis=-1)
    return (together @ angles[..., None])[..., 0] / count, count.astype(int), new & real


def _without_doubles(found: Sequence[Found], bars: MovingBars, pair: Pair) -> Found:
    """The collisions of two links, one for each parameter; parameters t instead of angles."""
    hits = Found(*map(np.concatenate, zip(*found, strict=True)))
    order = np.lexsort((hits.t, hits.rows))
    hits = Found(*(column[order] for column in hits))
    first = (np.diff(hits.rows, prepend=-1) > 0) | (np.diff(hits.t, prepend=-1.0) > ONE_ROOT / 100)
    crossing = np.zeros(np.count_nonzero(first), dtype=bool)
    np.logical_or.at(crossing, np.cumsum(first) - 1, hits.crossing)
    hits = Found(*(column[first] for column in hits))._replace(crossing=crossing)
    return hits._replace(t=bars.pick(hits.rows).parameter(hits.t))


# ---- clearance ---------------------------------------------------------------------------------------


def clearances(bars: MovingBars, joints: Sequence[int], rtol: float) -> Array:
    """The least distances of bars that share no joint, shape (rows,), over one full turn.

    Branch and bound: an interval of φ where no bar can come nearer than what was found elsewhere, less rtol times the
    size, is left out; the others are halved.  What was found is then improved.  Where the bars are known to meet there
    is nothing to search.
    """
    least = np.where(bars.defined, np.inf, np.nan)
    pairs = pairs_without_joint(joints)
    count = collisions_in_floats(bars, joints, least.shape, degenerate="nan").count
    least[np.asarray(count) > 0] = 0.0
    free = np.flatnonzero(least == np.inf)
    if pairs and len(free):
        least[free] = _Search(bars.pick(free), pairs, rtol).run()
    return least


START = 16
"""Into how many intervals the turn is first cut."""


class _Search:
    """What is known of the least distance, row by row."""

    def __init__(self, bars: MovingBars, pairs: Sequence[Pair], rtol: float):
        self.bars, self.pairs, self.close = bars, pairs, rtol * bars.size
        self.best = np.full(len(bars.size), np.inf)
        self.where = np.zeros(len(bars.size))
        self.who = np.zeros(len(bars.size), dtype=int)
        self.half = np.zeros(len(bars.size))

    def run(self) -> Array:
        """The least distances."""
        count = len(self.best)
        half = np.pi / START / 2
        rows = np.repeat(np.arange(count), START)
        angle = np.tile((2 * np.arange(START) + 1) * half, count)
        open_ones = [(n, rows, angle, half) for n in range(len(self.pairs))]
        while open_ones:
            seen = [self._look(*part) for part in open_ones]
            open_ones = [part for part in (self._split(*looked) for looked in seen) if len(part[1])]
        self._improve()
        return np.where(self.best <= RTOL * self.bars.size, 0.0, self.best)

    def _look(self, number: int, rows: Array, angle: Array, half: float) -> tuple[int, Array, Array, float, Array]:
        """What the distances in the middle of some intervals are, and what they may become there at least."""
        bars = self.bars.pick(rows)
        gap, speed = bars.distance_and_speed(self.pairs[number], angle, np.full(len(rows), half))
        order = np.lexsort((gap, rows))
        first = order[np.unique(rows[order], return_index=True)[1]]
        better = first[gap[first] < self.best[rows[first]]]
        at = rows[better]
        self.best[at], self.where[at], self.who[at], self.half[at] = gap[better], angle[better], number, half
        return number, rows, angle, half, gap - 2 * half * speed

    def _split(
        self, number: int, rows: Array, angle: Array, half: float, bound: Array
    ) -> tuple[int, Array, Array, float]:
        """The halves of the intervals where a bar may come nearer."""
        keep = (bound < self.best[rows] - self.close[rows]) & (self.best[rows] > RTOL * self.bars.size[rows])
        rows, angle = rows[keep], angle[keep]
        return number, np.repeat(rows, 2), (angle[:, None] + half / 2 * np.array([-1, 1])).reshape(-1), half / 2

    def _improve(self) -> None:
        """Narrow the place of the least distance by golden sections."""
        for number, pair in enumerate(self.pairs):
            rows = np.flatnonzero((self.who == number) & (self.best > RTOL * self.bars.size))
            if len(rows):
                self.best[rows] = np.minimum(self.best[rows], self._narrowed(pair, rows))

    def _narrowed(self, pair: Pair, rows: Array) -> Array:
        bars, half = self.bars.pick(rows), 2 * self.half[rows]
        return narrowed(lambda angle: bars.distance(pair, angle), self.where[rows] - half, self.where[rows] + half)[1]


GOLDEN = (math.sqrt(5) - 1) / 2


def narrowed(function: Callable[[Array], Array], low: Array, high: Array, steps: int = 40) -> tuple[Array, Array]:
    """Where a function with one dip between low and high is least, and its value, by golden sections."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_a, at_b = function(a), function(b)
    for _ in range(steps):
        left = at_a < at_b
        low, high = np.where(left, low, a), np.where(left, b, high)
        new = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        value = function(new)
        a, b = np.where(left, new, b), np.where(left, a, new)
        at_a, at_b = np.where(left, value, at_b), np.where(left, at_a, value)
    return np.where(at_a < at_b, a, b), np.minimum(at_a, at_b)
