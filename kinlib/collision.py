"""Where the bars of a closed chain meet, and how far from each other they stay."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kinlib.chain import Lines, batch_index, first_row
from kinlib.circle import narrowed, roots_of, samples, turned_charts
from kinlib.errors import Fault, report_faults
from kinlib.moving_bars import MovingBars, Pair, cross, distance, dot, pairs_without_joint
from kinlib.scalar import RTOL, as_float, as_scalars
from kinlib.shown import as_text
from kinlib.typing import Array, ArrayLike, Degenerate, Scalars

__all__ = ["Collision", "CollisionFault", "Collisions", "clearances", "collisions_in_floats"]

APART = (1e-4, 1e-6, 1e-8, 0.0)
"""Roots that are nearer than these angles are tried as one: so far can rounding move double and triple roots."""

PARALLEL = 1e-8
"""Bars whose angle has a smaller sine than this lie along each other."""

ROUNDED = 1e-13
"""Volumes below this may have the wrong sign."""

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
        found.append(_each_once([line.meetings(rtol) for line in lines], inner, pair, rtol))
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
        values = [self.volume(angle) for angle in samples(self.degree)]
        self.always_meet = np.abs(values).max(axis=0) <= RTOL
        self.values = np.stack([v * w for v, w in zip(values, map(self.norm, samples(self.degree)), strict=True)])

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

    def meetings(self, rtol: float) -> _Meetings:
        """Where the pieces themselves meet.

        Roots that may be one are tried as one first, at their mean; if the pieces do not meet there, as fewer ones.
        """
        away, coefficients, start = self._roots()
        untried, found = np.isfinite(away), []
        for apart in APART:
            groups = _groups(away, untried, apart)
            rows, sides = groups.rows, start[groups.rows] + groups.sides
            angle = start[rows] + groups.away - self._step(groups, coefficients[rows], start[rows])
            alone = (groups.number == 1) | (apart == 0)
            angle = self._nearest(rows, angle, sides, alone, rtol)
            met = distance(*self._ends(rows, angle))[0] <= rtol * self.bars.size[rows]
            found.append(self._judged(rows[met], angle[met], sides[:, met], rtol))
            untried &= ~groups.members(met | alone, away.shape)
            if not untried.any():
                break
        return _Meetings(*map(np.concatenate, zip(*found, strict=True)))

    def _judged(self, rows: Array, angle: Array, sides: Array, rtol: float) -> _Meetings:
        """Meetings at given angles, and whether one piece goes through the other.

        It does if they meet at an inner point of both, across, and the volume has another sign before than behind.
        """
        bars, ends = self.bars.pick(rows), self._ends(rows, angle)
        gap, s, _ = distance(*ends)
        u, v = ends[1] - ends[0], ends[3] - ends[2]
        lengths = np.sqrt(dot(u, u)), np.sqrt(dot(v, v))
        across = np.sqrt(dot(cross(u, v), cross(u, v))) > PARALLEL * lengths[0] * lengths[1]
        end, beside = _nearest_end(*ends)
        inner = beside > rtol * bars.size
        point = np.where(across, np.where(inner, ends[0] + s * u, end), _middle_of_overlap(*ends))
        before, behind = (self.volume(side, rows) for side in sides)
        changes = (before * behind < 0) & (np.minimum(np.abs(before), np.abs(behind)) > ROUNDED)
        point = bars.outward(self.pair.held, point, angle)
        return _Meetings(rows, angle, point.T, across & inner & changes, gap)

    def _ends(self, rows: Array, angle: Array) -> tuple[Array, Array, Array, Array]:
        """The ends of the two pieces at φ."""
        second = self.bars.pick(rows).moved(self.pair, self.second[..., rows], angle)
        return self.first[:, 0, rows], self.first[:, 1, rows], second[:, 0], second[:, 1]

    def _nearest(self, rows: Array, angle: Array, sides: Array, which: Array, rtol: float) -> Array:
        """The angles, some improved where the pieces nearly meet: next to fast turns rounding moves the roots."""
        gap = distance(*self._ends(rows, angle))[0] / self.bars.size[rows]
        poor = which & (gap > rtol / 10) & (gap < NEARLY)
        if poor.any():
            some = rows[poor]
            angle = angle.copy()
            angle[poor] = narrowed(lambda x: distance(*self._ends(some, x))[0], *sides[:, poor])[0]
        return angle

    def _roots(self) -> tuple[Array, Array, Array]:
        """The real roots, how far they are away from the beginning of a chart, ascending, ∞ behind them; the polynomial
        in this chart, and its beginning."""
        turned = turned_charts(self.degree)
        best = np.abs(np.einsum("js,sr->jr", turned[:, 0], self.values)).argmax(axis=0)
        coefficients = np.einsum("rds,sr->rd", turned[best], self.values)
        roots = roots_of(np.where(self.always_meet[:, None], np.eye(self.degree + 1)[0], coefficients))
        real = np.abs(roots.imag) <= APART[0] * (1 + np.abs(roots) ** 2) if self.degree else roots.real > 0
        real &= ~self.always_meet[:, None]
        away = np.sort(np.where(real, np.arctan2(1.0, roots.real), np.inf), axis=-1)
        return away, coefficients, np.pi * best / len(turned)

    def _step(self, groups: _Groups, coefficients: Array, start: Array) -> Array:
        """One step of Newton's method for simple roots, with the volume itself as the value."""
        tau, sine = 1 / np.tan(groups.away), np.sin(groups.away)
        slope = 0.0 * tau
        value = 0.0 * tau
        for c in coefficients.T:
            value, slope = value * tau + c, slope * tau + value
        angle = start + groups.away
        slope = -slope * sine ** (self.degree - 2) / self.norm(angle, groups.rows)
        step = self.volume(angle, groups.rows) / np.where(slope == 0, np.inf, slope)
        return np.where((groups.number == 1) & (np.abs(step) < APART[0]), step, 0.0)


class _Groups(NamedTuple):
    """Roots that may be one: the row, the first of them and their number, their mean, and the angles before and behind
    them, half the way to the next roots or so."""

    rows: Array
    first: Array
    number: Array
    away: Array
    sides: Array

    def members(self, which: Array, shape: tuple[int, int]) -> Array:
        """Where the roots of some groups are in the table of all."""
        table, columns = np.zeros(shape, dtype=bool), np.arange(shape[1])
        first, behind = (x[which, None] for x in (self.first, self.first + self.number))
        group, column = np.nonzero((columns >= first) & (columns < behind))
        table[self.rows[which][group], column] = True
        return table


def _groups(away: Array, untried: Array, apart: float) -> _Groups:
    """Groups of untried roots, ascending, between which it is farther than the given angle."""
    mean, count, new = _clusters(away, apart)
    rows, first = np.nonzero(new & untried)
    count, mean = count[rows, first], mean[rows, first]
    low, high = away[rows, first], away[rows, first + count - 1]
    framed = np.pad(away, ((0, 0), (1, 1)), constant_values=((0, 0), (-np.inf, np.inf)))
    before, behind = framed[rows, first], framed[rows, first + count + 1]
    sides = [np.maximum((before + low) / 2, low - NEARLY), np.minimum((behind + high) / 2, high + NEARLY)]
    return _Groups(rows, first, count, mean, np.stack(sides))


class _Meetings(NamedTuple):
    """Where pieces of two bars meet: rows, angles φ, points, whether they cross, and what is left between them."""

    rows: Array
    angle: Array
    point: Array
    crossing: Array
    gap: Array

    def pick(self, where: Array) -> _Meetings:
        return _Meetings(*(column[where] for column in self))


def _with_direction(piece: Array, size: Array) -> Array:
    """The two ends of a piece; a second point somewhere instead of an end that is the same as the other."""
    u = piece[:, 1] - piece[:, 0]
    point = np.sqrt(dot(u, u)) <= 1e-12 * size
    return np.stack([piece[:, 0], np.where(point, piece[:, 0] + SOMEWHERE[:, None] * size, piece[:, 1])], axis=1)


def _nearest_end(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """The end of one of two segments that is nearest to the other segment, and how near."""
    ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)]
    gaps = np.stack([distance(end, end, *other)[0] for end, *other in ends])
    which = gaps.argmin(axis=0)
    return np.choose(which, [end for end, *_ in ends]), gaps.min(axis=0)


def _middle_of_overlap(a: Array, b: Array, c: Array, d: Array) -> Array:
    """The middle of what two segments of one line share."""
    u, v = b - a, d - c
    longer = dot(u, u) >= dot(v, v)
    base, direction = np.where(longer, a, c), np.where(longer, u, v)
    square = np.where(dot(direction, direction) > 0, dot(direction, direction), 1.0)
    low, high = np.sort([dot(x - base, direction) / square for x in np.where(longer, (c, d), (a, b))], axis=0)
    return np.asarray(base + (np.maximum(low, 0.0) + np.minimum(high, 1.0)) / 2 * direction)


def _clusters(angles: Array, apart: float) -> tuple[Array, Array, Array]:
    """Ascending angles with those that may be one put together: their mean, their number, and where they begin.

    The mean of what rounding makes of a double root is exact up to rounding itself.
    """
    real = np.isfinite(angles)
    angles = np.where(real, angles, 8.0 + np.arange(angles.shape[-1]))
    new = np.diff(angles, axis=-1, prepend=-1.0) > apart
    number = np.cumsum(new, axis=-1)
    together = (number[:, :, None] == number[:, None, :]) * 1.0
    count = together.sum(axis=-1)
    return (together @ angles[..., None])[..., 0] / count, count.astype(int), new & real


def _each_once(found: Sequence[_Meetings], bars: MovingBars, pair: Pair, rtol: float) -> Found:
    """The collisions of two links: meetings between which the bars do not part are one.

    It is a crossing if the same pieces go through each other an odd number of times.
    """
    hits = _Meetings(*map(np.concatenate, zip(*found, strict=True)))
    piece = np.repeat(np.arange(len(found)), [len(part.rows) for part in found])
    angle = hits.angle % np.pi
    hits = hits._replace(angle=np.where(angle > np.pi - NEARLY, angle - np.pi, angle))
    order = np.lexsort((hits.angle, hits.rows))
    hits, piece = hits.pick(order), piece[order]
    number = np.cumsum(~_do_not_part(hits, bars, pair, rtol)) - 1
    count = number[-1] + 1 if len(number) else 0
    crossings = np.zeros((count, len(found)), dtype=int)
    np.add.at(crossings, (number, piece), hits.crossing)
    order = np.lexsort((hits.gap, number))
    best = hits.pick(order[np.unique(number, return_index=True)[1]])
    links = np.broadcast_to(sorted(pair[:2]), (count, 2))
    t = bars.pick(best.rows).parameter(best.angle)
    return Found(best.rows, t, links, best.point, (crossings % 2 == 1).any(axis=-1))


def _do_not_part(hits: _Meetings, bars: MovingBars, pair: Pair, rtol: float) -> Array:
    """Whether the bars stay together between each meeting and the one before it."""
    together = (np.diff(hits.rows, prepend=-1) == 0) & (np.diff(hits.angle, prepend=-np.inf) < NEARLY)
    later = np.flatnonzero(together)
    if len(later):
        some = bars.pick(hits.rows[later])
        between = (hits.angle[later] + hits.angle[later - 1]) / 2
        together[later] = some.distance(pair, between) <= rtol * some.size
    return together


# ---- clearance ---------------------------------------------------------------------------------------


def clearances(bars: MovingBars, joints: Sequence[int], rtol: float, enough: Array | None = None) -> Array:
    """The least distances of bars that share no joint, shape (rows,), over one full turn.

    Branch and bound: an interval of φ where no bar can come nearer than what was found elsewhere, less rtol times the
    size, is left out; the others are halved.  What was found is then improved.  Where the bars are known to meet there
    is nothing to search.  Where they come nearer than ``enough`` the result is some distance below that.
    """
    if enough is not None:
        return _clearances_above(bars, joints, rtol, enough)
    least = np.where(bars.defined, np.inf, np.nan)
    pairs = pairs_without_joint(joints)
    least[_meet(bars, joints)] = 0.0
    free = np.flatnonzero(least == np.inf)
    if pairs and len(free):
        least[free] = _Search(bars.pick(free), pairs, rtol).run()
    return least


def _meet(bars: MovingBars, joints: Sequence[int]) -> Array:
    """Which rows have bars that meet."""
    return np.asarray(collisions_in_floats(bars, joints, (len(bars.size),), degenerate="nan").count) > 0


def _clearances_above(bars: MovingBars, joints: Sequence[int], rtol: float, enough: Array) -> Array:
    """The same, the search first: it ends where a distance is below ``enough``, and few are left that may meet."""
    least = np.where(bars.defined, np.inf, np.nan)
    rows, pairs = np.flatnonzero(bars.defined), pairs_without_joint(joints)
    if pairs and len(rows):
        least[rows] = _Search(bars.pick(rows), pairs, rtol, enough[rows]).run()
    doubtful = np.flatnonzero((least >= enough) & (least <= 2 * rtol * bars.size))
    if len(doubtful):
        least[doubtful[_meet(bars.pick(doubtful), joints)]] = 0.0
    return least


START = 16
"""Into how many intervals the turn is first cut."""


class _Search:
    """What is known of the least distance, row by row."""

    def __init__(self, bars: MovingBars, pairs: Sequence[Pair], rtol: float, enough: Array | float = 0.0):
        self.bars, self.pairs, self.close = bars, pairs, rtol * bars.size
        self.enough = np.maximum(enough, RTOL * bars.size)
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
        keep = (bound < self.best[rows] - self.close[rows]) & (self.best[rows] > self.enough[rows])
        rows, angle = rows[keep], angle[keep]
        return number, np.repeat(rows, 2), (angle[:, None] + half / 2 * np.array([-1, 1])).reshape(-1), half / 2

    def _improve(self) -> None:
        """Narrow the place of the least distance by golden sections."""
        for number, pair in enumerate(self.pairs):
            rows = np.flatnonzero((self.who == number) & (self.best > self.enough))
            if len(rows):
                self.best[rows] = np.minimum(self.best[rows], self._narrowed(pair, rows))

    def _narrowed(self, pair: Pair, rows: Array) -> Array:
        bars, half = self.bars.pick(rows), 2 * self.half[rows]
        return narrowed(lambda angle: bars.distance(pair, angle), self.where[rows] - half, self.where[rows] + half)[1]
