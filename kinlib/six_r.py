"""Overconstrained 6R linkages through four poses (Hegedüs, Schicho & Schröcker 2014)."""

from __future__ import annotations

import math
from itertools import combinations, permutations

from kinlib.factorization import check_factors, factor_in_orders, quadratic_factors
from kinlib.interpolation import cubics_through, fourth_parameters
from kinlib.linkage import Linkage
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.poses import as_pose

__all__ = ["ADMISSIBLE_PAIRS", "six_r_linkages"]

ORDERS = tuple(permutations(range(3)))

ADMISSIBLE_PAIRS = tuple(
    (m, n) for m, n in combinations(range(6), 2) if ORDERS[m][0] != ORDERS[n][0] and ORDERS[m][2] != ORDERS[n][2]
)
"""The nine pairs of factorizations, by number, with different first and different last quadratic factors."""


def six_r_linkages(p0, p1, p2, p3, free=0) -> tuple[Linkage, ...]:
    """The 6R linkages whose couplers visit four poses: nine for each real family of cubics.

    Parameters
    ----------
    p0, p1, p2, p3 : DualQuaternion, 4×4 matrix or RigidTransform
        Four poses in general position.
    free : scalar
        The position in the family, see :func:`~kinlib.cubics_through`.

    Returns
    -------
    tuple of Linkage
        Nine for the first family, then nine for the second if there are two.

    Raises
    ------
    DegenerateError
        If no family is real, or the poses are not in general position.
    ValueError
        If exact poses need a number field that is too large to be of use: convert them to floats.

    Examples
    --------
    >>> from kinlib.gallery import FOUR_POSES
    >>> linkages = six_r_linkages(*(pose.astype(float) for pose in FOUR_POSES))
    >>> len(linkages), linkages[0].mobility()
    (18, 1)
    """
    poses = [as_pose(p) for p in (p0, p1, p2, p3)]
    cubics = cubics_through(*poses, free)
    linkages = []
    for C, t3 in zip(cubics, fourth_parameters(*poses), strict=True):
        linkages += _linkages_of(C, (math.inf, 0, 1, t3))
    return tuple(linkages)


def _linkages_of(C: MotionPolynomial, parameters: tuple) -> list[Linkage]:
    home = C.leading
    monic = C * home.inverse()
    factors = factor_in_orders(monic, quadratic_factors(monic.norm_polynomial()), ORDERS)
    check_factors(monic, factors)
    chains = [tuple(h[..., n] for h in factors) for n in range(len(ORDERS))]
    return [Linkage.from_chains(chains[m], chains[n], home=home, parameters=parameters) for m, n in ADMISSIBLE_PAIRS]
