"""Rows of a batch of dual quaternions: some left out, picked, chosen or replaced, or a block of them at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, wrap
from kinlib.scalar import as_float
from kinlib.typing import Array

__all__ = ["BLOCK", "broadcast", "chosen", "flat", "hold_memory", "joined", "masked", "picked", "replaced"]


BLOCK = 2048
"""So many rows are solved at a time: their numbers stay in the cache."""


def hold_memory() -> None:
    """Ask for 16 MB and give them back, so that temporary arrays of a batch use the same memory again and again.

    The C library keeps as much memory for the program as it was last given back in one piece; before that it returns
    the memory of each array to the system, which then has to clear it for the next one.
    """
    np.empty(2**21)


def flat(x: Any, shape: tuple[int, ...]) -> Any:
    """Dual quaternions, or numbers, as rows one after the other, after broadcasting them."""
    if isinstance(x, DualQuaternion):
        return wrap(broadcast(x, shape).components.reshape(8, -1))
    return np.broadcast_to(x, shape).reshape(-1)


def joined(parts: Sequence[Any], shape: tuple[int, ...]) -> Any:
    """The blocks of dual quaternions, or of numbers, as one batch; the rows are on the last axis."""
    if isinstance(parts[0], DualQuaternion):
        return wrap(joined([q.components for q in parts], shape))
    return np.concatenate(parts, axis=-1).reshape(*parts[0].shape[:-1], *shape)


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
