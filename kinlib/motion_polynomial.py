"""Polynomials in one real parameter t with dual quaternion coefficients; t commutes with everything."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, TypeAlias, TypeVar, Union

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form, one, pieces_in_latex, study_form, wrap
from kinlib.errors import Fault, named_rows, report_faults
from kinlib.scalar import ROUNDING, RTOL, as_scalars, divide, is_exact, is_infinite, is_zero, promote, size
from kinlib.shown import as_sum, in_lines
from kinlib.typing import Array, ArrayLike, Degenerate, PointLike, ScalarLike

__all__ = ["MotionPolynomial", "RationalCurve", "evaluate", "linear_factor", "multiply"]

PolynomialLike: TypeAlias = Union["MotionPolynomial", DualQuaternion, ArrayLike]
"""What polynomials compute with: a polynomial, or a constant, which is a dual quaternion or a number."""

Coefficient = TypeVar("Coefficient", DualQuaternion, Array)


@dataclass(frozen=True, eq=False)
class RationalCurve:
    """A rational curve of space: homogeneous coordinates (w, x, y, z), polynomials in t.

    Parameters
    ----------
    coeffs : array_like, shape (..., m+1, 4)
        Highest power first.
    """

    coeffs: Array

    def __post_init__(self) -> None:
        coeffs = as_scalars(self.coeffs)
        if coeffs.ndim < 2 or coeffs.shape[-1] != 4:
            raise ValueError(f"expected coefficients of shape (..., m+1, 4), got {coeffs.shape}")
        coeffs.setflags(write=False)
        object.__setattr__(self, "coeffs", coeffs)

    @property
    def degree(self) -> int:
        """The formal degree m of the coordinates."""
        return self.coeffs.shape[-2] - 1

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return self.coeffs.shape[:-2]

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single curve has no length; its coefficients are in .coeffs")
        return self.shape[0]

    def __getitem__(self, index: Any) -> RationalCurve:
        """Entries of the batch."""
        if not self.shape:
            raise TypeError("a single curve has no entries; its coefficients are in .coeffs")
        index = index if isinstance(index, tuple) else (index,)
        return RationalCurve(self.coeffs[(*index, Ellipsis, slice(None), slice(None))])

    def __iter__(self) -> Iterator[RationalCurve]:
        return (self[n] for n in range(len(self)))

    def __call__(self, t: ScalarLike | ArrayLike) -> np.ndarray:
        """The points at parameter values t, shape (..., 3); t broadcasts against the batch."""
        coeffs, t = promote(self.coeffs, as_scalars(t))
        rows = [coeffs[..., n, :] for n in range(self.degree + 1)]
        w, *x = np.moveaxis(evaluate(rows, t[..., None] if t.ndim else t[()]), -1, 0)
        return np.stack([divide(y, w) for y in x], axis=-1)


class MotionPolynomial:
    """C(t) = c_n tⁿ + … + c_0: a rational motion if C C̄ is a real polynomial.

    Parameters
    ----------
    coeffs : array_like, shape (..., n+1, 8)
        The dual quaternions c_n, …, c_0, highest power first, any scalars; leading axes are a batch.

    Examples
    --------
    >>> C = linear_factor(i) * linear_factor(j - eps * i)
    >>> C.degree, C.norm_polynomial().tolist()
    (2, [1, 0, 2, 0, 1])
    >>> C(0) == i * (j - eps * i)
    True
    """

    __slots__ = ("_coefficients", "_columns", "_factors")
    _coefficients: tuple[DualQuaternion, ...]
    _columns: Array | None
    _factors: tuple[tuple[DualQuaternion, ...], DualQuaternion] | None
    __array_ufunc__ = None

    def __init__(self, coeffs: ArrayLike):
        array = as_scalars(coeffs)
        if array.ndim < 2 or array.shape[-1] != 8 or array.shape[-2] == 0:
            raise ValueError(f"expected coefficients of shape (..., n+1, 8), got {array.shape}")
        self._keep(DualQuaternion(array[..., n, :]) for n in range(array.shape[-2]))

    @classmethod
    def from_coefficients(cls, coefficients: Iterable[DualQuaternion]) -> MotionPolynomial:
        """The polynomial with these dual quaternions as coefficients, highest power first."""
        self = object.__new__(cls)
        self._keep(coefficients)
        return self

    @classmethod
    def from_factors(cls, factors: Sequence[DualQuaternion], last: DualQuaternion = one) -> MotionPolynomial:
        """The polynomial (t − h_1) ⋯ (t − h_n) c with the given h_1, …, h_n and the constant c.

        In floats its values are computed as this product: where it nearly vanishes, its coefficients lose digits.

        Examples
        --------
        >>> MotionPolynomial.from_factors([i, j - eps * i])
        t^2 + (-i - j + εi) t + k + ε
        """
        factors, unit = tuple(factors), one
        coefficients = reduce(multiply, [[unit, -h] for h in factors], [unit])
        self = cls.from_coefficients(c * last for c in coefficients)
        if factors and not any(is_exact(h.components) for h in factors):
            object.__setattr__(self, "_factors", (factors, last))
        return self

    def _keep(self, coefficients: Iterable[DualQuaternion]) -> None:
        object.__setattr__(self, "_coefficients", tuple(coefficients))
        object.__setattr__(self, "_columns", None)
        object.__setattr__(self, "_factors", None)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a motion polynomial does not change: {name} cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a motion polynomial does not change: {name} cannot be deleted")

    def __reduce__(self) -> tuple[Any, ...]:
        if self._factors is not None:
            return MotionPolynomial.from_factors, self._factors
        return MotionPolynomial.from_coefficients, (self.coefficients,)

    @property
    def coefficients(self) -> tuple[DualQuaternion, ...]:
        """c_n, …, c_0, each of the shape of the batch (or of one that broadcasts to it)."""
        return self._coefficients

    @property
    def coeffs(self) -> np.ndarray:
        """All coefficients, shape (..., n+1, 8)."""
        return DualQuaternion.stack(self.coefficients, axis=-1).coeffs

    @property
    def degree(self) -> int:
        """The formal degree n: the leading coefficient may vanish."""
        return len(self.coefficients) - 1

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return np.broadcast_shapes(*[c.shape for c in self.coefficients])

    @property
    def leading(self) -> DualQuaternion:
        """The coefficient of the highest power: the pose at t = ∞."""
        return self.coefficients[0]

    def __call__(self, t: ScalarLike | ArrayLike) -> DualQuaternion:
        """The pose at t.

        Parameters
        ----------
        t : scalar or array_like
            Broadcasts against the batch; ``math.inf`` gives the leading coefficient, and a float t whose powers
            are too large to be computed with gives C(t)/tⁿ, which is the same pose.
        """
        if self._factors is not None:
            return self._product_at(t, *self._factors)
        if np.asarray(t).ndim == 0 or any(c.shape for c in self._coefficients):
            first, *others = self.coefficients
            return evaluate((first + others[0] * 0, *others) if others else (first,), t)
        columns = self._columns
        if columns is None:
            columns = np.stack(promote(*(c.components for c in self.coefficients)), axis=-1)
            object.__setattr__(self, "_columns", columns)
        return wrap(_evaluate(columns, t if type(t) is np.ndarray and t.dtype == float else as_scalars(t)))

    def _product_at(
        self, t: ScalarLike | ArrayLike, factors: Sequence[DualQuaternion], last: DualQuaternion
    ) -> DualQuaternion:
        """The value at t from the factors; from the coefficients where powers of t are too large."""
        t = as_scalars(t)
        finite = t if t.dtype.kind not in "fc" else np.where(np.abs(t) > _too_large(self.degree), 1.0, t)
        x: Any = finite[()]
        product = reduce(lambda q, h: q * (x - h), factors[1:], x - factors[0]) * last
        if finite is t or np.all(finite == t):
            return product
        far = evaluate(self.coefficients, t)
        large = np.broadcast_to(finite != t, product.shape)
        return DualQuaternion(np.where(large[..., None], far.coeffs, product.coeffs))

    def conjugate(self) -> MotionPolynomial:
        """C̄, with conjugate coefficients: the inverse motion."""
        return self.from_coefficients(c.conjugate() for c in self.coefficients)

    def norm_polynomial(self) -> np.ndarray:
        """The real polynomial C C̄ (its primal part), shape (..., 2n+1), highest power first."""
        return _convolve(null_form, self.coefficients)

    def study_polynomial(self) -> np.ndarray:
        """The dual part of C C̄, shape (..., 2n+1); it vanishes for a motion."""
        return _convolve(study_form, self.coefficients)

    def is_motion(self, *, rtol: float = RTOL) -> bool | Array:
        """Whether C C̄ is real and not zero, so that every C(t) is a point of the Study quadric.

        Floats are judged by the size of the numbers that are added, and dual parts that may be the rounding of
        primal parts count as zero.
        """
        zero = np.all(is_zero(self.norm_polynomial(), rtol=0), axis=-1)
        return (self._is_on_quadric(rtol) & ~zero)[()]

    def _is_on_quadric(self, rtol: float) -> Array:
        coeffs = self.coeffs
        primal, dual = size(coeffs[..., :4], (-1, -2)), size(coeffs[..., 4:], (-1, -2))
        bound = np.expand_dims(rtol * primal * dual + ROUNDING * primal * primal, -1)
        return np.all(is_zero(self.study_polynomial(), bound, 1.0), axis=-1)

    def __add__(self, other: PolynomialLike) -> MotionPolynomial:
        longer, shorter = self.coefficients, _polynomial(other).coefficients
        if len(longer) < len(shorter):
            longer, shorter = shorter, longer
        gap = len(longer) - len(shorter)
        lower = (a + b for a, b in zip(longer[gap:], shorter, strict=True))
        return self.from_coefficients((*longer[:gap], *lower))

    __radd__ = __add__

    def __neg__(self) -> MotionPolynomial:
        return self.from_coefficients(-c for c in self.coefficients)

    def __sub__(self, other: PolynomialLike) -> MotionPolynomial:
        return self + -_polynomial(other)

    def __rsub__(self, other: PolynomialLike) -> MotionPolynomial:
        return _polynomial(other) + -self

    def __mul__(self, other: PolynomialLike) -> MotionPolynomial:
        return self.from_coefficients(multiply(self.coefficients, _polynomial(other).coefficients))

    def __rmul__(self, other: PolynomialLike) -> MotionPolynomial:
        return _polynomial(other) * self

    def __divmod__(self, divisor: MotionPolynomial) -> tuple[MotionPolynomial, MotionPolynomial]:
        """Quotient Q and remainder R of the division from the right: C = Q M + R.

        The leading coefficient of the divisor M must be invertible.

        Examples
        --------
        >>> quotient, remainder = divmod(linear_factor(i) * linear_factor(j), linear_factor(j))
        >>> quotient == linear_factor(i), remainder == 0
        (True, True)
        """
        divisor = _polynomial(divisor)
        inverse = divisor.leading.inverse()
        rest, quotient = list(self.coefficients), []
        for n in range(self.degree - divisor.degree + 1):
            quotient.append(rest[n] * inverse)
            for m, c in enumerate(divisor.coefficients[1:], start=n + 1):
                rest[m] = rest[m] - quotient[n] * c
        zero = one * 0
        remainder = rest[max(len(rest) - divisor.degree, 0) :]
        return self.from_coefficients(quotient or [zero]), self.from_coefficients(remainder or [zero])

    def __eq__(self, other: Any) -> Any:
        """Whether all coefficients agree; one answer a batch entry."""
        try:
            difference = self - other
        except TypeError:
            return NotImplemented
        equal = reduce(np.logical_and, [c == 0 for c in difference.coefficients])
        return bool(equal) if np.ndim(equal) == 0 else equal

    def __ne__(self, other: object) -> Any:
        equal = self == other
        return ~equal if isinstance(equal, np.ndarray) else not equal

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single motion polynomial has no length; its coefficients are in .coefficients")
        return self.shape[0]

    def __iter__(self) -> Iterator[MotionPolynomial]:
        return (self[n] for n in range(len(self)))

    def __getitem__(self, index: Any) -> MotionPolynomial:
        """Entries of the batch."""
        if not self.shape:
            raise TypeError("a single motion polynomial has no entries; its coefficients are in .coefficients")
        index = index if isinstance(index, tuple) else (index,)
        return MotionPolynomial(self.coeffs[(*index, Ellipsis, slice(None), slice(None))])

    def __repr__(self) -> str:
        if self.shape:
            return f"MotionPolynomial of degree {self.degree}, shape {self.shape}"
        terms = [_term(c, self.degree - n) for n, c in enumerate(self.coefficients) if c != 0]
        return as_sum(terms)

    def _repr_latex_(self) -> str | None:
        """A single one as a formula, with a line for each power if it is long."""
        if self.shape:
            return None
        terms = [_latex_term(c, self.degree - n) for n, c in enumerate(self.coefficients) if c != 0]
        return f"${in_lines(terms[:1] + [f'+ {term}' for term in terms[1:]], len(repr(self))) or '0'}$"

    def trajectory(self, point: PointLike) -> RationalCurve:
        """The path of a point, shape (3,), of the moving frame: a rational curve of degree at most 2n.

        By equation (1) its coordinates are p p̄ and the vector part of p x p̄ + d p̄ − p d̄.

        Examples
        --------
        >>> circle = linear_factor(k).trajectory([1, 0, 0])
        >>> circle(0).tolist(), circle.degree
        ([Fraction(-1, 1), Fraction(0, 1), Fraction(0, 1)], 2)
        """
        x = DualQuaternion(np.concatenate([[1], np.zeros(4, dtype=int), as_scalars(point)]))
        mirrored = [c.eps_conjugate().conjugate() for c in self.coefficients]
        path = multiply([c * x for c in self.coefficients], mirrored)
        return RationalCurve(DualQuaternion.stack(path, axis=-1).coeffs[..., [0, 5, 6, 7]])

    def same_motion(self, other: MotionPolynomial, *, rtol: float = RTOL) -> bool:
        """Whether two polynomials move everything alike: C = λD with real polynomials on both sides.

        Examples
        --------
        >>> C = linear_factor(i)
        >>> (C * MotionPolynomial([one.coeffs, (2 * one).coeffs])).same_motion(C)
        True
        """
        coeffs = (self.conjugate() * other).coeffs
        (p, d), (r, e) = ((size(C.coeffs[..., :4]), size(C.coeffs[..., 4:])) for C in (self, other))
        turning = is_zero(coeffs[..., 1:4], p * r, rtol)
        shifting = is_zero(coeffs[..., 5:], p * e + d * r, rtol)
        return bool(np.all(turning) and np.all(shifting))


def linear_factor(h: DualQuaternion) -> MotionPolynomial:
    """The polynomial t − h; if h is a half-turn, it turns by −2 arccot t about the axis of h.

    Examples
    --------
    >>> linear_factor(i)
    t - i
    """
    return MotionPolynomial.from_coefficients((one, -h))


def _term(c: DualQuaternion, power: int) -> str:
    name = {0: "", 1: "t"}.get(power, f"t^{power}")
    text = repr(c)
    if not name:
        return text
    return name if text == "1" else f"({text}) {name}"


def _latex_term(c: DualQuaternion, power: int) -> str:
    name = {0: "", 1: "t"}.get(power, f"t^{{{power}}}")
    text = " ".join(pieces_in_latex(c))
    return name if name and text == "1" else rf"\left({text}\right) {name}".strip()


def _polynomial(x: PolynomialLike) -> MotionPolynomial:
    """A dual quaternion or a scalar as a constant polynomial."""
    if isinstance(x, MotionPolynomial):
        return x
    return MotionPolynomial.from_coefficients([x if isinstance(x, DualQuaternion) else one * x])


def multiply(left: Sequence[DualQuaternion], right: Sequence[DualQuaternion]) -> list[DualQuaternion]:
    """The coefficients of the product of two polynomials, given by theirs, highest power first."""
    total: dict[int, DualQuaternion] = {}
    for n, a in enumerate(left):
        for m, b in enumerate(right):
            total[n + m] = total[n + m] + a * b if n + m in total else a * b
    return [total[n] for n in range(len(total))]


def _convolve(form: Callable[[DualQuaternion, DualQuaternion], Array], items: Sequence[DualQuaternion]) -> np.ndarray:
    """Σ form(x_n, x_m) over n + m = r, for r = 0, 1, …, on the last axis."""
    count = len(items)
    sums = [
        sum(form(items[n], items[r - n]) for n in range(max(0, r - count + 1), min(r, count - 1) + 1))
        for r in range(2 * count - 1)
    ]
    return np.stack(np.broadcast_arrays(*sums), axis=-1)


def evaluate(coefficients: Sequence[Coefficient], t: ScalarLike | ArrayLike) -> Coefficient:
    """Horner's rule for coefficients of any kind; at infinity the leading one.  t broadcasts with the batch."""
    values = np.asarray(t)
    if values.dtype.kind in "fc":
        large = np.abs(values) > _too_large(len(coefficients) - 1)
        return _evaluate_far_away(coefficients, t, large) if np.any(large) else _horner(coefficients, t)
    infinite = is_infinite(t)
    return coefficients[0] if infinite else _horner(coefficients, t)


HUGE = 1e120
"""What is larger than this is not left to be squared."""


def _too_large(degree: int) -> float:
    """From where on powers of t are too large: products of three linear factors can still be squared."""
    return HUGE ** (1 / max(degree, 3))


def _horner(coefficients: Sequence[Coefficient], t: Any) -> Coefficient:
    return reduce(lambda total, c: total * t + c, coefficients)


def _evaluate_far_away(coefficients: Sequence[Coefficient], t: Any, large: Array) -> Coefficient:
    """C(t), or C(t)/tⁿ where the powers of t are too large: then it is a polynomial in 1/t."""
    if np.ndim(t) == 0:
        return coefficients[0] if np.isinf(t) else _horner(coefficients[::-1], 1 / t)
    near = _horner(coefficients, np.where(large, 0.0, t))
    far = _horner(coefficients[::-1], 1 / np.where(large, t, 1.0))
    return near * np.where(large, 0.0, 1.0) + far * np.where(large, 1.0, 0.0)


def _evaluate(columns: np.ndarray, t: np.ndarray) -> np.ndarray:
    """One polynomial at an array of parameters, as the product of its coefficients, shape (8, n+1), and powers."""
    columns, t = promote(columns, t)
    flat, count = t.ravel(), columns.shape[-1]
    powers = np.empty((count, t.size), dtype=t.dtype)
    powers[-1], powers[-2:-1] = 1, flat
    with np.errstate(over="ignore", invalid="ignore"):
        for n in range(count - 3, -1, -1):
            np.multiply(powers[n + 1], flat, out=powers[n])
        largest = np.vdot(flat, flat).real if t.dtype.kind in "fc" else 0.0
    bound = _too_large(count - 1)
    if not largest <= bound**2:
        large = np.abs(flat) > bound
        for n in range(count):
            powers[n, large] = (1 / flat[large]) ** n
    return (columns @ powers).reshape(8, *t.shape)


class MotionFault(Fault):
    """Why a polynomial is no motion."""

    OFF_QUADRIC = 1, "C C̄ is not a real polynomial: the curve leaves the Study quadric"


def check_monic(C: MotionPolynomial, degenerate: Degenerate = "raise") -> np.ndarray:
    """Refuse what is no motion polynomial that starts at the identity; or tell which rows are none."""
    if not isinstance(C, MotionPolynomial):
        raise TypeError(f"expected a MotionPolynomial, got {C!r}")
    monic = np.all(is_zero((C.leading - 1).coeffs, rtol=RTOL), axis=-1)
    undefined = np.isnan(size(C.leading.coeffs, -1)) if degenerate == "nan" else False
    if not np.all(monic | undefined):
        rows = named_rows(np.flatnonzero(~monic & ~undefined) if np.ndim(monic) else ())
        raise ValueError(f"{rows}expected a monic polynomial (the identity at t = ∞): factor C * C.leading.inverse()")
    return report_faults(~np.asarray(C._is_on_quadric(RTOL)) * MotionFault.OFF_QUADRIC, MotionFault, degenerate)
