"""The submissions in a folder, however they lie there."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

from nbformat import NotebookNode

from grader import masters, tables
from grader.matching import squeezed

NOT_A_NOTEBOOK = "{name} is not a notebook: {kind}"
EMPTY = "{name} is empty: the upload or the saving failed, ask for it again"
BROKEN = "{name} cannot be read as a notebook: {why}"
FOREIGN = "{name} is not a notebook of these assignments: none of its cells is known"
TWICE = "handed in more than once; the file changed last was graded: {name}"
KINDS = {
    ".zip": "it is a zip archive, unpack it",
    ".pdf": "ask for the file that ends in .ipynb, not for what was printed",
    ".html": "ask for the file that ends in .ipynb, not for the web page",
    ".py": "ask for the file that ends in .ipynb, not for what was exported",
}
COPY = re.compile(r"[\s_-]*(?:\(\d+\)|-\d+|-?\s*(?:copy|kopie|final|v\d+)(?:\s*\(\d+\))?)\s*$", re.IGNORECASE)
SYSTEMS = {
    "moodle": r"(?P<student>.+)_(?P<number>\d+)_assignsubmission_\w+$",
    "canvas": r"(?P<student>[^_]+)_(?:LATE_)?(?P<number>\d+)_\d+_.*",
}


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


def submissions(folder: Path, roster: dict[str, str], names: str | None = None) -> list[Submission]:
    """What lies in a folder: ``student/any/folders/file`` or ``student_assignment.ipynb``, one for each assignment.

    A notebook is known by its cells, whatever it is called; the student by the folder or the file's name, which the
    roster translates into an id.  A course system's names are read by a regular expression, see `pattern`.
    """
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and not is_hidden(path.relative_to(folder))]
    known = pattern(names)
    return latest([looked_at(path, owner(path.relative_to(folder), roster, known)) for path in files])


def pattern(names: str | None) -> re.Pattern | None:
    r"""A regular expression for the names of folders or files, by the name of a course system or written out.

    Raises
    ------
    EntryError
        If it is none, or has no group ``(?P<student>…)``.

    Examples
    --------
    >>> pattern("moodle").match("Ada Lovelace_4711_assignsubmission_file")["student"]
    'Ada Lovelace'
    >>> pattern("canvas").match("lovelaceada_LATE_12345_67890_goldberg-1.ipynb").groupdict()
    {'student': 'lovelaceada', 'number': '12345'}
    >>> pattern(r"(?P<student>\d+)-.*").match("4711-goldberg.ipynb")["student"]
    '4711'
    """
    if names is None:
        return None
    try:
        made = re.compile(SYSTEMS.get(names, names))
    except re.error as error:
        raise tables.EntryError(f"--names: {names!r} is no regular expression ({error})") from error
    if "student" not in made.groupindex:
        raise tables.EntryError(f"--names: {names!r} has no group (?P<student>…); or write {' or '.join(SYSTEMS)}")
    return made


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
    """Names of folders or files, and the ids they stand for, from a CSV file with the columns name and id.

    Raises
    ------
    EntryError
        If a column is missing, or one name has two ids.
    """
    rows = tables.read(path) if path else []
    if rows and not {"name", "id"} <= set(rows[0]):
        raise tables.EntryError(f"{path.name}: expected the columns name and id, got {', '.join(rows[0])}")
    roster: dict[str, str] = {}
    for row in rows:
        if roster.setdefault(row["name"], row["id"]) != row["id"]:
            raise tables.EntryError(f"{path.name}: {row['name']} has two ids, {roster[row['name']]} and {row['id']}")
    return roster


def owner(path: Path, roster: dict[str, str], known: re.Pattern | None = None) -> str:
    """Whose file it is: the roster's id for the whole name, or for what the pattern finds in it."""
    whole = path.parts[0]
    found = known.match(whole) if known else None
    name = found["student"] if found else whole if len(path.parts) > 1 else trimmed(path.stem)
    return roster.get(whole, roster.get(name, name)).strip()


def trimmed(stem: str) -> str:
    """A file's name without that of the assignment, and without what is added to copies.

    Examples
    --------
    >>> {trimmed(f"ada_goldberg{more}") for more in ("", " (1)", "-1", "_copy", " - Copy (2)", "_final")}
    {'ada'}
    >>> trimmed("goldberg_ada"), trimmed("4711"), trimmed("ada (2)")
    ('ada', '4711', 'ada')
    """
    for assignment in masters.ASSIGNMENTS:
        before, there, after = stem.partition(assignment)
        if there:
            name = (before if before.strip("_- ") else COPY.sub("", after)).strip("_- ")
            return name or stem
    return re.sub(r"\s*\(\d+\)$", "", stem)


def looked_at(path: Path, student: str) -> Submission:
    """A file with the assignment that it belongs to, or with what is wrong with it."""
    named = next((name for name in masters.ASSIGNMENTS if name in path.stem), None)
    if path.suffix.casefold() != ".ipynb":
        return Submission(student, path, None, NOT_A_NOTEBOOK.format(name=path.name, kind=kind_of(path)))
    if not path.read_bytes().strip():
        return Submission(student, path, named, EMPTY.format(name=path.name))
    try:
        notebook = masters.read(path)
        best = max(masters.ASSIGNMENTS, key=lambda name: likeness(notebook, name))
        alike = likeness(notebook, best)
    except Exception:  # whatever a file can do to the reader of notebooks
        return Submission(student, path, named, BROKEN.format(name=path.name, why=why(path)))
    if not alike:
        return Submission(student, path, named, FOREIGN.format(name=path.name))
    return Submission(student, path, best)


def kind_of(path: Path) -> str:
    """What a file is that is no notebook, and what to ask for."""
    return KINDS.get(path.suffix.casefold(), "ask for the file that ends in .ipynb")


def why(path: Path) -> str:
    """What is wrong with a notebook, in a teacher's words."""
    text = path.read_bytes()
    if text.lstrip()[:9].lower().startswith((b"<!doctype", b"<html")):
        return "it is a web page, probably saved from a browser: ask for the notebook itself"
    if text[:2] == b"PK":
        return "it is a zip archive: unpack it"
    try:
        json.loads(tables.decoded(text))
    except json.JSONDecodeError as error:
        if error.pos >= len(error.doc.rstrip()) - 1 or error.msg.startswith("Unterminated"):
            return "it breaks off in the middle: ask for it again"
        return f"line {error.lineno} is not as Jupyter writes it; was it edited by hand?"
    return "it holds something else than a notebook does: ask for the file as Jupyter saves it"


def likeness(notebook: NotebookNode, assignment: str) -> float:
    """How many cells of a notebook are an assignment's: by their names, else by their texts."""
    texts = {squeezed(cell.source) for cell in notebook.cells}
    return 10 * len(masters.names(notebook) & cells_of(assignment)) + len(texts & texts_of(assignment))


@cache
def texts_of(assignment: str) -> frozenset[str]:
    """The texts of the cells of an assignment that no other has."""
    mine, *others = (
        {squeezed(cell.source) for cell in masters.read(masters.release(name)).cells if len(squeezed(cell.source)) > 40}
        for name in (assignment, *(other for other in masters.ASSIGNMENTS if other != assignment))
    )
    return frozenset(mine.difference(*others))


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
