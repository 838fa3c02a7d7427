"""Linkages with what they were asked for: points and lines of the coupler, and where they have to go."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kinlib import task
from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion
from kinlib.line import Line
from kinlib.linkage import Linkage
from kinlib.pictures.colours import ORANGE, PURPLE
from kinlib.pictures.linkage_parts import body_of
from kinlib.pictures.moving import linkage_scene
from kinlib.pictures.parts import Ball, Part, Rod
from kinlib.pictures.scene import Scene
from kinlib.scalar import as_float

__all__ = ["task_scene"]


def task_scene(linkage: Linkage, data: Sequence[task.Datum], *, alt: str, **options: Any) -> Scene:
    """A linkage in motion, with the data that it meets.

    The frame of the coupler lights up where it meets the data, which are numbered in their order.  What moves is
    orange: points of the coupler, lines, directions.  Where they have to go is violet.

    Parameters
    ----------
    linkage : Linkage
        As :func:`~kinlib.goldberg_linkages_for` gives it, with the parameters of the data.
    data : sequence of :class:`~kinlib.task.Datum`
    alt : str
        A sentence that says what is to be seen.
    **options
        More of what :func:`linkage_scene` takes: ``point``, ``bars``, ``seconds``, ``view``, ``height``.

    Raises
    ------
    ValueError
        If the linkage was made from another number of data.

    Examples
    --------
    >>> from kinlib import bennett_linkages_for, task
    >>> from kinlib.gallery import THREE_POSES
    >>> data = [task.Pose(pose) for pose in THREE_POSES[1:]]
    >>> linkage = bennett_linkages_for(THREE_POSES[0], data, starts=20)[0]
    >>> task_scene(linkage, data, alt="A frame is carried through three poses.")
    <Scene of 90 frames: A frame is carried through three poses.>
    """
    if len(linkage.parameters) != len(data) + 1:
        raise ValueError(f"expected {len(linkage.parameters) - 1} data, as the linkage was made from, got {len(data)}")
    poses = [linkage.coupler_motion(t) for t in linkage.parameters]
    names = ["home", *(str(number) for number in range(1, len(poses)))]
    scene = linkage_scene(linkage, poses, parameters=linkage.parameters, names=names, alt=alt, **options)
    places = [as_float(act(pose, [0, 0, 0])) for pose in poses]
    size = float(np.linalg.norm(np.ptp([*linkage.bars().reshape(-1, 3), *places], axis=0)))
    parts = [
        part
        for datum, pose in zip(data, poses[1:], strict=True)
        for part in _parts(datum, pose, linkage.home, size, body_of(linkage.coupler))
    ]
    return scene.with_parts(*parts)


def _parts(datum: task.Datum, pose: DualQuaternion, home: DualQuaternion, size: float, body: str) -> Iterator[Part]:
    """What belongs to the coupler, where it is at home; and where it goes."""
    origin, start = as_float(act(pose, [0, 0, 0])), as_float(act(home, [0, 0, 0]))
    if isinstance(datum, task.Pose):
        return
    if isinstance(datum, task.Line):
        yield _piece(act(home, datum.line), start, size, ORANGE, body)  # type: ignore[arg-type]
        yield _piece(datum.to, origin, 1.5 * size, PURPLE)
        return
    for part in datum.parts():
        if isinstance(part, task.Point | task.PointOnLine):
            yield Ball(as_float(act(home, part.point)), ORANGE, 0.02 * size, body)
            yield Rod(start, as_float(act(home, part.point)), ORANGE, 0.005 * size, body)
        if isinstance(part, task.Point):
            yield Ball(as_float(part.to), PURPLE, 0.035 * size, opacity=0.6)
        elif isinstance(part, task.PointOnLine):
            yield _piece(part.line, as_float(act(pose, part.point)), 1.5 * size, PURPLE)
        elif isinstance(part, task.Direction):
            pointing = act(home, part.direction) - act(home, [0, 0, 0])
            yield _arrow(start, pointing, 0.35 * size, ORANGE, body)
            yield _arrow(origin, part.to, 0.6 * size, PURPLE)


def _piece(line: Any, near: np.ndarray, length: float, colour: str, body: str = "") -> Rod:
    """A piece of a line about its point next to a given one."""
    direction, foot = as_float(line.direction), as_float(Line(line.direction, line.moment).foot(near))
    half = direction / np.linalg.norm(direction) * length / 2
    return Rod(foot - half, foot + half, colour, 0.007 * length, body, 1.0 if body else 0.6)


def _arrow(start: np.ndarray, direction: Any, length: float, colour: str, body: str = "") -> Rod:
    vector = as_float(direction)
    end = start + vector / np.linalg.norm(vector) * length
    return Rod(start, end, colour, 0.01 * length, body, 1.0 if body else 0.6)
