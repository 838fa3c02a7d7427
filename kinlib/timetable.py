"""A linkage driven in time: laws that say where it is when, and the table of joint angles and poses that follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from kinlib.displacement import act, as_matrix
from kinlib.drive import dead_points, joint_number, order_of_visits, parameters_of_angle, turns_of, weighted_twist
from kinlib.dual_quaternion import DualQuaternion
from kinlib.loop import Loop
from kinlib.phase import phases_of, t_at, weight_of_phase
from kinlib.scalar import as_float, as_scalars, as_vectors
from kinlib.tables import as_table
from kinlib.typing import Array, ArrayLike, PointLike, ScalarLike

__all__ = ["ConstantPointSpeed", "ConstantSpeed", "Driven", "Law", "RestAtPoses", "Timetable", "angles_at", "driven_at"]

WHOLE = 1e-13
"""What is so near to a whole number of rounds is one."""


class Driven(NamedTuple):
    """What a law sees of a linkage: the loop in floats, the number of the coupler, its home and its parameters."""

    loop: Loop
    coupler: int
    parameters: Sequence[Any]


class Law(Protocol):
    """What says where a linkage is at which time."""

    def phases(self, driven: Driven, times: Array) -> Array:
        """The phases, which go on growing over whole motions, at times of shape (m,); shape (m, ...)."""


@dataclass(frozen=True, eq=False)
class Timetable:
    """Where a linkage is at which time.

    Attributes
    ----------
    time : array, shape (m,)
    t : array, shape (..., m)
        The parameters.
    angles : array, shape (..., m, n)
        The angles that the joints have turned from t = ∞, in radians, continuous in time.
    poses : DualQuaternion, shape (..., m)
        Of the coupler.

    Examples
    --------
    >>> from kinlib import ConstantSpeed, bennett_linkage, gallery
    >>> table = bennett_linkage(*gallery.THREE_POSES).drive(ConstantSpeed(), [0.0, 0.5, 1.0])
    >>> table.angles[:, 0].round(9).tolist(), table.matrices.shape
    ([0.0, 0.5, 1.0], (3, 4, 4))
    """

    time: Array
    t: Array
    angles: Array
    poses: DualQuaternion

    @property
    def matrices(self) -> Array:
        """The 4×4 matrices of the poses, shape (..., m, 4, 4)."""
        return as_matrix(self.poses)

    def as_csv(self) -> str:
        """Time, t and the joint angles of a single linkage as CSV: all digits, angles in radians.

        Examples
        --------
        >>> from kinlib import ConstantSpeed, bennett_linkage, gallery
        >>> table = bennett_linkage(*gallery.THREE_POSES).drive(ConstantSpeed(), [0.0, 1.0])
        >>> table.as_csv().splitlines()[:2]
        ['time,t,joint 1,joint 2,joint 3,joint 4', '0.0,inf,0.0,0.0,0.0,0.0']
        """
        if self.t.ndim > 1:
            raise ValueError("expected the table of a single linkage: index the linkage first")
        head = ["time", "t", *(f"joint {n + 1}" for n in range(self.angles.shape[-1]))]
        return as_table("csv", head, np.column_stack([self.time, self.t, self.angles]).tolist())


def angles_at(loop: Loop, phase: Array) -> Array:
    """The joint angles at phases, continuous over whole motions; shape (..., n)."""
    t = t_at(loop, phase)
    begun = np.rint((phase - np.remainder(phase, 2 * np.pi)) / (2 * np.pi)) + 1
    rounds = np.where(np.isinf(t), np.rint(phase / (2 * np.pi)), begun)
    return np.asarray(loop.angles(t) + 2 * np.pi * rounds[..., None] * turns_of(loop))


# ---- the input turns steadily ------------------------------------------------------------------------


@dataclass(frozen=True)
class ConstantSpeed:
    """One joint turns steadily.

    Parameters
    ----------
    joint : int
        The number of the joint that is driven, from 0; one that turns back cannot drive.
    speed : float
        In radians per unit of time, right-handed about its axis.
    start : scalar
        The parameter at time 0.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> loop = bennett_linkage(*gallery.THREE_POSES)
    >>> loop.drive(ConstantSpeed(joint=1, speed=2.0), [0.0, 0.25]).angles[:, 1].round(9).tolist()
    [0.0, 0.5]
    """

    joint: int = 0
    speed: float = 1.0
    start: ScalarLike = np.inf

    def phases(self, driven: Driven, times: Array) -> Array:
        """See :class:`Law`."""
        first = angle_at(driven.loop, self.joint, phases_of(driven.loop, self.start))
        return phase_of_angle(driven.loop, self.joint, first + self.speed * _in_front(times, first))


def _in_front(times: Array, values: Array) -> Array:
    """Times with axes for a batch behind theirs."""
    return times.reshape(-1, *[1] * np.ndim(values))


def angle_at(loop: Loop, joint: int, phase: Array) -> Array:
    """The angle of one joint at a phase."""
    return angles_at(loop, phase)[..., joint_number(loop, joint)]


def phase_of_angle(loop: Loop, joint: int, angle: Array) -> Array:
    """The phase at which a driving joint has turned by an angle, whole rounds included.

    Raises
    ------
    ValueError
        If the joint has dead points.
    """
    _check_drives(loop, joint)
    turns = turns_of(loop)[..., joint]
    rounds = np.sign(turns) * angle / (2 * np.pi)
    rounds = np.where(np.abs(rounds - np.rint(rounds)) < WHOLE * (1 + np.abs(rounds)), np.rint(rounds), rounds)
    number, count = np.floor(rounds), np.abs(turns)
    phases = np.sort(phases_of_list(loop, parameters_of_angle(loop, angle, joint)), axis=-1)
    with np.errstate(invalid="ignore"):
        which = np.where(np.isnan(number), 0, number % count).astype(int)
        whole = np.floor(number / count)
    return np.asarray(2 * np.pi * whole + np.take_along_axis(phases, which[..., None], axis=-1)[..., 0])


def phases_of_list(loop: Loop, t: Array) -> Array:
    """Phases of parameters that stand in a list behind the batch, shape (..., m)."""
    return np.moveaxis(phases_of(loop, np.moveaxis(t, -1, 0)), 0, -1)


def _check_drives(loop: Loop, joint: int) -> None:
    dead = as_float(dead_points(loop, joint))
    if np.isfinite(dead).any() or np.isinf(dead).any():
        t = dead[~np.isnan(dead)].flat[0]
        raise ValueError(
            f"joint {joint} turns back at t = {t:.6g} and can not drive the linkage there: drive another joint"
        )


# ---- a point moves steadily --------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ConstantPointSpeed:
    """A point of the coupler moves along its path steadily.

    Parameters
    ----------
    point : array_like, shape (3,)
        In the coupler's frame.
    speed : float
        In units of length per unit of time, forward with t.
    start : scalar
        The parameter at time 0.

    Raises
    ------
    ValueError
        If the point stays where it is.
    """

    point: PointLike
    speed: float = 1.0
    start: ScalarLike = np.inf

    def phases(self, driven: Driven, times: Array) -> Array:
        """See :class:`Law`."""
        path = _Path(driven, as_float(as_vectors(self.point, "a point")))
        first = path.length_to(phases_of(driven.loop, self.start))
        return path.phase_of(first + self.speed * _in_front(times, first))


NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
"""Where and with which weights a smooth function from −1 to 1 is taken for its integral."""


STEPS = 60
"""So many halvings reach the last digit where Newton's method does not."""


class _Path:
    """The length of the path of a point, from phase 0 on."""

    def __init__(self, driven: Driven, point: Array):
        self.driven, self.point, loop = driven, point, driven.loop
        shape = np.broadcast_shapes(loop.shape, loop.home.shape, point.shape[:-1])
        ends = _panels(loop)
        self.ends = np.broadcast_to(ends, (len(ends), *shape))
        pieces = self.between(self.ends[:-1], self.ends[1:])
        self.lengths = np.concatenate([np.zeros_like(pieces[:1]), np.cumsum(pieces, axis=0)])
        self.total = self.lengths[-1]
        size = loop.chain.lines.length + np.linalg.norm(act(loop.home, point) - loop.chain.lines.middle, axis=-1)
        if np.any(self.total <= 1e-12 * size):
            raise ValueError("the point stays where it is on the whole motion: it has no speed to be held")

    def speed(self, phase: Array) -> Array:
        """The length of the derivative of the path by the phase."""
        loop, coupler = self.driven.loop, self.driven.coupler
        t = t_at(loop, phase)
        twist, _, _ = weighted_twist(loop, t, coupler)
        place = act(loop.link_displacements(t)[..., coupler], act(loop.home, self.point))
        velocity = twist[..., 3:] + np.cross(twist[..., :3], place)
        return np.asarray(np.linalg.norm(velocity, axis=-1) * weight_of_phase(loop, phase))

    def between(self, low: Array, high: Array) -> Array:
        """The length between two phases of one panel."""
        middle, half = (low + high) / 2, (high - low) / 2
        nodes = NODES.reshape(-1, *[1] * np.ndim(middle))
        return np.asarray(np.tensordot(WEIGHTS, self.speed(middle + half * nodes), axes=1) * half)

    def length_to(self, phase: Array) -> Array:
        """The length of the path up to a phase below 2π."""
        panel = (self.ends[1:-1] <= phase).sum(axis=0)
        low = np.take_along_axis(self.ends, panel[None], axis=0)[0]
        return np.take_along_axis(self.lengths, panel[None], axis=0)[0] + self.between(low, phase)

    def phase_of(self, length: Array) -> Array:
        """The phase at which the path has a length; Newton's method inside each panel."""
        rounds = np.floor(length / self.total)
        rest = length - rounds * self.total
        panel = (self.lengths[1:-1, None] <= rest).sum(axis=0)
        low, start = (_taken(table, panel) for table in (self.ends, self.lengths))
        high = _taken(self.ends[1:], panel)
        below, above, phase = low, high, (low + high) / 2
        for _ in range(STEPS):
            off = self.between(low, phase) - (rest - start)
            below, above = np.where(off < 0, phase, below), np.where(off < 0, above, phase)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = phase - off / self.speed(phase)
            inside = (step > below) & (step < above)
            phase, last = np.where(inside, step, (below + above) / 2), phase
            if np.all(np.isnan(phase) | (np.abs(phase - last) <= 1e-15)):
                break
        return np.asarray(2 * np.pi * rounds + phase)


def _taken(table: Array, index: Array) -> Array:
    """The rows of a table (k, ...) that an index of shape (m, ...) names."""
    return np.take_along_axis(table, index, axis=0)


PANELS = 20
"""Into how many parts the turn of each joint is divided."""


def _panels(loop: Loop) -> Array:
    """Phases from 0 to 2π between which all joints turn by little; shape (k, ...)."""
    halves = np.pi * np.arange(1, PANELS) / PANELS
    middle, spread = loop.centred.middle, loop.centred.spread
    inner = []
    for f in loop.factors:
        x, y = f.components[0], np.sqrt((f.components[1:4] ** 2).sum(axis=0))
        inner += [2 * np.arctan2(spread, middle - x + y / np.tan(half)) for half in halves]
    ends = np.broadcast_arrays(*inner, np.zeros(loop.shape), np.full(loop.shape, 2 * np.pi))
    return np.sort(np.stack(ends), axis=0)


# ---- rests at the poses ------------------------------------------------------------------------------


@dataclass(frozen=True)
class RestAtPoses:
    """The coupler rests at the poses from which the linkage was made, and moves between them without a jerk.

    From rest to rest the driven joint turns by 10τ³ − 15τ⁴ + 6τ⁵ of the way, so that its speed and its acceleration
    begin and end with 0.  At time 0 the first rest begins, at pose 0.

    Parameters
    ----------
    move : float
        How long it takes from each pose to the next.
    rest : float
        How long each rest is.
    joint : int
        The number of the joint that is driven, from 0.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> loop = bennett_linkage(*gallery.THREE_POSES)
    >>> loop.drive(RestAtPoses(move=1.0, rest=0.5), [0.2, 1.5, 3.2]).t.round(9) + 0.0
    array([inf,  0.,  1.])
    """

    move: float = 1.0
    rest: float = 1.0
    joint: int = 0

    def phases(self, driven: Driven, times: Array) -> Array:
        """See :class:`Law`."""
        if not driven.parameters or not (self.move > 0 and self.rest >= 0):
            raise ValueError("expected a linkage made from poses, a positive time to move and no negative rest")
        loop = driven.loop
        stops = phases_of_list(loop, _stacked(driven.parameters, loop.shape))
        order = order_of_visits([np.broadcast_to(as_scalars(t), loop.shape) for t in driven.parameters])
        stops = np.take_along_axis(stops, order, axis=-1)
        stops = stops + 2 * np.pi * (np.cumsum(np.diff(stops, axis=-1, prepend=stops[..., :1]) < 0, axis=-1))
        angles = np.moveaxis(angles_at(loop, np.moveaxis(stops, -1, 0))[..., joint_number(loop, self.joint)], 0, -1)
        round_trip = 2 * np.pi * turns_of(loop)[..., self.joint]
        legs = np.floor(times / (self.move + self.rest)).astype(int)
        part = np.clip((times - legs * (self.move + self.rest) - self.rest) / self.move, 0, 1)
        ends = [self._stop(angles, round_trip, legs + n) for n in (0, 1)]
        blend = _in_front(part**3 * (10 - 15 * part + 6 * part**2), round_trip)
        return phase_of_angle(loop, self.joint, ends[0] + blend * (ends[1] - ends[0]))

    @staticmethod
    def _stop(angles: Array, round_trip: Array, numbers: Array) -> Array:
        """The angles at stops number n = …, −1, 0, 1, …; shape (m, ...)."""
        rounds, which = np.divmod(numbers, angles.shape[-1])
        return np.moveaxis(angles[..., which], -1, 0) + _in_front(rounds, round_trip) * round_trip


def _stacked(parameters: Sequence[Any], shape: tuple[int, ...]) -> Array:
    return np.stack([np.broadcast_to(as_float(as_scalars(t)), shape) for t in parameters], axis=-1)


def driven_at(law: Law, driven: Driven, times: ArrayLike) -> tuple[Array, Array, Array]:
    """The times, shape (m,), and t, shape (..., m), and angles, shape (..., m, n)."""
    times = as_float(as_scalars(times))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise ValueError(f"expected a list of finite times, shape (m,), got shape {times.shape}")
    phases = law.phases(driven, times)
    t, angles = t_at(driven.loop, phases), angles_at(driven.loop, phases)
    return times, np.moveaxis(t, 0, -1), np.moveaxis(angles, 0, -2)
