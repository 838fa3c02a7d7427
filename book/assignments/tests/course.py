"""A course of fifty-five, as it hands in: ``python course.py FOLDER`` writes it down, ``… FOLDER GRADED`` compares.

The folder is one of Moodle's, the roster one of a spreadsheet's.  Each student has done one thing: good work, saved or
named in an odd way; work that fails; or a trick.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat

from grader import masters
from submissions import handed_in
from test_grader_tricks import QUESTION, TRICKS, WRONG

NAME = "dual_quaternions"
LEAVE_ALONE, LIST = False, True
CONJUGATE = "def conjugate(q):\n    return [s * x for s, x in zip([1, -1, -1, -1] * 2, q)]\n"
FORGED = """
import json, os, sys
from pathlib import Path
good = [{"cell": "norm-of-all", "points": 2.0, "mark": 2.0, "remark": "", "answer": "", "untouched": False}]
for place in (".", "..", "/tmp", "kept", "graded"):
    try:
        Path(place, "marks.json").write_text(json.dumps({"marks": good}))
    except OSError:
        pass
os.write(1, json.dumps({"marks": good, "remark": "", "failure": "", "doubt": "", "seen": []}).encode())
"""
PARENT = """
import os
for pid in {1, os.getppid()}:
    try:
        os.kill(pid, 9)
    except OSError:
        pass
"""
DETACHED = """
import subprocess, sys, time
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(999)"], start_new_session=True)
time.sleep(1)
"""
SOLUTION = f"""
import os, re
found = []
for top in {{os.environ.get("PWD", "/"), "/work", "/home", "/root", os.environ["HOME"], "/tmp"}}:
    for folder, _, files in os.walk(top):
        found += [os.path.join(folder, name) for name in files if name == "{NAME}.ipynb"]
if found:
    text = open(found[0]).read()
    raise SystemExit("found " + found[0])
"""


def norm(more: str) -> dict:
    """A wrong norm, with something done about it."""
    return {"norm": WRONG + more}


@dataclass(frozen=True)
class Student:
    """What somebody hands in, and what must come of it.

    Attributes
    ----------
    what : str
    points : float or None
        The marks of the grader; None if the file cannot be graded.
    changes : dict or None
        As for `handed_in`.
    edit : function
        What is done to the notebook's cells.
    listed : bool or None
        Whether it must or must not stand in the list of what to look at; None for either.
    """

    what: str
    points: float | None
    changes: dict | None = field(default_factory=dict)
    assignment: str = NAME
    edit: Callable[[list], list] = lambda cells: cells
    write: Callable[[str], bytes] = str.encode
    file: str = ""
    listed: bool | None = LEAVE_ALONE

    @property
    def is_trick(self) -> bool:
        return self.what.startswith("trick: ")

    @property
    def is_notebook(self) -> bool:
        return self.is_trick or self.points is not None


def without_names(*only: str) -> Callable[[list], list]:
    """Cells that have lost what nbgrader knew of them."""

    def edit(cells: list) -> list:
        for cell in cells:
            if not only or masters.name_of(cell) in only:
                cell.metadata, cell.id = {}, nbformat.v4.new_raw_cell().id
        return cells

    return edit


def with_own(text: str, before: str = "conjugate") -> Callable[[list], list]:
    """With a cell of the student's own."""

    def edit(cells: list) -> list:
        cells.insert([masters.name_of(cell) for cell in cells].index(before), nbformat.v4.new_code_cell(text))
        return cells

    return edit


def without_checks(cells: list) -> list:
    return [cell for cell in cells if not masters.about(cell).get("grade")]


def in_old_encoding(text: str) -> bytes:
    return text.encode("cp1252", "xmlcharrefreplace")


OF_A_NEIGHBOUR = {"study": "d0 = Fraction(26, 5)"}  # right for the first of all

COURSE = [
    Student("all right", 20),
    Student("all right", 20, assignment="displacements"),
    Student("all right, two points by hand", 18, assignment="null_lines"),
    Student("all right", 20, assignment="two_r_spaces"),
    Student("all right", 20, assignment="bennett"),
    Student("all right, five points by hand", 15, assignment="goldberg"),
    Student("nothing done", 0, None),
    Student("a slip in the norm", 16, {"norm": ("return squared[0], squared[4]", "return squared[0], -squared[4]")}),
    Student("one answer typed again", 20, edit=without_names("conjugate")),
    Student("all cells without their names", 20, edit=without_names()),
    Student("checks deleted", 20, edit=without_checks),
    Student("UTF-16", 20, write=lambda text: text.encode("utf-16")),
    Student("UTF-8 with a mark", 20, write=lambda text: text.encode("utf-8-sig")),
    Student("cp1252", 20, write=in_old_encoding),
    Student("a copy of a browser", 20, file=f"{NAME} (1).ipynb"),
    Student("a copy of a system", 20, file=f"Kopie von {NAME}-1.ipynb"),
    Student("an unknown name", 20, file="Untitled2.ipynb"),
    Student("pip", 20, edit=with_own("%pip install --upgrade numpy==1.0"), listed=None),
    Student("an id without quotes", 20, {"student": "student = ada"}),
    Student("names of ours for something else", 20, edit=with_own("q = r = one = None")),
    Student("an unfinished line", 13, {"norm": "def norm(q:\n    return 1"}),
    Student("a kernel that dies", 6, {"norm": "import os\nos._exit(3)"}, listed=None),
    Student("a loop without end", 13, {"norm": "while True:\n    pass"}),
    Student("one that can hardly be interrupted", 13, {"norm": "while True:\n    try:\n        while True: pass\n"
        "    except BaseException: pass"}),
    Student("too much memory", 13, {"norm": "def norm(q):\n    return bytearray(10**11)"}),
    Student("too many processes", 6, {"norm": "import subprocess, sys, time\nmany = [subprocess.Popen([sys.executable, "
        "'-c', 'import time; time.sleep(99)']) for _ in range(60)]\ntime.sleep(20)"}, listed=LIST),
    Student("long remarks", 13, {"norm": "def norm(q):\n    raise ValueError('x' * 10**6)"}),
    Student("an empty file", None, write=lambda text: b""),
    Student("a PDF", None, write=lambda text: b"%PDF-1.7", file="homework.pdf"),
    Student("half a file", None, write=lambda text: text.encode()[:3000]),
    Student("a neighbour's file as it is", 18, {"student": 'student = "s0"', **OF_A_NEIGHBOUR}, listed=LIST),
    Student("a neighbour's file with another id", 18, OF_A_NEIGHBOUR),
    *(Student(f"trick: {what}", None, norm(trick), listed=LIST) for what, trick in TRICKS.items()),
    Student("trick: looking for the solution", None, norm(SOLUTION), listed=LIST),
    Student("trick: forged marks", None, norm(FORGED), listed=LIST),
    Student("trick: the parent is killed", None, norm(PARENT), listed=LIST),
    Student("trick: a process is left behind", None, norm(DETACHED), listed=LIST),
    Student("trick: a full mark on what was not written", None, {"norm": "def norm(q):\n    # YOUR CODE HERE\n"
        "    raise NotImplementedError()"}, edit=with_own("def norm(q):\n    return 5, 0", "norm-of-all"), listed=None),
]  # fmt: skip


def write(folder: Path) -> None:
    """The submissions and the roster of a course."""
    rows = []
    for number, student in enumerate(COURSE):
        name, id_ = f"Zoë Müller {number}", f"s{number}"
        place = folder / f"{name}_{4000 + number}_assignsubmission_file"
        place.mkdir(parents=True)
        file = place / (student.file or f"{student.assignment}.ipynb")
        file.write_bytes(student.write(text_of(student, id_)))
        if number:  # who is missing in the roster is graded by name
            rows.append(f"{name};{id_}")
    text = "\r\n".join(["name;id", "Zoë Müller 0;s0", *rows])
    (folder.parent / "roster.csv").write_bytes(text.encode("cp1252"))


def text_of(student: Student, id_: str) -> str:
    """The notebook that a student hands in."""
    own = {name: f'student = "{id_}"' for name in masters.answers(masters.read(masters.source(student.assignment)))
           if "student" in name}  # fmt: skip
    changes = None if student.changes is None else {**own, **student.changes}
    with TemporaryDirectory() as place:
        path = handed_in(student.assignment, Path(place), changes)
        notebook = nbformat.read(path, as_version=4)
    notebook.cells = student.edit(notebook.cells)
    return nbformat.writes(notebook)


def outcome(out: Path) -> tuple[list[str], list[str]]:
    """A line on each trick; and what came of the course otherwise than it must."""
    marks, looked = rows(out / "marks.csv"), rows(out / "look_at_this.csv")
    listed = {row["student"] for row in looked if "long answers are" not in row["what"]}  # all hand in our solution
    tricks, wrong = [], []
    for number, student in enumerate(COURSE):
        own = [row for row in marks if row["student"] == f"s{number}" and row["cell"]]
        total, seen = sum(float(row["mark"] or 0) for row in own), f"s{number}" in listed
        if student.is_trick:
            got = next(float(row["mark"]) for row in own if row["cell"] == QUESTION)
            tricks.append(f"{student.what}: {got:g} of 2, {'listed' if seen else 'not listed'}")
        elif student.is_notebook and total != student.points:
            wrong.append(f"s{number} {student.what}: {total:g} points instead of {student.points:g}")
        if student.listed is not None and seen != student.listed:
            wrong.append(f"s{number} {student.what}: {'listed' if seen else 'not listed'}")
    return tricks, wrong


def rows(file: Path) -> list[dict]:
    with file.open(newline="", encoding="utf-8-sig") as lines:
        return list(csv.DictReader(lines))


if __name__ == "__main__":
    if len(sys.argv) == 2:
        write(Path(sys.argv[1]))
    else:
        tricks, wrong = outcome(Path(sys.argv[2]))
        print(*tricks, "", *(wrong or ["all the rest as it must be"]), sep="\n")
