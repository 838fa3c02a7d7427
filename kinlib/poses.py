"""Several poses of one problem: judged in each other's company, seen from the first and from their middle.

How much rounding has made of a pose can only be told from the numbers that were rounded, and these are as large as the
whole problem.  So the poses of a problem are judged together.  In floats they are then looked at from the middle of
their displacements and in their own unit of length: neither the origin, nor the unit, nor the representatives matter
to what is computed.  Exact poses stay as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import combinations

import numpy as np

from kinlib.displacement import from_matrix, unit
from kinlib.dual_quaternion import (
    DualQuaternion,
    dual_size,
    eps_times,
    null_form,
    primal_size,
    study_form,
    wrap,
)
from kinlib.errors import DegenerateError, check_degenerate, named_rows
from kinlib.rows import masked
from kinlib.scalar import ROUNDING, RTOL, as_float, divide, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, Degenerate, PoseLike, RigidTransformLike

__all__ = ["as_pose"]


def as_pose(x: PoseLike, *, rtol: float = RTOL) -> DualQuaternion:
    """A pose given as dual quaternion, 4×4 matrix or SciPy ``RigidTransform``, checked.

    Parameters
    ----------
    x : DualQuaternion of shape (...), matrices of shape (..., 4, 4), or RigidTransform
    rtol : float
        How far a float may be from a pose, relative to its size; then the nearest pose is taken.

    Returns
    -------
    DualQuaternion
        A point of the Study quadric, exact for exact input.

    Raises
    ------
    ValueError
        If a number is not real and finite, or the point is not on the Study quadric.
    DegenerateError
        If the point lies in the exceptional space: no displacement belongs to it.

    Examples
    --------
    >>> as_pose(1 + eps * i)
    1 + εi
    >>> as_pose(1 + eps)
    Traceback (most recent call last):
    ...
    ValueError: expected a point of the Study quadric, p d̄ + d p̄ = 0; here it is 1 times |p||d|: \
give a larger rtol= for rounded numbers, or take study_projection
    """
    return as_poses(x, rtol=rtol)[0]


def as_poses(*given: PoseLike, rtol: float = RTOL, degenerate: Degenerate = "raise") -> list[DualQuaternion]:
    """Poses of one problem, judged in each other's company; rows that are none become NaN if asked."""
    check_degenerate(degenerate)
    points = [_point(x, rtol) for x in given]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        exact = all(is_exact(q.components) for q in points)
        length = 0 if exact else reduce(np.maximum, [np.nan_to_num(_lever(q)) for q in points])
        return [
            _checked(q, length, rtol, f"pose {n}: " if len(given) > 1 else "", degenerate) for n, q in enumerate(points)
        ]


def _point(x: PoseLike, rtol: float) -> DualQuaternion:
    if isinstance(x, DualQuaternion):
        return x
    if isinstance(x, RigidTransformLike):
        x = x.as_matrix()
    if np.asarray(x).ndim < 2:
        raise TypeError(f"expected a pose: a DualQuaternion, a 4×4 matrix or a RigidTransform, got {x!r}")
    return from_matrix(x, rtol=rtol)


def _lever(q: DualQuaternion) -> Array:
    """|d| / |p|, in floats; half of how far the origin is moved."""
    p, d = (as_float(np.sqrt(as_float((x * x).sum(axis=0)))) for x in (q.components[:4], q.components[4:]))
    return d / np.where(p > 0, p, np.nan)


def _checked(q: DualQuaternion, length: ArrayLike, rtol: float, name: str, degenerate: Degenerate) -> DualQuaternion:
    """The pose that a point is meant to be."""
    if q.components.dtype.kind == "c":
        raise ValueError(f"{name}expected real coefficients, got complex ones: a pose is a real point")
    if is_exact(q.components):
        return _checked_exactly(q, name)
    precision = max(rtol, 8 * float(np.finfo(q.components.dtype).eps)) if q.components.dtype.kind == "f" else rtol
    q = q.astype(float)
    p = np.sqrt(null_form(q, q))
    off = np.abs(study_form(q, q)) / 2
    lever = np.where(p > 0, _lever(q) + _over_other_axes(length, p.shape), 0.0)
    faults = [
        (~np.isfinite(q.components).all(axis=0), ValueError, lambda: "expected finite numbers, got NaN or infinity"),
        (p == 0, DegenerateError, lambda: EXCEPTIONAL),
        (off > (precision * lever + ROUNDING) * p * p, ValueError, lambda: _off_the_quadric(off, lever * p * p)),
    ]
    bad = [_refused(where, error, name, message, degenerate) for where, error, message in faults]
    projected = q - eps_times(q) * (study_form(q, q) / (2 * p * p))
    return masked(projected, np.logical_or.reduce(bad))


def _over_other_axes(length: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """The largest of the lengths that one row meets where batches of several shapes are combined."""
    lengths = np.asarray(length)
    lengths = lengths.max(axis=tuple(range(lengths.ndim - len(shape))), initial=0)
    single = tuple(n for n, size in enumerate(shape) if size == 1 and lengths.shape[n] != 1)
    return lengths.max(axis=single, keepdims=True, initial=0)


EXCEPTIONAL = "the point lies in the exceptional three-space: its primal part is zero, so it is no pose"


def _off_the_quadric(off: Array, scale: Array) -> str:
    worst = np.nanmax(np.where(scale > 0, off / np.where(scale > 0, scale, 1), 0), initial=0)
    return (
        f"expected a point of the Study quadric, p d̄ + d p̄ = 0; here it is {worst:.2g} times |p||d|: "
        "give a larger rtol= for rounded numbers, or take study_projection"
    )


def _refused(
    where: Array, error: type[ValueError], name: str, message: Callable[[], str], degenerate: Degenerate
) -> Array:
    if degenerate == "raise" and np.any(where):
        raise error(f"{named_rows(np.flatnonzero(where) if np.ndim(where) else [])}{name}{message()}")
    return where


def _checked_exactly(q: DualQuaternion, name: str) -> DualQuaternion:
    if np.any(is_zero(null_form(q, q), rtol=0)):
        raise DegenerateError(name + EXCEPTIONAL)
    off = study_form(q, q)
    if not np.all(is_zero(off)):
        scale = np.maximum(_lever(q), 1e-300) * as_float(null_form(q, q))
        raise ValueError(name + _off_the_quadric(np.abs(as_float(off)) / 2, scale))
    return q


@dataclass(frozen=True)
class PoseProblem:
    """Poses that belong together, and how the others look from the first.

    Parameters
    ----------
    home : DualQuaternion, shape (...)
        The first pose.
    others : tuple of DualQuaternion
        The displacements p_n p_0⁻¹; floats about the middle and in the unit of length, with primal parts of length 1.
    middle : numpy.ndarray, shape (..., 3)
        The point that these displacements move least, seen in the frame of the poses.
    length : numpy.ndarray, shape (...)
        The unit of length, a power of two; 1 about the origin for exact poses.
    noise : numpy.ndarray, shape (...)
        How far rounding of the given numbers may move a dual part, in the unit of length; 0 for exact poses.
    """

    home: DualQuaternion
    others: tuple[DualQuaternion, ...]
    middle: np.ndarray
    length: np.ndarray
    noise: np.ndarray

    @cached_property
    def steps(self) -> tuple[DualQuaternion, ...]:
        """The displacements from pose m to pose n, in the order of ``itertools.combinations``."""
        between = (q * p.conjugate() for p, q in combinations(self.others, 2))
        return *self.others, *(between if self.is_exact else map(_on_quadric, between))

    @cached_property
    def forms(self) -> tuple[Array, ...]:
        """The Study forms b(p_m, p_n), in the order of the steps: their dual scalar parts."""
        return tuple(step.components[4] for step in self.steps)

    def outward(self, q: DualQuaternion) -> DualQuaternion:
        """What was found about the middle, in the frame and unit of the poses: half-turns and linear factors."""
        return moved_origin(stretched(q, self.length), -self.middle)

    def inward(self, q: DualQuaternion) -> DualQuaternion:
        """What is given in the frame and unit of the poses, as seen about the middle."""
        return stretched(moved_origin(q, self.middle), divide(1, self.length) if self.is_exact else 1 / self.length)

    @property
    def is_exact(self) -> bool:
        """Whether nothing is rounded."""
        return is_exact(self.home.components)


def seen_together(*given: PoseLike, degenerate: Degenerate = "raise", rtol: float = RTOL) -> PoseProblem:
    """The poses as one problem; batches are broadcast against each other."""
    poses = as_poses(*given, rtol=rtol, degenerate=degenerate)
    exact = all(is_exact(q.components) for q in poses)
    if not exact:
        poses = [DualQuaternion(as_float(q.coeffs)) for q in poses]
    shape = np.broadcast_shapes(*[q.shape for q in poses])
    home, *others = (q if q.shape == shape else DualQuaternion(np.broadcast_to(q.coeffs, (*shape, 8))) for q in poses)
    seen = [unit(q * home.conjugate()) for q in others]
    if exact:
        if any(getattr(c, "free_symbols", None) for q in poses for c in q.components.ravel()):
            raise ValueError("the poses contain symbols: the roots that are needed have no closed form; put in numbers")
        return PoseProblem(home, tuple(seen), np.zeros(3, dtype=int), np.array(1), np.array(0))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        middle = middle_of(seen, sum(_place(q) for q in poses) / len(poses))
        centred = [moved_origin(q, middle) for q in seen]
        length = power_of_two(reduce(np.maximum, [np.abs(q.components[4:]).max(axis=0) for q in centred]))
        lever = reduce(np.maximum, [_lever(q) for q in poses])
        scaled = tuple(_on_quadric(stretched(q, 1 / length)) for q in centred)
        return PoseProblem(home, scaled, middle, length, np.finfo(float).eps * lever / length)


def _on_quadric(q: DualQuaternion) -> DualQuaternion:
    """The pose that is meant, from a dual part with some noise: p0 d0 + p1 d1 + p2 d2 + p3 d3 becomes 0.

    Near the identity d0 is made anew from the others, since it is much smaller than they are; else d loses its
    component along p.
    """
    p, d = q.components[:4], q.components[4:]
    square = p * p
    near = 2 * square[0] > square.sum(axis=0)
    along = (p * d).sum(axis=0)
    shift = np.where(near, 0, along / square.sum(axis=0))
    components = np.concatenate([p, d - p * shift])
    components[4] = np.where(near, -(p[1:] * d[1:]).sum(axis=0) / np.where(near, p[0], 1), components[4])
    return wrap(components)


def moved_origin(q: DualQuaternion, origin: np.ndarray) -> DualQuaternion:
    """The same displacement seen from another origin, shape (..., 3): 1 − ½εc times q times 1 + ½εc is q + ε(p × c)."""
    p0, p1, p2, p3, d0, d1, d2, d3 = q.components
    c1, c2, c3 = np.moveaxis(np.asarray(origin), -1, 0)
    moment = d1 + (p2 * c3 - p3 * c2), d2 + (p3 * c1 - p1 * c3), d3 + (p1 * c2 - p2 * c1)
    return wrap(np.stack(np.broadcast_arrays(p0, p1, p2, p3, d0, *moment)))


def stretched(q: DualQuaternion, factor: Array | float) -> DualQuaternion:
    """All lengths multiplied by a factor, shape (...); batches broadcast."""
    missing = max(np.ndim(factor) - len(q.shape), 0)
    components = q.components.reshape(8, *(1,) * missing, *q.shape)
    return wrap(np.concatenate(np.broadcast_arrays(components[:4], components[4:] * factor)))


def middle_of(seen: Sequence[DualQuaternion], start: np.ndarray | float = 0.0, steps: int = 2) -> np.ndarray:
    """The point that displacements move least, or one near the start that they move hardly more.

    Each step goes to the c with least Σ |d + p × c|², damped so that it does not run far along an axis that all
    displacements nearly share.
    """
    middle = np.zeros(3) + start
    for _ in range(steps):
        middle = middle + _step_to_middle([moved_origin(q, middle) for q in seen])
    return middle


def _step_to_middle(seen: Sequence[DualQuaternion]) -> np.ndarray:
    """The solution of (Σ |p|² − p pᵀ) c = Σ p × d, damped."""
    p1, p2, p3, d1, d2, d3 = np.stack([q.components[[1, 2, 3, 5, 6, 7]] for q in seen], axis=-1)
    right = [_sum(x) for x in (p2 * d3 - p3 * d2, p3 * d1 - p1 * d3, p1 * d2 - p2 * d1)]
    xx, yy, zz, xy, yz, zx = (_sum(x) for x in (p1 * p1, p2 * p2, p3 * p3, p1 * p2, p2 * p3, p3 * p1))
    slack = DAMPING * (xx + yy + zz)
    a, b, c = yy + zz + slack, zz + xx + slack, xx + yy + slack
    mxy, myz, mzx = c * xy + zx * yz, a * yz + xy * zx, b * zx + xy * yz
    rows = (b * c - yz * yz, mxy, mzx), (mxy, a * c - zx * zx, myz), (mzx, myz, a * b - xy * xy)
    determinant = a * rows[0][0] - xy * mxy - zx * mzx
    scale = np.where(determinant > 0, determinant, np.inf)
    step = np.stack([sum(m * x for m, x in zip(row, right, strict=True)) / scale for row in rows], axis=-1)
    return np.where(np.isfinite(step), step, 0)


DAMPING = 1e-6
"""The square of the angle below which turns about nearly one axis do not tell where along it the middle is."""


def _sum(x: np.ndarray) -> np.ndarray:
    return x.sum(axis=-1)


def _place(q: DualQuaternion) -> np.ndarray:
    """Where a displacement takes the origin: the vector part of 2 d p̄ / (p p̄), shape (..., 3)."""
    p0, p1, p2, p3, d0, d1, d2, d3 = q.components
    shift = np.stack([
        p0 * d1 - d0 * p1 + p2 * d3 - p3 * d2,
        p0 * d2 - d0 * p2 + p3 * d1 - p1 * d3,
        p0 * d3 - d0 * p3 + p1 * d2 - p2 * d1,
    ], axis=-1)  # fmt: skip
    return 2 * shift / null_form(q, q)[..., None]


def power_of_two(length: np.ndarray) -> np.ndarray:
    """The power of two next above a length; 1 for none at all."""
    return np.where(np.isfinite(length) & (length > 0), np.ldexp(1.0, np.frexp(np.nan_to_num(length))[1]), 1.0)


def gap(reached: DualQuaternion, wanted: DualQuaternion, *, length: Array | float = 1.0) -> np.ndarray:
    """How far one displacement is from another, in half-angles and in parts of a length; 0 or infinite if exact.

    Both may be any representatives: it is the vector part of their quotient, divided by its scalar part.
    """
    difference = wanted.conjugate() * reached
    turned, shifted = difference.components[1:4], difference.components[5:8]
    if is_exact(turned):
        return np.where(np.all(is_zero(turned) & is_zero(shifted), axis=0), 0.0, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.maximum(np.abs(turned).max(axis=0), np.abs(shifted).max(axis=0) / length)
        return off / np.abs(difference.scalar_part)


def opening(first: DualQuaternion, second: DualQuaternion) -> np.ndarray:
    """How far the ends of two chains are apart, in half-angles and in parts of how far they have moved."""
    if is_exact(first.components):
        return gap(second, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        return gap(second, first, length=1.0 + dual_size(first) / primal_size(first))
