"""A submission run here, cell by cell, without a kernel: what each check below an answer says, and what is lost."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass
from functools import cache

from matplotlib import pyplot as plt

from grader import masters
from submissions import changed

BEGIN, END = "### BEGIN HIDDEN TESTS\n", "### END HIDDEN TESTS"


@dataclass(frozen=True)
class Loss:
    """The points of a graded cell, what it says, and whether it says so to the student, before grading."""

    points: float
    said: str
    seen: bool


@cache
def master(assignment: str):
    return masters.read(masters.source(assignment))


def losses(assignment: str, changes: dict, student: str = "ada", without: tuple[str, ...] = ()) -> dict[str, Loss]:
    """What a submission loses, by cell; some cells, as those that draw, may be left out."""
    answers = masters.answers(master(assignment))
    assert set(changes) <= set(answers), f"no such cells: {set(changes) - set(answers)}"
    space, found = {"__name__": "__main__"}, {}
    for cell in master(assignment).cells:
        name = masters.name_of(cell)
        if cell.cell_type != "code" or name in without:
            continue
        if name in answers:
            run(with_id(changed(cell.source, changes.get(name)), student), space)
        elif (loss := judged(cell, space)).said:
            found[name] = loss
    plt.close("all")
    return {name: loss for name, loss in found.items() if loss.points}


def with_id(answer: str, student: str) -> str:
    return answer.replace('student = "ada"', f'student = "{student}"')


def judged(cell, space: dict) -> Loss:
    """What a check says: first the part that students have, then the hidden one."""
    visible, _, hidden = cell.source.partition(BEGIN)
    points = masters.about(cell).get("points") or 0
    if said := run(visible, space):
        return Loss(points, said, True)
    return Loss(points, run(hidden.replace(END, ""), space), False)


def run(text: str, space: dict) -> str:
    """Run a cell, and say what went wrong."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(text, "<a cell>", "exec"), space)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""
