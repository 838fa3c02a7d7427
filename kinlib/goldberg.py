"""5R linkages through three poses, or through five of one dyad: of Karger's class, Goldberg's among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form, one
from kinlib.dyad import Dyad
from kinlib.errors import DegenerateError
from kinlib.factorization import factorizations
from kinlib.linkage import Linkage, verified_linkage
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.poses import gap
from kinlib.projective import null_space
from kinlib.scalar import as_float, as_scalars, divide, is_exact, is_infinite, is_zero
from kinlib.surface import Stop
from kinlib.typing import Degenerate, PoseLike, ScalarLike, Scalars, ZLike
from kinlib.z_plane import SIDES, ZPlane, z_planes

__all__ = ["goldberg_linkages", "goldberg_linkages_with_stops"]

SAME = 1e-12
"""Two parameters of a joint are one if they differ by no more than this, relative to their size."""

PLACES = tuple(f"dyad {number}, {side} joint turning twice: " for number in (1, 2) for side in ("base", "moving"))


def goldberg_linkages(
    p0: PoseLike, p1: PoseLike, p2: PoseLike, z: ZLike, *, degenerate: Degenerate = "raise"
) -> tuple[Linkage, ...]:
    """The eight 5R linkages through three poses for a complex number z: four, each found twice.

    With v = h1 − k2 from the factorizations (t − h1)(t − h2) = (t − k1)(t − k2) of the conic through the poses, the
    map q ↦ v⁻¹ q̄ v fixes the poses and carries the linkages 0, 1, 2, 3 to 6, 7, 4, 5, with base and coupler exchanged:
    the two of a pair are congruent, but their couplers move in different ways.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Any poses that have two dyads and a conic (Theorem 2); exact ones give exact linkages.
    z : complex, array of complex, or tuple (x, y)
        The first root z1 = x + √−1 y, not real, in the `ZPlane` of each dyad and joint.  It stands for h1 = x + y h,
        where h is the half-turn about the joint that turns twice, oriented as the Bennett linkage turns; a pair of
        exact numbers keeps everything exact, with h as the exact dyad has it (of length 1 only if that root can be
        taken).  So neither frames, units nor representatives matter; exchanging p1 and p2 takes x to −x.
    degenerate : {"raise", "nan"}
        What to do about poses, or values of z, for which a linkage is not determined; with ``"nan"`` only the
        linkages concerned are NaN.

    Returns
    -------
    tuple of 8 Linkages
        For each of the two dyads: with its base joint turning twice, two linkages; with its moving joint
        turning twice, two linkages.  Each was checked against the poses.

    Raises
    ------
    DegenerateError
        Naming the geometry, and the triangle in whose plane z is badly placed.

    Examples
    --------
    >>> from kinlib import eps, i, j, one
    >>> poses = one, i * (j - eps * i), (1 - i) * (2 - j + eps * i)
    >>> linkages = goldberg_linkages(*poses, (1, 2))
    >>> len(linkages), linkages[0].joints, all(linkage.closure_residual() == 0 for linkage in linkages)
    (8, (2, 1, 1, 1, 1), True)
    """
    planes = zip(z_planes(p0, p1, p2, degenerate=degenerate), PLACES, strict=True)
    return tuple(
        linkage for plane, place in planes for linkage in plane.linkages(z, degenerate=degenerate, place=place)
    )


def goldberg_linkages_with_stops(
    dyad: Dyad, stops: Sequence[tuple[ScalarLike, ScalarLike]], *, side: str = "base"
) -> tuple[Linkage, Linkage]:
    """The two 5R linkages that carry a dyad from home through four more of its poses, one of its joints turning twice.

    Let joint A turn twice, by (t − z1)(t − z2) = t² − σt + π with h_A in the place of √−1, and B once.  The cubic is in
    the pose (s_A, s_B) at t = s_B exactly if σ1 s_B + σ2 s_A s_B − π1 − π2 s_A = s_B²: four linear equations.

    Parameters
    ----------
    dyad : Dyad
        Single; an exact one with exact stops gives exact linkages.
    stops : sequence of four pairs (t1, t2)
        The parameters of its joints in the four poses: such as `dyad.parameters(pose)`, or what
        :func:`stops_on_line` and :func:`nearest_stop` find.  A linkage meets them in the order of those of the joint
        that turns once.
    side : {"base", "moving"}
        Which joint of the dyad turns twice.

    Returns
    -------
    pair of Linkages
        With the same coupler motion; their ``parameters`` belong to the five poses.

    Raises
    ------
    DegenerateError
        If the four poses do not determine a cubic, or it belongs to no 5R linkage.

    Examples
    --------
    >>> dyad = Dyad(k, j - eps * i)
    >>> linkage, _ = goldberg_linkages_with_stops(dyad, [(0, 0), (1, 2), (-2, 1), (1, -2)])
    >>> linkage.joints, linkage.parameters, linkage.closure_residual()
    ((2, 1, 1, 1, 1), (inf, 0, 2, 1, -2), 0.0)
    >>> linkage.coupler_motion(1), dyad(-2, 1)
    (-2 - i + 2 j - k - 2 εi - εj, -2 - i + 2 j - k - 2 εi - εj)
    """
    pairs = _checked_stops(dyad, stops, side)
    z = _root(_quadratic(pairs), (dyad.h1 if side == "base" else dyad.h2).primal)
    candidates, fault = [], DegenerateError("no two of the four poses have a plane of z with the home pose")
    for m, n in combinations(stops, 2):  # the plane of two of them knows nothing of the others
        try:
            plane = ZPlane.of(dyad, dyad(*m), dyad(*n), side=side)
            linkages = plane.linkages(z)
        except DegenerateError as error:
            fault = error
            continue
        off = [_off(plane, linkages[0], b, dyad(*stop)) for (_, b), stop in zip(pairs, stops, strict=True)]
        candidates.append((max(off), linkages))
        if max(off) <= MISSED / 100:
            break
    if not candidates:
        raise fault
    missed, linkages = min(candidates, key=lambda pair: pair[0])
    if missed > MISSED:
        raise DegenerateError(f"the five poses nearly fail to determine a cubic: one is missed by {missed:.2g}")
    parameters = (math.inf, *(b for _, b in pairs))
    first, second = (verified_linkage(x.factors, x.joints, x.coupler, x.home, parameters) for x in linkages)
    return first, second


MISSED = 1e-8
"""How far a linkage may be from its five poses, in half-angles and in units of their size; exact ones are met."""


def _checked_stops(dyad: Dyad, stops: Sequence[Stop], side: str) -> list[Stop]:
    """The pairs (s_A, s_B) of the joint that turns twice and of that which turns once."""
    if not isinstance(dyad, Dyad) or dyad.shape:
        raise TypeError(f"expected a single Dyad, got {dyad!r}")
    if side not in SIDES:
        raise ValueError(f"expected the side 'base' or 'moving', got {side!r}")
    numbers = as_scalars(stops)
    if numbers.shape != (4, 2):
        raise ValueError(f"expected four pairs (t1, t2) of numbers, got an array of shape {numbers.shape}")
    pairs = [(a, b) if side == "base" else (b, a) for a, b in numbers]
    once = [b for _, b in pairs]
    if any(is_infinite(b) for b in once):
        raise DegenerateError("the joint that turns once is at home in one of the poses, but t = ∞ is the home pose")
    if any(is_zero(b - c, abs(b) + abs(c), SAME) for b, c in combinations(once, 2)):
        raise DegenerateError("two of the poses have the joint that turns once in one place: it is there only once")
    return pairs


def _quadratic(pairs: Sequence[Stop]) -> tuple[Scalars, ...]:
    """The σ1, σ2, π1, π2 of the four linear equations."""
    matrix = as_scalars([_equation(a, b) for a, b in pairs])
    if not is_exact(matrix):
        matrix = matrix / np.abs(matrix).max(axis=-1, keepdims=True)
    solutions = null_space(matrix)
    if len(solutions) != 1 or is_zero(solutions[0][-1], np.max(np.abs(as_float(solutions[0]))), SAME):
        raise DegenerateError("the four linear equations have no single solution: a conic meets the poses, or no cubic")
    return tuple(divide(x, solutions[0][-1]) for x in solutions[0][:4])


def _equation(a: Scalars, b: Scalars) -> list[Scalars]:
    """The coefficients of σ1, σ2, π1, π2, 1; divided by s_A where that is infinite."""
    return [b * 0, b, b * 0, b * 0 - 1, b * 0] if is_infinite(a) else [b, a * b, b * 0 - 1, -a, -b * b]


def _root(numbers: tuple[Scalars, ...], h: DualQuaternion) -> tuple[Scalars, Scalars]:
    """The x, y of a root of t² − σt + π, with h in the place of √−1."""
    sigma1, sigma2, pi1, pi2 = numbers
    P = MotionPolynomial.from_coefficients([one, -(h * sigma2 + sigma1), h * pi2 + pi1])
    try:
        root = factorizations(P)[0][0]
    except DegenerateError:
        raise DegenerateError(
            "a root of the quadratic of the joint that turns twice is real: the five poses are met by a conic, "
            "the motion of a Bennett linkage"
        ) from None
    return root.scalar_part, divide(null_form(root, h), null_form(h, h))


def _off(plane: ZPlane, linkage: Linkage, t: Scalars, pose: DualQuaternion) -> float:
    """How far a linkage is at t from a pose, as seen by the plane."""
    back = pose.inverse()
    return float(gap(*(plane.problem.inward(q * back) for q in (linkage.coupler_motion(t), pose))))
