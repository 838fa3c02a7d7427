"""What every assignment must do: who is right gets the points, who is wrong loses those of the slip."""

from hashlib import sha256
from importlib import import_module

import numpy as np

from grader import masters
from kinlib import DualQuaternion
from workbook import cells_of, judged_again, judged_by_heart, losses, reached, stubs

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
    the_same_for_all : tuple
        Checks whose numbers are nobody's own: laws that are proved with symbols, and the like.
    """

    by_hand = 0
    always: dict = {}  # noqa: RUF012
    pictures: tuple[str, ...] = ()
    the_same_for_all: tuple[str, ...] = ()

    def losses(self, changes: dict, **more):
        return losses(self.assignment, self.always | changes, without=self.pictures, **more)

    def test_numbers_that_were_handed_out_never_change(self):
        """Whatever becomes of kinlib: if this fails, mend the code, not the numbers below."""
        module = import_module(f"kinlib_assignments.{self.assignment}")
        drawn = {name: digest([getattr(module, name)(student) for student in STUDENTS]) for name in self.numbers}
        assert drawn == self.numbers

    def test_the_solution_gets_full_marks_as_teachers_grade(self, grade_as_teachers_do):
        result = grade_as_teachers_do(self.assignment, {}, "emmy")
        assert [mark for mark in result.marks if mark["mark"] not in (None, mark["points"])] == []
        assert sum(mark["points"] for mark in result.marks if mark["mark"] is None) == self.by_hand
        assert sum(mark["points"] for mark in result.marks) == 20
        assert result.seen == []

    def test_the_blank_copy_gets_nothing(self):
        found = losses(self.assignment, stubs(self.assignment), without=self.pictures)
        assert sum(loss.points for loss in found.values()) == 20 - self.by_hand

    def test_there_are_ten_slips_at_least(self):
        assert sum(slip[-1] is not None for slip in self.slips.values()) >= 10

    def test_a_slip_is_told_below_the_answer_and_costs_its_points(self, slip):
        changes, points, said = self.slips[slip]
        found = self.losses(changes, only=reached(self.assignment, changes), judge=judged_again)
        assert {name: loss.points for name, loss in found.items()} == points, found
        first = next(iter(found.values()))
        assert first.seen == (said is not None), first
        assert (said or "with other numbers than yours") in first.said

    def test_what_is_right_passes_all_checks_in_one_process(self):
        assert self.losses({}) == {}

    def test_another_way_keeps_all_points(self):
        assert self.losses(self.another_way) == {}

    def test_who_knows_the_answers_to_his_own_numbers_only_gets_nothing(self):
        """The checks that he sees pass, the hidden ones do not."""
        found = self.losses({}, judge=judged_by_heart)
        assert [loss for loss in found.values() if loss.seen or "with other numbers than yours" not in loss.said] == []
        asked = {
            masters.name_of(cell)
            for cell in cells_of(self.assignment)
            if masters.about(cell).get("grade") and "on_other_numbers" in cell.source
        }
        assert asked - set(found) == set(self.the_same_for_all)


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
