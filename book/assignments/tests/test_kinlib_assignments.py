"""What the assignments share: numbers of one's own, withheld answers, checks that say what is wrong."""

import builtins
import contextlib
import importlib.util
import inspect
import os
import subprocess
import sys
from collections import Counter
from fractions import Fraction
from types import FunctionType
from unittest.mock import patch

import numpy as np
import pytest
import sympy

import kinlib
import kinlib_assignments
from kinlib import DualQuaternion, eps, factorize, i, j, null_form, study_form
from kinlib_assignments import Lot, checks, goldberg, student_id, withheld
from kinlib_assignments import dual_quaternions as exercise
from kinlib_assignments.checks import assert_equal, assert_point, numbers, truth
from kinlib_assignments.seal import assert_untouched, on_other_numbers
from kinlib_assignments.withhold import answer_of, defined_beside

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


def test_the_id_is_what_the_notebook_calls_student(monkeypatch):
    monkeypatch.delenv("KINLIB_STUDENT", raising=False)
    monkeypatch.setitem(globals(), "student", 4711)
    assert student_id() == "4711"


def test_no_id_is_refused(monkeypatch):
    monkeypatch.delenv("KINLIB_STUDENT", raising=False)
    with pytest.raises(ValueError, match="between quotation marks"):
        student_id()
    with pytest.raises(ValueError, match="your id is missing"):
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


def copied(function):
    mine = FunctionType(function.__code__, function.__globals__, "mine", function.__defaults__, function.__closure__)
    mine.__kwdefaults__ = function.__kwdefaults__
    return mine


def imported_twice(function):
    spec = importlib.util.find_spec(function.__module__)
    module = importlib.util.module_from_spec(spec)
    with patch.dict(sys.modules, {"a second copy": module}):
        spec.loader.exec_module(module)
    return getattr(module, function.__name__)


@pytest.mark.parametrize("again", [copied, imported_twice])
def test_a_copy_of_what_is_withheld_is_recognised(again):
    mine = again(kinlib.act)
    assert np.array_equal(mine(i, (1, 2, 3)), (1, -2, -3))
    with pytest.raises(AssertionError, match="act of kinlib is the answer itself"):
        answer_of(mine, i, (1, 2, 3), without=(kinlib.act,))
    assert np.array_equal(mine(i, (1, 2, 3)), (1, -2, -3))


def test_a_refusal_that_is_caught_is_told_all_the_same():
    mine = copied(kinlib.act)

    def twice(x):
        for _ in range(2):
            with contextlib.suppress(AssertionError):
                return mine(i, x)
        return None

    with pytest.raises(AssertionError, match="act of kinlib is the answer itself"):
        answer_of(twice, (1, 2, 3), without=(kinlib.act,))


def test_a_function_of_ones_own_like_one_of_kinlib_is_not_taken_for_it():
    text = inspect.getsource(kinlib.null_form)
    made = dict(vars(sys.modules[kinlib.null_form.__module__]))
    exec(compile(text, "<a cell>", "exec"), made)
    assert answer_of(made["null_form"], i, i, without=(kinlib.null_form,)) == 1


ASKING = {
    "a subprocess": lambda: subprocess.run([sys.executable, "-V"], check=True),
    "the shell": lambda: os.system("true"),
    "a fork": os.fork,
}


@pytest.mark.parametrize("ask", ASKING.values(), ids=ASKING)
def test_no_other_program_is_asked(ask):
    with pytest.raises(AssertionError, match="another program"):
        answer_of(ask)


def test_what_is_no_function_any_more_is_said():
    with pytest.raises(AssertionError, match="was its name used for something else"):
        answer_of(3)


# ---- changed checks --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (checks, "assert_equal"),
        (exercise, "check_d0"),
        (exercise, "assert_equal"),
        (exercise, "_d0"),
        (kinlib_assignments, "student_id"),
        (kinlib, "is_zero"),
        (DualQuaternion, "__eq__"),
        (builtins, "all"),
        (np, "all"),
    ],
)
def test_what_is_replaced_is_found(owner, name, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(owner, name, lambda *given, **named: True)
        with pytest.raises(AssertionError, match=f"this notebook replaced what the checks need: .*{name}"):
            assert_untouched()
    assert_untouched()


def test_exchanged_code_is_found(monkeypatch):
    monkeypatch.setattr(checks.assert_equal, "__code__", (lambda *given, **named: None).__code__)
    with pytest.raises(AssertionError, match="assert_equal"):
        assert_untouched()


def test_exchanged_code_in_a_cache_is_found(monkeypatch):
    monkeypatch.setattr(goldberg.brief.__wrapped__, "__code__", (lambda student: None).__code__)
    with pytest.raises(AssertionError, match=r"goldberg\.brief"):
        assert_untouched()


def test_what_was_worked_out_by_something_else_is_forgotten():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(goldberg, "data", lambda student: DATA_OF_ADA)
        assert goldberg._stops("hidden first") == goldberg._stops("ada")
    on_other_numbers(lambda student: None)
    assert goldberg._stops("hidden first") != goldberg._stops("ada")


DATA_OF_ADA = goldberg.data("ada")


# ---- checks ----------------------------------------------------------------------------------------------


class Flattering:
    """Equals everything, and leaves nothing when anything is taken from it."""

    def __eq__(self, other):
        return True

    def __sub__(self, other):
        return 0

    __hash__ = None
    __rsub__ = __add__ = __mul__ = __sub__


class Pleasing(int):
    """A whole number that is whatever is asked for."""

    __eq__ = Flattering.__eq__
    __sub__ = __rsub__ = Flattering.__sub__
    __hash__ = None


@pytest.mark.parametrize("answer", [Flattering(), 1, "True", [True], None])
def test_only_true_and_false_are_so(answer):
    with pytest.raises(AssertionError, match=r"True or False|nothing was returned"):
        truth(answer, "the answer")


@pytest.mark.parametrize("answer", [True, np.True_, sympy.true])
def test_true_is_true_wherever_it_comes_from(answer):
    assert truth(answer, "the answer")


def test_floats_are_refused_where_fractions_are_asked_for():
    assert_equal([Fraction(1, 2), 1], [Fraction(1, 2), 1], "the pair", exact=True)
    with pytest.raises(AssertionError, match="must be exact"):
        assert_equal([0.5, 1], [Fraction(1, 2), 1], "the pair", exact=True)


def test_a_secret_is_kept():
    with pytest.raises(AssertionError, match="the number: something else than 3"):
        assert_equal(3, 17, "the number", secret=True)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (None, "nothing was returned"),
        ("1, 2", "expected numbers"),
        ([1, None], "expected numbers"),
        ([1, 2, 3], "expected 2 numbers, got 3 numbers"),
        ([[1, 2]], "expected 2 numbers, got an array of shape"),
        ([1.0, np.nan], "infinite or not a number"),
        (Flattering(), "expected numbers"),
        ([1, Flattering()], "expected numbers"),
        (np.array([1, Flattering()]), "expected numbers"),
        ([1, Pleasing(2)], "expected numbers"),
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
