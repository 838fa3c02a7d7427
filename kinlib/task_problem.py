"""Data as one problem: in the fixed frame at home, about their own middle and in units of their own size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinlib import task
from kinlib.displacement import act, as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.poses import as_pose, moved_origin, stretched
from kinlib.scalar import as_float
from kinlib.task_search import Conditions, normals_of
from kinlib.typing import Array, ArrayLike, PoseLike

__all__ = ["TaskProblem"]

LOOSE = 1e-3
"""Directions in which the data hold their middle less than this are left to the home pose."""


@dataclass(frozen=True)
class TaskProblem:
    """A home pose and data, in floats.

    Parameters
    ----------
    home : DualQuaternion
        The pose at t = ∞.
    data : tuple of Datum
    middle : numpy.ndarray, shape (3,)
        The point of the fixed frame that is nearest to all that the data are about.
    length : float
        How far that is from it on average, in units of length.
    """

    home: DualQuaternion
    data: tuple[task.Datum, ...]
    middle: Array
    length: float

    @classmethod
    def of(cls, home: PoseLike, data: Sequence[task.Datum]) -> TaskProblem:
        """The problem that is given.

        Raises
        ------
        TypeError
            If something is no datum.
        ValueError
            If there are batches: each problem is a search of its own.
        """
        if isinstance(data, task.Datum) or not isinstance(data, Sequence):
            raise TypeError(f"expected a sequence of data such as task.Pose or task.Point, got {data!r}")
        for datum in data:
            if not isinstance(datum, task.Datum):
                raise TypeError(f"expected data such as task.Pose or task.Point, got {datum!r}")
        pose = as_pose(home)
        if pose.shape or any(datum.shape for datum in data):
            raise ValueError("expected a single home pose and single data: a batch is a search for each of its rows")
        pose = DualQuaternion(as_float(pose.coeffs))
        start = as_float(act(pose, [0, 0, 0]))
        matrix, right, blocks = _pulls(pose, data, start)
        middle = start + np.linalg.lstsq(matrix, right, rcond=LOOSE)[0] if len(right) else start
        off = matrix @ (middle - start) - right
        length = float(np.sqrt((off**2).sum() / max(blocks, 1)))
        return cls(pose, tuple(data), middle, length or 1.0)

    def conditions(self) -> Conditions:
        """What the search needs to know."""
        return _conditions(self)

    def outward(self, q: DualQuaternion) -> DualQuaternion:
        """What was found about the middle, in the frame and unit of the data."""
        return moved_origin(stretched(q, self.length), -self.middle)

    def missed(self, pose: DualQuaternion, datum: task.Datum) -> float:
        """How far a pose is from a datum, in radians and in units of the size of the problem."""
        near = act(pose.inverse(), self.middle)
        return max(float(part.residual(pose, length=self.length)) for part in datum.parts(near))

    @property
    def noise(self) -> float:
        """What rounding of the given numbers makes of this."""
        reach = max(np.abs(self.middle).max(), _place(self.home, self.home, self.middle))
        return float(64 * np.finfo(float).eps * (1 + reach / self.length))


def _place(home: DualQuaternion, pose: DualQuaternion, middle: Array) -> float:
    """How far the middle is from the origin of the moving frame."""
    return float(np.abs(as_float(act(home.inverse(), middle))).max())


def _pulls(home: DualQuaternion, data: Sequence[task.Datum], start: Array) -> tuple[Array, Array, int]:
    """The equations for the middle, as seen from a start, one block for each thing that it should be near."""
    blocks = [block for datum in data for block in _blocks(home, datum)]
    matrix = np.concatenate([a for a, _ in blocks]) if blocks else np.zeros((0, 3))
    right = np.concatenate([b - a @ start for a, b in blocks]) if blocks else np.zeros(0)
    return matrix, right, len(blocks)


def _blocks(home: DualQuaternion, datum: task.Datum) -> list[tuple[Array, Array]]:
    """The equations that a point lies where a datum takes place: at home and afterwards."""
    if isinstance(datum, task.Pose):
        step = as_float(as_matrix(as_pose(datum.pose).astype(float) * home.inverse()))
        return [(step[:3, :3] - np.eye(3), -step[:3, 3])]
    if isinstance(datum, task.Line):
        return [_beside(line) for line in (act(home, datum.line), datum.to)]  # type: ignore[arg-type]
    blocks = []
    for part in datum.parts():
        if isinstance(part, task.Point | task.PointOnLine):
            blocks.append((np.eye(3), as_float(act(home, part.point))))
            blocks.append((np.eye(3), as_float(part.to)) if isinstance(part, task.Point) else _beside(part.line))
    return blocks


def _beside(line: task.LineLike) -> tuple[Array, Array]:
    """The equations of a line."""
    direction, foot = _unit(line.direction), as_float(line.foot())  # type: ignore[union-attr]
    across = np.stack(normals_of(direction))
    return across, across @ foot


def _unit(direction: ArrayLike) -> Array:
    vector = np.asarray(as_float(direction))
    return vector / np.linalg.norm(vector)


def _conditions(problem: TaskProblem) -> Conditions:
    home, middle, length = problem.home, problem.middle, problem.length
    rows: dict[type, list[tuple[Array, ...]]] = {kind: [] for kind in SHAPES}
    for number, datum in enumerate(problem.data):
        for part in datum.parts(act(home.inverse(), middle)):
            rows[type(part)].append((np.array(number), *_row(part, home, middle, length)))
    arrays = [
        tuple(map(np.stack, zip(*rows[kind], strict=True))) if rows[kind] else _empty(shapes)
        for kind, shapes in SHAPES.items()
    ]
    return Conditions(len(problem.data), *arrays)


SHAPES: dict[type, tuple[tuple[int, ...], ...]] = {
    task.Point: ((3,), (3,)),
    task.PointOnLine: ((3,), (3,), (2, 3)),
    task.Direction: ((3,), (3,)),
    task.Orientation: ((4,),),
}
"""The shapes of what the conditions hold of a part of each kind."""


def _empty(shapes: tuple[tuple[int, ...], ...]) -> tuple[Array, ...]:
    return np.zeros(0, dtype=int), *(np.zeros((0, *shape)) for shape in shapes)


def _row(part: task.Datum, home: DualQuaternion, middle: Array, length: float) -> tuple[Array, ...]:
    """A part in the fixed frame at home, about the middle and in units of the length."""
    if isinstance(part, task.Orientation):
        step = as_pose(part.rotation).astype(float) * home.inverse()
        quaternion = step.coeffs[:4] * [1, -1, -1, -1]
        return (quaternion / np.linalg.norm(quaternion),)
    if isinstance(part, task.Direction):
        ends = act(home, part.direction) - act(home, [0, 0, 0])
        return _unit(ends), _unit(part.to)
    assert isinstance(part, task.Point | task.PointOnLine)
    point = (as_float(act(home, part.point)) - middle) / length
    if isinstance(part, task.Point):
        return point, (as_float(part.to) - middle) / length
    line = part.line
    foot = (as_float(line.foot(middle)) - middle) / length  # type: ignore[union-attr]
    return point, foot, np.stack(normals_of(_unit(line.direction)))  # type: ignore[union-attr]
