"""Exact values as floats: a drawing needs no more."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinlib.displacement import as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.dyad import Dyad
from kinlib.linkage import Linkage
from kinlib.poses import as_poses
from kinlib.scalar import as_float
from kinlib.typing import PoseLike

__all__ = ["floats", "one_dyad", "one_linkage", "pose_matrices"]


def floats(q: DualQuaternion) -> DualQuaternion:
    """The same dual quaternions with floats for coefficients."""
    return DualQuaternion(as_float(q.coeffs))


def one_linkage(linkage: Linkage, name: str = "the linkage") -> Linkage:
    """The same linkage with floats for its numbers, if it is a single one that exists.

    Parameters
    ----------
    linkage : Linkage
    name : str
        What an error calls it.

    Raises
    ------
    ValueError
        If it is a batch of linkages, or one that a degenerate row of a batch has left as NaN.
    """
    _check_single(name, linkage.shape)
    factors = [floats(f) for f in linkage.factors]
    lost = [n for n, f in enumerate((*factors, floats(linkage.home))) if not np.all(np.isfinite(f.coeffs))]
    if lost:
        raise ValueError(
            f"{name} is not a linkage: {_lost(linkage, lost)} not finite, as in a degenerate row of a batch"
        )
    parameters = tuple(as_float(t) for t in linkage.parameters)
    return Linkage(factors, linkage.joints, linkage.coupler, floats(linkage.home), parameters)


def one_dyad(dyad: Dyad) -> Dyad:
    """The same dyad with floats for its numbers, if it is a single one that exists; else a ``ValueError``."""
    parts = [floats(x) for x in (dyad.h1, dyad.h2, dyad.home)]
    _check_single("the dyad", np.broadcast_shapes(*(x.shape for x in parts)))
    if not all(np.all(np.isfinite(x.coeffs)) for x in parts):
        raise ValueError("the dyad is not a dyad: its numbers are not finite, as in a degenerate row of a batch")
    return Dyad(*parts)


def _check_single(name: str, shape: tuple[int, ...]) -> None:
    if shape:
        raise ValueError(f"{name} is a batch of shape {shape}, expected a single one: pick one of its entries")


def _lost(linkage: Linkage, lost: Sequence[int]) -> str:
    """What is not finite, when the factors of these numbers are not; the number after the last is the home pose."""
    if len(lost) == len(linkage.factors) + 1:
        return "all its numbers are"
    if lost[0] == len(linkage.factors):
        return "its home pose is"
    joint = int(np.searchsorted(np.cumsum(linkage.joints), lost[0], side="right"))
    return f"the axis of joint {joint + 1} is"


def pose_matrices(poses: Sequence[PoseLike]) -> np.ndarray:
    """Poses of any kind as one array.

    Parameters
    ----------
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``

    Returns
    -------
    numpy.ndarray, shape (number of poses, 4, 4)

    Examples
    --------
    >>> pose_matrices([one, i])[:, 1, 1].tolist()
    [1.0, -1.0]
    """
    matrices = [as_float(as_matrix(pose)) for pose in as_poses(*poses)] if len(poses) else []
    return np.array(matrices).reshape(-1, 4, 4)
