"""The one error of its own that kinlib raises, and the faults that it names."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["DegenerateError", "NotFoundError"]


class DegenerateError(ValueError):
    """The input is well formed, but its geometry leaves the answer undetermined.

    Attributes
    ----------
    dyad : Dyad or None
        The only 2R dyad through three poses, where there is one instead of two.
    rows : tuple of int
        The rows of a batch that are concerned; empty for a single problem.

    Examples
    --------
    >>> issubclass(DegenerateError, ValueError)
    True
    """

    def __init__(self, message: str, *, dyad: Any = None, rows: tuple[int, ...] = ()):
        super().__init__(message)
        self.dyad = dyad
        self.rows = rows


class NotFoundError(ValueError):
    """A search found nothing, which does not mean that there is nothing; the message says what was tried.

    Examples
    --------
    >>> issubclass(NotFoundError, ValueError)
    True
    """


class Fault(IntEnum):
    """What can be wrong with a row: a number from 1, so that arrays hold it (0 is no fault), and what it means."""

    message: str

    def __new__(cls, number: int, message: str = "") -> Fault:
        self = int.__new__(cls, number)
        self._value_ = number
        self.message = message
        return self


def first_fault(*conditions: tuple[Any, Fault]) -> np.ndarray:
    """The number of the first fault whose condition holds, row by row; 0 where none does."""
    where = np.broadcast_arrays(*[np.asarray(condition, dtype=bool) for condition, _ in conditions])
    return np.select(where, [int(fault) for _, fault in conditions], 0)


def check_degenerate(degenerate: str) -> None:
    """Refuse any other word for what to do about degenerate rows."""
    if degenerate not in ("raise", "nan"):
        raise ValueError(f"expected degenerate to be 'raise' or 'nan', got {degenerate!r}")


def report_faults(
    faults: ArrayLike,
    kind: type[Fault],
    degenerate: str,
    *,
    place: str = "",
    how_near: ArrayLike | None = None,
    dyad: Any = None,
) -> np.ndarray:
    """Raise an error about the rows with a fault, or tell which rows have one.

    Parameters
    ----------
    faults : array of int, shape (...)
        0 where all is well, else a fault.
    kind : subclass of Fault
        What the numbers mean.
    degenerate : {"raise", "nan"}
        Whether to raise.
    place : str
        Where it is, in front of the message.
    how_near : array of float, optional
        How far each row is from its fault, relative to the size of the problem; said behind the message.
    dyad : Dyad, optional
        The only one that there is; attached to the error.

    Returns
    -------
    numpy.ndarray of bool, shape (...)
        Where there is a fault.
    """
    faults = np.asarray(faults)
    check_degenerate(degenerate)
    if degenerate == "nan" or not faults.any():
        return faults > 0
    rows = rows_where(faults)
    kinds = [kind(n).message for n in np.unique(faults[faults > 0])]
    near = "" if how_near is None else _nearness(np.broadcast_to(how_near, faults.shape)[faults > 0])
    raise DegenerateError(f"{named_rows(rows)}{place}{'; '.join(kinds)}{near}", rows=rows, dyad=dyad)


def _nearness(values: np.ndarray) -> str:
    finite = values[np.isfinite(values)]
    return f" (up to {finite.max():.1e} of its size)" if finite.size else ""


def named_rows(rows: Sequence[int] | np.ndarray) -> str:
    """The rows that an error is about, in front of what it says; nothing for a single problem."""
    if not len(rows):
        return ""
    named = ", ".join(map(str, rows[:10])) + (", …" if len(rows) > 10 else "")
    return f"row{'s' if len(rows) > 1 else ''} {named}: "


def rows_where(condition: Any) -> tuple[int, ...]:
    """The rows of a batch where a condition holds; none for a single problem."""
    return tuple(map(int, np.flatnonzero(condition))) if np.ndim(condition) else ()
