"""Goldberg linkages (5R) through three poses, with two real parameters to choose.

Take one of the two dyads through the poses, with axes A at the base and B, and let A turn twice while B turns
once.  Its motion is C = (t − h1)(t − h2)(t − hB) with h1, h2 = x + y hA, where hA and hB are the half-turns about
the axes and t is the parameter of B.  With hA in the place of √−1 the pairs (x, y) are complex numbers z1, z2.
For a pose (s_A − hA)(s_B − hB) the product (s_B − z1)(s_B − z2)(s_A + hA) must be real: for z1 given this is one
real linear equation for z2, and two poses determine z2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.dyad import Dyad
from kinlib.errors import report_faults
from kinlib.factorization import bennett_flip
from kinlib.interpolation import is_tangent
from kinlib.linkage import Linkage
from kinlib.poses import as_pose
from kinlib.scalar import as_float, as_scalars, divide, is_zero, promote
from kinlib.three_poses import FAULTS as POSE_FAULTS
from kinlib.three_poses import TANGENT, masked, pairs_through, relative

__all__ = ["goldberg_linkages"]

FAULTS = (
    "z is real: the joint would turn once only, as in the Bennett linkage through the poses",
    "z belongs to the Bennett linkage through the poses: its partner is not determined",
    "z lies on the circumcircle of the triangle: its isogonal conjugate is at infinity, and the cubic is a conic",
    "z lies on a side of the triangle: the cubic misses pose 1",
    "z lies on a side of the triangle: the cubic misses pose 2",
    "the quadratic of z or of its partner is that of the other axis (z = ±√−1): every factorization begins with "
    "the joint that turns twice, so there is no 5R",
    "z is an incentre or excentre of the triangle, its own isogonal conjugate: the two 5R linkages coincide",
)
REAL, BENNETT, CIRCUMCIRCLE, MISSES_1, MISSES_2, SAME_QUADRATIC, OWN_CONJUGATE = range(1, 8)
NEAR = 1e-10  # how near to a bad place, relative to the size of the numbers, is taken to be on it


def goldberg_linkages(p0, p1, p2, z, *, degenerate: str = "raise") -> tuple[Linkage, ...]:
    """The eight 5R linkages through three poses for a complex number z.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Any poses that have two dyads and a conic (Theorem 2); exact ones give exact linkages.
    z : complex, array of complex, or tuple (x, y)
        The first root z1 = x + √−1 y, not real.  It stands for h1 = x + y h, where h is the half-turn about the
        joint that turns twice; a pair of exact numbers keeps everything exact, with h as the exact dyad has
        it (of length 1 only if that root can be taken).
    degenerate : {"raise", "nan"}
        What to do about poses, or values of z, for which a linkage is not determined; with ``"nan"`` only the
        linkages concerned are NaN.

    Returns
    -------
    tuple of 8 Linkages
        For each of the two dyads: with its base joint turning twice, two linkages; with its moving joint
        turning twice, two linkages.

    Raises
    ------
    DegenerateError
        Naming the geometry, and the triangle in whose plane z is badly placed.

    Examples
    --------
    >>> poses = one, i * (j - eps * i), (1 - i) * (2 - j + eps * i)
    >>> linkages = goldberg_linkages(*poses, (1, 2))
    >>> len(linkages), linkages[0].joints, all(linkage.closure_residual() == 0 for linkage in linkages)
    (8, (2, 1, 1, 1, 1), True)
    """
    poses = [as_pose(p) for p in (p0, p1, p2)]
    z1 = _plane_point(z)
    pairs = pairs_through(poses, None, degenerate)
    faulty = report_faults(is_tangent(*poses) * TANGENT, POSE_FAULTS, degenerate)
    dyads = [Dyad(masked(h1, faulty), masked(h2, faulty)) for h1, h2 in pairs]
    seen = relative(*poses)
    linkages = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for number, dyad in enumerate(dyads, start=1):
            s1, s2 = (dyad.parameters(q) for q in seen)
            for side, build in (("base", _base_turns_twice), ("moving", _moving_turns_twice)):
                place = f"dyad {number}, {side} joint turning twice: "
                linkages += build(dyad, poses[0], s1, s2, z1, place, degenerate)
    return tuple(linkages)


@dataclass(frozen=True)
class _Plane:
    """A number x + y h of the plane in which h, with h² = −n, stands for √−1."""

    x: np.ndarray
    y: np.ndarray
    n: np.ndarray

    __array_ufunc__ = None

    def __mul__(self, other):
        return _Plane(self.x * other.x - self.n * self.y * other.y, self.x * other.y + self.y * other.x, self.n)

    def __rsub__(self, real):
        return _Plane(real - self.x, -self.y, self.n)

    def square(self):
        return self.x * self.x + self.n * self.y * self.y

    def length(self):
        """The square root of the square, in floats."""
        return np.sqrt(as_float(self.square()))

    def at(self, h: DualQuaternion) -> DualQuaternion:
        return h * self.y + self.x


def _plane_point(z) -> tuple:
    """The coordinates x, y of z: of a pair of real numbers as they are, of complex numbers in floats."""
    parts = [as_scalars(part) for part in z] if isinstance(z, tuple) and len(z) == 2 else [as_scalars(z)]
    floats = [part for part in parts if part.dtype.kind in "fc"]
    if not np.all([np.all(np.isfinite(part)) for part in floats]):
        raise ValueError("expected a finite z, got NaN or infinity")
    if len(parts) == 2 and all(part.dtype.kind != "c" for part in parts):
        return tuple(divide(part, 1) for part in promote(*parts))
    z = np.asarray(z, dtype=complex)
    return z.real, z.imag


def _base_turns_twice(dyad: Dyad, home: DualQuaternion, s1, s2, z1, place: str, degenerate: str) -> list[Linkage]:
    first, *partners = _chains(dyad.h1, dyad.h2, s1, s2, z1, place, degenerate)
    options = {"home": home, "joints": (2, 1, 1, 1, 1), "parameters": (math.inf, s1[1], s2[1])}
    return [Linkage.from_chains(first, second, **options) for second in partners]


def _moving_turns_twice(dyad: Dyad, home: DualQuaternion, s1, s2, z1, place: str, degenerate: str) -> list[Linkage]:
    """The mirror case, through the conjugate motion C̄, whose dyad has the axes −h2 and −h1."""
    first, *partners = map(_reversed, _chains(-dyad.h2, -dyad.h1, s1[::-1], s2[::-1], z1, place, degenerate))
    options = {"home": home, "joints": (1, 2, 1, 1, 1), "parameters": (math.inf, s1[0], s2[0])}
    return [Linkage.from_chains(first, second, **options) for second in partners]


def _reversed(factors) -> tuple[DualQuaternion, ...]:
    return tuple(h.conjugate() for h in reversed(factors))


def _chains(hA: DualQuaternion, hB: DualQuaternion, s1, s2, z, place: str, degenerate: str) -> list[tuple]:
    """The factors h1, h2, hB of the cubic with A turning twice, and those of its two admissible partners.

    The quadratic factors of C C̄ are those of h1, h2 and hB.  A partner begins with the quadratic of hB and ends
    with that of h1 or of h2; two exchanges of neighbours bring hB to the front.
    """
    z1 = _Plane(*z, null_form(hA, hA))
    products = [(s_b - z1) * _Plane(s_a, 1, z1.n) for s_a, s_b in (s1, s2)]
    early = _faults_of_z(z1, s1, s2, *products)
    messages = [place + fault for fault in FAULTS]
    unsolved = report_faults(early, messages, degenerate)
    z2 = _partner(z1, s1, s2, *products, unsolved)
    faults = np.where(early, early, _faults_of_pair(z1, z2, s1, null_form(hB, hB)))
    faulty = report_faults(faults, messages, degenerate)
    h1, h2 = z1.at(hA), z2.at(hA)
    chains = [(h1, h2, hB), _brought_to_front(h1, h2, hB), _brought_to_front(h2, h1, hB)]
    return [tuple(masked(h, faulty) for h in chain) for chain in chains]


def _partner(z1: _Plane, s1, s2, w1: _Plane, w2: _Plane, unsolved) -> _Plane:
    """The z2 with Im (s_B − z2) w = 0 for w = (s_B − z1)(s_A + h), at both poses."""
    determinant = w1.y * w2.x - w1.x * w2.y + unsolved  # any number but zero where there is no answer
    right1, right2 = s1[1] * w1.y, s2[1] * w2.y
    x = divide(right1 * w2.x - w1.x * right2, determinant)
    y = divide(w1.y * right2 - right1 * w2.y, determinant)
    return _Plane(x, y, z1.n)


def _faults_of_z(z1: _Plane, s1, s2, w1: _Plane, w2: _Plane) -> np.ndarray:
    """What can be wrong with z1 before its partner is known."""
    triangle = z1.length() + abs(as_float(s1[1])) + abs(as_float(s2[1]))
    length1, length2 = w1.length(), w2.length()
    conditions = [
        (is_zero(z1.y, triangle, 1e-13), REAL),
        (is_zero(w1.y, length1, NEAR) & is_zero(w2.y, length2, NEAR), BENNETT),
        (is_zero(w1.y * w2.x - w1.x * w2.y, length1 * length2, NEAR), CIRCUMCIRCLE),
    ]
    return _first(conditions)


def _faults_of_pair(z1: _Plane, z2: _Plane, s1, nB) -> np.ndarray:
    scale = z1.length() + z2.length() + abs(as_float(s1[1]))
    on_side = is_zero(z2.y, scale, 1e-13)
    quadratics = [(z.x, z.square()) for z in (z1, z2)]
    conditions = [
        (on_side & is_zero(s1[1] - z2.x, scale, 1e-6), MISSES_1),
        (on_side, MISSES_2),
        (_same_quadratic(quadratics[0], (0, nB)) | _same_quadratic(quadratics[1], (0, nB)), SAME_QUADRATIC),
        (_same_quadratic(*quadratics), OWN_CONJUGATE),
    ]
    return _first(conditions)


def _first(conditions) -> np.ndarray:
    """The number of the first condition that holds, 0 if none does."""
    return np.select([np.asarray(where) for where, _ in conditions], [fault for _, fault in conditions], 0)


def _same_quadratic(first, second):
    """Whether t² − 2xt + q is one polynomial for two pairs (x, q)."""
    (x, q), (y, r) = first, second
    scale = as_float(abs(q) + abs(r))
    return is_zero(x - y, np.sqrt(scale), NEAR) & is_zero(q - r, scale, NEAR)


def _brought_to_front(h1: DualQuaternion, h2: DualQuaternion, h3: DualQuaternion) -> tuple[DualQuaternion, ...]:
    """The factorization with the quadratics of h3, h1, h2 in this order."""
    middle, k3 = bennett_flip(h2, h3)
    k1, k2 = bennett_flip(h1, middle)
    return k1, k2, k3
