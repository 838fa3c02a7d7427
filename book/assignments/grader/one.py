"""Marks one notebook; runs in a process of its own: ``python -m grader.one`` reads an order in JSON."""

from __future__ import annotations

import contextlib
import json
import re
import resource
import sys
from pathlib import Path

from nbclient.exceptions import CellTimeoutError, DeadKernelError
from nbformat import NotebookNode
from nbgrader.preprocessors import Execute
from nbgrader.utils import determine_grade, is_grade
from nbgrader.utils import is_solution as is_answer

from grader import masters

TOO_SLOW = "took longer than {seconds} s, so it was stopped"
TOO_LARGE = "used more memory than there is"
NOT_DONE = "not answered yet: a line raise NotImplementedError() is left"
NOT_RUN = "was not run, since an earlier cell ended Python, used up its memory or could not be stopped"


def marks(assignment: str, submission: Path, folder: Path, seconds: int) -> list[dict]:
    """The marks of each graded cell: name, points, mark (None where a person decides), remark, answer.

    Parameters
    ----------
    assignment : str
    submission : Path
        The student's notebook.
    folder : Path
        Where the notebook is run.
    seconds : int
        How long a cell may take.
    """
    master, blank = masters.read(masters.source(assignment)), masters.read(masters.release(assignment))
    notebook = masters.assembled(master, blank, masters.read(submission))
    executed(notebook, folder, seconds)
    found, answer = [], ""
    for cell in notebook.cells:
        answer = cell.source if is_answer(cell) else answer
        if is_grade(cell):
            found.append({**judged(cell, masters.answers(blank), seconds), "answer": answer})
    return found


def executed(notebook: NotebookNode, folder: Path, seconds: int) -> None:
    """Run all cells in place; what raises is recorded in its cell, what never ends is stopped."""
    runner = Execute(timeout=seconds, startup_timeout=120)
    # The cells after one that ended Python were not run, and are judged so.
    with contextlib.suppress(DeadKernelError, CellTimeoutError):
        runner.preprocess(notebook, {"metadata": {"path": str(folder)}})


def judged(cell: NotebookNode, empty: dict[str, str], seconds: int) -> dict:
    """The marks of one cell that was run, by nbgrader's rule, but a warning costs nothing."""
    name, points = masters.name_of(cell), float(masters.about(cell)["points"])
    result = {"cell": name, "points": points, "mark": 0.0, "remark": ""}
    if is_answer(cell):
        blank = cell.source.strip() == empty[name].strip()
        return {**result, "remark": "nothing was written"} if blank else {**result, "mark": None}
    if cell.execution_count is None:
        return {**result, "remark": NOT_RUN}
    cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    return {**result, "mark": determine_grade(cell)[0], "remark": complaint(cell, seconds)}


def complaint(cell: NotebookNode, seconds: int) -> str:
    """What the last error of a cell says."""
    errors = [output for output in cell.outputs if output.output_type == "error"]
    if not errors:
        return ""
    kind, said = errors[-1].ename, errors[-1].evalue
    if kind in ("CellTimeoutError", "KeyboardInterrupt"):
        return TOO_SLOW.format(seconds=seconds)
    if kind == "NotImplementedError":
        return NOT_DONE
    if kind == "MemoryError":
        return TOO_LARGE
    if kind == "AssertionError" and said:
        return plain(said)
    return plain(f"{kind}: {said}" if said else f"{kind} in line {line_of(errors[-1])}")


def line_of(error: NotebookNode) -> str:
    """The text of the line in which an error without words was raised."""
    arrows = re.findall(r"^-+> *\d+ (.*)$", plain("\n".join(error.traceback)), re.MULTILINE)
    return repr(arrows[0].strip()) if arrows else "?"


def plain(text: str) -> str:
    """A text without the terminal's colours."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text).strip()


def carry_out(order: dict) -> None:
    """Mark a submission as ordered, and write its marks down."""
    found = marks(order["assignment"], Path(order["submission"]), Path(order["folder"]), order["seconds"])
    Path(order["result"]).write_text(json.dumps(found), encoding="utf-8")


def main() -> None:
    order = json.load(sys.stdin)
    limit = order["megabytes"] * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    carry_out(order)


if __name__ == "__main__":
    main()
