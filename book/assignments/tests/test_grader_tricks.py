"""Marks for nothing: each trick gives none, or shows in the list of what is to be looked at."""

import nbformat
import pytest

from grader import look, masters, one, run
from grader.collect import Submission
from submissions import handed_in

NAME = "dual_quaternions"
QUESTION = "norm-of-all"  # the notebook is run up to here
WRONG = "def norm(q):\n    return 5, 0\n"  # loses the marks of norm-of-all

# What is written in the cell of the norm: the answer is wrong, and something is done about it.
TRICKS = {
    "a check is replaced": "import kinlib_assignments.checks as c\nc.assert_equal = lambda *a, **k: None",
    "a check's code is replaced": (
        "from kinlib_assignments.dual_quaternions import check_norm\n"
        "check_norm.__code__ = (lambda *a, **k: None).__code__"
    ),
    "an assertion error that is never raised": (
        "import kinlib_assignments.checks as c\nclass AssertionError(Exception): pass\nc._agree = lambda *a: True"
    ),
    "asserts are taken out of the text": (
        "import ast\nclass Out(ast.NodeTransformer):\n    def visit_Expr(self, node): return ast.Pass()\n"
        "get_ipython().ast_transformers.append(Out())"
    ),
    "the input is emptied": "get_ipython().input_transformers_cleanup.append(lambda lines: ['pass\\n'])",
    "something is called after each cell": (
        "def after(*given): pass\nget_ipython().events.register('post_run_cell', after)"
    ),
    "cells are no longer run": (
        "shell = get_ipython()\nrun = shell.run_cell\nshell.run_cell = lambda text, *a, **k: run('pass', *a, **k)"
    ),
    "kinlib says that all is zero": "import kinlib_assignments.checks as c\nc.is_zero = lambda *a, **k: True",
    "objects are equal to everything": (
        "class Any(int):\n    def __sub__(self, other): return 0\n    __rsub__ = __sub__\n"
        "    def __eq__(self, other): return True\n    __hash__ = None\ndef norm(q):\n    return Any(1), Any(2)"
    ),
    "the class of dual quaternions is changed": (
        "from kinlib import DualQuaternion\nDualQuaternion.inverse = lambda self: self"
    ),
    "what is withheld is copied": (
        "from types import FunctionType\nfrom kinlib import DualQuaternion\n"
        "n, m = DualQuaternion.norm, DualQuaternion.__mul__\nmine = FunctionType(n.__code__, n.__globals__)\n"
        "def norm(q):\n    return tuple(mine(DualQuaternion(q)).coeffs[[0, 4]])"
    ),
    "what is withheld is imported a second time": (
        "import sys, importlib\nkept = {n: sys.modules.pop(n) for n in [*sys.modules] if n.split('.')[0] == 'kinlib'}\n"
        "again = importlib.import_module('kinlib').DualQuaternion\nsys.modules.update(kept)\n"
        "def norm(q):\n    return tuple(int(x) for x in again(q).norm().coeffs[[0, 4]])"
    ),
    "another program uses kinlib": (
        "import subprocess, sys, json\ndef norm(q):\n    text = f'import kinlib; n = kinlib.DualQuaternion({list(q)})"
        ".norm().coeffs; print([int(n[0]), int(n[4])])'\n"
        "    return json.loads(subprocess.run([sys.executable, '-c', text], capture_output=True, text=True).stdout)"
    ),
    "what looks for replaced checks is replaced with them, and all is put back": (
        "import kinlib_assignments.seal as s\nfrom kinlib_assignments import dual_quaternions as e\n"
        "kept = s.assert_untouched, e.check_norm\n"
        "def fake(norm, student):\n    if student == s.OTHERS[-1]:\n"
        "        s.assert_untouched, e.check_norm = kept\n"
        "s.assert_untouched, e.check_norm = (lambda: None), fake"
    ),
    "the id is set in the environment": "import os\nos.environ['KINLIB_STUDENT'] = 'emmy'",
    "the function for the id is replaced": (
        "import kinlib_assignments\nkinlib_assignments.student_id = lambda name: 'emmy'"
    ),
    "the test's own right answer is looked up": (
        "import inspect\ndef norm(q):\n    frame = inspect.currentframe().f_back\n"
        "    return frame.f_globals.get('right', (5, 0))"
    ),
    "an answer is built by name": "globals()['no' + 'rm_'] = 1\nsetattr(norm, 'x', 1)",
}


SEEN_BY_THE_KERNEL = {
    "a check is replaced",
    "a check's code is replaced",
    "what looks for replaced checks is replaced with them, and all is put back",
    "asserts are taken out of the text",
    "the input is emptied",
    "cells are no longer run",
    "something is called after each cell",
    "the class of dual quaternions is changed",
    "the id is set in the environment",
}
WITHOUT_MARKS = {
    "a check is replaced",
    "a check's code is replaced",
    "what looks for replaced checks is replaced with them, and all is put back",
    "the class of dual quaternions is changed",
}
NOT_RUN = {"asserts are taken out of the text", "the input is emptied", "cells are no longer run"}


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("trick", TRICKS)
def test_a_trick_gives_nothing_or_is_seen(trick, tmp_path):
    """What the kernel tells of is seen even if its text is hidden, and a check that was not run has no points."""
    text = TRICKS[trick]
    if trick in SEEN_BY_THE_KERNEL:
        text = f"exec(bytes({list(text.encode())}).decode())"
    submission = Submission("ada", handed_in(NAME, tmp_path, {"norm": WRONG + text}), NAME)
    result = run.marked(submission, run.Limits(cell=10), QUESTION)
    assert not result.failed, result.remark
    mark = next(mark for mark in result.marks if mark["cell"] == QUESTION)
    assert result.seen if trick in SEEN_BY_THE_KERNEL else look.findings([result]), mark
    if trick in WITHOUT_MARKS:
        assert (mark["mark"], bool(mark["remark"])) == (0, True)
    if trick in NOT_RUN:
        assert (mark["mark"], "did not run to its end" in mark["remark"]) == (0, True)


@pytest.mark.parametrize(
    ("first", "last", "what"),
    [
        ({"kinlib": "a"}, {"kinlib": "a"}, ""),
        ({"kinlib": "a"}, {"kinlib": "b"}, "kinlib"),
        ({"IPython": "a"}, {"IPython": "b"}, ""),  # who changes that may have good reasons: it is only listed
        ({"kinlib": "a"}, {"kinlib": "a", "kinlib.pictures": "b"}, ""),  # imported later
    ],
)
def test_only_what_the_checks_need_costs_marks(first, last, what):
    said = [{"refuses": True, "parts": parts} for parts in (first, last)]
    assert one.replaced(*said) == what
    assert one.replaced(said[0], {**said[1], "refuses": False}) == "the checks"
    assert one.replaced(said[0], {}) == one.replaced({}, said[1]) == ""  # a kernel that did not answer is listed


@pytest.mark.parametrize(
    ("text", "others"),
    [
        ("student = 'ada'", []),
        ('student = " ADA "  # me', []),
        ('student = ""', []),
        ('student = "emmy"', ["emmy"]),
        ("student = 'emmy'\nstudent = \"ada\"\nstudent = 'sophus'", ["emmy", "sophus"]),
        ('the_student = "emmy"', []),
    ],
)
def test_ids_that_are_not_the_graded_one(text, others):
    id_cell = nbformat.v4.new_code_cell(text, metadata={"nbgrader": {"solution": True, "grade_id": "student"}})
    of_the_task = nbformat.v4.new_code_cell('student = "nobody"')
    notebook = nbformat.v4.new_notebook(cells=[of_the_task, id_cell])
    assert look.other_ids(notebook, "ada") == others


def test_a_neighbours_file_is_seen_as_it_is_and_with_another_id(tmp_path):
    path = handed_in(NAME, tmp_path, {"student": 'student = "emmy"'})
    answers = masters.answers(masters.read(path))
    mark = {"points": 2.0, "mark": 2.0, "remark": "", "untouched": False}
    marks = [{**mark, "cell": name, "answer": f"{text}\nown = {[*range(50)]}"} for name, text in answers.items()]
    pair = [run.Result(Submission(name, path, NAME), marks) for name in ("ada", "emmy")]
    said = [finding.what for finding in look.findings(pair)]
    assert "the id that is written is 'emmy'" in said
    assert [words for words in said if "equal to those of emmy" in words]


def test_in_a_kernel_that_starts_from_nothing_a_replaced_check_is_seen_too(tmp_path):
    code = (
        "from kinlib_assignments.dual_quaternions import check_norm\ncheck_norm.__code__ = (lambda *a: None).__code__"
    )
    submission = Submission("ada", handed_in(NAME, tmp_path, {"norm": WRONG + code}), NAME)
    assert [said for said in run.marked(submission, run.Limits()).seen if "kinlib_assignments" in said]
