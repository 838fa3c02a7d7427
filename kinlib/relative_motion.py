"""The motion of one link of a loop as seen from another, without common real factors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import accumulate

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.factorization import divide_by_quadratic, quadratic_of
from kinlib.loop import Loop, undefined_rows, whole
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import product_of
from kinlib.rows import broadcast
from kinlib.scalar import is_zero, size

__all__ = ["relative_motion"]


def relative_motion(loop: Loop, a: int, b: int) -> MotionPolynomial:
    """The motion of link b as seen from link a, with common real factors taken out.

    Parameters
    ----------
    a, b : int
        Numbers of links, counted on round the loop.
    """
    count = loop.joint_count
    ahead = whole(b - a, "links as whole numbers") % count
    back = -ahead % count
    if ahead == 0:
        return MotionPolynomial.from_coefficients([loop.identity])
    if ahead <= back:
        return _reduced_product(loop, _between(loop, a, ahead))
    return _reduced_product(loop, _between(loop, b, back)).conjugate()


def _between(loop: Loop, link: int, steps: int) -> list[int]:
    """The numbers of the factors from a link on, over so many joints."""
    starts = [0, *accumulate(loop.joints)]
    joints = [(link + n) % loop.joint_count for n in range(steps)]
    return [n for joint in joints for n in range(starts[joint], starts[joint + 1])]


def _reduced_product(loop: Loop, numbers: Sequence[int]) -> MotionPolynomial:
    """The product of some factors, divided by each quadratic (t − f)(t − f̄) that divides it."""
    factors = [broadcast(loop.factors[n], loop.shape) for n in numbers]
    judged = factors if loop.is_exact else [loop.centred.factors[n] for n in numbers]
    coefficients, seen = product_of(factors), product_of(judged)
    for f, g in zip(factors, judged, strict=True):
        if len(seen) < 3:
            break
        quotient, remainder = divide_by_quadratic(seen, quadratic_of(g))
        if _negligible(remainder, seen):
            seen, coefficients = quotient, divide_by_quadratic(coefficients, quadratic_of(f))[0]
    return MotionPolynomial.from_coefficients(coefficients)


def _negligible(remainder: Sequence[DualQuaternion], coefficients: Sequence[DualQuaternion]) -> bool:
    """Whether a remainder vanishes, in every row of a batch that is not NaN."""
    fine = undefined = undefined_rows(coefficients[-1])
    for half in (slice(0, 4), slice(4, 8)):
        scale = reduce(np.maximum, (size(c.components[half], 0) for c in coefficients))
        vanish = [is_zero(r.components[half], scale, rtol=1e-7) for r in remainder]
        fine = (
            fine | np.all(vanish, axis=(0, 1)) if half.start == 0 else fine & (undefined | np.all(vanish, axis=(0, 1)))
        )
    return bool(np.all(fine) and not np.all(undefined))
