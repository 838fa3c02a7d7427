"""What the assignments share: numbers of one's own, withheld answers, checks that say what is wrong."""

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
import sympy

import kinlib
from kinlib import DualQuaternion, eps, factorize, i, j, null_form, study_form
from kinlib_assignments import Lot, student_id, withheld
from kinlib_assignments.checks import assert_equal, assert_point, numbers
from kinlib_assignments.withhold import defined_beside

# ---- numbers of one's own --------------------------------------------------------------------------------


def test_a_lot_is_the_same_for_ever():
    """Numbers that have been handed out must not change with a new version: they are written here once."""
    lot = Lot("displacements", "ada")
    assert [lot.whole(0, 10**6) for _ in range(3)] == LOT_OF_ADA


LOT_OF_ADA = [460841, 312457, 117131]  # by sha256sum and bc


def test_students_and_assignments_have_different_numbers():
    drawn = [Lot(a, f"student {n}").wholes(4, 10**6) for a in ("first", "second") for n in range(500)]
    assert len(set(map(tuple, drawn))) == 1000


def test_whole_numbers_are_fair():
    lot = Lot("dice", "ada")
    counts = Counter(lot.whole(1, 6) for _ in range(6000))
    assert set(counts) == {1, 2, 3, 4, 5, 6}
    assert sum((count - 1000) ** 2 / 1000 for count in counts.values()) < 20.5  # chi-square, 5 degrees, 0.1 %


def test_shuffled_keeps_all_and_reaches_every_order():
    lot = Lot("cards", "ada")
    orders = {tuple(lot.shuffled("abc")) for _ in range(200)}
    assert orders == {tuple(order) for order in ("abc", "acb", "bac", "bca", "cab", "cba")}


def test_lines_and_poses_are_what_they_say():
    lot = Lot("geometry", "ada")
    for _ in range(200):
        line, pose = lot.line(), lot.pose()
        assert sum(x * x for x in line.direction) == 1
        assert 0 not in line.direction
        assert line.direction @ line.moment == 0
        assert study_form(pose, pose) == 0
        assert null_form(pose, pose) > pose.scalar_part**2


def test_what_cannot_be_drawn_is_said():
    with pytest.raises(ValueError, match="nothing good among 7 draws for x/ada"):
        Lot("x", "ada").until(lambda: 1, lambda one: one > 1, tries=7)


def test_the_graders_id_counts_more_than_the_written_one(monkeypatch):
    assert student_id("Emmy") == "emmy"
    monkeypatch.setenv("KINLIB_STUDENT", "Ada")
    assert student_id("Emmy") == student_id("") == "ada"


def test_no_id_is_refused(monkeypatch):
    monkeypatch.delenv("KINLIB_STUDENT", raising=False)
    with pytest.raises(ValueError, match="write your id"):
        student_id("  ")


# ---- withheld answers ------------------------------------------------------------------------------------


def test_what_is_withheld_fails_by_every_name_and_comes_back():
    by_method = DualQuaternion.conjugate
    with withheld(DualQuaternion.conjugate, factorize):
        for use in (lambda: i.conjugate(), lambda: by_method(i), lambda: kinlib.factorize(1, order=2)):
            with pytest.raises(AssertionError, match="write your own"):
                use()
        assert i * i == -1
    assert i.conjugate() == by_method(i) == -i
    with pytest.raises(TypeError):
        factorize()


def test_what_stands_inside_another_function_is_withheld_too():
    n = 3

    def inner(a, *, b=0):
        return n + a + b

    with withheld(inner), pytest.raises(AssertionError, match="inner of kinlib is the answer"):
        inner(1)
    assert inner(1, b=2) == 6


def test_all_functions_of_a_file_are_withheld():
    found = defined_beside(DualQuaternion, kinlib.act)
    assert {kinlib.act, kinlib.translation, kinlib.from_matrix} <= set(found)
    assert {function.__module__ for function in found} <= {DualQuaternion.__module__, kinlib.act.__module__}


def test_what_is_withheld_comes_back_after_an_error():
    with pytest.raises(ZeroDivisionError), withheld(DualQuaternion.norm):
        raise ZeroDivisionError
    assert i.norm() == 1


# ---- checks ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (None, "nothing was returned"),
        ("1, 2", "expected numbers"),
        ([1, None], "expected numbers"),
        ([1, 2, 3], "expected 2 numbers, got 3 numbers"),
        ([[1, 2]], "expected 2 numbers, got an array of shape"),
        ([1.0, np.nan], "infinite or not a number"),
    ],
)
def test_what_is_no_answer_is_said(answer, said):
    with pytest.raises(AssertionError, match=said):
        numbers(answer, (2,), "the pair")


@pytest.mark.parametrize(
    "answer", [(1, 2), [1, 2], np.array([1.0, 2.0]), (sympy.Integer(1), Fraction(2)), (1 + 1e-13, 2)]
)
def test_right_answers_of_every_kind_are_right(answer):
    assert_equal(answer, (1, 2), "the pair")


@pytest.mark.parametrize("answer", [(2, 1), (1, 2 + 1e-6), (-1, -2), (1, Fraction(2 * 10**12 + 1, 10**12))])
def test_wrong_answers_are_wrong(answer):
    with pytest.raises(AssertionError):
        assert_equal(answer, (1, 2), "the pair")


def test_tolerances_scale_with_the_data():
    assert_equal([1e9 + 0.1], [1e9], "the length")
    with pytest.raises(AssertionError):
        assert_equal([1.1e-9], [1e-9], "the length")


def test_a_point_is_compared_up_to_a_factor():
    pose = i + eps * j
    assert_point(-3 * pose, pose, "the pose")
    far = 1 + i + 6000 * eps * j
    assert_point(0.7 * far.astype(float), far, "the pose")
    for wrong in (i - eps * j, 0 * i, j):
        with pytest.raises(AssertionError):
            assert_point(wrong, pose, "the pose")
