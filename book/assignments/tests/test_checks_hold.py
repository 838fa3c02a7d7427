"""Whoever is right keeps the marks in spite of a slip of form; who replaces a check, or what it needs, gets none."""

import nbformat
import pytest

from grader import masters
from grader.collect import Submission
from grader.run import Limits, marked
from submissions import handed_in

NAME = "dual_quaternions"
WRONG = {"conjugate": "def conjugate(q):\n    return q"}


@pytest.fixture
def lost(quick, tmp_path):
    """The points that a submission loses, with a cell of the student's own before an answer."""

    def of(changes: dict, own: str = "", before: str = "conjugate") -> dict[str, float]:
        path = handed_in(NAME, tmp_path, changes)
        notebook = nbformat.read(path, as_version=4)
        place = [masters.name_of(cell) for cell in notebook.cells].index(before)
        notebook.cells.insert(place, nbformat.v4.new_code_cell(own or "pass"))
        nbformat.write(notebook, path)
        result = marked(Submission("ada", path, NAME), Limits())
        assert not result.remark, result.remark
        return {mark["cell"]: mark["points"] - mark["mark"] for mark in result.marks if mark["mark"] != mark["points"]}

    return of


BY_ANOTHER_NAME = """
def reversal_defect(q, r):
    return [x - y for x, y in zip(conjugate(mul(q, r)), mul(conjugate(r), conjugate(q)))]
"""

# ---- right work ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "own"),
    [
        ({}, "q = r = [1, 0, 0, 0, 0, 0, 0, 0]\none = None"),
        ({"student": "student = ada"}, "pass"),
        ({"student": "student = ['a', 'list']"}, "pass"),
        ({"reversal_defect": BY_ANOTHER_NAME}, "mul = product"),
    ],
    ids=["own cells that use our names", "an id without quotes", "an id that is none", "a function by another name"],
)
def test_a_slip_of_form_costs_nothing(lost, changes, own):
    assert lost(changes, own, "conjugate") == {}


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
def test_what_is_replaced_gives_no_marks(lost, trick):
    found = lost(WRONG, TRICKS[trick])
    assert found.get("conjugate-of-all") == 1, found


LAZY = """
class Pleasing(list):
    def __eq__(self, other): return True
    def __getitem__(self, n): return 0


def conjugate(q):
    return Pleasing(q)
"""


def test_what_equals_everything_gives_no_marks(lost):
    assert lost({"conjugate": LAZY})["conjugate-of-all"] == 1
