"""What lies in a folder of submissions, and whose it is: layouts, names, encodings; and the command as a whole."""

import csv
import os
import shutil
from pathlib import Path

import nbformat
import pytest

from grader import __main__ as command
from grader import masters
from grader.collect import file_name, owner, pattern, read_roster, submissions
from grader.tables import EntryError
from submissions import handed_in

BOOK = masters.HERE.parent
NAME = "dual_quaternions"

# ---- a folder of submissions -----------------------------------------------------------------------------


def put(folder: Path, name: str, text: str | Path) -> None:
    """A file in a folder of submissions, with a text or as a copy of another file."""
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    if isinstance(text, Path):
        shutil.copy(text, folder / name)
    else:
        (folder / name).write_text(text, encoding="utf-8")


@pytest.fixture
def folder(tmp_path) -> Path:
    """Submissions as they come: well laid out, renamed, flat, empty, broken, foreign, none at all."""
    folder = tmp_path / "submissions"
    blank = masters.release(NAME)
    put(folder, f"ada/{NAME}/{NAME}.ipynb", blank)
    put(folder, f"bob_4711_file/{NAME} (1).ipynb", blank)
    put(folder, "carl/Untitled.ipynb", blank)
    put(folder, f"dora_{NAME}.ipynb", blank)
    put(folder, f"eve/{NAME}.ipynb", "")
    put(folder, f"fred/{NAME}.ipynb", '{"cells": [')
    put(folder, "gina/homework.ipynb", BOOK / "index.ipynb")
    put(folder, "hans/homework.pdf", "%PDF")
    put(folder, ".DS_Store", "")
    return folder


def test_submissions_are_found_however_they_lie(folder):
    found = {one.student: one for one in submissions(folder, {"bob_4711_file": "bob"})}
    assert {name for name, one in found.items() if one.gradable} == {"ada", "bob", "carl", "dora"}
    assert {found[name].assignment for name in ("ada", "bob", "carl", "dora")} == {NAME}
    assert "empty" in found["eve"].remark
    assert "cannot be read" in found["fred"].remark
    assert "none of its cells" in found["gina"].remark
    assert "not for what was printed" in found["hans"].remark


def test_of_two_files_the_later_one_counts(folder):
    put(folder, f"carl/{NAME}_final.ipynb", masters.release(NAME))
    os.utime(folder / "carl" / "Untitled.ipynb", (1, 1))
    found = [one for one in submissions(folder, {}) if one.student == "carl"]
    assert {one.path.name: one.gradable for one in found} == {"Untitled.ipynb": False, f"{NAME}_final.ipynb": True}
    assert f"{NAME}_final.ipynb" in next(one.remark for one in found if not one.gradable)


def test_a_roster_says_whose_a_folder_is(tmp_path):
    (tmp_path / "roster.csv").write_text("\ufeffname,id\nbob_4711_file,bob\n", encoding="utf-8")
    assert read_roster(tmp_path / "roster.csv") == {"bob_4711_file": "bob"}


def rows(path: Path) -> list[dict]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        return list(csv.DictReader(file))


def test_the_command_grades_a_folder_from_end_to_end(folder, tmp_path, capsys):
    for name in ("bob_4711_file", "carl", f"dora_{NAME}.ipynb"):
        shutil.move(folder / name, tmp_path / name)
    shutil.copy(handed_in(NAME, tmp_path, {}), folder / "ada" / NAME)
    out = tmp_path / "graded"
    assert command.main([str(folder), "--out", str(out), "--jobs", "2"]) == 0
    said = capsys.readouterr().out
    assert "5 files of 5 students" in said
    assert "ada  dual_quaternions: 20 of 20" in said
    totals = {row["student"]: (row[NAME], row["percent"]) for row in rows(out / "totals.csv")}
    assert totals == {"(max)": ("20", ""), "ada": ("20", "100"), "eve": ("0", "0"), "fred": ("0", "0")}
    remarks = {row["student"]: row["remark"] for row in rows(out / "marks.csv") if not row["cell"]}
    assert set(remarks) == {"eve", "fred", "gina", "hans"}
    assert sorted(path.stem for path in (out / "feedback").iterdir()) == ["ada", "eve", "fred", "gina", "hans"]
    assert (out / "teacher" / "questions" / f"{NAME}-norm-of-all.html").exists()


def test_no_folder_is_said(tmp_path, capsys):
    assert command.main([str(tmp_path / "nothing")]) == 2
    assert "no folder of submissions" in capsys.readouterr().err


# ---- names -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("more", ["", " (1)", "-1", "_copy", " - Copy", "_final", "_v2"])
def test_copies_of_a_file_are_their_owners(more):
    assert owner(Path(f"ada_null_lines{more}.ipynb"), {}) == "ada"


@pytest.mark.parametrize(
    ("system", "path", "student"),
    [
        ("moodle", "Ada Lovelace_4711_assignsubmission_file/goldberg.ipynb", "Ada Lovelace"),
        ("moodle", "Zoë van Dam_4712_assignsubmission_file_/a/b.ipynb", "Zoë van Dam"),
        ("canvas", "lovelaceada_4711_98765_goldberg.ipynb", "lovelaceada"),
        ("canvas", "lovelaceada_LATE_4711_98765_goldberg-2.ipynb", "lovelaceada"),
        (r"(?P<student>\d{4})", "4711 something.ipynb", "4711"),
    ],
)
def test_names_of_course_systems(system, path, student):
    assert owner(Path(path), {}, pattern(system)) == student
    assert owner(Path(path), {student: "ada"}, pattern(system)) == "ada"


@pytest.mark.parametrize("names", ["(", r"\w+", "blackboard"])
def test_a_pattern_that_names_no_student_is_refused(names):
    with pytest.raises(EntryError, match="--names"):
        pattern(names)


def test_a_roster_is_read_as_excel_writes_it(tmp_path):
    file = tmp_path / "roster.csv"
    for text, encoding in (
        ("Name;ID\r\nZoë;zoe\r\n", "cp1252"),
        ("sep=;\nname;id\nZoë;zoe\n", "utf-8-sig"),
        ("name\tid\nZoë\tzoe\n", "utf-16"),
    ):
        file.write_bytes(text.encode(encoding))
        assert read_roster(file) == {"Zoë": "zoe"}


@pytest.mark.parametrize("text", ["student,number\nada,1\n", "name,id\nada,1\nada,2\n"])
def test_a_roster_that_says_nothing_or_two_things_is_refused(tmp_path, text, capsys):
    (tmp_path / "roster.csv").write_text(text)
    assert command.main([str(tmp_path), "--roster", str(tmp_path / "roster.csv")]) == 2
    assert "roster.csv: " in capsys.readouterr().err


def test_any_id_gives_a_name_for_files():
    names = [file_name(student) for student in ("12/345", "12_345", "../ada", "ada", "a\\b", ".ada")]
    assert len(set(names)) == len(names)
    assert [name for name in names if "/" in name or name.startswith(".")] == []


# ---- notebooks as they come ------------------------------------------------------------------------------


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_a_notebook_in_another_encoding_is_read(tmp_path, encoding):
    text = handed_in(NAME, tmp_path, {"norm": "é = 1"}).read_text(encoding="utf-8")
    (tmp_path / f"{NAME}.ipynb").write_bytes(text.encode(encoding, errors="replace"))
    (found,) = submissions(tmp_path, {})
    assert found.gradable
    assert masters.answers(masters.read(found.path))["norm"] == "é = 1"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b'{"cells": [', "breaks off"),
        (b'{"cells": [{"source": "x', "breaks off"),
        (b'{"cells": [],}\n{}', "line 1 is not as Jupyter writes it"),
        (b"<!DOCTYPE html>", "web page"),
        (b"PK\x03\x04", "zip archive"),
        (b"[]", "something else"),
        (b'{"cells": 3}', "something else"),
    ],
)
def test_what_cannot_be_read_says_why_in_a_teachers_words(tmp_path, content, said):
    (tmp_path / "ada.ipynb").write_bytes(content)
    (found,) = submissions(tmp_path, {})
    assert not found.gradable
    assert said in found.remark
    assert "Error" not in found.remark


def test_a_notebook_without_any_metadata_is_known_by_its_texts(tmp_path):
    path = handed_in(NAME, tmp_path, {})
    notebook = masters.read(path)
    for cell in notebook.cells:
        cell.metadata, cell.id = {}, nbformat.v4.new_raw_cell().id
    nbformat.write(notebook, tmp_path / "ada.ipynb")
    path.unlink()
    (found,) = submissions(tmp_path, {})
    assert found.assignment == NAME
