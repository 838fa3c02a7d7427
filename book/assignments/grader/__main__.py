"""The command: ``python -m grader FOLDER``, from book/assignments."""

from __future__ import annotations

import argparse
import os
import sys
import time
from functools import partial
from pathlib import Path

from grader import box, look, masters, questions, report, tables
from grader.collect import read_roster, submissions
from grader.run import Limits, Result, cells_of, graded_all


def options(arguments: list[str] | None = None) -> argparse.Namespace:
    """What the command was asked to do."""
    parser = argparse.ArgumentParser(prog="grader", description="Grade a folder of submissions.")
    parser.add_argument("folder", type=Path, help="student/…/notebook.ipynb or student_assignment.ipynb")
    parser.add_argument("--out", type=Path, default=Path("graded"), help="where marks and feedback go (graded)")
    parser.add_argument("--roster", type=Path, help="CSV with the columns name and id: whose a folder or file is")
    parser.add_argument("--names", help="moodle, canvas, or a regular expression with (?P<student>…) for names")
    parser.add_argument("--question", help="make only the marks of this graded cell anew, and leave all others")
    parser.add_argument("--separator", choices=tables.SEPARATORS, default=",", help="between columns of CSV files (,)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="how many at a time (all processors)")
    parser.add_argument("--cell-seconds", type=int, default=Limits.cell, help="limit for one cell (%(default)s)")
    parser.add_argument("--seconds", type=int, default=Limits.all, help="limit for one notebook (%(default)s)")
    parser.add_argument("--megabytes", type=int, default=Limits.megabytes, help="limit of memory (%(default)s)")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    asked = options(arguments)
    print(about_the_box(), flush=True)
    if not asked.folder.is_dir():
        print(f"no folder of submissions at {asked.folder}", file=sys.stderr)
        return 2
    try:
        return graded(asked)
    except tables.EntryError as error:  # in what a person has written: the roster, by_hand.csv, the names
        print(error, file=sys.stderr)
        return 2


def about_the_box() -> str:
    return box.BOXED if box.bubblewrap() else box.OPEN


def graded(asked: argparse.Namespace) -> int:
    """Grade as was asked; say on the way what is done, and give 1 if something is to be run again."""
    begun = time.monotonic()
    found = submissions(asked.folder, read_roster(asked.roster), asked.names)
    if asked.question and asked.question not in all_questions():
        raise tables.EntryError(f"--question: there is no {asked.question!r}; the names stand in marks.csv under cell")
    print(f"{len(found)} files of {len({one.student for one in found})} students in {asked.folder}", flush=True)
    limits = Limits(asked.cell_seconds, asked.seconds, asked.megabytes)
    say = partial(print, flush=True)
    results = graded_all(found, limits, asked.out / "kept", asked.jobs, say, asked.question)
    results, said = report.with_marks_by_hand(results, asked.out / "by_hand.csv")
    write(results, said, asked.out, asked.separator)
    print("\n".join(last_words(results, said, asked.out, time.monotonic() - begun)))
    return int(any(result.failed for result in results))


def all_questions() -> set[str]:
    return {cell for assignment in masters.ASSIGNMENTS for cell in cells_of(assignment)}


def write(results: list[Result], said: list[str], out: Path, separator: str) -> None:
    """All files."""
    looked = look.findings(results)
    report.write_marks(results, out / "marks.csv", separator)
    report.write_totals(results, out / "totals.csv", separator)
    report.write_look(looked, out / "look_at_this.csv", separator)
    report.write_feedback(results, out / "feedback")
    questions.write_pages(results, looked, said, out / "teacher", about_the_box())


def last_words(results: list[Result], said: list[str], out: Path, seconds: float) -> list[str]:
    """What is said at the end: where all is, and what remains to be done."""
    lines = [*said, f"marks.csv, totals.csv, feedback/ and teacher/index.html are in {out} ({seconds:.0f} s)"]
    failed = sum(result.failed for result in results)
    waiting = sum(mark["mark"] is None for result in results for mark in result.marks)
    to_look_at = len(tables.read(out / "look_at_this.csv"))
    if failed:
        lines.append(f"{failed} files could not be run and have no marks: give the command again")
    if to_look_at:
        lines.append(f"{to_look_at} things to look at: {out / 'look_at_this.csv'}, or the page teacher/index.html")
    if waiting:
        lines.append(f"{waiting} answers wait for a mark by hand: enter it in {out / 'by_hand.csv'} and run this again")
    return lines


if __name__ == "__main__":
    sys.exit(main())
