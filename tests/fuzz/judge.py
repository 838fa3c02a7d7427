"""Is what kinlib returned right?  Judged in 115 digits from its floats or fractions, with nothing of kinlib.

*Size.*  The middle of a problem is the point of the fixed frame that its poses, as seen from each other, move
least; its length is how far they move it at most, its turn the largest angle between two of them.  Neither depends
on the frames.  (Where the poses hardly turn, the middle stays near the origins of the moving frame.)

*Borders.*  A pose is met if it is missed by at most 1e-9 of the turn and of the length, plus what rounding must be
allowed: some ulp of a full turn, and of the distance of poses and axes from the origin.  A loop is closed if at
every sampled parameter its ends differ by no more than that, in the length of the whole mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from tests.fuzz.fixed_point import (
    BITS,
    ONE,
    conjugate,
    fixed,
    loop_polynomial,
    product,
    ratio,
    shift_of,
    turn_of,
    value,
)
from tests.fuzz.poses import compose, inverse, of_unit_length

RTOL = 1e-9
ROUNDING = 64 * 2.0**-53  # 7e-15


@dataclass(frozen=True)
class Frame:
    """Where a problem is and how large, for n problems at once; floats.

    Attributes
    ----------
    middle : array, shape (n, 3)
    length, turn, reach : arrays, shape (n,)
        ``reach`` is how far the poses are from the origin.
    """

    middle: np.ndarray
    length: np.ndarray
    turn: np.ndarray
    reach: np.ndarray

    def __getitem__(self, rows) -> Frame:
        return Frame(self.middle[rows], self.length[rows], self.turn[rows], self.reach[rows])


def frame_of(poses: np.ndarray) -> Frame:
    """The frame of problems given by their poses, shape (count, n, 8)."""
    poses = of_unit_length(np.asarray(poses, dtype=float))
    moves = [compose(y, inverse(x)) for x, y in combinations(poses, 2)]
    R, t = (np.stack(parts, axis=1) for parts in zip(*(_matrix(q) for q in moves), strict=True))
    _, positions = zip(*(_matrix(q) for q in poses), strict=True)
    middle = _least_moved(R, t, np.mean(positions, axis=0))
    length = np.linalg.norm(_moved(R, t, middle), axis=-1).max(1)
    primal = np.stack([q[:, :4] for q in moves], axis=1)
    turn = 2 * np.arctan2(np.linalg.norm(primal[..., 1:], axis=-1), np.abs(primal[..., 0])).max(1)
    return Frame(middle, length, turn, np.linalg.norm(positions, axis=-1).max(0))


def _matrix(q) -> tuple:
    p, u, d, v = q[:, :1], q[:, 1:4], q[:, 4:5], q[:, 5:]
    x = np.eye(3)[None] * np.ones((len(q), 1, 1))
    turned = x + 2 * (p[:, None] * np.cross(u[:, None], x) + np.cross(u[:, None], np.cross(u[:, None], x)))
    return np.swapaxes(turned, -1, -2), 2 * (p * v - d * u + np.cross(u, v))


def _moved(R, t, c) -> np.ndarray:
    return (R @ c[:, None, :, None])[..., 0] + t - c[:, None]


def _least_moved(R, t, start, damping: float = 1e-2) -> np.ndarray:
    """Damped least squares, repeated, so that only moves that hardly turn are damped."""
    n, count = t.shape[:2]
    A = (R - np.eye(3)).reshape(n, 3 * count, 3)
    normal = np.swapaxes(A, -1, -2) @ A + damping**2 * np.eye(3)
    c = start
    for _ in range(4):
        c = c - np.linalg.solve(normal, np.swapaxes(A, -1, -2) @ _moved(R, t, c).reshape(n, -1, 1))[..., 0]
    return c


@dataclass(frozen=True)
class Verdict:
    """How far off n results are, each as a multiple of what is allowed, with the part that is worst."""

    excess: np.ndarray
    parts: dict

    @property
    def right(self) -> np.ndarray:
        return self.excess <= 1

    def worst(self, row: int) -> str:
        name = max(self.parts, key=lambda part: np.nan_to_num(self.parts[part][row], nan=np.inf))
        return f"{name}: {self.parts[name][row]:.1e} times what is allowed"


def _verdict(parts: dict) -> Verdict:
    with np.errstate(invalid="ignore"):
        stacked = np.array([np.where(np.isnan(x), np.inf, x) for x in parts.values()])
    return Verdict(stacked.max(0), parts)


def judge_linkage(factors, joints, coupler, home, parameters, poses, frame: Frame) -> Verdict:
    """Whether loops are closed, turn about real lines, and carry their couplers through the poses.

    Parameters
    ----------
    factors : list of arrays, shape (n, 8)
    joints, coupler, home, parameters : as of a Linkage; home of shape (n, 8), parameters of shape (n,)
    poses : array, shape (count, n, 8)
    """
    f = [fixed(x.T) for x in factors]
    middle = fixed(frame.middle.T)
    distance = _farthest(f, middle)
    reach = np.maximum(frame.reach, distance + np.linalg.norm(frame.middle, axis=-1))
    parts = {"axes that are no lines": _skewness(f, frame, reach)}
    parts["factors of one joint about two axes"] = _apart(f, joints, frame, reach)
    polynomial = loop_polynomial(f)
    extent = np.maximum(frame.length, distance)
    for t in _samples(f):
        end = value(polynomial, t)
        gap = np.maximum(turn_of(end) / (RTOL + ROUNDING), shift_of(end, middle) / (RTOL * extent + ROUNDING * reach))
        parts["loop open"] = np.maximum(parts.get("loop open", 0), np.where(np.isnan(gap), np.inf, gap))
    carried = loop_polynomial(f[: sum(joints[:coupler])])
    start = fixed(home.T)
    for number, (t, pose) in enumerate(zip(parameters, poses, strict=True)):
        reached = product(_at(carried, np.broadcast_to(t, frame.length.shape)), start)
        parts[f"pose {number} missed"] = _gap(reached, fixed(pose.T), middle, frame, reach)
    return _verdict(parts)


def _gap(reached, wanted, middle, frame: Frame, reach) -> np.ndarray:
    """How far one pose is from another, as a multiple of what is allowed."""
    off = product(reached, conjugate(wanted))
    turn = turn_of(off) / (RTOL * frame.turn + ROUNDING)
    shift = shift_of(off, middle) / (RTOL * frame.length + ROUNDING * reach)
    improper = _off_the_quadric(reached) / (RTOL * frame.length + ROUNDING * reach)
    return np.maximum(np.maximum(turn, shift), improper)


def _off_the_quadric(reached) -> np.ndarray:
    """p · d / (p · p), a length: zero for a pose, and for p = 0, since the quadric holds the exceptional space."""
    p, d = reached[:4], reached[4:]
    square = (p * p).sum(0)
    return np.where(square == 0, 0.0, np.abs(ratio((p * d).sum(0), square)))


def _at(polynomial, t) -> np.ndarray:
    """A polynomial at floats or fractions t, infinity included."""
    infinite = np.array([isinstance(x, float) and np.isinf(x) for x in t.tolist()])
    if infinite.all():
        return polynomial[0]
    result = value(polynomial, fixed(np.where(infinite, 0, t)))
    return np.where(infinite, polynomial[0], result)


def _samples(factors) -> list:
    """Parameters, in fixed point, at which each joint has turned by π, or by a right angle."""
    samples = []
    for f in factors:
        radius = np.array([int(x) for x in ratio((f[1:4] ** 2).sum(0), ONE * ONE) ** 0.5 * 2.0**200], dtype=object)
        samples += [f[0], f[0] + radius * (ONE >> 200)]
    return samples


def _farthest(factors, middle) -> np.ndarray:
    """How far the axes are from the middle at most."""
    return np.max([np.linalg.norm(_foot(f, middle), axis=0) for f in factors], axis=0)


def _foot(f, middle) -> np.ndarray:
    """The point of an axis next to the middle, as seen from there: l × m / l², m for the middle as origin."""
    l, m = f[1:4], f[5:8]
    m = [m[n] - (c >> BITS) for n, c in enumerate(_cross(middle, l))]
    return np.array([ratio(x, (l * l).sum(0)) for x in _cross(l, m)])


def _cross(a, b) -> list:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _skewness(factors, frame: Frame, reach) -> np.ndarray:
    """The pitch of each axis, and the dual part of its scalar, in lengths."""
    allowed = RTOL * frame.length + ROUNDING * reach
    worst = 0
    for f in factors:
        l, square = f[1:4], (f[1:4] ** 2).sum(0)
        pitch = np.abs(ratio((l * f[5:8]).sum(0), square))
        scalar = np.sqrt(ratio(f[4] * f[4], square))
        worst = np.maximum(worst, np.maximum(pitch, scalar) / allowed)
    return worst


def _apart(factors, joints, frame: Frame, reach) -> np.ndarray:
    """For joints that turn twice: the angle and the distance of the axes of the two factors."""
    worst, place = np.zeros(frame.length.shape), 0
    middle = fixed(frame.middle.T)
    for count in joints:
        for other in factors[place + 1 : place + count]:
            first = factors[place]
            crossed = np.array(_cross(first[1:4], other[1:4]), dtype=object)
            lengths = (first[1:4] ** 2).sum(0) * (other[1:4] ** 2).sum(0)
            angle = np.sqrt(ratio((crossed**2).sum(0), lengths))
            distance = np.linalg.norm(_foot(first, middle) - _foot(other, middle), axis=0)
            gap = np.maximum(angle / (RTOL + ROUNDING), distance / (RTOL * frame.length + ROUNDING * reach))
            worst = np.maximum(worst, gap)
        place += count
    return worst


def judge_motion(coefficients, poses, frame: Frame) -> Verdict:
    """Whether motion polynomials pass through the first three poses at ∞, 0 and 1, and never leave the Study quadric.

    The parameter of a fourth pose is not part of a polynomial; the 6R linkages of a cubic know it.
    """
    polynomial = [fixed(c.T) for c in coefficients]
    middle, parts = fixed(frame.middle.T), {}
    for number, (t, pose) in enumerate(zip((None, 0, ONE), poses, strict=False)):
        reached = polynomial[0] if t is None else value(polynomial, t)
        parts[f"pose {number} missed"] = _gap(reached, fixed(pose.T), middle, frame, frame.reach)
    allowed = RTOL * frame.length + ROUNDING * frame.reach
    between = [_off_the_quadric(value(polynomial, t * ONE // 4)) / allowed for t in (-9, -2, 1, 3, 11, 40)]
    return _verdict({**parts, "off the Study quadric": np.max(between, axis=0)})


def judge_dyad(h1, h2, home, poses, frame: Frame) -> Verdict:
    """Whether open chains of two turns reach the poses; h1, h2, home of shape (n, 8)."""
    h = [fixed(x.T) for x in (h1, h2)]
    start, middle = fixed(home.T), fixed(frame.middle.T)
    reach = np.maximum(frame.reach, _farthest(h, middle) + np.linalg.norm(frame.middle, axis=-1))
    parts = {"axes that are no lines": _skewness(h, frame, reach)}
    for number, pose in enumerate(poses):
        wanted = fixed(pose.T)
        seen = product(wanted, conjugate(start))
        reached = product(_nearest(h, seen), start)
        gap = _gap(reached, wanted, middle, frame, reach)
        for row in np.flatnonzero(~(gap <= 1)):
            gap[row] = _nearer(h, wanted, start, middle, frame, reach, row)
        parts[f"pose {number} missed"] = gap
    return _verdict(parts)


def _nearest(h, pose) -> np.ndarray:
    """The pose of a dyad with the turns that the orientation of a pose asks for.

    Among x0 + x1 h1 + x2 h2 + x3 h1h2 those with x0 : x1 = x2 : x3 = a1 : −b1 are (a1 − b1 h1)(a2 − b2 h2).
    """
    x0, x1, x2, x3 = _coordinates(h, pose)
    (a1, b1), (a2, b2) = _larger((x0, -x1), (x2, -x3)), _larger((x0, -x2), (x1, -x3))
    return product(_turned(a1, b1, h[0]), _turned(a2, b2, h[1]))


def _turned(a, b, h) -> np.ndarray:
    """a − b h, for numbers a, b of any scale."""
    scale = np.maximum(np.maximum(abs(a), abs(b)), 1)
    a, b = (a * ONE) // scale, (b * ONE) // scale
    result = -((h * b) >> BITS)
    result[0] = result[0] + a
    return result


def _larger(x, y) -> tuple:
    first = np.array(x[0] ** 2 + x[1] ** 2 >= y[0] ** 2 + y[1] ** 2, dtype=bool)
    return np.where(first, x[0], y[0]), np.where(first, x[1], y[1])


def _coordinates(h, pose) -> tuple:
    """The primal part of a pose in the basis 1, h1, h2, h1h2, up to a factor, by its inner products."""
    h1, h2 = h
    both = product(h1, h2)
    one = np.zeros_like(h1)
    one[0] = ONE
    n1, n2, c = ((x[:4] * y[:4]).sum(0) >> BITS for x, y in ((h1, h1), (h2, h2), (h1, h2)))
    along = [(pose[:4] * x[:4]).sum(0) >> BITS for x in (one, h1, h2, both)]
    square = n1 * n2 >> BITS
    rows = (
        square * along[0] + c * along[3],
        n2 * along[1] - c * along[2],
        n1 * along[2] - c * along[1],
        c * along[0] + along[3] * ONE,
    )
    return tuple(x >> BITS for x in rows)


def _nearer(h, wanted, start, middle, frame: Frame, reach, row: int) -> float:
    """The gap of the nearest pose of one dyad, by Gauss and Newton's method in both angles.

    Where the axes are nearly parallel the orientation alone does not tell the turns well.
    """
    one = [x[:, [row]] for x in (*h, wanted, start)]
    h1, h2, wanted, start = one
    there, frame, reach = middle[:, [row]], frame[[row]], reach[[row]]
    best = np.inf
    for first in (_angles(*_coordinates((h1, h2), product(wanted, conjugate(start)))), (0.0, 0.0), (3.0, 3.0)):
        angles = np.array(first)
        for _ in range(12):
            residual = _residual(h1, h2, wanted, start, there, frame, reach, angles)
            best = min(best, float(np.linalg.norm(residual)))
            step = 1e-6
            columns = [
                (_residual(h1, h2, wanted, start, there, frame, reach, angles + step * e) - residual) / step
                for e in np.eye(2)
            ]
            J = np.array(columns).T
            if not np.isfinite(J).all():
                break
            angles = angles - np.linalg.lstsq(J, residual, rcond=None)[0]
    return best


def _angles(x0, x1, x2, x3) -> tuple:
    (a1, b1), (a2, b2) = _larger((x0, -x1), (x2, -x3)), _larger((x0, -x2), (x1, -x3))
    return tuple(float(np.arctan2(float(ratio(b, ONE)[0]), float(ratio(a, ONE)[0]))) for a, b in ((a1, b1), (a2, b2)))


def _residual(h1, h2, wanted, start, middle, frame: Frame, reach, angles) -> np.ndarray:
    """The six components of a small displacement from wanted to reached, as multiples of what is allowed."""
    turns = []
    for angle, h in zip(angles, (h1, h2), strict=True):
        norm = ratio((h[1:4] ** 2).sum(0), ONE * ONE) ** 0.5
        turns.append(_turned(fixed(np.cos([angle])), fixed(np.sin([angle]) / norm), h))
    off = product(product(product(*turns), start), conjugate(wanted))
    p0 = off[0]
    turn = np.array([2 * ratio(x, p0)[0] for x in off[1:4]])
    u, v = off[1:4], off[5:8]
    moved = [
        2 * ratio(p0 * a + ((p0 * v[n] - off[4] * u[n] + w) << BITS), (off[:4] ** 2).sum(0) << BITS)[0]
        for n, (a, w) in enumerate(zip(_cross(u, middle), _cross(u, v), strict=True))
    ]
    allowed = RTOL * frame.turn + ROUNDING, RTOL * frame.length + ROUNDING * reach
    return np.concatenate([turn / allowed[0], np.array(moved) / allowed[1]])
