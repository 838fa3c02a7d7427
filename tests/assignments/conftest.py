"""Submissions made from the solved notebooks, graded as a teacher grades them."""

from pathlib import Path

import nbformat
import pytest

from grader import masters
from grader.collect import Submission
from grader.run import Limits, Result, graded


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


@pytest.fixture
def grade(tmp_path):
    """Grades a submission: ``grade(assignment, changes, student)``."""

    def run(assignment: str, changes: dict | None = None, student: str = "ada") -> Result:
        path = handed_in(assignment, tmp_path, changes)
        return graded(Submission(student, path, assignment), Limits(), tmp_path / "kept")

    return run


@pytest.fixture
def lost(grade):
    """The points that a submission loses, by cell; what a person marks is left out."""

    def of(assignment: str, changes: dict | None = None, student: str = "ada") -> dict[str, float]:
        result = grade(assignment, changes, student)
        assert not result.remark, result.remark
        losses = {m["cell"]: m["points"] - m["mark"] for m in result.marks if m["mark"] is not None}
        return {cell: points for cell, points in losses.items() if points}

    return of


def pytest_generate_tests(metafunc):
    """One test for each slip that is listed for an assignment."""
    if "slip" in metafunc.fixturenames:
        metafunc.parametrize("slip", metafunc.cls.slips)
