"""The cubic motions through four poses: two families with one parameter each, where they are real.

A cubic with p0 at t = ∞, p1 at 0, p2 at 1 and p3 at t3 is C = p0 Π(t − t_j) + Σ λ_j p_j Π_{m≠j}(t − t_m).  It lies on
the Study quadric if the skew matrix of the b_mn / (t_m − t_n) sends (1, λ) to zero.  That decides t3, up to a
quadratic equation, and leaves λ a line.  What may be wrong with one of the two families need not concern the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, eps_times, null_form, one, study_form
from kinlib.errors import DegenerateError, Fault, check_degenerate, first_fault, named_rows
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.number_field import square_root
from kinlib.poses import PoseProblem, as_poses, gap, seen_together
from kinlib.projective import null_space
from kinlib.rows import broadcast
from kinlib.scalar import ROUNDING, as_float, as_scalars, divide, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, Degenerate, PoseLike, Scalars

__all__: list[str] = []

MET = 2e-10
"""How near the poses must be passed, in half-angles and in the unit of length of the problem."""

SAME_FAMILY = 1e-14
"""Where the discriminant counts as zero, relative to the squares that it is made of."""

SAME_SIZE = 1e-9
"""Two values of t3 of opposite sign whose sizes differ by less count as equally large; the positive comes first."""

NEARLY_DEPENDENT = 1e-11
"""Where four poses count as dependent: the least singular value of their directions from the first."""

MODERATE = 1e3
"""How much larger or smaller than the cubic a step of the free parameter may be."""

NEARLY_MISSED = 1e-5
"""The share of a cubic below which a pose counts as nearly missed, when the base of the free parameter is chosen."""

NEAR = 1e-5
"""From how near a degeneracy on it is blamed for what is wrong with a cubic in floats."""

MISSED = 1e-12
"""The share of the largest pose below which a pose counts as missed."""

PAIRS = tuple(combinations(range(4), 2))
FAMILIES = ("first", "second")

Forms: TypeAlias = Mapping[tuple[int, int], Array]
"""The Study form b_mn of every pair of poses."""

Parameters: TypeAlias = tuple[float, int, int, Scalars]
"""The parameters ∞, 0, 1, t3 of the four poses."""


class CubicFault(Fault):
    """Why a family of cubics, or all of it, is missing."""

    EQUAL = 1, "two of the four poses are equal: four different poses are needed"
    SPAN = 2, "each two of the four poses differ by a rotation or a translation: their span lies in the Study quadric"
    STAR = (
        3,
        "one pose differs from all others by rotations or translations: the cubics through the poses are a family with "
        "two parameters, which is not built",
    )
    TRIANGLE = (
        4,
        "each two of three of the poses differ by a rotation or a translation: the cubics that pass through these miss "
        "the fourth pose",
    )
    DEPENDENT = (
        5,
        "the four poses are dependent (as points of P⁷ they lie in a plane, the fourth on the conic of the others): "
        "the only cubic through them is a conic with a real factor",
    )
    UNREAL = 6, "neither family is real: the Gram determinant of the four poses is negative"
    SAME = 7, "the two families are one: the Gram determinant of the four poses vanishes"
    FALLS_ON_0 = 8, "the fourth pose falls on pose 0 (t3 = ∞)"
    FALLS_ON_1 = 9, "the fourth pose falls on pose 1 (t3 = 0)"
    FALLS_ON_2 = 10, "the fourth pose falls on pose 2 (t3 = 1)"
    MISSES_0 = 11, "for this value of the free parameter the cubic misses pose 0"
    MISSES_1 = 12, "for this value of the free parameter the cubic misses pose 1"
    MISSES_2 = 13, "for this value of the free parameter the cubic misses pose 2"
    MISSES_3 = 14, "for this value of the free parameter the cubic misses pose 3"
    UNDEFINED = 15, "a pose is not defined (NaN)"
    LOST = 16, "in floats the poses are not met to 1e-9"
    POWERS = (
        19,
        "powers of t lose a pose in floats; six_r_linkages keeps it in linear factors, if it can be kept",
    )
    REAL_ROOT = 17, "the norm polynomial has a real root: the motion passes through the exceptional space"
    UNSPLIT = 18, "the cubic has no six factorizations into turns"


NUMERICAL = (CubicFault.LOST, CubicFault.POWERS, CubicFault.REAL_ROOT, CubicFault.UNSPLIT)
MISSES = (CubicFault.MISSES_0, CubicFault.MISSES_1, CubicFault.MISSES_2, CubicFault.MISSES_3)


@dataclass(frozen=True)
class CubicRows:
    """Single cubics C = Π(t − t_j) + Σ λ_j q_j Π_{m≠j}(t − t_m) that exist, in rows, as seen in their problem.

    Parameters
    ----------
    others : tuple of DualQuaternion, shape (rows,)
        The displacements q_1, q_2, q_3.
    t3, beyond : arrays, shape (rows,)
        The parameter of the fourth pose, and t3 − 1 with all its digits.
    weights : tuple of arrays, shape (rows,)
        λ_1, λ_2, λ_3.
    """

    others: tuple[DualQuaternion, ...]
    t3: Array
    beyond: Array
    weights: tuple[Array, ...]

    @property
    def is_exact(self) -> bool:
        """Whether nothing is rounded."""
        return all(is_exact(x) for x in (self.t3, *self.weights)) and is_exact(self.others[0].components)

    def cubics(self, at: Array | int = 0, unit: Array | int = 1) -> MotionPolynomial:
        """The cubics in the parameter (t − at) / unit, where at is 0 or 1."""
        first = 0 * self.t3 - at
        nodes = [divide(t, unit) for t in (first, first + 1, np.where(at == 1, self.beyond, self.t3))]
        scaled = [q * divide(w, unit) for q, w in zip(self.others, self.weights, strict=True)]
        return _lagrange(scaled, nodes)

    def centre_and_unit(self) -> tuple[Array, Array]:
        """In floats: 1 where t3 is nearest to it, else 0; and the mean of the smallest and largest distance."""
        near_one = np.abs(self.beyond) < np.minimum(np.abs(self.t3), 1)
        distances = np.abs([np.ones_like(self.t3), self.t3, self.beyond])
        unit = np.sqrt(distances.min(axis=0) * distances.max(axis=0))
        return np.where(near_one, 1.0, 0.0), np.exp2(np.round(np.log2(unit)))

    def some(self, rows: Array | slice) -> CubicRows:
        """Some of the rows."""
        return CubicRows(
            tuple(q[rows] for q in self.others),
            self.t3[rows],
            self.beyond[rows],
            tuple(w[rows] for w in self.weights),
        )

    @property
    def parameters(self) -> Array:
        """The parameters of p1, p2, p3, shape (rows, 3)."""
        return np.stack([0 * self.t3, 0 * self.t3 + 1, self.t3], axis=-1)

    def values_at_poses(self) -> list[DualQuaternion]:
        """The values of the cubics at the parameters of p1, p2, p3, each with all its digits."""
        spans = (self.t3, -self.beyond, self.t3 * self.beyond)
        return [q * (w * s) for q, w, s in zip(self.others, self.weights, spans, strict=True)]

    def missed(self, reached: DualQuaternion) -> np.ndarray:
        """How far motions are from p1, p2, p3, given where they are there, shape (rows, ..., 3); p0 is met anyway."""
        wanted = DualQuaternion.stack(self.others, axis=-1).coeffs
        wanted = wanted.reshape(len(wanted), *(1,) * (len(reached.shape) - 2), 3, 8)
        return gap(reached, DualQuaternion(wanted)).max(axis=tuple(range(1, len(reached.shape))))


def _lagrange(scaled: Sequence[DualQuaternion], t: Sequence[Array]) -> MotionPolynomial:
    """Π(t − t_j) + Σ q_j Π_{m≠j}(t − t_m) for three nodes."""
    a, b, c = t
    zero = 0 * scaled[0]
    coefficients = [zero + n for n in (1, -(a + b + c), a * b + b * c + c * a, -a * b * c)]
    for q, (a, b) in zip(scaled, ((t[1], t[2]), (t[0], t[2]), (t[0], t[1])), strict=True):
        factors: Sequence[int | Array] = 1, -(a + b), a * b
        for n, factor in enumerate(factors, start=1):
            coefficients[n] = coefficients[n] + q * factor
    return MotionPolynomial.from_coefficients(coefficients)


@dataclass(frozen=True)
class CubicFamilies:
    """Both families of cubics through four poses; the family is on the last axis.

    Parameters
    ----------
    problem : PoseProblem
        The poses, of shape (...).
    forms : dict of arrays, shape (...)
        The b_mn.
    t3, beyond : arrays, shape (..., 2)
        The parameter of the fourth pose, and t3 − 1.
    weights : tuple of arrays, shape (..., 2)
        λ_1, λ_2, λ_3.
    shares : list of arrays, shape (..., 2)
        The squares of the four poses in the cubic, weighed on the projective line of t.
    faults : array of int, shape (..., 2)
        What is wrong, a ``CubicFault``; 0 if nothing.
    off : array of float, shape (..., 2)
        How far the poses are missed in floats, where they are.
    chosen : tuple of arrays of int
        Which entries of (..., 2) are solved further, each a row.
    """

    problem: PoseProblem
    forms: Forms
    t3: Array
    beyond: Array
    weights: tuple[Array, ...]
    shares: list[Array]
    faults: Array
    off: Array
    chosen: tuple[Array, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return self.faults.shape[:-1]

    @cached_property
    def rows(self) -> CubicRows:
        """The cubics that exist, one after the other."""
        others = tuple(q[self.chosen[:-1]] if self.shape else _repeated(q, len(self.chosen[-1])) for q in self.others)
        pick = [np.asarray(x)[self.chosen] for x in (self.t3, self.beyond, *self.weights)]
        return CubicRows(others, pick[0], pick[1], tuple(pick[2:]))

    @property
    def others(self) -> DualQuaternion:
        """The displacements q_1, q_2, q_3."""
        return self.problem.others

    def outward(self, q: DualQuaternion) -> DualQuaternion:
        """What was found for the rows, shape (rows, ...), in the frame and unit of the poses."""
        if self.problem.is_exact:
            return q
        inner = (1,) * (len(q.shape) - 1)
        middle, length = (
            np.broadcast_to(x, (*self.shape, *x.shape[x.ndim - tail :]))[self.chosen[:-1]]
            for x, tail in ((self.problem.middle, 1), (self.problem.length, 0))
        )
        if not self.shape:
            return self.problem.outward(q)
        middle, length = middle.reshape(-1, *inner, 3), length.reshape(-1, *inner)
        return replace(self.problem, middle=middle, length=length).outward(q)

    def less(self, faults: Array | int, off: Array | float) -> CubicFamilies:
        """The same families with faults of the rows."""
        all_faults, all_off = self.faults.copy(), self.off.copy()
        all_faults[self.chosen], all_off[self.chosen] = faults, off
        return replace(self, faults=all_faults, off=all_off)

    def spread(self, q: DualQuaternion, family: int) -> DualQuaternion:
        """What was found for the rows, shape (rows, ...), as a batch of one family; NaN where there is none."""
        mine = (self.chosen[-1] == family) & (self.faults[self.chosen] == 0)
        if not self.shape:
            return q[int(np.flatnonzero(mine)[0])] if mine.any() else one * np.nan
        components = np.full((8, *self.shape, *q.shape[1:]), None if self.problem.is_exact else np.nan)
        components[(slice(None), *(axis[mine] for axis in self.chosen[:-1]))] = q.components[:, mine]
        return DualQuaternion.from_components(components)

    def spread_all(self, factors: Sequence[DualQuaternion], family: int) -> list[tuple[DualQuaternion, ...]]:
        """The chains of factors of one family, from factors of shape (rows, chains)."""
        spread = [self.spread(h, family) for h in factors]
        return [tuple(h[..., n] for h in spread) for n in range(factors[0].shape[-1])]

    def parameters(self, family: int) -> Parameters:
        """The parameters of the poses in one family, (∞, 0, 1, t3); NaN for t3 where the family is missing."""
        t3 = self.t3[..., family]
        if not self.shape:
            return math.inf, 0, 1, t3[()] if self.problem.is_exact else float(t3)
        return math.inf, 0, 1, t3 if self.problem.is_exact else np.where(self.faults[..., family] > 0, np.nan, t3)

    def judged(self, degenerate: Degenerate) -> tuple[list[int], tuple[str, ...]]:
        """The numbers of the families to be returned, and what is missing; or an error."""
        flat = self.faults.reshape(-1, 2)
        missing = tuple(text for family in (0, 1) for text in self._missing(flat[:, family], family))
        if degenerate == "nan":
            return [0, 1], missing
        whole = [n for n in (0, 1) if (flat[:, n] > 0).all() and len(flat)]
        left = [n for n in (0, 1) if n not in whole]
        if left and not (flat[:, left] > 0).any():
            return left, missing
        raise DegenerateError(self._summary(flat, missing), rows=self._faulty_rows(flat))

    def _faulty_rows(self, flat: Array) -> tuple[int, ...]:
        return tuple(map(int, np.flatnonzero((flat > 0).any(axis=-1)))) if self.shape else ()

    def _missing(self, faults: Array, family: int) -> list[str]:
        texts = []
        for fault in np.unique(faults[faults > 0]):
            rows = np.flatnonzero(faults == fault)
            where = named_rows(rows) if self.shape else ""
            texts.append(
                f"{where}{FAMILIES[family]} family: {self._explained(CubicFault(fault), int(rows[0]), family)}"
            )
        return texts

    def _summary(self, flat: Array, missing: tuple[str, ...]) -> str:
        """What an error says: once, if it concerns both families alike."""
        if len(flat) and (flat[:, 0] == flat[:, 1]).all() and len(np.unique(flat[flat > 0])) == 1:
            rows = self._faulty_rows(flat)
            return named_rows(rows) + self._explained(CubicFault(flat.max()), rows[0] if rows else 0, 0)
        return "; ".join(missing)

    def _explained(self, fault: CubicFault, row: int, family: int) -> str:
        """The message of a fault with the geometry of one row."""
        if fault in POSITION:
            return f"{fault.message}: {self._relations(row)}"
        if fault == CubicFault.UNREAL:
            return f"{fault.message}, {self._gram(row):.3g}"
        if fault in NUMERICAL and not self.problem.is_exact:
            size, text = self._nearest(row, family)
            off = self.off.reshape(-1, 2)[row, family]
            what = (CubicFault.LOST if size < NEAR and fault != CubicFault.POWERS else fault).message
            by = f" (off by {off:.1e})" if MET < off < 1e-2 else ""
            return f"{what}{by}: {text} ({size:.1e})" if size < 0.05 else f"{what}{by}"
        return fault.message

    def _step(self, pair: tuple[int, int], row: int) -> DualQuaternion:
        """The displacement between two poses of one row."""
        return DualQuaternion(self.problem.steps[PAIRS.index(pair)].coeffs.reshape(-1, 8)[row])

    def _form(self, pair: tuple[int, int], row: int) -> Any:
        return np.ravel(self.forms[pair])[row]

    def _gram(self, row: int) -> float:
        x, y, z = products({pair: self._form(pair, row) for pair in PAIRS})
        return float((x - y - z) ** 2 - 4 * y * z)

    def _relations(self, row: int) -> str:
        """Which poses of a row differ by what, if not by a screw."""
        tolerance = np.ravel(np.broadcast_to(rounding(self.problem), self.shape))[row]
        pairs = [pair for pair in PAIRS if self._form(pair, row) == 0]
        return ", ".join(f"poses {m} and {n} {relation(self._step((m, n), row), tolerance)}" for m, n in pairs)

    def _nearest(self, row: int, family: int) -> tuple[float, str]:
        """How near a row is to which degeneracy."""
        near = [
            (abs(float(self._form((m, n), row))), f"poses {m} and {n} {relation(self._step((m, n), row), 1e-3, True)}")
            for m, n in PAIRS
        ]
        x, y, z = (float(v) for v in products({pair: self._form(pair, row) for pair in PAIRS}))
        square = max(x * x, y * y, z * z)
        gram = abs(self._gram(row)) / square if square else 1.0
        near.append((gram, "the Gram determinant of the poses nearly vanishes"))
        shares = [float(s.reshape(-1, 2)[row, family]) for s in self.shares]
        text = "for this value of the free parameter the cubic all but misses pose {}"
        near += [((share / max(shares)) ** 0.5, text.format(n)) for n, share in enumerate(shares)]
        return min(near)


POSITION = (
    CubicFault.EQUAL,
    CubicFault.SPAN,
    CubicFault.STAR,
    CubicFault.TRIANGLE,
    CubicFault.FALLS_ON_0,
    CubicFault.FALLS_ON_1,
    CubicFault.FALLS_ON_2,
)


def relation(step: DualQuaternion, tolerance: Any, nearly: bool = False) -> str:
    """How two poses differ whose form vanishes, given the displacement from one to the other."""
    word = "nearly " if nearly else ""
    if not np.all(is_zero(step.components[1:4], tolerance, 1.0)):
        return f"{word}differ by a rotation"
    return f"are {word}equal" if no_displacement(step, tolerance) else f"{word}differ by a translation"


def no_displacement(step: DualQuaternion, tolerance: Any) -> Array:
    """Whether a displacement from one pose to another is none."""
    return np.all(is_zero(step.components[[1, 2, 3, 5, 6, 7]], tolerance, 1.0), axis=0)


def rounding(problem: PoseProblem) -> Any:
    """What counts as zero among the numbers of a problem; exact numbers are compared exactly."""
    return 0 if problem.is_exact else ROUNDING + 64 * problem.noise


def products(b: Forms) -> tuple[Array, Array, Array]:
    """x = b_01 b_23, y = b_02 b_13, z = b_03 b_12."""
    return b[0, 1] * b[2, 3], b[0, 2] * b[1, 3], b[0, 3] * b[1, 2]


def _repeated(q: DualQuaternion, count: int) -> DualQuaternion:
    return DualQuaternion(np.broadcast_to(q.coeffs, (count, 8)))


def families_of(
    p0: PoseLike, p1: PoseLike, p2: PoseLike, p3: PoseLike, free: ArrayLike, degenerate: Degenerate = "raise"
) -> CubicFamilies:
    """Both families of cubics through four poses, for one value of the free parameter."""
    check_degenerate(degenerate)
    problem, free = _problem((p0, p1, p2, p3), _checked_free(free), degenerate)
    if problem.is_exact and degenerate == "nan":
        raise ValueError("degenerate='nan' needs floats, since NaN is one: convert the poses, or use 'raise'")
    with np.errstate(all="ignore"):
        b = _forms(problem)
        t3, beyond, discriminant, family_faults = _fourth_parameters(b)
        faults = np.where(
            (row_faults := _row_faults(problem, b, discriminant))[..., None] > 0,
            row_faults[..., None],
            family_faults,
        )
        t3, beyond = np.where(faults > 0, 2, t3), np.where(faults > 0, 1, beyond)
        weights = _weights(problem, b, t3, beyond, free)
        shares = _shares(problem, t3, beyond, weights)
        faults = np.where(faults > 0, faults, _misses(shares))
    off = np.full(faults.shape, np.nan)
    return CubicFamilies(problem, b, t3, beyond, weights, shares, faults, off, np.nonzero(faults == 0))


def _checked_free(free: ArrayLike) -> Array:
    if isinstance(free, DualQuaternion):
        raise TypeError(f"expected a number for the free parameter, got {free!r}")
    free = as_scalars(free)
    if free.dtype.kind == "c" or (free.dtype.kind == "f" and not np.all(np.isfinite(free))):
        raise ValueError(f"expected real and finite values of the free parameter, got {free}")
    return free


def _problem(given: Sequence[PoseLike], free: Array, degenerate: Degenerate) -> tuple[PoseProblem, Array]:
    """The poses as one problem of the shape of poses and free parameter; in floats if one of them is."""
    problem = seen_together(*given, degenerate=degenerate)
    if problem.is_exact and not is_exact(free):
        problem = seen_together(*(p.astype(float) for p in as_poses(*given)))
    if not problem.is_exact:
        problem = replace(problem, others=_projected(problem.others))
        free = as_float(free) if is_exact(free) else free
    shape = np.broadcast_shapes(problem.home.shape, free.shape)
    if shape != problem.home.shape:
        home, *others = (broadcast(q, shape) for q in (problem.home, *problem.others))
        problem = replace(problem, home=home, others=DualQuaternion.stack(others))
    return problem, free[..., None] if free.ndim else free[()]


def _projected(q: DualQuaternion) -> DualQuaternion:
    """The nearest point of the Study quadric: poses given far from the origin are off it, in the unit of length."""
    return q - eps_times(q) * (study_form(q, q) / 2)


def _forms(problem: PoseProblem) -> Forms:
    """The b_mn; what may be rounding of the given numbers is zero."""
    forms = dict(zip(PAIRS, map(np.asarray, problem.forms), strict=True))
    if problem.is_exact:
        return forms
    limits = map(rounding_of_form, problem.steps, [problem.noise] * 6)
    return {pair: np.where(np.abs(b) <= limit, 0, b) for (pair, b), limit in zip(forms.items(), limits, strict=True)}


def rounding_of_form(step: DualQuaternion, noise: Array) -> Array:
    """What rounding makes of b(x, y), which is the product of the vector parts of the step, up to a factor."""
    r = np.abs(step.components)
    primal, dual = r[1:4].max(axis=0), r[5:].max(axis=0)
    return ROUNDING / 4 * (primal + dual) + 16 * noise * primal


_exact_sign = np.frompyfunc(lambda x: 1 if x > 0 else -1 if x < 0 else 0, 1, 1)
_exact_root = np.frompyfunc(lambda x: square_root(x) if x > 0 else 0, 1, 1)


def _sign(values: Array) -> Array:
    values = np.asarray(values)
    return np.sign(values) if values.dtype.kind == "f" else np.asarray(_exact_sign(values))


def _root(square: Array) -> Array:
    square = np.asarray(square)
    return np.sqrt(np.maximum(square, 0)) if square.dtype.kind == "f" else np.asarray(_exact_root(square))


def _fourth_parameters(b: Forms) -> tuple[Array, Array, Array, Array]:
    """t3 and t3 − 1 of both families, shape (..., 2), the discriminant and the faults of each family.

    t3 solves z t² + (x − y − z) t + y = 0, and e = t3 − 1 solves z e² + (x − y + z) e + x = 0, with one discriminant.
    """
    x, y, z = (np.asarray(value) for value in products(b))
    linear, shifted = x - y - z, x - y + z
    discriminant = np.asarray(linear * linear - 4 * y * z)
    largest = x * x + y * y + z * z
    small = is_zero(discriminant, SAME_FAMILY, largest)
    discriminant = np.where(small, 0, discriminant)
    root = _root(discriminant)
    first = np.where(is_zero(linear, SAME_SIZE, np.sqrt(as_float(largest))), _sign(z), -_sign(linear))
    first = np.where(first == 0, 1, np.nan_to_num(as_float(first))).astype(int)
    signs = np.stack([first, -first], axis=-1)
    x, y, z, linear, shifted, root = (np.asarray(v)[..., None] for v in (x, y, z, linear, shifted, root))
    t3, far = _solution(z, linear, y, root * signs)
    beyond, farther = _solution(z, shifted, x, root * signs)
    second = np.array([False, True])
    faults = first_fault(
        (np.asarray(is_zero(root, rtol=0)) & second, CubicFault.SAME),
        (far | farther | ~_finite(t3) | ~_finite(beyond), CubicFault.FALLS_ON_0),
        (is_zero(t3, rtol=0), CubicFault.FALLS_ON_1),
        (is_zero(beyond, rtol=0), CubicFault.FALLS_ON_2),
    )
    return t3, beyond, discriminant, faults


def _solution(a: Array, linear: Array, c: Array, root: Array) -> tuple[Array, Array]:
    """The root (−linear + root) / 2a of at² + linear t + c without cancellation, and where it is infinite."""
    straight = as_float(_sign(root) * _sign(linear)) <= 0
    numerator = np.where(straight, root - linear, 2 * c)
    denominator = np.where(straight, 2 * a, -(linear + root))
    infinite = np.asarray(is_zero(denominator, rtol=0))
    return np.asarray(divide(numerator, np.where(infinite, 1, denominator))), infinite


def _finite(values: Array) -> Array:
    return np.isfinite(values) if values.dtype.kind == "f" else np.ones(values.shape, dtype=bool)


def _row_faults(problem: PoseProblem, b: Forms, discriminant: Array) -> Array:
    """What is wrong with both families."""
    zero = {pair: np.asarray(is_zero(value, rtol=0)) for pair, value in b.items()}
    nothing = (zero[0, 1] | zero[2, 3]) & (zero[0, 2] | zero[1, 3]) & (zero[0, 3] | zero[1, 2])
    triangles = [np.all([zero[pair] for pair in PAIRS if n not in pair], axis=0) for n in range(4)]
    tolerance, equal = rounding(problem), np.zeros(nothing.shape, dtype=bool)
    for pair, step in zip(PAIRS, problem.steps, strict=True):
        if zero[pair].any():
            equal = equal | (zero[pair] & no_displacement(step, tolerance))
    undefined = np.zeros(nothing.shape, dtype=bool) if problem.is_exact else np.isnan(discriminant)
    return first_fault(
        (undefined, CubicFault.UNDEFINED),
        (equal, CubicFault.EQUAL),
        (np.all(list(zero.values()), axis=0), CubicFault.SPAN),
        (nothing & np.any(triangles, axis=0), CubicFault.TRIANGLE),
        (nothing, CubicFault.STAR),
        (_dependent(problem, b, discriminant), CubicFault.DEPENDENT),
        (as_float(_sign(discriminant)) < 0, CubicFault.UNREAL),
    )


def _dependent(problem: PoseProblem, b: Forms, discriminant: Array) -> Array:
    """Where the four displacements are dependent; then their Gram determinant vanishes, up to rounding."""
    dependent = np.zeros(discriminant.shape, dtype=bool)
    candidates = is_zero(discriminant, 1e-9, sum(v * v for v in products(b)))
    if not np.any(candidates):
        return dependent
    rows = np.stack([q.coeffs[np.nonzero(candidates)] if q.shape else q.coeffs[None] for q in problem.others], axis=-2)
    if problem.is_exact:
        dependent[candidates] = [len(null_space(np.array(matrix)[:, 1:].T)) > 0 for matrix in rows]
        return dependent
    rows = rows[..., 1:] / np.linalg.norm(rows[..., 1:], axis=-1, keepdims=True)
    dependent[candidates] = np.linalg.svd(np.nan_to_num(rows), compute_uv=False)[:, -1] <= NEARLY_DEPENDENT
    return dependent


def _weights(problem: PoseProblem, b: Forms, t3: Array, beyond: Array, free: Any) -> tuple[Array, ...]:
    """λ = μ + (base + free) r κ, see ``cubics_through``."""
    b01, b02, b03, b12, b13, b23 = (np.asarray(b[pair])[..., None] for pair in PAIRS)
    kernel = [-divide(b23, beyond), divide(b13, t3), -b12]
    squares = [np.asarray(null_form(q, q))[..., None] for q in problem.others]
    weighted = [w * k for w, k in zip(squares, kernel, strict=True)]
    total = np.asarray(sum(k * w for k, w in zip(kernel, weighted, strict=True)))
    total = np.where(is_zero(total, rtol=0), 1, total)
    special = [divide(v, total) for v in _cross((b01, b02, b03), weighted)]
    balance = [divide(w, d) for w, d in zip(squares, _squared_distances(t3, beyond), strict=True)]
    whole = 1 + sum(w * v * v for w, v in zip(balance, special, strict=True))
    step = np.asarray(sum(w * k * k for w, k in zip(balance, kernel, strict=True)))
    unit = _unit_of_freedom((b01, b02, b03, b12, b13, b23), whole, np.where(is_zero(step, rtol=0), 1, step))
    steps = [unit * k for k in kernel]
    base = _base(special, steps, balance)
    return tuple(np.asarray(v + (base + free) * s) for v, s in zip(special, steps, strict=True))


def _squared_distances(t3: Array, beyond: Array) -> list[Array]:
    """σ² + (t_j − c)² for the parameters 0, 1, t3, which lie about c, in the scale σ.

    With these the weights of a cubic are compared as they are on the projective line of t, where two parameters that
    nearly agree are as far from ∞ as the others are near it.
    """
    sizes = [np.ones_like(t3), t3 * _sign(t3), beyond * _sign(beyond)]
    least = np.where(sizes[1] < sizes[0], sizes[1], sizes[0])
    near_one = sizes[2] < least
    least = np.where(near_one, sizes[2], least)
    most = np.where(sizes[1] > sizes[2], sizes[1], sizes[2])
    scale = least * np.where(most > 1, most, 1)
    return [scale + d * d for d in (np.where(near_one, 1, 0), np.where(near_one, 0, 1), np.where(near_one, beyond, t3))]


def _cross(a: Sequence[Array], b: Sequence[Array]) -> list[Array]:
    return [a[(n + 1) % 3] * b[(n + 2) % 3] - a[(n + 2) % 3] * b[(n + 1) % 3] for n in range(3)]


def _unit_of_freedom(b: Sequence[Array], whole: Array, total: Array) -> Array:
    """The r of ``cubics_through``: with it λ does not depend on frames, unit of length and factors of the poses."""
    b01, b02, b03, b12, b13, b23 = b
    unit, found = np.ones_like(total), np.zeros(total.shape, dtype=bool)
    for top, x, y in ((b01, b12, b13), (b02, b12, b23), (b03, b13, b23)):
        below = x * y
        none = is_zero(below, rtol=0) | is_zero(top, rtol=0)
        r = divide(top, np.where(none, 1, below))
        share = np.sqrt(as_float(divide(r * r * total, whole)))
        suits = ~none & ~found & (share >= 1 / MODERATE) & (share <= MODERATE)
        unit, found = np.where(suits, r, unit), found | suits
    if found.all():
        return unit
    x, y, z = np.broadcast_arrays(b01 * b23, b02 * b13, b03 * b12, total)[:3]
    largest = np.maximum(np.maximum(*(as_float(v * v) for v in (x, y))), as_float(z * z))
    leading = np.select(
        [as_float(v * v) >= largest / 4 for v in (x, y)], [as_float(_sign(v)) for v in (x, y)], as_float(_sign(z))
    )
    lengths = _root(np.where(found, 1, divide(whole, total)))
    return np.where(found, unit, lengths * leading.astype(int if lengths.dtype == object else float))


def _base(special: Sequence[Array], steps: Sequence[Array], balance: Sequence[Array]) -> Array:
    """The first of 0, 1, −1, 2, −2 at which no pose is nearly missed, or the best of them."""
    numbers = (0, 1, -1, 2, -2)
    shares = []
    for number in numbers:
        parts = [as_float(w) * as_float(v + number * s) ** 2 for w, v, s in zip(balance, special, steps, strict=True)]
        shares.append(reduce(np.minimum, [1, *parts]) / (1 + sum(parts)))
    return np.array(numbers)[np.argmax(np.minimum(np.nan_to_num(shares), NEARLY_MISSED**2), axis=0)]


def _shares(problem: PoseProblem, t3: Array, beyond: Array, weights: Sequence[Array]) -> list[Array]:
    """λ_j² p_j p̄_j, weighed on the projective line of t; factors of the poses do not matter to it."""
    balance = zip(weights, problem.others, _squared_distances(t3, beyond), strict=True)
    shares = [divide(w * w * np.asarray(null_form(q, q))[..., None], d) for w, q, d in balance]
    return [1 + 0 * shares[0], *map(np.asarray, shares)]


def _misses(shares: Sequence[Array]) -> Array:
    """Which pose a cubic misses: the share of the pose against the largest of them."""
    largest = reduce(np.maximum, [_floats(s) for s in shares])
    return first_fault(*((is_zero(s, MISSED**2, largest), fault) for s, fault in zip(shares, MISSES, strict=True)))


def _floats(values: Array) -> Array:
    """Floats, where there are no symbols."""
    try:
        return as_float(values)
    except TypeError:
        return np.ones(values.shape)
