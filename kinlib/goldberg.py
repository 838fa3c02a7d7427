"""5R linkages through three poses, two for each of the four planes of z: of Karger's class, Goldberg's among them."""

from __future__ import annotations

from kinlib.linkage import Linkage
from kinlib.typing import Degenerate, PoseLike, ZLike
from kinlib.z_plane import z_planes

__all__ = ["goldberg_linkages"]

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
