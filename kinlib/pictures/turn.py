"""One turn of a linkage in even steps, and when it reaches given poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinlib.displacement import as_matrix
from kinlib.linkage import Linkage
from kinlib.pictures.bars import Bars
from kinlib.pictures.floats import pose_matrices
from kinlib.scalar import as_float
from kinlib.typing import Array, ArrayLike, PoseLike

__all__ = ["one_turn", "parameters_of"]

_STEPS = 720  # places along a turn from which even ones are chosen


def parameters_of(bars: Bars, poses: Sequence[PoseLike]) -> np.ndarray:
    """The parameters t at which the coupler reaches the poses.

    Parameters
    ----------
    bars : Bars
        Of the linkage.
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``

    Returns
    -------
    numpy.ndarray
        One parameter a pose; ``inf`` for the pose at home.

    Raises
    ------
    ValueError
        If the coupler does not pass through one of the poses.
    """
    return np.array([_parameter_of(bars, target, n) for n, target in enumerate(pose_matrices(poses))])


def _parameter_of(bars: Bars, target: np.ndarray, n: int) -> float:
    """One of the parameters from which the linkage was made, or else what a search along the whole turn finds."""
    linkage = bars.linkage

    def gap(turn: Array | float) -> np.ndarray:
        difference = _matrices(linkage, turn) - target
        return (difference / np.array([1, 1, 1, bars.size]))[..., :3, :].reshape(*np.shape(turn), 12)

    known = [t for t in linkage.parameters if np.abs(gap(_turn(t))).max() < 1e-9]
    root = _turn(known[0]) if known else _nearest_turn(gap, _even_turns(bars))
    if not np.abs(gap(root)).max() < 1e-6:
        raise ValueError(f"the coupler does not pass through pose {n} of those given")
    return float(known[0] if known else _parameter(root))


def _nearest_turn(gap: Callable[[Array | float], np.ndarray], turns: np.ndarray) -> float:
    """Where a gap is least: the best of some turns, then settled where the gap is orthogonal to the motion."""
    best = turns[np.argmin((gap(turns) ** 2).sum(-1))]
    width = 1e-4 * min(best, 2 * np.pi - best) + 1e-9
    tangent = gap(best + width) - gap(best - width)
    return _secant(lambda turn: gap(turn) @ tangent, best - width, best + width)


def _secant(function: Callable[[float], float], a: float, b: float) -> float:
    """A zero of a function near a and b, as closely as floats tell."""
    at_a, at_b = function(a), function(b)
    for _ in range(30):
        if at_a == at_b or abs(b - a) < 1e-15:
            break
        a, b, at_a = b, b - at_b * (b - a) / (at_b - at_a), at_b
        at_b = function(b)
    return b


def _turn(t: ArrayLike) -> np.ndarray:
    """The turn from 0 to 2π with t = cot(½ turn)."""
    t = as_float(t)
    return np.where(np.isinf(t), 0, 2 * np.arctan2(1, t))


def _parameter(turn: ArrayLike) -> np.ndarray:
    """The parameter t = cot(½ turn): a turn of 0 is t = ∞, a turn of 2π is t = −∞."""
    turn = np.asarray(turn, dtype=float)
    sine = np.sin(turn / 2)
    home = np.abs(sine) < 1e-10
    return np.where(home, np.inf, np.cos(turn / 2) / np.where(home, 1, sine))


def _matrices(linkage: Linkage, turn: ArrayLike) -> np.ndarray:
    return as_float(as_matrix(linkage.coupler_motion(_parameter(turn))))


def _travel(bars: Bars, turns: np.ndarray) -> np.ndarray:
    """How far the ends of the bars have come altogether, from 0 to 1; never at rest."""
    ends = bars.ends_at(_parameter(turns)).reshape(len(turns), -1, 3)
    steps = np.linalg.norm(np.diff(ends, axis=0), axis=-1).sum(axis=-1)
    travel = np.concatenate([[0], np.cumsum(steps)])
    share = turns / (2 * np.pi)
    return 0.95 * travel / travel[-1] + 0.05 * share if travel[-1] > 0 else share


def _even_turns(bars: Bars) -> np.ndarray:
    """Turns from 0 to 2π in which the linkage goes equally far at each step, nearly."""
    turns = np.linspace(0, 2 * np.pi, _STEPS + 1)
    for _ in range(4):
        travel = _travel(bars, turns)
        turns = np.interp(np.linspace(0, travel[-1], _STEPS + 1), travel, turns)
    return turns


def one_turn(
    bars: Bars, frames: int, stops: ArrayLike = (), places: ArrayLike | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Parameters along one turn at which the linkage goes equally far at each step.

    Parameters
    ----------
    bars : Bars
        Of the linkage.
    frames : int
        How many parameters; after the last comes the first again.
    stops : array_like, shape (k,)
        Parameters that must be among them, in any order.
    places : array_like of int, shape (k,), optional
        Where the stops must be.  If not given, the first parameter is ``inf`` (home), from which t falls, and the
        stops are where an even pace puts them.

    Returns
    -------
    parameters : numpy.ndarray, shape (frames,)
    places : numpy.ndarray of int, shape (k,)
        Where the stops are.

    Raises
    ------
    ValueError
        If there are too few frames for the stops, or the stops do not follow each other as the places ask.
    """
    stops = np.asarray(stops, dtype=float)
    knots = _turn(stops)
    turns = np.union1d(_even_turns(bars), knots)
    travel = _travel(bars, turns)
    heights = np.interp(knots, turns, travel)
    if places is None or not len(stops):
        places = _even_places(heights, frames)
        climb = _heights(np.append(places, 0), np.append(heights, 0), frames)
    else:
        places = np.asarray(places, dtype=int)
        climb = _heights(places, heights, frames)
    parameters = _parameter(np.interp(climb, travel, turns))
    parameters[places] = np.where(knots == 0, np.inf, stops)
    return parameters, places


def _even_places(heights: np.ndarray, frames: int) -> np.ndarray:
    """The frames at which an even climb from 0 to 1 comes to the heights: whole numbers, all different, home at 0."""
    corners = np.union1d(0, heights)
    if len(corners) > frames:
        raise ValueError(f"expected at least {len(corners)} frames for the stops, got {frames}")
    order = np.arange(len(corners))
    rising = np.maximum.accumulate(np.round(frames * corners) - order)
    rising = np.minimum(rising, frames - len(corners)) + order
    return rising[np.searchsorted(corners, heights)].astype(int)


def _heights(places: np.ndarray, heights: np.ndarray, frames: int) -> np.ndarray:
    """How far every frame has come, when the given heights belong to the given places; upwards or downwards."""
    places, first = np.unique(places, return_index=True)
    since = (np.arange(frames) - places[0]) % frames
    for sense in (1, -1):
        climb = sense * (heights[first] - heights[first[0]]) % 1
        if np.all(np.diff(climb) > 0):
            even = np.interp(since, np.append(places - places[0], frames), np.append(climb, 1))
            return (heights[first[0]] + sense * even) % 1
    raise ValueError("the poses do not follow each other in the order that is asked for")
