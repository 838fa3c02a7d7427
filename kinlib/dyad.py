"""2R dyads, their spaces and null quadrilaterals; Theorem 1 as a procedure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from kinlib.displacement import unit
from kinlib.dual_quaternion import DualQuaternion, dual_size, null_form, one, pieces_in_latex, primal_size, study_form
from kinlib.errors import DegenerateError, check_degenerate, named_rows, rows_where
from kinlib.line import Line
from kinlib.number_field import square_root
from kinlib.poses import as_pose, gap, middle_of, moved_origin, stretched
from kinlib.projective import Subspace, coordinates_of, join, null_space
from kinlib.quadric import Quadric, binary_roots
from kinlib.scalar import ROUNDING, RTOL, as_float, divide, imaginary_unit, is_exact, is_infinite, is_zero, size
from kinlib.shown import html_table, in_words
from kinlib.study import NULL_CONE, STUDY_QUADRIC
from kinlib.typing import Array, ArrayLike, Degenerate, DualQuaternionLike, PoseLike, Scalars

__all__ = ["Dyad", "NullQuadrilateral", "TwoRSpace", "primal_coordinates", "recognise"]


class NullQuadrilateral(NamedTuple):
    """The vertices of a null quadrilateral in their order; u1, u2 and v1, v2 are conjugate complex.

    With m = √−1 − h1 and n = √−1 − h2 they are m n̂, m n, m̂ n, m̂ n̂, where a hat conjugates √−1.
    """

    u1: DualQuaternion
    v1: DualQuaternion
    u2: DualQuaternion
    v2: DualQuaternion

    def _repr_latex_(self) -> str | None:
        """The four vertices of a single one, below each other."""
        if any(vertex.shape for vertex in self):
            return None
        rows = [rf"{name[0]}_{name[1]} &= {' '.join(pieces_in_latex(getattr(self, name)))}" for name in self._fields]
        return rf"$\begin{{aligned}}{(chr(92) * 2).join(rows)}\end{{aligned}}$"


@dataclass(frozen=True, eq=False)
class Dyad:
    """An open 2R chain: rotate about the axis of h2, then about that of h1.

    Parameters
    ----------
    h1, h2 : DualQuaternion, shape (...)
        Half-turns l + εm about the axis at the base and the moving axis.  Floats have |l| = 1; exact
        half-turns may be longer, since the root that would shorten them may leave the number field.
    home : DualQuaternion
        The pose of the end link at t1 = t2 = ∞.

    Raises
    ------
    ValueError
        If h1 or h2 is no half-turn about a line.
    DegenerateError
        If the two axes agree.

    Examples
    --------
    >>> dyad = Dyad(i, j - eps * i)
    >>> dyad(0, 0) == i * (j - eps * i)
    True
    """

    h1: DualQuaternion
    h2: DualQuaternion
    home: DualQuaternion = field(default_factory=lambda: one)

    def __post_init__(self) -> None:
        for name, h in (("h1", self.h1), ("h2", self.h2)):
            if not isinstance(h, DualQuaternion):
                raise TypeError(f"expected {name} as a DualQuaternion, the half-turn about an axis, got {h!r}")
            if np.any(~_is_half_turn(h)):
                raise ValueError(f"{name} is no half-turn l + εm about a line: l ≠ 0 and l · m = 0 are needed")
        if np.any(_commute(self.h1, self.h2)):
            raise DegenerateError("h1 and h2 commute, so their axes agree: a 2R dyad needs two different axes")
        object.__setattr__(self, "home", _pose_or_nan(self.home))

    def __call__(self, t1: ArrayLike, t2: ArrayLike) -> DualQuaternion:
        """The pose R(t1, t2) of equation (2); t = ∞ is no rotation."""
        return _factor(t1, self.h1) * _factor(t2, self.h2) * self.home

    def _repr_html_(self) -> str:
        """The axes of a single dyad as a table, at home, with angle and distance; a batch as one line."""
        if self.shape:
            return f"<p>2R dyads of shape {self.shape}</p>"
        base, moving = self.axes
        distance, angle = float(base.distance(moving)), math.degrees(base.angle(moving))
        far = RTOL * max(distance, *(float(np.linalg.norm(as_float(line.foot()))) for line in self.axes))
        rows = [
            (name, _listed(_of_length_one(line.direction), RTOL), _listed(line.foot(), far))
            for name, line in (("at the base (h1)", base), ("moving (h2)", moving))
        ]
        caption = f"2R dyad: axes {in_words(distance, far)} apart, at {in_words(angle, RTOL)}°; home {self.home!r}"
        return html_table(caption, ("axis", "direction", "point next to the origin"), rows)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return np.broadcast_shapes(self.h1.shape, self.h2.shape, self.home.shape)

    @property
    def axes(self) -> tuple[Line, Line]:
        """The axes of h1 and h2 as lines, in the fixed frame at t1 = t2 = ∞."""
        return Line.from_dual_quaternion(self.h1), Line.from_dual_quaternion(self.h2)

    @property
    def basis(self) -> tuple[DualQuaternion, ...]:
        """The base points 1, h1, h2, h1h2 of the 2R space (times the home pose)."""
        return tuple(x * self.home for x in (one, self.h1, self.h2, self.h1 * self.h2))

    def space(self) -> TwoRSpace:
        """The 2R space of the dyad."""
        return TwoRSpace(self)

    def coordinates(self, point: PoseLike) -> tuple[Scalars, Scalars, Scalars, Scalars]:
        """The x0, x1, x2, x3 with primal part of the point = that of x0 + x1 h1 + x2 h2 + x3 h1h2 (times home).

        Only the orientation counts: there is one point of the 2R space with it, and where the given point lies is not
        asked.  Poses R(t1, t2) have the coordinates t1 t2, −t2, −t1, 1, so they lie on the quadric x0 x3 = x1 x2.

        Parameters
        ----------
        point : pose, or any dual quaternion of shape (...)
        """
        if np.any(self.is_parallel()):
            raise DegenerateError("the axes are parallel: their 2R space meets the exceptional three-space")
        q = point if isinstance(point, DualQuaternion) else as_pose(point)
        return primal_coordinates(q * self.home.inverse(), self.h1, self.h2)

    def is_parallel(self) -> bool | Array:
        """Whether the two axes are parallel, so that the 2R space meets the exceptional three-space."""
        n1, n2, c = null_form(self.h1, self.h1), null_form(self.h2, self.h2), null_form(self.h1, self.h2)
        return is_zero(n1 * n2 - c * c, n1 * n2, 1e-28)

    def parameters(
        self, pose: PoseLike, *, rtol: float = RTOL, degenerate: Degenerate = "raise"
    ) -> tuple[Scalars, Scalars]:
        """The t1, t2 with R(t1, t2) = pose, for a pose that the dyad reaches; ∞ where a joint is at home.

        Parameters
        ----------
        pose : pose, shape (...)
        rtol : float
            How far the dyad may pass from the pose, in half-angles and in units of its own size.
        degenerate : {"raise", "nan"}
            What to do about poses that are not reached.

        Raises
        ------
        DegenerateError
            If the dyad does not reach the pose, with the distance to the pose of the dyad that is as near in turning.

        Examples
        --------
        >>> dyad = Dyad(i, j - eps * i)
        >>> t1, t2 = dyad.parameters(dyad(2, 3))
        >>> int(t1), int(t2)
        (2, 3)
        >>> dyad.parameters(1 + k)
        Traceback (most recent call last):
        ...
        kinlib.errors.DegenerateError: the dyad does not reach the pose: it passes by at 1 (the tangent of half the turn
        that is missing, or half the shift in units of the dyad's size, whichever is more)
        """
        q = as_pose(pose) * self.home.inverse()
        turns, off, noise = self._candidate(q)
        if np.any(off) and all(is_exact(x.components) for x in (q, self.h1, self.h2)):
            off = np.where(off == 0, 0.0, np.maximum(self._in_floats()._candidate(_floats(q))[1], 2 * RTOL))
        bad = self._unreached(off, rtol + noise, degenerate)
        t1, t2 = (_parameter(numerator, denominator) for numerator, denominator in turns)
        return (np.where(bad, np.nan, t1), np.where(bad, np.nan, t2)) if np.any(bad) else (t1, t2)

    def _in_floats(self) -> Dyad:
        return Dyad(*(unit(_floats(h)) for h in (self.h1, self.h2)))

    def _candidate(self, q: DualQuaternion) -> tuple[tuple[Ratio, Ratio], np.ndarray, np.ndarray]:
        """The parameters that a displacement from home would have, how far it is from the pose there, rounding."""
        (seen, h1, h2), noise = self._seen(q)
        turns = homogeneous_parameters(seen, h1, h2)
        return turns, gap(reached(h1, h2, turns), seen), noise

    def _seen(self, q: DualQuaternion) -> tuple[list[DualQuaternion], np.ndarray]:
        """A displacement and both half-turns, and what rounding makes of a length.

        In floats they are seen about the middle of the axes, in units of their size.
        """
        given = [q, self.h1, self.h2]
        if all(is_exact(x.components) for x in given):
            return given, np.array(0)
        given = [_floats(x) for x in given]
        middle = middle_of(given[1:])
        q, *turns = (moved_origin(x, middle) for x in given)
        q = unit(q)
        far, length = (
            np.maximum.reduce(np.broadcast_arrays(*(dual_size(x) / primal_size(x) for x in several)))
            for several in (given, (q, *turns))
        )
        length = np.where(length > 0, length, 1)
        return [stretched(x, 1 / length) for x in (q, *turns)], ROUNDING * far / length

    @staticmethod
    def _unreached(off: np.ndarray, rtol: np.ndarray, degenerate: Degenerate) -> np.ndarray:
        check_degenerate(degenerate)
        bad = np.asarray(~(off <= rtol))
        if degenerate == "raise" and bad.any():
            rows = rows_where(bad)
            raise DegenerateError(
                f"{named_rows(rows)}the dyad does not reach the pose: it passes by at {np.max(off[bad]):.2g} "
                "(the tangent of half the turn that is missing, or half the shift in units of the dyad's size, "
                "whichever is more)",
                rows=rows,
            )
        return bad


def primal_coordinates(
    x: DualQuaternion, h1: DualQuaternion, h2: DualQuaternion
) -> tuple[Scalars, Scalars, Scalars, Scalars]:
    """The coordinates of the primal part of x in the basis 1, h1, h2, h1h2; its Gram matrix splits into 2×2 blocks."""
    n1, n2, c = null_form(h1, h1), null_form(h2, h2), null_form(h1, h2)
    area = n1 * n2 - c * c
    along = [null_form(x, y) for y in (one, h1, h2, h1 * h2)]
    return (
        divide(n1 * n2 * along[0] + c * along[3], area),
        divide(n2 * along[1] - c * along[2], area),
        divide(n1 * along[2] - c * along[1], area),
        divide(c * along[0] + along[3], area),
    )


def _floats(q: DualQuaternion) -> DualQuaternion:
    return DualQuaternion(as_float(q.coeffs))


Ratio: TypeAlias = tuple[Scalars, Scalars]
"""A parameter a/b as the pair (a, b); b = 0 for ∞."""


def homogeneous_parameters(q: DualQuaternion, h1: DualQuaternion, h2: DualQuaternion) -> tuple[Ratio, Ratio]:
    """The parameters t1 = a1/b1, t2 = a2/b2 of the pose q of a dyad, as pairs (a, b).

    (t1 + h1) q is a multiple of t2 − h2, and q (t2 + h2) one of t1 − h1.  So modulo 1 and h2 the points q and h1 q are
    multiples of each other, and so are q and q h2 modulo 1 and h1.
    """
    return _parameter_pair(_modulo(q, h2), _modulo(h1 * q, h2)), _parameter_pair(_modulo(q, h1), _modulo(q * h2, h1))


def _modulo(q: DualQuaternion, h: DualQuaternion) -> np.ndarray:
    """The coefficients but the first, without their component along those of h."""
    x, axis = np.broadcast_arrays(q.components[1:], h.components[1:])
    return x - axis * divide((x * axis).sum(axis=0), (axis * axis).sum(axis=0))


def _parameter_pair(x: np.ndarray, y: np.ndarray) -> Ratio:
    """The (a, b) with a x + b y = 0, from the larger of the two."""
    xx, xy, yy = (x * x).sum(axis=0), (x * y).sum(axis=0), (y * y).sum(axis=0)
    use = ~np.asarray(is_zero(xx, rtol=0)) if is_exact(x) else xx >= yy
    return np.where(use, -xy, -yy)[()], np.where(use, xx, xy)[()]


def reached(h1: DualQuaternion, h2: DualQuaternion, turns: tuple[Ratio, Ratio]) -> DualQuaternion:
    """A multiple of the pose (t1 − h1)(t2 − h2) for the parameters a/b, given as pairs (a, b)."""
    (a1, b1), (a2, b2) = turns
    return (a1 - h1 * b1) * (a2 - h2 * b2)


def _quotient_or_infinity(a: Scalars, b: Scalars) -> Scalars:
    if is_zero(b, abs(a), ROUNDING) if isinstance(b, float) else is_zero(b):
        return np.inf
    return divide(a, b)


def _parameter(a: Scalars, b: Scalars) -> Scalars:
    """The quotient a/b; ∞ where b vanishes."""
    values = np.frompyfunc(_quotient_or_infinity, 2, 1)(a, b)
    if np.asarray(a).dtype.kind in "fc":
        return values if np.ndim(values) == 0 else values.astype(np.result_type(a, b))
    return values


def _factor(t: Scalars, h: DualQuaternion) -> DualQuaternion:
    return one if np.ndim(t) == 0 and is_infinite(t) else t - h


def _pose_or_nan(home: PoseLike) -> DualQuaternion:
    """The home pose, checked but for rows of NaN, which stand for what is not determined."""
    if not isinstance(home, DualQuaternion) or home.components.dtype.kind != "f":
        return as_pose(home)
    undetermined = np.isnan(home.components).any(axis=0)
    if not undetermined.any():
        return as_pose(home)
    as_pose(DualQuaternion(np.where(undetermined[..., None], one.coeffs.astype(float), home.coeffs)))
    return home


def _is_half_turn(h: DualQuaternion) -> Array:
    real = is_zero(h.components[[0, 4]], size(h.components, 0), RTOL)
    p, d = size(h.components[1:4], 0), size(h.components[5:], 0)
    on_quadric = is_zero(study_form(h, h), p * d + p * p, RTOL)
    return (np.all(real, axis=0) & on_quadric & (p > 0)) | np.isnan(p)


def _of_length_one(direction: Array) -> Array:
    return as_float(direction) / np.linalg.norm(as_float(direction))


def _listed(vector: Array, least: float) -> str:
    return ", ".join(in_words(x, least) for x in as_float(vector).tolist())


def _commute(h1: DualQuaternion, h2: DualQuaternion) -> Array:
    """Whether two half-turns have one axis: parallel directions, and moments in the same ratio."""
    l1, m1, l2, m2 = (x for h in (h1, h2) for x in (h.components[1:4], h.components[5:]))
    minors = [l1[a] * l2[b] - l1[b] * l2[a] for a, b in ((0, 1), (1, 2), (2, 0))]
    parallel = np.all([is_zero(x, size(l1, 0) * size(l2, 0), 1e-12) for x in minors], axis=0)
    square, product = sum(a * a for a in l2), sum(a * b for a, b in zip(l1, l2, strict=True))
    shift = [a * square - b * product for a, b in zip(m1, m2, strict=True)]
    return parallel & np.all([is_zero(x, size(m1, 0) * size(l2, 0) ** 2, 1e-12) for x in shift], axis=0)


@dataclass(frozen=True, eq=False)
class TwoRSpace:
    """The 3-space spanned by the image of a 2R dyad.

    Examples
    --------
    >>> space = Dyad(i, j - eps * i).space()
    >>> i * (j - eps * i) in space, (j - eps * i) * i in space
    (True, False)
    """

    dyad: Dyad

    @property
    def points(self) -> DualQuaternion:
        """Four points that span the space, shape (..., 4)."""
        return DualQuaternion.stack(self.dyad.basis, axis=-1)

    def as_subspace(self) -> Subspace:
        """The space as a subspace of P⁷."""
        return Subspace(self.points.coeffs)

    def contains(self, pose: PoseLike, *, rtol: float = RTOL) -> bool | Array:
        """Whether a point of P⁷ lies in the space; batches give one answer an entry."""
        x = pose if isinstance(pose, DualQuaternion) else as_pose(pose)
        if not self.dyad.shape and self.dyad.is_parallel():
            return self.as_subspace().contains(x)
        inside = sum((e * c for c, e in zip(self.dyad.coordinates(x), self.dyad.basis, strict=True)), one * 0)
        difference = (inside - x).components
        moments = [size(e.components[4:], 0) / size(e.components[:4], 0) for e in self.dyad.basis]
        primal = size(x.components[:4], 0)
        dual = np.maximum(size(x.components[4:], 0), primal * np.max(np.broadcast_arrays(*moments), axis=0))
        close = np.concatenate([is_zero(difference[:4], primal, rtol), is_zero(difference[4:], dual, rtol)])
        return np.all(close, axis=0)[()]

    def __contains__(self, pose: PoseLike) -> bool:
        return bool(np.all(self.contains(pose)))

    def quadric(self) -> Quadric:
        """The Study quadric in the coordinates of the basis 1, h1, h2, h1h2: a multiple of x0 x3 − x1 x2."""
        return STUDY_QUADRIC.restrict(self.as_subspace())

    def null_quadrilateral(self) -> NullQuadrilateral:
        """The null quadrilateral t1, t2 = ±√−1 of Lemma 2, four complex points.

        Examples
        --------
        >>> from kinlib import is_null_line
        >>> u1, v1, u2, v2 = Dyad(i, j - eps * i).space().null_quadrilateral()
        >>> all(is_null_line(x, y) for x, y in [(u1, v1), (v1, u2), (u2, v2), (v2, u1)])
        True
        """
        imaginary = imaginary_unit(self.dyad.h1.components)
        t1, t2 = (imaginary * square_root(null_form(h, h)) for h in (self.dyad.h1, self.dyad.h2))
        signs = ((1, -1), (1, 1), (-1, 1), (-1, -1))
        return NullQuadrilateral(*(self.dyad(s1 * t1, s2 * t2) for s1, s2 in signs))


def recognise(
    basis: Subspace | TwoRSpace | DualQuaternionLike, *, rtol: float = RTOL, degenerate: Degenerate = "raise"
) -> Dyad:
    """Theorem 1 as a procedure: the 2R dyad of a 3-space, or the condition that fails.

    A real 3-space P through [1] that misses E is a 2R space exactly if A = N⁻¹S satisfies
    A² − ½ tr(A) A + κ = 0 with A not scalar and κ ≠ 0, where S and N are the matrices of the Study form and
    of the null form on P.  The axes are the two points of the Study quadric on the line of P in which it meets
    the vectors l + εm.

    Parameters
    ----------
    basis : Subspace, TwoRSpace, DualQuaternion of shape (..., 4), or array_like of shape (..., 4, 8)
        Four points that span the 3-space; floats or exact.
    rtol : float
        What counts as zero for floats.
    degenerate : {"raise", "nan"}
        What to do about rows of a batch that are no 2R spaces.

    Raises
    ------
    DegenerateError
        Naming the first condition that fails.

    Examples
    --------
    >>> dyad = recognise([one.coeffs, i.coeffs, (j - eps * i).coeffs, (i * (j - eps * i)).coeffs])
    >>> dyad.h1, dyad.h2
    (i, j - εi)
    >>> recognise(DualQuaternion.stack([one, i, j, k]))
    Traceback (most recent call last):
    ...
    kinlib.errors.DegenerateError: the space lies in the Study quadric: the axes would be coplanar
    """
    points = DualQuaternion(coordinates_of(basis.points if isinstance(basis, TwoRSpace) else _rows(basis)))
    check_degenerate(degenerate)
    if len(points.shape) != 1 and points.shape[-1:] != (4,):
        raise ValueError(f"expected four points that span a 3-space, shape (..., 4, 8), got {points.coeffs.shape}")
    if points.components.dtype.kind == "c":
        raise ValueError("expected a real 3-space, got complex points")
    if len(points.shape) == 1:
        return _of_one_space(points, rtol)
    return _of_many_spaces(points, rtol, degenerate)


def _of_many_spaces(points: DualQuaternion, rtol: float, degenerate: Degenerate) -> Dyad:
    """The dyads of a batch of 3-spaces, one after the other."""
    rows, found, lost = points.coeffs.reshape(-1, 4, 8), [], {}
    for n, row in enumerate(rows):
        try:
            dyad = _of_one_space(DualQuaternion(row), rtol)
            found.append((dyad.h1.coeffs, dyad.h2.coeffs))
        except ValueError as error:
            lost[n] = str(error)
            found.append((np.full(8, np.nan),) * 2)
    if lost and degenerate == "raise":
        said = "; ".join(dict.fromkeys(lost.values()))
        raise DegenerateError(f"{named_rows(list(lost))}{said}", rows=tuple(lost))
    h1, h2 = (np.array(turns).reshape(*points.shape[:-1], 8) for turns in zip(*found, strict=True))
    return Dyad(DualQuaternion(h1), DualQuaternion(h2))


def _of_one_space(points: DualQuaternion, rtol: float) -> Dyad:
    """The dyad of one 3-space; in floats seen about the middle of the points, in units of their length."""
    if is_exact(points.components):
        return _recognised(_three_space(points, rtol), rtol)
    if not np.all(np.isfinite(points.components)):
        raise ValueError("expected finite coefficients, got NaN or infinity")
    if not np.any(points.components[:4]):
        raise DegenerateError("the space is the exceptional three-space: no displacement belongs to its points")
    rows = points / np.maximum(primal_size(points), dual_size(points) * 1e-6)
    middle, before = middle_of(rows), np.max(dual_size(rows))
    rows = moved_origin(rows, middle)
    length = float(np.max(dual_size(rows))) or 1.0
    if length <= 1e-10 * before:  # nothing but rounding is left about the middle: all axes meet there
        length = float(before)
    rtol = max(rtol, 1e-13 * before / length)  # what the distance from the origin has cost
    dyad = _recognised(_three_space(stretched(rows, 1 / length), rtol), rtol)
    return Dyad(*(moved_origin(stretched(h, length), -middle) for h in (dyad.h1, dyad.h2)))


def _rows(basis: Subspace | DualQuaternionLike) -> DualQuaternionLike:
    return basis.basis if isinstance(basis, Subspace) else basis


def _recognised(space: Subspace, rtol: float) -> Dyad:
    null, study = NULL_CONE.restrict(space), STUDY_QUADRIC.restrict(space)
    if np.all(is_zero(study.matrix, 1.0, rtol)):
        raise DegenerateError("the space lies in the Study quadric: the axes would be coplanar")
    if null.rank(rtol=rtol) < 4:
        raise DegenerateError(
            "the space meets the exceptional three-space: one of the joints would be prismatic, or the axes parallel"
        )
    _check_regular(study, rtol)
    _check_null_quadrilateral(null, study, rtol)
    first, second = _rotations(space)
    if space.contains(first * second):
        return Dyad(first, second)
    return Dyad(second, first)


def _three_space(points: DualQuaternion, rtol: float) -> Subspace:
    space = join(points, rtol=rtol)
    if space.dimension != 3:
        raise DegenerateError(f"expected points that span a 3-space, got a span of dimension {space.dimension}")
    if not space.contains(one):
        raise DegenerateError("the space does not contain [1], the identity: multiply by the inverse of a pose")
    return space


def _check_regular(study: Quadric, rtol: float) -> None:
    rank = study.rank(rtol=rtol)
    if rank < 4:
        raise DegenerateError(f"the space meets the Study quadric in a singular quadric, of rank {rank}")
    positive, _ = study.signature()
    if positive != 2:
        raise DegenerateError(
            "the space meets the Study quadric in a regular quadric without real lines: the axes would be complex"
        )


def _check_null_quadrilateral(null: Quadric, study: Quadric, rtol: float) -> None:
    A = _solve(null.matrix, study.matrix)
    square = A @ A - divide(np.trace(A), 2) * A
    scalar = np.eye(4, dtype=int) * square[0, 0]
    if not np.all(is_zero(square - scalar, size(A) ** 2, rtol)):
        raise DegenerateError("the space contains no null quadrilateral: its real rulings are not rotations of a dyad")


def _solve(N: np.ndarray, S: np.ndarray) -> np.ndarray:
    """N⁻¹S, from the null space of [N, −S]: for each column x of S the solution of N y = x."""
    if not is_exact(N) or not is_exact(S):
        return np.linalg.solve(N, S)
    columns = [null_space(np.column_stack([N, -S[:, n]])) for n in range(len(S))]
    return np.array([divide(c[0, :-1], c[0, -1]) for c in columns], dtype=object).T


def _rotations(space: Subspace) -> tuple[DualQuaternion, DualQuaternion]:
    """The two points of the Study quadric on the line of half-turns in the space, as unit ones if possible."""
    half_turns = [one.coeffs, coordinates_of(_DUAL_ONE)]
    conditions = np.array([space.basis @ row for row in half_turns])
    line = DualQuaternion(null_space(conditions) @ space.basis)
    x, y = line
    roots = binary_roots(study_form(x, x), study_form(x, y), study_form(y, y))
    first, second = (unit(x * s + y * t) for s, t in roots)
    return first, second


_DUAL_ONE = DualQuaternion([0, 0, 0, 0, 1, 0, 0, 0])
