"""Where submissions run: what they see, what they can change, and what the machine's own failures do."""

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from grader import __main__ as command
from grader import box, masters, one, remarks, run
from grader.collect import Submission
from grader.run import Limits, Result, graded_all, marked
from submissions import handed_in

NAME = "dual_quaternions"
CONJUGATE = "def conjugate(q):\n    return [q[0], -q[1], -q[2], -q[3], q[4], -q[5], -q[6], -q[7]]"


SPY = """
import json, os, socket, subprocess, sys, time
from pathlib import Path
import kinlib, kinlib_assignments

def can(what):
    try:
        return bool(what())
    except Exception:
        return False

def writes(path):
    return can(lambda: Path(path, "spy").write_text("x"))

packages = [os.path.dirname(module.__file__) for module in (kinlib, kinlib_assignments)]
found = {
    "reads": [path for path in FILES if can(lambda: open(path, "rb").read(1))],
    "writes": list(filter(writes, [*map(os.path.dirname, FILES), *packages, sys.prefix, "/", "/usr", "/dev", "/etc"])),
    "at home": writes("."),
    "processes": len([pid for pid in os.listdir("/proc") if pid.isdigit()]),
    "net": can(lambda: socket.create_connection(("127.0.0.1", PORT), 2)),
    "secret": os.environ.get("A_SECRET"),
    "dry": os.environ["PIP_DRY_RUN"],
}
for above in {1, os.getppid()}:
    can(lambda: os.kill(above, 9))
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(LEFT)"], start_new_session=True)
time.sleep(1)
raise ValueError(json.dumps(found))
"""
LEFT = 1234.5 + os.getpid() / 1e6  # how long the process sleeps that it leaves behind, to know it again


@pytest.fixture(scope="module")
def spied(tmp_path_factory) -> Result:
    """What comes of a submission that looks around, tries to write everywhere and leaves a process behind."""
    folder = tmp_path_factory.mktemp("spied")
    files = [masters.source(NAME), Path(run.__file__), masters.HERE.parents[1] / "README.md", folder / f"{NAME}.ipynb"]
    with socket.create_server(("127.0.0.1", 0)) as server, pytest.MonkeyPatch.context() as patch:
        patch.setenv("A_SECRET", "of the teacher")
        spy = SPY.replace("FILES", repr([*map(str, files)])).replace("PORT", str(server.getsockname()[1]))
        path = handed_in(NAME, folder, {"counterexample": spy.replace("LEFT", str(LEFT))})
        return marked(Submission("ada", path, NAME), Limits())


@pytest.fixture
def boxed():
    if not box.bubblewrap():
        pytest.skip("bubblewrap is not installed")


def found_by(result: Result) -> dict:
    said = next(mark["remark"] for mark in result.marks if mark["cell"] == "not-a-law")
    return json.loads(said[said.index("{") :])


@pytest.mark.usefixtures("boxed")
def test_a_submission_sees_and_changes_nothing_but_its_own(spied):
    found = found_by(spied)
    kept = [path for path in found["writes"] if not path.startswith("/tmp/") or Path(path, "spy").exists()]
    assert (found["reads"], kept, found["at home"]) == ([], [], True)  # its /tmp is its own, and gone afterwards
    assert found["processes"] <= 4
    assert (found["net"], found["secret"], found["dry"]) == (False, None, "1")


@pytest.mark.usefixtures("boxed")
def test_what_it_leaves_behind_is_ended_and_seen(spied):
    assert [p for p in psutil.process_iter(["cmdline"]) if str(LEFT) in " ".join(p.info["cmdline"] or [])] == []
    assert [said for said in spied.seen if "processes of its own" in said]
    assert sum(mark["mark"] for mark in spied.marks) == 19


def test_the_environment_and_what_is_graded_are_the_same(spied):
    """Kernels import the very files whose digest tells whether something has changed."""
    assert {path.parent for path in run.programs()} >= set(run.PACKAGES.values())
    assert set(run.PACKAGES) == {"kinlib", "kinlib_assignments"}


def test_without_a_box_it_is_said(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(box, "bubblewrap", lambda: None)
    tmp_path.joinpath("submissions").mkdir()
    command.main([str(tmp_path / "submissions"), "--out", str(tmp_path / "graded")])
    assert "bubblewrap is not here" in capsys.readouterr().out.splitlines()[0]


def test_pip_changes_nothing_even_without_a_box(tmp_path):
    order = run.order_for(Submission("ada", tmp_path / "x.ipynb", NAME), Limits(), tmp_path, boxed=False)
    assert order["surroundings"]["PIP_DRY_RUN"] == "1"
    assert sorted(path.name for path in (tmp_path / "packages").iterdir()) == ["kinlib", "kinlib_assignments"]


def test_a_detached_process_is_ended_without_a_box_too(tmp_path, monkeypatch):
    monkeypatch.setattr(box, "bubblewrap", lambda: None)
    environment = {**os.environ, "HOME": str(tmp_path / "home")}
    command = [sys.executable, "-c", "import time; time.sleep(100)"]
    with subprocess.Popen(command, env=environment, start_new_session=True) as left:
        run.end_leftovers(tmp_path)
        assert left.wait(10) != 0


# ---- limits ----------------------------------------------------------------------------------------------

FULL = """
import subprocess, sys, time
product_ = product
many = [subprocess.Popen([sys.executable, "-c", "import time; time.sleep(100)"]) for _ in range(60)]
time.sleep(20)
"""


@pytest.mark.parametrize(
    ("greedy", "said"),
    [
        (FULL, remarks.TOO_MANY),
        ("import numpy as np, time\nall = [np.ones(10**7) for _ in range(30)]\ntime.sleep(20)", remarks.TOO_LARGE),
    ],
)
def test_too_many_processes_and_too_much_memory_end_the_kernel(tmp_path, greedy, said):
    path = handed_in(NAME, tmp_path, {"norm": greedy})
    limits = Limits(megabytes=1500) if said == remarks.TOO_LARGE else Limits()
    result = marked(Submission("ada", path, NAME), limits)
    found = {mark["cell"]: mark for mark in result.marks}
    assert (found["conjugate-of-all"]["mark"], found["norm-of-all"]["mark"]) == (1, 0)
    assert said in found["norm-of-all"]["remark"]
    assert result.doubt == ""


TALKING = "def norm(q):\n    for _ in range(30):\n        print('x' * 100_000, flush=True)\n    return "


@pytest.mark.usefixtures("quick")
def test_what_a_cell_prints_is_limited_and_costs_nothing(tmp_path):
    right = TALKING + "[sum(q[n] ** 2 for n in range(4)), 2 * sum(q[n] * q[n + 4] for n in range(4))]"
    result = marked(Submission("ada", handed_in(NAME, tmp_path, {"norm": right}), NAME), Limits(), "norm-of-all")
    assert {mark["cell"]: mark["mark"] for mark in result.marks}["norm-of-all"] == 2
    assert result.doubt == ""


@pytest.mark.usefixtures("quick")
def test_what_is_printed_too_late_is_a_failure_of_the_machine(tmp_path, monkeypatch):
    """It is no mark, and above all not the end of all marks."""
    monkeypatch.setattr(one, "PATIENCE", 0)
    path = handed_in(NAME, tmp_path, {"norm": TALKING + "1, 2"})
    result = marked(Submission("ada", path, NAME), Limits(), "norm-of-all")
    assert "expected" in {mark["cell"]: mark["remark"] for mark in result.marks}["norm-of-all"]
    assert result.doubt == remarks.LOADED


# ---- what the machine does wrong -------------------------------------------------------------------------


class Machine:
    """Answers in place of the grading process, one after the other."""

    def __init__(self, *answers):
        self.answers, self.asked = list(answers), 0

    def __call__(self, order, seconds):
        self.asked += 1
        return self.answers.pop(0)


GOOD = {
    "marks": [{"cell": "norm-of-all", "points": 2.0, "mark": 2.0, "remark": "", "answer": "", "untouched": False}],
    "remark": "",
    "failure": "",
    "doubt": "",
    "seen": [],
}
ZERO = {**GOOD, "marks": [{**GOOD["marks"][0], "mark": 0.0}]}


@pytest.fixture
def grade_with(monkeypatch, tmp_path):
    """Grades one file while the machine answers in some way; gives the results and the lines that were said."""

    def grade(*answers) -> tuple[Result, list[str], Machine]:
        machine, lines = Machine(*answers), []
        monkeypatch.setattr(run, "run", machine)
        one = Submission("ada", handed_in(NAME, tmp_path, None), NAME)
        return graded_all([one], Limits(), tmp_path / "kept", 1, lines.append)[0], lines, machine

    return grade


FAILURE = {"failure": "RuntimeError: Kernel died before replying to kernel_info"}


@pytest.mark.parametrize("first", [FAILURE, {**ZERO, "doubt": remarks.LOADED}, {**ZERO, "doubt": "died"}, {}, [], None])
def test_a_failure_of_the_machine_is_tried_again(grade_with, first):
    result, lines, machine = grade_with(first, GOOD)
    assert (result.marks[0]["mark"], result.failed, machine.asked) == (2, False, 2)
    assert len(lines) == 2


@pytest.mark.parametrize("twice", [FAILURE, {**ZERO, "doubt": remarks.LOADED}])
def test_a_failure_of_the_machine_is_no_mark_and_not_kept(grade_with, tmp_path, twice):
    result, lines, _ = grade_with(twice, twice)
    assert (result.marks, result.failed) == ([], True)
    assert "give the command again" in lines[-1]
    result, _, machine = grade_with(GOOD)
    assert (result.marks[0]["mark"], machine.asked) == (2, 1)


def test_a_kernel_that_dies_twice_was_ended_by_the_notebook(grade_with):
    result, _, _ = grade_with(*[{**ZERO, "doubt": "died"}] * 2)
    assert (result.marks[0]["mark"], result.failed) == (0, False)


MALFORMED = [{**GOOD, "marks": "20"}, {**GOOD, "marks": [{**GOOD["marks"][0], "mark": 1000.0}]}, {**GOOD, "marks": [7]}]


@pytest.mark.parametrize("marks", MALFORMED)
def test_marks_that_are_none_end_nothing(grade_with, marks):
    result, _, _ = grade_with(marks, marks)
    assert result.failed


@pytest.mark.parametrize("text", ["", "{", "[]", '{"digest": 1}', '{"marks": [{"mark": 20}]}'])
def test_what_was_kept_and_cannot_be_read_is_made_again(grade_with, tmp_path, text):
    grade_with(GOOD)
    (tmp_path / "kept" / "ada" / f"{NAME}.json").write_text(text)
    result, _, machine = grade_with(GOOD)
    assert (result.marks[0]["mark"], machine.asked) == (2, 1)


def test_a_kernel_that_does_not_start_is_a_failure(tmp_path, monkeypatch):
    def without_python(*given):
        return ["/bin/false"]

    monkeypatch.setattr(box, "around", without_python)
    monkeypatch.setattr(box, "bubblewrap", lambda: "/bin/false")
    one_ = Submission("ada", handed_in(NAME, tmp_path, None), NAME)
    (tmp_path / "place").mkdir()
    answer = one.carry_out(run.order_for(one_, Limits(), tmp_path / "place", boxed=True) | {"question": None})
    assert answer["failure"]
    assert answer["marks"] == []
