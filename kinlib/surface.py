"""The surface on which a dyad keeps a point: where a line meets it, and what of it is next to a place.

A stop of a dyad is a pair (t1, t2) of parameters of its two joints, and so a pose.  A datum that leaves finitely many
stops costs a linkage that carries the dyad one of its parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, left_matrix, null_form, one
from kinlib.dyad import Dyad
from kinlib.errors import DegenerateError
from kinlib.line import Line
from kinlib.poses import moved_origin, stretched
from kinlib.scalar import as_float, as_vectors
from kinlib.typing import Array, ArrayLike, PointLike

__all__ = ["NearestStop", "nearest_stop", "stops_on_line"]

Stop: TypeAlias = tuple[Any, Any]
"""Parameters t1, t2 of the joints of a dyad; ∞ where a joint is at home."""

TOUCHING = 1e-7
"""Two places on a line are one, where the line touches, if they are no farther apart in units of the dyad."""

ON_AXIS = 1e-9
"""A point is on an axis, and two axes meet or are parallel, if they are so near to it, in units of the dyad."""


class NearestStop(NamedTuple):
    """What a dyad reaches next to a place.

    Attributes
    ----------
    stop : pair of float
        The parameters t1, t2 of its joints.
    place : numpy.ndarray, shape (3,)
        Where it brings the point.
    distance : float
        How far that is from the place asked for, in units of length.
    """

    stop: Stop
    place: Array
    distance: float


def stops_on_line(dyad: Dyad, point: PointLike, line: Line, *, real: bool = True) -> tuple[Stop, ...]:
    """All stops at which a dyad brings a point of the moving frame to a line: at most four.

    Seen from the point at home, the poses p + εd of the 2R space have d = Ap for a real matrix A, and a pose brings the
    point to the place f + sl of the line exactly if 2d = (f + sl)p.  So s is an eigenvalue of p ↦ −l(2A − f)p.

    Parameters
    ----------
    dyad : Dyad
        With skew axes; single, computed with floats.
    point : array_like, shape (3,)
        In the moving frame.
    line : Line
        In the fixed frame.
    real : bool
        Whether complex stops are left out.  There are always four, counted as often as the line touches the surface.

    Returns
    -------
    tuple of pairs (t1, t2)
        In the order of the places along the line (of their real parts).

    Raises
    ------
    DegenerateError
        If the axes of the dyad are coplanar, or the point lies on the moving axis.

    Examples
    --------
    >>> from kinlib import act
    >>> dyad = Dyad(i, j - eps * i)
    >>> line = Line.through([0, 0, 3], act(dyad(1, 2), [1, 2, 0]))
    >>> for stop in stops_on_line(dyad, [1, 2, 0], line):
    ...     print([round(float(x), 6) for x in act(dyad(*stop), [1, 2, 0])])
    [-0.037654, -0.032275, 3.13448]
    [0.273369, 0.234317, 2.023681]
    [1.322031, 1.13317, -1.721541]
    [1.4, 1.2, -2.0]
    """
    seen = _Seen.of(dyad, point)
    if not isinstance(line, Line) or line.shape:
        raise TypeError(f"expected a single Line, got {line!r}")
    _check_skew(dyad, seen)
    basis = np.stack([x.coeffs for x in (one.astype(float), seen.h1, seen.h2, seen.h1 * seen.h2)], axis=-1)
    inverse = np.linalg.inv(basis[:4])
    foot, l = (_left(x) for x in seen.line(line))
    places, orientations = np.linalg.eig(-l @ (2 * basis[4:] @ inverse - foot))
    if not real:
        order = np.argsort(places.real, kind="stable")
        return tuple(seen.stop(inverse @ orientations[:, n]) for n in order)
    kept = [n for n in np.argsort(places.real, kind="stable") if 0 <= places[n].imag < TOUCHING]
    return tuple(seen.stop(inverse @ _without_phase(orientations[:, n])) for n in kept)


def nearest_stop(dyad: Dyad, point: PointLike, place: PointLike) -> NearestStop:
    """Where a dyad brings a point of the moving frame as near as possible to a place.

    The moving joint turns the point on a circle, and the base joint turns each of its places into the half-plane of
    the given one.  How near it comes there is a function of the angle of the moving joint, with at most eight
    stationary values: roots of a polynomial.

    Parameters
    ----------
    dyad : Dyad
        Single, computed with floats; its axes may be coplanar.
    point : array_like, shape (3,)
        In the moving frame.
    place : array_like, shape (3,)
        In the fixed frame.

    Raises
    ------
    DegenerateError
        If the point lies on the moving axis: then the moving joint may be anywhere.

    Examples
    --------
    >>> dyad = Dyad(i, j - eps * i)
    >>> found = nearest_stop(dyad, [1, 2, 0], [5, 0, 0])
    >>> round(found.distance, 6)
    4.192588
    """
    seen = _Seen.of(dyad, point)
    target = as_vectors(place, "places")
    if target.shape != (3,):
        raise ValueError(f"expected a single place of shape (3,), got shape {target.shape}")
    circle = _Circle.of(seen, (as_float(target) - seen.middle) / seen.length)
    angles = circle.stationary()
    beta = circle.polished(angles[np.argmin(circle.distance(angles))])
    alpha = circle.base_angle(beta)
    stop = seen.stop_of_angles(alpha, beta)
    reached = as_float(act(dyad(*stop), point))
    return NearestStop(stop, reached, float(np.linalg.norm(reached - as_float(target))))


@dataclass(frozen=True)
class _Seen:
    """A dyad as seen from a point at home, in units of its own size: half-turns of length 1, and what they were."""

    h1: DualQuaternion
    h2: DualQuaternion
    lengths: tuple[float, float]
    middle: Array
    length: float

    @classmethod
    def of(cls, dyad: Dyad, point: PointLike) -> _Seen:
        if not isinstance(dyad, Dyad) or dyad.shape:
            raise TypeError(f"expected a single Dyad, got {dyad!r}")
        x = as_vectors(point, "points")
        if x.shape != (3,):
            raise ValueError(f"expected a single point of shape (3,), got shape {x.shape}")
        middle = as_float(act(dyad.home, x))
        lengths = [float(np.sqrt(as_float(null_form(h, h)))) for h in (dyad.h1, dyad.h2)]
        turns = [DualQuaternion(as_float(h.coeffs) / n) for h, n in zip((dyad.h1, dyad.h2), lengths, strict=True)]
        turns = [moved_origin(h, middle) for h in turns]
        away = [float(np.linalg.norm(h.coeffs[5:])) for h in turns]
        length = max(away)
        if away[1] <= ON_AXIS * length or length == 0:
            raise DegenerateError("the point lies on the moving axis: it stays on a circle about the base axis")
        h1, h2 = (stretched(h, 1 / length) for h in turns)
        return cls(h1, h2, (lengths[0], lengths[1]), middle, length)

    def line(self, line: Line) -> tuple[Array, Array]:
        """The foot and the direction of a line."""
        l = as_float(line.direction)
        return (as_float(line.foot(self.middle)) - self.middle) / self.length, l / np.linalg.norm(l)

    def stop(self, x: Array) -> Stop:
        """The parameters of the point of the 2R space with coordinates t1 t2, −t2, −t1, 1."""
        pairs = ((x[0], x[1]), (x[2], x[3])), ((x[0], x[2]), (x[1], x[3]))
        (a1, b1), (a2, b2) = (max(pair, key=lambda ab: abs(ab[0]) + abs(ab[1])) for pair in pairs)
        return self._parameters(-a1, b1, -a2, b2)

    def stop_of_angles(self, alpha: float, beta: float) -> Stop:
        """The parameters of turns by two angles."""
        return self._parameters(-np.cos(alpha / 2), np.sin(alpha / 2), -np.cos(beta / 2), np.sin(beta / 2))

    def _parameters(self, a1: Any, b1: Any, a2: Any, b2: Any) -> Stop:
        first, second = (_quotient(n * a, b) for n, a, b in zip(self.lengths, (a1, a2), (b1, b2), strict=True))
        return first, second


@dataclass(frozen=True)
class _Circle:
    """The circle of the point about the moving axis, at home, and where its places are turned about the base axis.

    The points are centre + cos β · first + sin β · second.  In the half-planes about the base axis they have the
    distance √u(β) from it, and are at F(β) − u(β) from the height of the target, in squares.
    """

    centre: Array
    first: Array
    second: Array
    foot: Array
    axis: Array
    target: Array

    @classmethod
    def of(cls, seen: _Seen, target: Array) -> _Circle:
        (l1, m1), (l2, m2) = ((h.coeffs[1:4], h.coeffs[5:]) for h in (seen.h1, seen.h2))
        centre, foot = np.cross(l2, m2), np.cross(l1, m1)
        return cls(centre, -centre, -np.cross(l2, centre), foot, l1, target - foot)

    @property
    def away(self) -> float:
        """How far the target is from the base axis."""
        return float(np.linalg.norm(self._across(self.target)))

    def _across(self, x: Array) -> Array:
        return x - (x @ self.axis)[..., None] * self.axis

    def at(self, beta: ArrayLike) -> Array:
        """The points, as seen from the foot of the base axis."""
        angle = np.asarray(beta)[..., None]
        return self.centre - self.foot + np.cos(angle) * self.first + np.sin(angle) * self.second

    def distance(self, beta: ArrayLike) -> Array:
        """How far they are from the target, once turned into its half-plane."""
        radius = np.linalg.norm(self._across(self.at(beta)), axis=-1)
        return np.hypot(radius - self.away, (self.at(beta) - self.target) @ self.axis)

    def base_angle(self, beta: float) -> float:
        """The turn about the base axis that brings a point into the half-plane of the target."""
        x, y = self._across(self.at(beta)), self._across(self.target)
        return float(np.arctan2(np.cross(x, y) @ self.axis, x @ y)) if self.away > ON_AXIS else 0.0

    @property
    def _series(self) -> tuple[Array, Array]:
        """The Fourier coefficients of F and of u, from exp(−2iβ) to exp(2iβ)."""
        moving = np.array([self.first + 1j * self.second, 2 * (self.centre - self.foot), self.first - 1j * self.second])
        across = self._across(moving / 2)
        off = self.centre - self.foot - (self.target @ self.axis) * self.axis
        slope = np.array([0, (self.first + 1j * self.second) @ off, 0, (self.first - 1j * self.second) @ off, 0])
        return slope, np.sum([np.convolve(x, x) for x in across.T], axis=0)

    def stationary(self) -> Array:
        """The angles at which the distance is stationary, and perhaps some others."""
        F, u = self._series
        slope, bend = (1j * np.arange(-2, 3) * x for x in (F, u))
        slope = slope[1:4]
        polynomial = np.convolve(np.convolve(slope, slope), u) - self.away**2 * np.convolve(bend, bend)
        return np.append(np.angle(np.roots(polynomial[::-1])), 0.0)

    def polished(self, beta: float) -> float:
        """The angle, up to rounding, by Newton's method for F' √u − ρ u' = 0."""
        k = 1j * np.arange(-2, 3)
        for _ in range(4):
            waves = np.exp(k * beta)
            F, u = ([float((x * k**n @ waves).real) for n in range(3)] for x in self._series)
            root = np.sqrt(max(u[0], 1e-300))
            slope = F[2] * root + F[1] * u[1] / (2 * root) - self.away * u[2]
            moved = beta - (F[1] * root - self.away * u[1]) / slope if slope else beta
            if not self.distance(moved) <= self.distance(beta) + 1e-14:
                break
            beta = moved
        return float(beta)


def _quotient(a: Any, b: Any) -> Any:
    return np.asarray(a / b).item() if abs(b) > 1e-300 else np.inf


def _left(x: Array) -> Array:
    """The matrix of multiplication from the left by a vector, of quaternions."""
    return left_matrix(DualQuaternion([0, *x, 0, 0, 0, 0]))[:4, :4]


def _without_phase(x: Array) -> Array:
    """The real vector of which a complex one is a multiple."""
    largest = x[np.abs(x).argmax()]
    return (x / largest).real


def _check_skew(dyad: Dyad, seen: _Seen) -> None:
    base, moving = dyad.axes
    angle = np.sin(base.angle(moving))
    if angle <= ON_AXIS or base.distance(moving) <= ON_AXIS * seen.length:
        raise DegenerateError(
            "the axes are coplanar: the point stays on a plane or a sphere, and may have many stops in one place"
        )
