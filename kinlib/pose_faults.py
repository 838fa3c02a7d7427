"""What can be wrong with three poses, and how near they are to that."""

from __future__ import annotations

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.errors import Fault, first_fault
from kinlib.poses import PoseProblem
from kinlib.scalar import as_float, is_exact, is_zero

__all__ = ["PoseFault"]

MEETS = "the plane of the three poses meets the exceptional three-space"
TANGENT = (
    "poses {} and {} differ by a rotation, so the plane of the three poses is tangent to the Study quadric: there are "
    "two 2R dyads, which method='eigenvalues' finds, but no conic and no Bennett linkage"
)


class PoseFault(Fault):
    """What can be wrong with three poses."""

    EQUAL_01 = 1, "poses 0 and 1 are equal: three different poses are needed"
    EQUAL_02 = 2, "poses 0 and 2 are equal: three different poses are needed"
    EQUAL_12 = 3, "poses 1 and 2 are equal: three different poses are needed"
    SLIDE_01 = 4, f"{MEETS}: poses 0 and 1 differ by a pure translation"
    SLIDE_02 = 5, f"{MEETS}: poses 0 and 2 differ by a pure translation"
    SLIDE_12 = 6, f"{MEETS}: poses 1 and 2 differ by a pure translation"
    PARALLEL = 7, f"{MEETS}: the three orientations differ by rotations about parallel axes"
    INSIDE = (
        8,
        "the plane of the three poses lies in the Study quadric: no 2R space contains it, as its quadric is regular",
    )
    DOUBLE = 9, "the quartic of the three poses has double roots: one 2R dyad passes through them, not two"
    TANGENT_01 = 10, TANGENT.format(0, 1)
    TANGENT_02 = 11, TANGENT.format(0, 2)
    TANGENT_12 = 12, TANGENT.format(1, 2)
    INVALID = 13, "a number is not finite, or a pose is none"


EQUAL = (PoseFault.EQUAL_01, PoseFault.EQUAL_02, PoseFault.EQUAL_12)
SLIDE = (PoseFault.SLIDE_01, PoseFault.SLIDE_02, PoseFault.SLIDE_12)
TANGENTS = (PoseFault.TANGENT_01, PoseFault.TANGENT_02, PoseFault.TANGENT_12)

APART = 1e-12
"""How near a plane may come to the exceptional space before rounding decides what is found."""

SHIFT = 1e-10
"""How far apart two poses of one orientation may be, in the unit of the problem, and still count as equal."""


def faults_of_poses(problem: PoseProblem) -> np.ndarray:
    """What is wrong with three poses themselves, whatever is asked of them: a PoseFault a row, or 0."""
    undefined, still, rotations = _not_finite(problem), _are_still(problem), _are_rotations(problem)
    parallel = _sine(problem) <= (0 if problem.is_exact else APART)
    inside = rotations.all(axis=0)
    if not (undefined | still.any(axis=0) | parallel | inside).any():
        return np.zeros(inside.shape, dtype=int)
    return first_fault(
        (undefined, PoseFault.INVALID),
        *zip(still & _are_near(problem), EQUAL, strict=True),
        *zip(still, SLIDE, strict=True),
        (parallel, PoseFault.PARALLEL),
        (inside, PoseFault.INSIDE),
    )


def tangent_faults(problem: PoseProblem) -> np.ndarray:
    """Which two poses differ by a rotation, so that there is no conic: a PoseFault a row, or 0."""
    rotations = _are_rotations(problem)
    if not rotations.any():
        return np.zeros(rotations.shape[1:], dtype=int)
    return first_fault(*zip(rotations, TANGENTS, strict=True))


def nearest_fault(problem: PoseProblem) -> tuple[np.ndarray, np.ndarray]:
    """The fault that each row is nearest to, and how near, relative to the size of what vanishes there."""
    turns, shifts = (_largest(problem.steps.components[part]) for part in (slice(1, 4), slice(4, 8)))
    forms = np.abs(problem.forms)
    measured = [
        *zip(np.maximum(turns, shifts), EQUAL, strict=True),
        *zip(turns / (turns + shifts), SLIDE, strict=True),
        (_sine(problem), PoseFault.PARALLEL),
        *zip(forms / (turns * shifts), TANGENTS, strict=True),
    ]
    sizes = np.array([np.broadcast_to(np.nan_to_num(size, nan=np.inf), problem.home.shape) for size, _ in measured])
    return np.array([int(fault) for _, fault in measured])[np.argmin(sizes, axis=0)], sizes.min(axis=0)


def _are_rotations(problem: PoseProblem) -> np.ndarray:
    """Whether the steps are rotations: b divided by the sine of the half-angle is the pitch, up to a factor."""
    turns = _largest(problem.steps.components[1:4])
    return np.asarray(is_zero(problem.forms, turns, 1e-14 + 4 * problem.noise))


def _not_finite(problem: PoseProblem) -> np.ndarray:
    return ~np.isfinite(as_float(problem.others.components)).all(axis=(0, 1))


def _largest(rows: np.ndarray) -> np.ndarray:
    return np.abs(as_float(rows)).max(axis=0)


def _are_still(problem: PoseProblem) -> np.ndarray:
    """Whether the steps do not turn."""
    return np.all(is_zero(problem.steps.components[1:4], 1.0, APART), axis=0)


def _are_near(problem: PoseProblem) -> np.ndarray:
    """Whether steps that do not turn do not shift either."""
    return np.all(is_zero(problem.steps.components[4:], 1.0, SHIFT + problem.noise), axis=0)


def distance_from_exceptional_space(others: DualQuaternion) -> np.ndarray:
    """How far the plane of [1], [q1], [q2] is from the exceptional space: 0 if the turns have parallel axes."""
    a, b = np.moveaxis(others.components[1:4], 1, 0)
    cross = np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    if is_exact(cross):
        return np.where(np.all(is_zero(cross), axis=0), 0.0, 1.0)
    longest = np.sqrt((others.components[1:4] ** 2).sum(axis=0).max(axis=0))
    return np.sqrt((cross * cross).sum(axis=0)) / np.where(longest > 0, longest, 1)


def _sine(problem: PoseProblem) -> np.ndarray:
    """The sine of the angle between the axes of the turns from the first pose."""
    turns = _largest(problem.others.components[1:4]).min(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        sine = distance_from_exceptional_space(problem.others) / turns
    return np.where(np.isnan(sine), 1.0, sine)
