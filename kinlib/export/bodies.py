"""The links of one linkage as bodies: where their bars and joints are at home, in a unit of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinlib.chain import Chain
from kinlib.collision import checked_bars
from kinlib.linkage import Linkage
from kinlib.scalar import as_float
from kinlib.typing import Array, ArrayLike

__all__ = ["Bodies"]


@dataclass(frozen=True, eq=False)
class Bodies:
    """Links and joints of a single linkage at t = ∞, scaled.

    Attributes
    ----------
    bars : array, shape (n, m, 3)
        The points of each link's bar, link 0 first.
    anchors, directions : array, shape (n, 3)
        A point of each joint's axis, in the middle between the ends of its two bars, and its direction, of length 1.
    size : float
        The largest distance of the bars' points from their mean.
    """

    bars: Array
    anchors: Array
    directions: Array
    size: float

    @classmethod
    def of(cls, linkage: Linkage, scale: float, bars: ArrayLike | None = None) -> Bodies:
        """The bodies of a linkage whose unit of length is ``scale`` of the new ones.

        Raises
        ------
        ValueError
            If the linkage is a batch or the scale is not positive.
        """
        if linkage.shape:
            raise ValueError("expected a single linkage: index the batch")
        if not scale > 0:
            raise ValueError(f"expected a positive scale, got {scale!r}")
        floats = linkage.astype(float)
        points = as_float(floats.bars() if bars is None else checked_bars(bars, floats.chain.lines)) * scale
        ends, starts = points[:, -1], np.roll(points[:, 0], -1, axis=0)  # of link n and of link n + 1, both on axis n
        directions = Chain.wrap(floats.axes).lines.directions
        size = float(np.linalg.norm(points - points.mean(axis=(0, 1)), axis=-1).max())
        return cls(points, (ends + starts) / 2, directions, size)

    def pieces(self, link: int, shortest: float) -> list[tuple[Array, Array]]:
        """The straight pieces of a link's bar that are longer than ``shortest``."""
        pairs = pairwise(self.bars[link])
        return [(a, b) for a, b in pairs if np.linalg.norm(b - a) > shortest]

    @property
    def count(self) -> int:
        """The number of links, and of joints."""
        return len(self.anchors)
