"""The grader: nobody stops the others, nobody gets marks for nothing, nobody loses marks for form."""

import os
import shutil
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

import nbformat
import psutil
import pytest

from grader import masters
from grader.collect import Submission
from grader.run import Limits, graded, keep, marked
from kinlib_assignments import dual_quaternions as exercise
from submissions import handed_in

NAME = "dual_quaternions"
SPIN = "while True:\n    pass"
SPINNING = "import time\n\n\ndef inverse(q):\n    while True:\n        time.sleep(0.01)"


def marks(path: Path, student: str = "ada", question: str | None = None, **limits: int) -> dict[str, dict]:
    result = marked(Submission(student, path, NAME), Limits(**limits), question)
    assert not result.remark, result.remark
    return {mark["cell"]: mark for mark in result.marks}


def lost(path: Path, student: str = "ada", question: str | None = None) -> dict[str, float]:
    """The points that a submission loses, by cell; up to a question, if one is named."""
    found = marks(path, student, question)
    return {name: mark["points"] - mark["mark"] for name, mark in found.items() if mark["mark"] != mark["points"]}


def edited(path: Path, edit) -> Path:
    """A notebook with its list of cells changed in place."""
    notebook = nbformat.read(path, as_version=4)
    notebook.cells = edit(notebook.cells)
    nbformat.write(notebook, path)
    return path


# ---- what students do to notebooks -----------------------------------------------------------------------


@pytest.mark.usefixtures("quick")
def test_tests_that_were_deleted_emptied_or_made_powerless_are_run_all_the_same(tmp_path):
    fake = "check_norm = check_exact_inverse = assert_equal = withheld = lambda *given, **named: None"

    def without_tests(cells):
        kept = [cell for cell in cells if masters.name_of(cell) != "norm-of-all"]
        for cell in kept:
            if masters.about(cell).get("grade"):
                cell.source = "pass"
        return [part for cell in kept for part in (nbformat.v4.new_code_cell(fake), cell)]

    wrong = {"norm": ("return squared[0], squared[4]", "return squared[0], -squared[4]")}
    path = edited(handed_in(NAME, tmp_path, wrong), without_tests)
    assert lost(path) == {"norm-of-all": 2, "inverse-exact": 2}


@pytest.mark.usefixtures("quick")
def test_cells_of_ones_own_are_kept_in_their_place_and_a_warning_costs_nothing(tmp_path):
    def with_helper(cells):
        place = [masters.name_of(cell) for cell in cells].index("conjugate")
        cells.insert(place, nbformat.v4.new_code_cell("import warnings\n\nsigns = [1, -1, -1, -1] * 2"))
        cells.insert(place, nbformat.v4.new_markdown_cell("I keep the signs in a list."))
        return cells

    own = "def conjugate(q):\n    warnings.warn('look out')\n    return [s * x for s, x in zip(signs, q)]"
    path = edited(handed_in(NAME, tmp_path, {"conjugate": own}), with_helper)
    assert lost(path) == {}


@pytest.mark.usefixtures("quick")
def test_a_neighbours_id_gives_no_marks_for_his_numbers(tmp_path):
    number = "(root,) = [-Fraction(q[1] * q[5] + q[2] * q[6] + q[3] * q[7], q[0])]\nd0 = root"
    computed = handed_in(NAME, tmp_path, {"student": 'student = "emmy"', "study": number})
    assert lost(computed, "ada", "study-quadric") == {}
    copied = handed_in(NAME, tmp_path, {"student": 'student = "emmy"', "study": f"d0 = Fraction({of_emmy()})"})
    assert lost(copied, "ada", "study-quadric") == {"study-quadric": 2}
    assert lost(copied, "emmy", "study-quadric") == {}


def of_emmy() -> str:
    p0, p1, p2, p3, _, d1, d2, d3 = exercise.data("emmy").q
    value = -Fraction(p1 * d1 + p2 * d2 + p3 * d3, p0)
    return f"{value.numerator}, {value.denominator}"


# ---- what would stop the others --------------------------------------------------------------------------


@pytest.mark.usefixtures("quick")
def test_what_never_ends_is_named_and_costs_itself_and_what_needs_it(tmp_path):
    path = handed_in(NAME, tmp_path, {"counterexample": SPIN, "inverse": SPINNING})
    found = marks(path, cell=5)
    assert [name for name, mark in found.items() if mark["mark"] == 0] == [
        "not-a-law",
        "inverse-exact",
        "inverse-missing",
    ]
    assert found["inverse-exact"] == {
        "cell": "inverse-exact",
        "points": 2,
        "mark": 0,
        "remark": "took longer than 5 s, so it was stopped",
        "answer": SPINNING,
        "untouched": False,
    }


def test_what_cannot_be_interrupted_is_killed(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    stubborn = "import time\nwhile True:\n    try:\n        time.sleep(1)\n    except BaseException:\n        pass"
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


# ---- what is kept ----------------------------------------------------------------------------------------


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
    path = handed_in(NAME, tmp_path, wrong)
    (tmp_path / "submitted" / "ada" / NAME).mkdir(parents=True)
    shutil.copy(path, tmp_path / "submitted" / "ada" / NAME)
    settings = Config()
    settings.CourseDirectory.root = str(tmp_path)
    api = NbGraderAPI(config=settings)
    assert api.generate_assignment(NAME)["success"]
    assert api.autograde(NAME, "ada")["success"]
    with Gradebook(f"sqlite:///{tmp_path}/gradebook.db") as book:
        theirs = {grade.name: grade.score for grade in book.find_submission_notebook(NAME, NAME, "ada").grades}
    assert {name: mark["mark"] for name, mark in marks(path).items()} == theirs
    assert sum(theirs.values()) == 16
