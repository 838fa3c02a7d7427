"""The command: ``python -m grader FOLDER``, from book/assignments."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from grader import box, report
from grader.collect import read_roster, submissions
from grader.run import Limits, graded_all


def options(arguments: list[str] | None = None) -> argparse.Namespace:
    """What the command was asked to do."""
    parser = argparse.ArgumentParser(prog="grader", description="Grade a folder of submissions.")
    parser.add_argument("folder", type=Path, help="student/…/notebook.ipynb or student_assignment.ipynb")
    parser.add_argument("--out", type=Path, default=Path("graded"), help="where marks and feedback go (graded)")
    parser.add_argument("--roster", type=Path, help="CSV with the columns name and id: whose a folder or file is")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="how many at a time (all processors)")
    parser.add_argument("--cell-seconds", type=int, default=Limits.cell, help="limit for one cell (%(default)s)")
    parser.add_argument("--seconds", type=int, default=Limits.all, help="limit for one notebook (%(default)s)")
    parser.add_argument("--megabytes", type=int, default=Limits.megabytes, help="limit of memory (%(default)s)")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    asked = options(arguments)
    if not asked.folder.is_dir():
        print(f"no folder of submissions at {asked.folder}", file=sys.stderr)
        return 2
    print(box.BOXED if box.bubblewrap() else box.OPEN, flush=True)
    begun = time.monotonic()
    found = submissions(asked.folder, read_roster(asked.roster))
    print(f"{len(found)} files of {len({one.student for one in found})} students in {asked.folder}", flush=True)
    limits = Limits(asked.cell_seconds, asked.seconds, asked.megabytes)
    results = graded_all(found, limits, asked.out / "kept", asked.jobs, lambda line: print(line, flush=True))
    results = report.with_marks_by_hand(results, asked.out / "by_hand.csv")
    report.write_marks(results, asked.out / "marks.csv")
    report.write_totals(results, asked.out / "totals.csv")
    report.write_feedback(results, asked.out / "feedback")
    waiting = sum(mark["mark"] is None for result in results for mark in result.marks)
    print(f"marks.csv, totals.csv and feedback/ are in {asked.out} ({time.monotonic() - begun:.0f} s)")
    if waiting:
        print(f"{waiting} answers wait for a mark by hand: enter it in {asked.out / 'by_hand.csv'} and run this again")
    return 0


if __name__ == "__main__":
    sys.exit(main())
