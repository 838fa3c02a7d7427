"""Gives problems to kinlib and sorts what comes back into bands."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

import kinlib
from tests.fuzz import geometry
from tests.fuzz.judge import Frame, frame_of, judge_dyad, judge_linkage, judge_motion
from tests.fuzz.problems import Block

BANDS = ("right", "refused truly", "refused falsely", "wrong", "NaN", "uneven", "crash")
"""From good to bad; *uneven*: a row of a batch is not what the single problem is."""
GOOD = BANDS[:2]
SECONDS = 60  # for one call


@dataclass(frozen=True)
class Outcome:
    """What became of one problem: ``excess`` is its worst gap as a multiple of what is allowed."""

    name: str
    function: str
    band: str
    detail: str = ""
    excess: float = 0.0


@dataclass(frozen=True)
class Found:
    """One row of an answer: the worst gap, how many of its parts are numbers, and which gap is worst."""

    excess: float
    defined: int
    parts: int
    text: str

    @property
    def whole(self) -> bool:
        return self.defined == self.parts


@dataclass(frozen=True)
class Job:
    """One public function: how it is called, what its answer is made of, and each how manieth problem it is given."""

    function: str
    call: Callable
    kind: str = "linkages"
    stride: int = 1


def _bennett(poses, z, free, **options):
    return (kinlib.bennett_linkage(*poses, **options),)


def _goldberg(poses, z, free, **options):
    return kinlib.goldberg_linkages(*poses, z, **options)


def _dyads(poses, z, free, **options):
    return kinlib.dyads_through_poses(*poses, **options)


def _six_r(poses, z, free, **options):
    return kinlib.six_r_linkages(*poses, **({} if free is None else {"free": free}), **options)


def _conic(poses, z, free, **options):
    return (kinlib.conic_through(*poses, **options),)


def _cubics(poses, z, free, **options):
    return kinlib.cubics_through(*poses, **({} if free is None else {"free": free}), **options)


DYADS = Job("dyads_through_poses", _dyads, "dyads")
CONIC = Job("conic_through", _conic, "motions", 8)
CUBICS = Job("cubics_through", _cubics, "motions", 8)
BENNETT = Job("bennett_linkage", _bennett)
GOLDBERG = Job("goldberg_linkages", _goldberg)
SIX_R = Job("six_r_linkages", _six_r)


def jobs_of(block: Block) -> tuple[Job, ...]:
    if len(block.poses) == 4:
        return (SIX_R, CUBICS)
    return (DYADS, BENNETT, CONIC) if block.z is None else (GOLDBERG,)


def try_block(block: Block) -> list[Outcome]:
    """All outcomes of a block."""
    frame = frame_of(block.poses)
    _MEASURED.clear()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return [outcome for job in jobs_of(block) for outcome in _try_job(job, block, frame)]


def _try_job(job: Job, block: Block, frame: Frame) -> list[Outcome]:
    rows = np.arange(0, block.poses.shape[1], job.stride)
    answer = None if block.exact else _in_a_batch(job, block)
    if isinstance(answer, Outcome):
        return [answer, *(_single(job, block, frame, row) for row in rows)]
    if answer is None:
        return [_single(job, block, frame, row) for row in rows]
    verdict = _judge(job, answer, block.poses, frame)
    outcomes = []
    for row in rows:
        found = verdict(row)
        if not found.whole or row % 16 == 0:
            outcomes.append(_single(job, block, frame, row, batch=found))
        else:
            outcomes.append(_sorted(job, f"{block.name}/{row}", found))
    return outcomes


def _sorted(job: Job, name: str, found: Found) -> Outcome:
    return Outcome(name, job.function, "right" if found.excess <= 1 else "wrong", found.text, found.excess)


NO_BATCHES = set()


def _in_a_batch(job: Job, block: Block):
    """The answer for all rows, None where the function takes no batches, an outcome if it fails."""
    if job.function in NO_BATCHES:
        return None
    try:
        return _call(job, block, slice(None), degenerate="nan")
    except TypeError as error:
        if "degenerate" in str(error):
            NO_BATCHES.add(job.function)
            return None
        return Outcome(f"{block.name}/:", job.function, "crash", f"batch: {type(error).__name__}: {error}")
    except Exception as error:
        return Outcome(f"{block.name}/:", job.function, "crash", f"batch: {type(error).__name__}: {error}")


def _single(job: Job, block: Block, frame: Frame, row: int, batch=None) -> Outcome:
    """One problem by itself, compared with its row of a batch."""
    name = f"{block.name}/{row}"
    one = [row]
    try:
        answer = (
            _call(job, block, row, degenerate="raise") if job.function not in NO_BATCHES else _call(job, block, row)
        )
    except (kinlib.DegenerateError, ValueError) as error:
        if isinstance(error, np.linalg.LinAlgError):
            return Outcome(name, job.function, "crash", f"LinAlgError: {error}")
        return _refused(job, block, frame, row, str(error), batch)
    except TimeoutError:
        return Outcome(name, job.function, "crash", f"not done after {SECONDS} s")
    except Exception as error:
        return Outcome(name, job.function, "crash", f"{type(error).__name__}: {error}")
    found = _judge(job, answer, block.poses[:, one], frame[one])(0)
    if not found.whole:
        return Outcome(name, job.function, "NaN", "NaN where an error is asked for", np.inf)
    if batch is not None and found.excess <= 1 and (batch.defined != found.defined or batch.excess > 1):
        text = f"right alone; in a batch {batch.defined} of {found.defined} parts: {batch.text}"
        return Outcome(name, job.function, "uneven", text, found.excess)
    return _sorted(job, name, found)


def _refused(job: Job, block: Block, frame: Frame, row: int, message: str, batch) -> Outcome:
    name = f"{block.name}/{row}"
    if batch is not None and batch.defined and batch.excess > 1:
        return Outcome(name, job.function, "wrong", f"in a batch {batch.text}; alone: {message}", batch.excess)
    if batch is not None and batch.whole:
        return Outcome(name, job.function, "uneven", f"answered in a batch; alone: {message}", batch.excess)
    reach = float(frame.reach[row] / max(frame.length[row], 1e-300))
    truth, why = geometry.is_true(message, _measures(block, row), reach)
    return Outcome(name, job.function, "refused truly" if truth else "refused falsely", f"{message} [{why}]")


def _measures(block: Block, row: int) -> dict:
    """How near a problem is to each degeneracy; found once, though several functions may ask."""
    key = (block.name, row)
    if key not in _MEASURED:
        poses = block.poses[:, row]
        if block.z is not None:
            found = geometry.of_z(poses, complex(block.z[row]))
        elif len(poses) == 4:
            found = geometry.of_four_poses(poses, 0 if block.free is None else float(block.free[row]))
        else:
            found = geometry.of_three_poses(poses)
        _MEASURED[key] = {**found, "exact": 0.0 if block.exact else 1.0}
    return _MEASURED[key]


_MEASURED: dict = {}


def _call(job: Job, block: Block, rows, **options):
    poses = [_told(p[rows], block.form) for p in block.poses]
    z, free = (None if x is None else x[rows] for x in (block.z, block.free))
    with _Limited():
        return job.call(poses, z, free, **options)


def _told(pose, form: str):
    if form == "matrices":
        return matrix_of(pose)
    if pose.dtype == object:
        return kinlib.DualQuaternion([int(x) if x == int(x) else Fraction(x) for x in pose])
    return kinlib.DualQuaternion(pose)


def matrix_of(q) -> np.ndarray:
    """The 4×4 matrices of unit poses."""
    p, u, d, v = q[..., :1], q[..., 1:4], q[..., 4:5], q[..., 5:]
    matrix = np.zeros((*q.shape[:-1], 4, 4))
    x = np.eye(3)
    for n in range(3):
        crossed = np.cross(u, x[n])
        matrix[..., :3, n] = x[n] + 2 * (p * crossed + np.cross(u, crossed))
    matrix[..., :3, 3] = 2 * (p * v - d * u + np.cross(u, v))
    matrix[..., 3, 3] = 1
    return matrix


class _Limited:
    """Stops a call that takes too long."""

    def __enter__(self):
        signal.signal(signal.SIGALRM, self._stop)
        signal.alarm(SECONDS)

    def __exit__(self, *_):
        signal.alarm(0)

    def _stop(self, *_):
        raise TimeoutError


def _judge(job: Job, answer, poses, frame: Frame):
    """A function of the row: what was found of the parts of its answer."""
    n = poses.shape[1]
    results = [_judge_part(job, part, poses, frame, n) for part in answer]

    def of(row: int):
        defined = [(finite, verdict, place) for finite, verdict, place in results if finite[row]]
        excess, text = 0.0, ""
        for number, (_, verdict, place) in enumerate(defined):
            if not verdict.excess[place[row]] <= excess:
                excess = float(verdict.excess[place[row]])
                text = f"part {number}: {verdict.worst(place[row])}"
        return Found(excess, len(defined), len(results), text)

    return of


def _judge_part(job: Job, part, poses, frame: Frame, n: int):
    """Which rows of a dyad, a motion or a linkage are finite, and the verdict on these."""
    arrays = [_rows(x, n) for x in _dual_quaternions(job, part)]
    parameters = [_numbers(t, n) for t in part.parameters] if job.kind == "linkages" else []
    finite = np.all([_finite(x) for x in arrays], axis=0) & ~np.any([_is_nan(t) for t in parameters] or [False], axis=0)
    place = np.cumsum(finite) - 1
    if not finite.any():
        return finite, None, place
    arrays, parameters = [x[finite] for x in arrays], [t[finite] for t in parameters]
    poses, frame = poses[:, finite], frame[finite]
    if job.kind == "dyads":
        return finite, judge_dyad(*arrays, poses, frame), place
    if job.kind == "motions":
        return finite, judge_motion(arrays, poses, frame), place
    *factors, home = arrays
    return finite, judge_linkage(factors, part.joints, part.coupler, home, parameters, poses, frame), place


def _dual_quaternions(job: Job, part) -> tuple:
    if job.kind == "dyads":
        return part.h1, part.h2, part.home
    return part.coefficients if job.kind == "motions" else (*part.factors, part.home)


def _rows(q, n: int) -> np.ndarray:
    return np.broadcast_to(q.coeffs, (n, 8))


def _numbers(t, n: int) -> np.ndarray:
    array = np.asarray(t, dtype=object if hasattr(t, "denominator") or hasattr(t, "field") else None)
    return np.broadcast_to(array, (n,))


def _finite(x) -> np.ndarray:
    return np.isfinite(x).all(axis=-1) if x.dtype.kind == "f" else np.ones(x.shape[:-1], dtype=bool)


def _is_nan(t) -> np.ndarray:
    return np.isnan(t) if t.dtype.kind == "f" else np.zeros(t.shape, dtype=bool)
