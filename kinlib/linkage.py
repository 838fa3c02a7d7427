"""Closed chains of revolute joints, moved by one parameter t."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, null_form, one
from kinlib.factorization import divide_by_quadratic, product_of, quadratic_of
from kinlib.line import Line, common_perpendicular
from kinlib.motion_polynomial import MotionPolynomial, RationalCurve, evaluate
from kinlib.projective import null_space
from kinlib.scalar import RTOL, as_float, is_exact, is_zero, size

__all__ = ["DHRow", "Linkage"]


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

    distance: np.ndarray
    twist: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True, eq=False)
class Linkage:
    """A closed chain of revolute joints with the motion of its links.

    Joint n turns about its axis by a product of linear factors t − f; the product of all factors around the
    loop is a real polynomial, so the loop is closed for all t.  Link 0 is the base; link n sits between joint n
    and joint n + 1.

    Parameters
    ----------
    factors : sequence of DualQuaternion, each of shape (...)
        The f of all linear factors in loop order.
    joints : sequence of int
        How many consecutive factors share an axis, joint by joint.
    coupler : int
        The number of the link whose motion was asked for.
    home : DualQuaternion
        The pose of the coupler at t = ∞.
    parameters : tuple
        The parameter values at which the coupler is in the poses from which the linkage was made.

    Examples
    --------
    >>> from kinlib import bennett_flip
    >>> h1, h2 = i, 2 * j - 2 * eps * i
    >>> loop = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
    >>> loop.closure_residual(), loop.mobility(), loop.coupler
    (0.0, 1, 2)
    """

    factors: Sequence[DualQuaternion]
    joints: Sequence[int]
    coupler: int
    home: DualQuaternion = field(default_factory=lambda: one)
    parameters: tuple = ()

    def __post_init__(self):
        if sum(self.joints) != len(self.factors):
            raise ValueError(f"expected {sum(self.joints)} factors for joints {self.joints}, got {len(self.factors)}")
        if not 0 < self.coupler < len(self.joints):
            raise ValueError(f"expected the coupler among links 1, …, {len(self.joints) - 1}, got {self.coupler}")

    @classmethod
    def from_chains(cls, first, second, *, home=one, joints=None, parameters=()) -> Linkage:
        """Close the loop of two chains (t − h_1) ⋯ (t − h_m) = (t − k_1) ⋯ (t − k_n) that carry the same coupler.

        Parameters
        ----------
        first, second : sequences of DualQuaternion
            The factors from the base to the coupler, with equal products.
        joints : sequence of int, optional
            How many factors share an axis; by default each has its own.
        """
        factors = (*first, *(k.conjugate() for k in reversed(second)))
        joints = tuple(joints or [1] * len(factors))
        coupler = list(accumulate(joints)).index(len(first)) + 1
        return cls(factors, joints, coupler, home, parameters)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return np.broadcast_shapes(*[f.shape for f in self.factors])

    def __len__(self) -> int:
        return len(self.joints)

    def __getitem__(self, index) -> Linkage:
        """Entries of the batch."""
        pick = [_broadcast(f, self.shape)[index] for f in (*self.factors, self.home)]
        parameters = tuple(np.broadcast_to(t, self.shape)[index] for t in self.parameters)
        return Linkage(pick[:-1], self.joints, self.coupler, pick[-1], parameters)

    def joint_factors(self, joint: int) -> Sequence[DualQuaternion]:
        """The factors of joint number 0, 1, …, all about one axis."""
        start = sum(self.joints[:joint])
        return self.factors[start : start + self.joints[joint]]

    @property
    def axes(self) -> DualQuaternion:
        """The half-turns about the axes in loop order at t = ∞, in the fixed frame; shape (..., n)."""
        return self._stack([axis_of(self.joint_factors(n)[0]) for n in range(len(self))])

    def _stack(self, items) -> DualQuaternion:
        return DualQuaternion.stack([_broadcast(x, self.shape) for x in items], axis=-1)

    @property
    def coupler_motion(self) -> MotionPolynomial:
        """The motion of the coupler's frame, which visits the given poses."""
        first = self.factors[: sum(self.joints[: self.coupler])]
        return MotionPolynomial.from_factors(first, self.home)

    def coupler_curve(self, point) -> RationalCurve:
        """The path of a point, shape (3,), of the coupler's frame."""
        return self.coupler_motion.trajectory(point)

    def link_displacements(self, t) -> DualQuaternion:
        """The displacements of all links from t = ∞ to t; shape (..., n), t broadcasts against the batch."""
        turns = [_turn(self.joint_factors(n), t) for n in range(len(self) - 1)]
        start = self.factors[0] * 0 + 1  # the identity, in scalars of the linkage's kind
        links = accumulate(turns, lambda link, turn: unit(link * turn), initial=start)
        shape = np.broadcast_shapes(self.shape, np.shape(t))
        return DualQuaternion.stack([_broadcast(link, shape) for link in links], axis=-1)

    def configuration(self, t) -> DualQuaternion:
        """The half-turns about all axes at t; shape (..., n)."""
        links = self.link_displacements(t)
        return unit(links * self.axes * links.conjugate())

    def joint_angles(self, t) -> np.ndarray:
        """The angles that the joints have turned from t = ∞ (+∞ and −∞ differ by one round); radians, (..., n).

        The factor t − f turns by −2 arccot((t − Re f)/|Im f|), so the angles are continuous in t.
        """
        t = as_float(t)
        angles = [self._angle(n, t) for n in range(len(self))]
        return np.stack(np.broadcast_arrays(*angles), axis=-1)

    def _angle(self, joint: int, t: np.ndarray):
        factors = [_as_float(f) for f in self.joint_factors(joint)]
        axis = axis_of(factors[0])
        return sum(-2 * np.arctan2(null_form(f, axis), t - f.scalar_part) for f in factors)

    def relative_motion(self, a: int, b: int) -> MotionPolynomial:
        """The motion of link b as seen from link a, with common real factors taken out."""
        count = len(self)
        ahead, back = (b - a) % count, (a - b) % count
        if ahead <= back:
            chain = [f for n in range(ahead) for f in self.joint_factors((a + n) % count)]
        else:
            backwards = [f for n in range(back) for f in self.joint_factors((b + n) % count)]
            chain = [f.conjugate() for f in reversed(backwards)]
        return _without_real_factors(product_of(chain), chain)

    def closure_residual(self):
        """How far the product of all factors is from a real polynomial, relative to its size; 0 if exact.

        Each coefficient is compared with the same coefficient of Π(t + |f|), dual parts with the longest
        moment among the axes besides.  This measures how well the loop closes, not how near the poses are passed.
        """
        factors = [_broadcast(f, self.shape) for f in self.factors]
        product = DualQuaternion.stack(product_of(factors), axis=-1).coeffs[..., 1:]
        if is_exact(product) and np.all(is_zero(product)):
            return _plain(np.zeros(self.shape))
        primal = [as_float(np.sqrt(as_float(null_form(f, f)))) for f in factors]
        bound = reduce(_times_linear, primal, np.ones((*self.shape, 1)))
        length = np.max([size(f.components[4:], 0) / r for f, r in zip(factors, primal, strict=True)], axis=0)
        turning, shifting = size(product[..., :3], -1) / bound, size(product[..., 3:], -1) / bound
        with np.errstate(invalid="ignore", divide="ignore"):
            shifting = np.where(shifting == 0, 0, shifting / length[..., None])
        return _plain(np.maximum(turning, shifting).max(axis=-1))

    def mobility(self, t=math.inf):
        """The degree of freedom at t: the number of joints less the rank of the axes' Plücker coordinates."""
        lines = self.configuration(t).coeffs[..., [1, 2, 3, 5, 6, 7]]
        if is_exact(lines):
            free = [len(null_space(rows.T)) for rows in lines.reshape(-1, len(self), 6)]
            return _plain(np.reshape(free, lines.shape[:-2]))
        singular = np.linalg.svd(_centred(as_float(lines)), compute_uv=False)
        rank = (singular > RTOL * singular[..., :1]).sum(axis=-1)
        return _plain(len(self) - rank)

    def denavit_hartenberg(self) -> list[DHRow]:
        """One row a link, link n from axis n to axis n + 1 (counted from 1); floats.

        Raises
        ------
        DegenerateError
            If neighbouring axes are parallel: their common perpendicular is not determined.
        """
        axes = Line.from_dual_quaternion(_as_float(self.axes))
        following = Line(np.roll(axes.direction, -1, axis=-2), np.roll(axes.moment, -1, axis=-2))
        start, end = common_perpendicular(axes, following)
        gap = end - start
        distance = np.linalg.norm(gap, axis=-1)
        normal = np.cross(axes.direction, following.direction)
        side = np.where((gap * normal).sum(-1) < 0, -1, 1)
        offset = ((start - np.roll(end, 1, axis=-2)) * axes.direction).sum(-1)
        rows = np.moveaxis(np.stack([distance, side * axes.angle(following), offset]), -1, 0)
        return [DHRow(*row) for row in rows]


def _plain(values):
    """A Python number for a single linkage, an array for a batch."""
    return np.asarray(values).item() if np.ndim(values) == 0 else values


def _broadcast(x: DualQuaternion, shape: tuple[int, ...]) -> DualQuaternion:
    return x if x.shape == shape else DualQuaternion(np.broadcast_to(x.coeffs, (*shape, 8)))


def _as_float(q: DualQuaternion) -> DualQuaternion:
    return DualQuaternion(as_float(q.coeffs))


def _turn(factors, t) -> DualQuaternion:
    """The displacement of a joint from infinity to t."""
    return reduce(lambda q, f: q * evaluate((one, -f), t), factors, one)


def _times_linear(polynomial: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The coefficients of a polynomial times (t + r)."""
    zero = np.zeros((*polynomial.shape[:-1], 1))
    shifted = np.concatenate([zero, polynomial], axis=-1) * np.asarray(r)[..., None]
    return np.concatenate([polynomial, zero], axis=-1) + shifted


def _without_real_factors(coefficients: list[DualQuaternion], factors) -> MotionPolynomial:
    """Divide by each quadratic (t − f)(t − f̄) that divides the polynomial."""
    for f in factors:
        if len(coefficients) < 3:
            break
        quotient, remainder = divide_by_quadratic(coefficients, quadratic_of(f))
        if _negligible(remainder, coefficients):
            coefficients = quotient
    return MotionPolynomial.from_coefficients(coefficients)


def _negligible(remainder, coefficients) -> bool:
    rows = (slice(0, 4), slice(4, 8))
    scales = [max(size(c.coeffs[..., half]) for c in coefficients) for half in rows]
    return all(
        np.all(is_zero(r.coeffs[..., half], scale, rtol=1e-7))
        for r in remainder
        for half, scale in zip(rows, scales, strict=True)
    )


def _centred(lines: np.ndarray) -> np.ndarray:
    """Plücker coordinates (..., n, 6) with respect to the middle of the lines, in units of their spread."""
    direction, moment = lines[..., :3], lines[..., 3:]
    feet = np.cross(direction, moment)
    middle = feet.mean(axis=-2, keepdims=True)
    moment = moment - np.cross(middle, direction)
    spread = np.linalg.norm(moment, axis=-1).max(axis=-1)[..., None, None]
    return np.concatenate([direction, moment / np.where(spread > 0, spread, 1)], axis=-1)
