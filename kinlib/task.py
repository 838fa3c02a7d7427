"""What may be asked of a coupler besides poses: points, lines, directions, orientations, and what each of them costs.

A datum is a condition on a pose.  It consists of parts: a point that arrives somewhere or comes to lie on a line, a
direction that is aimed, an orientation that is taken.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.line import Line as SpaceLine
from kinlib.linkage import Linkage
from kinlib.poses import as_pose
from kinlib.scalar import as_float, as_scalars, as_vectors, plain
from kinlib.typing import Array, PointLike, PoseLike, VectorLike

__all__ = [
    "Datum",
    "Direction",
    "Line",
    "Orientation",
    "Part",
    "Point",
    "PointAndDirection",
    "PointOnLine",
    "Pose",
    "residuals",
]

LineLike: TypeAlias = SpaceLine | DualQuaternion
"""A line, or the half-turn about it (or any rotation)."""


class Datum(ABC):
    """A condition on the poses of a moving frame: base of the seven kinds.

    Attributes
    ----------
    codimension : int
        How many independent equations it makes for a pose.
    orientation_codimension : int
        How many of them are about the orientation alone.
    """

    codimension: ClassVar[int]
    orientation_codimension: ClassVar[int]

    @abstractmethod
    def parts(self, near: PointLike = (0, 0, 0)) -> tuple[Part, ...]:
        """The parts that together are the same condition: points, points on lines, directions and orientations.

        Parameters
        ----------
        near : array_like, shape (3,)
            A point of the moving frame; where a part may choose its point it takes one near this.
        """

    def residual(self, pose: PoseLike, *, length: float = 1.0) -> Any:
        """How far a pose is from meeting the datum: the largest angle in radians or distance in parts of a length.

        Parameters
        ----------
        pose : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransform
            Broadcasts against a batch of data.
        length : float
            The size of the problem, in units of length; positive.

        Examples
        --------
        >>> from kinlib import task, translation
        >>> task.Point([0, 0, 0], to=[3, 4, 0]).residual(translation([0, 0, 0]), length=10)
        0.5
        """
        if not 0 < length < np.inf:
            raise ValueError(f"expected a positive length, the size of the problem, got {length!r}")
        q = pose if isinstance(pose, DualQuaternion) else as_pose(pose)
        q = DualQuaternion(as_float(q.coeffs))
        return plain(np.maximum.reduce(np.broadcast_arrays(*(part.off(q, length) for part in self.parts()))))

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of a batch of data; ``()`` for one."""
        return np.broadcast_shapes(*(_shape(value) for value in vars(self).values()))

    def _put(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)


class Part(Datum):
    """A datum that has no parts but itself."""

    def parts(self, near: PointLike = (0, 0, 0)) -> tuple[Part, ...]:
        """Itself."""
        return (self,)

    @abstractmethod
    def off(self, q: DualQuaternion, length: float) -> Array:
        """The residual on poses in floats: an angle, or a distance in parts of a length."""


@dataclass(frozen=True, eq=False)
class Point(Part):
    """A point of the moving frame arrives at a place: codimension 3.

    Parameters
    ----------
    point : array_like, shape (..., 3)
        In the moving frame, in units of length.
    to : array_like, shape (..., 3)
        In the fixed frame.

    Examples
    --------
    >>> from kinlib import task, translation
    >>> datum = task.Point([1, 0, 0], to=[1, 2, 0])
    >>> datum.codimension, datum.residual(translation([0, 2, 0]))
    (3, 0.0)
    """

    point: PointLike
    to: PointLike
    codimension = 3
    orientation_codimension = 0

    def __post_init__(self) -> None:
        self._put(point=as_vectors(self.point, "points"), to=as_vectors(self.to, "places"))

    def off(self, q: DualQuaternion, length: float) -> Array:
        """The distance."""
        return np.linalg.norm(as_float(act(q, self.point)) - as_float(self.to), axis=-1) / length


@dataclass(frozen=True, eq=False)
class PointOnLine(Part):
    """A point of the moving frame comes to lie on a line of the fixed frame: codimension 2.

    Parameters
    ----------
    point : array_like, shape (..., 3)
        In the moving frame, in units of length.
    line : Line, or half-turn about it
        In the fixed frame.

    Examples
    --------
    >>> from kinlib import Line, one, task
    >>> task.PointOnLine([1, 0, 3], Line.at([0, 0, 0], [1, 0, 0])).residual(one)
    3.0
    """

    point: PointLike
    line: LineLike
    codimension = 2
    orientation_codimension = 0

    def __post_init__(self) -> None:
        self._put(point=as_vectors(self.point, "points"), line=_as_line(self.line))

    def off(self, q: DualQuaternion, length: float) -> Array:
        """The distance from the line."""
        l, m = (as_float(x) for x in (self.line.direction, self.line.moment))  # type: ignore[union-attr]
        apart = np.cross(as_float(act(q, self.point)), l) - m
        return np.linalg.norm(apart, axis=-1) / np.linalg.norm(l, axis=-1) / length


@dataclass(frozen=True, eq=False)
class Direction(Part):
    """A direction of the moving frame is aimed at a direction of the fixed frame: codimension 2.

    Parameters
    ----------
    direction, to : array_like, shape (..., 3)
        In the moving and in the fixed frame; of any length, but not zero.

    Examples
    --------
    >>> from kinlib import k, task
    >>> task.Direction([1, 0, 0], to=[-2, 0, 0]).residual(k)
    0.0
    """

    direction: VectorLike
    to: VectorLike
    codimension = 2
    orientation_codimension = 2

    def __post_init__(self) -> None:
        self._put(direction=_as_direction(self.direction), to=_as_direction(self.to))

    def off(self, q: DualQuaternion, length: float) -> Array:
        """The angle."""
        turned = as_float(act(_turning(q), self.direction))
        to = as_float(self.to)
        return np.arctan2(np.linalg.norm(np.cross(turned, to), axis=-1), (turned * to).sum(axis=-1))


@dataclass(frozen=True, eq=False)
class Orientation(Part):
    """The moving frame takes an orientation, at whatever place: codimension 3.

    Parameters
    ----------
    rotation : pose, SciPy Rotation, or matrices of shape (..., 3, 3)
        Of a pose only the orientation counts.

    Examples
    --------
    >>> from kinlib import k, task, translation
    >>> task.Orientation([[-1, 0, 0], [0, -1, 0], [0, 0, 1]]).residual(translation([5, 0, 0]) * k)
    0.0
    """

    rotation: PoseLike
    codimension = 3
    orientation_codimension = 3

    def __post_init__(self) -> None:
        self._put(rotation=_as_rotation(self.rotation))

    def off(self, q: DualQuaternion, length: float) -> Array:
        """The angle of the turn between them."""
        rotation = self.rotation
        between = DualQuaternion(as_float(rotation.coeffs)).conjugate() * q  # type: ignore[union-attr]
        sine = np.sqrt((between.components[1:4] ** 2).sum(axis=0))
        return 2 * np.arctan2(sine, np.abs(between.components[0]))


@dataclass(frozen=True, eq=False)
class Pose(Datum):
    """The moving frame takes a pose: codimension 6.

    Parameters
    ----------
    pose : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransform

    Examples
    --------
    >>> from kinlib import one, task, translation
    >>> task.Pose(translation([0, 0, 2])).residual(one)
    2.0
    """

    pose: PoseLike
    codimension = 6
    orientation_codimension = 3

    def __post_init__(self) -> None:
        self._put(pose=as_pose(self.pose))

    def parts(self, near: PointLike = (0, 0, 0)) -> tuple[Part, ...]:
        """Its orientation, and where it takes a point."""
        return Orientation(self.pose), Point(near, act(self.pose, near))


@dataclass(frozen=True, eq=False)
class PointAndDirection(Datum):
    """A point arrives at a place, and a direction is aimed there: codimension 5, as for a tool that spins.

    Parameters
    ----------
    point, to_point : array_like, shape (..., 3)
        In the moving and in the fixed frame, in units of length.
    direction, to_direction : array_like, shape (..., 3)
        In the moving and in the fixed frame; not zero.

    Examples
    --------
    >>> from kinlib import k, task
    >>> task.PointAndDirection([1, 0, 0], [0, 0, 1], [-1, 0, 0], [0, 0, 1]).residual(k)
    0.0
    """

    point: PointLike
    direction: VectorLike
    to_point: PointLike
    to_direction: VectorLike
    codimension = 5
    orientation_codimension = 2

    def __post_init__(self) -> None:
        self._put(point=as_vectors(self.point, "points"), to_point=as_vectors(self.to_point, "places"))
        self._put(direction=_as_direction(self.direction), to_direction=_as_direction(self.to_direction))

    def parts(self, near: PointLike = (0, 0, 0)) -> tuple[Part, ...]:
        """The point and the direction."""
        return Point(self.point, self.to_point), Direction(self.direction, self.to_direction)


@dataclass(frozen=True, eq=False)
class Line(Datum):
    """An oriented line of the moving frame comes to lie on a line of the fixed frame: codimension 4.

    Parameters
    ----------
    line, to : Line, or half-turn about it
        In the moving and in the fixed frame.

    Examples
    --------
    >>> from kinlib import Line, one, task
    >>> line = Line.at([0, 0, 1], [1, 0, 0])
    >>> task.Line(line, to=line).residual(one), task.Line(line, to=Line.at([0, 0, 3], [1, 0, 0])).residual(one)
    (0.0, 2.0)
    """

    line: LineLike
    to: LineLike
    codimension = 4
    orientation_codimension = 2

    def __post_init__(self) -> None:
        self._put(line=_as_line(self.line), to=_as_line(self.to))

    def parts(self, near: PointLike = (0, 0, 0)) -> tuple[Part, ...]:
        """Its direction, and a point of it."""
        line, to = _as_line(self.line), _as_line(self.to)
        return Direction(line.direction, to.direction), PointOnLine(line.foot(near), to)


def residuals(linkage: Linkage, data: Sequence[Datum], *, length: float = 1.0) -> tuple[Any, ...]:
    """How far the coupler of a linkage is from data (and wishes), at the parameters that the linkage names for them.

    Parameters
    ----------
    linkage : Linkage
        Such as :func:`~kinlib.goldberg_linkages_for` gives: its ``parameters`` are those of home and of the data.
    data : sequence of Datum
        All of them, in the order in which they were given, the wishes last.
    length : float
        The size of the problem, in units of length.

    Examples
    --------
    >>> from kinlib import bennett_linkage, task
    >>> from kinlib.gallery import THREE_POSES
    >>> linkage = bennett_linkage(*THREE_POSES)
    >>> max(task.residuals(linkage, [task.Pose(pose) for pose in THREE_POSES[1:]])) < 1e-15
    True
    """
    if len(data) + 1 != len(linkage.parameters):
        raise ValueError(f"expected {len(linkage.parameters) - 1} data, as the linkage has parameters, got {len(data)}")
    poses = map(linkage.coupler_motion, linkage.parameters[1:])
    return tuple(datum.residual(pose, length=length) for datum, pose in zip(data, poses, strict=True))


def _shape(value: Any) -> tuple[int, ...]:
    return value.shape if isinstance(value, DualQuaternion | SpaceLine) else value.shape[:-1]


def _turning(q: DualQuaternion) -> DualQuaternion:
    """The rotation of a displacement about the origin."""
    components = q.components.copy()
    components[4:] = 0
    return DualQuaternion.from_components(components)


def _as_line(x: LineLike) -> SpaceLine:
    if isinstance(x, SpaceLine):
        return x
    if isinstance(x, DualQuaternion):
        return SpaceLine.from_dual_quaternion(x)
    raise TypeError(f"expected a Line, or a half-turn about it as DualQuaternion, got {type(x).__name__}")


def _as_direction(x: VectorLike) -> Array:
    vectors = as_vectors(x, "directions")
    if np.any((as_float(vectors) == 0).all(axis=-1)):
        raise ValueError("expected a direction that is not zero")
    return vectors


def _as_rotation(x: PoseLike) -> DualQuaternion:
    if not isinstance(x, DualQuaternion):
        x = as_scalars(x.as_matrix() if hasattr(x, "as_matrix") else x)
        if x.shape[-2:] == (3, 3):
            whole = np.zeros((*x.shape[:-2], 4, 4), dtype=x.dtype)
            whole[..., :3, :3], whole[..., 3, 3] = x, 1
            x = whole
        if x.shape[-2:] != (4, 4):
            raise ValueError(f"expected an orientation as matrix of shape (..., 3, 3) or as pose, got shape {x.shape}")
    elif np.any(as_float(null_form(x, x)) == 0):
        return as_pose(x)  # it says that this is no pose
    else:
        x = _turning(x)
    return _turning(as_pose(x))
