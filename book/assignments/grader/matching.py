"""Which cell of a submission is which cell of the assignment, even where it has lost its name.

Editors drop what nbgrader knows of a cell when it is typed again, split or pasted; some drop it for all cells.  A cell
is then known by its id, by a text that is still the assignment's, by the names that it defines, or by its place.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import pairwise

from nbformat import NotebookNode

DEFINED = re.compile(r"^(?:def|class)\s+(\w+)|^(\w+(?:\s*,\s*\w+)*)\s*=(?!=)", re.MULTILINE)
Key = str | int
"""A cell of the assignment: its name, or its number if it has none."""


def keys(notebook: NotebookNode, name_of: Callable) -> list[Key]:
    """The names of the cells of an assignment, numbers for those without."""
    return [name_of(cell) or number for number, cell in enumerate(notebook.cells)]


def defined(text: str) -> set[str]:
    """The names that a cell gives to something.

    Examples
    --------
    >>> sorted(defined("def norm(q):\\n    a = 1\\nx, y = 1, 2\\nx == y"))
    ['norm', 'x', 'y']
    """
    return {name for pair in DEFINED.findall(text) for part in pair for name in re.findall(r"\w+", part)}


def squeezed(text: str) -> str:
    """A text without its white space."""
    return re.sub(r"\s+", "", text)


def matched(blank: NotebookNode, solved: NotebookNode, given: NotebookNode, name_of: Callable) -> list[Key | None]:
    """For each cell of a submission, which cell of the assignment it is, if any.

    Parameters
    ----------
    blank, solved : NotebookNode
        The student's copy as it was handed out, and the solved notebook: the same cells.
    given : NotebookNode
        What was handed in.
    name_of : function
        The name of a cell, or None.
    """
    known = keys(blank, name_of)
    found: list[Key | None] = [None] * len(given.cells)

    def take(number: int, key: Key) -> None:
        if found[number] is None and key not in found:
            found[number] = key

    for number, cell in enumerate(given.cells):
        if name_of(cell) in known:
            take(number, name_of(cell))
    for same in (same_id, same_text):
        for number, cell in nameless(given, name_of):
            for key, other in zip(known, blank.cells, strict=True):
                if cell.cell_type == other.cell_type and same(cell, other):
                    take(number, key)
    for key, stub, solution in zip(known, blank.cells, solved.cells, strict=True):
        wanted = defined(solution.source) if is_answer(stub) and stub.cell_type == "code" else set()
        for number, cell in reversed(list(nameless(given, name_of))):  # of several tries the last one counts
            if cell.cell_type == "code" and found[number] is None and wanted & defined(cell.source):
                take(number, key)
    by_place(known, blank, given, found, name_of)
    return found


def nameless(notebook: NotebookNode, name_of: Callable) -> Iterator[tuple[int, NotebookNode]]:
    """The cells of a submission that don't say what they are, with their numbers."""
    return ((n, cell) for n, cell in enumerate(notebook.cells) if not name_of(cell) and cell.source.strip())


def is_answer(cell: NotebookNode) -> bool:
    about = cell.metadata.get("nbgrader", {})
    return isinstance(about, dict) and bool(about.get("solution"))


def same_id(cell: NotebookNode, other: NotebookNode) -> bool:
    return bool(cell.get("id")) and cell.get("id") == other.get("id")


def same_text(cell: NotebookNode, other: NotebookNode) -> bool:
    return squeezed(cell.source) == squeezed(other.source)


def by_place(known: list, blank: NotebookNode, given: NotebookNode, found: list, name_of: Callable) -> None:
    """Answers that are still missing are the cells left over between the same neighbours, if the count is clear."""
    for first, last in gaps(known, found):
        start, end = position(found, known, first, -1), position(found, known, last, len(given.cells))
        for kind in ("code", "markdown"):
            missing = [
                known[n]
                for n in range(first + 1, last)
                if blank.cells[n].cell_type == kind and is_answer(blank.cells[n])
            ]
            left = [
                n
                for n, cell in nameless(given, name_of)
                if start < n < end and found[n] is None and cell.cell_type == kind
            ]
            if len(missing) == 1 and left:
                left = left[-1:] if kind == "code" else [max(left, key=lambda n: len(given.cells[n].source))]
            if len(missing) == len(left):
                for number, key in zip(left, missing, strict=True):
                    found[number] = key


def gaps(known: list, found: list) -> list[tuple[int, int]]:
    """Pairs of neighbouring cells of the assignment that were found, with some between them that were not."""
    there = [-1, *(n for n, key in enumerate(known) if key in found), len(known)]
    return [(a, b) for a, b in pairwise(there) if b - a > 1]


def position(found: list, known: list, number: int, outside: int) -> int:
    """Where in the submission a cell of the assignment stands."""
    return found.index(known[number]) if 0 <= number < len(known) else outside
