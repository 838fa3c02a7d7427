"""Where the bars of a loop of linear factors meet, and how far they stay: exact for exact loops, in batches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from kinlib.chain import plain
from kinlib.collision import (
    CollisionFault,
    Collisions,
    checked_bars,
    clearances,
    collisions_in_floats,
    listed_collisions,
)
from kinlib.errors import check_degenerate, report_faults
from kinlib.exact_collision import exact_bars, exact_collisions
from kinlib.loop import Loop
from kinlib.moving_bars import MovingBars
from kinlib.rows import broadcast
from kinlib.scalar import as_float, as_scalars, is_exact
from kinlib.typing import Array, ArrayLike, Degenerate

__all__ = ["clearance_of", "collisions_of"]


def collisions_of(
    loop: Loop, usual: Callable[[], Array], bars: ArrayLike | None, rtol: float, degenerate: Degenerate
) -> Collisions:
    """Where bars of links that share no joint meet; ``usual`` gives those that are taken if none are given."""
    check_degenerate(degenerate)
    if loop.is_exact and (bars is None or is_exact(as_scalars(bars))):
        return _exact_collisions(loop, usual, bars, degenerate)
    moving = _moving_bars(loop, usual, bars)
    return collisions_in_floats(moving[0], loop.joints, moving[1], rtol=rtol, degenerate=degenerate)


def clearance_of(loop: Loop, usual: Callable[[], Array], bars: ArrayLike | None, rtol: float) -> Any:
    """The least distance of such bars, over the whole motion."""
    if not rtol > 0:
        raise ValueError(f"expected a positive rtol, got {rtol!r}")
    moving, shape = _moving_bars(loop, usual, bars)
    return plain(clearances(moving, loop.joints, rtol).reshape(shape))


def _moving_bars(loop: Loop, usual: Callable[[], Array], bars: ArrayLike | None) -> tuple[MovingBars, tuple[int, ...]]:
    """The bars in motion, and the shape of their batch."""
    points = as_float(usual() if bars is None else checked_bars(bars, loop.chain.lines))
    shape = np.broadcast_shapes(loop.shape, points.shape[:-3])
    points = np.broadcast_to(points, (*shape, *points.shape[-3:]))
    return MovingBars.of([broadcast(f, shape) for f in loop.factors], loop.joints, points), shape


def _exact_collisions(
    loop: Loop, usual: Callable[[], Array], bars: ArrayLike | None, degenerate: Degenerate
) -> Collisions:
    given = None if bars is None else checked_bars(bars, loop.chain.lines)
    shape = np.broadcast_shapes(loop.shape, () if given is None else given.shape[:-3])
    hits, faults = [], np.zeros(shape, dtype=int)
    for index in np.ndindex(shape):
        factors = [broadcast(f, shape)[index] for f in loop.factors]
        if given is None:
            points = exact_bars(loop.axes[index], usual()[index])
        else:
            points = np.broadcast_to(given, (*shape, *given.shape[-3:]))[index]
        found = exact_collisions(factors, loop.joints, points)
        faults[index] = 0 if found is not None else CollisionFault.IN_A_PLANE
        hits.append(found or [])
    bad = report_faults(faults, CollisionFault, degenerate)
    return listed_collisions(hits, shape, bad.reshape(-1))
