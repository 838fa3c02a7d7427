"""Numbers of ℚ(a), with a real and algebraic: what the one irrational step of the theory needs.

SymPy does the arithmetic; the class here makes an element print readably, convert, and mix with integers
and fractions, so that it can be a coefficient like any other.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cached_property, total_ordering
from numbers import Rational
from typing import Any

import numpy as np

__all__ = ["NumberField", "NumberFieldElement", "square_root"]


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

    def __init__(self, root):
        from sympy import QQ

        self.root = root
        self.domain = QQ.algebraic_field(root)

    @property
    def degree(self) -> int:
        """The dimension of ℚ(a) over ℚ."""
        return self.domain.mod.degree()

    @property
    def generator(self) -> NumberFieldElement:
        """The element a."""
        return self.element([1, 0])

    def element(self, coefficients) -> NumberFieldElement:
        """The polynomial in a with these rational coefficients, highest power first."""
        return NumberFieldElement(self, self.domain([_rational(c) for c in coefficients]))

    @cached_property
    def _digits(self) -> dict:
        return {}

    def root_to(self, digits: int):
        """The number a to so many digits."""
        if digits not in self._digits:
            self._digits[digits] = self.root.evalf(digits)
        return self._digits[digits]

    def __reduce__(self):
        return NumberField, (self.root,)

    def __eq__(self, other) -> bool:
        return isinstance(other, NumberField) and self.root == other.root

    def __hash__(self) -> int:
        return hash(self.root)

    def __repr__(self) -> str:
        from sympy import Poly, Symbol

        minimal = Poly.from_list([int(c) if c.denominator == 1 else c for c in self.domain.mod.to_list()], Symbol("a"))
        return f"ℚ(a), a = {float(self.root):.6g} a root of {minimal.as_expr()}"


def _rational(x):
    from sympy import QQ

    return QQ(int(x.numerator), int(x.denominator))


@total_ordering
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

    def __init__(self, field: NumberField, value):
        self.field = field
        self.value = value

    def _operate(self, other, operation):
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

    def __add__(self, other):
        return self._operate(other, lambda x, y: x + y)

    def __sub__(self, other):
        return self._operate(other, lambda x, y: x - y)

    def __rsub__(self, other):
        return self._operate(other, lambda x, y: y - x)

    def __mul__(self, other):
        return self._operate(other, lambda x, y: x * y)

    def __truediv__(self, other):
        if not other:
            raise ZeroDivisionError("division by zero")
        return self._operate(other, lambda x, y: x / y)

    def __rtruediv__(self, other):
        if not self:
            raise ZeroDivisionError("division by zero")
        return self._operate(other, lambda x, y: y / x)

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, exponent: int):
        if exponent < 0:
            return 1 / self**-exponent
        return NumberFieldElement(self.field, self.value**exponent)

    def __pos__(self):
        return self

    def __neg__(self):
        return NumberFieldElement(self.field, -self.value)

    def __abs__(self):
        return -self if self < 0 else self

    def __bool__(self) -> bool:
        return bool(self.value)

    def __eq__(self, other) -> bool:
        if isinstance(other, NumberFieldElement) and other.field != self.field:
            return bool(self.as_sympy().equals(other.as_sympy()))
        difference = self._operate(other, lambda x, y: x - y)
        if difference is NotImplemented:
            return NotImplemented
        return not difference if isinstance(difference, NumberFieldElement) else difference == 0

    def __lt__(self, other) -> bool:
        if isinstance(other, NumberFieldElement) and other.field != self.field:
            return float(self) < float(other)
        return float(self - other) < 0

    def __hash__(self) -> int:
        return hash(tuple(self.coefficients)) if len(self.coefficients) > 1 else hash(self.coefficients[0])

    @property
    def coefficients(self) -> list[Fraction]:
        """The rational coefficients of the polynomial in a, highest power first."""
        return [Fraction(int(c.numerator), int(c.denominator)) for c in self.value.to_list()] or [Fraction(0)]

    def __reduce__(self):
        return NumberField.element, (self.field, self.coefficients)

    def as_sympy(self):
        """The same number as a SymPy expression."""
        return self.field.domain.to_sympy(self.value)

    _sympy_ = as_sympy  # so that SymPy mixes with these numbers exactly, not through floats

    def _to(self, digits: int):
        from sympy import Float

        root, total = self.field.root_to(digits), Float(0, digits)
        for c in self.coefficients:
            total = total * root + Float(c.numerator, digits) / c.denominator
        return total

    def __float__(self) -> float:
        digits = 30
        while True:  # cancellation may eat digits: go on until twice as many change nothing
            coarse, fine = float(self._to(digits)), float(self._to(2 * digits))
            if not self or (fine != 0 and abs(coarse - fine) <= 1e-16 * abs(fine)):
                return fine if self else 0.0
            digits *= 2

    def __complex__(self) -> complex:
        return complex(float(self))

    def __repr__(self) -> str:
        powers = range(len(self.coefficients) - 1, -1, -1)
        terms = [_term(c, n) for c, n in zip(self.coefficients, powers, strict=True) if c]
        return " + ".join(terms[::-1]).replace("+ -", "- ") or "0"


def _term(coefficient: Fraction, power: int) -> str:
    name = {0: "", 1: "a"}.get(power, f"a**{power}")
    if not name:
        return str(coefficient)
    factor = {1: "", -1: "-"}.get(coefficient, f"{coefficient}*")
    return factor + name


def square_root(x) -> Any:
    """The non-negative root of a non-negative number, exact for exact numbers.

    Parameters
    ----------
    x : scalar or array of floats
        Not negative.

    Returns
    -------
    scalar
        A float for a float; a fraction where x is the square of one, else an element of ℚ(√x); for a number
        of ℚ(a) its root in the same field.

    Raises
    ------
    ValueError
        If x is negative, or a number of ℚ(a) that has no root there.

    Examples
    --------
    >>> square_root(Fraction(9, 4)), square_root(2)
    (Fraction(3, 2), a)
    """
    if isinstance(x, np.ndarray) and x.dtype.kind not in "fc":
        return np.frompyfunc(square_root, 1, 1)(x.astype(object))
    if hasattr(x, "free_symbols"):
        from sympy import sqrt

        return sqrt(x)
    if isinstance(x, NumberFieldElement):
        return _root_in_field(x)
    if not np.iscomplexobj(x) and np.any(np.less(x, 0)):
        raise ValueError(f"a negative number has no real square root: {x}")
    if not isinstance(x, (Rational, np.integer)):
        return np.sqrt(x)
    return _rational_root(Fraction(int(x.numerator), int(x.denominator)))


def _rational_root(x: Fraction):
    product = x.numerator * x.denominator
    root = math.isqrt(product)
    if root * root == product:
        return Fraction(root, x.denominator)
    from sympy import CRootOf, Poly, Symbol, factorint

    square_free = math.prod(p for p, n in factorint(product, limit=10**4).items() if n % 2)  # but for large squares
    field = NumberField(CRootOf(Poly([1, 0, -square_free], Symbol("a")), 1, radicals=True))
    return field.generator * Fraction(math.isqrt(product // square_free), x.denominator)


def _root_in_field(x: NumberFieldElement):
    from sympy import Poly, Symbol

    domain = x.field.domain
    _, factors = Poly([domain.one, domain.zero, -x.value], Symbol("t"), domain=domain).factor_list()
    if len(factors) == 1 and factors[0][0].degree() == 2:
        raise ValueError(f"{x!r} has no square root in {x.field!r}")
    root = NumberFieldElement(x.field, -factors[0][0].rep.to_list()[1])
    return abs(root)
