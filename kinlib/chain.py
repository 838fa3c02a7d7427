"""Closed chains of revolute joints at one position: Denavit–Hartenberg rows, mobility, bars."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from kinlib.displacement import axis_of, half_turn
from kinlib.dual_quaternion import DualQuaternion, eps, i, k, one, study_form
from kinlib.errors import check_degenerate, named_rows
from kinlib.line import Line
from kinlib.poses import middle_of
from kinlib.projective import null_space
from kinlib.rows import broadcast
from kinlib.scalar import ROUNDING, RTOL, angle_of, as_float, is_exact, is_zero, root_of
from kinlib.shown import html_table as html_table
from kinlib.shown import in_words
from kinlib.tables import TableForm, as_table
from kinlib.typing import Array, ArrayLike, Degenerate, PointLike

__all__ = ["Chain", "DHRow"]

NEARLY_PARALLEL = 1e-8
"""Neighbouring axes with a smaller angle count as parallel: in floats they do not say where they are nearest."""

SMALLEST = 1e-15
"""Lengths below this come from rounding, whatever else is in the problem."""


class DHRow(NamedTuple):
    """Denavit–Hartenberg parameters of one link and the joint where it starts.

    Attributes
    ----------
    distance : float or array
        Length of the common perpendicular of the link's two axes, not negative.
    twist : float or array
        Angle from the first axis to the second, in radians, about the perpendicular that points to the second.
    offset : float or array
        On the first axis: from the perpendicular of the link before to that of this link.
    """

    distance: float | Array
    twist: float | Array
    offset: float | Array


class Lines(NamedTuple):
    """The axes of a chain in floats, seen from their middle: the point with the least sum of squared distances.

    Attributes
    ----------
    directions, points : array, shape (..., n, 3)
        Of length 1; nearest to the middle, and given from there.
    middle : array, shape (..., 3)
    length : array, shape (...)
        The distance of the farthest axis from the middle: the size of the chain, 0 if all axes meet.
    noise : array, shape (...)
        What rounding makes of a length, for axes as far from the origin as these.
    """

    directions: Array
    points: Array
    middle: Array
    length: Array
    noise: Array

    @classmethod
    def of(cls, axes: DualQuaternion) -> Lines:
        """The lines of half-turns, shape (..., n)."""
        coeffs = as_float(axes.coeffs)
        scale = np.linalg.norm(coeffs[..., 1:4], axis=-1, keepdims=True)
        directions, moments = coeffs[..., 1:4] / scale, coeffs[..., 5:8] / scale
        turns = [axes[..., n].astype(float) for n in range(axes.shape[-1])]
        middle = middle_of(turns, np.cross(directions, moments).mean(axis=-2), steps=3)
        points = np.cross(directions, moments - np.cross(middle[..., None, :], directions))
        length = np.linalg.norm(points, axis=-1).max(axis=-1)
        far = np.linalg.norm(moments, axis=-1).max(axis=-1)
        return cls(directions, points, middle, length, np.maximum(ROUNDING * far, SMALLEST))


class Perpendiculars(NamedTuple):
    """The common perpendicular of each axis and the next: its feet on both, its direction, its length.

    Attributes
    ----------
    start, end, direction : array, shape (..., n, 3)
        The feet are given from the middle of the chain.
    distance : array, shape (..., n)
    """

    start: Array
    end: Array
    direction: Array
    distance: Array


@dataclass(frozen=True, eq=False, repr=False)
class Chain:
    """A closed chain of revolute joints at one position: its axes, in loop order.

    Link n joins axis n and axis n + 1, counted from 1; the last link joins the last axis and the first.

    Parameters
    ----------
    axes : DualQuaternion, shape (..., n), or sequence of n half-turns or lines
        The half-turns l + εm about at least three axes; leading axes are a batch, NaN rows stay NaN.

    Raises
    ------
    ValueError
        If a dual quaternion is not a half-turn.

    Examples
    --------
    >>> square = Chain([k, k + eps * i, k + eps * i + eps * j, k + eps * j])      # hinges of a parallelogram
    >>> square.mobility(), [row.distance for row in square.denavit_hartenberg()]
    (1, [1.0, 1.0, 1.0, 1.0])
    """

    axes: DualQuaternion

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes", _as_axes(self.axes))

    @classmethod
    def from_denavit_hartenberg(
        cls,
        rows: Sequence[Sequence[ArrayLike]],
        angles: ArrayLike,
        *,
        rtol: float = RTOL,
        degenerate: Degenerate = "raise",
    ) -> Chain:
        """The chain with given rows and joint angles: the first axis is that of z, the last perpendicular that of x.

        Joint n turns by its angle about z and shifts by the offset along z; then its link shifts by the distance
        along x and turns by the twist about x.

        Parameters
        ----------
        rows : sequence of n triples (distance, twist, offset)
            As :meth:`denavit_hartenberg` gives them.
        angles : array_like, shape (..., n)
            As :meth:`angles` gives them, in radians.
        rtol : float
            How far the loop may be from closed: in radians, and relative to the longest distance or offset.
        degenerate : {"raise", "nan"}
            What to do about rows of a batch that do not close.

        Raises
        ------
        ValueError
            If the loop does not close; the message says how far off it is.

        Examples
        --------
        >>> from math import pi
        >>> rows = [DHRow(1.0, 0.0, 0.0)] * 4
        >>> Chain.from_denavit_hartenberg(rows, [pi / 2] * 4).mobility()
        1
        >>> Chain.from_denavit_hartenberg(rows, [1.5] * 4)
        Traceback (most recent call last):
        ...
        ValueError: the loop does not close: its end is turned by 0.283 and shifted by 0.207 against its start; \
give angles that close it, or rtol= if the numbers are rounded
        """
        table = _as_table(rows)
        turns = np.moveaxis(np.atleast_1d(as_float(angles)), -1, 0)
        if len(table) != len(turns):
            raise ValueError(f"expected as many angles as rows: got {len(turns)} angles and {len(table)} rows")
        steps = [_step(angle, *row) for angle, row in zip(turns, table, strict=True)]
        *frames, last = accumulate(steps, initial=one.astype(float), func=lambda frame, step: frame * step)
        shape = last.shape
        longest = np.max([np.abs(np.broadcast_to(row[part], shape)) for row in table for part in (0, 2)], axis=0)
        open_rows = _open_rows(last, longest, rtol, degenerate)
        axes = DualQuaternion.stack([broadcast(frame * k * frame.conjugate(), shape) for frame in frames], axis=-1)
        return cls(DualQuaternion(np.where(open_rows[..., None, None], np.nan, axes.coeffs)))

    @classmethod
    def wrap(cls, axes: DualQuaternion) -> Chain:
        """The chain of half-turns that are known to be such, unchecked."""
        self = object.__new__(cls)
        object.__setattr__(self, "axes", axes)
        return self

    @property
    def joint_count(self) -> int:
        """The number of joints, and of links."""
        return self.axes.shape[-1]

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch; ``()`` for a single chain."""
        return self.axes.shape[:-1]

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single chain has no length; the number of its joints is .joint_count")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Chain:
        """Entries of the batch, indexed as an array of shape ``self.shape``."""
        return Chain.wrap(self.axes[batch_index(index, self.shape, "chain")])

    def __iter__(self) -> Iterator[Chain]:
        return (self[n] for n in range(len(self)))

    def __repr__(self) -> str:
        return f"Chain of {self.joint_count} joints" + (f", shape {self.shape}" if self.shape else "")

    def __getstate__(self) -> dict[str, Any]:
        return {"axes": self.axes}  # what is computed from them is left behind

    def _repr_html_(self) -> str:
        """The table of a single chain; a batch as one line."""
        if self.shape:
            return f"<p>{self!r}</p>"
        return html_table(repr(self), ("joint", "angle", "offset", "distance", "twist"), self.table())

    def _repr_latex_(self) -> str | None:
        """The table of a single chain."""
        if self.shape:
            return None
        rows = r" \\ ".join(" & ".join(row).replace("°", r"^\circ") for row in self.table())
        return rf"$\begin{{array}}{{rrrrr}} n & \theta_n & d_n & a_n & \alpha_n \\ \hline {rows} \end{{array}}$"

    def table(self) -> list[tuple[str, ...]]:
        """The table of a single chain in words: number of the joint, angle, offset, distance, twist; in degrees."""
        least = max(RTOL * float(self.lines.length), float(self.lines.noise))
        angles = [_in_degrees(angle) for angle in self.angles()]
        return [
            (str(n), angle, in_words(row.offset, least), in_words(row.distance, least), _in_degrees(row.twist))
            for n, (row, angle) in enumerate(zip(self.denavit_hartenberg(), angles, strict=True), start=1)
        ]

    def table_text(self, form: TableForm) -> str:
        """The Denavit–Hartenberg table of a single chain as CSV, Markdown or LaTeX.

        CSV has all digits, angles in radians; :meth:`from_denavit_hartenberg` reads its columns back.  Markdown and
        LaTeX have six digits and angles in degrees, to be read.

        Parameters
        ----------
        form : {"csv", "markdown", "latex"}

        Examples
        --------
        >>> print(Chain([k, k + eps * i, k + eps * i + eps * j, k + eps * j]).table_text("markdown"))
        | joint | angle | offset | distance | twist |
        | --: | --: | --: | --: | --: |
        | 1 | 90° | 0 | 1 | 0° |
        | 2 | 90° | 0 | 1 | 0° |
        | 3 | 90° | 0 | 1 | 0° |
        | 4 | 90° | 0 | 1 | 0° |
        <BLANKLINE>
        """
        if self.shape:
            raise ValueError("expected a single chain: a batch has many tables, index it")
        if form == "latex":
            return as_table(form, ("$n$", r"$\theta_n$", "$d_n$", "$a_n$", r"$\alpha_n$"), self.table())
        if form != "csv":
            return as_table(form, ("joint", "angle", "offset", "distance", "twist"), self.table())
        rows = zip(self.denavit_hartenberg(), self.angles().tolist(), strict=True)
        numbers = [(n, angle, row.offset, row.distance, row.twist) for n, (row, angle) in enumerate(rows, start=1)]
        return as_table(form, ("joint", "angle", "offset", "distance", "twist"), numbers)

    @cached_property
    def lines(self) -> Lines:
        """The axes in floats, seen from their middle."""
        with np.errstate(invalid="ignore"):
            return Lines.of(self.axes)

    def mobility(self, *, rtol: float = RTOL) -> Any:
        """The degree of freedom at this position: the number of joints less the rank of the Plücker coordinates.

        Parameters
        ----------
        rtol : float
            Singular values below this, relative to the largest, count as zero: with n decimals in the input take
            10⁻ⁿ or so.  Lengths are measured by the chain itself.  Exact axes are judged exactly.

        Returns
        -------
        int, or array of int for a batch
            Of floats if there are NaN rows.

        Examples
        --------
        >>> Chain([i, j, k, i + j]).mobility()              # through one point
        1
        """
        if not is_exact(self.axes.components):
            return plain(count_or_nan(self.joint_count - self.rank(rtol)))
        lines = self.axes.coeffs[..., [1, 2, 3, 5, 6, 7]]
        free = [len(null_space(rows.T)) for rows in lines.reshape(-1, self.joint_count, 6)]
        return plain(np.reshape(free, self.shape))

    def rank(self, rtol: float = RTOL) -> Array:
        """The rank of the Plücker coordinates, in units of the chain's length; NaN in NaN rows."""
        directions, points, _, length, noise = self.lines
        unit_length = np.where(length > noise, length, np.inf)[..., None, None]  # axes that meet have no moments
        matrix = np.concatenate([directions, np.cross(points, directions) / unit_length], axis=-1)
        undefined = ~np.isfinite(matrix).all(axis=(-1, -2))
        singular = np.linalg.svd(np.where(undefined[..., None, None], 0.0, matrix), compute_uv=False)
        least = np.maximum(rtol, noise / unit_length[..., 0, 0])[..., None]
        return np.where(undefined, np.nan, (singular > least * singular[..., :1]).sum(axis=-1))

    def denavit_hartenberg(self) -> list[DHRow]:
        """One row a link, link n from axis n to axis n + 1 (counted from 1); floats, NaN in NaN rows.

        The rows and the :meth:`angles` rebuild the chain.  Where the two axes are parallel, within 10⁻⁸, any common
        perpendicular would do: the table takes the one through the foot of the perpendicular before it, so that
        the offset is 0.
        """
        directions, feet = self.lines.directions, self._perpendiculars
        twists, offsets = _twists_and_offsets(directions, feet.direction, feet.start, feet.end)
        columns = (feet.distance, np.where(twists < ROUNDING - np.pi, np.pi, twists), offsets)
        return [DHRow(*(plain(column[..., n]) for column in columns)) for n in range(self.joint_count)]

    def angles(self) -> Array:
        """The joint angles of the table: on axis n, from the perpendicular of the link before to that of link n.

        Returns
        -------
        numpy.ndarray, shape (..., n)
            In radians, from −π to π.

        Examples
        --------
        >>> chain = Chain([k, k + eps * i, k + eps * i + eps * j, k + eps * j])
        >>> (chain.angles() / np.pi).round(6).tolist()
        [0.5, 0.5, 0.5, 0.5]
        """
        normals = self._perpendiculars.direction
        return _angle_about(self.lines.directions, np.roll(normals, 1, axis=-2), normals)

    @cached_property
    def _perpendiculars(self) -> Perpendiculars:
        directions, points, _, length, noise = self.lines
        tiny = np.maximum(1e-12 * length, noise)[..., None]
        with np.errstate(invalid="ignore"):
            return _perpendiculars(directions, points, tiny)

    def bars(self, *, near: PointLike | None = None) -> Array:
        """The two ends of every link, on the axes that it joins.

        Link n joins the axes n and n + 1, counted from 1; in the array link 0, between the last and the first
        axis, comes first.  The ends are the feet of the common perpendicular.  Where these feet run far away, the
        bars go straight between points that lie close together.

        Parameters
        ----------
        near : array_like, shape (..., 3), optional
            A point that says where the bars are if the axes do not: where all axes are parallel, in the plane through
            this point; where all axes meet, as far from there as this point.  By default that distance is 1.

        Returns
        -------
        numpy.ndarray, shape (..., n, 2, 3)
            In units of length; NaN in NaN rows.

        Examples
        --------
        >>> Chain([k, k + eps * i, k + eps * i + eps * j, k + eps * j]).bars()[0].round(9).tolist()
        [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
        """
        return self._bars if near is None else self._bars_near(as_float(near) - self.lines.middle)

    @cached_property
    def _bars(self) -> Array:
        return self._bars_near(np.zeros((*self.shape, 3)))

    def _bars_near(self, near: Array) -> Array:
        """The bars, for a point that is given from the middle."""
        directions, points, middle, length, noise = self.lines
        radius = np.linalg.norm(near, axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            points = points + _dot(near[..., None, :], directions)[..., None] * directions
            points = _points_close_together(directions, points)
            sines = np.linalg.norm(np.cross(directions, directions[..., :1, :]), axis=-1)
            meet = (length <= np.maximum(noise, RTOL * radius)) & (sines.max(axis=-1) > NEARLY_PARALLEL)
            out = np.where(meet, np.where(radius > noise, radius, 1.0), 0.0)[..., None, None]
            points = np.where(meet[..., None, None], out * directions, points)
            straight = np.stack([np.roll(points, 1, axis=-2), points], axis=-2)
            feet = _feet(straight, directions)
            ratio = (_spread(feet) / _spread(straight))[..., None, None, None]
        bars = np.where((ratio > 1e-6) & (ratio <= 3), feet, straight) + middle[..., None, None, :]
        bars.setflags(write=False)
        return bars


# ---- input -------------------------------------------------------------------------------------------


def _as_axes(axes: DualQuaternion | Line | Sequence[DualQuaternion | Line]) -> DualQuaternion:
    """Half-turns about the axes of a chain, shape (..., n), checked and freed of what rounding has added."""
    if isinstance(axes, Line):
        axes = half_turn(axes)
    if not isinstance(axes, DualQuaternion):
        axes = _stacked(axes)
    if not axes.shape or axes.shape[-1] < 3:
        raise ValueError(f"expected at least three axes, as half-turns of shape (..., n), got shape {axes.shape}")
    if axes.components.dtype.kind == "c":
        raise ValueError("expected real axes, got complex ones")
    wrong = ~_are_half_turns(axes)
    if np.any(wrong):
        which = ", ".join(str(tuple(map(int, index))) for index in np.argwhere(wrong)[:5])
        raise ValueError(
            f"expected half-turns l + εm with m perpendicular to l; at {which} there is something else "
            "(axis_of gives the half-turn about the axis of a rotation)"
        )
    return axis_of(axes)


def _are_half_turns(axes: DualQuaternion) -> Array:
    """Whether p0 = d0 = l · m = 0, in floats up to rounding in a problem of this size; NaN is let through."""
    p0, d0 = axes.components[[0, 4]]
    if is_exact(axes.components):
        return is_zero(p0) & is_zero(d0) & is_zero(study_form(axes, axes))
    turning, shifting = _lengths(axes.components[1:4]), _lengths(axes.components[5:])
    shifting = shifting + turning * np.max(shifting / np.where(turning > 0, turning, 1), axis=-1, keepdims=True)
    fine = is_zero(p0, turning) & is_zero(d0, shifting) & is_zero(study_form(axes, axes), turning * shifting)
    return fine | np.isnan(turning + shifting)


def _stacked(items: Any) -> DualQuaternion:
    try:
        items = [half_turn(item) if isinstance(item, Line) else item for item in items]
    except TypeError:
        items = [items]
    if not items or not all(isinstance(item, DualQuaternion) for item in items):
        kinds = ", ".join(sorted({type(item).__name__ for item in items})) or "nothing"
        raise TypeError(f"expected the axes as DualQuaternion or Line, got {kinds}")
    return DualQuaternion.stack(items, axis=-1)


def _lengths(vector: Sequence[Array] | Array) -> Array:
    """The lengths of vectors given by components, in floats."""
    return np.sqrt(sum(as_float(x) ** 2 for x in vector))


def _as_table(rows: Any) -> list[tuple[Array, Array, Array]]:
    try:
        return [(as_float(distance), as_float(twist), as_float(offset)) for distance, twist, offset in rows]
    except (TypeError, ValueError):
        raise TypeError(f"expected rows of three numbers: distance, twist and offset, got {rows!r}") from None


def _step(angle: Array, distance: Array, twist: Array, offset: Array) -> DualQuaternion:
    """Turn about z and shift along z, then shift along x and turn about x."""
    about_z = (k * np.sin(angle / 2) + np.cos(angle / 2)) * (eps * k * (offset / 2) + 1.0)
    return about_z * (eps * i * (distance / 2) + 1.0) * (i * np.sin(twist / 2) + np.cos(twist / 2))


def _open_rows(last: DualQuaternion, longest: Array, rtol: float, degenerate: Degenerate) -> Array:
    """Which loops do not come back to their first frame."""
    check_degenerate(degenerate)
    p0, p1, p2, p3, *_ = last.components
    turned = 2 * np.arctan2(_lengths((p1, p2, p3)), np.abs(p0))
    shifted = 2 * _lengths((last.dual * last.primal.conjugate()).components[1:4])
    wrong = np.asarray((turned > rtol) | (shifted > rtol * longest + ROUNDING * (longest == 0)))
    if degenerate == "raise" and wrong.any():
        row, words = first_row(wrong)
        raise ValueError(
            f"{words}the loop does not close: its end is turned by {turned[row]:.3g} and shifted by "
            f"{shifted[row]:.3g} against its start; give angles that close it, or rtol= if the numbers are rounded"
        )
    return wrong


# ---- words -------------------------------------------------------------------------------------------


def _in_degrees(angle: Any) -> str:
    return in_words(math.degrees(angle), 1e-9) + "°"


# ---- shapes ------------------------------------------------------------------------------------------


def first_row(wrong: Array) -> tuple[tuple[int, ...], str]:
    """The index of the first row of a batch where something is wrong, and words that name all of them."""
    row = tuple(int(n) for n in np.unravel_index(wrong.argmax(), wrong.shape))
    return row, named_rows(np.flatnonzero(wrong).tolist() if wrong.ndim else [])


def batch_index(index: Any, shape: tuple[int, ...], name: str) -> tuple[Any, ...]:
    """An index of a batch, completed to one of an array with more axes behind those of the batch."""
    index = index if isinstance(index, tuple) else (index,)
    if not shape and any(part is not Ellipsis for part in index):
        raise TypeError(f"a single {name} has no entries")
    return index if any(part is Ellipsis for part in index) and not shape else (*index, *_rest(index))


def _rest(index: tuple[Any, ...]) -> tuple[Any, ...]:
    return (slice(None),) if any(part is Ellipsis for part in index) else (Ellipsis, slice(None))


def plain(values: Array) -> Any:
    """A Python number for a single chain, an array for a batch."""
    return np.asarray(values).item() if np.ndim(values) == 0 else values


def count_or_nan(values: Array) -> Array:
    """Whole numbers as integers, unless there is NaN among them."""
    return values if np.isnan(values).any() else values.astype(int)


# ---- geometry ----------------------------------------------------------------------------------------


def _dot(x: Array, y: Array) -> Array:
    return (x * y).sum(axis=-1)


def _angle_about(axis: Array, x: Array, y: Array) -> Array:
    """The angle from x to y about an axis of length 1, from −π to π."""
    return angle_of(_dot(np.cross(x, y), axis), _dot(x, y))


def link_columns(directions: Array, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """Distances, twists and offsets of links with given ends, for any scalars.

    Parameters
    ----------
    directions : array, shape (n, 3)
        Of the axes, of length 1.
    start, end : array, shape (n, 3)
        The feet of the common perpendicular of each axis and the next, which differ.
    """
    way = end - start
    distance = root_of(_dot(way, way))
    return distance, *_twists_and_offsets(directions, way / distance[..., None], start, end)


def _twists_and_offsets(directions: Array, normals: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """The angle of each axis and the next about their normal, and what lies between two feet on each axis."""
    twists = _angle_about(normals, directions, np.roll(directions, -1, axis=-2))
    return twists, _dot(start - np.roll(end, 1, axis=-2), directions)


def _perpendiculars(directions: Array, points: Array, tiny: Array) -> Perpendiculars:
    """The common perpendiculars; shorter than ``tiny`` counts as no length, so that rounding gives no direction."""
    after, beyond = np.roll(directions, -1, axis=-2), np.roll(points, -1, axis=-2)
    normal, gap = np.cross(directions, after), beyond - points
    sine = np.linalg.norm(normal, axis=-1)
    parallel = sine <= NEARLY_PARALLEL
    sine = np.where(parallel, 1.0, sine)[..., None]
    normal = normal / sine
    start = points + (_dot(np.cross(gap, after), normal)[..., None] / sine) * directions
    end = beyond + (_dot(np.cross(gap, directions), normal)[..., None] / sine) * after
    along = _dot(gap, normal)
    found = Perpendiculars(start, end, np.where((along < -tiny)[..., None], -normal, normal), np.abs(along))
    return _through_previous_feet(found, directions, points, parallel, tiny) if parallel.any() else found


def _through_previous_feet(
    found: Perpendiculars, directions: Array, points: Array, parallel: Array, tiny: Array
) -> Perpendiculars:
    """For parallel neighbours the perpendicular through the foot of the one before; twice around finds them all."""
    start, end, direction, distance = (np.array(part) for part in found)
    count = parallel.shape[-1]
    for n in (*range(count), *range(count)):
        here, following = directions[..., n, :], (n + 1) % count
        foot, line = end[..., n - 1, :], directions[..., following, :]
        opposite = points[..., following, :]
        opposite = opposite + _dot(foot - opposite, line)[..., None] * line
        across = opposite - foot
        across = across - _dot(across, here)[..., None] * here
        length = np.linalg.norm(across, axis=-1)
        kept = _perpendicular_to(here, direction[..., n - 1, :])
        unit_across = across / np.where(length > 0, length, 1.0)[..., None]
        normal = np.where((length > tiny[..., 0])[..., None], unit_across, kept)
        for part, value in ((start, foot), (end, opposite), (direction, normal)):
            part[..., n, :] = np.where(parallel[..., n, None], value, part[..., n, :])
        distance[..., n] = np.where(parallel[..., n], length, distance[..., n])
    return Perpendiculars(start, end, direction, distance)


def _perpendicular_to(line: Array, wish: Array) -> Array:
    """A unit vector perpendicular to a line's direction: the wish, made so, or any if that has no such part."""
    any_other = np.eye(3)[np.abs(np.nan_to_num(line)).argmin(axis=-1)]
    usable = np.linalg.norm(np.cross(line, wish), axis=-1, keepdims=True) > 0.5
    vector = np.where(usable, wish, any_other)
    vector = vector - _dot(vector, line)[..., None] * line
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def _points_close_together(directions: Array, points: Array) -> Array:
    """One point on every axis, so that the sum of the squared distances around the loop is least."""
    count = points.shape[-2]
    sides = np.eye(count) - np.roll(np.eye(count), 1, axis=1)
    system = np.einsum("ij,...jc->...icj", sides, directions).reshape(*points.shape[:-2], 3 * count, count)
    right = -(sides @ points).reshape(*points.shape[:-2], 3 * count, 1)
    return points + _least_squares(system, right) * directions


def _least_squares(system: Array, right: Array) -> Array:
    """The shortest of the best solutions; where the normal equations would lose digits, by singular values."""
    undefined = ~np.isfinite(system).all(axis=(-1, -2), keepdims=True)
    system = np.where(undefined, 0.0, system)
    transposed = np.swapaxes(system, -1, -2)
    values, vectors = np.linalg.eigh(transposed @ system)
    poor = values[..., 0] <= 1e-4 * values[..., -1]
    values = np.where(poor[..., None], 1.0, values)[..., None]
    solution = vectors @ (np.swapaxes(vectors, -1, -2) @ (transposed @ right) / values)
    if poor.any():
        solution[poor] = np.linalg.pinv(system[poor], rcond=RTOL) @ right[poor]
    return solution


def _feet(ends: Array, directions: Array) -> Array:
    """The feet of the common perpendicular of each axis and the one before; near the given ends if parallel."""
    before, here = np.roll(directions, 1, axis=-2), directions
    gap, normal = ends[..., 1, :] - ends[..., 0, :], np.cross(before, here)
    square = _dot(normal, normal)
    parallel = np.sqrt(square) <= 1e-7
    square = np.where(parallel, 1.0, square)
    first = np.where(parallel, _dot(gap, before) / 2, _dot(np.cross(gap, here), normal) / square)
    second = np.where(parallel, -_dot(gap, here) / 2, _dot(np.cross(gap, before), normal) / square)
    return ends + np.stack([first[..., None] * before, second[..., None] * here], axis=-2)


def _spread(points: Array) -> Array:
    """How far points, shape (..., n, 2, 3), are from their mean."""
    return np.linalg.norm(points - points.mean(axis=(-3, -2), keepdims=True), axis=-1).max(axis=(-2, -1))
