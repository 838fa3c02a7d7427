"""Checks of answers; where an answer is wrong in a way that is often seen, they say in which."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping

import numpy as np

from kinlib import DualQuaternion, as_scalars, is_exact, is_zero, same_point, size

__all__ = ["assert_equal", "assert_point", "assert_refuses", "numbers", "several", "truth"]

NUMBERS_FROM = {"builtins", "fractions", "kinlib", "numpy", "sympy"}
"""The packages whose numbers are taken; others could say of themselves that they equal everything."""


def _is_plain(answer) -> bool:
    """Whether an answer is made of known numbers, in known containers."""
    kind = type(answer)
    if kind in (list, tuple):
        return all(map(_is_plain, answer))
    if kind is np.ndarray:
        return answer.dtype.kind in "iufcb" or (
            answer.dtype.kind == "O" and all(map(_is_plain, answer.ravel().tolist()))
        )
    if kind is DualQuaternion:
        return _is_plain(answer.coeffs)
    home = kind.__module__
    known = home.split(".")[0] in NUMBERS_FROM and getattr(sys.modules.get(home), kind.__name__, None) is kind
    return known and kind not in (str, bytes, type(None))


def numbers(answer, shape: tuple[int, ...], what: str) -> np.ndarray:
    """An answer as an array of numbers.

    Parameters
    ----------
    answer : array_like or DualQuaternion
        What the student's code gave.
    shape : tuple of int
        What it must have.
    what : str
        What it is, for the message.

    Raises
    ------
    AssertionError
        If the answer is missing, holds anything but finite numbers, or has another shape.

    Examples
    --------
    >>> numbers((1, 2, 3), (4,), "the quaternion")
    Traceback (most recent call last):
        ...
    AssertionError: the quaternion: expected 4 numbers, got 3 numbers
    """
    _assert_there(answer, what)
    if not _is_plain(answer):
        raise AssertionError(f"{what}: expected numbers, got {str(answer)[:80]!r}")
    try:
        array = as_scalars(answer.coeffs if isinstance(answer, DualQuaternion) else answer)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"{what}: expected numbers, got {answer!r}") from error
    if array.shape != shape:
        raise AssertionError(f"{what}: expected {_count(shape)}, got {_count(array.shape)}")
    if array.dtype.kind in "fc" and not np.isfinite(array).all():
        raise AssertionError(f"{what}: it is infinite or not a number; was there a division by zero?")
    return array


def _assert_there(answer, what: str) -> None:
    if answer is None or answer is NotImplemented:
        raise AssertionError(f"{what}: nothing was returned; is there a `return`?")


def several(answer, count: int, what: str, of: str = "numbers") -> list:
    """An answer as a list of so many things.

    Examples
    --------
    >>> several((1, 2), 3, "the triangle", "corners")
    Traceback (most recent call last):
        ...
    AssertionError: the triangle: expected 3 corners, got 2
    """
    _assert_there(answer, what)
    if not isinstance(answer, Iterable):
        raise AssertionError(f"{what}: expected {count} {of}, got {str(answer)[:80]}")
    answer = list(answer)
    if len(answer) != count:
        raise AssertionError(f"{what}: expected {count} {of}, got {len(answer)}")
    return answer


def truth(answer, what: str) -> bool:
    """An answer that must be True or False.

    Examples
    --------
    >>> truth(1 == 1, "whether one is one")
    True
    >>> truth(1, "whether one is one")
    Traceback (most recent call last):
        ...
    AssertionError: whether one is one: expected True or False, got 1
    """
    _assert_there(answer, what)
    if not (type(answer) in (bool, np.bool_) or type(answer).__name__ in ("BooleanTrue", "BooleanFalse")):
        raise AssertionError(f"{what}: expected True or False, got {str(answer)[:80]}")
    return bool(answer)


def assert_refuses(call, error: type[Exception], what: str) -> None:
    """Fail unless a call raises an error.

    Examples
    --------
    >>> assert_refuses(lambda: 1, ZeroDivisionError, "the inverse of ε")
    Traceback (most recent call last):
        ...
    AssertionError: the inverse of ε: raise a ZeroDivisionError
    """
    try:
        call()
    except error:
        return
    raise AssertionError(f"{what}: raise a {error.__name__}")


def _count(shape: tuple[int, ...]) -> str:
    if len(shape) == 1:
        return f"{shape[0]} numbers"
    return "one number" if not shape else f"an array of shape {shape}"


def assert_equal(
    answer,
    expected,
    what: str,
    slips: Mapping[str, object] | None = None,
    *,
    rtol: float = 1e-9,
    exact: bool = False,
    secret: bool = False,
) -> None:
    """Fail unless an answer is the expected one: exactly for exact numbers, up to ``rtol`` of its size for floats.

    Parameters
    ----------
    answer, expected : array_like or DualQuaternion
        What came, and what should have come.
    what : str
        What it is, for the message.
    slips : mapping of str to array_like, optional
        Wrong values that are often met, by what to say about them.
    rtol : float
        The tolerance for floats, relative to the largest expected number.
    exact : bool
        Whether floats are wrong by themselves.
    secret : bool
        Whether the expected number is to be kept from whoever reads the message.

    Examples
    --------
    >>> assert_equal((1, -2), (1, 2), "the norm", {"the second sign is lost": (1, -2)})
    Traceback (most recent call last):
        ...
    AssertionError: the norm: the second sign is lost
    """
    expected = as_scalars(expected.coeffs if isinstance(expected, DualQuaternion) else expected)
    array = numbers(answer, expected.shape, what)
    if _agree(array, expected, rtol):
        if exact and not is_exact(array):
            raise AssertionError(f"{what}: these are floats, but it must be exact: divide by Fraction(…)")
        return
    for said, value in (slips or {}).items():
        value = as_scalars(value.coeffs if isinstance(value, DualQuaternion) else value)
        if value.shape == array.shape and _agree(array, value, rtol):
            raise AssertionError(f"{what}: {said}")
    wanted = "something else than" if secret else f"expected {_shown(expected)}, got"
    raise AssertionError(f"{what}: {wanted} {_shown(array)}")


def _agree(first: np.ndarray, second: np.ndarray, rtol: float) -> bool:
    return bool(np.all(is_zero(first - second, scale=size(second), rtol=rtol)))


def _shown(array: np.ndarray) -> str:
    if array.dtype.kind in "fc":
        array = array.round(6)
    return "(" + ", ".join(map(str, array.ravel())) + ")" if array.shape else str(array)


def assert_point(
    answer, expected: DualQuaternion, what: str, slips: Mapping[str, DualQuaternion] | None = None
) -> None:
    """Fail unless a dual quaternion is, up to a factor, the expected one.

    Examples
    --------
    >>> from kinlib import i, j
    >>> assert_point(2 * i, i, "the pose")
    >>> assert_point(j, i, "the pose", {"the axes are exchanged": j})
    Traceback (most recent call last):
        ...
    AssertionError: the pose: the axes are exchanged
    """
    point = DualQuaternion(numbers(answer, (8,), what))
    if not np.any(point.coeffs != 0):
        raise AssertionError(f"{what}: all coefficients vanish, which is no point of P⁷")
    length = max(1.0, size(expected.coeffs) / (size(expected.coeffs[:4]) or 1.0))
    if same_point(point, expected, length=length):
        return
    for said, value in (slips or {}).items():
        if same_point(point, value, length=length):
            raise AssertionError(f"{what}: {said}")
    raise AssertionError(f"{what}: expected [{expected}], got [{point}]")
