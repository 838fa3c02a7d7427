"""The best rows of a batch of linkages, stage by stage, cheap criteria first.

Clearance, the dearest, is searched for last and only where it can matter: a few positions bound it from above, and rows
whose bound is below the best that is known are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinlib.brief import LARGE, MEASURES, NAMES, Brief
from kinlib.collision import clearances
from kinlib.displacement import as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.measures import bar_lengths, clearance_at_most, moving_bars
from kinlib.typing import Array
from kinlib.z_plane import ZPlane, z_planes

__all__ = ["Found", "Task", "best_rows"]

CHUNK = 32
"""For so many linkages at a time clearance is searched."""

CLOSE = 1e-3
"""To which part of its size."""


class Found(NamedTuple):
    """The best rows of a block, best first, and how many were left after each criterion.

    Attributes
    ----------
    score : array, shape (k,)
        Larger is better.
    which : array of int, shape (k, 3)
        The number of the plane, of the partner, and of the point z.
    z : array of complex, shape (k,)
    left : dict of str to int
    """

    score: Array
    which: Array
    z: Array
    left: dict[str, int]

    def best(self, keep: int) -> Found:
        """The best of them; where scores are equal the first."""
        order = np.lexsort((*self.which.T[::-1], -self.score))[:keep]
        return Found(self.score[order], self.which[order], self.z[order], self.left)

    def floor(self, keep: int) -> float:
        """What a score must reach to be among the best."""
        return float(self.score[keep - 1]) if len(self.score) >= keep else -np.inf

    def and_more(self, other: Found, keep: int) -> Found:
        """The best of both."""
        left = {name: count + other.left[name] for name, count in self.left.items()}
        score, which, z = (np.concatenate(pair) for pair in zip(self[:3], other[:3], strict=True))
        return Found(score, which, z, left).best(keep)


class Task(NamedTuple):
    """What is looked for, all but the points."""

    poses: Array
    brief: Brief
    best: str
    keep: int
    planes: tuple[int, ...]

    @property
    def stages(self) -> list[str]:
        """The cheap measures that are needed, in order."""
        return [name for name in MEASURES if self.brief.asks(name) or name == self.best]

    @property
    def needs_clearance(self) -> bool:
        """Whether clearance decides, or is asked for."""
        return any(self.brief.asks(name) or name == self.best for name in NAMES[-2:])

    @property
    def centre(self) -> Array:
        """The middle of the poses."""
        return np.asarray(as_matrix(DualQuaternion(self.poses))[..., :3, 3].mean(axis=0))

    def zplanes(self) -> tuple[ZPlane, ...]:
        """The four planes of z."""
        return z_planes(*(DualQuaternion(pose) for pose in self.poses))


def best_rows(task: Task, linkage: Linkage, z: Array, place: Array, floor: float) -> Found:
    """The best rows of one batch, stage by stage."""
    rows, left = _Rows.of(linkage), {}
    left["linkages"] = int(rows.alive.sum())
    if task.brief.order is not None:
        rows = rows.kept((rows.linkage.order_of_visits() == task.brief.order).all(axis=-1))
        left["order"] = int(rows.alive.sum())
    for name in task.stages:
        values = np.asarray(MEASURES[name](rows.linkage, task.centre))
        if name == task.best:
            rows = rows._replace(score=values if name in LARGE else -values)
        rows = rows.kept(task.brief.allows(name, values))
        left[name] = int(rows.alive.sum())
    good, score = _by_clearance(task, rows, floor) if task.needs_clearance else (rows.alive, rows.score[rows.alive])
    number = rows.number[good]
    which = np.broadcast_to(place, (len(number), 3)) + number[:, None] * np.array([0, 0, 1])
    return Found(score, which, z[number], left).best(task.keep)


class _Rows(NamedTuple):
    """What is left of a batch: linkages, their numbers in it, which of them satisfy the brief so far, and scores."""

    linkage: Linkage
    number: Array
    alive: Array
    score: Array

    @classmethod
    def of(cls, linkage: Linkage) -> _Rows:
        """All rows that are linkages."""
        count = len(linkage)
        return cls(linkage, np.arange(count), np.isfinite(linkage.axes.coeffs).all(axis=(-1, -2)), np.zeros(count))

    def kept(self, fine: Array) -> _Rows:
        """Without some rows; linkages are taken out only where few are left, as they know their bars already."""
        alive = self.alive & fine
        if np.count_nonzero(alive) > len(alive) / 2:
            return self._replace(alive=alive)
        return _Rows(self.linkage[alive], self.number[alive], alive[alive], self.score[alive])


def _by_clearance(task: Task, rows: _Rows, floor: float) -> tuple[Array, Array]:
    """The rows that satisfy the brief's clearance, as far as they can be among the best, and their scores."""
    total = bar_lengths(rows.linkage).sum(axis=-1)
    most = clearance_at_most(rows.linkage, np.where(rows.alive, _needed(task, total, rows.score, floor), np.inf))
    bound = _scored(task, most, total, rows.score)
    hopeful = np.flatnonzero(rows.alive & _is_clear(task, most, total) & (bound >= floor))
    hopeful = hopeful[np.argsort(-bound[hopeful], kind="stable")]
    good, scores = np.zeros(0, dtype=int), np.zeros(0)
    for start in range(0, len(hopeful), CHUNK):
        some = hopeful[start : start + CHUNK]
        if len(scores) >= task.keep:
            floor = max(floor, np.sort(scores)[-task.keep])
        if bound[some[0]] < floor:
            break
        needed = _needed(task, total[some], rows.score[some], floor)
        clearance = clearances(moving_bars(rows.linkage[some]), rows.linkage.joints, CLOSE, needed)
        score = _scored(task, clearance, total[some], rows.score[some])
        fine = _is_clear(task, clearance, total[some]) & (score >= floor)
        good, scores = np.concatenate([good, some[fine]]), np.concatenate([scores, score[fine]])
    return good, scores


def _needed(task: Task, total: Array, score: Array, floor: float) -> Array:
    """The clearance below which a row is not among the best; ∞ where no clearance is enough."""
    needed = np.maximum(task.brief.clearance, task.brief.relative_clearance * total)
    decides = {"clearance": np.full_like(total, floor), "relative_clearance": floor * total}
    return np.maximum(needed, decides.get(task.best, np.where(score < floor, np.inf, 0.0)))


def _scored(task: Task, clearance: Array, total: Array, score: Array) -> Array:
    """The scores, if the clearance is this."""
    return {"clearance": clearance, "relative_clearance": clearance / total}.get(task.best, score)


def _is_clear(task: Task, clearance: Array, total: Array) -> Array:
    return task.brief.allows("clearance", clearance) & task.brief.allows("relative_clearance", clearance / total)
