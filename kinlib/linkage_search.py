"""The best 5R linkages through three poses among very many: the plane of z in blocks, one core or a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from kinlib.blocks import Cluster, run_in_blocks
from kinlib.brief import MEASURES, NAMES, Brief, ZGrid
from kinlib.linkage import Linkage
from kinlib.poses import as_pose
from kinlib.scalar import as_float
from kinlib.stages import Found, Task, best_rows
from kinlib.typing import Array, ArrayLike, PoseLike
from kinlib.z_plane import ZPlane

__all__ = ["Choice", "refine", "search"]


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
    found: Found | None = None

    def pieces() -> Iterator[_Piece]:
        for start in starts:
            yield _Piece(start, _piece(points, start, min(start + block, count)), _floor(found, keep))

    for number, part in enumerate(run_in_blocks(partial(_examine, task), pieces(), cluster), start=1):
        found = part if found is None else found.and_more(part, keep)
        if progress is not None:
            progress(number, len(starts))
    if found is None:
        raise ValueError("expected at least one point z")
    return _choice(task, found)


def _task(poses: Any, brief: Brief | None, best: str, keep: int, planes: Sequence[int]) -> Task:
    if best not in NAMES:
        raise ValueError(f"expected one of {', '.join(NAMES)}, got {best!r}")
    if not planes or not set(planes) <= set(range(4)):
        raise ValueError(f"expected numbers of planes from 0 to 3, got {planes!r}")
    if keep < 1:
        raise ValueError(f"expected to keep at least one linkage, got {keep}")
    coeffs = np.array([as_float(as_pose(pose).coeffs) for pose in poses])
    if coeffs.shape != (3, 8):
        raise ValueError(f"expected three single poses, got the shape {coeffs.shape[:-1]}")
    return Task(coeffs, brief or Brief(), best, keep, tuple(planes))


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
    """A block: its points, the number of the first, and what a score must reach to be among the best by then."""

    start: int
    points: _Part | Array
    floor: float


def _floor(found: Found | None, keep: int) -> float:
    return -np.inf if found is None else found.floor(keep)


def _examine(task: Task, piece: _Piece) -> Found:
    """The best linkages of a block."""
    points = piece.points
    z = points.grid.points(points.start, points.stop) if isinstance(points, _Part) else points
    found: Found | None = None
    for number, plane in enumerate(task.zplanes()):
        for partner, linkage in enumerate(plane.linkages(z, degenerate="nan") if number in task.planes else ()):
            floor = max(piece.floor, _floor(found, task.keep))
            part = best_rows(task, linkage, z, np.array([number, partner, piece.start]), floor)
            found = part if found is None else found.and_more(part, task.keep)
    assert found is not None  # there is a plane
    return found


def _choice(task: Task, found: Found) -> Choice:
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


# ---- improved ------------------------------------------------------------------------------------------


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


def _climbed(task: Task, plane: ZPlane, place: Array, z: complex, minimize: Callable[..., Array]) -> Found:
    """The best that is found from one z on."""

    def at(point: Array) -> Found:
        there = np.array([complex(*point)])
        return best_rows(task, plane.linkages(there, degenerate="nan")[place[1]], there, place, -np.inf)

    def loss(point: Array) -> float:
        score = at(point).score
        return -float(score[0]) if len(score) else LOST

    start = np.array([z.real, z.imag])
    best = at(minimize(loss, start, 0.02 * (1 + abs(z))))
    return best if len(best.score) else at(start)


LOST = 1e300
"""The loss where the brief is not satisfied."""
