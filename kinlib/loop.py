"""A loop of linear factors: its joints, how they turn, where the links and the axes are at t."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from kinlib.chain import Chain
from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, null_form, one
from kinlib.errors import DegenerateError
from kinlib.motion_polynomial import evaluate
from kinlib.poses import as_pose
from kinlib.projective import null_space
from kinlib.rows import broadcast
from kinlib.scalar import ROUNDING, as_float, as_scalars, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, PoseLike

__all__ = ["Centred", "Loop", "as_factors", "as_home", "as_tuple", "loop_of_chains", "undefined_rows", "whole"]


@dataclass(frozen=True, eq=False, repr=False)
class Loop:
    """Linear factors t − f around a loop, joint by joint; whether they close is another question.

    Attributes
    ----------
    factors : tuple of DualQuaternion, each of shape (...)
        The f in loop order.
    joints : tuple of int
        How many consecutive factors share an axis.
    home : DualQuaternion
        The pose of some link at t = ∞, which says how far from the origin the loop is used.
    shape : tuple of int
        The shape of the batch.
    """

    factors: tuple[DualQuaternion, ...]
    joints: tuple[int, ...]
    home: DualQuaternion
    shape: tuple[int, ...]

    @property
    def joint_count(self) -> int:
        """The number of joints, and of links."""
        return len(self.joints)

    def joint_factors(self, joint: int) -> Sequence[DualQuaternion]:
        """The factors of joint number 0, 1, …, all about one axis."""
        start = sum(self.joints[:joint])
        return self.factors[start : start + self.joints[joint]]

    def rows(self) -> list[Loop]:
        """Each entry of the batch, in the order of ``np.ndindex``."""
        if not self.shape:
            return [self]
        *factors, home = (broadcast(f, self.shape) for f in (*self.factors, self.home))
        return [Loop(tuple(f[n] for f in factors), self.joints, home[n], ()) for n in np.ndindex(self.shape)]

    def astype(self, dtype: Any) -> Loop:
        """The same loop with numbers of another kind."""
        return Loop(tuple(f.astype(dtype) for f in self.factors), self.joints, self.home.astype(dtype), self.shape)

    @cached_property
    def axes(self) -> DualQuaternion:
        """The half-turns about the axes at t = ∞; shape (..., n)."""
        axes = [axis_of(self.joint_factors(n)[0]) for n in range(self.joint_count)]
        return DualQuaternion.stack([broadcast(h, self.shape) for h in axes], axis=-1)

    @cached_property
    def chain(self) -> Chain:
        """The closed chain of the axes at t = ∞."""
        return Chain.wrap(self.axes)

    @cached_property
    def is_exact(self) -> bool:
        """Whether all factors are exact."""
        return all(is_exact(f.components) for f in self.factors)

    @property
    def identity(self) -> DualQuaternion:
        """The identity, in scalars of the loop's kind; NaN in NaN rows."""
        return broadcast(self.factors[0] * 0 + 1, self.shape)

    @cached_property
    def undefined(self) -> Array:
        """Which rows are NaN; shape (...)."""
        return np.asarray(undefined_rows(self.identity))

    @cached_property
    def centred(self) -> Centred:
        """The factors in floats, seen from their middle."""
        return Centred.of(self)

    def turn(self, joint: int, t: Any) -> DualQuaternion:
        """The displacement of a joint from t = ∞ to t, a multiple of the rotation."""
        return reduce(lambda q, f: q * evaluate((one, -f), t), self.joint_factors(joint), one)

    def angles(self, t: ArrayLike) -> Array:
        """The angles that the joints have turned from t = ∞, as the factors say; radians, (..., n)."""
        t = as_float(as_scalars(t))
        angles = [self._angle(n, t) for n in range(self.joint_count)]
        return np.stack(np.broadcast_arrays(*angles), axis=-1)

    def _angle(self, joint: int, t: Array) -> Array:
        factors = [f.astype(float) for f in self.joint_factors(joint)]
        axis = axis_of(factors[0])
        return sum(-2 * np.arctan2(null_form(f, axis), t - f.scalar_part) for f in factors)

    def link_displacements(self, t: ArrayLike) -> DualQuaternion:
        """The displacements of all links from t = ∞ to t; shape (..., n), t broadcasts against the batch."""
        t = as_scalars(t)[()]
        turns = [self.turn(n, t) for n in range(self.joint_count - 1)]
        links = accumulate(turns, lambda link, turn: unit(link * turn), initial=self.identity)
        shape = np.broadcast_shapes(self.shape, np.asarray(t).shape)
        return DualQuaternion.stack([broadcast(link, shape) for link in links], axis=-1)

    def configuration(self, t: ArrayLike) -> DualQuaternion:
        """The half-turns about all axes at t; shape (..., n)."""
        links = self.link_displacements(t)
        return unit(links * self.axes * links.conjugate())

    def exact_rank(self, t: Any) -> int:
        """The exact rank of the axes' Plücker coordinates at t, for a single loop; half-turns of any length will do."""
        turns = [self.turn(n, t) for n in range(self.joint_count - 1)]
        links = DualQuaternion.stack(list(accumulate(turns, initial=self.identity, func=operator.mul)))
        lines = (links * self.axes * links.conjugate()).coeffs[:, [1, 2, 3, 5, 6, 7]]
        return self.joint_count - len(null_space(lines.T))


class Centred(NamedTuple):
    """The factors of a loop in floats, with lengths from the middle of its axes and t from that of its factors.

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
    def of(cls, loop: Loop) -> Centred:
        """The factors of a loop, seen from its middle."""
        lines, shape = loop.chain.lines, loop.shape
        components = np.stack([broadcast(f, shape).astype(float).components for f in loop.factors])
        middle = components[:, 0].mean(axis=0)
        components[:, 0] -= middle
        spread = np.sqrt((components[:, :4] ** 2).sum(axis=1)).max(axis=0)
        noise = np.maximum(lines.noise, ROUNDING * _distance(loop.home))
        length = np.where(lines.length > noise, lines.length, np.inf)
        turning = np.moveaxis(components[:, 1:4], 1, -1)
        components[:, 5:] -= np.moveaxis(np.cross(lines.middle, turning), -1, 1)
        components /= spread
        components[:, 4:] /= length
        factors = [DualQuaternion.from_components(np.array(f)) for f in components]
        return cls(factors, middle, spread, 8 * noise / length)


def _distance(pose: DualQuaternion) -> Array:
    """How far a displacement moves the origin, about: twice the ratio of dual and primal part."""
    coeffs = as_float(pose.coeffs)
    return 2 * np.linalg.norm(coeffs[..., 4:], axis=-1) / np.linalg.norm(coeffs[..., :4], axis=-1)


def undefined_rows(q: DualQuaternion) -> Array:
    """Which rows of a batch are NaN."""
    return np.isnan(q.components).any(axis=0) if q.components.dtype.kind == "f" else np.zeros(q.shape, dtype=bool)


# ---- what is given -----------------------------------------------------------------------------------


def loop_of_chains(
    first: Any, second: Any, joints: Sequence[int] | None
) -> tuple[tuple[DualQuaternion, ...], tuple[int, ...], int]:
    """The factors around the loop of two chains, the joints, and the number of the link where the chains meet."""
    first, second = as_factors(first), as_factors(second)
    factors = (*first, *(f.conjugate() for f in reversed(second)))
    joints = tuple(joints or [1] * len(factors))
    ends = list(accumulate(joints))
    if len(first) not in ends:
        raise ValueError(f"expected a joint to end with the first chain of {len(first)} factors, got joints {joints}")
    return factors, joints, ends.index(len(first)) + 1


def as_home(home: PoseLike) -> DualQuaternion:
    """The pose of the coupler at home; rows of NaN are let through."""
    if not isinstance(home, DualQuaternion):
        home = as_pose(home)
    if np.any(is_zero(null_form(home, home), rtol=0)):
        raise DegenerateError("the home pose lies in the exceptional three-space: its primal part is zero")
    return home


def as_tuple(values: Any, name: str) -> tuple[Any, ...]:
    """A sequence as a tuple."""
    try:
        return tuple(values)
    except TypeError:
        raise TypeError(f"expected a sequence for {name}, got {values!r}") from None


def whole(number: Any, what: str) -> int:
    """A whole number."""
    try:
        return operator.index(number)
    except TypeError:
        raise TypeError(f"expected {what}, got {number!r}") from None


def as_factors(factors: Any) -> tuple[DualQuaternion, ...]:
    """Real, finite dual quaternions; rows of NaN are let through."""
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
