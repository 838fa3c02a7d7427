"""Answers that have lost their names are found again, and the first cause of an error is told."""

import nbformat
import pytest

from grader import masters, remarks
from grader.collect import Submission
from grader.run import Limits, marked
from submissions import handed_in

NAME = "dual_quaternions"


def given(cells, assignment: str = NAME) -> dict[str, str]:
    """The answers that the grader finds among some cells."""
    master, blank = masters.read(masters.source(assignment)), masters.read(masters.release(assignment))
    return masters.answers(masters.assembled(master, blank, nbformat.v4.new_notebook(cells=cells)))


def solved(folder, assignment: str = NAME):
    return masters.read(handed_in(assignment, folder, {})).cells


def retyped(cell, **named):
    make = nbformat.v4.new_code_cell if cell.cell_type == "code" else nbformat.v4.new_markdown_cell
    return make(cell.source, **named)


@pytest.mark.parametrize("assignment", masters.ASSIGNMENTS)
def test_each_answer_is_found_when_its_cell_is_typed_again(tmp_path, assignment):
    cells = solved(tmp_path, assignment)
    right = given(cells, assignment)
    for number, cell in enumerate(cells):
        if masters.is_answer(cell):
            assert given([*cells[:number], retyped(cell), *cells[number + 1 :]], assignment) == right


@pytest.mark.parametrize("assignment", masters.ASSIGNMENTS)
def test_all_answers_are_found_when_all_metadata_is_gone(tmp_path, assignment):
    cells = solved(tmp_path, assignment)
    right = given(cells, assignment)
    assert given([retyped(cell) for cell in cells], assignment) == right
    assert given([retyped(cell, id=cell.id) for cell in cells], assignment) == right


def test_answers_are_found_among_own_cells_and_without_the_text_around(tmp_path):
    cells = solved(tmp_path)
    right = given(cells)
    tries = [nbformat.v4.new_code_cell(f"trial_{n} = {n}") for n in range(len(cells))]
    mixed = [part for pair in zip(tries, map(retyped, cells), strict=True) for part in pair]
    assert given(mixed) == right
    assert given([retyped(cell) for cell in cells if masters.is_answer(cell)]) == right


def test_of_two_tries_without_a_name_the_last_counts(tmp_path):
    cells = solved(tmp_path)
    place = [masters.name_of(cell) for cell in cells].index("norm")
    first, last = (nbformat.v4.new_code_cell(f"def norm(q):\n    return {n}, 0") for n in (1, 2))
    assert given([*cells[:place], first, last, *cells[place + 1 :]])["norm"] == last.source


def test_a_cell_whose_metadata_is_nonsense_is_read(tmp_path):
    cells = solved(tmp_path)
    right = given(cells)
    for cell in cells[5:9]:
        cell.metadata = {"nbgrader": 7}
    assert given(cells) == right


@pytest.mark.usefixtures("quick")
def test_the_first_cause_is_told_and_cut_to_length(tmp_path):
    long = "def norm(q):\n    raise ValueError('x' * 100_000)"
    changes = {"product": "def product(q, r)\n    return q", "norm": long}
    result = marked(Submission("ada", handed_in(NAME, tmp_path, changes), NAME), Limits())
    said = {mark["cell"]: mark["remark"] for mark in result.marks}
    for name in ("product-of-yours", "product-for-all", "reversal-law"):
        assert said[name].startswith("the answer above did not run to its end: SyntaxError: expected ':'")
    assert len(said["norm-of-all"]) == remarks.LONGEST
