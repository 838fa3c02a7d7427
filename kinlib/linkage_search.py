"""The best 5R linkages through three poses among very many: a brief, the plane of z in blocks, one core or a cluster.

Each block is examined in stages, cheap criteria first.  Clearance, the dearest, is searched for last and only where it
can matter: a few positions bound it from above, and rows whose bound is below the best that is known are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from kinlib.blocks import Cluster, run_in_blocks
from kinlib.displacement import as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.measures import bar_lengths, clearance_at_most, room_about, smallest_angle, travel
from kinlib.poses import as_pose
from kinlib.scalar import as_float
from kinlib.typing import Array, ArrayLike, PoseLike
from kinlib.z_plane import ZPlane, z_planes

__all__ = ["Brief", "Choice", "ZGrid", "refine", "search"]

Measure: TypeAlias = Callable[[Linkage, Array], Array]

MEASURES: Mapping[str, Measure] = {
    "shortest_bar": lambda linkage, _: bar_lengths(linkage).min(axis=-1),
    "longest_bar": lambda linkage, _: bar_lengths(linkage).max(axis=-1),
    "total_length": lambda linkage, _: bar_lengths(linkage).sum(axis=-1),
    "smallest_angle": lambda linkage, _: smallest_angle(linkage),
    "travel": lambda linkage, _: travel(linkage),
    "room": room_about,
}
"""What is cheap to measure, the cheapest first; the second argument is the middle of the poses."""

NAMES = (*MEASURES, "clearance", "relative_clearance")
"""All that can be asked for."""

LARGE = ("shortest_bar", "smallest_angle", "clearance", "relative_clearance")
"""The measures of which more is better."""

CHUNK = 16
"""For so many linkages at a time clearance is searched."""


@dataclass(frozen=True)
class Brief:
    """What a linkage has to satisfy; what is not given is not asked.

    Attributes
    ----------
    shortest_bar, smallest_angle, clearance, relative_clearance : float
        At least: the length of each bar, the angle of neighbouring axes (radians, up to π/2), the least distance of
        bars that share no joint over the whole motion, and the same as a part of the sum of all lengths.
    longest_bar, total_length, travel, room : float
        At most: the length of each bar and of all together; the angle in radians that a joint is moved on the best way
        through all poses; the radius about the middle of the poses that bars sweep (in 32 positions).
    order : tuple of int, optional
        In which order the poses are passed while t grows, such as (0, 2, 1).

    Examples
    --------
    >>> Brief(longest_bar=480, room=600)
    Brief(longest_bar=480, room=600)
    """

    shortest_bar: float = 0.0
    longest_bar: float = np.inf
    total_length: float = np.inf
    smallest_angle: float = 0.0
    travel: float = np.inf
    room: float = np.inf
    clearance: float = 0.0
    relative_clearance: float = 0.0
    order: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        for name in NAMES:
            if not getattr(self, name) >= 0:
                raise ValueError(f"expected {name} to be positive, got {getattr(self, name)!r}")
        if self.order is not None and (len(self.order) != 3 or sorted(self.order) != [0, 1, 2] or self.order[0] != 0):
            raise ValueError(f"expected the order (0, 1, 2) or (0, 2, 1) of three poses, got {self.order!r}")

    def __repr__(self) -> str:
        asked = ((field.name, getattr(self, field.name)) for field in fields(self) if self.asks(field.name))
        return f"Brief({', '.join(f'{name}={value!r}' for name, value in asked)})"

    def asks(self, name: str) -> bool:
        """Whether something is asked of a measure, or of the order."""
        return bool(getattr(self, name) != getattr(type(self), name))

    def allows(self, name: str, values: Array) -> Array:
        """Which values of a measure satisfy the brief."""
        bound = getattr(self, name)
        return np.asarray(values >= bound if name in LARGE else values <= bound)


@dataclass(frozen=True)
class ZGrid:
    """An even grid of points of the plane of z, made piece by piece.

    Attributes
    ----------
    low, high : complex
        Two opposite corners.
    shape : pair of int
        The numbers of columns and rows; the points are the middles of their cells.

    Examples
    --------
    >>> grid = ZGrid(-2 - 2j, 2 + 2j, (2, 2))
    >>> len(grid), grid.points(1, 3).tolist()
    (4, [(1-1j), (-1+1j)])
    """

    low: complex
    high: complex
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        if min(self.shape) < 1:
            raise ValueError(f"expected a grid of at least one column and one row, got {self.shape}")

    def __len__(self) -> int:
        return self.shape[0] * self.shape[1]

    def points(self, start: int, stop: int) -> Array:
        """The points with numbers from start to stop, row by row."""
        row, column = np.divmod(np.arange(start, stop), self.shape[0])
        low, step = complex(self.low), complex(self.high) - complex(self.low)
        x = low.real + step.real * (column + 0.5) / self.shape[0]
        return x + 1j * (low.imag + step.imag * (row + 0.5) / self.shape[1])


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


@dataclass(frozen=True, eq=False, repr=False)
class Choice:
    """The best linkages of a search, best first.

    Attributes
    ----------
    linkages : tuple of Linkage
    z : array of complex, shape (k,)
        Where they are in the plane of z.
    planes, partners : array of int, shape (k,)
        Number ``2 * plane + partner`` is the place in what `goldberg_linkages` returns.
    measures : dict of str to array of shape (k,)
        All that a `Brief` can ask for.
    left : dict of str to int
        How many linkages there were, and how many were left after each criterion.  Clearance is searched for only where
        it can matter, and has no number here.
    """

    linkages: tuple[Linkage, ...]
    z: Array
    planes: Array
    partners: Array
    measures: dict[str, Array]
    left: dict[str, int]

    def __len__(self) -> int:
        return len(self.linkages)

    def __repr__(self) -> str:
        counts = ", ".join(f"{name} {count}" for name, count in self.left.items())
        rows = (f"  {number}: z = {z:.6g}" for number, z in zip(2 * self.planes + self.partners, self.z, strict=True))
        return "\n".join([f"Choice of {len(self)} ({counts})", *rows])


class _Task(NamedTuple):
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


def search(
    p0: PoseLike,
    p1: PoseLike,
    p2: PoseLike,
    z: ZGrid | ArrayLike,
    brief: Brief | None = None,
    *,
    best: str = "relative_clearance",
    keep: int = 10,
    planes: Sequence[int] = (0, 1, 2, 3),
    block: int = 8192,
    cluster: Cluster = None,
    progress: Callable[[int, int], None] | None = None,
) -> Choice:
    """The best 5R linkages through three poses for many z: two for each z and each plane.

    Parameters
    ----------
    p0, p1, p2 : pose
        A single problem; exact poses are taken as floats.
    z : ZGrid, or array_like of complex
        Which points of the planes are tried.
    brief : Brief, optional
        What a linkage has to satisfy.
    best : str
        The measure that decides, one of those in a `Brief`: the largest shortest bar, angle or clearance, or the
        smallest of the others.
    keep : int
        How many linkages are returned at most.
    planes : sequence of int
        Numbers of `z_planes`: dyad 1 with its base joint turning twice, with its moving joint, dyad 2 likewise.
    block : int
        So many points are looked at together, which bounds the memory: some 100 MB a process for 8192.
    cluster : int, str or dask.distributed.Client, optional
        How many processes to start, or the address of a scheduler, or a client; needs ``kinlib[scale]``.  The answer is
        the same as without, to the last bit on like machines.  What a lost worker had is computed again.
    progress : callable, optional
        Called with the numbers of blocks that are done and in all.

    Raises
    ------
    ValueError
        If there is no such measure or plane, or z is not finite.
    DegenerateError
        If the poses have no planes.

    Examples
    --------
    >>> from kinlib.gallery import THREE_POSES
    >>> found = search(*THREE_POSES, ZGrid(-2 - 2j, 2 + 2j, (12, 12)), Brief(longest_bar=1.5), keep=2)
    >>> [round(float(part), 3) for part in found.measures["relative_clearance"]]
    [0.075, 0.075]
    """
    task = _task((p0, p1, p2), brief, best, keep, planes)
    points = z if isinstance(z, ZGrid) else _points(z)
    task.zplanes()  # refuses poses that have none
    if block < 1:
        raise ValueError(f"expected blocks of at least one point, got {block}")
    count = len(points)
    starts = range(0, count, block)
    pieces = (_Piece(n, _piece(points, n, min(n + block, count))) for n in starts)
    found: Found | None = None
    for number, part in enumerate(run_in_blocks(partial(_examine, task), pieces, cluster), start=1):
        found = part if found is None else found.and_more(part, keep)
        if progress is not None:
            progress(number, len(starts))
    if found is None:
        raise ValueError("expected at least one point z")
    return _choice(task, found)


def _task(poses: Any, brief: Brief | None, best: str, keep: int, planes: Sequence[int]) -> _Task:
    if best not in NAMES:
        raise ValueError(f"expected one of {', '.join(NAMES)}, got {best!r}")
    if not planes or not set(planes) <= set(range(4)):
        raise ValueError(f"expected numbers of planes from 0 to 3, got {planes!r}")
    if keep < 1:
        raise ValueError(f"expected to keep at least one linkage, got {keep}")
    coeffs = np.array([as_float(as_pose(pose).coeffs) for pose in poses])
    if coeffs.shape != (3, 8):
        raise ValueError(f"expected three single poses, got the shape {coeffs.shape[:-1]}")
    return _Task(coeffs, brief or Brief(), best, keep, tuple(planes))


def _points(z: ArrayLike) -> Array:
    points = np.asarray(z, dtype=complex).reshape(-1)
    if not np.isfinite(points).all():
        raise ValueError("expected finite points z")
    return points


class _Part(NamedTuple):
    """Some points of a grid, not yet made."""

    grid: ZGrid
    start: int
    stop: int


def _piece(points: ZGrid | Array, start: int, stop: int) -> _Part | Array:
    return _Part(points, start, stop) if isinstance(points, ZGrid) else points[start:stop]


class _Piece(NamedTuple):
    """A block: its points, and the number of the first."""

    start: int
    points: _Part | Array


def refine(
    p0: PoseLike,
    p1: PoseLike,
    p2: PoseLike,
    found: Choice,
    brief: Brief | None = None,
    *,
    best: str = "relative_clearance",
    steps: int = 60,
) -> Choice:
    """The linkages of a choice, each improved by moving its z, by Nelder and Mead's method; needs ``kinlib[scale]``.

    Parameters
    ----------
    p0, p1, p2, brief, best
        As in `search`.
    found : Choice
        Where to begin.
    steps : int
        How many steps each linkage is given.

    Returns
    -------
    Choice
        None is worse than it was; best first.

    Examples
    --------
    >>> from kinlib.gallery import THREE_POSES
    >>> found = search(*THREE_POSES, ZGrid(-2 - 2j, 2 + 2j, (6, 6)), best="longest_bar", keep=1)
    >>> better = refine(*THREE_POSES, found, best="longest_bar")
    >>> bool(better.measures["longest_bar"] < found.measures["longest_bar"])
    True
    """
    minimize = _nelder_mead()
    task = _task((p0, p1, p2), brief, best, 1, (0, 1, 2, 3))
    zplanes = task.zplanes()
    parts = [
        _climbed(task, zplanes[plane], np.array([plane, partner, number]), z, partial(minimize, steps=steps))
        for number, (plane, partner, z) in enumerate(zip(found.planes, found.partners, found.z, strict=True))
    ]
    if not parts:
        return found
    score, which, points = (np.concatenate([part[n] for part in parts]) for n in range(3))
    return _choice(task, Found(score, which, points, found.left).best(len(parts)))


def _nelder_mead() -> Callable[..., Array]:
    """The least place of a function of two numbers, from a start and a step."""
    try:
        from scipy.optimize import minimize
    except ImportError as error:
        raise ImportError('refining needs SciPy: pip install "kinlib[scale]"') from error

    def found(function: Callable[[Array], float], start: Array, step: float, steps: int) -> Array:
        simplex = start + step * np.array([[0, 0], [1, 0], [0, 1]])
        options = {"maxiter": steps, "initial_simplex": simplex, "xatol": 1e-9, "fatol": 1e-12}
        return np.asarray(minimize(function, start, method="Nelder-Mead", options=options).x)

    return found


def _climbed(task: _Task, plane: ZPlane, place: Array, z: complex, minimize: Callable[..., Array]) -> Found:
    """The best that is found from one z on."""

    def at(point: Array) -> Found:
        there = np.array([complex(*point)])
        return _best_rows(task, plane.linkages(there, degenerate="nan")[place[1]], there, place, -np.inf)

    def loss(point: Array) -> float:
        score = at(point).score
        return -float(score[0]) if len(score) else LOST

    start = np.array([z.real, z.imag])
    best = at(minimize(loss, start, 0.02 * (1 + abs(z))))
    return best if len(best.score) else at(start)


LOST = 1e300
"""The loss where the brief is not satisfied."""


# ---- one block ---------------------------------------------------------------------------------------


def _examine(task: _Task, piece: _Piece) -> Found:
    """The best linkages of a block."""
    points = piece.points
    z = points.grid.points(points.start, points.stop) if isinstance(points, _Part) else points
    found: Found | None = None
    for number, plane in enumerate(task.zplanes()):
        for partner, linkage in enumerate(plane.linkages(z, degenerate="nan") if number in task.planes else ()):
            floor = -np.inf if found is None else found.floor(task.keep)
            part = _best_rows(task, linkage, z, np.array([number, partner, piece.start]), floor)
            found = part if found is None else found.and_more(part, task.keep)
    assert found is not None  # there is a plane
    return found


def _best_rows(task: _Task, linkage: Linkage, z: Array, place: Array, floor: float) -> Found:
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


def _by_clearance(task: _Task, rows: _Rows, floor: float) -> tuple[Array, Array]:
    """The rows that satisfy the brief's clearance, as far as they can be among the best, and their scores."""
    total, most = bar_lengths(rows.linkage).sum(axis=-1), clearance_at_most(rows.linkage)
    bound = _scored(task, most, total, rows.score)
    hopeful = np.flatnonzero(rows.alive & _is_clear(task, most, total) & (bound >= floor))
    hopeful = hopeful[np.argsort(-bound[hopeful], kind="stable")]
    good, scores = np.zeros(0, dtype=int), np.zeros(0)
    for start in range(0, len(hopeful), CHUNK):
        some = hopeful[start : start + CHUNK]
        if len(scores) >= task.keep and bound[some[0]] < np.sort(scores)[-task.keep]:
            break
        clearance = np.asarray(rows.linkage[some].clearance())
        fine = _is_clear(task, clearance, total[some])
        good = np.concatenate([good, some[fine]])
        scores = np.concatenate([scores, _scored(task, clearance, total[some], rows.score[some])[fine]])
    return good, scores


def _scored(task: _Task, clearance: Array, total: Array, score: Array) -> Array:
    """The scores, if the clearance is this."""
    return {"clearance": clearance, "relative_clearance": clearance / total}.get(task.best, score)


def _is_clear(task: _Task, clearance: Array, total: Array) -> Array:
    return task.brief.allows("clearance", clearance) & task.brief.allows("relative_clearance", clearance / total)


# ---- what is returned --------------------------------------------------------------------------------


def _choice(task: _Task, found: Found) -> Choice:
    planes = task.zplanes()
    numbers, partners = found.which[:, 0], found.which[:, 1]
    linkages = tuple(
        planes[plane].linkages(complex(z))[partner]
        for plane, partner, z in zip(numbers, partners, found.z, strict=True)
    )
    table = {
        name: np.array([float(measure(linkage, task.centre)) for linkage in linkages])
        for name, measure in MEASURES.items()
    }
    table["clearance"] = np.array([float(linkage.clearance()) for linkage in linkages])
    table["relative_clearance"] = table["clearance"] / table["total_length"]
    return Choice(linkages, found.z, numbers, partners, table, found.left)
