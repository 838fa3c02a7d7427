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
from kinlib.rows import broadcast, hold_memory, masked
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
    names = [f"pose {n}: " for n in range(len(points))] if len(points) > 1 else [""]
    if all(is_exact(q.components) for q in points):
        return [_checked_exactly(q, name) for q, name in zip(points, names, strict=True)]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        if all(q.components.dtype == float and q.shape == points[0].shape for q in points):
            together = DualQuaternion.stack(points)
            lever = _lever(together)
            return list(_checked(together, lever, np.fmax.reduce(lever, axis=0, initial=0), rtol, names, degenerate))
        length = np.asarray(reduce(np.fmax, [np.nan_to_num(_lever(q)) for q in points]))
        return [
            _checked_exactly(q, name)
            if is_exact(q.components)
            else _checked(DualQuaternion.stack([q]), _lever(q)[None], length, rtol, [name], degenerate)[0]
            for q, name in zip(points, names, strict=True)
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
    """|d| / |p|, in floats; half of how far the origin is moved; NaN in the exceptional space."""
    p, d = (as_float((x * x).sum(axis=0)) for x in (q.components[:4], q.components[4:]))
    return np.asarray(np.sqrt(d / np.where(p > 0, p, np.nan)))


def _checked(
    q: DualQuaternion, lever: Array, length: Array, rtol: float, names: Sequence[str], degenerate: Degenerate
) -> DualQuaternion:
    """The poses that points are meant to be, shape (poses, ...), given their levers and the longest of all."""
    dtype = q.components.dtype
    if dtype.kind == "c":
        raise ValueError(f"{names[0]}expected real coefficients, got complex ones: a pose is a real point")
    precision = rtol if dtype.kind == "O" else max(rtol, 8 * float(np.finfo(dtype).eps))
    q = q.astype(float)
    square, form = null_form(q, q), study_form(q, q)
    off = np.abs(form) / 2
    scale = np.where(square > 0, (lever + _over_other_axes(length, q.shape[1:])) * square, 0.0)
    faults = [
        (~np.isfinite(q.components).all(axis=0), ValueError, lambda n: "expected finite numbers, got NaN or infinity"),
        (square == 0, DegenerateError, lambda n: EXCEPTIONAL),
        (off > precision * scale + ROUNDING * square, ValueError, lambda n: _off_the_quadric(off[n], scale[n])),
    ]
    bad = faults[0][0] | faults[1][0] | faults[2][0]
    if degenerate == "raise" and bad.any():
        _refuse(faults, names)
    return masked(q - eps_times(q) * (form / (2 * square)), bad)


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


def _refuse(faults: Sequence[tuple[Array, type[ValueError], Callable[[int], str]]], names: Sequence[str]) -> None:
    """An error about the first pose that is none."""
    for n, name in enumerate(names):
        for where, error, message in faults:
            if where[n].any():
                raise error(f"{named_rows(np.flatnonzero(where[n]) if where[n].ndim else [])}{name}{message(n)}")


def _checked_exactly(q: DualQuaternion, name: str) -> DualQuaternion:
    if np.any(is_zero(null_form(q, q), rtol=0)):
        raise DegenerateError(name + EXCEPTIONAL)
    off = study_form(q, q)
    if not np.all(is_zero(off)):
        scale = np.fmax(_lever(q), 1e-300) * as_float(null_form(q, q))
        raise ValueError(name + _off_the_quadric(np.abs(as_float(off)) / 2, scale))
    return q


@dataclass(frozen=True)
class PoseProblem:
    """Poses that belong together, and how the others look from the first.

    Parameters
    ----------
    home : DualQuaternion, shape (...)
        The first pose.
    others : DualQuaternion, shape (poses − 1, ...)
        The displacements p_n p_0⁻¹; floats about the middle and in the unit of length, with primal parts of length 1.
    middle : numpy.ndarray, shape (..., 3)
        The point that these displacements move least, seen in the frame of the poses.
    length : numpy.ndarray, shape (...)
        The unit of length, a power of two; 1 about the origin for exact poses.
    noise : numpy.ndarray, shape (...)
        How far rounding of the given numbers may move a dual part, in the unit of length; 0 for exact poses.
    """

    home: DualQuaternion
    others: DualQuaternion
    middle: np.ndarray
    length: np.ndarray
    noise: np.ndarray

    @cached_property
    def steps(self) -> DualQuaternion:
        """The displacements from pose m to pose n, in the order of ``itertools.combinations``, on the first axis."""
        first, second = zip(*combinations(range(len(self.others)), 2), strict=True)
        between = self.others[list(second)] * self.others[list(first)].conjugate()
        between = between if self.is_exact else _on_quadric(between)
        return wrap(np.concatenate([self.others.components, between.components], axis=1))

    @property
    def forms(self) -> Array:
        """The Study forms b(p_m, p_n), in the order of the steps: their dual scalar parts."""
        return self.steps.components[4]

    def outward(self, q: DualQuaternion) -> DualQuaternion:
        """What was found about the middle, in the frame and unit of the poses: half-turns and linear factors."""
        return moved_origin(stretched(q, self.length), -self.middle)

    def inward(self, q: DualQuaternion) -> DualQuaternion:
        """What is given in the frame and unit of the poses, as seen about the middle."""
        return stretched(moved_origin(q, self.middle), divide(1, self.length) if self.is_exact else 1 / self.length)

    def flat(self) -> PoseProblem:
        """The same problems in floats, one after the other."""
        home, others = self.home.components.reshape(8, -1), self.others.components.reshape(8, len(self.others), -1)
        return PoseProblem(
            wrap(home), wrap(others), self.middle.reshape(-1, 3), self.length.reshape(-1), self.noise.reshape(-1)
        )

    def some(self, rows: Array | slice) -> PoseProblem:
        """The problems in floats of some rows, given by a mask or a slice."""
        parts = self.middle[rows], self.length[rows], self.noise[rows]
        return PoseProblem(self.home[rows], self.others[:, rows], *parts)

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
    if shape:
        hold_memory()
    poses = [broadcast(q, shape) for q in poses]
    home, others = poses[0], DualQuaternion.stack(poses[1:])
    seen = unit(others * home.conjugate())
    if exact:
        if any(getattr(c, "free_symbols", None) for q in poses for c in q.components.ravel()):
            raise ValueError("the poses contain symbols: the roots that are needed have no closed form; put in numbers")
        return PoseProblem(home, seen, np.zeros(3, dtype=int), np.array(1), np.array(0))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        together = DualQuaternion.stack(poses)
        middle = middle_of(seen, _place(together).mean(axis=0))
        centred = moved_origin(seen, middle)
        length = power_of_two(np.abs(centred.components[4:]).max(axis=(0, 1)))
        noise = np.asarray(np.finfo(float).eps * _lever(together).max(axis=0) / length)
        return PoseProblem(home, _on_quadric(stretched(centred, 1 / length)), middle, length, noise)


def _on_quadric(q: DualQuaternion) -> DualQuaternion:
    """The pose that is meant, from a dual part with some noise: p0 d0 + p1 d1 + p2 d2 + p3 d3 becomes 0.

    Near the identity d0 is made anew from the others, since it is much smaller than they are; else d loses its
    component along p.
    """
    p, d = q.components[:4], q.components[4:]
    square, real = null_form(q, q), p[0] * p[0]
    near = 2 * real > square
    along = (p * d).sum(axis=0)
    components = np.concatenate([p, d - p * np.where(near, 0, along / square)])
    if near.any():
        anew = -(p[1:] * d[1:]).sum(axis=0) / np.where(near, p[0], 1)
        components[4] = np.where(near, anew, components[4])
    return wrap(components)


def moved_origin(q: DualQuaternion, origin: np.ndarray) -> DualQuaternion:
    """The same displacement seen from another origin, shape (..., 3): 1 − ½εc times q times 1 + ½εc is q + ε(p × c)."""
    origin = np.asarray(origin, dtype=np.result_type(q.components, origin))  # whole numbers of Python beside exact ones
    p0, p1, p2, p3, d0, d1, d2, d3 = q.components
    c1, c2, c3 = origin.transpose(-1, *range(origin.ndim - 1))
    moment = d1 + (p2 * c3 - p3 * c2), d2 + (p3 * c1 - p1 * c3), d3 + (p1 * c2 - p2 * c1)
    moved = np.empty((8, *np.shape(moment[0])), dtype=origin.dtype)
    for n, row in enumerate((p0, p1, p2, p3, d0, *moment)):
        moved[n] = row
    return wrap(moved)


def stretched(q: DualQuaternion, factor: Array | float) -> DualQuaternion:
    """All lengths multiplied by a factor, shape (...); batches broadcast."""
    if np.ndim(factor) > len(q.shape):
        q = wrap(q.components.reshape(8, *(1,) * (np.ndim(factor) - len(q.shape)), *q.shape))
    return wrap(np.concatenate(np.broadcast_arrays(q.components[:4], q.components[4:] * factor)))


def middle_of(
    seen: DualQuaternion | Sequence[DualQuaternion], start: np.ndarray | float = 0.0, steps: int = 2
) -> np.ndarray:
    """The point that displacements move least, or one near the start that they move hardly more.

    Each step goes to the c with least Σ |d + p × c|², damped so that it does not run far along an axis that all
    displacements nearly share.

    Parameters
    ----------
    seen : DualQuaternion, shape (displacements, ...), or a sequence of them
    start : array, shape (..., 3)
    steps : int
    """
    seen, middle = seen if isinstance(seen, DualQuaternion) else DualQuaternion.stack(seen), np.zeros(3) + start
    p = seen.components[1:4]
    squares = (p[:, None] * p).sum(axis=2)
    for _ in range(steps):
        middle = middle + _step_to_middle(squares, p, moved_origin(seen, middle).components[5:])
    return middle


def _step_to_middle(squares: np.ndarray, p: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The solution of (Σ |p|² − p pᵀ) c = Σ p × d, damped; given Σ p pᵀ and p, d with their components first."""
    (xx, xy, zx), (_, yy, yz), (_, _, zz) = squares
    (_, pd12, pd13), (pd21, _, pd23), (pd31, pd32, _) = (p[:, None] * d).sum(axis=2)
    right = pd23 - pd32, pd31 - pd13, pd12 - pd21
    slack = DAMPING * (xx + yy + zz)
    a, b, c = yy + zz + slack, zz + xx + slack, xx + yy + slack
    mxy, myz, mzx = c * xy + zx * yz, a * yz + xy * zx, b * zx + xy * yz
    rows = (b * c - yz * yz, mxy, mzx), (mxy, a * c - zx * zx, myz), (mzx, myz, a * b - xy * xy)
    determinant = a * rows[0][0] - xy * mxy - zx * mzx
    scale = np.where(determinant > 0, determinant, np.inf)
    step = np.stack([(l * right[0] + m * right[1] + n * right[2]) / scale for l, m, n in rows], axis=-1)
    return np.where(np.isfinite(step), step, 0)


DAMPING = 1e-6
"""The square of the angle below which turns about nearly one axis do not tell where along it the middle is."""


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
    defined = np.isfinite(length) & (length > 0)
    return np.where(defined, np.ldexp(1.0, np.frexp(np.where(defined, length, 1.0))[1]), 1.0)


def gap(reached: DualQuaternion, wanted: DualQuaternion, *, length: Array | float = 1.0) -> np.ndarray:
    """How far one displacement is from another, in half-angles and in parts of a length; 0 or infinite if exact.

    Both may be any representatives: it is the vector part of their quotient, divided by its scalar part.
    """
    difference = wanted.conjugate() * reached
    turned, shifted = difference.components[1:4], difference.components[5:8]
    if is_exact(turned):
        return np.where(np.all(is_zero(turned) & is_zero(shifted), axis=0), 0.0, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.abs(difference.scalar_part)
        return np.maximum(np.abs(turned).max(axis=0), np.abs(shifted).max(axis=0) / length) / scale


def opening(first: DualQuaternion, second: DualQuaternion) -> np.ndarray:
    """How far the ends of two chains are apart, in half-angles and in parts of how far they have moved."""
    if is_exact(first.components):
        return gap(second, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        return gap(second, first, length=1.0 + dual_size(first) / primal_size(first))
