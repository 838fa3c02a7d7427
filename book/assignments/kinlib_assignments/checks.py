"""Checks of answers; where an answer is wrong in a way that is often seen, they say in which."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinlib import DualQuaternion, as_scalars, is_zero, same_point, size

__all__ = ["assert_equal", "assert_point", "numbers"]


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
    if answer is None or answer is NotImplemented:
        raise AssertionError(f"{what}: nothing was returned; is there a `return`?")
    try:
        array = as_scalars(answer.coeffs if isinstance(answer, DualQuaternion) else answer)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"{what}: expected numbers, got {answer!r}") from error
    if array.shape != shape:
        raise AssertionError(f"{what}: expected {_count(shape)}, got {_count(array.shape)}")
    if array.dtype.kind in "fc" and not np.isfinite(array).all():
        raise AssertionError(f"{what}: it is infinite or not a number; was there a division by zero?")
    return array


def _count(shape: tuple[int, ...]) -> str:
    if len(shape) == 1:
        return f"{shape[0]} numbers"
    return "one number" if not shape else f"an array of shape {shape}"


def assert_equal(answer, expected, what: str, slips: Mapping[str, object] | None = None, *, rtol: float = 1e-9) -> None:
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
        return
    for said, value in (slips or {}).items():
        value = as_scalars(value.coeffs if isinstance(value, DualQuaternion) else value)
        if value.shape == array.shape and _agree(array, value, rtol):
            raise AssertionError(f"{what}: {said}")
    raise AssertionError(f"{what}: expected {_shown(expected)}, got {_shown(array)}")


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
