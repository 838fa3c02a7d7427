"""What a teacher and the students get: marks as CSV, what is marked by hand, and pages to read."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from hashlib import sha256
from itertools import groupby
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from grader import tables
from grader.collect import file_name
from grader.run import Result, cells_of

MARKS = ("student", "assignment", "cell", "points", "mark", "marked", "remark")
BY_HAND = ("student", "assignment", "cell", "points", "mark", "comment", "answer")
LOOK = ("student", "assignment", "cell", "what")
PAGES = Environment(
    loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined, trim_blocks=True
)
CHANGED = "the answer has changed since it was marked {mark}: mark it again"
NOWHERE = "by_hand.csv: {where} is not among what was graded (mark {mark}); is a name misspelled?"
TWICE = "by_hand.csv: {where} stands there twice; the last row counts"
ANOTHER = "by_hand.csv: the answer to {where} has changed since it was marked {mark}; {now}"


def with_marks_by_hand(results: list[Result], file: Path) -> tuple[list[Result], list[str]]:
    """The results with the marks that a person has entered in a file, and what is to be said about the file.

    A row stands for one graded cell; its mark and comment take the place of what the grader found.  Answers that only
    a person can mark get their rows here.  The last column tells which answer was marked: when it changes, the mark no
    longer holds and is asked for again.

    Raises
    ------
    EntryError
        If a mark in the file is no number between 0 and the points of its cell.
    """
    rows, said = tables.read(file), []
    entered: dict[tuple, dict] = {}
    for row in rows:
        row |= {name: row.get(name, "") for name in BY_HAND}
        if key(row) in entered:
            said.append(TWICE.format(where=where(row)))
        entered[key(row)] = row
    rows = list(entered.values())
    graded = {key_of(result, mark): mark for result in results for mark in result.marks}
    failed = {
        (result.submission.student.casefold(), result.submission.assignment) for result in results if result.failed
    }
    lost = [row for row in rows if key(row) not in graded and key(row)[:2] not in failed]
    said += [NOWHERE.format(where=where(row), mark=row["mark"] or "none") for row in lost]
    for known, mark in graded.items():
        if known in entered:
            said += brought_up_to_date(entered[known], mark)
        elif mark["mark"] is None:
            rows.append(dict(zip(BY_HAND, (*known, mark["points"], "", "", name_of(mark)), strict=True)))
    if rows:
        tables.write(file, BY_HAND, rows, separator_in(file))
    completed_ = [
        replace(result, marks=[completed(mark, entered.get(key_of(result, mark))) for mark in result.marks])
        for result in results
    ]
    return completed_, said


def separator_in(file: Path) -> str:
    """What divides the columns of a file that is there, so that it is written as its owner writes it."""
    return tables.separator_of(tables.decoded(file.read_bytes())) if file.exists() else ","


def key(row: dict) -> tuple[str, str, str]:
    return row["student"].casefold(), row["assignment"].casefold(), row["cell"].casefold()


def key_of(result: Result, mark: dict) -> tuple[str, str, str]:
    one = result.submission
    return one.student.casefold(), one.assignment.casefold(), mark["cell"].casefold()


def where(row: dict) -> str:
    return ", ".join(row[name] for name in BY_HAND[:3])


def name_of(mark: dict) -> str:
    """A short name for an answer, by which it is known again."""
    return sha256(mark["answer"].strip().encode()).hexdigest()[:8]


def brought_up_to_date(row: dict, mark: dict) -> list[str]:
    """Note which answer a row is for; if that has changed, its mark goes into the comment.  What there is to say."""
    now, row["points"] = name_of(mark), mark["points"]
    before, row["answer"] = row["answer"] or now, now
    if before == now or not row["mark"]:
        return []
    what_now = "it waits for a mark again" if mark["mark"] is None else "the grader's mark counts"
    said = ANOTHER.format(where=where(row), mark=row["mark"], now=what_now)
    row["comment"] = f"{CHANGED.format(mark=row['mark'])} {row['comment']}".strip()
    row["mark"] = ""
    return [said]


def completed(mark: dict, row: dict | None) -> dict:
    """A mark, with what a person entered for it."""
    mark = {**mark, "marked": "" if mark["mark"] is None else "auto"}
    if row is None or not row["mark"].strip():
        return mark
    return {**mark, "mark": number(row["mark"], mark["points"], row), "remark": row["comment"], "marked": "hand"}


def number(text: str, points: float, row: dict) -> float:
    """A mark that a person entered."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = -1.0
    if not 0 <= value <= points:
        raise tables.EntryError(f"by_hand.csv: expected a mark from 0 to {points:g} for {where(row)}, got {text!r}")
    return value


def write_marks(results: Iterable[Result], file: Path, separator: str = ",") -> None:
    """One row for each graded cell, and one for each file that could not be graded."""
    rows = []
    for result in results:
        one = result.submission
        if result.remark:
            rows.append({"student": one.student, "assignment": one.assignment or "", "remark": result.remark})
        for mark in result.marks:
            rows.append({"student": one.student, "assignment": one.assignment, **pick(mark, MARKS[2:])})
    tables.write(file, MARKS, rows, separator)


def write_totals(results: Iterable[Result], file: Path, separator: str = ",") -> None:
    """One row for each student: the marks of each assignment, their sum, what there is to be had and what waits.

    What was not handed in is empty and counts as nothing.  What waits, for a person or for another run, is not counted
    yet: `percent` is of `max`, so it can still rise by `waiting`.
    """
    results = [result for result in results if result.marks or result.failed]
    names = sorted({result.submission.assignment for result in results})
    most = {name: sum(cells_of(name).values()) for name in names}
    totals: dict[str, dict] = {}
    for result in results:
        one = result.submission
        row = totals.setdefault(one.student, {"student": one.student, "total": 0.0, "waiting": 0.0})
        row["total"] += total(result.marks)
        row["waiting"] += waiting(result.marks) if result.marks else most[one.assignment]
        row[one.assignment] = total(result.marks) if result.marks else ""
    for row in totals.values():
        row["max"] = float(sum(most.values()))
        row["percent"] = round(100 * row["total"] / row["max"], 1)
    top = {"student": "(max)", "total": float(sum(most.values())), **most}
    rows = [top, *(totals[student] for student in sorted(totals))] if totals else []
    tables.write(file, ("student", *names, "total", "max", "waiting", "percent"), rows, separator)


def write_look(found: list, file: Path, separator: str = ",") -> None:
    """One row for each thing to look at."""
    tables.write(file, LOOK, [{name: getattr(one, name) for name in LOOK} for one in found], separator)


def write_feedback(results: Iterable[Result], folder: Path) -> None:
    """A page for each student."""
    for student, group in groupby(sorted(results, key=student_of), key=student_of):
        put(folder / f"{file_name(student)}.html", "feedback.html", student=student, results=list(group))


def put(file: Path, template: str, **named) -> None:
    """A page made from a template."""
    file.parent.mkdir(parents=True, exist_ok=True)
    page = PAGES.get_template(template).render(total=total, points=points, waiting=waiting, **named)
    file.write_text(page, encoding="utf-8")


def student_of(result: Result) -> str:
    return result.submission.student


def total(marks: list[dict]) -> float:
    return float(sum(mark["mark"] or 0 for mark in marks))


def points(marks: list[dict]) -> float:
    return float(sum(mark["points"] for mark in marks))


def waiting(marks: list[dict]) -> float:
    """The points that a person has still to give or not."""
    return float(sum(mark["points"] for mark in marks if mark["mark"] is None))


def pick(row: dict, keys: Iterable[str]) -> dict:
    return {key: "" if row[key] is None else row[key] for key in keys}
