"""The one error of its own that kinlib raises."""

import numpy as np

__all__ = ["DegenerateError"]


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

    def __init__(self, message: str, *, dyad=None, rows: tuple[int, ...] = ()):
        super().__init__(message)
        self.dyad = dyad
        self.rows = rows


def report_faults(faults, messages, degenerate: str, **details):
    """Raise an error about the rows with a fault, or tell which rows have one.

    Parameters
    ----------
    faults : array of int, shape (...)
        0 where all is well, else the number of a message.
    messages : sequence of str
        ``messages[n - 1]`` names fault n.
    degenerate : {"raise", "nan"}
        Whether to raise.

    Returns
    -------
    numpy.ndarray of bool, shape (...)
        Where there is a fault.
    """
    faults = np.asarray(faults)
    if degenerate not in ("raise", "nan"):
        raise ValueError(f"expected degenerate to be 'raise' or 'nan', got {degenerate!r}")
    if degenerate == "nan" or not faults.any():
        return faults > 0
    if faults.ndim == 0:
        raise DegenerateError(messages[int(faults) - 1], **details)
    rows = np.flatnonzero(faults)
    kinds = [messages[n - 1] for n in np.unique(faults[faults > 0])]
    named = ", ".join(map(str, rows[:10])) + (", …" if len(rows) > 10 else "")
    raise DegenerateError(f"rows {named}: {'; '.join(kinds)}", rows=tuple(map(int, rows)), **details)
