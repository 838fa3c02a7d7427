"""The solved notebooks of the assignments, and a student's answers put into a copy of one."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from grader import tables
from grader.matching import is_answer, keys, matched

HERE = Path(__file__).resolve().parents[1]
SOURCE, RELEASE = HERE / "source", HERE / "release"
ASSIGNMENTS = tuple(sorted(path.parent.name for path in SOURCE.glob("*/*.ipynb")))


def read(path: Path) -> NotebookNode:
    """A notebook in the present format, whatever version and encoding it was saved in."""
    return nbformat.reads(tables.decoded(path.read_bytes()), as_version=4)


def source(assignment: str) -> Path:
    """The solved notebook of an assignment."""
    return SOURCE / assignment / f"{assignment}.ipynb"


def release(assignment: str) -> Path:
    """The student's copy of an assignment."""
    return RELEASE / assignment / f"{assignment}.ipynb"


def about(cell: NotebookNode) -> dict:
    """What nbgrader knows of a cell."""
    known = cell.metadata.get("nbgrader", {})
    return known if isinstance(known, dict) else {}


def name_of(cell: NotebookNode) -> str | None:
    name = about(cell).get("grade_id")
    return name if isinstance(name, str) else None


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
    that they followed.  An answer that has lost its name is found again, see `grader.matching`.
    """
    found = matched(blank, master, submission, name_of)
    given = {key: cell.source for key, cell in zip(found, submission.cells, strict=True) if key is not None}
    own = own_cells(submission, found, names(master))
    cells = own.get(None, [])
    for key, cell, stub in zip(keys(blank, name_of), deepcopy(master.cells), blank.cells, strict=True):
        if about(cell).get("solution"):
            cell.source = given.get(key, stub.source)
        cells += [cell, *own.get(key, [])]
    metadata = {"kernelspec": master.metadata.kernelspec}
    return nbformat.v4.new_notebook(cells=[cleared(cell) for cell in cells], metadata=metadata)


def own_cells(submission: NotebookNode, found: list, known: set[str]) -> dict[str | int | None, list[NotebookNode]]:
    """The code cells that a student added, by the cell of the assignment before them; second copies of tests go."""
    own: dict[str | int | None, list[NotebookNode]] = {}
    before = None
    for key, cell in zip(found, submission.cells, strict=True):
        if key is not None:
            before = key
        elif cell.cell_type == "code" and cell.source.strip() and (name_of(cell) not in known or is_answer(cell)):
            own.setdefault(before, []).append(nbformat.v4.new_code_cell(cell.source, metadata={"own": True}))
    return own


def cleared(cell: NotebookNode) -> NotebookNode:
    """A cell without what running it left behind, under an id of its own."""
    if cell.cell_type == "code":
        cell.outputs, cell.execution_count = [], None
    cell.id = nbformat.v4.new_raw_cell().id
    return cell
