"""A grader of submissions: of many, whose kernels start at once, or of some, the way teachers go."""

import pytest

import warm_kernels
from grader import box, one, run
from grader.collect import Submission
from submissions import handed_in

pytest.register_assert_rewrite("marks")  # so that its failures show both sides


@pytest.fixture
def grade_as_teachers_do(tmp_path):
    """Grades a submission in processes of its own: ``grade_as_teachers_do(assignment, changes, student)``."""

    def grade(assignment: str, changes: dict | None = None, student: str = "ada") -> run.Result:
        path = handed_in(assignment, tmp_path, changes)
        return run.graded(Submission(student, path, assignment), run.Limits(), tmp_path / "kept")

    return grade


@pytest.fixture(scope="session")
def warm():
    """The process that kernels are forked from."""
    warm_kernels.prepare()


@pytest.fixture
def quick(warm, monkeypatch):
    """The grader, but it works in this process, and its kernels are forked from one that has imported everything.

    Each submission has a kernel of its own as before, but no box and no limit of memory.
    """

    monkeypatch.setattr(run, "run", lambda order, seconds: one.carry_out(order))
    monkeypatch.setattr(box, "bubblewrap", lambda: None)
    monkeypatch.setattr("jupyter_client.provisioning.local_provisioner.launch_kernel", warm_kernels.launch)


@pytest.fixture
def grade(quick, grade_as_teachers_do):
    """Grades a submission: ``grade(assignment, changes, student)``."""
    return grade_as_teachers_do


@pytest.fixture
def lost(grade):
    """The points that a submission loses, by cell; what a person marks is left out."""

    def of(assignment: str, changes: dict | None = None, student: str = "ada") -> dict[str, float]:
        result = grade(assignment, changes, student)
        assert not result.remark, result.remark
        losses = {m["cell"]: m["points"] - m["mark"] for m in result.marks if m["mark"] is not None}
        return {cell: points for cell, points in losses.items() if points}

    return of


def pytest_generate_tests(metafunc):
    """One test for each slip that is listed for an assignment."""
    if "slip" in metafunc.fixturenames:
        metafunc.parametrize("slip", metafunc.cls.slips)
