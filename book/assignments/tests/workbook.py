"""A submission run here, cell by cell, without a kernel: what each check below an answer says, and what is lost."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import nbformat
from matplotlib import pyplot as plt

from grader import masters
from grader.matching import defined
from submissions import changed

BEGIN, END = "### BEGIN HIDDEN TESTS\n", "### END HIDDEN TESTS"
Space = dict[str, object]


@dataclass(frozen=True)
class Loss:
    """The points of a graded cell, what it says, and whether it says so to the student, before grading."""

    points: float
    said: str
    seen: bool


@cache
def cells_of(assignment: str) -> list:
    """The code cells of a solved notebook."""
    return [cell for cell in masters.read(masters.source(assignment)).cells if cell.cell_type == "code"]


def solved(assignment: str) -> dict[str, str]:
    return {masters.name_of(cell): cell.source for cell in cells_of(assignment) if masters.about(cell).get("solution")}


def stubs(assignment: str) -> dict[str, str]:
    """The answers in code as they are handed out."""
    blank = masters.answers(masters.read(masters.release(assignment)))
    return {name: blank[name] for name in solved(assignment)}


def losses(
    assignment: str,
    changes: dict,
    student: str = "ada",
    without: tuple[str, ...] = (),
    only: set[str] | None = None,
    judge: Callable | None = None,
) -> dict[str, Loss]:
    """What a submission loses, by cell; some cells, as those that draw, may be left out, or all checks but some."""
    texts = solved(assignment)
    assert set(changes) <= set(texts), f"no such cells: {set(changes) - set(texts)}"
    texts = {name: with_id(changed(text, changes.get(name)), student) for name, text in texts.items()}
    space, found = {"__name__": "__main__"}, {}
    for cell in until_last(cells_of(assignment), only):
        name, graded = masters.name_of(cell), masters.about(cell).get("grade")
        if name in without or (graded and only is not None and name not in only):
            continue
        if graded:
            found[name] = (judge or judged)(cell, space)
        else:
            run(texts.get(name, cell.source), space)
    plt.close("all")
    return {name: loss for name, loss in found.items() if loss.said}


def until_last(cells: list, only: set[str] | None) -> list:
    """The cells up to the last of some checks; those after it decide nothing."""
    last = max((n for n, cell in enumerate(cells, 1) if only is None or masters.name_of(cell) in only), default=0)
    return cells[:last]


def reached(assignment: str, changes: dict) -> set[str]:
    """The checks whose outcome some changes can alter: all other ones meet no name that depends on them."""
    texts = {name: changed(text, changes.get(name)) for name, text in solved(assignment).items()}
    names, found = set(), set()
    for _ in range(2):  # a function may call one that is defined below it
        for cell in cells_of(assignment):
            name = masters.name_of(cell)
            text = texts.get(name, cell.source)
            if name in changes or names & set(re.findall(r"\w+", text)):
                names |= defined(text)
                found.add(name)
    return found


def with_id(answer: str, student: str) -> str:
    return answer.replace('student = "ada"', f'student = "{student}"')


def parts(cell) -> tuple[str, str]:
    """What of a check students see, and what they don't."""
    visible, _, hidden = cell.source.partition(BEGIN)
    return visible, hidden.replace(END, "")


def points_of(cell) -> float:
    return masters.about(cell).get("points") or 0


def judged_again(cell, space: Space) -> Loss:
    """What a check says of the same numbers as others before: they need not be worked out anew."""
    again = nbformat.from_dict({**cell, "source": cell.source.replace("on_other_numbers", "_on_others")})
    return judged(again, space)


def judged(cell, space: Space) -> Loss:
    """What a check says: first the part that students have, then the hidden one."""
    visible, hidden = parts(cell)
    if said := run(visible, space):
        return Loss(points_of(cell), said, True)
    return Loss(points_of(cell), run(hidden, space), False)


class Parrot:
    """Remembers what a function answers, and later answers only what it remembers, or the first thing it did."""

    def __init__(self, function: Callable):
        self.function, self.known, self.learns = function, {}, True

    def __call__(self, *given):
        if self.learns or str(given) in self.known:
            answer = self.function(*given)
            answer = [*answer] if hasattr(answer, "__next__") else answer
            self.known.setdefault(str(given), answer)
            return answer
        return next(iter(self.known.values()))


def judged_by_heart(cell, space: Space) -> Loss:
    """What a check says of answers that know the right values for the student's own numbers, and no other ones."""
    visible, hidden = parts(cell)
    asked = set(re.findall(r"\w+", hidden))
    parrots = {name: Parrot(thing) for name, thing in space.items() if name in asked and is_own(thing)}
    if not parrots:
        return Loss(0, "", False)
    space = space | parrots
    said = run(visible, space)
    for parrot in parrots.values():
        parrot.learns = False
    return Loss(points_of(cell), said or run(hidden, space), bool(said))


def is_own(thing: object) -> bool:
    """Whether something is a function that was written in the notebook."""
    return getattr(thing, "__module__", None) == "__main__" and callable(thing)


def run(text: str, space: Space) -> str:
    """Run a cell, and say what went wrong."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(text, "<a cell>", "exec"), space)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""
