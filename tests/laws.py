"""One law, all shapes: runs a law over the batches and the kinds of numbers that a user may bring.

A law is a function that asserts something of the things that it is given.  :func:`law` says which things these are,
and makes it a test for each kind of scalar and each shape of a batch.  Functions that work row by row have laws in
common; :class:`Rowwise` says how such a function is called, and the tests in ``test_laws.py`` run through all of them.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import pytest

from kinlib import (
    DualQuaternion,
    Dyad,
    Line,
    Linkage,
    MotionPolynomial,
    RationalCurve,
    TwoRSpace,
    same_point,
    square_root,
    translation,
    unit,
)  # fmt: skip

SHAPES = ((), (1,), (3, 1, 2))
EXACT = ("fraction", "field")
REAL = ("float", *EXACT)
ALL = (*REAL, "complex", "symbol")
LENGTHS = (1e-6, 1e6)
IN_SPACE = {"point", "pose", "line", "half_turn", "rotation", "dyad", "motion"}
"""What has a place in space, so that the unit of length matters."""
COVERED: set[str] = set()
"""The public names that some law is about."""


def _few(kind: str, shapes: tuple[tuple[int, ...], ...]) -> list[tuple[int, ...]]:
    """The shapes for a kind of numbers: symbols come alone, and batches over a field are small, since both are slow."""
    if kind == "symbol":
        return [shape for shape in shapes if shape == ()]
    return [(2, 1) if kind == "field" and shape == SHAPES[-1] else shape for shape in shapes]


def law(*names: str, kinds=("float", "fraction"), shapes=SHAPES, lengths=LENGTHS, **arguments: str):
    """Make a law about the public ``names`` a test for each kind of scalar and each shape.

    ``arguments`` tells what to draw for each argument: the name of a method of :class:`Draw`.
    """
    COVERED.update(names)
    settings = [(kind, shape, 1.0) for kind in kinds for shape in _few(kind, shapes)]
    if "float" in kinds and set(arguments.values()) & IN_SPACE:
        settings += [("float", shapes[0], length) for length in lengths]

    def decorate(function: Callable) -> Callable:
        @pytest.mark.parametrize(("kind", "shape", "length"), settings, ids=lambda x: str(x).replace(" ", ""))
        def test(kind, shape, length):
            draw = Draw(kind, shape, seed=zlib.crc32(function.__name__.encode()), length=length)
            function(**{name: getattr(draw, what)() for name, what in arguments.items()})

        test.__name__, test.__doc__ = function.__name__, function.__doc__
        return test

    return decorate


@dataclass
class Draw:
    """Draws things over one kind of scalar, in batches of one shape; always the same for the same seed."""

    kind: str = "float"
    shape: tuple[int, ...] = ()
    seed: int = 0
    length: float = 1.0
    random: np.random.Generator = field(init=False)

    def __post_init__(self):
        self.random = np.random.default_rng(self.seed)

    def numbers(self, *tail: int) -> np.ndarray:
        """Numbers of the kind, not zero, shape (*shape, *tail)."""
        shape = (*self.shape, *tail)
        if self.kind == "float":
            return self.random.normal(size=shape)
        if self.kind == "complex":
            return self.random.normal(size=shape) + 1j * self.random.normal(size=shape)
        whole = self.random.integers(1, 8, shape) * self.random.choice([-1, 1], shape)
        numbers = np.empty(shape, dtype=object)
        for index in np.ndindex(*shape):
            numbers[index] = self._exact(int(whole[index]))
        return numbers

    def _exact(self, n: int):
        if self.kind == "field":
            return n + int(self.random.integers(-2, 3)) * square_root(2)
        if self.kind == "symbol":
            from sympy import Symbol

            return n + Symbol("x", real=True) * int(self.random.integers(0, 2))
        return Fraction(n, int(self.random.integers(1, 4)))

    def scalar(self):
        return self.numbers()[()]

    def vector(self) -> np.ndarray:
        return self.numbers(3)

    def point(self) -> np.ndarray:
        """In units of the length."""
        return self.numbers(3) if self.length == 1 else self.numbers(3) * self.length

    def dual_quaternion(self) -> DualQuaternion:
        return DualQuaternion(self.numbers(8))

    def pose(self) -> DualQuaternion:
        """A point of the Study quadric, with a primal part of any length."""
        turn = np.concatenate([self.numbers(4), np.zeros((*self.shape, 4), dtype=int)], axis=-1)
        return translation(self.point()) * DualQuaternion(turn)

    def line(self) -> Line:
        return Line.at(self.point(), self.vector())

    def half_turn(self) -> DualQuaternion:
        """About a line; with a direction of length 1 for floats."""
        h = self.line().as_dual_quaternion()
        return unit(h) if self.kind == "float" else h

    def rotation(self) -> DualQuaternion:
        """Any linear factor's h: a number and a multiple of a half-turn."""
        return self.half_turn() * self.scalar() + self.scalar()

    def dyad(self) -> Dyad:
        return Dyad(self.half_turn(), self.half_turn(), self.pose())

    def polynomial(self) -> MotionPolynomial:
        """Of degree 2, with any coefficients."""
        return MotionPolynomial.from_coefficients([self.dual_quaternion() for _ in range(3)])

    def motion(self) -> MotionPolynomial:
        """The product of two linear factors: a motion."""
        return MotionPolynomial.from_coefficients([DualQuaternion([1] + [0] * 7), -self.rotation()]) * (
            MotionPolynomial.from_coefficients([DualQuaternion([1] + [0] * 7), -self.rotation()])
        )

    def angle(self):
        return self.random.uniform(-3, 3, self.shape)[()]

    def z(self):
        return (self.random.normal(size=self.shape) + 1j * self.random.normal(size=self.shape))[()]


# --- what agrees ------------------------------------------------------------------------------------------------


def arrays_of(thing) -> list[tuple[np.ndarray, int]]:
    """The numbers in what a function returns: arrays, and how many of their last axes are not the batch."""
    if isinstance(thing, DualQuaternion):
        return [(thing.coeffs, 1)]
    if isinstance(thing, Line):
        return [(thing.direction, 1), (thing.moment, 1)]
    if isinstance(thing, (MotionPolynomial, RationalCurve)):
        return [(thing.coeffs, 2)]
    if isinstance(thing, Dyad):
        return arrays_of([thing.h1, thing.h2, thing.home])
    if isinstance(thing, TwoRSpace):
        return arrays_of(thing.dyad)
    if isinstance(thing, Linkage):
        return arrays_of([*thing.factors, thing.home, *thing.parameters])
    if isinstance(thing, (tuple, list)):
        return [pair for part in thing for pair in arrays_of(part)]
    return [(np.asarray(thing), 0)]


def row_of(thing, shape, index) -> list[np.ndarray]:
    """The numbers of one row of a batch."""
    arrays = arrays_of(thing)
    return [np.broadcast_to(x, (*shape, *x.shape[x.ndim - tail :]))[index] for x, tail in arrays]


def assert_same(actual, expected, *, rtol: float = 1e-9) -> None:
    """Equal for exact numbers; for floats up to rounding, with NaN where NaN is expected."""
    actual, expected = ([x for x, _ in arrays_of(thing)] for thing in (actual, expected))
    assert len(actual) == len(expected)
    for x, y in zip(actual, expected, strict=True):
        assert_same_numbers(x, y, rtol=rtol)


def assert_zero(x, scale=1.0, *, rtol: float = 1e-9) -> None:
    """Zero for exact numbers; for floats, as compared with numbers of the given scale."""
    x = np.asarray(x)
    if x.dtype == object:
        assert all(_is_zero(n) for n in x.flat), f"{x} is not zero"
    else:
        assert np.abs(x).max(initial=0) <= rtol * np.abs(np.asarray(scale, dtype=float)).max(initial=0)


def assert_same_numbers(x, y, *, rtol: float = 1e-9) -> None:
    """As :func:`assert_same`, for arrays."""
    x, y = np.broadcast_arrays(np.asarray(x), np.asarray(y))
    if x.dtype == object and y.dtype == object and not any(isinstance(n, float) for n in (*x.flat, *y.flat)):
        assert all(_is_zero(a - b) for a, b in zip(x.flat, y.flat, strict=True)), f"{x} ≠ {y}"
        return
    x, y = (a if a.dtype.kind in "fcb" else a.astype(float) for a in (x, y))
    finite = np.abs(np.concatenate([x[np.isfinite(x)].ravel(), y[np.isfinite(y)].ravel(), [1e-300]])).max()
    np.testing.assert_allclose(x, y, rtol=rtol, atol=rtol * finite)


def _is_zero(x) -> bool:
    if hasattr(x, "free_symbols"):
        from sympy import cancel, expand

        return expand(x) == 0 or cancel(x) == 0
    return x == 0


def assert_same_poses(x: DualQuaternion, y: DualQuaternion, *, length: float = 1.0, rtol: float = 1e-9) -> None:
    """Equal up to factors, which may differ from row to row."""
    assert np.all(same_point(x, y, rtol=rtol, length=length)), f"{x} and {y} are different points"


def assert_same_linkages(first, second, *, length: float = 1.0, rtol: float = 1e-7) -> None:
    """The same factors about the same oriented axes, home poses up to factors, in the same order."""
    assert len(first) == len(second)
    for a, b in zip(first, second, strict=True):
        pairs = [(a.h1, b.h1), (a.h2, b.h2)] if isinstance(a, Dyad) else list(zip(a.factors, b.factors, strict=True))
        for f, g in pairs:
            scale = np.array([1.0] * 4 + [length] * 4)
            assert_same_numbers(*(q.coeffs.astype(float) / scale for q in (f, g)), rtol=rtol)
        assert_same_poses(a.home.astype(float), b.home.astype(float), length=length, rtol=rtol)
        if isinstance(a, Linkage):
            assert a.joints == b.joints
            assert_same_numbers(*(np.array(np.broadcast_arrays(*x.parameters), dtype=float) for x in (a, b)), rtol=rtol)


# --- functions that work row by row -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Rowwise:
    """A public function, or a method, that takes batches.

    Attributes
    ----------
    names : tuple of str
        The public names that it covers.
    function : callable
    takes : tuple of str
        What each argument is: a method of :class:`Draw`.
    exact : bool
        Whether exact arguments give exact answers, equal to those for floats.
    """

    names: tuple[str, ...]
    function: Callable
    takes: tuple[str, ...]
    exact: bool = True

    def draw(self, kind: str = "float", shape=(), seed: int = 0) -> list:
        draw = Draw(kind, shape, seed=zlib.crc32("".join(self.names).encode()) + seed)
        return [getattr(draw, what)() for what in self.takes]


def in_floats(thing):
    """The same argument in floats."""
    if isinstance(thing, DualQuaternion):
        return thing.astype(float)
    if isinstance(thing, Line):
        return Line(thing.direction.astype(float), thing.moment.astype(float))
    if isinstance(thing, MotionPolynomial):
        return MotionPolynomial(thing.coeffs.astype(float))
    if isinstance(thing, Dyad):
        return Dyad(in_floats(thing.h1), in_floats(thing.h2), in_floats(thing.home))
    return np.asarray(thing).astype(float)[()]


def row(thing, index):
    """One row of an argument."""
    if isinstance(thing, Line):
        return Line(thing.direction[index], thing.moment[index])
    if isinstance(thing, Dyad):
        return Dyad(thing.h1[index], thing.h2[index], thing.home[index])
    return thing[index]


def with_nan(thing, index):
    """An argument with one row made NaN, as kinlib itself marks rows that it cannot answer."""
    if isinstance(thing, DualQuaternion):
        return DualQuaternion(_spoiled(thing.coeffs, index))
    if isinstance(thing, MotionPolynomial):
        return MotionPolynomial(_spoiled(thing.coeffs, index))
    if isinstance(thing, Line):
        coordinates = _spoiled(np.concatenate([thing.direction, thing.moment], axis=-1), index)
        return Line.from_components(np.moveaxis(coordinates, -1, 0).copy())
    if isinstance(thing, Dyad):
        return Dyad(with_nan(thing.h1, index), thing.h2, thing.home)
    return _spoiled(np.asarray(thing), index)


def _spoiled(array: np.ndarray, index) -> np.ndarray:
    array = np.array(array, dtype=float if array.dtype.kind != "c" else complex)
    array[index] = math.nan
    return array
