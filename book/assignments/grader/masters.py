"""The solved notebooks of the assignments, and a student's answers put into a copy of one."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import nbformat
from nbformat import NotebookNode

HERE = Path(__file__).resolve().parents[1]
SOURCE, RELEASE = HERE / "source", HERE / "release"
ASSIGNMENTS = tuple(sorted(path.parent.name for path in SOURCE.glob("*/*.ipynb")))


def read(path: Path) -> NotebookNode:
    """A notebook in the present format, whatever version it was saved in."""
    return nbformat.read(path, as_version=4)


def source(assignment: str) -> Path:
    """The solved notebook of an assignment."""
    return SOURCE / assignment / f"{assignment}.ipynb"


def release(assignment: str) -> Path:
    """The student's copy of an assignment."""
    return RELEASE / assignment / f"{assignment}.ipynb"


def about(cell: NotebookNode) -> dict:
    """What nbgrader knows of a cell."""
    return cell.metadata.get("nbgrader", {})


def name_of(cell: NotebookNode) -> str | None:
    return about(cell).get("grade_id")


def names(notebook: NotebookNode) -> set[str]:
    """The names of the cells that an assignment is made of."""
    return {name_of(cell) for cell in notebook.cells} - {None}


def answers(notebook: NotebookNode) -> dict[str, str]:
    """The text of each cell that a student fills in; of copies of a cell the first counts."""
    found: dict[str, str] = {}
    for cell in notebook.cells:
        if about(cell).get("solution"):
            found.setdefault(name_of(cell), cell.source)
    return found


def assembled(master: NotebookNode, blank: NotebookNode, submission: NotebookNode) -> NotebookNode:
    """The master with the student's answers in it.

    All that is not the student's comes from the master, hidden tests included: tests that were changed, moved or
    deleted are as they were, and an answer that is missing is blank.  The student's own code cells stay after the cell
    that they followed.
    """
    given, empty, own = answers(submission), answers(blank), own_cells(submission, names(master))
    cells = own.get(None, [])
    for cell in deepcopy(master.cells):
        name = name_of(cell)
        if name in empty:
            cell.source = given.get(name, empty[name])
        cells += [cell, *own.get(name, [])] if name else [cell]
    metadata = {"kernelspec": master.metadata.kernelspec}
    return nbformat.v4.new_notebook(cells=[cleared(cell) for cell in cells], metadata=metadata)


def own_cells(submission: NotebookNode, known: set[str]) -> dict[str | None, list[NotebookNode]]:
    """The code cells that a student added, by the name of the cell of the assignment before them."""
    own: dict[str | None, list[NotebookNode]] = {}
    seen: set[str] = set()
    before = None
    for cell in submission.cells:
        name = name_of(cell)
        if name in known - seen:
            seen.add(name)
            before = name
        elif cell.cell_type == "code" and cell.source.strip() and (name not in known or about(cell).get("solution")):
            own.setdefault(before, []).append(nbformat.v4.new_code_cell(cell.source))
    return own


def cleared(cell: NotebookNode) -> NotebookNode:
    """A cell without what running it left behind, under an id of its own."""
    if cell.cell_type == "code":
        cell.outputs, cell.execution_count = [], None
    cell.id = nbformat.v4.new_raw_cell().id
    return cell
