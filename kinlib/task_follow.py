"""A linkage that is carried along data that change, by continuation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.scalar import as_float
from kinlib.task import Datum
from kinlib.task_linkages import MISSED, balanced, linkages_of
from kinlib.task_problem import TaskProblem
from kinlib.task_search import Search, Unknowns
from kinlib.typing import PoseLike

__all__ = ["follow"]

STEPS = 8
"""Newton's steps for each change of the data."""

LONGEST = 0.5
"""The first of them may change no unknown by more, in radians or in parts of the size of the problem."""


def follow(linkage: Linkage, home: PoseLike, path: Sequence[Sequence[Datum]]) -> tuple[Linkage, ...]:
    """A linkage that meets data, and what becomes of it while they change: as far as it can be followed.

    Each linkage is found from the one before by Newton's method.  The way ends where real solutions come together and
    vanish, or where the data change too much at once.

    Parameters
    ----------
    linkage : Linkage
        One that meets the first data, such as :func:`~kinlib.goldberg_linkages_for` gives for them.
    home : PoseLike
        The pose of the coupler at t = ∞.
    path : sequence of sequences of :class:`task.Datum`
        The data at the beginning, and after each change: of the same kinds, in the same order.

    Returns
    -------
    tuple of Linkage
        For the first data, the given one; then one for each of the others, at most as many as the path has.  Each was
        checked as those of :func:`~kinlib.goldberg_linkages_for` are.

    Raises
    ------
    ValueError
        If the linkage does not meet the first data.

    Examples
    --------
    >>> from kinlib import bennett_linkages_for, task, translation
    >>> from kinlib.gallery import THREE_POSES
    >>> home, first, second = THREE_POSES
    >>> path = [[task.Pose(first), task.Pose(translation([0, 0, z]) * second)] for z in (0.0, 0.1, 0.2)]
    >>> linkage, = bennett_linkages_for(home, path[0], starts=20)
    >>> [found.joint_count for found in follow(linkage, home, path)]
    [4, 4, 4]
    """
    _check_met(linkage, TaskProblem.of(home, path[0]))
    found = [linkage]
    for data in path[1:]:
        problem = TaskProblem.of(home, data)
        search = Search(tuple(linkage.joints[: linkage.coupler]), problem.conditions())
        solution = _arrived(search, _unknowns(problem, found[-1]))
        if solution is None:
            break
        candidates = list(linkages_of(problem, search, balanced(solution), 0))
        if not candidates:
            break
        found.append(min(candidates, key=lambda candidate: _apart(candidate, found[-1])))
    return tuple(found)


def _check_met(linkage: Linkage, problem: TaskProblem) -> None:
    data = problem.data
    if len(linkage.parameters) != len(data) + 1:
        raise ValueError(f"expected {len(linkage.parameters) - 1} data, as the linkage has parameters, got {len(data)}")
    poses = map(linkage.coupler_motion, linkage.parameters[1:])
    off = max(problem.missed(pose, datum) for pose, datum in zip(poses, data, strict=True))
    if off > 100 * (MISSED + problem.noise):
        raise ValueError(f"the linkage misses the first data by {off:.2g}: there is nothing to be followed")


def _unknowns(problem: TaskProblem, linkage: Linkage) -> Unknowns:
    """The first chain of a linkage as the search has it: the last number z is √−1."""
    joints = linkage.joints[: linkage.coupler]
    factors = [problem.inward(f) for f in linkage.factors[: sum(joints)]]
    owner = np.repeat(np.arange(len(joints)), joints)
    first = [factors[int(np.flatnonzero(owner == n)[0])] for n in range(len(joints) - 1)] + [factors[-1]]
    lengths = [np.linalg.norm(f.coeffs[1:4]) for f in first]
    l = np.array([f.coeffs[1:4] / length for f, length in zip(first, lengths, strict=True)])
    p = np.array([np.cross(x, f.coeffs[5:] / length) for x, f, length in zip(l, first, lengths, strict=True)])
    z = np.array([f.coeffs[0] + 1j * (f.coeffs[1:4] @ l[n]) for f, n in zip(factors, owner, strict=True)])
    t = as_float(np.array(linkage.parameters[1:]))
    phi = np.arctan2(1.0, (t - z[-1].real) / z[-1].imag)
    return Unknowns(l.T[..., None], p.T[..., None], ((z - z[-1].real) / z[-1].imag)[:, None], phi[:, None])


def _arrived(search: Search, unknowns: Unknowns) -> Unknowns | None:
    """The solution next to a chain, if Newton's method gets there by short steps."""
    values, matrix = search.derivatives(unknowns)
    if np.abs(np.linalg.pinv(matrix, rcond=1e-10) @ values.T[..., None]).max() > LONGEST:
        return None
    solution = search.polished(unknowns, STEPS)
    return solution if solution.count else None


def _apart(linkage: Linkage, other: Linkage) -> float:
    """How far the axes of two linkages are from each other, as points of P⁷ of length 1."""
    return sum(
        min(float(np.linalg.norm((a - b).coeffs)), float(np.linalg.norm((a + b).coeffs)))
        for a, b in zip(_axes(linkage), _axes(other), strict=True)
    )


def _axes(linkage: Linkage) -> list[DualQuaternion]:
    axes = [DualQuaternion(row) for row in as_float(linkage.axes.coeffs)]
    return [h / float(np.linalg.norm(h.coeffs[1:4])) for h in axes]
