"""Whoever is right keeps the marks in spite of a slip of form; who replaces a check, or what it needs, gets none."""

import nbformat
import pytest

from grader import masters
from grader.collect import Submission
from grader.run import Limits, marked
from submissions import handed_in
from workbook import losses, solved

NAME = "dual_quaternions"
QUESTION = "conjugate-of-all"
WRONG = {"conjugate": "def conjugate(q):\n    return q"}


@pytest.fixture
def points(quick, tmp_path):
    """The points for the conjugate, with a cell of the student's own before it."""

    def of(changes: dict, own: str = "pass") -> float:
        path = handed_in(NAME, tmp_path, changes)
        notebook = nbformat.read(path, as_version=4)
        place = [masters.name_of(cell) for cell in notebook.cells].index("conjugate")
        notebook.cells.insert(place, nbformat.v4.new_code_cell(own))
        nbformat.write(notebook, path)
        result = marked(Submission("ada", path, NAME), Limits(), QUESTION)
        assert not result.remark, result.remark
        return {mark["cell"]: mark["mark"] for mark in result.marks}[QUESTION]

    return of


# ---- right work ------------------------------------------------------------------------------------------

BY_ANOTHER_NAME = """
mul = product


def reversal_defect(q, r):
    return [x - y for x, y in zip(conjugate(mul(q, r)), mul(conjugate(r), conjugate(q)))]
"""
FORMS = {
    "own cells that use our names": {"norm": "q = r = [1, 0, 0, 0, 0, 0, 0, 0]\none = None\n\n" + solved(NAME)["norm"]},
    "an id without quotes": {"student": "student = ada"},
    "an id that is none": {"student": "student = ['a', 'list']"},
    "a function by another name": {"reversal_defect": BY_ANOTHER_NAME},
}


@pytest.mark.parametrize("form", FORMS)
def test_a_slip_of_form_costs_nothing(form, monkeypatch):
    monkeypatch.setenv("KINLIB_STUDENT", "ada")  # as the grader has it
    assert losses(NAME, FORMS[form], without=("picture",)) == {}


# ---- tricks ----------------------------------------------------------------------------------------------

TRICKS = {
    "a check is replaced": "import kinlib_assignments.dual_quaternions as e\ne.check_conjugate = lambda *given: None",
    "all checks are": "import kinlib_assignments.dual_quaternions as e\n"
    "for name in e.__all__:\n    setattr(e, name, lambda *given: None)",
    "their code is": "import kinlib_assignments.dual_quaternions as e\n"
    "e.check_conjugate.__code__ = (lambda conjugate, student: None).__code__",
    "what they call is": "import kinlib_assignments.dual_quaternions as e\n"
    "e.assert_equal = lambda *given, **named: None",
    "the id is": "import kinlib_assignments\nkinlib_assignments.student_id = lambda *given: 'emmy'",
    "Python is": "import builtins\nbuiltins.all = lambda things: True",
}


@pytest.mark.parametrize("trick", TRICKS)
def test_what_is_replaced_gives_no_marks(points, trick):
    assert points(WRONG, TRICKS[trick]) == 0


def test_without_a_trick_there_are_marks(points):
    assert points({}) == 1


LAZY = """
class Pleasing(list):
    def __eq__(self, other): return True
    def __getitem__(self, n): return 0


def conjugate(q):
    return Pleasing(q)
"""


def test_what_equals_everything_gives_no_marks():
    assert losses(NAME, {"conjugate": LAZY}, only={QUESTION})[QUESTION].points == 1
