"""The submissions in a folder, however they lie there."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

from grader import masters

NOT_A_NOTEBOOK = "{name} is not a notebook"
BROKEN = "{name} cannot be read as a notebook ({why})"
FOREIGN = "{name} is not a notebook of these assignments: none of its cells is known"
TWICE = "handed in more than once; the file changed last was graded: {name}"


@dataclass(frozen=True)
class Submission:
    """A file that somebody handed in; without an assignment, a file that is none."""

    student: str
    path: Path
    assignment: str | None
    remark: str = ""

    @property
    def gradable(self) -> bool:
        return self.assignment is not None and not self.remark


def submissions(folder: Path, roster: dict[str, str]) -> list[Submission]:
    """What lies in a folder: ``student/any/folders/file`` or ``student_assignment.ipynb``, one for each assignment.

    A notebook is known by its cells, whatever it is called; the student by the folder or the file's name, which the
    roster translates into an id.
    """
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and not is_hidden(path.relative_to(folder))]
    return latest([looked_at(path, owner(path.relative_to(folder), roster)) for path in files])


def file_name(student: str) -> str:
    """A name for a student's files, whatever the id is made of.

    Examples
    --------
    >>> file_name("ada"), file_name("12/345")
    ('ada', '12_345-7c5b')
    """
    plain = re.sub(r"[^\w.@ -]|^\.+", "_", student)
    return plain if plain == student else f"{plain}-{sha256(student.encode()).hexdigest()[:4]}"


def is_hidden(path: Path) -> bool:
    return any(part.startswith((".", "__MACOSX")) for part in path.parts)


def read_roster(path: Path | None) -> dict[str, str]:
    """Names of folders or files, and the ids they stand for, from a CSV file with the columns name and id."""
    if path is None:
        return {}
    with path.open(newline="", encoding="utf-8-sig") as file:
        return {row["name"]: row["id"] for row in csv.DictReader(file)}


def owner(path: Path, roster: dict[str, str]) -> str:
    """Whose file it is."""
    name = path.parts[0] if len(path.parts) > 1 else trimmed(path.stem)
    return roster.get(name, name)


def trimmed(stem: str) -> str:
    """A file's name without that of the assignment."""
    for assignment in masters.ASSIGNMENTS:
        if assignment in stem:
            return stem.replace(assignment, "").strip("_- ") or stem
    return stem


def looked_at(path: Path, student: str) -> Submission:
    """A file with the assignment that it belongs to, or with what is wrong with it."""
    named = next((name for name in masters.ASSIGNMENTS if name in path.stem), None)
    if path.suffix != ".ipynb":
        return Submission(student, path, None, NOT_A_NOTEBOOK.format(name=path.name))
    if not path.read_bytes().strip():
        return Submission(student, path, named, f"{path.name} is empty")
    try:
        known = masters.names(masters.read(path))
    except Exception as error:  # whatever a file can do to the reader of notebooks
        why = f"{type(error).__name__}: {error}".splitlines()[0][:120]
        return Submission(student, path, named, BROKEN.format(name=path.name, why=why))
    shared = {name: len(known & cells_of(name)) for name in masters.ASSIGNMENTS}
    best = max(shared, key=shared.get)
    if not shared[best]:
        return Submission(student, path, named, FOREIGN.format(name=path.name))
    return Submission(student, path, best)


@cache
def cells_of(assignment: str) -> frozenset[str]:
    """The names of the cells of an assignment."""
    return frozenset(masters.names(masters.read(masters.release(assignment))))


def latest(found: list[Submission]) -> list[Submission]:
    """Of the files of one student for one assignment, the readable one changed last; the others with a remark."""
    chosen: dict[tuple, Submission] = {}
    for one in sorted(found, key=lambda s: (s.gradable, s.path.stat().st_mtime)):
        if one.assignment:
            chosen[one.student, one.assignment] = one
    passed_over = {
        one.path: Submission(
            one.student, one.path, None, TWICE.format(name=chosen[one.student, one.assignment].path.name)
        )
        for one in found
        if one.assignment and chosen[one.student, one.assignment] is not one
    }
    return sorted((passed_over.get(one.path, one) for one in found), key=lambda s: (s.student, str(s.assignment)))
