"""The grader: nobody stops the others, nobody gets marks for nothing, nobody loses marks for form."""

import csv
import os
import shutil
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

import nbformat
import psutil
import pytest

from grader import __main__ as command
from grader import masters, report
from grader.collect import Submission, read_roster, submissions
from grader.run import Limits, Result, graded, keep, marked
from kinlib_assignments import dual_quaternions as exercise
from submissions import handed_in

BOOK = masters.HERE.parent
NAME = "dual_quaternions"
SPIN = "while True:\n    pass"
SPINNING = "def inverse(q):\n    while True:\n        pass"


def marks(path: Path, student: str = "ada", **limits: int) -> dict[str, dict]:
    result = marked(Submission(student, path, NAME), Limits(**limits))
    assert not result.remark, result.remark
    return {mark["cell"]: mark for mark in result.marks}


def lost(path: Path, student: str = "ada") -> dict[str, float]:
    return {name: m["points"] - m["mark"] for name, m in marks(path, student).items() if m["mark"] != m["points"]}


def edited(path: Path, edit) -> Path:
    """A notebook with its list of cells changed in place."""
    notebook = nbformat.read(path, as_version=4)
    notebook.cells = edit(notebook.cells)
    nbformat.write(notebook, path)
    return path


# ---- what students do to notebooks -----------------------------------------------------------------------


@pytest.mark.usefixtures("quick")
def test_tests_that_were_deleted_or_emptied_are_run_all_the_same(tmp_path):
    def without_tests(cells):
        kept = [cell for cell in cells if masters.name_of(cell) != "norm-of-all"]
        for cell in kept:
            if masters.about(cell).get("grade"):
                cell.source = "pass"
        return kept

    wrong = {"norm": ("return squared[0], squared[4]", "return squared[0], -squared[4]")}
    path = edited(handed_in(NAME, tmp_path, wrong), without_tests)
    assert lost(path) == {"norm-of-all": 2, "inverse-exact": 2}


@pytest.mark.usefixtures("quick")
def test_checks_that_were_redefined_are_imported_again(tmp_path):
    fake = "assert_equal = assert_product = assert_norm = withheld = lambda *given, **named: None"

    def with_fakes(cells):
        return [part for cell in cells for part in (nbformat.v4.new_code_cell(fake), cell)]

    path = edited(handed_in(NAME, tmp_path, {"conjugate": "def conjugate(q):\n    return q"}), with_fakes)
    assert "conjugate-of-all" in lost(path)


@pytest.mark.usefixtures("quick")
def test_cells_of_ones_own_are_kept_in_their_place(tmp_path):
    def with_helper(cells):
        place = [masters.name_of(cell) for cell in cells].index("conjugate")
        cells.insert(place, nbformat.v4.new_code_cell("signs = [1, -1, -1, -1] * 2"))
        cells.insert(place, nbformat.v4.new_markdown_cell("I keep the signs in a list."))
        return cells

    own = "def conjugate(q):\n    return [s * x for s, x in zip(signs, q)]"
    path = edited(handed_in(NAME, tmp_path, {"conjugate": own}), with_helper)
    assert lost(path) == {}


@pytest.mark.usefixtures("quick")
def test_a_neighbours_id_gives_no_marks_for_his_numbers(tmp_path):
    number = "(root,) = [-Fraction(q[1] * q[5] + q[2] * q[6] + q[3] * q[7], q[0])]\nd0 = root"
    computed = handed_in(NAME, tmp_path, {"student": 'student = "emmy"', "study": number})
    assert lost(computed, "ada") == {}
    copied = handed_in(NAME, tmp_path, {"student": 'student = "emmy"', "study": f"d0 = Fraction({of_emmy()})"})
    assert lost(copied, "ada") == {"study-quadric": 2}
    assert lost(copied, "emmy") == {}


def of_emmy() -> str:
    p0, p1, p2, p3, _, d1, d2, d3 = exercise.data("emmy").q
    value = -Fraction(p1 * d1 + p2 * d2 + p3 * d3, p0)
    return f"{value.numerator}, {value.denominator}"


@pytest.mark.usefixtures("quick")
def test_a_warning_costs_nothing(tmp_path):
    warning = "import warnings\n\n\ndef conjugate(q):\n    warnings.warn('look out')\n"
    warning += "    return [s * x for s, x in zip([1, -1, -1, -1] * 2, q)]"
    assert lost(handed_in(NAME, tmp_path, {"conjugate": warning})) == {}


# ---- what would stop the others --------------------------------------------------------------------------


@pytest.mark.usefixtures("quick")
def test_a_cell_that_never_ends_costs_itself_and_what_needs_it(tmp_path):
    path = handed_in(NAME, tmp_path, {"counterexample": SPIN})
    found = marks(path, cell=5)
    assert [name for name, mark in found.items() if mark["mark"] == 0] == ["not-a-law"]


@pytest.mark.usefixtures("quick")
def test_a_function_that_never_ends_is_named(tmp_path):
    path = handed_in(NAME, tmp_path, {"inverse": SPINNING})
    found = marks(path, cell=5)
    assert found["inverse-exact"] == {
        "cell": "inverse-exact",
        "points": 2,
        "mark": 0,
        "remark": "took longer than 5 s, so it was stopped",
        "answer": SPINNING,
        "untouched": False,
    }
    assert found["moved-point"]["mark"] == 2


def test_what_cannot_be_interrupted_is_killed(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    stubborn = "while True:\n    try:\n        while True:\n            pass\n    except BaseException:\n        pass"
    path = handed_in(NAME, tmp_path, {"student": stubborn})
    found = marks(path, cell=3)
    assert {mark["mark"] for mark in found.values()} == {0}
    assert {mark["remark"][:11] for mark in found.values()} == {"was not run"}
    assert processes_below(tmp_path) == []


def test_a_notebook_that_takes_too_long_as_a_whole_is_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = handed_in(NAME, tmp_path, {"norm": "import time\ntime.sleep(1000)"})
    result = marked(Submission("ada", path, NAME), Limits(all=12))
    assert result.remark == "stopped after 12 s in all"
    assert [mark["mark"] for mark in result.marks] == [2, 1, 2, 1] + [0] * 8
    assert processes_below(tmp_path) == []


def processes_below(folder: Path) -> list[list[str]]:
    """The commands of the processes that have to do with a folder."""
    commands = [process.info["cmdline"] or [] for process in psutil.process_iter(["cmdline"])]
    return [command for command in commands if str(folder) in " ".join(command)]


def test_memory_is_limited(tmp_path):
    greedy = "def norm(q):\n    return bytearray(10**10)"
    found = marks(handed_in(NAME, tmp_path, {"norm": greedy}), megabytes=3000)
    assert found["norm-of-all"]["remark"] == "used more memory than there is"
    assert found["moved-point"]["mark"] == 2


@pytest.mark.usefixtures("quick")
def test_a_notebook_that_ends_python_keeps_what_came_before(tmp_path):
    path = handed_in(NAME, tmp_path, {"norm": "import os\nos._exit(3)"})
    found = marks(path)
    assert found["conjugate-of-all"]["mark"] == 1
    assert found["norm-of-all"]["mark"] == 0
    assert found["norm-of-all"]["remark"].startswith("was not run")
    assert found["moved-point"]["mark"] == 0


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
    assert "not a notebook" in found["hans"].remark


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
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_command_grades_a_folder_from_end_to_end(folder, tmp_path, capsys):
    for name in ("bob_4711_file", "carl"):
        shutil.rmtree(folder / name)
    shutil.copy(handed_in(NAME, tmp_path, {}), folder / "ada" / NAME)
    out = tmp_path / "graded"
    assert command.main([str(folder), "--out", str(out), "--jobs", "2"]) == 0
    said = capsys.readouterr().out
    assert "6 files of 6 students" in said
    assert "ada  dual_quaternions: 20 of 20" in said
    totals = {row["student"]: row[NAME] for row in rows(out / "totals.csv")}
    assert totals == {"ada": "20", "dora": "0", "eve": "0", "fred": "0"}
    remarks = {row["student"]: row["remark"] for row in rows(out / "marks.csv") if not row["cell"]}
    assert set(remarks) == {"eve", "fred", "gina", "hans"}
    assert sorted(path.stem for path in (out / "feedback").iterdir()) == ["ada", "dora", "eve", "fred", "gina", "hans"]


def test_no_folder_is_said(tmp_path, capsys):
    assert command.main([str(tmp_path / "nothing")]) == 2
    assert "no folder of submissions" in capsys.readouterr().err


# ---- marks by hand, and what is kept ---------------------------------------------------------------------

ANSWER = {"cell": "argument", "points": 5.0, "mark": None, "remark": "", "answer": "<script>alert(1)</script>"}


def waiting() -> list[Result]:
    return [Result(Submission("ada", Path("goldberg.ipynb"), "goldberg"), [dict(ANSWER)])]


def test_marks_by_hand_are_asked_for_once_and_taken_over(tmp_path):
    file = tmp_path / "by_hand.csv"
    assert report.with_marks_by_hand(waiting(), file)[0].marks[0]["mark"] is None
    asked = file.read_text(encoding="utf-8")
    assert "ada,goldberg,argument,5.0,," in asked
    filled = asked.replace(",", ";").replace(";5.0;;", ';4,5;4,5;"well; argued,\n- but long"')
    file.write_text(filled, encoding="utf-8-sig")
    mark = report.with_marks_by_hand(waiting(), file)[0].marks[0]
    assert (mark["mark"], mark["remark"], mark["marked"]) == (4.5, "well; argued,\n- but long", "hand")
    assert len(report.read(file)) == 1


def test_no_remark_is_a_formula(tmp_path):
    mark = {"cell": "norm", "points": 2.0, "mark": 0.0, "marked": "auto", "remark": "=1+1", "answer": ""}
    report.write_marks([Result(Submission("@ada", Path("x.ipynb"), "bennett"), [mark])], tmp_path / "marks.csv")
    assert (tmp_path / "marks.csv").read_text().splitlines()[1] == "'@ada,bennett,norm,2.0,0.0,auto,'=1+1"


@pytest.mark.parametrize("entered", ["6", "-1", "good"])
def test_a_mark_by_hand_that_cannot_be_is_refused(tmp_path, entered):
    file = tmp_path / "by_hand.csv"
    file.write_text(f"student,assignment,cell,points,mark,comment\nada,goldberg,argument,5,{entered},\n")
    with pytest.raises(ValueError, match="from 0 to 5 for ada, goldberg, argument"):
        report.with_marks_by_hand(waiting(), file)


def test_a_feedback_page_shows_answers_as_text(tmp_path):
    report.write_feedback(report.with_marks_by_hand(waiting(), tmp_path / "by_hand.csv"), tmp_path)
    page = (tmp_path / "ada.html").read_text(encoding="utf-8")
    assert "&lt;script&gt;" in page
    assert "<script>" not in page


@pytest.mark.usefixtures("quick")
def test_what_has_not_changed_is_not_run_again(tmp_path, monkeypatch):
    path = handed_in(NAME, tmp_path, None)
    one = Submission("ada", path, NAME)
    first = graded(one, Limits(), tmp_path / "kept")
    keep(first, Limits(), tmp_path / "kept")
    monkeypatch.setattr("grader.run.marked", lambda *given: pytest.fail("it was run again"))
    assert graded(one, Limits(), tmp_path / "kept") == first
    edited(path, lambda cells: cells[:-1])
    with pytest.raises(pytest.fail.Exception, match="run again"):
        graded(one, Limits(), tmp_path / "kept")


# ---- nbgrader itself -------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::sqlalchemy.exc.SAWarning")  # nbgrader's own
def test_nbgrader_alone_gives_the_same_marks(tmp_path, monkeypatch):
    from nbgrader.api import Gradebook
    from nbgrader.apps import NbGraderAPI
    from traitlets.config import Config

    monkeypatch.setenv("PATH", os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
    monkeypatch.setenv("KINLIB_STUDENT", "ada")
    shutil.copytree(masters.SOURCE / NAME, tmp_path / "source" / NAME)
    wrong = {"norm": ("return squared[0], squared[4]", "return squared[0], -squared[4]")}
    put(tmp_path, f"submitted/ada/{NAME}/{NAME}.ipynb", path := handed_in(NAME, tmp_path, wrong))
    settings = Config()
    settings.CourseDirectory.root = str(tmp_path)
    api = NbGraderAPI(config=settings)
    assert api.generate_assignment(NAME)["success"]
    assert api.autograde(NAME, "ada")["success"]
    with Gradebook(f"sqlite:///{tmp_path}/gradebook.db") as book:
        theirs = {grade.name: grade.score for grade in book.find_submission_notebook(NAME, NAME, "ada").grades}
    assert {name: mark["mark"] for name, mark in marks(path).items()} == theirs
    assert sum(theirs.values()) == 16
