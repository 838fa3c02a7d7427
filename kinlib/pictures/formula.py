"""Formulas that a page can evaluate: what a function does to some parameters, written down step by step.

kinlib's formulas run on all scalars, so also on one that writes down what is done to it.  The scalar carries its exact
value at one general point, a fraction.  A rational function that vanishes there vanishes everywhere, and two that
agree there are one and the same: so ``==`` has an answer, what is checked exactly stays checked exactly, and each
function is written down only once.  What no result needs is left out.
"""

from __future__ import annotations

import json
import math
import operator
import random
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from numbers import Rational, Real
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from kinlib.dual_quaternion import DualQuaternion

__all__ = ["Formula", "Traced", "record"]

DENOMINATOR = 2**31 - 1
"""Of the general point: a prime, so large that nothing vanishes there by chance."""

POINTS = 64
"""At how many points of the ranges a formula is compared with the function that was recorded."""

UNDECIDED = 1e-9
"""Values after a root, which are floats, are not called zero or different if they are nearer to zero than this."""

Value: TypeAlias = Fraction | float
Node: TypeAlias = int | float
"""A step by its number, or a constant."""

_NUMPY: dict[str, Callable[..., Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "neg": np.negative,
    "sqrt": np.sqrt, "abs": np.abs, "cos": np.cos, "sin": np.sin, "atan2": np.arctan2,
}  # fmt: skip
_COMPARE: dict[str, Callable[..., Any]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


class Step(NamedTuple):
    """One operation and what it is applied to; an input has its name for an operation."""

    operation: str
    operands: tuple[Node, ...] = ()


class Comparison(NamedTuple):
    """An order that was asked for, the answer at the general point, and the line that asked."""

    sign: str
    left: Node
    right: Node
    answer: bool
    where: str


class Tape:
    """The steps so far, and the comparisons that chose among them."""

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self.comparisons: list[Comparison] = []
        self._known: dict[Any, Traced] = {}

    def input(self, name: str, value: Fraction) -> Traced:
        """A parameter."""
        return self._write(Step(name), value)

    def apply(self, operation: str, operands: tuple[Node, ...], value: Value) -> Traced | int:
        """The result of an operation, which is an earlier one if that is the same function; or zero."""
        if not isinstance(value, Fraction):
            key: Any = (operation, operands)
            if key not in self._known:
                self._remember(key, self._write(Step(operation, operands), value))
            return self._known[key]
        if value == 0:
            return 0
        if value in self._known:
            return self._known[value]
        if -value in self._known:
            opposite = Step("neg", (self._known[-value].node,))
            return self._remember(value, self._write(opposite, value))
        return self._write(Step(operation, operands), value)

    def _write(self, step: Step, value: Value) -> Traced:
        self.steps.append(step)
        made = Traced(self, len(self.steps) - 1, value)
        return self._remember(value, made) if isinstance(value, Fraction) else made

    def _remember(self, key: Any, made: Traced) -> Traced:
        self._known[key] = made
        return made


class Traced:
    """A scalar that writes down what is done to it; it has a value at the general point."""

    __slots__ = ("node", "tape", "value")

    def __init__(self, tape: Tape, node: int, value: Value):
        self.tape, self.node, self.value = tape, node, value

    def _apply(self, operation: str, other: Any, swapped: bool = False) -> Any:
        value, node = _value_and_node(other)
        if value is None:
            return NotImplemented
        pairs = [(self.value, self.node), (value, node)]
        (left, a), (right, b) = reversed(pairs) if swapped else pairs
        return self.tape.apply(operation, (a, b), _ARITHMETIC[operation](left, right))

    def __add__(self, other: Any) -> Any:
        return self if _is_number(other, 0) else self._apply("+", other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if not isinstance(other, Traced) and isinstance(other, Real):
            return self + -other
        return self._apply("-", other)

    def __rsub__(self, other: Any) -> Any:
        return -self if _is_number(other, 0) else self._apply("-", other, swapped=True)

    def __mul__(self, other: Any) -> Any:
        if _is_number(other, 0):
            return 0
        if _is_number(other, 1):
            return self
        return -self if _is_number(other, -1) else self._apply("*", other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self * other if _is_number(other, 1) or _is_number(other, -1) else self._apply("/", other)

    def __rtruediv__(self, other: Any) -> Any:
        return 0 if _is_number(other, 0) else self._apply("/", other, swapped=True)

    def __neg__(self) -> Any:
        return self.tape.apply("neg", (self.node,), -self.value)

    def __pos__(self) -> Traced:
        return self

    def __pow__(self, exponent: Any) -> Any:
        if not isinstance(exponent, (int, np.integer)):
            return self.sqrt() if exponent == 0.5 else NotImplemented
        power = math.prod([self] * abs(int(exponent)))
        return 1 / power if exponent < 0 else power

    def __abs__(self) -> Any:
        return self._function("abs", abs(float(self.value)))

    def sqrt(self) -> Any:
        """The square root."""
        return self._function("sqrt", math.sqrt(self.value))

    def cos(self) -> Any:
        """The cosine of an angle in radians."""
        return self._function("cos", math.cos(self.value))

    def sin(self) -> Any:
        """The sine of an angle in radians."""
        return self._function("sin", math.sin(self.value))

    def arctan2(self, other: Any) -> Any:
        """The angle of the point (other, self) of a plane."""
        value, node = _value_and_node(other)
        return self.tape.apply("atan2", (self.node, node), math.atan2(self.value, value))

    def rarctan2(self, other: Any) -> Any:
        """The angle of the point (self, other) of a plane."""
        value, node = _value_and_node(other)
        return self.tape.apply("atan2", (node, self.node), math.atan2(value, self.value))

    def _function(self, operation: str, value: float) -> Any:
        return self.tape.apply(operation, (self.node,), value)

    def __eq__(self, other: object) -> Any:
        value, _ = _value_and_node(other)
        if value is None:
            return NotImplemented
        if not isinstance(self.value, Fraction) or not isinstance(value, Fraction):
            _refuse_undecided(self.value, value)
        return self.value == value

    def __hash__(self) -> int:
        return id(self)

    def __bool__(self) -> bool:
        return bool(self != 0)

    def _compare(self, sign: str, other: Any) -> Any:
        value, node = _value_and_node(other)
        if value is None:
            return NotImplemented
        answer = bool(_COMPARE[sign](self.value, value))
        self.tape.comparisons.append(Comparison(sign, self.node, node, answer, _asking_line()))
        return answer

    def __lt__(self, other: Any) -> Any:
        return self._compare("<", other)

    def __le__(self, other: Any) -> Any:
        return self._compare("<=", other)

    def __gt__(self, other: Any) -> Any:
        return self._compare(">", other)

    def __ge__(self, other: Any) -> Any:
        return self._compare(">=", other)

    def __float__(self) -> float:
        return float(self.value)

    def __repr__(self) -> str:
        return f"<a number that is {float(self.value):.6g} at the general point>"


_ARITHMETIC = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


def _is_number(x: Any, number: int) -> bool:
    return not isinstance(x, Traced) and isinstance(x, Real) and bool(x == number)


def _value_and_node(x: Any) -> tuple[Any, Any]:
    """The value of an operand and what stands for it on the tape; None for what is no finite real number."""
    if isinstance(x, Traced):
        return x.value, x.node
    if isinstance(x, Rational):
        return Fraction(int(x.numerator), int(x.denominator)), float(x)
    if isinstance(x, Real) and math.isfinite(x):
        return Fraction(float(x)), float(x)
    return None, None


def _refuse_undecided(left: Value, right: Value) -> None:
    if abs(float(left) - float(right)) <= UNDECIDED * max(abs(float(left)), abs(float(right)), 1.0):
        raise ValueError(
            f"{_asking_line()}: whether two numbers are equal cannot be told once a root, an absolute value or an "
            "angle has been taken; compare before that"
        )


def _asking_line() -> str:
    """The nearest line outside this file, as file:number."""
    frame = sys._getframe(1)
    while frame.f_code.co_filename == __file__ and frame.f_back:
        frame = frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"


# ---- formulas ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class Formula:
    """A function of some parameters as steps of arithmetic.

    Attributes
    ----------
    inputs : tuple of str
        The names of the parameters.
    steps : tuple of Step
        Each refers to steps before it by number; the inputs come first.
    outputs : nested lists and dicts
        Of numbers, and of steps as `Output`.
    """

    inputs: tuple[str, ...]
    steps: tuple[Step, ...]
    outputs: Any

    def __repr__(self) -> str:
        return f"<Formula of {', '.join(self.inputs)} in {len(self.steps) - len(self.inputs)} steps>"

    def evaluate(self, **values: Any) -> Any:
        """The results, in the same nested form, for numbers or arrays that broadcast.

        Examples
        --------
        >>> formula = record(lambda x, y: [x + y, x * x], {"x": (0, 1), "y": (0, 1)})
        >>> [value.tolist() for value in formula.evaluate(x=np.array([1.0, 2.0]), y=3.0)]
        [[4.0, 5.0], [1.0, 4.0]]
        """
        if set(values) != set(self.inputs):
            raise TypeError(f"expected values for {', '.join(self.inputs)}, got {', '.join(values) or 'none'}")
        found = _run(self.steps, values)
        return _mapped(self.outputs, lambda leaf: found[leaf.node] if isinstance(leaf, Output) else leaf)

    @property
    def javascript(self) -> str:
        """A function of the parameters that returns the results as nested arrays and objects.

        Examples
        --------
        >>> record(lambda x, y: [x + y, 2 / (x + y)], {"x": (0, 1), "y": (0, 1)}).javascript
        '(x,y)=>{const $2=x+y,$3=2/$2;return [$2,$3]}'
        """
        names = [*self.inputs, *(f"${n}" for n in range(len(self.inputs), len(self.steps)))]
        lines = [f"{name}={_in_javascript(step, names)}" for name, step in zip(names, self.steps, strict=True)]
        body = f"const {','.join(lines[len(self.inputs) :])};" if len(lines) > len(self.inputs) else ""
        return f"({','.join(self.inputs)})=>{{{body}return {_nested(self.outputs, names)}}}"


class Output(NamedTuple):
    """A result that is a step."""

    node: int


def record(
    function: Callable[..., Any],
    ranges: Mapping[str, tuple[float, float]],
    *,
    seed: int = 0,
    rtol: float = 1e-9,
    points: int = POINTS,
) -> Formula:
    """Write down what a function does to its parameters.

    The formula is compared with the function itself, and with all comparisons of size that it made, at random points of
    the ranges, before it is returned.

    Parameters
    ----------
    function : callable
        Takes the parameters by name; returns numbers, arrays, dual quaternions, or lists and dicts of these.  Other
        numbers in it should be exact: beside floats it would be computed in floats, and nothing could be recorded.
    ranges : mapping of str to (float, float)
        The least and the largest value of each parameter.
    seed : int
        Of the general point and of the points of comparison.
    rtol : float
        How far formula and function may differ, relative to the numbers in one row of results.
    points : int
        At how many points they are compared.

    Raises
    ------
    ValueError
        If the function cannot be recorded: it lost track of a parameter, or a comparison has different answers in the
        ranges; the message says which one, and where.

    Examples
    --------
    >>> formula = record(lambda x: (1 + x * i) * (1 - x * i), {"x": (-1, 1)})
    >>> formula
    <Formula of x in 3 steps>
    >>> [float(value) for value in formula.evaluate(x=0.5)]
    [1.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    chance = random.Random(seed)
    tape = Tape()
    inputs = {name: tape.input(name, _general(limits, chance)) for name, limits in ranges.items()}
    results = _mapped(function(**inputs), lambda leaf: Output(leaf.node) if isinstance(leaf, Traced) else float(leaf))
    places = {name: np.array([chance.uniform(*limits) for _ in range(points)]) for name, limits in ranges.items()}
    _check_comparisons(tape, places)
    formula = Formula(tuple(ranges), *_needed(tape.steps, len(ranges), results))
    _check_values(formula, function, places, rtol)
    return formula


def _general(limits: tuple[float, float], chance: random.Random) -> Fraction:
    """A number between two others, by chance."""
    low, high = (Fraction(limit) for limit in limits)
    if not low < high:
        raise ValueError(f"expected a range from a number to a larger one, got {limits}")
    return low + (high - low) * Fraction(chance.randrange(1, DENOMINATOR), DENOMINATOR)


def _needed(steps: Sequence[Step], inputs: int, results: Any) -> tuple[tuple[Step, ...], Any]:
    """The steps that the results need, numbered anew, and the results in these numbers."""
    wanted = {leaf.node for leaf in _leaves(results) if isinstance(leaf, Output)} | set(range(inputs))
    for n in range(len(steps) - 1, -1, -1):
        if n in wanted:
            wanted.update(node for node in steps[n].operands if isinstance(node, int))
    number = {old: new for new, old in enumerate(sorted(wanted))}

    def renamed(node: Node) -> Node:
        return number[node] if isinstance(node, int) else node

    kept = tuple(Step(steps[n].operation, tuple(map(renamed, steps[n].operands))) for n in sorted(wanted))
    return kept, _mapped(results, lambda leaf: Output(number[leaf.node]) if isinstance(leaf, Output) else leaf)


def _run(steps: Sequence[Step], values: Mapping[str, Any]) -> list[Any]:
    """The values of all steps."""
    found: list[Any] = []
    for operation, operands in steps:
        inputs = [found[node] if isinstance(node, int) else node for node in operands]
        found.append(_NUMPY[operation](*inputs) if inputs else values[operation])
    return found


def _check_comparisons(tape: Tape, points: Mapping[str, np.ndarray]) -> None:
    with np.errstate(all="ignore"):
        found = _run(tape.steps, points)
    for sign, left, right, answer, where in tape.comparisons:
        a, b = (found[node] if isinstance(node, int) else node for node in (left, right))
        other = np.broadcast_to(_COMPARE[sign](a, b), next(iter(points.values())).shape) != answer
        if other.any():
            raise ValueError(
                f"{where}: the answer of the comparison {sign} changes within the ranges, for instance at "
                f"{_at(points, int(np.argmax(other)))}: record the function on each side of it"
            )


def _check_values(
    formula: Formula, function: Callable[..., Any], points: Mapping[str, np.ndarray], rtol: float
) -> None:
    """Compare the formula with the function, each row of results by its largest number."""
    for n in range(next(iter(points.values())).size):
        point = {name: float(values[n]) for name, values in points.items()}
        results, wanted = formula.evaluate(**point), _mapped(function(**point), float)
        rounded = 1e-3 * min(1.0, max(map(abs, _leaves(wanted)), default=0.0) or 1.0)  # of rows that should be zero
        for found, expected in zip(_rows(results), _rows(wanted), strict=True):
            scale = max(rounded, *map(abs, expected))
            gap = max(abs(a - b) for a, b in zip(found, expected, strict=True))
            if not gap <= rtol * scale:
                raise ValueError(
                    f"the formula is not the function: at {_at(points, n)} they differ by {gap / scale:.3g} of the "
                    "size; the function lost track of a parameter (by float(), or beside a float: write 0.1 as "
                    "Fraction(1, 10)), or chose by its value"
                )


def _at(points: Mapping[str, np.ndarray], n: int) -> str:
    return ", ".join(f"{name} = {values[n]:.6g}" for name, values in points.items())


# ---- nested results ----------------------------------------------------------------------------------


def _mapped(results: Any, change: Callable[[Any], Any]) -> Any:
    """Nested results as lists and dicts, with every number changed."""
    if isinstance(results, DualQuaternion):
        results = results.coeffs
    if isinstance(results, np.ndarray):
        results = results.tolist()
    if isinstance(results, Mapping):
        return {name: _mapped(part, change) for name, part in results.items()}
    if isinstance(results, (list, tuple)) and not isinstance(results, Output):
        return [_mapped(part, change) for part in results]
    return change(results)


def _rows(results: Any) -> Iterator[list[Any]]:
    """The numbers next to each other in one list, list by list."""
    if isinstance(results, Mapping):
        results = list(results.values())
    elif not isinstance(results, list):
        results = [results]
    numbers = [part for part in results if not isinstance(part, (list, Mapping))]
    if numbers:
        yield numbers
    for part in results:
        if isinstance(part, (list, Mapping)):
            yield from _rows(part)


def _leaves(results: Any) -> Iterator[Any]:
    return (leaf for row in _rows(results) for leaf in row)


def _nested(results: Any, names: Sequence[str]) -> str:
    """Results as text of JavaScript."""
    if isinstance(results, Mapping):
        return "{" + ",".join(f"{json.dumps(name)}:{_nested(part, names)}" for name, part in results.items()) + "}"
    if isinstance(results, list):
        return "[" + ",".join(_nested(part, names) for part in results) + "]"
    return names[results.node] if isinstance(results, Output) else _constant(results)


def _constant(x: float) -> str:
    return repr(int(x) if x.is_integer() and abs(x) < 2**53 else x)


def _in_javascript(step: Step, names: Sequence[str]) -> str:
    if not step.operands:
        return step.operation
    texts = [names[node] if isinstance(node, int) else _constant(node) for node in step.operands]
    if step.operation == "neg":
        return f"-{texts[0]}"
    if step.operation in _ARITHMETIC:
        return f"{texts[0]}{step.operation}{texts[1]}"
    return f"Math.{step.operation}({','.join(texts)})"
