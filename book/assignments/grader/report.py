"""What a teacher and the students get: marks as CSV, what is to be marked by hand, and a page for each student."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from grader.run import Result

MARKS = ("student", "assignment", "cell", "points", "mark", "marked", "remark")
BY_HAND = ("student", "assignment", "cell", "points", "mark", "comment")
PAGES = Environment(
    loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined, trim_blocks=True
)


def with_marks_by_hand(results: list[Result], file: Path) -> list[Result]:
    """The results with the marks that a person has entered in a file, which gets a row for each that is missing.

    Raises
    ------
    ValueError
        If a mark in the file is no number between 0 and the points of its cell.
    """
    rows = read(file)
    entered = {tuple(row[key] for key in BY_HAND[:3]): row for row in rows}
    for result in results:
        for mark in result.marks:
            if mark["mark"] is None and key_of(result, mark) not in entered:
                rows.append(dict(zip(BY_HAND, (*key_of(result, mark), mark["points"], "", ""), strict=True)))
    if rows:
        write(file, BY_HAND, rows)
    return [
        replace(result, marks=[completed(mark, entered.get(key_of(result, mark))) for mark in result.marks])
        for result in results
    ]


def key_of(result: Result, mark: dict) -> tuple[str, str, str]:
    return result.submission.student, result.submission.assignment, mark["cell"]


def completed(mark: dict, row: dict | None) -> dict:
    """A mark, with what a person entered for it."""
    mark = {**mark, "marked": "" if mark["mark"] is None else "auto"}
    if mark["mark"] is not None or row is None or not row["mark"].strip():
        return mark
    return {**mark, "mark": number(row["mark"], mark["points"], row), "remark": row["comment"], "marked": "hand"}


def number(text: str, points: float, row: dict) -> float:
    """A mark that a person entered."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = -1.0
    if not 0 <= value <= points:
        where = ", ".join(row[key] for key in BY_HAND[:3])
        raise ValueError(f"by_hand.csv: expected a mark from 0 to {points:g} for {where}, got {text!r}")
    return value


def write_marks(results: Iterable[Result], file: Path) -> None:
    """One row for each graded cell, and one for each file that could not be graded."""
    rows = []
    for result in results:
        one = result.submission
        if result.remark:
            rows.append({"student": one.student, "assignment": one.assignment or "", "remark": result.remark})
        for mark in result.marks:
            rows.append({"student": one.student, "assignment": one.assignment, **pick(mark, MARKS[2:])})
    write(file, MARKS, rows)


def write_totals(results: Iterable[Result], file: Path) -> None:
    """One row for each student, one column for each assignment; what waits for a person is not counted."""
    graded = [result for result in results if result.marks]
    names = sorted({result.submission.assignment for result in graded})
    totals: dict[str, dict] = {}
    for result in graded:
        row = totals.setdefault(result.submission.student, {"student": result.submission.student})
        row[result.submission.assignment] = f"{total(result.marks):g}"
    write(file, ("student", *names), [totals[student] for student in sorted(totals)])


def write_feedback(results: Iterable[Result], folder: Path) -> None:
    """A page for each student."""
    folder.mkdir(parents=True, exist_ok=True)
    for student, group in groupby(sorted(results, key=student_of), key=student_of):
        page = PAGES.get_template("feedback.html").render(
            student=student, results=list(group), total=total, points=points
        )
        (folder / f"{student}.html").write_text(page, encoding="utf-8")


def student_of(result: Result) -> str:
    return result.submission.student


def total(marks: list[dict]) -> float:
    return sum(mark["mark"] or 0 for mark in marks)


def points(marks: list[dict]) -> float:
    return sum(mark["points"] for mark in marks)


def pick(row: dict, keys: Iterable[str]) -> dict:
    return {key: "" if row[key] is None else row[key] for key in keys}


def read(file: Path) -> list[dict]:
    """The rows of a CSV file, none if there is no file; spreadsheets write ; for , and a mark of byte order."""
    if not file.exists():
        return []
    text = file.read_text(encoding="utf-8-sig")
    separator = ";" if text.splitlines()[0].count(";") > text.splitlines()[0].count(",") else ","
    rows = csv.DictReader(io.StringIO(text, newline=""), delimiter=separator)
    return [{key: (value or "").removeprefix("'") for key, value in row.items()} for row in rows]


def write(file: Path, columns: tuple[str, ...], rows: list[dict]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, columns, restval="")
        writer.writeheader()
        writer.writerows({key: harmless(value) for key, value in row.items()} for row in rows)


def harmless(value):
    """A value that no spreadsheet takes for a formula: some of the text comes from students."""
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@")) else value
