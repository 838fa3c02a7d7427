"""Numbers of ℚ(a), with a real and algebraic: what the one irrational step of the theory needs.

SymPy does the arithmetic; the class here makes an element print readably, convert, and mix with integers
and fractions, so that it can be a coefficient like any other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from numbers import Rational, Real
from operator import ge, gt, le, lt
from typing import Any

import numpy as np

from kinlib.scalar import ArrayLike, ScalarLike, as_scalars, plain

__all__ = ["NumberField", "NumberFieldElement", "square_root"]

DIGITS = 25
"""To how many digits a number is first computed where its sign or its nearest float is asked."""


class NumberField:
    """The field ℚ(a) of all polynomials in one real algebraic number a.

    Parameters
    ----------
    root : sympy.Expr
        The number a: a real ``CRootOf`` or a real radical.

    Examples
    --------
    >>> import sympy
    >>> field = NumberField(sympy.sqrt(2))
    >>> field.generator * field.generator
    2
    >>> field
    ℚ(a), a = 1.41421 a root of a**2 - 2
    """

    def __init__(self, root: Any):
        from sympy import QQ

        self.root = _real_algebraic(root)
        self.domain = QQ.algebraic_field(self.root)

    @property
    def degree(self) -> int:
        """The dimension of ℚ(a) over ℚ."""
        return int(self.domain.mod.degree())

    @property
    def generator(self) -> NumberFieldElement:
        """The element a."""
        return self.element([1, 0])

    def element(self, coefficients: Sequence[ScalarLike]) -> NumberFieldElement:
        """The polynomial in a with these rational coefficients, highest power first.

        Examples
        --------
        >>> import sympy
        >>> NumberField(sympy.sqrt(2)).element([1, 0, 0])
        2
        """
        value = self.domain([_rational(c) for c in coefficients])
        return NumberFieldElement(self, self.domain.one * value)  # the product is reduced

    @cached_property
    def _bounds(self) -> dict[int, tuple[int, int]]:
        return {}

    def root_within(self, digits: int) -> tuple[int, int]:
        """The number a in units of 10^−digits, rounded, and how far off that may be."""
        if digits not in self._bounds:
            near = _rational_near(self.root, digits + 10)
            self._bounds[digits] = round(near * 10**digits), 1 + int(abs(near))
        return self._bounds[digits]

    def __reduce__(self) -> tuple[Any, ...]:
        return NumberField, (self.root,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NumberField) and self.root == other.root

    def __hash__(self) -> int:
        return hash(self.root)

    def __repr__(self) -> str:
        from sympy import Poly, Symbol

        minimal = Poly.from_list([int(c) if c.denominator == 1 else c for c in self.domain.mod.to_list()], Symbol("a"))
        return f"ℚ(a), a = {float(self.root):.6g} a root of {minimal.as_expr()}"


def _real_algebraic(root: Any) -> Any:
    from sympy import Expr, sympify

    root = sympify(root) if isinstance(root, (int, Fraction)) else root
    if not isinstance(root, Expr):
        raise TypeError(f"expected a real algebraic number of SymPy, such as sqrt(2), got {root!r}")
    if root.free_symbols or not (root.is_algebraic and root.is_real):
        raise ValueError(f"expected a real algebraic number, got {root}")
    return root


def _rational_near(root: Any, digits: int) -> Fraction:
    """A number of SymPy to so many significant digits, as a fraction."""
    from sympy import Rational as Exact

    near = Exact(root.evalf(digits))
    return Fraction(int(near.p), int(near.q))


def _rational(x: Any) -> Any:
    from sympy import QQ

    x = int(x) if isinstance(x, (int, np.bool_)) else plain(x)
    if not isinstance(x, Rational):
        raise TypeError(f"expected whole numbers and fractions, got {x!r}")
    return QQ(int(x.numerator), int(x.denominator))


class NumberFieldElement:
    """A number of ℚ(a); integers and fractions mix with it exactly.

    Examples
    --------
    >>> a = square_root(5)
    >>> (1 + a) / 2 * (1 - a) / 2
    -1
    >>> round(float((1 + a) / 2), 6), ((1 + a) / 2).as_sympy()
    (1.618034, 1/2 + sqrt(5)/2)
    """

    __slots__ = ("field", "value")

    def __init__(self, field: NumberField, value: Any):
        self.field = field
        self.value = value

    def _operate(self, other: Any, operation: Callable[[Any, Any], Any]) -> Any:
        if isinstance(other, NumberFieldElement):
            if other.field != self.field:
                raise ValueError(f"numbers of two fields do not mix: {self.field!r} and {other.field!r}")
            return NumberFieldElement(self.field, operation(self.value, other.value))
        if isinstance(other, (Rational, np.integer)):
            return NumberFieldElement(self.field, operation(self.value, self.field.domain(_rational(other))))
        if isinstance(other, (float, complex)):
            return operation(float(self), other)
        if hasattr(other, "free_symbols"):
            return operation(self.as_sympy(), other)
        return NotImplemented

    def __add__(self, other: Any) -> Any:
        return self._operate(other, lambda x, y: x + y)

    def __sub__(self, other: Any) -> Any:
        return self._operate(other, lambda x, y: x - y)

    def __rsub__(self, other: Any) -> Any:
        return self._operate(other, lambda x, y: y - x)

    def __mul__(self, other: Any) -> Any:
        return self._operate(other, lambda x, y: x * y)

    def __truediv__(self, other: Any) -> Any:
        if not other:
            raise ZeroDivisionError("division by zero")
        return self._operate(other, lambda x, y: x / y)

    def __rtruediv__(self, other: Any) -> Any:
        if not self:
            raise ZeroDivisionError("division by zero")
        return self._operate(other, lambda x, y: y / x)

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, exponent: int) -> Any:
        if isinstance(exponent, float):
            return float(self) ** exponent
        if not isinstance(exponent, (int, np.integer)):
            return NotImplemented
        if exponent < 0:
            return 1 / self ** -int(exponent)
        return NumberFieldElement(self.field, self.value ** int(exponent))

    def __pos__(self) -> NumberFieldElement:
        return self

    def __neg__(self) -> NumberFieldElement:
        return NumberFieldElement(self.field, -self.value)

    def __abs__(self) -> NumberFieldElement:
        return -self if self < 0 else self

    def __bool__(self) -> bool:
        return bool(self.value)

    def __eq__(self, other: object) -> Any:
        """Whether two numbers are equal, exactly: floats are taken at their exact value."""
        if isinstance(other, NumberFieldElement) and other.field != self.field:
            return _equal_across_fields(self, other)
        if isinstance(other, (float, complex)):
            return _is_fraction_of(self, other)
        difference = self._operate(other, lambda x, y: x - y)
        if difference is NotImplemented:
            return NotImplemented
        return not difference if isinstance(difference, NumberFieldElement) else bool(difference == 0)

    def _compare(self, other: Any, relation: Callable[[Any, Any], bool]) -> Any:
        """The order of the real numbers, exactly; floats are taken at their exact value."""
        if hasattr(other, "free_symbols"):
            return bool(relation(self.as_sympy(), other))
        if isinstance(other, float):
            if not math.isfinite(other):
                return relation(0.0, other)
            other = Fraction(other)
        if not isinstance(other, (NumberFieldElement, Rational, np.integer)):
            return NotImplemented
        return relation(_order(self, other), 0)

    def __lt__(self, other: Any) -> Any:
        return self._compare(other, lt)

    def __le__(self, other: Any) -> Any:
        return self._compare(other, le)

    def __gt__(self, other: Any) -> Any:
        return self._compare(other, gt)

    def __ge__(self, other: Any) -> Any:
        return self._compare(other, ge)

    def __hash__(self) -> int:
        """That of the nearest float, which is the same for equal numbers of different fields."""
        if len(self.coefficients) == 1:
            return hash(self.coefficients[0])
        try:
            return hash(float(self))
        except OverflowError:
            return hash(math.inf if self > 0 else -math.inf)

    @property
    def coefficients(self) -> list[Fraction]:
        """The rational coefficients of the polynomial in a, highest power first."""
        return [Fraction(int(c.numerator), int(c.denominator)) for c in self.value.to_list()] or [Fraction(0)]

    def __reduce__(self) -> tuple[Any, ...]:
        return NumberField.element, (self.field, self.coefficients)

    def as_sympy(self) -> Any:
        """The same number as a SymPy expression."""
        return self.field.domain.to_sympy(self.value)

    _sympy_ = as_sympy  # so that SymPy mixes with these numbers exactly, not through floats

    def within(self, digits: int) -> tuple[int, int, int]:
        """Whole numbers v, e, u: this number is v / u up to an error of e / u, with a to so many digits."""
        root, error = self.field.root_within(digits)
        coefficients, largest = self.coefficients, abs(root) + error
        unit, power = math.lcm(*(c.denominator for c in coefficients)), 1
        value = slope = bound = 0
        for n, c in enumerate(coefficients):  # Horner's rule for the polynomial, and for a bound of its derivative
            power = 10 ** (digits * n)
            term = int(c * unit) * power
            slope, bound, value = slope * largest + bound, bound * largest + abs(term), value * root + term
        return value, slope * error, unit * power

    def __float__(self) -> float:
        """The nearest float."""
        if len(self.coefficients) == 1:
            return _ratio(*self.coefficients[0].as_integer_ratio())
        digits = DIGITS
        while True:  # cancellation may eat digits
            value, error, unit = self.within(digits)
            low, high = _ratio(value - error, unit), _ratio(value + error, unit)
            if low == high:
                return low
            digits *= 2

    @property
    def real(self) -> NumberFieldElement:
        """The number itself."""
        return self

    @property
    def imag(self) -> int:
        """0: all numbers of the field are real."""
        return 0

    def conjugate(self) -> NumberFieldElement:
        """The complex conjugate: the number itself."""
        return self

    def __complex__(self) -> complex:
        return complex(float(self))

    def __repr__(self) -> str:
        powers = range(len(self.coefficients) - 1, -1, -1)
        terms = [_term(c, n) for c, n in zip(self.coefficients, powers, strict=True) if c]
        return " + ".join(terms[::-1]).replace("+ -", "- ") or "0"

    def _latex(self, printer: Any) -> str:
        """What SymPy's printer asks for: square roots as such, numbers of higher fields in their generator a."""
        from sympy import Poly, Symbol

        rational = [c.numerator if c.denominator == 1 else c for c in self.coefficients]
        square = len(self.field.domain.mod.to_list()) == 3
        return str(printer.doprint(self.as_sympy() if square else Poly(rational, Symbol("a")).as_expr()))


def _ratio(numerator: int, denominator: int) -> float:
    """The nearest float to a fraction."""
    try:
        return numerator / denominator
    except OverflowError:
        raise OverflowError("the number is too large for a float (the largest is about 1.8e308)") from None


def _is_fraction_of(x: NumberFieldElement, y: float | complex) -> bool:
    """Whether a number is that float: an irrational one never is."""
    real, imaginary = (y.real, y.imag) if isinstance(y, complex) else (y, 0.0)
    return imaginary == 0 and math.isfinite(real) and not x - Fraction(real)


def _order(x: NumberFieldElement, y: Any) -> int:
    """The sign of x − y, by ever better fractions near both; equal numbers are found without them."""
    if x == y:
        return 0
    digits = DIGITS
    while True:
        (u, u_error, p), (v, v_error, q) = x.within(digits), _within(y, digits)
        difference = u * q - v * p
        if abs(difference) > u_error * q + v_error * p:
            return 1 if difference > 0 else -1
        digits *= 2


def _within(x: Any, digits: int) -> tuple[int, int, int]:
    if isinstance(x, NumberFieldElement):
        return x.within(digits)
    return int(x.numerator), 0, int(x.denominator)


def _equal_across_fields(x: NumberFieldElement, y: NumberFieldElement) -> bool:
    """Whether numbers of two fields are equal; if their nearest floats are, SymPy has to decide."""
    if hash(x) != hash(y):
        return False
    from sympy import Symbol, minimal_polynomial

    difference, t = x.as_sympy() - y.as_sympy(), Symbol("t")
    return bool(difference == 0 or minimal_polynomial(difference, t) == t)


Real.register(NumberFieldElement)


def _term(coefficient: Fraction, power: int) -> str:
    name = {0: "", 1: "a"}.get(power, f"a**{power}")
    if not name:
        return str(coefficient)
    factor = {Fraction(1): "", Fraction(-1): "-"}.get(coefficient, f"{coefficient}*")
    return factor + name


def square_root(x: ArrayLike) -> Any:
    """The non-negative root of a non-negative number, exact for exact numbers.

    Parameters
    ----------
    x : scalar or array
        Not negative.

    Returns
    -------
    scalar or numpy.ndarray
        A float for a float; a fraction where x is the square of one, else an element of ℚ(√x); for a number
        of ℚ(a) its root in the same field.

    Raises
    ------
    ValueError
        If x is negative, or a number of ℚ(a) that has no root there.
    TypeError
        If x is no number.

    Examples
    --------
    >>> square_root(Fraction(9, 4)), square_root(2)
    (Fraction(3, 2), a)
    """
    if isinstance(x, (float, np.floating)) and x >= 0:
        return np.sqrt(x)
    array = as_scalars(x)
    if array.dtype.kind == "O":
        return _exact_root(array[()]) if array.ndim == 0 else np.frompyfunc(_exact_root, 1, 1)(array)
    if array.dtype.kind == "f" and (array < 0).any():
        raise ValueError(f"a negative number has no real square root: {array[array < 0].flat[0]}")
    return np.sqrt(array)[()]


def _exact_root(x: Any) -> Any:
    if hasattr(x, "free_symbols"):
        from sympy import sqrt

        return sqrt(x)
    if isinstance(x, NumberFieldElement):
        if x < 0:
            raise ValueError(f"a negative number has no real square root: {x}")
        return _root_in_field(x)
    if not isinstance(x, Rational):
        raise TypeError(f"expected a number that has a square root, got {x!r}")
    if x < 0:
        raise ValueError(f"a negative number has no real square root: {x}")
    return _rational_root(Fraction(x))


def _rational_root(x: Fraction) -> Any:
    product = x.numerator * x.denominator
    root = math.isqrt(product)
    if root * root == product:
        return Fraction(root, x.denominator)
    from sympy import CRootOf, Poly, Symbol, factorint

    square_free = math.prod(p for p, n in factorint(product, limit=10**4).items() if n % 2)  # but for large squares
    field = NumberField(CRootOf(Poly([1, 0, -square_free], Symbol("a")), 1, radicals=True))
    return field.generator * Fraction(math.isqrt(product // square_free), x.denominator)


def _root_in_field(x: NumberFieldElement) -> Any:
    from sympy import Poly, Symbol

    domain = x.field.domain
    _, factors = Poly([domain.one, domain.zero, -x.value], Symbol("t"), domain=domain).factor_list()
    if len(factors) == 1 and factors[0][0].degree() == 2:
        raise ValueError(f"{x!r} has no square root in {x.field!r}")
    root = NumberFieldElement(x.field, -factors[0][0].rep.to_list()[1])
    return abs(root)
