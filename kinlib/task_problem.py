"""Data as one problem: at home, about their own middle, in a frame that turns with them, in units of their own size."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations

import numpy as np

from kinlib import task
from kinlib.displacement import act, as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.errors import DegenerateError
from kinlib.poses import as_pose, moved_origin, stretched
from kinlib.scalar import as_float
from kinlib.task_search import Conditions, normals_of
from kinlib.typing import Array, ArrayLike, PoseLike

__all__ = ["TaskProblem"]

LOOSE = 1e-3
"""Directions in which the data hold their middle less than this are left to the home pose."""

SAME = 1e-10
"""Data whose numbers differ by no more than this, in radians and in parts of the size of the problem, are the same."""


@dataclass(frozen=True)
class TaskProblem:
    """A home pose and data, in floats.

    Parameters
    ----------
    home : DualQuaternion
        The pose at t = ∞.
    data : tuple of Datum
    wishes : tuple of Datum
    middle : numpy.ndarray, shape (3,)
        The point of the fixed frame that is nearest to all that the data are about.
    length : float
        How far that is from it on average, in units of length.
    """

    home: DualQuaternion
    data: tuple[task.Datum, ...]
    wishes: tuple[task.Datum, ...]
    middle: Array
    length: float

    @classmethod
    def of(cls, home: PoseLike, data: Sequence[task.Datum], wishes: Sequence[task.Datum] = ()) -> TaskProblem:
        """The problem that is given.

        Raises
        ------
        TypeError
            If something is no datum.
        ValueError
            If there are batches: each problem is a search of its own.
        """
        data, wishes = _as_data(data), _as_data(wishes)
        pose = as_pose(home)
        if pose.shape or any(datum.shape for datum in (*data, *wishes)):
            raise ValueError("expected a single home pose and single data: a batch is a search for each of its rows")
        pose = DualQuaternion(as_float(pose.coeffs))
        start = as_float(act(pose, [0, 0, 0]))
        matrix, right, blocks = _pulls(pose, (*data, *wishes), start)
        middle = start + np.linalg.lstsq(matrix, right, rcond=LOOSE)[0] if len(right) else start
        off = matrix @ (middle - start) - right
        with np.errstate(over="ignore"):
            length = float(np.sqrt((off**2).sum() / max(blocks, 1)))
        if not np.isfinite(length):
            raise ValueError(f"expected coordinates that can be squared, got up to {np.abs(off).max():.1g}")
        return cls(pose, data, wishes, middle, length or 1.0)

    def check_independent(self) -> None:
        """That no datum is met by the home pose already, or with another one.

        Raises
        ------
        DegenerateError
            Naming the data, counted from 1.
        """
        names = [f"{number} ({type(datum).__name__})" for number, datum in enumerate(self.data, 1)]
        seen = [self._seen(datum) for datum in self.data]
        for name, datum in zip(names, self.data, strict=True):
            if self.missed(self.home, datum) <= SAME + self.noise:
                raise DegenerateError(f"datum {name} is met by the home pose already: it asks for nothing")
        for m, n in permutations(range(len(names)), 2):
            first, second = self.data[m], self.data[n]
            if isinstance(first, task.Pose):
                implied = self.missed(as_pose(first.pose).astype(float), second) <= SAME + self.noise
            else:
                implied = type(first) is type(second) and np.abs(seen[m] - seen[n]).max() <= SAME + self.noise
            if implied:
                raise DegenerateError(f"datum {names[n]} is met whenever datum {names[m]} is: it asks for nothing more")

    def _seen(self, datum: task.Datum) -> Array:
        """Numbers that are the same for the same condition."""
        near, numbers = act(self.home.inverse(), self.middle), []
        for part in datum.parts(near):
            row = _row(part, self.home, self.middle, self.length)
            if isinstance(part, task.Orientation):
                row = (np.outer(*row, *row),)
            elif isinstance(part, task.PointOnLine):
                row = (*row[:2], row[2].T @ row[2])
            numbers += [x.ravel() for x in row]
        return np.concatenate(numbers)

    def conditions(self, *, wishes: bool = False) -> Conditions:
        """What the search needs to know of the data, or of the data and the wishes."""
        return _conditions(self, (*self.data, *self.wishes) if wishes else self.data).seen_in(self.frame)

    @cached_property
    def frame(self) -> Array:
        """The frame of the data and the wishes, as a rotation matrix: the search knows no other."""
        return _conditions(self, (*self.data, *self.wishes)).frame

    def outward(self, q: DualQuaternion) -> DualQuaternion:
        """What was found about the middle, in the fixed frame and in the unit of the data."""
        components = stretched(q, self.length).components.copy()
        components[1:4], components[5:] = self.frame @ components[1:4], self.frame @ components[5:]
        return moved_origin(DualQuaternion.from_components(components), -self.middle)

    def inward(self, q: DualQuaternion) -> DualQuaternion:
        """What is in the fixed frame and in the unit of the data, as the search sees it."""
        components = stretched(moved_origin(q, self.middle), 1 / self.length).components.copy()
        components[1:4], components[5:] = self.frame.T @ components[1:4], self.frame.T @ components[5:]
        return DualQuaternion.from_components(components)

    def missed(self, pose: DualQuaternion, datum: task.Datum) -> float:
        """How far a pose is from a datum, in radians and in units of the size of the problem."""
        near = act(pose.inverse(), self.middle)
        return max(float(part.residual(pose, length=self.length)) for part in datum.parts(near))

    @property
    def noise(self) -> float:
        """What rounding of the given numbers makes of this."""
        reach = max(np.abs(self.middle).max(), _place(self.home, self.home, self.middle))
        return float(64 * np.finfo(float).eps * (1 + reach / self.length))


def _as_data(data: Sequence[task.Datum]) -> tuple[task.Datum, ...]:
    if isinstance(data, task.Datum) or not isinstance(data, Iterable):
        raise TypeError(f"expected a sequence of data such as task.Pose or task.Point, got {data!r}")
    data = tuple(data)
    for datum in data:
        if not isinstance(datum, task.Datum):
            raise TypeError(f"expected data such as task.Pose or task.Point, got {datum!r}")
    return data


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


def _conditions(problem: TaskProblem, data: Sequence[task.Datum]) -> Conditions:
    home, middle, length = problem.home, problem.middle, problem.length
    rows: dict[type, list[tuple[Array, ...]]] = {kind: [] for kind in SHAPES}
    for number, datum in enumerate(data):
        for part in datum.parts(act(home.inverse(), middle)):
            rows[type(part)].append((np.array(number), *_row(part, home, middle, length)))
    arrays = [
        tuple(map(np.stack, zip(*rows[kind], strict=True))) if rows[kind] else _empty(shapes)
        for kind, shapes in SHAPES.items()
    ]
    return Conditions(len(data), *arrays)


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
