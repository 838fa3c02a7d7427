"""The students' copies: in step with the solved notebooks, without a trace of the solutions."""

import re

import pytest

from grader import masters
from release import assignments, generate


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The copies, made anew."""
    folder = tmp_path_factory.mktemp("release")
    generate(assignments(), folder)
    return folder


def test_there_are_six():
    assert len(assignments()) == 6


@pytest.mark.parametrize("name", assignments())
def test_copies_are_in_step(made, name):
    """If this fails, run `make assignments`."""
    assert (made / name / f"{name}.ipynb").read_text() == masters.release(name).read_text()


@pytest.mark.parametrize("name", assignments())
def test_copies_hold_no_solution(name):
    solved, blank = masters.read(masters.source(name)), masters.read(masters.release(name))
    text = masters.release(name).read_text(encoding="utf-8")
    assert not re.search("BEGIN SOLUTION|END SOLUTION|HIDDEN TESTS", text)
    assert all(not cell.get("outputs") for cell in blank.cells)
    for answer in masters.answers(solved).values():
        for secret in re.findall("### BEGIN SOLUTION\n(.*?)### END SOLUTION", answer, re.DOTALL):
            long_lines = [line.strip() for line in secret.splitlines() if len(line.strip()) > 30]
            assert [line for line in long_lines if line in text] == []


@pytest.mark.parametrize("name", assignments())
def test_each_code_cell_has_a_part(name):
    notebook = masters.read(masters.source(name))
    assert [cell.source for cell in notebook.cells if cell.cell_type == "code" and not masters.name_of(cell)] == []
    names = [masters.name_of(cell) for cell in notebook.cells if masters.name_of(cell)]
    assert len(names) == len(set(names))
    assert sum(masters.about(cell).get("points", 0) for cell in notebook.cells) == 20


@pytest.mark.parametrize("name", assignments())
def test_each_mark_hangs_on_hidden_tests(name):
    """Whoever only satisfies the checks that he sees gets nothing for it."""
    for cell in masters.read(masters.source(name)).cells:
        if masters.about(cell).get("grade") and not masters.about(cell).get("solution"):
            assert "### BEGIN HIDDEN TESTS" in cell.source, masters.name_of(cell)
