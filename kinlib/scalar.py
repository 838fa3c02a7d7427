"""Scalars of every kind: how they are stored, divided and compared with zero.

Coefficients are NumPy arrays.  Floats and complex numbers keep their dtype; everything exact lives in object
arrays: whole numbers as Python integers, which never overflow, ``Fraction``, SymPy expressions, elements of
number fields and of polynomial rings.

All numbers enter through one door, :func:`as_scalars`.  What is rational becomes a Python integer or a ``Fraction``,
whichever package it comes from (SymPy, NumPy, ``decimal``, gmpy2), and what is a floating-point number becomes a
Python float (SymPy's ``Float``, mpmath's ``mpf``: further digits are dropped).  √2, π and symbols of SymPy stay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from numbers import Integral, Rational
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "PARALLEL",
    "ROUNDING",
    "RTOL",
    "RTOL_SINGLE",
    "ArrayLike",
    "ScalarLike",
    "Scalars",
    "angle_of",
    "as_float",
    "as_scalars",
    "check_finite",
    "divide",
    "imaginary_unit",
    "is_exact",
    "is_zero",
    "root_of",
    "size",
]  # fmt: skip

RTOL = 1e-9
"""What counts as zero in floats, relative to the size of the problem."""

RTOL_SINGLE = 1e-5
"""The same for numbers in single precision (``float32``, ``complex64``), which have half as many digits."""

ROUNDING = 64 * 2.0**-52
"""What rounding may leave where numbers of size 1 should cancel."""

PARALLEL = 1e-12
"""The sine of the angle below which two directions in floats count as parallel."""


class Algebraic(Protocol):
    """What computes and compares like a number: SymPy expressions, elements of number fields and of rings."""

    def __add__(self, other: Any, /) -> Any: ...

    def __mul__(self, other: Any, /) -> Any: ...

    def __neg__(self) -> Any: ...

    def __lt__(self, other: Any, /) -> Any: ...


ScalarLike: TypeAlias = int | float | complex | Fraction | np.number[Any] | Algebraic
"""A number of any kind: of Python, NumPy, mpmath or SymPy, or an element of a number field."""

ArrayLike: TypeAlias = NDArray[Any] | Sequence[Any] | ScalarLike
"""Numbers of any kind, any shape: an array, nested sequences, or a single one."""

Scalars: TypeAlias = Any
"""What comes out: a number for a single problem, an array of numbers for a batch."""


def as_scalars(values: ArrayLike) -> np.ndarray:
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
    >>> import sympy
    >>> as_scalars([sympy.Rational(1, 2), sympy.Integer(2), sympy.sqrt(2)]).tolist()
    [Fraction(1, 2), 2, sqrt(2)]
    """
    if not isinstance(values, np.ndarray):
        _refuse_algebras(values)
    try:
        array = np.array(values)
    except ValueError:
        raise ValueError(
            "expected an array of numbers, got an inhomogeneous shape: rows of different lengths"
        ) from None
    kind = array.dtype.kind
    if kind == "f" and isinstance(values, (list, tuple)):
        array = _rescue_large_integers(values, array)
        kind = array.dtype.kind
    if kind in "biu":
        return (array.astype(int) if kind == "b" else array).astype(object)
    if kind == "O":
        return _plain_objects(array)
    if kind not in "fc":
        raise TypeError(f"expected numbers, got an array of {array.dtype}")
    return array


def _refuse_algebras(values: Any) -> None:
    """Dual quaternions and their like are no scalars, although NumPy could read their coefficients."""
    while isinstance(values, (list, tuple)) and values:
        values = values[0]
    if not is_scalar(values):
        raise TypeError(f"expected numbers, got {type(values).__name__} {values!r}")


def _rescue_large_integers(values: Any, array: np.ndarray) -> np.ndarray:
    """NumPy turns a list like [2**63, -1] into floats; keep its integers instead."""
    objects = np.array(values, dtype=object)
    whole = all(isinstance(x, (int, np.integer)) for x in objects.ravel())
    return objects if whole and objects.size else array


_ARITHMETIC = ("__add__", "__mul__", "__neg__")


def is_scalar(x: Any) -> bool:
    """Whether x may be a number or an array of numbers, and not one of the algebras built on them.

    Those ask NumPy to leave operations to them, by the attribute ``__array_ufunc__ = None``.
    """
    return getattr(type(x), "__array_ufunc__", x) is not None


def _plain_objects(array: np.ndarray) -> np.ndarray:
    """Python's numbers in place of those of other packages; anything but numbers is refused."""
    for index, x in np.ndenumerate(array):
        if type(x) is not int and type(x) is not Fraction:
            array[index] = plain(x)
    return array if is_exact(array) else _float_or_same(array)


def plain(x: Any) -> Any:
    """A number as Python writes it, where Python can: rational ones exactly, floating-point ones as floats.

    Examples
    --------
    >>> plain(np.int64(3)), plain(Decimal("0.1"))
    (3, Fraction(1, 10))
    """
    if isinstance(x, np.generic):
        x = x.item()
    if isinstance(x, (int, Fraction, float, complex)) and not isinstance(x, bool):
        return x
    if isinstance(x, Integral) and not isinstance(x, bool):
        return int(x)
    if isinstance(x, Rational) and not isinstance(x, bool):
        return Fraction(int(x.numerator), int(x.denominator))
    if isinstance(x, Decimal):
        return Fraction(x) if x.is_finite() else float(x)
    if hasattr(x, "free_symbols"):
        return _plain_expression(x)
    if hasattr(x, "_mpf_") or hasattr(x, "_mpc_"):  # of mpmath
        return float(x) if hasattr(x, "_mpf_") else complex(x)
    if isinstance(x, bool) or not is_scalar(x) or not all(hasattr(x, name) for name in _ARITHMETIC):
        raise TypeError(f"expected numbers, got {x!r}")
    return x


def _plain_expression(x: Any) -> Any:
    """An expression of SymPy; if it has floating-point numbers in it and no symbol, a float."""
    from sympy import Expr, Float, S

    if not isinstance(x, Expr):  # a matrix, a set
        raise TypeError(f"expected numbers, got {x!r}")
    if not x.is_number or not x.has(Float, S.NaN, S.Infinity, S.NegativeInfinity, S.ComplexInfinity):
        return x
    value = complex(x)
    return value.real if value.imag == 0 else value


def _float_or_same(array: np.ndarray) -> np.ndarray:
    """Floats in place of numbers, unless there are symbols among them."""
    try:
        return as_float(array)
    except TypeError:
        return array


def promote(*arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Arrays that may be combined: beside floats, exact numbers become floats and symbols stay."""
    first = arrays[0].dtype
    if all([x.dtype == first for x in arrays]):  # noqa: C419 a list is faster than a generator
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


FLOATS = (np.ndarray, np.floating)


def divide(numerator: ArrayLike, denominator: ArrayLike) -> Scalars:
    """The quotient, exact for exact numbers: whole numbers give fractions, never floats.

    Examples
    --------
    >>> divide(1, 3)
    Fraction(1, 3)
    >>> divide(np.array([2.0]), 4).tolist()
    [0.5]
    """
    if (
        isinstance(numerator, FLOATS)
        and isinstance(denominator, FLOATS)
        and numerator.dtype == denominator.dtype == float
    ):
        return numerator / denominator
    numerator, denominator = promote(np.asarray(numerator), np.asarray(denominator))
    kinds = {numerator.dtype.kind, denominator.dtype.kind}
    if kinds & set("fc") and "O" not in kinds:
        return numerator / denominator
    return _quotient(*(np.asarray(x).astype(object) for x in (numerator, denominator)))


def _exact_quotient(x: Any, y: Any) -> Any:
    return Fraction(x, y) if isinstance(x, int) and isinstance(y, int) else x / y


_quotient = np.frompyfunc(_exact_quotient, 2, 1)


def root_of(x: Any) -> Any:
    """The square root to the digits of floats, as a float or, of exact numbers, as a fraction.

    Scalars that have a root of their own, since they write formulas down, keep to it.
    """
    return _root_of(x) if np.asarray(x).dtype == object else np.sqrt(x)


def angle_of(y: Any, x: Any) -> Any:
    """The angle of the points (x, y), likewise."""
    return _angle_of(y, x) if object in (np.asarray(y).dtype, np.asarray(x).dtype) else np.arctan2(y, x)


def _root(x: Any) -> Any:
    return x.sqrt() if hasattr(x, "sqrt") else Fraction(math.sqrt(x))


def _angle(y: Any, x: Any) -> Any:
    if hasattr(y, "arctan2"):
        return y.arctan2(x)
    return x.rarctan2(y) if hasattr(x, "rarctan2") else Fraction(math.atan2(y, x))


_root_of, _angle_of = np.frompyfunc(_root, 1, 1), np.frompyfunc(_angle, 2, 1)


def is_zero(values: ArrayLike, scale: Any = 1.0, rtol: Any = RTOL) -> Any:
    """Whether numbers vanish: exact ones exactly, floats up to ``rtol * scale``.

    SymPy expressions are expanded, so a polynomial identity is recognised; with sines and cosines they are simplified.

    Parameters
    ----------
    values : array_like
        Any scalars, any shape.
    scale : array_like
        The size that floats are compared with.
    rtol : float or array_like
        The relative tolerance for floats; not below :data:`RTOL_SINGLE` for numbers in single precision, but for
        ``rtol=0``, which asks for exact zeros.

    Returns
    -------
    bool or numpy.ndarray of bool
        One answer an entry; False for NaN.

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
    if array.dtype.kind in "biu":
        answers = array == 0
    else:
        answers = np.abs(array) <= own_precision(array, rtol) * np.asarray(scale)
    return bool(answers) if np.ndim(answers) == 0 else answers


def own_precision(array: np.ndarray, rtol: Any) -> Any:
    """The tolerance that an array can be held to: numbers in single precision are judged by their own."""
    if array.dtype.char not in "efF":
        return rtol
    return np.where(np.asarray(rtol) > 0, np.maximum(rtol, RTOL_SINGLE), rtol)[()]


def _object_zero(x: Any, scale: Any, rtol: Any) -> bool:
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


def size(values: ArrayLike, axis: int | tuple[int, ...] | None = None) -> Any:
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


def _absolute(x: Any) -> float:
    try:
        return abs(complex(x))
    except OverflowError:  # an exact number beyond all floats
        return math.inf
    except TypeError:  # a symbol, or an element of a polynomial ring
        return 1.0


def as_float(values: ArrayLike) -> np.ndarray:
    """The nearest floats (complex ones where a number is not real).

    Raises
    ------
    OverflowError
        If a number is too large for a float.

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
    except OverflowError:
        raise OverflowError("an exact number is too large for a float (the largest is about 1.8e308)") from None


def as_vectors(values: ArrayLike, what: str = "vectors") -> np.ndarray:
    """Points or vectors of space as an array of shape (..., 3), real; a single one must be finite.

    In a batch, rows with NaN or infinity become rows of NaN, so that they stay rows of any result.

    Raises
    ------
    TypeError
        If there is something that is not a number.
    ValueError
        If there are not three coordinates, or they are not real, or a single vector is not finite.

    Examples
    --------
    >>> as_vectors([1, 2, 3]).tolist()
    [1, 2, 3]
    """
    array = as_scalars(values)
    if array.shape[-1:] != (3,):
        raise ValueError(f"expected {what} of shape (..., 3), got shape {array.shape}")
    if array.dtype.kind == "c":
        raise ValueError(f"expected real {what}, got complex numbers")
    return finite_rows(array, what)


def finite_rows(array: np.ndarray, what: str, core: int = 1) -> np.ndarray:
    """The array, if all its numbers are finite; in a batch the other rows become NaN.

    Parameters
    ----------
    array : numpy.ndarray
        It may be changed: give a new one.
    what : str
        What the rows are, for the error.
    core : int
        How many axes a row has; further axes are the batch.

    Raises
    ------
    ValueError
        If a single row is not finite.
    """
    if array.dtype.kind not in "fc" or np.isfinite(array).all():
        return array
    if array.ndim == core:
        raise ValueError(f"expected finite {what}, got NaN or infinity")
    array[~np.isfinite(array).all(axis=tuple(range(-core, 0)))] = math.nan
    return array


def check_finite(array: np.ndarray, what: str = "numbers") -> None:
    """Refuse NaN and infinity anywhere.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    if array.dtype.kind in "fc" and not np.isfinite(array).all():
        raise ValueError(f"expected finite {what}, got NaN or infinity")


def read_only(array: np.ndarray) -> np.ndarray:
    """A copy of an array that cannot be written to."""
    array = np.array(array)
    array.setflags(write=False)
    return array


def imaginary_unit(array: np.ndarray) -> Any:
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


def is_infinite(t: Any) -> bool:
    """Whether a single parameter value is the point at infinity (``math.inf`` or SymPy's ``oo``)."""
    if isinstance(t, (float, np.floating)):
        return math.isinf(t)
    return bool(getattr(t, "is_infinite", False))
