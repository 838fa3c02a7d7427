"""Checks for tests, notebooks and assignments; they know that q and λq are one pose and say what is wrong."""

from __future__ import annotations

import numpy as np

from kinlib.displacement import translation, unit
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.projective import same_point
from kinlib.scalar import RTOL, size
from kinlib.typing import HomogeneousLike

__all__ = ["assert_closes", "assert_same_point", "assert_visits", "random_poses"]


def assert_same_point(
    actual: HomogeneousLike, expected: HomogeneousLike, *, rtol: float = RTOL, length: float = 1.0
) -> None:
    """Fail unless two dual quaternions are one point of P⁷ (in a batch: everywhere).

    Examples
    --------
    >>> assert_same_point(2 + 2 * i, -1 - i)
    """
    if not np.all(same_point(actual, expected, rtol=rtol, length=length)):
        raise AssertionError(f"expected the point [{expected}], got [{actual}]")


def assert_closes(linkage: Linkage, *, rtol: float = RTOL) -> None:
    """Fail unless the loop of a linkage is closed for all values of its parameter."""
    residual = np.max(linkage.closure_residual())
    if not residual <= rtol:
        raise AssertionError(f"the loop does not close: its product differs from a real polynomial by {residual:.2g}")


def assert_visits(linkage: Linkage, *poses: DualQuaternion, rtol: float = RTOL) -> None:
    """Fail unless the coupler of a linkage passes through the poses at the parameters that the linkage names."""
    if len(poses) != len(linkage.parameters):
        raise AssertionError(f"the linkage was made from {len(linkage.parameters)} poses, not {len(poses)}")
    for number, (t, pose) in enumerate(zip(linkage.parameters, poses, strict=True)):
        reached = linkage.coupler_motion(t)
        length = float(max(size(pose.coeffs) / size(pose.coeffs[..., :4]), 1.0))
        if not np.all(same_point(reached, pose, rtol=rtol, length=length)):
            raise AssertionError(f"the coupler misses pose {number}: at t = {t} it is at [{reached}], not [{pose}]")


def random_poses(
    count: int, *, seed: int, length: float = 1.0, angle: float | None = None, shape: tuple[int, ...] = ()
) -> list[DualQuaternion]:
    """Poses with random orientation and position, the same for the same seed.

    Parameters
    ----------
    count : int
        How many.
    seed : int
        Of NumPy's default generator.
    length : float
        The standard deviation of the coordinates of the position.
    angle : float, optional
        The size of the turns from the identity, in radians; by default all orientations are equally likely.
    shape : tuple of int
        The shape of the batch of each pose.

    Returns
    -------
    list of DualQuaternion

    Examples
    --------
    >>> [bool(abs(pose.norm().coeffs[0] - 1) < 1e-12) for pose in random_poses(2, seed=1)]
    [True, True]
    """
    random = np.random.default_rng(seed)
    poses = []
    for _ in range(count):
        primal = random.normal(size=(*shape, 4))
        if angle is not None:
            primal = np.concatenate([np.ones((*shape, 1)), primal[..., 1:] * angle / 2], axis=-1)
        turn = unit(DualQuaternion(np.concatenate([primal, np.zeros((*shape, 4))], axis=-1)))
        poses.append(translation(length * random.normal(size=(*shape, 3))) * turn)
    return poses
