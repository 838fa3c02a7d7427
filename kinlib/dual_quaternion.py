"""Dual quaternions: the algebra of the paper's section 2, for scalars of every kind.

A dual quaternion q = p + εd is eight coefficients (p0, p1, p2, p3, d0, d1, d2, d3) with respect to
1, i, j, k, ε, εi, εj, εk.  Leading axes are a batch.  The product composes displacements: the right factor
acts first.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from kinlib.scalar import ArrayLike, Scalars, as_float, as_scalars, divide, is_scalar, is_zero, promote, size
from kinlib.shown import as_latex, as_sum, as_text, in_lines, times_unit

__all__ = [
    "DualQuaternion", "dual_size", "eps", "eps_times", "i", "j", "k", "null_form", "one", "primal_size", "study_form",
]  # fmt: skip

UNITS = ("", "i", "j", "k", "ε", "εi", "εj", "εk")
LATEX_UNITS = "", r"\mathbf{i}", r"\mathbf{j}", r"\mathbf{k}"
FEW = 512  # products so few are summed up by tables: one call of NumPy costs as much as short arrays
BLOCK = 2**13  # rows of a batch at a time: they stay in the cache


class DualQuaternion:
    """A dual quaternion, or a batch of them; its value never changes.

    Parameters
    ----------
    coeffs : array_like, shape (..., 8)
        The coefficients with respect to 1, i, j, k, ε, εi, εj, εk: integers, floats, complex numbers,
        fractions, SymPy expressions or elements of a number field.  A dual quaternion, or a list of them, gives
        the same value, or their batch.

    Raises
    ------
    ValueError
        If the last axis does not have eight entries.
    TypeError
        If there is something that is not a number.

    Notes
    -----
    For NumPy a dual quaternion is its array of coefficients: ``np.asarray(q)`` is ``q.coeffs``, read-only.  In
    operations an array is an array of scalars, one for each entry of the batch; ``==`` compares with coefficients.
    ``bool(q)`` is False for zero only; a batch has no truth value.

    Examples
    --------
    >>> q = DualQuaternion([1, 2, 0, 0, 0, 0, 3, 0])
    >>> q
    1 + 2 i + 3 εj
    >>> q == 1 + 2 * i + 3 * eps * j
    True
    >>> q.conjugate(), q.norm()
    (1 - 2 i - 3 εj, 5)
    """

    __slots__ = ("_components",)
    __array_ufunc__ = None  # arrays leave mixed operations to this class
    _components: np.ndarray

    def __init__(self, coeffs: DualQuaternion | Sequence[DualQuaternion] | ArrayLike):
        array = _coefficients(coeffs)
        if array.ndim == 0 or array.shape[-1] != 8:
            raise ValueError(f"expected coefficients of shape (..., 8), got {array.shape}")
        components = np.ascontiguousarray(array.transpose(-1, *range(array.ndim - 1)))
        components.setflags(write=False)
        self._components = components

    @classmethod
    def from_components(cls, components: ArrayLike) -> DualQuaternion:
        """The dual quaternion of an array with the eight components first, shape (8, ...).

        Examples
        --------
        >>> DualQuaternion.from_components(np.eye(8)).shape
        (8,)
        """
        array = as_scalars(components)
        if array.ndim == 0 or len(array) != 8:
            raise ValueError(f"expected components of shape (8, ...), got {array.shape}")
        return wrap(array)

    @classmethod
    def stack(cls, items: Iterable[DualQuaternion], axis: int = 0) -> DualQuaternion:
        """Join dual quaternions of one batch shape along a new batch axis.

        Examples
        --------
        >>> DualQuaternion.stack([i, j, k]).shape
        (3,)
        """
        if not isinstance(items, Iterable):
            raise TypeError(f"expected dual quaternions to stack, got {type(items).__name__}")
        items = [as_dual_quaternion(item) for item in items]
        if not items:
            raise ValueError("expected at least one dual quaternion to stack")
        components = promote(*[item._components for item in items])
        if any(x.shape != components[0].shape for x in components):
            shape = np.broadcast_shapes(*[x.shape[1:] for x in components])
            components = tuple(_over(x, shape) for x in components)
        return wrap(np.stack(components, axis=axis + 1 if axis >= 0 else axis))

    @property
    def components(self) -> np.ndarray:
        """The coefficients with the eight components first, shape (8, ...), read-only."""
        return self._components

    @property
    def coeffs(self) -> np.ndarray:
        """The coefficients, shape (..., 8), read-only."""
        return self._components.transpose(*range(1, self._components.ndim), 0)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch; ``()`` for a single dual quaternion."""
        return self._components.shape[1:]

    @property
    def scalar_part(self) -> Any:
        """The coefficient of 1, shape (...)."""
        return self._components[0]

    @property
    def primal(self) -> DualQuaternion:
        """The quaternion p of q = p + εd."""
        return wrap(np.concatenate((self._components[:4], np.zeros_like(self._components[4:]))))

    @property
    def dual(self) -> DualQuaternion:
        """The quaternion d of q = p + εd."""
        return wrap(np.concatenate((self._components[4:], np.zeros_like(self._components[4:]))))

    def conjugate(self) -> DualQuaternion:
        """q̄ = p̄ + εd̄: the signs of i, j and k change."""
        components = -self._components
        components[::4] = self._components[::4]
        return wrap(components)

    def eps_conjugate(self) -> DualQuaternion:
        """p − εd: the sign of ε changes."""
        components = self._components.copy()
        components[4:] = -components[4:]
        return wrap(components)

    def norm(self) -> DualQuaternion:
        """The dual number q q̄ = p p̄ + ε(p d̄ + d p̄); never its root."""
        p, d = self._components[:4], self._components[4:]
        norm = np.zeros_like(self._components)
        norm[0], norm[4] = _inner(p, p), 2 * _inner(p, d)
        return wrap(norm)

    def inverse(self) -> DualQuaternion:
        """q⁻¹ = q̄ / (q q̄).

        Raises
        ------
        ZeroDivisionError
            If a primal part vanishes (or is a complex null quaternion): such elements divide zero.

        Examples
        --------
        >>> (1 + eps * i).inverse(), (2 * j).inverse()
        (1 - εi, -1/2 j)
        """
        p, d = self._components[:4], self._components[4:]
        square = _inner(p, p)
        if np.any(is_zero(square, rtol=0)):
            raise ZeroDivisionError("no inverse: p p̄ = 0 for the primal part p, so q divides zero")
        conjugate = self.conjugate()
        real, dual = divide(1, square), divide(-2 * _inner(p, d), square * square)
        inverse = conjugate._components * real
        inverse[4:] = inverse[4:] + conjugate._components[:4] * dual
        return wrap(inverse)

    def astype(self, dtype: DTypeLike) -> DualQuaternion:
        """The same value with coefficients of another kind, such as ``float``.

        Examples
        --------
        >>> (i / 3).astype(float).coeffs[1].round(6)
        np.float64(0.333333)
        """
        components = self._components
        if np.dtype(dtype).kind in "fc":
            components = as_float(components)
        return wrap(np.array(components, dtype=dtype))

    def map(self, function: Callable[[Any], Any]) -> DualQuaternion:
        """The same dual quaternion with a function applied to each coefficient, such as ``sympy.expand``.

        Examples
        --------
        >>> import sympy
        >>> x = sympy.Symbol("x")
        >>> ((x + i) * (x - i)).map(sympy.factor)
        x**2 + 1
        """
        return DualQuaternion(np.frompyfunc(function, 1, 1)(self.coeffs.astype(object)))

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        """The coefficients, as NumPy asks for them."""
        return np.array(self.coeffs, dtype=dtype) if copy else np.asarray(self.coeffs, dtype=dtype)

    def __add__(self, other: DualQuaternion | ArrayLike) -> DualQuaternion:
        if isinstance(other, DualQuaternion):
            return wrap(_aligned_sum(self._components, other._components))
        if not is_scalar(other):
            return NotImplemented
        return wrap(_plus_scalar(self._components, other))

    def __pos__(self) -> DualQuaternion:
        return self

    def __neg__(self) -> DualQuaternion:
        return wrap(-self._components)

    def __sub__(self, other: DualQuaternion | ArrayLike) -> DualQuaternion:
        if isinstance(other, DualQuaternion):
            return wrap(_aligned_sum(self._components, other._components, operator.sub))
        if not is_scalar(other):
            return NotImplemented
        return wrap(_plus_scalar(self._components, other, operator.sub))

    def __rsub__(self, other: ArrayLike) -> DualQuaternion:
        return -self + other

    def __mul__(self, other: DualQuaternion | ArrayLike) -> DualQuaternion:
        if isinstance(other, DualQuaternion):
            return wrap(_product(self._components, other._components))
        if _takes_the_precision_of(self._components, other):
            return wrap(self._components * other)
        if not is_scalar(other):
            return NotImplemented
        return wrap(_scaled(self._components, _scalars(other)))

    def __rmul__(self, scalar: ArrayLike) -> DualQuaternion:
        return self * scalar  # a scalar commutes with everything; dual quaternions never come here

    __radd__ = __add__

    def __truediv__(self, other: DualQuaternion | ArrayLike) -> DualQuaternion:
        if isinstance(other, DualQuaternion):
            return self * other.inverse()
        if not is_scalar(other):
            return NotImplemented
        if _takes_the_precision_of(self._components, other) and other:
            return wrap(self._components / other)
        scalar = _scalars(other)
        if scalar.ndim == 0:
            return wrap(divide(self._components, scalar[()]))
        return wrap(divide(*_aligned(self._components, scalar[None])))

    def __rtruediv__(self, scalar: ArrayLike) -> DualQuaternion:
        return self.inverse() * scalar

    def __pow__(self, exponent: int) -> DualQuaternion:
        if not isinstance(exponent, (int, np.integer)):
            raise TypeError(f"expected a whole number as exponent, got {exponent!r}")
        base = self.inverse() if exponent < 0 else self
        return math.prod([base] * abs(int(exponent)), start=one)

    def __bool__(self) -> bool:
        """Whether a single dual quaternion is not zero."""
        if self.shape:
            raise ValueError(f"a batch of shape {self.shape} has no truth value: compare its entries, as in q != 0")
        return not np.all(is_zero(self._components, rtol=0))

    def __eq__(self, other: Any) -> Any:
        """Whether all coefficients agree (not: whether the points of P⁷ do); one answer a batch entry.

        An array is read as coefficients, shape (..., 8); a single number is compared as one.
        """
        if isinstance(other, (np.ndarray, list, tuple)) and np.ndim(other):
            try:
                other = DualQuaternion(other)
            except (TypeError, ValueError):
                return NotImplemented
        if not isinstance(other, DualQuaternion) and not is_scalar(other):
            return NotImplemented
        try:
            difference = self - other
        except TypeError:
            return NotImplemented
        equal = np.asarray(is_zero(difference._components, rtol=0)).all(axis=0)
        return bool(equal) if difference.shape == () else equal

    def __ne__(self, other: object) -> Any:
        equal = self == other
        return ~equal if isinstance(equal, np.ndarray) else not equal

    def __copy__(self) -> DualQuaternion:
        return self  # its value never changes

    def __deepcopy__(self, memo: Any) -> DualQuaternion:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return wrap, (self._components,)  # read-only again after pickling

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single dual quaternion has no length; its coefficients are in .coeffs")
        return self.shape[0]

    def __getitem__(self, index: Any) -> DualQuaternion:
        """Entries of the batch, indexed as an array of shape ``self.shape``."""
        index = index if isinstance(index, tuple) else (index,)
        return wrap(np.array(self._components[(slice(None), *index)]))

    def __iter__(self) -> Iterator[DualQuaternion]:
        return (self[n] for n in range(len(self)))

    def __repr__(self) -> str:
        if self.shape:
            return f"DualQuaternion of shape {self.shape}, {self._components.dtype}"
        terms = zip(self._components.tolist(), UNITS, strict=True)
        return as_sum(times_unit(as_text(c), unit) for c, unit in terms if c != 0)

    def _repr_latex_(self) -> str | None:
        """A single one as a formula."""
        return None if self.shape else f"${in_lines(pieces_in_latex(self), len(repr(self)))}$"


def study_form(x: DualQuaternion, y: DualQuaternion) -> Scalars:
    """The Study form b(x, y), shape (...); batches broadcast.

    Examples
    --------
    >>> int(study_form(i, j - eps * i))       # two skew lines, one apart and at right angles
    -1
    """
    a, b = promote(*_components_of(x, y))
    return _inner(a[:4], b[4:]) + _inner(a[4:], b[:4])


def null_form(x: DualQuaternion, y: DualQuaternion) -> Scalars:
    """The null form ⟨x, y⟩ of the primal parts, shape (...); batches broadcast.

    Examples
    --------
    >>> int(null_form(1 + 2 * i + eps, 3 + j))
    3
    """
    a, b = promote(*_components_of(x, y))
    return _inner(a[:4], b[:4])


def _inner(p: np.ndarray, r: np.ndarray) -> Scalars:
    """Σ p_k r_k for components first, four of each; batches broadcast from the right."""
    if p.dtype == r.dtype == float and p.ndim == r.ndim:
        return np.add.reduce(p * r, axis=0)  # in the same order, so with the same rounding
    (p0, p1, p2, p3), (r0, r1, r2, r3) = p, r
    return p0 * r0 + p1 * r1 + p2 * r2 + p3 * r3


def left_matrix(q: DualQuaternion) -> np.ndarray:
    """The matrix of x ↦ q x, shape (..., 8, 8), in floats."""
    return np.moveaxis(np.tensordot(TABLE, as_float(q.components), (0, 0)), (0, 1), (-2, -1))


def right_matrix(q: DualQuaternion) -> np.ndarray:
    """The matrix of x ↦ x q, shape (..., 8, 8), in floats."""
    return np.moveaxis(np.tensordot(TABLE, as_float(q.components), (2, 0)), (1, 0), (-2, -1))


def eps_times(q: DualQuaternion) -> DualQuaternion:
    """The product εq, which moves the primal part to the dual part."""
    p = as_dual_quaternion(q).components[:4]
    return wrap(np.concatenate((np.zeros_like(p), p)))


def primal_size(q: DualQuaternion) -> Scalars:
    """How large the primal part is: the largest absolute value of its four coefficients, a float, shape (...).

    Examples
    --------
    >>> primal_size(3 * i - 4 * k + 7 * eps), dual_size(3 * i - 4 * k + 7 * eps)
    (4.0, 7.0)
    """
    return _size(as_dual_quaternion(q).components[:4])


def dual_size(q: DualQuaternion) -> Scalars:
    """How large the dual part is: the largest absolute value of its four coefficients, a float, shape (...)."""
    return _size(as_dual_quaternion(q).components[4:])


def _components_of(x: DualQuaternion, y: DualQuaternion) -> tuple[np.ndarray, np.ndarray]:
    try:
        return x.components, y.components
    except AttributeError:
        return as_dual_quaternion(x).components, as_dual_quaternion(y).components


def _size(components: np.ndarray) -> Scalars:
    return size(components, 0 if components.ndim > 1 else None)


def wrap(components: np.ndarray) -> DualQuaternion:
    """The dual quaternion of an array with the eight components first, shape (8, ...), without a copy or a check.

    For formulas that have just made the array, of numbers as :func:`~kinlib.scalar.as_scalars` stores them: it can
    no longer be written to.
    """
    self = object.__new__(DualQuaternion)
    components.setflags(write=False)
    self._components = components
    return self


def as_dual_quaternion(x: Any, what: str = "a dual quaternion") -> DualQuaternion:
    """The dual quaternion x itself; an error for everything else."""
    if isinstance(x, DualQuaternion):
        return x
    raise TypeError(
        f"expected {what}, got {type(x).__name__}: DualQuaternion(x) takes coefficients, from_matrix(x) a 4×4 matrix, "
        "half_turn(x) a line"
    )


def _coefficients(x: Any) -> np.ndarray:
    if isinstance(x, DualQuaternion):
        return x.coeffs
    if isinstance(x, (list, tuple)) and x and isinstance(x[0], DualQuaternion):
        return DualQuaternion.stack(x).coeffs
    return as_scalars(x)


def pieces_in_latex(q: DualQuaternion) -> list[str]:
    """The primal and the dual part of a single one as formulas, the latter with its sign; without what is zero."""
    numbers = q.components.tolist()
    primal, dual = (
        [times_unit(as_latex(c), f"{eps}{unit}".strip()) for c, unit in zip(part, LATEX_UNITS, strict=True) if c != 0]
        for part, eps in ((numbers[:4], ""), (numbers[4:], r"\varepsilon "))
    )
    if primal and dual:
        return [as_sum(primal), as_sum(["", *dual]).strip()]
    return [as_sum(primal + dual)]


def _takes_the_precision_of(components: np.ndarray, x: Any) -> bool:
    """Whether x is a number of Python that NumPy multiplies in the precision of the components, be it single."""
    kind = type(x)
    return components.dtype.kind in "fc" and (kind is float or (kind is int and abs(x) < 2**1023))


def _scalars(x: Any) -> Any:
    """Numbers to compute with, as :func:`~kinlib.scalar.as_scalars` stores them; arrays of floats as they are."""
    return x if type(x) in (np.ndarray, np.float64) and x.dtype == float else as_scalars(x)


def _plus_scalar(components: np.ndarray, scalar: Any, combine: Callable[[Any, Any], Any] = operator.add) -> np.ndarray:
    """The sum with a scalar, or an array of scalars, in the precision of the components; or the difference."""
    if _takes_the_precision_of(components, scalar):
        scalar = components.dtype.type(scalar)
    else:
        components, scalar = promote(components, _scalars(scalar))
        components, scalar = _aligned(components, scalar[None])
    first = combine(components[:1], scalar)
    if first.shape[1:] != components.shape[1:] or first.dtype != components.dtype:
        components = np.broadcast_to(components, (8, *first.shape[1:])).astype(first.dtype)
    total = components + 0  # no zero is left with a sign
    total[:1] = first
    return total


def _aligned(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Insert axes behind the components, so that the batches broadcast from the right."""
    missing = a.ndim - b.ndim
    if missing > 0:
        return a, b.reshape(*b.shape[:1], *(1,) * missing, *b.shape[1:])
    return (a.reshape(*a.shape[:1], *(1,) * -missing, *a.shape[1:]) if missing else a), b


def _aligned_sum(a: np.ndarray, b: np.ndarray, combine: Callable[[Any, Any], Any] = operator.add) -> np.ndarray:
    return combine(*_aligned(*promote(a, b)))


def _scaled(components: np.ndarray, scalar: Any) -> np.ndarray:
    components, scalar = promote(components, scalar)
    if scalar.ndim == 0:
        return components * scalar[()]
    components, scalar = _aligned(components, scalar[None])
    return components * scalar


def _product_formula(a: Any, b: Any) -> tuple[Any, ...]:
    """(p + εd)(r + εe) = pr + ε(pe + dr), written out; each component may be a number or an array."""
    p0, p1, p2, p3, d0, d1, d2, d3 = a
    r0, r1, r2, r3, e0, e1, e2, e3 = b
    return (
        p0 * r0 - p1 * r1 - p2 * r2 - p3 * r3,
        p0 * r1 + p1 * r0 + p2 * r3 - p3 * r2,
        p0 * r2 - p1 * r3 + p2 * r0 + p3 * r1,
        p0 * r3 + p1 * r2 - p2 * r1 + p3 * r0,
        p0 * e0 - p1 * e1 - p2 * e2 - p3 * e3 + (d0 * r0 - d1 * r1 - d2 * r2 - d3 * r3),
        p0 * e1 + p1 * e0 + p2 * e3 - p3 * e2 + (d0 * r1 + d1 * r0 + d2 * r3 - d3 * r2),
        p0 * e2 - p1 * e3 + p2 * e0 + p3 * e1 + (d0 * r2 - d1 * r3 + d2 * r0 + d3 * r1),
        p0 * e3 + p1 * e2 - p2 * e1 + p3 * e0 + (d0 * r3 + d1 * r2 - d2 * r1 + d3 * r0),
    )


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of component arrays (8, ...) and (8, ...), batches broadcast."""
    if a.ndim == b.ndim == 1:
        values = _product_formula(a.tolist(), b.tolist())
        return np.array(values, dtype=a.dtype) if a.dtype == b.dtype else as_scalars(values)
    if a.dtype == b.dtype == float and max(a.size, b.size) <= 8 * FEW:
        a, b = _aligned(a, b)
        if np.broadcast(a, b).size <= 8 * FEW:
            return _product_by_tables(a, b)
    return blockwise(_product_formula, a, b, rows=8)


def _product_by_tables(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The same sums in the same order, so with the same rounding, by few calls of NumPy."""
    signs = SIGNS.reshape(4, 4, *(1,) * (a.ndim - 1))
    pr, pe, dr = np.add.reduce(a[LEFT] * (signs * b[RIGHT]), axis=2)
    return np.concatenate([pr, pe + dr])


TABLE = np.array([_product_formula(unit, np.eye(8)) for unit in np.eye(8)])
NUMBERS, SIGNS = np.abs(TABLE[:4, :4, :4]).argmax(axis=2).T, TABLE[:4, :4, :4].sum(axis=2).T
"""Component n of a product pr of quaternions is the sum of SIGNS[n, k] p[k] r[NUMBERS[n, k]] over k."""
LEFT = np.array([0, 0, 4])[:, None, None] + np.arange(4)
RIGHT = np.array([0, 4, 0])[:, None, None] + NUMBERS


def blockwise(formula: Callable[..., tuple[Any, ...]], *operands: np.ndarray, rows: int) -> np.ndarray:
    """Apply a formula on components to arrays (components, ...), a cache-sized block of the batch at a time.

    Parameters
    ----------
    formula : callable
        Takes one sequence of components for each operand, returns ``rows`` components.
    operands : arrays, shape (components, ...)
        Their batches are broadcast against each other.
    rows : int
        The number of components of the result.

    Returns
    -------
    numpy.ndarray, shape (rows, ...)
    """
    operands = promote(*operands)
    shape = np.broadcast_shapes(*[x.shape[1:] for x in operands])
    total, dtype = math.prod(shape), np.result_type(*operands)
    flat = [x if x.ndim == 1 else _flat(x, shape, total) for x in operands]
    result = np.empty((rows, total), dtype=dtype)
    for start in range(0, total, BLOCK):
        block = slice(start, start + BLOCK)
        values = formula(*[x if x.ndim == 1 else np.ascontiguousarray(x[:, block]) for x in flat])
        for row, value in zip(result, values, strict=True):
            row[block] = value
    return result.reshape(rows, *shape)


def _flat(x: np.ndarray, shape: tuple[int, ...], total: int) -> np.ndarray:
    return (x if x.shape[1:] == shape else _over(x, shape)).reshape(len(x), total)


def _over(x: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """An array with the components first, broadcast over a batch."""
    missing = len(shape) - x.ndim + 1
    return np.broadcast_to(x.reshape(x.shape[:1] + (1,) * missing + x.shape[1:]), (len(x), *shape))


one, i, j, k, eps = (DualQuaternion(row) for row in np.eye(8, dtype=int)[:5])
"""One of the five from which all others are made, with whole coefficients."""
