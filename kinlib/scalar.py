"""Scalars of every kind: how they are stored, divided and compared with zero.

Coefficients are NumPy arrays.  Floats and complex numbers keep their dtype; everything exact lives in object
arrays: whole numbers as Python integers, which never overflow, ``Fraction``, SymPy expressions, elements of
number fields and of polynomial rings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Protocol, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "RTOL", "ArrayLike", "ScalarLike", "as_float", "as_scalars", "divide", "imaginary_unit", "is_exact", "is_zero",
    "size",
]  # fmt: skip

RTOL = 1e-9
"""What counts as zero in floats, relative to the size of the problem."""


class Algebraic(Protocol):
    """What computes and compares like a number: SymPy expressions, elements of number fields and of rings."""

    def __add__(self, other: Any, /) -> Any: ...

    def __mul__(self, other: Any, /) -> Any: ...

    def __neg__(self) -> Any: ...

    def __lt__(self, other: Any, /) -> Any: ...


ScalarLike: TypeAlias = Union[int, float, complex, Fraction, "np.number[Any]", Algebraic]
"""A number of any kind: of Python, NumPy, mpmath or SymPy, or an element of a number field."""

ArrayLike: TypeAlias = NDArray[Any] | Sequence[Any] | ScalarLike
"""Numbers of any kind, any shape: an array, nested sequences, or a single one."""


def as_scalars(values) -> np.ndarray:
    """Store numbers as an array without losing exactness.

    Parameters
    ----------
    values : array_like
        Numbers of any kind; whole numbers stay whole, fractions stay fractions.

    Returns
    -------
    numpy.ndarray
        A new array of the same shape, of dtype float, complex or object.

    Raises
    ------
    TypeError
        If there is something that is not a number.

    Examples
    --------
    >>> [as_scalars(row).dtype.kind for row in ([1, 2], [Fraction(1, 2), 2], [2**80, 1], [0.5, 1])]
    ['O', 'O', 'O', 'f']
    """
    array = np.array(values)
    if array.dtype.kind == "f" and isinstance(values, (list, tuple)):
        array = _rescue_large_integers(values, array)
    if array.dtype.kind in "biu":
        return (array.astype(int) if array.dtype.kind == "b" else array).astype(object)
    if array.dtype.kind == "O":
        return _plain_objects(array)
    if array.dtype.kind not in "fc":
        raise TypeError(f"expected numbers, got an array of {array.dtype}")
    return array


def _rescue_large_integers(values, array: np.ndarray) -> np.ndarray:
    """NumPy turns a list like [2**63, -1] into floats; keep its integers instead."""
    objects = np.array(values, dtype=object)
    whole = all(isinstance(x, (int, np.integer)) for x in objects.ravel())
    return objects if whole and objects.size else array


_NOT_NUMBERS = {type(None), bool, str, bytes, list, tuple, dict, set, object}


def is_scalar(x) -> bool:
    """Whether x may be a number or an array of numbers, and not one of the algebras built on them.

    Those ask NumPy to leave operations to them, by the attribute ``__array_ufunc__ = None``.
    """
    return getattr(type(x), "__array_ufunc__", x) is not None


def _plain_objects(array: np.ndarray) -> np.ndarray:
    """Python's numbers in place of NumPy's inside an object array; anything but numbers is refused."""
    for index, x in np.ndenumerate(array):
        if isinstance(x, np.generic):
            array[index] = x.item()
        elif type(x) in _NOT_NUMBERS or not is_scalar(x):
            raise TypeError(f"expected numbers, got {x!r}")
    return array if is_exact(array) else _float_or_same(array)


def _float_or_same(array: np.ndarray) -> np.ndarray:
    """Floats in place of numbers, unless there are symbols among them."""
    try:
        return as_float(array)
    except TypeError:
        return array


def promote(*arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Arrays that may be combined: beside floats, exact numbers become floats and symbols stay."""
    if all(x.dtype == arrays[0].dtype for x in arrays):
        return arrays
    kinds = {x.dtype.kind for x in arrays}
    if "O" in kinds and kinds & set("fc"):
        return tuple(_float_or_same(x) if x.dtype.kind == "O" else x for x in arrays)
    return arrays


def is_exact(array: np.ndarray) -> bool:
    """Whether no entry is a floating-point number, real or complex.

    Examples
    --------
    >>> is_exact(np.array([1, 2])), is_exact(np.array([1.0]))
    (True, False)
    """
    if array.dtype.kind == "O":
        return not any(isinstance(x, (float, complex)) or getattr(x, "is_Float", False) for x in array.ravel())
    return array.dtype.kind not in "fc"


def divide(numerator, denominator) -> Any:
    """The quotient, exact for exact numbers: whole numbers give fractions, never floats.

    Examples
    --------
    >>> divide(1, 3)
    Fraction(1, 3)
    >>> divide(np.array([2.0]), 4).tolist()
    [0.5]
    """
    if isinstance(numerator, np.floating) and isinstance(denominator, np.floating):
        return numerator / denominator
    numerator, denominator = promote(np.asarray(numerator), np.asarray(denominator))
    kinds = {numerator.dtype.kind, denominator.dtype.kind}
    if kinds & set("fc") and "O" not in kinds:
        return numerator / denominator
    return _quotient(*(np.asarray(x).astype(object) for x in (numerator, denominator)))


def _exact_quotient(x, y):
    return Fraction(x, y) if isinstance(x, int) and isinstance(y, int) else x / y


_quotient = np.frompyfunc(_exact_quotient, 2, 1)


def is_zero(values, scale=1.0, rtol: float = RTOL):
    """Whether numbers vanish: exact ones exactly, floats up to ``rtol * scale``.

    SymPy expressions are expanded, so a polynomial identity is recognised; with sines and cosines they are simplified.

    Parameters
    ----------
    values : array_like
        Any scalars, any shape.
    scale : array_like
        The size that floats are compared with.
    rtol : float
        The relative tolerance for floats.

    Returns
    -------
    bool or numpy.ndarray of bool
        One answer an entry.

    Examples
    --------
    >>> is_zero(1e-12), is_zero(Fraction(1, 10**12))
    (True, False)
    """
    if isinstance(values, float) and isinstance(scale, float):
        return bool(abs(values) <= rtol * scale)
    array = np.asarray(values)
    if array.dtype.kind == "O":
        with np.errstate(invalid="ignore"):
            answers = _object_is_zero(array, scale, rtol)
        return bool(answers) if array.ndim == 0 else np.asarray(answers).astype(bool)
    answers = array == 0 if array.dtype.kind in "biu" else np.abs(array) <= rtol * np.asarray(scale)
    return bool(answers) if np.ndim(answers) == 0 else answers


def _object_zero(x, scale, rtol) -> bool:
    if isinstance(x, (float, complex)) or getattr(x, "is_Float", False):
        return bool(abs(x) <= rtol * scale)
    if not hasattr(x, "free_symbols"):
        return x == 0
    from sympy import cancel, expand, simplify
    from sympy.functions.elementary.trigonometric import TrigonometricFunction

    expanded = expand(x)
    if expanded == 0:
        return True
    if not expanded.free_symbols:
        return bool(expanded.equals(0) if expanded.is_zero is None else expanded.is_zero)
    return (simplify if expanded.has(TrigonometricFunction) else cancel)(expanded) == 0


_object_is_zero = np.frompyfunc(_object_zero, 3, 1)


def size(values, axis=None) -> float | np.ndarray:
    """The largest absolute value as a float, along an axis if one is given; a symbol counts as 1.

    Examples
    --------
    >>> size([3, -4])
    4.0
    """
    array = np.asarray(values)
    if array.dtype.kind == "O":
        array = np.vectorize(_absolute, otypes=[float])(array)
    largest = np.abs(array).max(axis=axis, initial=0)
    return float(largest) if axis is None else largest * 1.0


def _absolute(x) -> float:
    try:
        return abs(complex(x))
    except TypeError:  # a symbol, or an element of a polynomial ring
        return 1.0


def as_float(values) -> np.ndarray:
    """The nearest floats (complex ones where a number is not real).

    Examples
    --------
    >>> as_float([Fraction(1, 4), 2]).tolist()
    [0.25, 2.0]
    """
    array = np.asarray(values)
    if array.dtype.kind in "fc":
        return array
    try:
        return array.astype(float)
    except TypeError:
        return array.astype(complex)


def imaginary_unit(array: np.ndarray):
    """√−1 in the company of the given numbers: ``1j`` beside floats, SymPy's ``I`` beside exact numbers.

    Examples
    --------
    >>> imaginary_unit(np.array([1.0])), imaginary_unit(np.array([1]))
    (1j, I)
    """
    if not is_exact(array):
        return 1j
    from sympy import I

    return I


def is_infinite(t) -> bool:
    """Whether a single parameter value is the point at infinity (``math.inf`` or SymPy's ``oo``)."""
    if isinstance(t, (float, np.floating)):
        return math.isinf(t)
    return bool(getattr(t, "is_infinite", False))
