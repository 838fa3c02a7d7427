"""The plane of z: all 5R linkages through three poses with one joint of one dyad turning twice.

Let the axes of a dyad through the poses be A and B, with half-turns hA and hB, and let A turn twice while B turns
once: C = (t − h1)(t − h2)(t − hB) with h1, h2 = x + y hA.  With hA in the place of √−1 the pairs (x, y) are complex
numbers z1, z2.  In a pose (s_A − hA)(s_B − hB) the product (s_B − z1)(s_B − z2)(s_A + hA) must be real: for z1 given
this is one real linear equation for z2, and two poses determine z2.  It is the isogonal conjugate of z1 in the triangle
s_B1, s_B2, z*, where z* belongs to the Bennett linkage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.dyad import Dyad
from kinlib.dyad_routes import on_axis
from kinlib.errors import Fault, check_degenerate, first_fault, report_faults
from kinlib.factorization import bennett_flip
from kinlib.linkage import Linkage, verified_loop
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import polished, product_of
from kinlib.poses import PoseProblem, gap, opening, seen_together
from kinlib.rows import BLOCK, broadcast, chosen, flat, joined, masked, picked, replaced
from kinlib.scalar import as_float, as_scalars, divide, is_zero, promote
from kinlib.three_poses import ALMOST, GOOD, MET, Stop, two_dyads
from kinlib.typing import Array, Degenerate, PoseLike, Scalars, ZLike

__all__ = ["ZFault", "ZPlane", "z_planes"]


class ZFault(Fault):
    """What can be wrong with a point of the plane of z."""

    REAL = 1, "z is real: the joint would turn once only, as in the Bennett linkage through the poses"
    BENNETT = 2, "z belongs to the Bennett linkage through the poses: its partner is not determined"
    CIRCUMCIRCLE = (
        3,
        ("z lies on the circumcircle of the triangle: its isogonal conjugate is at infinity, and the cubic is a conic"),
    )
    MISSES_1 = 4, "z lies on a side of the triangle: the cubic misses pose 1"
    MISSES_2 = 5, "z lies on a side of the triangle: the cubic misses pose 2"
    SAME_QUADRATIC = (
        6,
        (
            "the quadratic of z or of its partner is that of the other axis (z = ±√−1): every factorization begins "
            "with the joint that turns twice, so there is no 5R"
        ),
    )
    OWN_CONJUGATE = (
        7,
        ("z is an incentre or excentre of the triangle, its own isogonal conjugate: the two 5R linkages coincide"),
    )
    INVALID = 8, "expected a finite z, and poses that have a plane"


ON_IT = 1e-12
"""How near to a bad place, relative to the size of the numbers, a float is taken to be on it."""

SIDES = ("base", "moving")

Point: TypeAlias = tuple[Scalars, Scalars]
"""The coordinates x, y of a point of the plane of z."""

Factors: TypeAlias = tuple[DualQuaternion, ...]
"""The h1, h2, h3 of a chain (t − h1)(t − h2)(t − h3)."""


@dataclass(frozen=True)
class PlaneNumber:
    """A number x + y h of the plane in which h, with h² = −n, stands for √−1."""

    x: Scalars
    y: Scalars
    n: Scalars

    __array_ufunc__ = None

    def __mul__(self, other: PlaneNumber) -> PlaneNumber:
        return PlaneNumber(self.x * other.x - self.n * (self.y * other.y), self.x * other.y + self.y * other.x, self.n)

    def __rsub__(self, real: Scalars) -> PlaneNumber:
        return PlaneNumber(real - self.x, -self.y, self.n)

    def over(self, shape: tuple[int, ...]) -> PlaneNumber:
        """The numbers of a whole batch, one after the other."""
        return PlaneNumber(flat(self.x, shape), flat(self.y, shape), flat(self.n, shape))

    def some(self, rows: slice) -> PlaneNumber:
        """The numbers of some rows."""
        return PlaneNumber(self.x[rows], self.y[rows], self.n[rows])

    def square(self) -> Scalars:
        """The square of the absolute value."""
        return self.x * self.x + self.n * (self.y * self.y)

    def length(self) -> Array:
        """The absolute value, in floats."""
        return np.sqrt(as_float(self.square()))

    def at(self, h: DualQuaternion) -> DualQuaternion:
        """The factor x + y h."""
        return h * self.y + self.x


@dataclass(frozen=True, eq=False)
class ZPlane:
    """The plane of z of one dyad through three poses and one of its joints, which is to turn twice.

    A point of it is a complex number, an array of them, or a pair (x, y) of real numbers; pairs keep exact numbers
    exact.  Lengths in the plane have no unit.  They refer to the half-turns as they are: where an exact half-turn hB is
    not of length 1, x counts in units of |hB|, and y in units of |hB|/|hA|.

    Parameters
    ----------
    problem : PoseProblem
        The three poses.
    hA, hB : DualQuaternion
        The half-turns about the joint that turns twice and about the other one, in the problem's frame; both reversed
        and with opposite signs for the moving side, where the motion is looked at from the other end.
    stops : ((s_A1, s_B1), (s_A2, s_B2))
        The parameters of both joints in the second pose and in the third.
    side : {"base", "moving"}
        Which joint of the dyad turns twice.

    Examples
    --------
    >>> from kinlib.gallery import THREE_POSES
    >>> plane = z_planes(*THREE_POSES)[2]
    >>> plane.corners
    ((Fraction(0, 1), Fraction(0, 1)), (Fraction(2, 1), Fraction(0, 1)), (Fraction(0, 1), Fraction(2, 1)))
    >>> plane.partner((1, 3)), plane.fault((2, 2)).name
    ((Fraction(6, 1), Fraction(2, 1)), 'CIRCUMCIRCLE')
    """

    problem: PoseProblem
    hA: DualQuaternion
    hB: DualQuaternion
    stops: tuple[Stop, Stop]
    side: str

    @classmethod
    def of(cls, dyad: Dyad, p1: PoseLike, p2: PoseLike, *, side: str = "base") -> ZPlane:
        """The plane of a dyad that reaches two poses besides its home.

        Raises
        ------
        DegenerateError
            If the dyad does not reach a pose.
        """
        problem = seen_together(dyad.home, p1, p2)
        h1, h2 = (problem.inward(h) for h in (dyad.h1, dyad.h2))
        return cls._on_side(problem, h1, h2, (dyad.parameters(p1), dyad.parameters(p2)), side)

    @classmethod
    def _on_side(
        cls, problem: PoseProblem, h1: DualQuaternion, h2: DualQuaternion, stops: tuple[Stop, Stop], side: str
    ) -> ZPlane:
        if side not in SIDES:
            raise ValueError(f"expected the side 'base' or 'moving', got {side!r}")
        if side == "base":
            return cls(problem, h1, h2, stops, side)
        (a1, b1), (a2, b2) = stops
        return cls(problem, -h2, -h1, ((b1, a1), (b2, a2)), side)

    @property
    def corners(self) -> tuple[Point, Point, Point]:
        """The triangle s_B1, s_B2, z*, as pairs (x, y)."""
        (a1, b1), (a2, b2) = self.stops
        slope = divide(b2 - b1, a2 - a1)
        return (b1, b1 * 0), (b2, b2 * 0), (b1 - slope * a1, slope)

    @property
    def circumcircle(self) -> tuple[complex, float]:
        """Centre and radius of the circle through the corners, in floats."""
        (b1, _), (b2, _), (x, y) = ((as_float(u), as_float(v) * self._unit) for u, v in self.corners)
        middle = (b1 + b2) / 2
        height = ((x - middle) ** 2 + y * y - (b1 - middle) ** 2) / (2 * y)
        return middle + 1j * height, np.hypot(b1 - middle, height)

    @property
    def _unit(self) -> Array:
        """The length of hA: y counts in its inverse."""
        return np.sqrt(as_float(null_form(self.hA, self.hA)))

    def partner(self, z: ZLike) -> Scalars | tuple[Scalars, Scalars]:
        """The second root z2 of the joint that turns twice, for the first root z; infinite or NaN where there is none.

        Parameters
        ----------
        z : complex, array of complex, or pair (x, y)

        Returns
        -------
        of the same kind as z
        """
        z1 = self._number(z)
        with np.errstate(invalid="ignore", divide="ignore"):
            z2 = self._partner(z1, *self._products(z1), False)
        return (z2.x, z2.y) if isinstance(z, tuple) else z2.x + 1j * z2.y

    def fault(self, z: ZLike) -> ZFault | Array | None:
        """What is wrong at a point: a `ZFault`, or None; for arrays the numbers of the faults, 0 for none."""
        z1 = self._number(z)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            faults = self._faults(z1, *self._with_partner(z1))
        if np.ndim(faults):
            return faults
        return ZFault(int(faults)) if faults else None

    def chains(self, z: ZLike, *, degenerate: Degenerate = "raise") -> tuple[Factors, ...]:
        """The three chains of linear factors that share one cubic: the dyad's, and the two that close it to a 5R.

        Raises
        ------
        DegenerateError
            Naming what is wrong with z.
        """
        chains, bad = self._checked_chains(self._number(z), degenerate, "")
        return tuple(self._outward(chain, bad) for chain in chains)

    def linkages(self, z: ZLike, *, degenerate: Degenerate = "raise", place: str = "") -> tuple[Linkage, Linkage]:
        """The two 5R linkages for a point z, whose couplers visit the poses."""
        chains, bad = self._checked_chains(self._number(z), degenerate, place)
        first, *partners = (self._outward(chain, bad) for chain in chains)
        joints = (2, 1, 1, 1, 1) if self.side == "base" else (1, 2, 1, 1, 1)
        one_loop, other_loop = (
            verified_loop(first, partner, home=self.problem.home, joints=joints, parameters=self.parameters)
            for partner in partners
        )
        return one_loop, other_loop

    @property
    def parameters(self) -> tuple[Scalars, ...]:
        """The t at which the linkages are in the three poses."""
        return (math.inf, *(s_b for _, s_b in self.stops))

    def _outward(self, chain: Factors, bad: Array) -> Factors:
        """The factors in the frame of the poses, from the base to the coupler."""
        if self.side == "moving":
            chain = tuple(h.conjugate() for h in reversed(chain))
        with np.errstate(invalid="ignore", over="ignore"):  # where there is no plane of z
            return tuple(masked(self.problem.outward(h), bad) for h in chain)

    def _number(self, z: ZLike) -> PlaneNumber:
        return PlaneNumber(*_coordinates(z), null_form(self.hA, self.hA))

    def _products(self, z1: PlaneNumber) -> tuple[PlaneNumber, PlaneNumber]:
        """w = (s_B − z1)(s_A + hA) for both poses."""
        w1, w2 = ((s_b - z1) * PlaneNumber(s_a, 1, z1.n) for s_a, s_b in self.stops)
        return w1, w2

    def _partner(self, z1: PlaneNumber, w1: PlaneNumber, w2: PlaneNumber, unsolved: bool | Array) -> PlaneNumber:
        """The z2 with Im (s_B − z2) w = 0 at both poses."""
        determinant = w1.y * w2.x - w1.x * w2.y + unsolved  # any number but zero where there is no answer
        right1, right2 = (s_b * w.y for (_, s_b), w in zip(self.stops, (w1, w2), strict=True))
        x = divide(right1 * w2.x - w1.x * right2, determinant)
        y = divide(w1.y * right2 - right1 * w2.y, determinant)
        return PlaneNumber(x, y, z1.n)

    def _with_partner(self, z1: PlaneNumber) -> tuple[PlaneNumber, np.ndarray]:
        """The partner, and what is wrong with z1 before its partner is known."""
        w1, w2 = self._products(z1)
        length1, length2 = w1.length(), w2.length()
        finite = np.isfinite(as_float(z1.x + z1.y)) & np.isfinite(length1) & np.isfinite(length2)
        early = first_fault(
            (~finite, ZFault.INVALID),
            (is_zero(z1.y, self._size(z1), ON_IT), ZFault.REAL),
            (is_zero(w1.y, length1, ON_IT) & is_zero(w2.y, length2, ON_IT), ZFault.BENNETT),
            (is_zero(w1.y * w2.x - w1.x * w2.y, length1 * length2, ON_IT), ZFault.CIRCUMCIRCLE),
        )
        return self._partner(z1, w1, w2, early > 0), early

    def _faults(self, z1: PlaneNumber, z2: PlaneNumber, early: np.ndarray, near: float = ON_IT) -> np.ndarray:
        """What is wrong with a pair of roots; with a larger number for near, what is nearly so."""
        on_side = is_zero(z2.y, self._size(z2), near)
        b1, b2 = (s_b for _, s_b in self.stops)
        nearer = abs(as_float(z2.x - b1)) <= abs(as_float(z2.x - b2))
        first, second = ((z.x, z.square()) for z in (z1, z2))
        other = (0, null_form(self.hB, self.hB))
        late = first_fault(
            (on_side & nearer, ZFault.MISSES_1),
            (on_side, ZFault.MISSES_2),
            (_same_quadratic(first, other, near) | _same_quadratic(second, other, near), ZFault.SAME_QUADRATIC),
            (_same_quadratic(first, second, near), ZFault.OWN_CONJUGATE),
        )
        return np.where(early, early, late)

    def _size(self, z: PlaneNumber) -> Array:
        return z.length() + sum(abs(as_float(s_b)) for _, s_b in self.stops)

    def _checked_chains(self, z1: PlaneNumber, degenerate: Degenerate, place: str) -> tuple[list[Factors], np.ndarray]:
        """The chains in the problem's frame, and the rows for which there are none."""
        check_degenerate(degenerate)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            z2, early = self._with_partner(z1)
            faults = self._faults(z1, z2, early)
            place = place or f"{self.side} joint turning twice: "
            bad = report_faults(faults, ZFault, degenerate, place=place)
            chains, missed = self._improved(*self._in_blocks(z1, z2))
            lost = ~bad & ~(missed <= MET)
        if lost.any():
            nearest, how_near = self._nearest(z1, z2)
            report_faults(lost * nearest, ZFault, degenerate, place=place + ALMOST, how_near=how_near)
        return chains, bad | lost

    def _in_blocks(self, z1: PlaneNumber, z2: PlaneNumber) -> tuple[list[Factors], np.ndarray]:
        """The chains and what they miss, a block of the rows of a batch at a time."""
        shape = np.broadcast_shapes(self.problem.home.shape, np.shape(z1.x))
        if self.problem.is_exact or math.prod(shape) <= BLOCK:
            return self._tried(z1, z2)
        blocks = [slice(n, n + BLOCK) for n in range(0, math.prod(shape), BLOCK)]
        plane, first, second = self._over(shape), z1.over(shape), z2.over(shape)
        parts = [plane._some(rows)._tried(first.some(rows), second.some(rows)) for rows in blocks]
        chains = [
            tuple(joined(h, shape) for h in zip(*same, strict=True))
            for same in zip(*(c for c, _ in parts), strict=True)
        ]
        return chains, joined([missed for _, missed in parts], shape)

    def _over(self, shape: tuple[int, ...]) -> ZPlane:
        """The planes of a whole batch, one after the other."""
        first, second = ((flat(a, shape), flat(b, shape)) for a, b in self.stops)
        others = [flat(q, shape) for q in self.problem.others]
        problem = replace(self.problem, others=DualQuaternion.stack(others))
        return ZPlane(problem, flat(self.hA, shape), flat(self.hB, shape), (first, second), self.side)

    def _some(self, rows: slice) -> ZPlane:
        """The planes of some rows."""
        (a1, b1), (a2, b2) = self.stops
        stops = (a1[rows], b1[rows]), (a2[rows], b2[rows])
        problem = replace(self.problem, others=self.problem.others[:, rows])
        return ZPlane(problem, self.hA[rows], self.hB[rows], stops, self.side)

    def _tried(self, z1: PlaneNumber, z2: PlaneNumber) -> tuple[list[Factors], np.ndarray]:
        """The chains, and how far they are from the poses and from each other."""
        chains = _factorizations(z1.at(self.hA), z2.at(self.hA), self.hB)
        return chains, np.asarray(self._missed(chains))

    def _improved(self, chains: list[Factors], missed: np.ndarray) -> tuple[list[Factors], np.ndarray]:
        """The chains, better ones where they miss a pose or do not share the cubic; and by how much they still do."""
        poor = ~(missed <= GOOD) & np.isfinite(missed)
        if self.problem.is_exact or not poor.any():
            return chains, missed
        kept = [tuple(on_axis(picked(h, poor)) for h in chain) for chain in chains]
        C = MotionPolynomial.from_coefficients(product_of(kept[0]))
        tried = [kept[0], *(tuple(on_axis(h) for h in polished(C, chain)) for chain in kept[1:])]
        before, now = (np.asarray(self._missed(these, poor)) for these in (kept, tried))
        gain = now < before
        missed = missed.copy()
        missed[poor] = np.where(gain, now, before)
        kept = [
            tuple(chosen(gain, new, old) for new, old in zip(*both, strict=True))
            for both in zip(tried, kept, strict=True)
        ]
        return [
            tuple(replaced(broadcast(h, poor.shape), poor, new) for h, new in zip(*both, strict=True))
            for both in zip(chains, kept, strict=True)
        ], missed

    def _missed(self, chains: list[Factors], rows: np.ndarray | None = None) -> np.ndarray:
        """How far the chains are from the poses, and from each other where a joint turns fastest, at t = Re f."""
        stops, seen = self.parameters[1:], list(self._seen)
        if rows is not None:
            stops = tuple(np.broadcast_to(t, rows.shape)[rows] for t in stops)
            seen = [picked(q, rows) for q in seen]
        places = [*stops, *(h.scalar_part for h in chains[0])][: 3 if self.problem.is_exact else None]
        t = np.stack(np.broadcast_arrays(*places))
        values = [_product_at(chain, t) for chain in chains]
        off = [gap(values[0][n], q) for n, q in enumerate(seen)]
        off += [opening(values[0], value).max(axis=0) for value in values[1:]]
        return np.max(np.broadcast_arrays(*off), axis=0)

    @property
    def _seen(self) -> DualQuaternion:
        """The poses as seen from the end from which the chains begin."""
        others = self.problem.others
        return others if self.side == "base" else others.conjugate()

    def _nearest(self, z1: PlaneNumber, z2: PlaneNumber) -> tuple[np.ndarray, np.ndarray]:
        """The bad place that z is nearest to, and how near, relative to the size of the numbers."""
        w1, w2 = self._products(z1)
        length1, length2 = w1.length(), w2.length()
        size1, size2 = self._size(z1), self._size(z2)
        b1, b2 = (s_b for _, s_b in self.stops)
        nearer = abs(z2.x - b1) <= abs(z2.x - b2)
        side = abs(z2.y) / size2
        n = null_form(self.hB, self.hB)
        quadratics = [abs(z.x) + abs(z.square() - n) for z in (z1, z2)]
        measured = np.array(np.broadcast_arrays(
            abs(z1.y) / size1,
            abs(w1.y) / length1 + abs(w2.y) / length2,
            abs(w1.y * w2.x - w1.x * w2.y) / (length1 * length2),
            np.where(nearer, side, np.inf),
            np.where(nearer, np.inf, side),
            np.minimum(*quadratics) / n,
            (abs(z1.x - z2.x) + abs(abs(z1.y) - abs(z2.y))) / size1,
        ))  # fmt: skip
        measured = np.where(np.isnan(measured), np.inf, measured)
        return 1 + np.argmin(measured, axis=0), measured.min(axis=0)


def z_planes(
    p0: PoseLike, p1: PoseLike, p2: PoseLike, *, degenerate: Degenerate = "raise"
) -> tuple[ZPlane, ZPlane, ZPlane, ZPlane]:
    """The four planes of z of three poses: of each of the two dyads, with its base joint and with its moving joint.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Poses that have two dyads and a conic (Theorem 2).  Exchanging p1 and p2 mirrors the planes, x to −x.
    degenerate : {"raise", "nan"}
        What to do about rows of a batch that have no planes.
    """
    problem = seen_together(p0, p1, p2, degenerate=degenerate)
    both = two_dyads(problem, degenerate)
    base1, moving1, base2, moving2 = (
        ZPlane._on_side(problem, *both.half_turns(n), both.stops(n), side) for n in range(2) for side in SIDES
    )
    return base1, moving1, base2, moving2


def _coordinates(z: ZLike) -> Point:
    """The x, y of a point of the plane: of a pair of real numbers as they are, of complex numbers in floats."""
    if not isinstance(z, tuple):
        points = np.asarray(as_float(as_scalars(z)), dtype=complex)
        return points.real, points.imag
    if len(z) != 2:
        raise ValueError(f"expected z as a complex number or as a pair (x, y) of real numbers, got {len(z)} numbers")
    x, y = promote(*(as_scalars(part) for part in z))
    if "c" in (x.dtype.kind, y.dtype.kind):
        raise ValueError("expected z as a complex number or as a pair (x, y) of real numbers, got a complex part")
    return divide(x, 1), divide(y, 1)


def _same_quadratic(first: tuple[Scalars, Scalars], second: tuple[Scalars, Scalars], near: float) -> bool | Array:
    """Whether t² − 2xt + q is one polynomial for two pairs (x, q)."""
    (x, q), (y, r) = first, second
    scale = as_float(abs(q) + abs(r))
    return is_zero(x - y, np.sqrt(scale), near) & is_zero(q - r, scale, near)


def _factorizations(h1: DualQuaternion, h2: DualQuaternion, hB: DualQuaternion) -> list[Factors]:
    """The factors h1, h2, hB of the cubic with A turning twice, and those of its two admissible partners.

    The quadratic factors of C C̄ are those of h1, h2 and hB.  A partner begins with the quadratic of hB and ends
    with that of h1 or of h2; two exchanges of neighbours bring hB to the front.
    """
    return [(h1, h2, hB), _brought_to_front(h1, h2, hB), _brought_to_front(h2, h1, hB)]


def _brought_to_front(h1: DualQuaternion, h2: DualQuaternion, h3: DualQuaternion) -> Factors:
    """The factorization with the quadratics of h3, h1, h2 in this order."""
    middle, k3 = bennett_flip(h2, h3)
    k1, k2 = bennett_flip(h1, middle)
    return k1, k2, k3


def _product_at(chain: Factors, t: np.ndarray) -> DualQuaternion:
    """(t − h1)(t − h2)(t − h3) at several parameters, shape (m, ...)."""
    h1, h2, h3 = chain
    return (t - h1) * (t - h2) * (t - h3)
