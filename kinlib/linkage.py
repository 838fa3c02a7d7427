"""Linkages: closed chains of revolute joints with their rational motion, driven by one parameter t."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kinlib.bonds import Bond, bonds_of_loop, degrees_of
from kinlib.chain import Chain, DHRow, batch_index, html_table
from kinlib.closure import CLOSED, check_closure, check_turns, closure_residual
from kinlib.collision import (
    Collisions,
)
from kinlib.displacement import act
from kinlib.drive import (
    dead_points,
    joint_ranges,
    joint_rates,
    order_of_visits,
    parameters_of_angle,
    turns_of,
    twist_of,
)
from kinlib.dual_quaternion import DualQuaternion, one
from kinlib.line import Line
from kinlib.loop import Loop, as_factors, as_home, as_tuple, loop_of_chains, whole
from kinlib.loop_collisions import clearance_of, collisions_of
from kinlib.loop_motion import motion_of_axes, moving_chain
from kinlib.mobility import general_mobility
from kinlib.motion_polynomial import MotionPolynomial, RationalCurve
from kinlib.poses import as_pose
from kinlib.reach import NearestPose, nearest_pose, parameters_of_pose
from kinlib.relative_motion import relative_motion
from kinlib.rows import broadcast
from kinlib.saving import from_json, read_document, to_json, write_document
from kinlib.scalar import RTOL, as_float, as_scalars
from kinlib.timetable import Driven, Law, Timetable, driven_at
from kinlib.typing import Array, ArrayLike, Degenerate, PointLike, PoseLike, ScalarLike

__all__ = ["Linkage"]


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
        self._set(as_factors(self.factors), self.joints, self.coupler, as_home(self.home), self.parameters)
        check_turns(self._loop, max(rtol, CLOSED))
        check_closure(self._loop, self.coupler, rtol)

    def _set(
        self, factors: Sequence[DualQuaternion], joints: Any, coupler: Any, home: DualQuaternion, parameters: Any
    ) -> None:
        joints = tuple(whole(count, "joints as whole numbers of factors") for count in as_tuple(joints, "joints"))
        coupler, parameters = whole(coupler, "the coupler as a whole number"), as_tuple(parameters, "parameters")
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
        return cls(*loop_of_chains(first, second, joints), as_home(home), as_tuple(parameters, "parameters"), rtol)

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
        return verified_linkage(factors, joints, len(joints) // 2 if coupler is None else coupler, as_home(home))

    @classmethod
    def from_denavit_hartenberg(
        cls,
        rows: Sequence[Sequence[ArrayLike]],
        *,
        angle: ArrayLike,
        joint: int = 0,
        coupler: int | None = None,
        home: PoseLike = one,
        rtol: float = CLOSED,
        degenerate: Degenerate = "raise",
    ) -> Linkage:
        """The linkage of a table of Denavit–Hartenberg rows, at a position where one joint has a given angle.

        Distances, twists and offsets fix no position, and not always one linkage: the angle has to choose.  Of the
        positions that close the loop the first is taken from which the linkage moves.

        Parameters
        ----------
        rows : sequence of n triples (distance, twist, offset)
            As :meth:`denavit_hartenberg` gives them: numbers, or arrays of shape (...) for many tables.
        angle : array_like, shape (...)
            The angle of one joint at t = ∞, as :meth:`Chain.angles <kinlib.Chain.angles>` counts it, in radians.
        joint : int
            The number of that joint, from 0.
        coupler, home, rtol
            As in :meth:`from_axes`.
        degenerate : {"raise", "nan"}
            What becomes of tables of a batch that do not close, or do not move.

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
        number = whole(joint, "the joint as a whole number")
        chain = moving_chain(rows, angle, number, rtol=rtol, degenerate=degenerate)
        return cls.from_axes(chain, coupler=coupler, home=home, rtol=rtol, degenerate=degenerate)

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

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the linkage to a JSON file, which :meth:`load` reads; all numbers as they are, exact ones too.

        Raises
        ------
        TypeError
            If there are numbers that can not be saved, such as elements of polynomial rings.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> from kinlib import bennett_linkage, gallery
        >>> loop = bennett_linkage(*gallery.THREE_POSES)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     loop.save(Path(folder) / "bennett.json")
        ...     again = Linkage.load(Path(folder) / "bennett.json")
        >>> again.factors == loop.factors, again.parameters
        (True, (inf, 0, 1))
        """
        residual = float(np.nanmax(self.closure_residual(), initial=0.0))
        write_document(
            path, "linkage", {"residual": residual, **{x: to_json(y) for x, y in self.__getstate__().items()}}
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Linkage:
        """The linkage that was saved in a file.

        Raises
        ------
        ValueError
            If the file is no saved linkage, was changed since, or comes from a newer kinlib.
        """
        content = read_document(path, "linkage")
        try:
            residual = content.pop("residual")
            given = {name: from_json(value) for name, value in content.items()}
            return cls(**given, rtol=max(CLOSED, 2 * residual))
        except (TypeError, KeyError, ValueError, AttributeError) as error:
            raise ValueError(f"the file does not hold a linkage: {error}") from None

    def joint_factors(self, joint: int) -> Sequence[DualQuaternion]:
        """The factors of joint number 0, 1, …, all about one axis."""
        return self._loop.joint_factors(joint)

    @cached_property
    def _loop(self) -> Loop:
        return Loop(tuple(self.factors), tuple(self.joints), self.home, self.shape)

    # ---- the chain -----------------------------------------------------------------------------------

    @cached_property
    def axes(self) -> DualQuaternion:
        """The half-turns about the axes in loop order at t = ∞, in the fixed frame; shape (..., n)."""
        return self._loop.axes

    @cached_property
    def chain(self) -> Chain:
        """The closed chain of the axes at home, t = ∞."""
        return self._loop.chain

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
        return self._loop.link_displacements(t)

    def configuration(self, t: ArrayLike) -> DualQuaternion:
        """The half-turns about all axes at t; shape (..., n)."""
        return self._loop.configuration(t)

    def joint_angles(self, t: ArrayLike) -> Array:
        """The angles that the joints have turned from t = ∞ (+∞ and −∞ differ by one round); radians, (..., n).

        The factor t − f turns by −2 arccot((t − Re f)/|Im f|), so the angles are continuous in t.
        """
        return self._loop.angles(t)

    def relative_motion(self, a: int, b: int) -> MotionPolynomial:
        """The motion of link b as seen from link a, with common real factors taken out.

        Parameters
        ----------
        a, b : int
            Numbers of links, counted on round the loop.
        """
        return relative_motion(self._loop, a, b)

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
        return general_mobility(self._loop, rtol=rtol) if t is None else self.at(t).mobility(rtol=rtol)

    # ---- the drive -----------------------------------------------------------------------------------

    def parameter_of(self, angle: ArrayLike, joint: int = 0) -> Array:
        """All t at which a joint has turned by an angle from t = ∞: as many as it turns round.

        Parameters
        ----------
        angle : array_like, shape (...)
            In radians, as :meth:`joint_angles` gives them, right-handed about the joint's axis; whole rounds do not
            matter.  Angles of SymPy, such as π/3, give exact parameters of an exact linkage.
        joint : int
            The number of the joint, from 0.

        Returns
        -------
        numpy.ndarray, shape (..., m)
            One for a joint with one factor, m for one with m, in the order of t with ∞ at the end; NaN behind them
            where a joint that swings to and fro has fewer, or none.

        Examples
        --------
        >>> from math import pi
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> loop = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
        >>> loop.parameter_of(pi / 2).round(9).tolist(), loop.parameter_of(0).tolist()
        ([-1.0], [inf])
        """
        return parameters_of_angle(self._loop, angle, joint)

    def parameters_of_pose(self, pose: PoseLike, *, rtol: float = RTOL, degenerate: Degenerate = "raise") -> Array:
        """All t at which the coupler has a pose; exact for an exact linkage and pose.

        Parameters
        ----------
        pose : pose, shape (...)
            Of the coupler's frame.
        rtol : float
            How far the coupler may pass from the pose, in turning and in parts of the size of the linkage.
        degenerate : {"raise", "nan"}
            What to do about poses that are not reached.

        Returns
        -------
        numpy.ndarray, shape (..., m)
            In the order of t with ∞ at the end; m is 1 unless some pose is passed several times, then rows with fewer
            end in NaN.

        Raises
        ------
        DegenerateError
            If a pose is not reached; the message says how far the coupler passes by.

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> loop = bennett_linkage(*gallery.THREE_POSES)
        >>> [[str(t) for t in loop.parameters_of_pose(pose)] for pose in gallery.THREE_POSES]
        [['inf'], ['0'], ['1']]
        >>> loop.parameters_of_pose(gallery.THREE_POSES[2] * (1 + eps * i))
        Traceback (most recent call last):
        ...
        kinlib.errors.DegenerateError: the coupler does not reach the pose: where it is nearest, at t = 2.11911, it \
is turned by 0.42 rad and shifted by 1.7 against it; nearest_pose() gives this t, rtol= accepts more
        """
        return parameters_of_pose(self._loop, self.coupler, self.coupler_motion, as_pose(pose), rtol, degenerate)

    def nearest_pose(self, pose: PoseLike) -> NearestPose:
        """The t at which the coupler comes nearest to a pose, and how near; in floats, shape (...).

        There is no distance of poses that does not depend on a length.  Here it is the size of the linkage, see
        :class:`NearestPose`.

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> loop = bennett_linkage(*gallery.THREE_POSES)
        >>> [round(x, 3) for x in loop.nearest_pose(gallery.THREE_POSES[2] * (1 + eps * i))]
        [2.119, 0.419, 1.717]
        """
        return nearest_pose(self._loop, self.coupler, as_pose(pose))

    def joint_rates(self, t: ArrayLike, joint: int | None = 0) -> Array:
        """How fast the joints turn at t; shape (..., n).

        Parameters
        ----------
        t : scalar or array
            Broadcasts against the batch; ∞ is no exception.
        joint : int or None
            For which joint the rate is 1.  With None all rates are in radians per unit of t, so 0 at infinity.

        Returns
        -------
        numpy.ndarray
            Infinite, or NaN, where this joint is at one of its :meth:`dead_points`.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> loop = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
        >>> [str(rate) for rate in loop.joint_rates(0)], [str(rate) for rate in loop.joint_rates(0, None)]
        (['1', '1/2', '1', '1/2'], ['2', '1', '2', '1'])
        """
        return joint_rates(self._loop, t, joint)

    def twist(self, t: ArrayLike, link: int, joint: int | None = 0) -> Array:
        """The velocity of a link against link 0 at t, when a joint turns by one radian per unit of time.

        Returns
        -------
        numpy.ndarray, shape (..., 6)
            The angular velocity ω, right-handed, and the velocity v of the point of the link that is at the origin, in
            the fixed frame: a point at x has the velocity v + ω × x.  With ``joint=None`` per unit of t.

        Examples
        --------
        >>> from kinlib import bennett_flip
        >>> h1, h2 = i, 2 * j - 2 * eps * i
        >>> loop = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
        >>> [str(x) for x in loop.twist(0, 1)]
        ['1', '0', '0', '0', '0', '0']
        """
        return twist_of(self._loop, t, link, joint)

    def dead_points(self, joint: int) -> Array:
        """All t at which a joint turns back, where it can not drive the linkage; shape (..., 2m − 2), m its factors.

        A joint that turns once has none.  In the order of t, NaN behind them where there are fewer.

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> bennett_linkage(*gallery.THREE_POSES).dead_points(0).shape
        (0,)
        """
        return dead_points(self._loop, joint)

    def turns(self) -> Array:
        """How often each joint turns round its axis during the whole motion, t from −∞ to ∞; shape (..., n).

        Right-handed about the :attr:`axes`; 0 for a joint that swings to and fro.

        Examples
        --------
        >>> from kinlib import gallery, goldberg_linkages
        >>> goldberg_linkages(*gallery.THREE_POSES, (1, 2))[0].turns().tolist()
        [2, 1, 1, 1, 1]
        """
        return turns_of(self._loop)

    def joint_ranges(self) -> Array:
        """The least and the greatest of the :meth:`joint_angles` over the motion; radians, shape (..., n, 2)."""
        return joint_ranges(self._loop)

    def order_of_visits(self) -> Array:
        """In which order the poses at the :attr:`parameters` are passed while t grows; from pose 0 on, shape (..., m).

        Examples
        --------
        >>> from kinlib import bennett_linkage, gallery
        >>> loop = bennett_linkage(*gallery.THREE_POSES)
        >>> loop.parameters, loop.order_of_visits().tolist()
        ((inf, 0, 1), [0, 1, 2])
        """
        return order_of_visits([np.broadcast_to(as_scalars(t), self.shape) for t in self.parameters])

    def drive(self, law: Law, times: ArrayLike) -> Timetable:
        """Where the linkage is at given times, when it is driven by a law.

        Parameters
        ----------
        law : ConstantSpeed, ConstantPointSpeed or RestAtPoses
        times : array_like, shape (m,)
            In the unit of time of the law.

        Returns
        -------
        Timetable
            With parameters, joint angles and poses of the coupler.

        Raises
        ------
        ValueError
            If the joint that is to drive turns back somewhere, or the point that is to move does not.

        Examples
        --------
        >>> from kinlib import ConstantPointSpeed, bennett_linkage, gallery
        >>> loop = bennett_linkage(*gallery.THREE_POSES)
        >>> table = loop.drive(ConstantPointSpeed([1, 0, 0], speed=0.1), np.linspace(0.0, 3.0, 31))
        >>> steps = np.diff(act(table.poses, [1, 0, 0]), axis=0)
        >>> np.linalg.norm(steps, axis=-1).round(3).tolist() == [0.01] * 30
        True
        """
        floats = self.astype(float)
        times, t, angles = driven_at(law, Driven(floats._loop, self.coupler, self.parameters), times)
        poses = floats.coupler_motion(np.moveaxis(t, -1, 0)) if self.shape else floats.coupler_motion(t)
        batch = DualQuaternion(np.moveaxis(poses.coeffs, 0, -2)) if self.shape else poses
        return Timetable(times, t, angles, batch)

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
            In floats, bars that come nearer than this, in units of their size, count as meeting, and meetings between
            which they do not part farther as one.  At each t that is returned they are as near as that; they cross if
            no end of one is as near to the other, and the sides change.
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
        return collisions_of(self._loop, self.bars, bars, rtol, degenerate)

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
        return clearance_of(self._loop, self.bars, bars, rtol)

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
        return bonds_of_loop(self._loop)

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

    def closure_residual(self) -> Any:
        """How far the product of all factors is from a real polynomial, relative to its size; 0 if exact.

        Each coefficient is compared with the same coefficient of Π(t + |f|), dual parts with the size of the chain
        besides.  Lengths are measured from the middle of the axes and t from that of the factors, so neither the
        place of the origin nor the units matter.  This measures how well the loop closes, not how near the poses are
        passed.
        """
        return closure_residual(self._loop, self.coupler)


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
    return verified_linkage(*loop_of_chains(first, second, joints), home, parameters, motion)


# ---- measures ----------------------------------------------------------------------------------------


def _listed(parameters: tuple[Any, ...]) -> str:
    """Parameter values in words."""
    if any(np.ndim(t) for t in parameters):
        return f"{len(parameters)} values of t"
    return "t = " + ", ".join(_in_words(t) for t in parameters)


def _in_words(t: Any) -> str:
    try:
        return f"{float(t):.6g}".replace("inf", "∞")
    except TypeError:  # it has symbols
        return str(t)
