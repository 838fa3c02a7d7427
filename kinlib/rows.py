"""Rows of a batch of dual quaternions: some left out, picked, chosen or replaced."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, wrap
from kinlib.scalar import as_float
from kinlib.typing import Array

__all__ = ["broadcast", "chosen", "masked", "picked", "replaced"]


def broadcast(q: DualQuaternion, shape: tuple[int, ...]) -> DualQuaternion:
    """The same for every entry of a batch."""
    return q if q.shape == shape else DualQuaternion(np.broadcast_to(q.coeffs, (*shape, 8)))


def masked(q: DualQuaternion, rows: Array) -> DualQuaternion:
    """NaN in place of the given rows."""
    return DualQuaternion(np.where(np.asarray(rows)[..., None], np.nan, as_float(q.coeffs))) if np.any(rows) else q


def picked(q: DualQuaternion, rows: Array) -> DualQuaternion:
    """The given rows of what may be the same for all of them."""
    return broadcast(q, rows.shape)[rows]


def chosen(rows: Array, x: DualQuaternion, y: DualQuaternion) -> DualQuaternion:
    """x in the given rows, y in the others; on axes in front there may be several of both."""
    return wrap(np.where(rows, x.components, y.components)) if rows.any() else y


def replaced(q: DualQuaternion, rows: Array | tuple[Array | slice, ...], new: DualQuaternion) -> DualQuaternion:
    """The same dual quaternions but for some rows, given by a mask or by their indices."""
    where: Any = rows if isinstance(rows, tuple) else (rows,)
    components = q.components.copy()
    components[(slice(None), *where)] = new.components
    return wrap(components)
