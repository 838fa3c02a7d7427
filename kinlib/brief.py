"""What a linkage has to satisfy, and the points of the plane of z that are tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np

from kinlib.linkage import Linkage
from kinlib.measures import bar_lengths, room_about, smallest_angle, travel
from kinlib.typing import Array

__all__ = ["LARGE", "MEASURES", "NAMES", "Brief", "ZGrid"]

Measure: TypeAlias = Callable[[Linkage, Array], Array]

MEASURES: Mapping[str, Measure] = {
    "shortest_bar": lambda linkage, _: bar_lengths(linkage).min(axis=-1),
    "longest_bar": lambda linkage, _: bar_lengths(linkage).max(axis=-1),
    "total_length": lambda linkage, _: bar_lengths(linkage).sum(axis=-1),
    "smallest_angle": lambda linkage, _: smallest_angle(linkage),
    "travel": lambda linkage, _: travel(linkage),
    "room": room_about,
}
"""What is cheap to measure, the cheapest first; the second argument is the middle of the poses."""

NAMES = (*MEASURES, "clearance", "relative_clearance")
"""All that can be asked for."""

LARGE = ("shortest_bar", "smallest_angle", "clearance", "relative_clearance")
"""The measures of which more is better."""


@dataclass(frozen=True)
class Brief:
    """What a linkage has to satisfy; what is not given is not asked.

    Attributes
    ----------
    shortest_bar, smallest_angle, clearance, relative_clearance : float
        At least: the length of each bar, the angle of neighbouring axes (radians, up to π/2), the least distance of
        bars that share no joint over the whole motion, and the same as a part of the sum of all lengths.
    longest_bar, total_length, travel, room : float
        At most: the length of each bar and of all together; the angle in radians that a joint is moved on the best way
        through all poses; the radius about the middle of the poses that bars sweep (in 32 positions).
    order : tuple of int, optional
        In which order the poses are passed while t grows, such as (0, 2, 1).

    Examples
    --------
    >>> Brief(longest_bar=480, room=600)
    Brief(longest_bar=480, room=600)
    """

    shortest_bar: float = 0.0
    longest_bar: float = np.inf
    total_length: float = np.inf
    smallest_angle: float = 0.0
    travel: float = np.inf
    room: float = np.inf
    clearance: float = 0.0
    relative_clearance: float = 0.0
    order: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        for name in NAMES:
            if not getattr(self, name) >= 0:
                raise ValueError(f"expected {name} to be positive, got {getattr(self, name)!r}")
        if self.order is not None and (len(self.order) != 3 or sorted(self.order) != [0, 1, 2] or self.order[0] != 0):
            raise ValueError(f"expected the order (0, 1, 2) or (0, 2, 1) of three poses, got {self.order!r}")

    def __repr__(self) -> str:
        asked = ((field.name, getattr(self, field.name)) for field in fields(self) if self.asks(field.name))
        return f"Brief({', '.join(f'{name}={value!r}' for name, value in asked)})"

    def asks(self, name: str) -> bool:
        """Whether something is asked of a measure, or of the order."""
        return bool(getattr(self, name) != getattr(type(self), name))

    def allows(self, name: str, values: Array) -> Array:
        """Which values of a measure satisfy the brief."""
        bound = getattr(self, name)
        return np.asarray(values >= bound if name in LARGE else values <= bound)


@dataclass(frozen=True)
class ZGrid:
    """An even grid of points of the plane of z, made piece by piece.

    Attributes
    ----------
    low, high : complex
        Two opposite corners.
    shape : pair of int
        The numbers of columns and rows; the points are the middles of their cells.

    Examples
    --------
    >>> grid = ZGrid(-2 - 2j, 2 + 2j, (2, 2))
    >>> len(grid), grid.points(1, 3).tolist()
    (4, [(1-1j), (-1+1j)])
    """

    low: complex
    high: complex
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        if min(self.shape) < 1:
            raise ValueError(f"expected a grid of at least one column and one row, got {self.shape}")

    def __len__(self) -> int:
        return self.shape[0] * self.shape[1]

    def points(self, start: int, stop: int) -> Array:
        """The points with numbers from start to stop, row by row."""
        row, column = np.divmod(np.arange(start, stop), self.shape[0])
        low, step = complex(self.low), complex(self.high) - complex(self.low)
        x = low.real + step.real * (column + 0.5) / self.shape[0]
        return x + 1j * (low.imag + step.imag * (row + 0.5) / self.shape[1])
