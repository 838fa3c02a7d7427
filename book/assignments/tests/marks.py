"""What every assignment must do: who is right gets the points, who is wrong loses those of the slip."""

import pytest


class Marks:
    """The tests of one assignment; a subclass names it, the slips and another way to be right.

    Attributes
    ----------
    assignment : str
    slips : dict
        What is done wrong: the changed cells, and the points lost by cell.
    another_way : dict
        The cells of a right answer that looks quite different.
    by_hand : float
        The points that a person gives.
    always : dict
        Cells that are changed in every slip.
    """

    by_hand = 0
    always: dict = {}  # noqa: RUF012

    @pytest.mark.parametrize("student", ["ada", "emmy", "sophus"])
    def test_the_solution_gets_full_marks(self, grade, student):
        marks = grade(self.assignment, {}, student).marks
        assert [mark for mark in marks if mark["mark"] not in (None, mark["points"])] == []
        assert sum(mark["points"] for mark in marks if mark["mark"] is None) == self.by_hand

    def test_the_blank_copy_gets_nothing(self, grade):
        marks = grade(self.assignment).marks
        assert sum(mark["points"] for mark in marks) == 20
        assert [mark["mark"] for mark in marks] == [0] * len(marks)

    def test_a_slip_costs_its_points(self, lost, slip):
        changes, points = self.slips[slip]
        assert lost(self.assignment, self.always | changes) == points

    def test_another_way_keeps_all_points(self, lost):
        assert lost(self.assignment, self.another_way) == {}
