"""Submissions made from the solved notebooks."""

from pathlib import Path

import nbformat

from grader import masters


def handed_in(assignment: str, folder: Path, changes: dict | None) -> Path:
    """A student's copy with the solutions filled in, but for some changes.

    A change is a new text for a cell, or a pair of texts: the first, which must occur once, is replaced by the second.
    Without changes (None) nothing is filled in.
    """
    notebook = masters.read(masters.release(assignment))
    solved = masters.answers(masters.read(masters.source(assignment)))
    if changes is not None:
        assert set(changes) <= set(solved), f"no such cells: {set(changes) - set(solved)}"
        for cell in notebook.cells:
            if (name := masters.name_of(cell)) in solved:
                cell.source = changed(solved[name], changes.get(name))
    path = folder / f"{assignment}.ipynb"
    nbformat.write(notebook, path)
    return path


def changed(text: str, change: str | tuple[str, str] | None) -> str:
    if change is None or isinstance(change, str):
        return change if change is not None else text
    assert text.count(change[0]) == 1, f"{change[0]!r} occurs {text.count(change[0])} times"
    return text.replace(*change)
