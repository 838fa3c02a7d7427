"""Whether a loop of linear factors closes: their product must be a real polynomial, each factor a rotation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kinlib.chain import Chain, first_row, plain
from kinlib.dual_quaternion import DualQuaternion, null_form, study_form
from kinlib.loop import Loop
from kinlib.polishing import product_of
from kinlib.rows import broadcast
from kinlib.scalar import is_exact, is_zero, size
from kinlib.typing import Array

__all__ = ["CLOSED", "check_closure", "check_turns", "closure_residual"]

CLOSED = 1e-7
"""How far floats may be from closed: next to degenerate places half of their digits are gone."""

_ROUNDED = " (rtol= accepts rounded numbers)"


def closure_residual(loop: Loop, coupler: int) -> Any:
    """How far the product of all factors is from a real polynomial, relative to its size; 0 if exact.

    Parameters
    ----------
    loop : Loop
    coupler : int
        The link where two chains meet: if their products are equal, the loop is closed.
    """
    if loop.is_exact and _closes_exactly(loop, coupler):
        return plain(np.zeros(loop.shape))
    product = product_of(loop.centred.factors)
    residual = _beside_real(product, _bound(loop.centred.factors))
    return plain(np.maximum(residual, np.finfo(float).tiny) if loop.is_exact else residual)


def check_closure(loop: Loop, coupler: int, rtol: float) -> None:
    """Refuse a loop that is not closed."""
    if loop.is_exact and _closes_exactly(loop, coupler):
        return
    if loop.is_exact or not np.all(_difference_of_chains(loop, coupler) <= rtol):
        residual = np.asarray(closure_residual(loop, coupler))
        wrong = residual > (0 if loop.is_exact else rtol + loop.centred.noise)
        if wrong.any():
            row, words = first_row(wrong)
            raise ValueError(
                f"{words}the loop does not close: around it the product of the factors differs from a real "
                f"polynomial by {residual[row]:.3g} of its size; the two chains to the coupler must have equal "
                "products" + _ROUNDED * (not loop.is_exact)
            )


def _closes_exactly(loop: Loop, coupler: int) -> bool:
    first, second = _halves(loop, coupler, loop.factors)
    if first and all(np.all(c == d) for c, d in zip(product_of(first), product_of(second), strict=True)):
        return True
    product = DualQuaternion.stack(product_of([broadcast(f, loop.shape) for f in loop.factors]), axis=-1)
    return bool(np.all(is_zero(product.components[1:])))


def _halves(
    loop: Loop, coupler: int, factors: Sequence[DualQuaternion]
) -> tuple[Sequence[DualQuaternion], Sequence[DualQuaternion]]:
    """The two chains to the coupler if they have equally many factors, else nothing."""
    count = sum(loop.joints[:coupler])
    first, second = factors[:count], [f.conjugate() for f in reversed(factors[count:])]
    return (first, second) if len(first) == len(second) else ((), ())


def _difference_of_chains(loop: Loop, coupler: int) -> Any:
    """How far the two chains to the coupler are from having equal products, if they may have."""
    first, second = _halves(loop, coupler, loop.centred.factors)
    if not first:
        return math.inf
    difference = [c - d for c, d in zip(product_of(first), product_of(second), strict=True)]
    return _beside_real(difference, np.fmax(_bound(first), _bound(second)), all_of_it=True)


def check_turns(loop: Loop, rtol: float) -> None:
    """Refuse factors that are no rotations, and factors of one joint that have different axes."""
    for number, f in enumerate(loop.factors):
        pitch = np.asarray(_pitch(f, loop.chain))
        wrong = pitch > (0 if is_exact(f.components) else rtol)
        if wrong.any():
            row, words = first_row(wrong)
            raise ValueError(
                f"{words}factor number {number} is no rotation x + y h about a line: it is off by {pitch[row]:.3g} "
                "of its size" + _ROUNDED * (not is_exact(f.components))
            )
    for n in range(loop.joint_count):
        for f in loop.joint_factors(n)[1:]:
            if not np.all(_turns_about(loop.axes[..., n], f, loop.chain, rtol)):
                raise ValueError(
                    f"expected the factors of joint {n + 1} to have one axis, but they have different ones: "
                    f"joints={loop.joints} says how many factors in a row share an axis"
                )


def _pitch(f: DualQuaternion, chain: Chain) -> Array:
    """How far f is from x + y h with a half-turn h, in parts of its size: 0 only if it is exactly that."""
    d0, product = f.components[4], study_form(f, f)
    if is_exact(f.components) and np.all(is_zero(d0) & is_zero(product)):
        return np.zeros(f.shape)
    f = f.astype(float)
    turning, length = size(f.components[:4], 0), size(f.components[5:], 0)
    length = length + turning * (chain.lines.length + chain.lines.noise)
    return np.maximum(np.abs(f.components[4]), np.abs(study_form(f, f)) / turning) / length


def _turns_about(axis: DualQuaternion, f: DualQuaternion, chain: Chain, rtol: float) -> Any:
    """Whether a rotation f has a given axis; NaN is let through."""
    f = f - f.scalar_part
    commutator = f * axis - axis * f
    if is_exact(commutator.components):
        return np.all(is_zero(commutator.components))
    turning = size(axis.components[1:4], 0) * size(f.components[1:4], 0)
    length = size(axis.components[5:], 0) + chain.lines.length
    turned = is_zero(size(commutator.components[:4], 0), turning, rtol)
    shifted = is_zero(size(commutator.components[4:], 0), turning * length, rtol)
    return (turned & shifted) | np.isnan(turning)


def _bound(factors: Sequence[DualQuaternion]) -> Array:
    """The coefficients of Π (t + |f|), highest power on the first axis."""
    bound = [np.ones(factors[0].shape)]
    for f in factors:
        r = np.sqrt(null_form(f, f))
        bound = [high + low * r for high, low in zip([*bound, 0.0], [0.0, *bound], strict=True)]
    return np.stack(bound)


def _beside_real(coefficients: Sequence[DualQuaternion], bound: Array, *, all_of_it: bool = False) -> Array:
    """The largest coefficient beside the real ones (or of all), each relative to its bound; shape (...).

    The leading coefficient, which is 1 or 0, is left out.
    """
    components = np.stack([c.components for c in coefficients[1:]])[:, 0 if all_of_it else 1 :]
    return (np.abs(components).max(axis=1) / bound[1:]).max(axis=0)
