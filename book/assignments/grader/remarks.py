"""What students and teachers are told, in words."""

from __future__ import annotations

import re

from nbformat import NotebookNode

from grader.matching import defined, is_answer

LONGEST = 500
STOPPED = "stopped after {seconds} s in all"
TOO_SLOW = "took longer than {seconds} s, so it was stopped"
TOO_LARGE = "used more memory than there is"
TOO_MANY = "started more processes than it may"
TOO_FULL = "wrote more than there is room for"
NOTHING = "nothing was written"
NOT_DONE = "not answered yet: a line raise NotImplementedError() is left"
NOT_RUN = "was not run, since an earlier cell ended Python, used up its memory or could not be stopped"
NOT_PROVED = "no points, since the check did not run to its end, or what it printed went elsewhere"
REPLACED = "no points, since before this check something that it needs was replaced in {what}"
ABOVE = "the answer above did not run to its end: {why}"

LOADED = "the machine was too busy for the limits of time"
STARTED = "it started {count} processes of its own"
CHANGED = "while it ran, something was replaced in {what}"
WHOSE = "while it ran, the numbers were drawn for {student!r}"
ACCEPTS = "while it ran, the checks accepted a wrong answer"
SILENT = "the kernel did not answer as it should"


def complaint(cell: NotebookNode, before: list[NotebookNode], seconds: int) -> str:
    """What the last error of a cell says; if a name is missing, why the cell that should define it did not."""
    errors = errors_of(cell)
    if not errors:
        return ""
    if errors[-1].ename == "NameError":
        cause = first_cause(errors[-1].evalue, before)
        if cause is not None:
            said = in_words(cause, seconds)
            return said if said in (NOT_DONE, TOO_SLOW.format(seconds=seconds)) else cut(ABOVE.format(why=said))
    return in_words(errors[-1], seconds)


def errors_of(cell: NotebookNode) -> list[NotebookNode]:
    return [output for output in cell.get("outputs", []) if output.output_type == "error"]


def first_cause(said: str, before: list[NotebookNode]) -> NotebookNode | None:
    """The error of the last cell that would have defined the missing name, else that of the last answer."""
    missing = set(re.findall(r"'(\w+)'", said))
    code = [cell for cell in reversed(before) if cell.cell_type == "code"]
    defining = [cell for cell in code if missing & defined(cell.source)] or [cell for cell in code if is_answer(cell)]
    return (errors_of(defining[0]) or [None])[-1] if defining else None


def in_words(error: NotebookNode, seconds: int) -> str:
    """One error, in a student's words."""
    kind, said = error.ename, error.evalue
    if kind in ("CellTimeoutError", "KeyboardInterrupt"):
        return TOO_SLOW.format(seconds=seconds)
    if kind == "NotImplementedError":
        return NOT_DONE
    if kind == "MemoryError":
        return TOO_LARGE
    if kind == "AssertionError" and said:
        return cut(said)
    return cut(f"{kind}: {said}" if said else f"{kind} in line {line_of(error)}")


def line_of(error: NotebookNode) -> str:
    """The text of the line in which an error without words was raised."""
    arrows = re.findall(r"^-+> *\d+ (.*)$", plain("\n".join(error.traceback)), re.MULTILINE)
    return repr(arrows[0].strip()) if arrows else "?"


def plain(text: str) -> str:
    """A text without the terminal's colours and other signs that are not to be seen."""
    return re.sub(r"[\x00-\x08\x0b-\x1f\x7f]", "", re.sub(r"\x1b\[[0-9;]*m", "", text)).strip()


def cut(text: str) -> str:
    """A text that is not too long to be read.

    Examples
    --------
    >>> len(cut("x" * 100_000)), cut("short")
    (500, 'short')
    """
    text = plain(text[: 20 * LONGEST])
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 2]} …"
