"""Linkages: closed chains of revolute joints with their rational motion, driven by one parameter t."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from dataclasses import InitVar, dataclass, field
from fractions import Fraction
from functools import cached_property, reduce
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from kinlib.bonds import Bond, bonds_of, degrees_of
from kinlib.chain import Chain, DHRow, batch_index, count_or_nan, first_row, html_table, plain
from kinlib.closing import closing_angles
from kinlib.collision import (
    CollisionFault,
    Collisions,
    checked_bars,
    clearances,
    collisions_in_floats,
    listed_collisions,
)
from kinlib.displacement import act, axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, null_form, one, study_form
from kinlib.errors import DegenerateError, check_degenerate, report_faults
from kinlib.exact_collision import exact_bars, exact_collisions
from kinlib.factorization import divide_by_quadratic, quadratic_of
from kinlib.line import Line
from kinlib.loop_motion import motion_of_axes
from kinlib.motion_polynomial import MotionPolynomial, RationalCurve, evaluate
from kinlib.moving_bars import MovingBars
from kinlib.polishing import product_of
from kinlib.poses import as_pose
from kinlib.projective import null_space
from kinlib.rows import broadcast
from kinlib.scalar import ROUNDING, RTOL, as_float, as_scalars, is_exact, is_zero, size
from kinlib.typing import Array, ArrayLike, Degenerate, PointLike, PoseLike, ScalarLike

__all__ = ["Linkage"]

CLOSED = 1e-7
"""How far floats may be from closed: next to degenerate places half of their digits are gone."""

_ROUNDED = " (rtol= accepts rounded numbers)"

SAMPLES = (0.37, -1.71, 3.3, -0.59, 0.11)
"""Where the mobility of a motion is looked at, from the middle of its parameters and in units of their spread."""


@dataclass(frozen=True, eq=False, repr=False)
class Linkage:
    """A closed chain of revolute joints with the motion of its links.

    Joint n turns about its axis by a product of linear factors t − f; the product of all factors around the
    loop is a real polynomial, so the loop is closed for all t.  Link 0 is the base; link n sits between joint n
    and joint n + 1, counted from 1.  A loop that does not close is refused.

    Parameters
    ----------
    factors : sequence of DualQuaternion, each of shape (...)
        The f of all linear factors in loop order.  NaN rows of a batch stay NaN.
    joints : sequence of int
        How many consecutive factors share an axis, joint by joint.
    coupler : int
        The number of the link whose motion was asked for.
    home : pose
        The pose of the coupler at t = ∞.
    parameters : tuple
        The parameter values at which the coupler is in the poses from which the linkage was made.
    rtol : float
        How far floats may be from closed, see :meth:`closure_residual`; exact factors must close exactly.

    Raises
    ------
    ValueError
        If the loop does not close; the message gives the residual and the rows.

    Examples
    --------
    >>> from kinlib import bennett_flip
    >>> h1, h2 = i, 2 * j - 2 * eps * i
    >>> loop = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
    >>> loop
    Linkage 4R, coupler 2
    >>> loop.closure_residual(), loop.mobility(), loop.joint_count
    (0.0, 1, 4)
    """

    factors: Sequence[DualQuaternion]
    joints: Sequence[int]
    coupler: int
    home: DualQuaternion = field(default_factory=lambda: one)
    parameters: tuple[Any, ...] = ()
    rtol: InitVar[float] = CLOSED

    def __post_init__(self, rtol: float) -> None:
        self._set(_as_factors(self.factors), self.joints, self.coupler, _as_home(self.home), self.parameters)
        self._check_turns(max(rtol, CLOSED))
        self._check_closure(rtol)

    def _set(
        self, factors: Sequence[DualQuaternion], joints: Any, coupler: Any, home: DualQuaternion, parameters: Any
    ) -> None:
        joints = tuple(_whole(count, "joints as whole numbers of factors") for count in _as_tuple(joints, "joints"))
        coupler, parameters = _whole(coupler, "the coupler as a whole number"), _as_tuple(parameters, "parameters")
        if min(joints, default=0) < 1 or sum(joints) != len(factors):
            raise ValueError(f"expected joints with {len(factors)} factors in all, at least 1 each, got {joints}")
        if not 0 < coupler < len(joints):
            raise ValueError(f"expected the coupler among links 1, …, {len(joints) - 1}, got {coupler}")
        as_scalars([t for t in parameters if not np.ndim(t)])
        for name, value in {"factors": tuple(factors), "joints": joints, "coupler": coupler, "home": home}.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "parameters", parameters)

    @classmethod
    def from_chains(
        cls,
        first: Sequence[DualQuaternion],
        second: Sequence[DualQuaternion],
        *,
        home: PoseLike = one,
        joints: Sequence[int] | None = None,
        parameters: Sequence[ScalarLike | Array] = (),
        rtol: float = CLOSED,
    ) -> Linkage:
        """Close the loop of two chains (t − h_1) ⋯ (t − h_m) = (t − k_1) ⋯ (t − k_n) that carry the same coupler.

        Parameters
        ----------
        first, second : sequences of DualQuaternion
            The factors from the base to the coupler, with equal products.
        home : pose
            The pose of the coupler at t = ∞.
        joints : sequence of int, optional
            How many factors share an axis; by default each has its own.
        parameters : tuple
            Where the coupler is in given poses.
        rtol : float
            How far floats may be from closed.
        """
        return cls(*_loop(first, second, joints), _as_home(home), _as_tuple(parameters, "parameters"), rtol)

    @classmethod
    def from_axes(
        cls,
        axes: DualQuaternion | Line | Chain | Sequence[DualQuaternion | Line],
        *,
        coupler: int | None = None,
        home: PoseLike = one,
        rtol: float = CLOSED,
        degenerate: Degenerate = "raise",
    ) -> Linkage:
        """The linkage with given axes, in loop order at t = ∞: its motion follows from them.

        It is found by linear systems, if all joints but at most one turn once.  The parameter is such that the
        first joint that turns once has the factor t − h, with h the half-turn about its axis.  The :attr:`axes` of the
        linkage are oriented by their first factors, whichever orientation was given.

        Parameters
        ----------
        axes : DualQuaternion or Line of shape (..., n), sequence of n half-turns or lines, or Chain
            Four, five or six axes; exact axes give an exact linkage.
        coupler : int, optional
            The number of the link whose motion is asked for; by default opposite link 0.
        home : pose
            The pose of the coupler's frame in the position in which the axes are given.
        rtol : float
            How far the loop may be from closed; with n decimals in the axes take 10⁻ⁿ or so.
        degenerate : {"raise", "nan"}
            What becomes of rows of a batch that do not move, or not in this way.

        Raises
        ------
        DegenerateError
            Saying whether the chain is rigid, mobile only infinitesimally or in another way, or at a singular position.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> k1, k2 = bennett_flip(h1, h2)
        >>> Linkage.from_axes([h1, h2, k2, k1]).closure_residual()
        0.0
        >>> Linkage.from_axes([h1, h2, k2, j + eps * k])
        Traceback (most recent call last):
        ...
        kinlib.errors.DegenerateError: the axes are independent: the chain is rigid
        """
        chain = axes if isinstance(axes, Chain) else Chain(axes)  # type: ignore[arg-type]
        factors, joints = motion_of_axes(chain, rtol=rtol, degenerate=degenerate)
        return verified_linkage(factors, joints, len(joints) // 2 if coupler is None else coupler, _as_home(home))

    @classmethod
    def from_denavit_hartenberg(
        cls,
        rows: Sequence[Sequence[ArrayLike]],
        *,
        angle: float,
        joint: int = 0,
        coupler: int | None = None,
        home: PoseLike = one,
        rtol: float = CLOSED,
    ) -> Linkage:
        """The linkage of a table of Denavit–Hartenberg rows, at a position where one joint has a given angle.

        Distances, twists and offsets fix no position, and not always one linkage: the angle has to choose.  Of the
        positions that close the loop the first is taken from which the linkage moves.

        Parameters
        ----------
        rows : sequence of n triples (distance, twist, offset)
            As :meth:`denavit_hartenberg` gives them; numbers, for a single linkage.
        angle : float
            The angle of one joint at t = ∞, as :meth:`Chain.angles <kinlib.Chain.angles>` counts it, in radians.
        joint : int
            The number of that joint, from 0.
        coupler, home, rtol
            As in :meth:`from_axes`.

        Raises
        ------
        ValueError
            If the loop does not close at this angle.
        DegenerateError
            If it closes, but no position belongs to a motion that is found.

        Examples
        --------
        >>> from math import pi
        >>> rows = [(1, pi / 6, 0), (2, pi / 2, 0)] * 2                  # 1 / sin 30° = 2 / sin 90°
        >>> Linkage.from_denavit_hartenberg(rows, angle=1.0)
        Linkage 4R, coupler 2
        """
        joint = _whole(joint, "the joint as a whole number")
        if not 0 <= joint < len(rows):
            raise ValueError(f"expected a joint among 0, …, {len(rows) - 1}, got {joint}")
        table = as_float(as_scalars(rows))
        if table.shape[1:] != (3,) or not np.isfinite(table).all() or not np.isfinite(angle):
            raise ValueError(f"expected finite rows (distance, twist, offset) and an angle, got {rows!r} and {angle!r}")
        found = closing_angles([tuple(row) for row in table.tolist()], float(angle), joint, rtol=rtol)
        if not found:
            raise ValueError(f"no position was found in which the loop closes and joint {joint} has the angle {angle}")
        error: DegenerateError | None = None
        for angles in found:
            chain = Chain.from_denavit_hartenberg(rows, angles, rtol=max(10 * rtol, RTOL))
            try:
                return cls.from_axes(chain, coupler=coupler, home=home, rtol=rtol)
            except DegenerateError as refused:
                error = error or refused
        raise DegenerateError(f"the loop closes at this angle in {len(found)} ways, but {error}")

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch; ``()`` for a single linkage."""
        return np.broadcast_shapes(*[q.shape for q in (*self.factors, self.home)], *map(np.shape, self.parameters))

    @property
    def joint_count(self) -> int:
        """The number of joints, and of links."""
        return len(self.joints)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single linkage has no length; the number of its joints is .joint_count")
        return self.shape[0]

    def __getitem__(self, index: Any) -> Linkage:
        """Entries of the batch, indexed as an array of shape ``self.shape``."""
        where = batch_index(index, self.shape, "linkage")[:-1]
        pick = [broadcast(f, self.shape)[where] for f in (*self.factors, self.home)]
        parameters = tuple(np.broadcast_to(t, self.shape)[where][()] for t in self.parameters)
        return verified_linkage(pick[:-1], self.joints, self.coupler, pick[-1], parameters)

    def __iter__(self) -> Iterator[Linkage]:
        return (self[n] for n in range(len(self)))

    def astype(self, dtype: Any) -> Linkage:
        """The same linkage with numbers of another kind, such as ``float``."""
        factors, home = [f.astype(dtype) for f in self.factors], self.home.astype(dtype)
        parameters = tuple(np.asarray(t).astype(dtype)[()] for t in self.parameters)
        return verified_linkage(factors, self.joints, self.coupler, home, parameters)

    def __repr__(self) -> str:
        parts = [f"Linkage {self.joint_count}R" + (f" of shape {self.shape}" if self.shape else "")]
        parts += [f"joint {n} with {count} factors" for n, count in enumerate(self.joints, start=1) if count > 1]
        parts += [f"coupler {self.coupler}"]
        return ", ".join(parts + [f"poses at {_listed(self.parameters)}"] * bool(self.parameters))

    def _repr_html_(self) -> str:
        """Links, joints and poses as a table; a batch as one line."""
        if self.shape:
            return f"<p>{self!r}</p>"
        head = ("joint", "angle at home", "offset", "distance", "twist", "factors", "link after it")
        table = zip(self.chain.table(), self.joints, strict=True)
        rows = [(*row, count, n % self.joint_count) for n, (row, count) in enumerate(table, start=1)]
        return html_table(repr(self), head, rows)

    def _repr_latex_(self) -> str | None:
        """The table of the chain at home."""
        return self.chain._repr_latex_()

    def __getstate__(self) -> dict[str, Any]:
        names = ("factors", "joints", "coupler", "home", "parameters")
        return {name: self.__dict__[name] for name in names}  # what is computed from them is left behind

    def joint_factors(self, joint: int) -> Sequence[DualQuaternion]:
        """The factors of joint number 0, 1, …, all about one axis."""
        start = sum(self.joints[:joint])
        return self.factors[start : start + self.joints[joint]]

    # ---- the chain -----------------------------------------------------------------------------------

    @cached_property
    def axes(self) -> DualQuaternion:
        """The half-turns about the axes in loop order at t = ∞, in the fixed frame; shape (..., n)."""
        axes = [axis_of(self.joint_factors(n)[0]) for n in range(self.joint_count)]
        return DualQuaternion.stack([broadcast(h, self.shape) for h in axes], axis=-1)

    @cached_property
    def chain(self) -> Chain:
        """The closed chain of the axes at home, t = ∞."""
        return Chain.wrap(self.axes)

    def at(self, t: ArrayLike) -> Chain:
        """The closed chain of the axes at t, which broadcasts against the batch."""
        return Chain.wrap(self.configuration(t))

    def denavit_hartenberg(self) -> list[DHRow]:
        """One row a link, link n from axis n to axis n + 1 (counted from 1), the same at all t; floats.

        See :meth:`Chain.denavit_hartenberg <kinlib.Chain.denavit_hartenberg>`.
        """
        return self.chain.denavit_hartenberg()

    @cached_property
    def _bars(self) -> Array:
        return self.chain.bars(near=as_float(act(self.home, [0, 0, 0])))

    def bars(self) -> Array:
        """The two ends of every link at home, link 0 first, shape (..., n, 2, 3), in units of length.

        See :meth:`Chain.bars <kinlib.Chain.bars>`; what the axes leave free goes by the origin of the coupler's frame.
        """
        return self._bars

    # ---- the motion ----------------------------------------------------------------------------------

    @cached_property
    def coupler_motion(self) -> MotionPolynomial:
        """The motion of the coupler's frame, which visits the given poses."""
        first = self.factors[: sum(self.joints[: self.coupler])]
        return MotionPolynomial.from_factors(first, self.home)

    def coupler_curve(self, point: PointLike) -> RationalCurve:
        """The path of a point, shape (3,), of the coupler's frame."""
        return self.coupler_motion.trajectory(point)

    def link_displacements(self, t: ArrayLike) -> DualQuaternion:
        """The displacements of all links from t = ∞ to t; shape (..., n), t broadcasts against the batch."""
        t = as_scalars(t)[()]
        turns = [_turn(self.joint_factors(n), t) for n in range(self.joint_count - 1)]
        links = accumulate(turns, lambda link, turn: unit(link * turn), initial=self._identity)
        shape = np.broadcast_shapes(self.shape, np.asarray(t).shape)
        return DualQuaternion.stack([broadcast(link, shape) for link in links], axis=-1)

    @property
    def _identity(self) -> DualQuaternion:
        """The identity, in scalars of the linkage's kind; NaN in NaN rows."""
        return broadcast(self.factors[0] * 0 + 1, self.shape)

    def configuration(self, t: ArrayLike) -> DualQuaternion:
        """The half-turns about all axes at t; shape (..., n)."""
        links = self.link_displacements(t)
        return unit(links * self.axes * links.conjugate())

    def joint_angles(self, t: ArrayLike) -> Array:
        """The angles that the joints have turned from t = ∞ (+∞ and −∞ differ by one round); radians, (..., n).

        The factor t − f turns by −2 arccot((t − Re f)/|Im f|), so the angles are continuous in t.
        """
        t = as_float(as_scalars(t))
        angles = [self._angle(n, t) for n in range(self.joint_count)]
        return np.stack(np.broadcast_arrays(*angles), axis=-1)

    def _angle(self, joint: int, t: Array) -> Array:
        factors = [f.astype(float) for f in self.joint_factors(joint)]
        axis = axis_of(factors[0])
        return sum(-2 * np.arctan2(null_form(f, axis), t - f.scalar_part) for f in factors)

    def relative_motion(self, a: int, b: int) -> MotionPolynomial:
        """The motion of link b as seen from link a, with common real factors taken out.

        Parameters
        ----------
        a, b : int
            Numbers of links, counted on round the loop.
        """
        count = self.joint_count
        ahead = _whole(b - a, "links as whole numbers") % count
        back = -ahead % count
        if ahead == 0:
            return MotionPolynomial.from_coefficients([self._identity])
        if ahead <= back:
            return self._reduced_product(self._between(a, ahead))
        return self._reduced_product(self._between(b, back)).conjugate()

    def _between(self, link: int, steps: int) -> list[int]:
        """The numbers of the factors from a link on, over so many joints."""
        starts = [0, *accumulate(self.joints)]
        joints = [(link + n) % self.joint_count for n in range(steps)]
        return [n for joint in joints for n in range(starts[joint], starts[joint + 1])]

    def _reduced_product(self, numbers: Sequence[int]) -> MotionPolynomial:
        """The product of some factors, divided by each quadratic (t − f)(t − f̄) that divides it."""
        factors = [broadcast(self.factors[n], self.shape) for n in numbers]
        judged = factors if self._is_exact else [self._centred.factors[n] for n in numbers]
        coefficients, seen = product_of(factors), product_of(judged)
        for f, g in zip(factors, judged, strict=True):
            if len(seen) < 3:
                break
            quotient, remainder = divide_by_quadratic(seen, quadratic_of(g))
            if _negligible(remainder, seen):
                seen, coefficients = quotient, divide_by_quadratic(coefficients, quadratic_of(f))[0]
        return MotionPolynomial.from_coefficients(coefficients)

    def mobility(self, t: ArrayLike | None = None, *, rtol: float = RTOL) -> Any:
        """The degree of freedom: of the motion, or at one position of it.

        Parameters
        ----------
        t : scalar or array, optional
            Where to ask for the instantaneous mobility, the number of joints less the rank of the axes' Plücker
            coordinates.  Without it, the least over general t.
        rtol : float
            What counts as zero among singular values, see :meth:`Chain.mobility <kinlib.Chain.mobility>`.

        Returns
        -------
        int, or array of int for a batch
            Of floats if there are NaN rows.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> loop = Linkage.from_chains([k, 2 * i + 2 * eps * k], bennett_flip(k, 2 * i + 2 * eps * k))
        >>> loop.mobility(), loop.mobility(0)
        (1, 1)
        """
        if t is not None:
            return self.at(t).mobility(rtol=rtol)
        bound = min(6, self.joint_count - 1)  # the joints do turn, so their axes are dependent
        if self._is_exact:
            rows = [_exact_rank(self[index], bound, rtol) for index in np.ndindex(self.shape)]
            return plain(self.joint_count - np.reshape(rows, self.shape))
        return plain(count_or_nan(self.joint_count - self._general_rank(bound, rtol)))

    def _general_rank(self, bound: int, rtol: float) -> Array:
        """The largest rank of the axes' Plücker coordinates over some general t, at most the bound."""
        rank = np.full(self.shape, -1)
        for t in self._samples():
            rank = np.fmin(np.maximum(rank, self.at(t).rank(rtol)), bound)  # NaN stays where the axes are NaN
            rank = np.where(np.isnan(self.chain.lines.length), np.nan, rank)
            if np.all((rank == bound) | np.isnan(rank)):
                break
        return rank

    def _samples(self) -> list[Array]:
        """General values of t, neither bunched together nor far from where the motion turns."""
        return [self._centred.middle + self._centred.spread * x for x in SAMPLES]

    # ---- bars that meet ------------------------------------------------------------------------------

    def collisions(
        self, bars: ArrayLike | None = None, *, rtol: float = RTOL, degenerate: Degenerate = "raise"
    ) -> Collisions:
        """Where two bars of links that share no joint meet: each parameter t, the links, the point, whether they cross.

        The lines of two bars meet where a polynomial in t vanishes.  An exact linkage over ℚ gets its roots and all
        decisions exactly, an irrational t as the generator of its field; t = ∞ is no exception.

        Parameters
        ----------
        bars : array_like, shape (..., n, m, 3), optional
            The m points of each link's bar at home, m = 2 for straight ones: the first and the last on the axes that
            the link joins, link 0 first, as :meth:`bars` gives them.  By default those, exact for an exact linkage.
        rtol : float
            In floats, bars that come nearer than this, in units of their size, count as meeting; and roots that are
            within 10⁻⁴ of a turn count as one.
        degenerate : {"raise", "nan"}
            What to do about bars that always lie in one plane, as those of a planar linkage do.

        Raises
        ------
        DegenerateError
            If two bars always lie in one plane: they meet over intervals of t.
        ValueError
            If a bar does not end on its axes; if an exact linkage needs irrational numbers (use floats).

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> bennett_linkage(*gallery.THREE_POSES).collisions()
        2 collisions
          t = 0, links 0 and 2 touch at (-1.33333, 0, 0)
          t = ∞, links 0 and 2 touch at (-0.333333, 0, 0)
        """
        check_degenerate(degenerate)
        if self._is_exact and (bars is None or is_exact(as_scalars(bars))):
            return self._exact_collisions(bars, degenerate)
        moving = self._moving_bars(bars)
        return collisions_in_floats(moving[0], self.joints, moving[1], rtol=rtol, degenerate=degenerate)

    def clearance(self, bars: ArrayLike | None = None, *, rtol: float = 1e-3) -> Any:
        """The least distance that two bars of links that share no joint come to, over the whole motion; in floats.

        Found by branch and bound over one full turn: how fast the joints turn at most says how fast a distance can
        change.  So the true least distance is not less than the result by more than rtol times the size of the
        bars, but for rounding; 0 if they meet, ∞ if all links share joints.

        Parameters
        ----------
        bars : array_like, shape (..., n, m, 3), optional
            As in :meth:`collisions`.
        rtol : float
            How much nearer the bars may come than the result says, in units of their size: the largest distance of
            their points from the middle of all.

        Returns
        -------
        float, or array of shape (...)
            NaN in NaN rows.

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> bennett_linkage(*gallery.THREE_POSES).clearance()
        0.0
        """
        if not rtol > 0:
            raise ValueError(f"expected a positive rtol, got {rtol!r}")
        moving, shape = self._moving_bars(bars)
        return plain(clearances(moving, self.joints, rtol).reshape(shape))

    def _moving_bars(self, bars: ArrayLike | None) -> tuple[MovingBars, tuple[int, ...]]:
        """The bars in motion, and the shape of their batch."""
        points = as_float(self.bars() if bars is None else checked_bars(bars, self.chain.lines))
        shape = np.broadcast_shapes(self.shape, points.shape[:-3])
        points = np.broadcast_to(points, (*shape, *points.shape[-3:]))
        return MovingBars.of([broadcast(f, shape) for f in self.factors], self.joints, points), shape

    def _exact_collisions(self, bars: ArrayLike | None, degenerate: Degenerate) -> Collisions:
        given = None if bars is None else checked_bars(bars, self.chain.lines)
        shape = np.broadcast_shapes(self.shape, () if given is None else given.shape[:-3])
        hits, faults = [], np.zeros(shape, dtype=int)
        for index in np.ndindex(shape):
            factors = [broadcast(f, shape)[index] for f in self.factors]
            if given is None:
                points = exact_bars(self.axes[index], self.bars()[index])
            else:
                points = np.broadcast_to(given, (*shape, *given.shape[-3:]))[index]
            found = exact_collisions(factors, self.joints, points)
            faults[index] = 0 if found is not None else CollisionFault.IN_A_PLANE
            hits.append(found or [])
        bad = report_faults(faults, CollisionFault, degenerate)
        return listed_collisions(hits, shape, bad.reshape(-1))

    # ---- the bonds -----------------------------------------------------------------------------------

    def bonds(self) -> tuple[Bond, ...]:
        """The pairs of joints that are bonded: those whose factors share a quadratic polynomial.

        Returns
        -------
        tuple of Bond
            With the numbers of two joints, from 0, and their quadratic polynomial.  For a batch all rows must be
            bonded alike, and its shape is that of the polynomials.

        Raises
        ------
        ValueError
            If the rows of a batch have different bonds.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> [bond.joints for bond in Linkage.from_chains([h1, h2], bennett_flip(h1, h2)).bonds()]
        [(0, 2), (1, 3)]
        """
        rows = [
            bonds_of([broadcast(f, self.shape)[index] for f in self.factors] if index else self.factors, self.joints)
            for index in np.ndindex(self.shape)
            if not _undefined(broadcast(self._identity, self.shape))[index]
        ]
        if any([bond.joints for bond in row] != [bond.joints for bond in rows[0]] for row in rows):
            raise ValueError("the rows of the batch have different bonds: ask each row, or rows that are alike")
        return rows[0] if rows and not self.shape else self._stacked_bonds(rows)

    def _stacked_bonds(self, rows: Sequence[tuple[Bond, ...]]) -> tuple[Bond, ...]:
        """The bonds of a batch, with NaN in NaN rows."""
        defined = ~np.asarray(_undefined(broadcast(self._identity, self.shape)))
        stacked = []
        for bonds in zip(*rows, strict=True):
            quadratic = np.full(
                (*self.shape, 3), np.nan, dtype=float if not defined.all() else bonds[0].quadratic.dtype
            )
            quadratic[defined] = [bond.quadratic for bond in bonds]
            stacked.append(Bond(bonds[0].joints, quadratic))
        return tuple(stacked)

    def degrees(self) -> Array:
        """The degrees of all relative motions, of link b as seen from link a; shape (n, n), whole numbers.

        Each is the number of :meth:`bonds` that are cut where the loop is cut at both links.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> Linkage.from_chains([h1, h2], bennett_flip(h1, h2)).degrees().tolist()
        [[0, 1, 2, 1], [1, 0, 1, 2], [2, 1, 0, 1], [1, 2, 1, 0]]
        """
        return degrees_of(self.bonds(), self.joint_count)

    # ---- closure -------------------------------------------------------------------------------------

    @cached_property
    def _is_exact(self) -> bool:
        return all(is_exact(f.components) for f in self.factors)

    @cached_property
    def _centred(self) -> Centred:
        return Centred.of(self)

    def closure_residual(self) -> Any:
        """How far the product of all factors is from a real polynomial, relative to its size; 0 if exact.

        Each coefficient is compared with the same coefficient of Π(t + |f|), dual parts with the size of the chain
        besides.  Lengths are measured from the middle of the axes and t from that of the factors, so neither the
        place of the origin nor the units matter.  This measures how well the loop closes, not how near the poses are
        passed.
        """
        if self._is_exact and self._closes_exactly:
            return plain(np.zeros(self.shape))
        product = product_of(self._centred.factors)
        residual = _beside_real(product, _bound(self._centred.factors))
        return plain(np.maximum(residual, np.finfo(float).tiny) if self._is_exact else residual)

    @cached_property
    def _closes_exactly(self) -> bool:
        first, second = self._halves(self.factors)
        if first and all(np.all(c == d) for c, d in zip(product_of(first), product_of(second), strict=True)):
            return True
        product = DualQuaternion.stack(product_of([broadcast(f, self.shape) for f in self.factors]), axis=-1)
        return bool(np.all(is_zero(product.components[1:])))

    def _halves(self, factors: Sequence[DualQuaternion]) -> tuple[Sequence[DualQuaternion], Sequence[DualQuaternion]]:
        """The two chains to the coupler if they have equally many factors, else nothing."""
        count = sum(self.joints[: self.coupler])
        first, second = factors[:count], [f.conjugate() for f in reversed(factors[count:])]
        return (first, second) if len(first) == len(second) else ((), ())

    def _check_closure(self, rtol: float) -> None:
        if self._is_exact and self._closes_exactly:
            return
        if self._is_exact or not np.all(self._difference_of_chains() <= rtol):
            residual = np.asarray(self.closure_residual())
            wrong = residual > (0 if self._is_exact else rtol + self._centred.noise)
            if wrong.any():
                row, words = first_row(wrong)
                raise ValueError(
                    f"{words}the loop does not close: around it the product of the factors differs from a real "
                    f"polynomial by {residual[row]:.3g} of its size; the two chains to the coupler must have equal "
                    "products" + _ROUNDED * (not self._is_exact)
                )

    def _difference_of_chains(self) -> Any:
        """How far the two chains to the coupler are from having equal products, if they may have."""
        first, second = self._halves(self._centred.factors)
        if not first:
            return math.inf
        difference = [c - d for c, d in zip(product_of(first), product_of(second), strict=True)]
        return _beside_real(difference, np.fmax(_bound(first), _bound(second)), all_of_it=True)

    def _check_turns(self, rtol: float) -> None:
        """Refuse factors that are no rotations, and factors of one joint that have different axes."""
        for number, f in enumerate(self.factors):
            pitch = np.asarray(_pitch(f, self.chain))
            wrong = pitch > (0 if is_exact(f.components) else rtol)
            if wrong.any():
                row, words = first_row(wrong)
                raise ValueError(
                    f"{words}factor number {number} is no rotation x + y h about a line: it is off by {pitch[row]:.3g} "
                    "of its size" + _ROUNDED * (not is_exact(f.components))
                )
        for n in range(self.joint_count):
            for f in self.joint_factors(n)[1:]:
                if not np.all(_turns_about(self.axes[..., n], f, self.chain, rtol)):
                    raise ValueError(
                        f"expected the factors of joint {n + 1} to have one axis, but they have different ones: "
                        f"joints={self.joints} says how many factors in a row share an axis"
                    )


class Centred(NamedTuple):
    """The factors of a linkage in floats, with lengths from the middle of its axes and t from that of its factors.

    Attributes
    ----------
    factors : list of DualQuaternion
        In units of the size of the chain (without moments if all axes meet) and of the spread of t.
    middle, spread : array, shape (...)
        Of the parameter t.
    noise : array, shape (...)
        What rounding makes of the dual parts.
    """

    factors: list[DualQuaternion]
    middle: Array
    spread: Array
    noise: Array

    @classmethod
    def of(cls, linkage: Linkage) -> Centred:
        """The factors of a linkage, seen from its middle."""
        lines = linkage.chain.lines
        shape = linkage.shape
        components = np.stack([broadcast(f, shape).astype(float).components for f in linkage.factors])
        middle = components[:, 0].mean(axis=0)
        components[:, 0] -= middle
        spread = np.sqrt((components[:, :4] ** 2).sum(axis=1)).max(axis=0)
        noise = np.maximum(lines.noise, ROUNDING * _distance(linkage.home))
        length = np.where(lines.length > noise, lines.length, np.inf)
        turning = np.moveaxis(components[:, 1:4], 1, -1)
        components[:, 5:] -= np.moveaxis(np.cross(lines.middle, turning), -1, 1)
        components /= spread
        components[:, 4:] /= length
        factors = [DualQuaternion.from_components(np.array(f)) for f in components]
        return cls(factors, middle, spread, 8 * noise / length)


# ---- making linkages ---------------------------------------------------------------------------------


def verified_linkage(
    factors: Sequence[DualQuaternion],
    joints: Sequence[int],
    coupler: int,
    home: DualQuaternion = one,
    parameters: Sequence[ScalarLike | Array] = (),
    motion: MotionPolynomial | None = None,
) -> Linkage:
    """A linkage that is known to close, without the check.

    Parameters
    ----------
    factors, joints, coupler, home, parameters
        As in :class:`Linkage`; the factors about one joint must share its axis.
    motion : MotionPolynomial, optional
        The coupler motion, where it is known already.
    """
    linkage = object.__new__(Linkage)
    linkage._set(factors, joints, coupler, home, parameters)
    if motion is not None:
        linkage.__dict__["coupler_motion"] = motion
    return linkage


def verified_loop(
    first: Sequence[DualQuaternion],
    second: Sequence[DualQuaternion],
    *,
    home: DualQuaternion = one,
    joints: Sequence[int] | None = None,
    parameters: Sequence[ScalarLike | Array] = (),
    motion: MotionPolynomial | None = None,
) -> Linkage:
    """The loop of two chains with products that are known to be equal: :meth:`Linkage.from_chains` unchecked."""
    return verified_linkage(*_loop(first, second, joints), home, parameters, motion)


def _loop(
    first: Any, second: Any, joints: Sequence[int] | None
) -> tuple[tuple[DualQuaternion, ...], tuple[int, ...], int]:
    """The factors around the loop of two chains, the joints, and the number of the link where the chains meet."""
    first, second = _as_factors(first), _as_factors(second)
    factors = (*first, *(f.conjugate() for f in reversed(second)))
    joints = tuple(joints or [1] * len(factors))
    ends = list(accumulate(joints))
    if len(first) not in ends:
        raise ValueError(f"expected a joint to end with the first chain of {len(first)} factors, got joints {joints}")
    return factors, joints, ends.index(len(first)) + 1


def _as_home(home: PoseLike) -> DualQuaternion:
    """The pose of the coupler at home; rows of NaN are let through."""
    if not isinstance(home, DualQuaternion):
        home = as_pose(home)
    if np.any(is_zero(null_form(home, home), rtol=0)):
        raise DegenerateError("the home pose lies in the exceptional three-space: its primal part is zero")
    return home


def _as_tuple(values: Any, name: str) -> tuple[Any, ...]:
    try:
        return tuple(values)
    except TypeError:
        raise TypeError(f"expected a sequence for {name}, got {values!r}") from None


def _whole(number: Any, what: str) -> int:
    try:
        return operator.index(number)
    except TypeError:
        raise TypeError(f"expected {what}, got {number!r}") from None


def _as_factors(factors: Any) -> tuple[DualQuaternion, ...]:
    if isinstance(factors, DualQuaternion) or not isinstance(factors, Sequence):
        raise TypeError(f"expected a sequence of dual quaternions f, one for each factor t − f, got {factors!r}")
    for f in factors:
        if not isinstance(f, DualQuaternion):
            raise TypeError(f"expected a dual quaternion f for each factor t − f, got {f!r}")
        if f.components.dtype.kind == "c":
            raise ValueError(f"expected real factors, got a complex one: {f!r}")
        if f.components.dtype.kind == "f" and np.isinf(f.components).any():
            raise ValueError("expected finite factors, got infinity")
    return tuple(factors)


def _pitch(f: DualQuaternion, chain: Chain) -> Array:
    """How far f is from x + y h with a half-turn h, in parts of its size: 0 only if it is exactly that."""
    d0, product = f.components[4], study_form(f, f)
    if is_exact(f.components) and np.all(is_zero(d0) & is_zero(product)):
        return np.zeros(f.shape)
    f = f.astype(float)
    turning, length = size(f.components[:4], 0), size(f.components[5:], 0)
    length = length + turning * (chain.lines.length + chain.lines.noise)
    return np.maximum(np.abs(f.components[4]), np.abs(study_form(f, f)) / turning) / length


def _turns_about(axis: DualQuaternion, f: DualQuaternion, chain: Chain, rtol: float) -> Any:
    """Whether a rotation f has a given axis; NaN is let through."""
    f = f - f.scalar_part
    commutator = f * axis - axis * f
    if is_exact(commutator.components):
        return np.all(is_zero(commutator.components))
    turning = size(axis.components[1:4], 0) * size(f.components[1:4], 0)
    length = size(axis.components[5:], 0) + chain.lines.length
    turned = is_zero(size(commutator.components[:4], 0), turning, rtol)
    shifted = is_zero(size(commutator.components[4:], 0), turning * length, rtol)
    return (turned & shifted) | np.isnan(turning)


# ---- measures ----------------------------------------------------------------------------------------


def _listed(parameters: tuple[Any, ...]) -> str:
    """Parameter values in words."""
    if any(np.ndim(t) for t in parameters):
        return f"{len(parameters)} values of t"
    return "t = " + ", ".join(f"{float(t):.6g}".replace("inf", "∞") for t in parameters)


def _distance(pose: DualQuaternion) -> Array:
    """How far a displacement moves the origin, about: twice the ratio of dual and primal part."""
    coeffs = as_float(pose.coeffs)
    return 2 * np.linalg.norm(coeffs[..., 4:], axis=-1) / np.linalg.norm(coeffs[..., :4], axis=-1)


def _turn(factors: Sequence[DualQuaternion], t: Any) -> DualQuaternion:
    """The displacement of a joint from infinity to t."""
    return reduce(lambda q, f: q * evaluate((one, -f), t), factors, one)


def _bound(factors: Sequence[DualQuaternion]) -> Array:
    """The coefficients of Π (t + |f|), highest power on the first axis."""
    bound = [np.ones(factors[0].shape)]
    for f in factors:
        r = np.sqrt(null_form(f, f))
        bound = [high + low * r for high, low in zip([*bound, 0.0], [0.0, *bound], strict=True)]
    return np.stack(bound)


def _beside_real(coefficients: Sequence[DualQuaternion], bound: Array, *, all_of_it: bool = False) -> Array:
    """The largest coefficient beside the real ones (or of all), each relative to its bound; shape (...).

    The leading coefficient, which is 1 or 0, is left out.
    """
    components = np.stack([c.components for c in coefficients[1:]])[:, 0 if all_of_it else 1 :]
    return (np.abs(components).max(axis=1) / bound[1:]).max(axis=0)


def _negligible(remainder: Sequence[DualQuaternion], coefficients: Sequence[DualQuaternion]) -> bool:
    """Whether a remainder vanishes, in every row of a batch that is not NaN."""
    fine = undefined = _undefined(coefficients[-1])
    for half in (slice(0, 4), slice(4, 8)):
        scale = reduce(np.maximum, (size(c.components[half], 0) for c in coefficients))
        vanish = [is_zero(r.components[half], scale, rtol=1e-7) for r in remainder]
        fine = (
            fine | np.all(vanish, axis=(0, 1)) if half.start == 0 else fine & (undefined | np.all(vanish, axis=(0, 1)))
        )
    return bool(np.all(fine) and not np.all(undefined))


def _undefined(q: DualQuaternion) -> Array:
    return np.isnan(q.components).any(axis=0) if q.components.dtype.kind == "f" else np.zeros(q.shape, dtype=bool)


def _exact_rank(linkage: Linkage, bound: int, rtol: float) -> int:
    """The rank of the axes of a single exact linkage at general t.

    No rank is above the bound, so floats that reach it decide; else the ranks at some fractions do.
    """
    try:
        floats = linkage.astype(float)
        if floats._general_rank(bound, rtol) == bound:
            return bound
        samples = [Fraction(float(t)).limit_denominator(10**3) for t in floats._samples()[:3]]
    except TypeError:  # there are symbols
        samples = [Fraction(37, 100)]
    return max(_rank_at(linkage, t) for t in samples)


def _rank_at(linkage: Linkage, t: Fraction) -> int:
    """The exact rank of the axes at t; their half-turns need no common length."""
    turns = [_turn(linkage.joint_factors(n), t) for n in range(linkage.joint_count - 1)]
    links = DualQuaternion.stack(list(accumulate(turns, initial=linkage._identity, func=operator.mul)))
    lines = (links * linkage.axes * links.conjugate()).coeffs[:, [1, 2, 3, 5, 6, 7]]
    return linkage.joint_count - len(null_space(lines.T))
