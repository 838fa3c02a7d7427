"""What every assignment must do: who is right gets the points, who is wrong loses those of the slip."""

from hashlib import sha256
from importlib import import_module

import numpy as np
import pytest

from kinlib import DualQuaternion
from workbook import losses

STUDENTS = ("ada", "emmy", "sophus", "4711", "student 1")


class Marks:
    """The tests of one assignment; a subclass names it, the slips and another way to be right.

    Attributes
    ----------
    assignment : str
    numbers : dict
        What the functions that draw numbers gave to some students when they were handed out: `digest` of it.
    slips : dict
        What is done wrong: the changed cells, the points lost by cell, and what the first check that fails says to the
        student; nothing (None) if only other numbers than the student's own find it out.
    another_way : dict
        The cells of a right answer that looks quite different.
    by_hand : float
        The points that a person gives.
    always : dict
        Cells that are changed in every slip.
    pictures : tuple
        Cells that draw; they take time and have no points.
    """

    by_hand = 0
    always: dict = {}  # noqa: RUF012
    pictures: tuple[str, ...] = ()

    def test_numbers_that_were_handed_out_never_change(self):
        """Whatever becomes of kinlib: if this fails, mend the code, not the numbers below."""
        module = import_module(f"kinlib_assignments.{self.assignment}")
        drawn = {name: digest([getattr(module, name)(student) for student in STUDENTS]) for name in self.numbers}
        assert drawn == self.numbers

    @pytest.mark.parametrize("student", ["ada", "sophus"])
    def test_the_solution_gets_full_marks(self, grade, student):
        self.assert_full(grade(self.assignment, {}, student).marks)

    def test_the_solution_gets_full_marks_as_teachers_grade(self, grade_as_teachers_do):
        result = grade_as_teachers_do(self.assignment, {}, "emmy")
        self.assert_full(result.marks)
        assert result.seen == []

    def assert_full(self, marks):
        assert [mark for mark in marks if mark["mark"] not in (None, mark["points"])] == []
        assert sum(mark["points"] for mark in marks if mark["mark"] is None) == self.by_hand

    def test_the_blank_copy_gets_nothing(self, grade):
        marks = grade(self.assignment).marks
        assert sum(mark["points"] for mark in marks) == 20
        assert [mark["mark"] for mark in marks] == [0] * len(marks)

    def test_there_are_ten_slips_at_least(self):
        assert sum(slip[-1] is not None for slip in self.slips.values()) >= 10

    def test_a_slip_is_told_below_the_answer_and_costs_its_points(self, slip):
        changes, points, said = self.slips[slip]
        found = losses(self.assignment, self.always | changes, without=self.pictures)
        assert {name: loss.points for name, loss in found.items()} == points, found
        first = next(iter(found.values()))
        assert first.seen == (said is not None), first
        assert (said or "with other numbers than yours") in first.said

    @pytest.mark.parametrize("student", ["ada", "emmy"])
    def test_what_is_right_passes_all_checks_in_one_process(self, student):
        always = self.always if student == "ada" else {}  # it is an answer of hers
        without = self.pictures if always or not self.always else ()
        assert losses(self.assignment, always, student, without) == {}

    def test_another_way_keeps_all_points(self, lost):
        assert lost(self.assignment, self.another_way) == {}


def digest(drawn) -> str:
    """The first digits of the SHA-256 of what was drawn, written as text."""
    return sha256(written(drawn).encode()).hexdigest()[:16]


def written(drawn) -> str:
    """Numbers as text, whatever they are kept in.

    Examples
    --------
    >>> written({"A": (1, None), "B": DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0])})
    '(A:(1,None),B:(1,0,0,0,0,0,0,0))'
    """
    if isinstance(drawn, DualQuaternion):
        drawn = drawn.coeffs
    if isinstance(drawn, dict):
        return "(" + ",".join(f"{name}:{written(one)}" for name, one in drawn.items()) + ")"
    if isinstance(drawn, (list, tuple, np.ndarray)):
        return "(" + ",".join(map(written, drawn)) + ")"
    return str(drawn)
