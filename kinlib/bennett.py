"""Bennett linkages (4R) through three poses: the two 2R dyads of Theorem 2, joined at both ends."""

from __future__ import annotations

import math

from kinlib.linkage import Linkage, verified_loop
from kinlib.poses import seen_together
from kinlib.three_poses import two_dyads
from kinlib.typing import Degenerate, PoseLike

__all__ = ["bennett_linkage"]


def bennett_linkage(p0: PoseLike, p1: PoseLike, p2: PoseLike, *, degenerate: Degenerate = "raise") -> Linkage:
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
    problem = seen_together(p0, p1, p2, degenerate=degenerate)
    both = two_dyads(problem, degenerate)
    first, second = ([problem.outward(k) for k in both.factors(n)] for n in range(2))
    return verified_loop(first, second, home=problem.home, parameters=(math.inf, 0, 1))
