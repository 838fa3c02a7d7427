"""Bennett linkages (4R) through three poses: the two 2R dyads of Theorem 2, joined at both ends."""

from __future__ import annotations

import math

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, one
from kinlib.dyad import primal_coordinates
from kinlib.errors import report_faults
from kinlib.interpolation import conic, is_tangent
from kinlib.linkage import Linkage
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.poses import as_pose
from kinlib.scalar import divide
from kinlib.three_poses import FAULTS, TANGENT, masked, pairs_through, relative

__all__ = ["bennett_linkage"]


def bennett_linkage(p0, p1, p2, *, degenerate: str = "raise") -> Linkage:
    """The Bennett linkage whose coupler visits three poses, at t = ∞, 0 and 1.

    Both dyads of Theorem 2 contain the conic through the poses; each gives one factorization of it.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Any poses; exact ones give an exact linkage over the number field that it needs.
    degenerate : {"raise", "nan"}
        What to do about rows of a batch that have no Bennett linkage.

    Raises
    ------
    DegenerateError
        Naming the geometry, as :func:`~kinlib.dyads_through_poses`; also if the plane of the poses is tangent.

    Examples
    --------
    >>> linkage = bennett_linkage(one, i * (j - eps * i), (1 - i) * (2 - j + eps * i))
    >>> linkage.closure_residual(), linkage.mobility()
    (0.0, 1)
    """
    poses = [as_pose(p) for p in (p0, p1, p2)]
    pairs = pairs_through(poses, None, degenerate)
    faulty = report_faults(is_tangent(*poses) * TANGENT, FAULTS, degenerate)
    with np.errstate(invalid="ignore", divide="ignore"):
        q1, q2 = relative(*poses)
        C = conic(one, q1, masked(q2, faulty))
        chains = [linear_factors(h1, h2, C) for h1, h2 in pairs]
    return Linkage.from_chains(*chains, home=poses[0], parameters=(math.inf, 0, 1))


def linear_factors(h1: DualQuaternion, h2: DualQuaternion, C: MotionPolynomial) -> tuple:
    """The k1, k2 about the axes of h1, h2 with C = (t − k1)(t − k2), for a monic conic in their 2R space.

    With k = x + y h for each axis the coefficients of C in the basis 1, h1, h2, h1h2 are those of
    t² − (x1 + x2 + y1 h1 + y2 h2) t + (x1 + y1 h1)(x2 + y2 h2).
    """
    linear, constant = (primal_coordinates(c, h1, h2) for c in C.coefficients[1:])
    y1, y2 = -linear[1], -linear[2]
    x1, x2 = divide(constant[2], y2), divide(constant[1], y1)
    return h1 * y1 + x1, h2 * y2 + x2
