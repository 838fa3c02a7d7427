"""At which parameters a link of a loop has a given pose, and where it comes nearest to one that it does not reach."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from kinlib.chain import plain
from kinlib.circle import narrowed, roots_of, samples, turned_charts
from kinlib.displacement import act
from kinlib.drive import exact_real_roots
from kinlib.dual_quaternion import DualQuaternion, null_form, one
from kinlib.errors import DegenerateError, check_degenerate, named_rows, rows_where
from kinlib.loop import Loop
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.rows import broadcast
from kinlib.scalar import ROUNDING, as_float, divide, is_exact, is_zero
from kinlib.typing import Array, Degenerate

__all__ = ["NearestPose", "nearest_pose", "parameters_of_pose"]

SAMPLES = 24
"""At how many angles of each joint a motion is looked at first."""

AT_INFINITY = 1e-14
"""Half a phase within which a parameter counts as infinite."""

ONE = 1e-6
"""Parameters whose phases are nearer than this are one."""


class NearestPose(NamedTuple):
    """Where a motion comes nearest to a pose.

    Nearest means the least mean square of the distances that the points of a ball about the origin of the moving frame
    would have to go, with a radius of √(5/3) times the size of the linkage: then D² = |shift|² + ⅓ size² ‖R − R'‖².

    Attributes
    ----------
    t : float or array of shape (...)
    angle : float or array
        By how much it is turned against the pose there, in radians.
    shift : float or array
        How far the origin of the moving frame is from that of the pose.
    """

    t: Any
    angle: Any
    shift: Any


class _Problem(NamedTuple):
    """Rows of factors to the link, home, the pose, the size: everything flat, in floats; see :func:`_flat`."""

    factors: list[DualQuaternion]
    home: DualQuaternion
    pose: DualQuaternion
    size: Array
    middle: Array
    spread: Array

    def pick(self, rows: Array) -> _Problem:
        factors, rest = [f[rows] for f in self.factors], (self.size[rows], self.middle[rows], self.spread[rows])
        return _Problem(factors, self.home[rows], self.pose[rows], *rest)

    def at(self, phase: Array) -> tuple[DualQuaternion, DualQuaternion]:
        """A multiple of the link's pose at phases, shape (..., rows), and its derivative."""
        sine, cosine = np.sin(phase / 2), np.cos(phase / 2)
        weight, turn = self.middle * sine - self.spread * cosine, (self.middle * cosine + self.spread * sine) / 2
        pose, change = one.astype(float), one.astype(float) * 0.0
        for f in self.factors:
            value, slope = weight - f * sine, turn - f * (cosine / 2)
            pose, change = pose * value, change * value + pose * slope
        return pose * self.home, change * self.home

    def gap(self, phase: Array) -> tuple[Array, Array]:
        """The sine of half the angle and the shift at phases."""
        q, _ = self.at(phase)
        return np.linalg.norm(self._across(q), axis=-1), np.linalg.norm(self._shift(q), axis=-1)

    def _across(self, q: DualQuaternion) -> Array:
        p, wanted = (_direction(x.coeffs[..., :4]) for x in (q, self.pose))
        return np.asarray(p - (p * wanted).sum(axis=-1, keepdims=True) * wanted)

    def _shift(self, q: DualQuaternion) -> Array:
        return np.asarray(act(q, [0.0, 0.0, 0.0]) - act(self.pose, [0.0, 0.0, 0.0]))

    def square(self, phase: Array) -> Array:
        """D², see :class:`NearestPose`; the square of ‖R − R'‖ is 8 sin² of half the angle."""
        sine, shift = self.gap(phase)
        return np.asarray(shift**2 + 8 / 3 * (self.size * sine) ** 2)

    def slope(self, phase: Array) -> Array:
        """Half the derivative of D² by the phase."""
        q, change = self.at(phase)
        p, turn = q.coeffs[..., :4], change.coeffs[..., :4]
        length = (p * p).sum(axis=-1, keepdims=True)
        grows = (p * turn).sum(axis=-1, keepdims=True) / length
        turning = (turn - grows * p) / np.sqrt(length)
        rate = (change * q.eps_conjugate().conjugate() + q * change.eps_conjugate().conjugate()).coeffs[..., 5:]
        moving = rate / length - 2 * grows * act(q, [0.0, 0.0, 0.0])
        away = (self._shift(q) * moving).sum(axis=-1)
        return np.asarray(away + 8 / 3 * self.size**2 * (self._across(q) * turning).sum(axis=-1))

    def t_at(self, phase: Array) -> Array:
        """The parameters of phases; ∞ where rounding could have moved it."""
        far = np.abs(np.sin(phase / 2)) < AT_INFINITY
        return np.where(far, np.inf, self.middle - self.spread / np.where(far, 1.0, np.tan(phase / 2)))


def _direction(p: Array) -> Array:
    return np.asarray(p / np.linalg.norm(p, axis=-1, keepdims=True))


def nearest_pose(loop: Loop, coupler: int, pose: DualQuaternion) -> NearestPose:
    """Where a link comes nearest to a pose."""
    problem, shape, defined = _flat(loop, coupler, pose)
    rows, phase = _dips(problem)
    square = problem.pick(rows).square(phase)
    best = np.full(defined.shape, np.nan)
    for n in range(len(best)):
        mine = np.flatnonzero(rows == n)
        if len(mine) and defined[n]:
            best[n] = phase[mine[np.argmin(square[mine])]]
    sine, shift = problem.gap(best)
    answer = (problem.t_at(best), 2 * np.arcsin(np.minimum(sine, 1)), np.where(defined, shift, np.nan))
    return NearestPose(*(plain(part.reshape(shape)) for part in answer))


def parameters_of_pose(
    loop: Loop, coupler: int, motion: MotionPolynomial, pose: DualQuaternion, rtol: float, degenerate: Degenerate
) -> Array:
    """All t at which a link has a pose, in their order, ∞ and then NaN at the end; shape (..., m)."""
    check_degenerate(degenerate)
    shape = np.broadcast_shapes(loop.shape, loop.home.shape, pose.shape)
    exact = all(is_exact(q.components) for q in (pose, *motion.coefficients))
    found = _exact_rows(motion, pose, shape) if exact else _float_rows(loop, coupler, pose, rtol)
    undefined = [np.isnan(as_float(x.coeffs)).any(axis=-1) for x in (pose, *motion.coefficients)] if not exact else []
    missed = np.array([not len(row) for row in found], dtype=bool).reshape(shape) & ~reduce(
        np.logical_or, undefined, False
    )
    if degenerate == "raise" and missed.any():
        raise _not_reached(missed, nearest_pose(loop, coupler, pose))
    count = max((len(row) for row in found), default=0) or 1
    table = np.full((len(found), count), np.nan, dtype=object if exact else float)
    for n, row in enumerate(found):
        table[n, : len(row)] = row
    return table.reshape(*shape, count)


def _not_reached(missed: Array, nearest: NearestPose) -> DegenerateError:
    rows = rows_where(missed)
    index = tuple(np.argwhere(missed)[0])
    t, angle, shift = (float(np.asarray(part)[index]) for part in nearest)
    return DegenerateError(
        f"{named_rows(rows)}the coupler does not reach the pose: where it is nearest, at t = {t:.6g}, it is turned by "
        f"{angle:.2g} rad and shifted by {shift:.2g} against it; nearest_pose() gives this t, rtol= accepts more",
        rows=rows,
    )


# ---- exactly -----------------------------------------------------------------------------------------


def _exact_rows(motion: MotionPolynomial, pose: DualQuaternion, shape: tuple[int, ...]) -> list[Any]:
    coefficients = [broadcast(c, shape) for c in motion.coefficients]
    pose = broadcast(pose, shape)
    return [_exact_row([c[n].coeffs for c in coefficients], pose[n].coeffs) for n in np.ndindex(shape)]


def _exact_row(coefficients: Sequence[Array], q: Array) -> list[Any]:
    """The real common roots of the 2×2 minors of (C(t), q), homogeneous in t."""
    pivot = next(n for n in range(8) if not is_zero(q[n]))
    minors = [[c[n] * q[pivot] - c[pivot] * q[n] for c in coefficients] for n in range(8) if n != pivot]
    minors = [minor for minor in minors if not np.all(is_zero(np.array(minor)))]
    infinite = [np.inf] if all(is_zero(minor[0]) for minor in minors) else []
    divisor = reduce(_greatest_divisor, (_trimmed(minor) for minor in minors))
    roots = list(exact_real_roots(divisor)) if len(divisor) > 1 else []
    finite = [t for t in roots if not np.isnan(as_float(t))]
    return [t for n, t in enumerate(finite) if not any(is_zero(t - s) for s in finite[:n])] + infinite


def _trimmed(polynomial: Sequence[Any]) -> list[Any]:
    start = next((n for n, c in enumerate(polynomial) if not is_zero(c)), len(polynomial))
    return list(polynomial[start:])


def _greatest_divisor(a: list[Any], b: list[Any]) -> list[Any]:
    """Euclid's algorithm for polynomials over a field."""
    while b:
        while len(a) >= len(b):
            factor = divide(a[0], b[0])
            a = _trimmed([x - factor * (b[n] if n < len(b) else 0) for n, x in enumerate(a)][1:])
        a, b = b, a
    return a


# ---- in floats ---------------------------------------------------------------------------------------


def _flat(loop: Loop, coupler: int, pose: DualQuaternion) -> tuple[_Problem, tuple[int, ...], Array]:
    shape = np.broadcast_shapes(loop.shape, loop.home.shape, pose.shape)

    def flat(q: DualQuaternion) -> DualQuaternion:
        return DualQuaternion(broadcast(q.astype(float), shape).coeffs.reshape(-1, 8))

    def numbers(x: Array) -> Array:
        return np.broadcast_to(x, shape).reshape(-1)

    factors = [flat(f) for f in loop.factors[: sum(loop.joints[:coupler])]]
    home, pose = flat(loop.home), flat(pose)
    lines = loop.chain.lines
    far = np.linalg.norm(
        act(home, [0.0, 0.0, 0.0]) - np.broadcast_to(lines.middle, (*shape, 3)).reshape(-1, 3), axis=-1
    )
    size = np.where(numbers(lines.length > lines.noise), numbers(lines.length), np.where(far > 0, far, 1.0))
    defined = np.isfinite(np.stack([x.coeffs for x in (*factors, home, pose)])).all(axis=(0, -1))
    middle, spread = numbers(loop.centred.middle), numbers(loop.centred.spread)
    return _Problem(factors, home, pose, size, middle, spread), shape, defined


def _dips(problem: _Problem) -> tuple[Array, Array]:
    """All local minima of the distance: the numbers of their rows, and phases."""
    with np.errstate(invalid="ignore"):
        phases = np.sort(np.concatenate([_first_looks(problem), _level_places(problem)]), axis=0)
        square = problem.square(phases)
        dips = (square <= np.roll(square, 1, axis=0)) & (square < np.roll(square, -1, axis=0))
    where, rows = np.nonzero(dips)
    count = len(phases)
    before, after = phases[where - 1, rows], phases[(where + 1) % count, rows]
    low = np.where(where == 0, before - 2 * np.pi, before)
    high = np.where(where == count - 1, after + 2 * np.pi, after)
    seen = problem.pick(rows)
    phase, _ = narrowed(seen.square, low, high)
    return rows, _levelled(seen, phase, (high - low) / 1e4)


def _levelled(problem: _Problem, phase: Array, step: Array) -> Array:
    """The places of minima, by Newton's method for the slope: values near a minimum say only half of its digits."""
    for _ in range(3):
        curvature = (problem.slope(phase + step) - problem.slope(phase - step)) / (2 * step)
        with np.errstate(divide="ignore", invalid="ignore"):
            change = problem.slope(phase) / curvature
        phase = phase - np.where((np.abs(change) < step) & (curvature > 0), change, 0.0)
    return phase


def _first_looks(problem: _Problem) -> Array:
    """Phases at which each joint has turned by many angles; no joint is too fast for them."""
    halves = np.pi * np.arange(1, SAMPLES) / SAMPLES
    looks = [np.zeros(problem.size.shape)]
    for f in problem.factors:
        x, y = f.components[0], np.sqrt((f.components[1:4] ** 2).sum(axis=0))
        looks += [2 * np.arctan2(problem.spread, problem.middle - x + y / np.tan(half)) for half in halves]
    return np.stack(looks)


def _level_places(problem: _Problem) -> Array:
    """Phases among which all are where the slope vanishes: between two of them there is at most one dip.

    With n factors D² is a quotient of polynomials of degree 2n, and its slope one over the square of the lower one.
    """
    degree = 4 * len(problem.factors)
    phases = 2 * samples(degree)
    values = np.stack([problem.slope(phase) * _weight(problem, phase) for phase in phases])
    values = np.where(np.isfinite(values), values, 0.0)
    charts = turned_charts(degree)
    best = np.abs(np.einsum("js,sr->jr", charts[:, 0], values)).argmax(axis=0)
    coefficients = np.einsum("rds,sr->rd", charts[best], values)
    coefficients[coefficients[:, 0] == 0] = np.eye(degree + 1)[0]
    roots = roots_of(coefficients)
    away = np.arctan2(1.0, roots.real) + np.pi * best[:, None] / len(charts)
    away = away + np.where(roots.imag < 0, np.pi / 2, 0.0)  # of a pair one is enough
    return np.asarray(np.remainder(2 * away, 2 * np.pi).T)


def _weight(problem: _Problem, phase: Array) -> Array:
    """What makes the slope a polynomial: the square of the norm of the motion."""
    q, _ = problem.at(phase)
    norm = null_form(q, q) / problem.spread ** (2 * len(problem.factors))
    return np.asarray(norm**2)


def _float_rows(loop: Loop, coupler: int, pose: DualQuaternion, rtol: float) -> list[Array]:
    problem, _, defined = _flat(loop, coupler, pose)
    rows, phase = _dips(problem)
    far = np.linalg.norm(act(problem.pose, [0.0, 0.0, 0.0]), axis=-1)
    allowed = rtol * (problem.size + far) + ROUNDING * far
    seen = problem.pick(rows)
    square, t = seen.square(phase), seen.t_at(phase)
    reached = np.sqrt(square) <= allowed[rows]
    found = []
    for n in range(len(defined)):
        mine = np.flatnonzero((rows == n) & reached)
        kept: list[int] = []
        for m in mine[np.argsort(square[mine])]:
            if all(abs(np.sin((phase[m] - phase[other]) / 2)) > ONE for other in kept):
                kept.append(int(m))
        found.append(np.sort(t[kept]))
    return found
