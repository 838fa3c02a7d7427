"""To and from the coefficients of rational-linkages, which acts by the other sign of ε."""

from __future__ import annotations

from collections.abc import Sequence

from kinlib.dual_quaternion import DualQuaternion, one
from kinlib.linkage import Linkage
from kinlib.scalar import as_scalars
from kinlib.typing import Array, ArrayLike, PoseLike

__all__ = ["as_rational_linkages", "from_rational_linkages"]


def as_rational_linkages(linkage: Linkage) -> tuple[list[Array], list[Array]]:
    """The factors of both chains from the base to the coupler, as rational-linkages has them.

    Its ``MotionFactorization`` takes one chain, as ``DualQuaternion`` of these coefficients: the f of factors t − f.
    Its joint angles have the other sign than ours.

    Returns
    -------
    pair of lists of arrays, each of shape (..., 8)

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> loop = bennett_linkage(*gallery.THREE_POSES)
    >>> first, second = as_rational_linkages(loop)
    >>> len(first), len(second), DualQuaternion(first[1]) == loop.factors[1].eps_conjugate()
    (2, 2, True)
    """
    count = sum(linkage.joints[: linkage.coupler])
    first, second = linkage.factors[:count], [f.conjugate() for f in reversed(linkage.factors[count:])]
    return [f.eps_conjugate().coeffs for f in first], [f.eps_conjugate().coeffs for f in second]


def from_rational_linkages(
    first: Sequence[ArrayLike], second: Sequence[ArrayLike], *, home: PoseLike = one, rtol: float = 1e-7
) -> Linkage:
    """The linkage of two chains of rational-linkages: the ``dq.array()`` of the factors of both factorizations.

    Parameters
    ----------
    first, second : sequences of array_like, shape (..., 8)
        From the base to the coupler, with its sign of ε.
    home : pose
        The pose of the coupler's frame at t = ∞, as kinlib has it.
    rtol : float
        How far floats may be from closed.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> loop = bennett_linkage(*gallery.THREE_POSES)
    >>> from_rational_linkages(*as_rational_linkages(loop)).factors == loop.factors
    True
    """
    chains = ([DualQuaternion(as_scalars(f)).eps_conjugate() for f in chain] for chain in (first, second))
    return Linkage.from_chains(*chains, home=home, rtol=rtol)
