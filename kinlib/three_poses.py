"""Theorem 2: the two 2R dyads through three poses, by three routes.

As seen from the first pose the plane of the poses is spanned by [1], [q1], [q2].  Let μ1 ≤ μ2 ≤ μ3 be the eigenvalues
of the Study form relative to the null form on it.  There are two 2R spaces through the plane if the three differ, and
one if two of them agree.  The conic of the plane is the coupler motion of a Bennett linkage; it splits into linear
factors about the axes of either dyad.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, eps, eps_times, i, j, null_form, one, study_form, wrap
from kinlib.dyad import Dyad, homogeneous_parameters, primal_coordinates, reached
from kinlib.errors import Fault, first_fault, report_faults
from kinlib.factorization import factor_in_orders, polished, quadratic_factors, solved
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.poses import PoseProblem, as_pose, gap, masked, opening, seen_together
from kinlib.scalar import as_float, divide, is_exact, is_zero

__all__ = ["dyads_through_poses", "study_eigenvalues"]

MEETS = "the plane of the three poses meets the exceptional three-space"
TANGENT = (
    "poses {} and {} differ by a rotation, so the plane of the three poses is tangent to the Study quadric: there are "
    "two 2R dyads, which method='eigenvalues' finds, but no conic and no Bennett linkage"
)


class PoseFault(Fault):
    """What can be wrong with three poses."""

    EQUAL_01 = 1, "poses 0 and 1 are equal: three different poses are needed"
    EQUAL_02 = 2, "poses 0 and 2 are equal: three different poses are needed"
    EQUAL_12 = 3, "poses 1 and 2 are equal: three different poses are needed"
    SLIDE_01 = 4, f"{MEETS}: poses 0 and 1 differ by a pure translation"
    SLIDE_02 = 5, f"{MEETS}: poses 0 and 2 differ by a pure translation"
    SLIDE_12 = 6, f"{MEETS}: poses 1 and 2 differ by a pure translation"
    PARALLEL = 7, f"{MEETS}: the three orientations differ by rotations about parallel axes"
    INSIDE = (
        8,
        "the plane of the three poses lies in the Study quadric: no 2R space contains it, as its quadric is regular",
    )
    DOUBLE = 9, "the quartic of the three poses has double roots: one 2R dyad passes through them, not two"
    TANGENT_01 = 10, TANGENT.format(0, 1)
    TANGENT_02 = 11, TANGENT.format(0, 2)
    TANGENT_12 = 12, TANGENT.format(1, 2)
    INVALID = 13, "a number is not finite, or a pose is none"


EQUAL = (PoseFault.EQUAL_01, PoseFault.EQUAL_02, PoseFault.EQUAL_12)
SLIDE = (PoseFault.SLIDE_01, PoseFault.SLIDE_02, PoseFault.SLIDE_12)
TANGENTS = (PoseFault.TANGENT_01, PoseFault.TANGENT_02, PoseFault.TANGENT_12)

APART = 1e-12
"""How near a plane may come to the exceptional space before rounding decides what is found."""

SHIFT = 1e-10
"""How far apart two poses of one orientation may be, in the unit of the problem, and still count as equal."""

MET = 1e-10
"""How far a pose may be missed, in half-angles and in the unit of the problem; more is refused."""

GOOD = 1e-12
"""How far a pose may be missed before the answer is improved."""

Pair = tuple[DualQuaternion, DualQuaternion]


def dyads_through_poses(p0, p1, p2, *, method: str | None = None, degenerate: str = "raise") -> tuple[Dyad, Dyad]:
    """The two 2R dyads through three poses (Theorem 2).

    Each joint of a dyad turns through the poses in the sense of its half-turn, from p0 over p1 to p2 (the conic has
    the linear factor t − x − y h with y > 0).  First comes the dyad whose base joint has the smaller x, then the
    smaller y.  So the answer depends on neither frames, units nor representatives; exchanging p1 and p2 reverses the
    half-turns and the order.  On tangent planes, where there is no conic, b(h1, h2) > 0.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Any poses; p0 becomes the home pose of the dyads.  Batches broadcast.
    method : {"eigenvalues", "factorization", "null_quadrilateral"}, optional
        The route.  ``"eigenvalues"``: from the Study form relative to the null form on the plane of the poses;
        floats; right on tangent planes; the default for floats.  ``"factorization"``:
        from the two factorizations of the conic through the poses; exact for exact poses, and the default
        for them.  ``"null_quadrilateral"``: the construction of the paper's proof, in complex floats.
    degenerate : {"raise", "nan"}
        What to do about rows of a batch for which the answer is not determined; ``"nan"`` needs floats.

    Returns
    -------
    tuple of two Dyads
        Each passes through all three poses: checked, to a thousandth of a millionth of the size of the problem.

    Raises
    ------
    DegenerateError
        Naming the geometry and, in a batch, the rows; where there is one dyad instead of two, it is attached
        as ``error.dyad``.

    Examples
    --------
    >>> poses = one, i * (j - eps * i), (1 - i) * (2 - j + eps * i)
    >>> for dyad in dyads_through_poses(*poses):
    ...     print(dyad.h1, "|", dyad.h2, "|", all(pose in dyad.space() for pose in poses))
    4/5 i - 3/5 j - 9/25 εi - 12/25 εj | 3/5 i + 4/5 j - 8/25 εi + 6/25 εj | True
    i | j - εi | True
    """
    poses = (p0, p1, p2) if method in (None, "factorization") else [_in_floats(p) for p in (p0, p1, p2)]
    problem = seen_together(*poses, degenerate=degenerate)
    both = two_dyads(problem, degenerate, method, tangent=True)
    return tuple(Dyad(*map(problem.outward, both.half_turns(n)), problem.home) for n in range(2))


def study_eigenvalues(p0, p1, p2) -> np.ndarray:
    """The eigenvalues μ1 ≤ μ2 ≤ μ3 of the Study form relative to the null form on the plane of three poses.

    Both dyads through the poses have (μ3 − μ1)/2 as the ratio of distance and sine of the angle of their axes,
    and −μ1 μ3 as the square of the distance.  Floats, in units of length, shape (..., 3).

    Raises
    ------
    DegenerateError
        If the plane meets the exceptional three-space, on which the null form vanishes.

    Examples
    --------
    >>> study_eigenvalues(one, i * (j - eps * i), (1 - i) * (2 - j + eps * i)).round(6).tolist()
    [-1.0, -0.8, 1.0]
    """
    problem = seen_together(*map(_in_floats, (p0, p1, p2)))
    faults = faults_of_poses(problem)
    report_faults(np.where(faults == PoseFault.INSIDE, 0, faults), PoseFault, "raise")
    return _spectrum(*problem.others).values * problem.length[..., None]


def _in_floats(pose) -> DualQuaternion:
    return DualQuaternion(as_float(as_pose(pose).coeffs))


# ---- what is wrong with the poses --------------------------------------------------------------------


def faults_of_poses(problem: PoseProblem) -> np.ndarray:
    """What is wrong with three poses themselves, whatever is asked of them: a PoseFault a row, or 0."""
    still = [_is_still(step) for step in problem.steps]
    same = [turned & _is_near(step, problem) for turned, step in zip(still, problem.steps, strict=True)]
    return first_fault(
        (_not_finite(problem), PoseFault.INVALID),
        *zip(same, EQUAL, strict=True),
        *zip(still, SLIDE, strict=True),
        (_sine(problem) <= (0 if problem.is_exact else APART), PoseFault.PARALLEL),
        (np.all(_are_rotations(problem), axis=0), PoseFault.INSIDE),
    )


def tangent_faults(problem: PoseProblem) -> np.ndarray:
    """Which two poses differ by a rotation, so that there is no conic: a PoseFault a row, or 0."""
    return first_fault(*zip(_are_rotations(problem), TANGENTS, strict=True))


def _are_rotations(problem: PoseProblem) -> list[np.ndarray]:
    """Whether the steps are rotations: b divided by the sine of the half-angle is the pitch, up to a factor."""
    limit = 1e-14 + 4 * problem.noise
    return [
        is_zero(b, _largest(step.components[1:4]), limit) for b, step in zip(problem.forms, problem.steps, strict=True)
    ]


def _not_finite(problem: PoseProblem) -> np.ndarray:
    return ~np.all([np.isfinite(as_float(q.components)).all(axis=0) for q in problem.others], axis=0)


def _largest(rows) -> np.ndarray:
    return np.max([np.abs(as_float(x)) for x in rows], axis=0)


def _is_still(step: DualQuaternion) -> np.ndarray:
    """Whether a step does not turn."""
    return np.all(is_zero(step.components[1:4], 1.0, APART), axis=0)


def _is_near(step: DualQuaternion, problem: PoseProblem) -> np.ndarray:
    """Whether a step that does not turn does not shift either."""
    return np.all(is_zero(step.components[4:], 1.0, SHIFT + problem.noise), axis=0)


def _apart(q1: DualQuaternion, q2: DualQuaternion) -> np.ndarray:
    """How far the plane of [1], [q1], [q2] is from the exceptional space: 0 if the turns have parallel axes."""
    (a1, a2, a3), (b1, b2, b3) = (q.components[1:4] for q in (q1, q2))
    cross = np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])
    if is_exact(cross):
        return np.where(np.all(is_zero(cross), axis=0), 0.0, 1.0)
    longest = np.sqrt(np.maximum(a1 * a1 + a2 * a2 + a3 * a3, b1 * b1 + b2 * b2 + b3 * b3))
    return np.sqrt((cross * cross).sum(axis=0)) / np.where(longest > 0, longest, 1)


def _sine(problem: PoseProblem) -> np.ndarray:
    """The sine of the angle between the axes of the turns from the first pose."""
    turns = [_largest(step.components[1:4]) for step in problem.steps[:2]]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nan_to_num(_apart(*problem.others) / np.minimum(*turns), nan=1.0)


def _nearest(problem: PoseProblem) -> tuple[np.ndarray, np.ndarray]:
    """The fault that each row is nearest to, and how near, relative to the size of what vanishes there."""
    turns, shifts = ([_largest(step.components[part]) for step in problem.steps] for part in (slice(1, 4), slice(4, 8)))
    forms = [np.abs(b) for b in problem.forms]
    measured = [
        *zip([np.maximum(*sizes) for sizes in zip(turns, shifts, strict=True)], EQUAL, strict=True),
        *zip([turn / (turn + shift) for turn, shift in zip(turns, shifts, strict=True)], SLIDE, strict=True),
        (_sine(problem), PoseFault.PARALLEL),
        *zip([b / (turn * shift) for b, turn, shift in zip(forms, turns, shifts, strict=True)], TANGENTS, strict=True),
    ]
    sizes = np.array([np.broadcast_to(np.nan_to_num(size, nan=np.inf), problem.home.shape) for size, _ in measured])
    return np.array([int(fault) for _, fault in measured])[np.argmin(sizes, axis=0)], sizes.min(axis=0)


# ---- both dyads, and the conic in linear factors -----------------------------------------------------


class TwoDyads(NamedTuple):
    """Both dyads through three poses, and the conic in linear factors about their axes, in the problem's own frame.

    The last axis of each batch tells the dyads apart.  The factors are those of C(start + τ), a polynomial in τ: near
    t = start they keep digits that the factors of C(t) lose.  They are NaN where there is no conic.
    """

    h1: DualQuaternion
    h2: DualQuaternion
    k1: DualQuaternion
    k2: DualQuaternion
    start: np.ndarray

    def half_turns(self, n: int) -> Pair:
        """The half-turns about the axes of dyad n."""
        return self.h1[..., n], self.h2[..., n]

    def factors(self, n: int) -> Pair:
        """The k1, k2 about the axes of dyad n with C(t) = (t − k1)(t − k2)."""
        return self.k1[..., n] + self.start, self.k2[..., n] + self.start

    def stops(self, n: int) -> tuple[tuple, tuple]:
        """The (s1, s2) with which dyad n is in the second pose, and in the third, as (s1 − h1)(s2 − h2).

        From t − k = y ((t − x)/y − h) for k = x + y h.
        """
        turns = [_about(k[..., n], h[..., n]) for k, h in ((self.k1, self.h1), (self.k2, self.h2))]
        return tuple(tuple(divide(t - self.start - x, y) for x, y in turns) for t in (0, 1))


def _about(k: DualQuaternion, h: DualQuaternion) -> tuple:
    """The x, y of k = x + y h."""
    return k.scalar_part, divide(null_form(k, h), null_form(h, h))


def two_dyads(problem: PoseProblem, degenerate: str, method: str | None = None, *, tangent: bool = False) -> TwoDyads:
    """Theorem 2 for a problem: checked against its poses, improved where rounding asks for it, else refused.

    With ``tangent`` the dyads of tangent planes are wanted too, where there is no conic.
    """
    method = method or ("factorization" if problem.is_exact else "eigenvalues")
    if method not in ROUTES:
        raise ValueError(f"expected a method among {', '.join(ROUTES)}, got {method!r}")
    if problem.is_exact and degenerate == "nan":
        raise ValueError("degenerate='nan' needs floats, since NaN is one: convert the poses, or use 'raise'")
    faults, tangents = faults_of_poses(problem), tangent_faults(problem)
    if not tangent or method != "eigenvalues":
        faults = np.where(faults, faults, tangents)
    if not problem.is_exact:
        return _float_dyads(_replaced(problem, faults > 0), faults, method, degenerate, tangent)
    report_faults(faults, PoseFault, degenerate)
    return _exact_dyads(problem)


def _exact_dyads(problem: PoseProblem) -> TwoDyads:
    """From the two factorizations of the conic; the only irrational step is to split its quartic."""
    C = _conic_from(problem, np.array(0))
    quadratics = quadratic_factors(C.norm_polynomial())
    k1, k2 = factor_in_orders(C, quadratics, BOTH_ORDERS)
    both = TwoDyads(axis_of(k1), axis_of(k2), k1, k2, np.array(0))
    _report_missed(problem, _missed(problem.others, both.start, k1, k2) > 0, "raise")
    double = np.asarray((quadratics[..., 0, :] == quadratics[..., 1, :]).all(axis=-1))
    dyad = Dyad(*both.half_turns(0), problem.home) if double.ndim == 0 and double else None
    report_faults(double * PoseFault.DOUBLE, PoseFault, "raise", dyad=dyad)
    return both


BOTH_ORDERS = ((0, 1), (1, 0))


def _float_dyads(problem: PoseProblem, faults, method: str, degenerate: str, tangent: bool) -> TwoDyads:
    """By one of the routes, and by all that repairs what rounding does to it; faulty rows hold a regular problem."""
    with np.errstate(all="ignore"):
        plane = _spectrum(*problem.others)
        start = _start(problem)
        C = _conic_from(problem, start)
        h1, h2 = ROUTES[method](problem, plane)
        k1, k2, missed = _improved(problem, C, start, *_linear_factors(h1, h2, C))
        no_conic = ~(missed <= MET)
        h1, h2 = (chosen(no_conic, h, _half_turn(k)) for h, k in ((h1, k1), (h2, k2)))
        double = _has_double_roots(problem, plane) & (no_conic | _same_quadratics(k1, k2))
        off = np.where(no_conic, _missed_by(problem, h1, h2), missed) if tangent and no_conic.any() else missed
    faults = np.where(faults, faults, double * PoseFault.DOUBLE)
    only = (
        _only_dyad(problem, plane)
        if degenerate == "raise" and faults.ndim == 0 and faults == PoseFault.DOUBLE
        else None
    )
    bad = report_faults(faults, PoseFault, degenerate, dyad=only)
    lost = ~bad & ~(off <= MET)
    _report_missed(problem, lost, degenerate)
    bad = (bad | lost)[..., None]
    later = ~no_conic & _comes_later(k1)
    h1, h2, k1, k2 = (_exchanged(q, later) for q in (h1, h2, k1, k2))
    return TwoDyads(masked(h1, bad), masked(h2, bad), *(masked(k, bad | no_conic[..., None]) for k in (k1, k2)), start)


ALMOST = "the answer would miss the poses; they are near a place where there is none: "


def _report_missed(problem: PoseProblem, lost: np.ndarray, degenerate: str) -> None:
    """Say what the rows are near to in which nothing was found that meets the poses."""
    if np.any(lost):
        nearest, how_near = _nearest(problem)
        report_faults(lost * nearest, PoseFault, degenerate, place=ALMOST, how_near=how_near)


def _only_dyad(problem: PoseProblem, plane: _Spectrum) -> Dyad:
    """The dyad of a single problem with double roots."""
    h1, h2 = _by_eigenvalues(problem, _rounded(plane))
    return Dyad(problem.outward(h1[0]), problem.outward(h2[0]), problem.home)


STAND_INS = tuple(unit(q.astype(float)) for q in (i * (j - eps * i), (1 - i) * (2 - j + eps * i)))
"""The second and the third pose of a regular problem, in place of faulty rows."""


def _replaced(problem: PoseProblem, rows: np.ndarray) -> PoseProblem:
    """The same problem with a regular one in place of the given rows."""
    if not rows.any():
        return problem
    others = tuple(chosen(rows, stand_in, q) for q, stand_in in zip(problem.others, STAND_INS, strict=True))
    return replace(problem, others=others)


def chosen(rows: np.ndarray, x: DualQuaternion, y: DualQuaternion) -> DualQuaternion:
    """x in the given rows, y in the others; a row may hold both dyads."""
    if not rows.any():
        return y
    return DualQuaternion(
        np.where(rows.reshape(*rows.shape, *[1] * max(len(y.shape) - rows.ndim, 0), 1), x.coeffs, y.coeffs)
    )


def _start(problem: PoseProblem) -> np.ndarray:
    """Which of t = 0 and t = 1 the conic passes more slowly: there its polynomial needs its digits."""
    first, second = _weights(problem)
    return np.where(np.abs(second) < np.abs(first), 1.0, 0.0)


def _weights(problem: PoseProblem) -> tuple:
    """The b02/b12 and b01/b12 with which C(0) and C(1) are multiples of the second and third pose."""
    b01, b02, b12 = problem.forms
    return divide(b02, b12), divide(b01, b12)


def _conic_from(problem: PoseProblem, start: np.ndarray) -> MotionPolynomial:
    """C(start + τ) as a polynomial in τ, for the conic C with [1] at ∞, [q1] at 0 and [q2] at 1.

    C = t(t − 1) + (1 − t) λ1 q1 + t λ2 q2 with the weights λ.
    """
    q1, q2 = (q * weight for q, weight in zip(problem.others, _weights(problem), strict=True))
    linear = q2 - q1 + (2 * start - 1)
    constant = q1 * (1 - start) + q2 * start
    return MotionPolynomial.from_coefficients((linear * 0 + 1, linear, constant))


def _for_both(C: MotionPolynomial) -> MotionPolynomial:
    """The polynomial once for each dyad."""
    return MotionPolynomial.from_coefficients(c[..., None] for c in C.coefficients)


def _linear_factors(h1: DualQuaternion, h2: DualQuaternion, C: MotionPolynomial) -> Pair:
    """The k1, k2 about the axes of h1, h2 with C = (τ − k1)(τ − k2), for a monic conic in their 2R space.

    With k = x + y h for each axis the coefficients of C in the basis 1, h1, h2, h1h2 are those of
    τ² − (x1 + x2 + y1 h1 + y2 h2) τ + (x1 + y1 h1)(x2 + y2 h2).
    """
    linear, constant = (primal_coordinates(c[..., None], h1, h2) for c in C.coefficients[1:])
    y1, y2 = -linear[1], -linear[2]
    return h1 * y1 + divide(constant[2], y2), h2 * y2 + divide(constant[1], y1)


def _improved(problem: PoseProblem, C: MotionPolynomial, start, k1: DualQuaternion, k2: DualQuaternion) -> tuple:
    """The linear factors, or better ones where these miss a pose; and by how much they still miss one, shape (...)."""
    best, missed = [_on_axis(k1), _on_axis(k2)], np.asarray(_missed(problem.others, start, k1, k2))
    poor = ~(missed <= GOOD)
    if not poor.any():
        return *best, missed
    others, begin, C = [q[poor] for q in problem.others], start[poor], _rows(C, poor)
    kept, off = [k[poor] for k in best], missed[poor]
    for factors in (kept, _factored(C)):
        candidate = [_on_axis(k) for k in polished(_for_both(C), factors)]
        candidate_off = np.where(_coincide(candidate[0]), np.inf, _missed(others, begin, *candidate))
        gain = ~(candidate_off >= off)
        kept = [chosen(gain, new, old) for new, old in zip(candidate, kept, strict=True)]
        off = np.where(gain, candidate_off, off)
    missed = missed.copy()
    missed[poor] = off
    return *(_with_rows(k, poor, new) for k, new in zip(best, kept, strict=True)), missed


def _rows(C: MotionPolynomial, rows: np.ndarray) -> MotionPolynomial:
    return MotionPolynomial.from_coefficients(c[rows] for c in C.coefficients)


def _with_rows(q: DualQuaternion, rows: np.ndarray, new: DualQuaternion) -> DualQuaternion:
    """The same dual quaternions but for some rows."""
    components = q.components.copy()
    components[:, rows] = new.components
    return wrap(components)


def _on_axis(k: DualQuaternion) -> DualQuaternion:
    """The factor x + y h with the axis that k nearly has: what rounding has added to a line is taken away."""
    v = _vector_part(k)
    return v - eps_times(v) * (study_form(v, v) / (2 * null_form(v, v))) + k.scalar_part


def _half_turn(k: DualQuaternion) -> DualQuaternion:
    """The half-turn h with k = x + y h and y > 0; NaN where there is none."""
    return _normalised(_vector_part(k))


def _vector_part(k: DualQuaternion) -> DualQuaternion:
    components = k.components.copy()
    components[[0, 4]] = 0
    return wrap(components)


def _factored(C: MotionPolynomial) -> Pair:
    """The linear factors from the roots of the norm polynomial of the conic, in both orders."""
    upper = _upper_roots(C)
    quadratics = np.stack([np.ones(upper.shape), -2 * upper.real, np.abs(upper) ** 2], axis=-1)
    return tuple(factor_in_orders(C, quadratics, BOTH_ORDERS))


def _upper_roots(C: MotionPolynomial) -> np.ndarray:
    """The roots of the norm polynomial of a monic conic with the larger imaginary parts, shape (..., 2)."""
    quartic = C.norm_polynomial()
    companion = np.zeros((*quartic.shape[:-1], 4, 4)) + np.eye(4, k=-1)
    companion[..., 0, :] = np.nan_to_num(-quartic[..., 1:], posinf=0, neginf=0)
    roots = np.linalg.eigvals(companion)
    return np.take_along_axis(roots, np.argsort(-roots.imag, axis=-1)[..., :2], -1)


def _missed(others, start, k1: DualQuaternion, k2: DualQuaternion) -> np.ndarray:
    """How far both chains together are from the poses at t = 0 and t = 1, and from each other on the way."""
    f1, f2 = k1 + start[..., None], k2 + start[..., None]
    off = gap(f1 * f2, others[0][..., None]), gap((1 - f1) * (1 - f2), others[1][..., None])
    return np.maximum(np.maximum(*off).max(axis=-1), _open(f1, f2))


def _open(f1: DualQuaternion, f2: DualQuaternion) -> np.ndarray:
    """How far the loop of both chains is open where it is most so: where one joint turns fastest, at t = Re f."""
    t = np.stack([f[..., 0].scalar_part for f in (f1, f2)], axis=-1)
    first, second = ((t - f1[..., n, None]) * (t - f2[..., n, None]) for n in range(2))
    return opening(first, second).max(axis=-1)


def _missed_by(problem: PoseProblem, h1: DualQuaternion, h2: DualQuaternion) -> np.ndarray:
    """How far both dyads together are from the poses, whatever their parameters there."""
    seen = [q[..., None] for q in problem.others]
    turns = [homogeneous_parameters(q, h1, h2) for q in seen]
    off = [gap(reached(h1, h2, turn), q) for turn, q in zip(turns, seen, strict=True)]
    return np.maximum(*off).max(axis=-1)


def _coincide(k: DualQuaternion) -> np.ndarray:
    """Whether what should be the factors of two dyads is the same twice."""
    return gap(k[..., 0], k[..., 1]) <= MET


def _same_quadratics(k1: DualQuaternion, k2: DualQuaternion) -> np.ndarray:
    """Whether the two quadratics of the conic agree more or less, so that double roots are believed."""
    (x1, y1), (x2, y2) = (_about(k[..., 0], _half_turn(k[..., 0])) for k in (k1, k2))
    return np.maximum(np.abs(x1 - x2), np.abs(y1 - y2)) <= 1e-3 * (y1 + y2)


def _comes_later(k1: DualQuaternion) -> np.ndarray:
    """Whether the base joint of the first dyad has the later quadratic: the larger real part of the root, or both
    real parts the same and the larger imaginary part."""
    x, y = _about(k1, _half_turn(k1))
    tied = np.abs(x[..., 0] - x[..., 1]) <= TIE * y.sum(axis=-1)
    return np.where(tied, y[..., 0] > y[..., 1], x[..., 0] > x[..., 1])


TIE = 1e-9
"""How near two real parts may be, relative to the imaginary parts, before the imaginary parts decide the order."""


def _exchanged(q: DualQuaternion, rows: np.ndarray) -> DualQuaternion:
    """The two dyads in the other order in some rows."""
    return wrap(np.where(rows[..., None], q.components[..., ::-1], q.components))


# ---- the routes: half-turns of both dyads, from the poses and the diagonal form of their plane ---------


class _Spectrum(NamedTuple):
    """The plane of three poses: a basis orthonormal for the null form and diagonal for the Study form."""

    basis: tuple[DualQuaternion, DualQuaternion, DualQuaternion]
    normal: DualQuaternion  # the primal quaternion orthonormal to the plane
    values: np.ndarray  # (..., 3), ascending


def _spectrum(q1: DualQuaternion, q2: DualQuaternion) -> _Spectrum:
    e1 = _normalised(q1 - q1.scalar_part)
    rest = _normalised(q2 - q2.scalar_part)
    e2 = _normalised(rest - e1 * null_form(e1, rest))
    e2 = _normalised(e2 - e1 * null_form(e1, e2))
    plane = DualQuaternion.stack([one, e1, e2], axis=-1).coeffs
    mixed = plane[..., :4] @ np.swapaxes(plane[..., 4:], -1, -2)
    gram = mixed + np.swapaxes(mixed, -1, -2)
    values, vectors = np.linalg.eigh(np.where(np.isfinite(gram), gram, 0))
    rows = DualQuaternion(np.swapaxes(vectors, -1, -2) @ plane)
    return _Spectrum(tuple(rows[..., n] for n in range(3)), (e1 * e2).primal, values)


def _normalised(x: DualQuaternion) -> DualQuaternion:
    """A point scaled to null form 1; NaN where it is 0."""
    return x / np.sqrt(null_form(x, x))


def _has_double_roots(problem: PoseProblem, plane: _Spectrum) -> np.ndarray:
    """Whether two eigenvalues agree as nearly as they can be told."""
    mu1, mu2, mu3 = np.moveaxis(plane.values, -1, 0)
    noise = (1e-14 + 4 * problem.noise) / _apart(*problem.others)
    return np.minimum(mu3 - mu2, mu2 - mu1) <= 1e-13 * (mu3 - mu1) + noise


def _rounded(plane: _Spectrum) -> _Spectrum:
    """The plane with its middle eigenvalue moved to the nearer of the others."""
    mu1, mu2, mu3 = plane.values
    return plane._replace(values=np.array([mu1, mu1 if mu2 - mu1 < mu3 - mu2 else mu3, mu3]))


def _by_eigenvalues(problem: PoseProblem, plane: _Spectrum) -> Pair:
    """Both spaces from the bordered eigenvalue problem of the plane.

    A 2R space has two double eigenvalues; by interlacing they are μ1 and μ3.  In the basis f1, f2, f3 of the
    plane, completed by a point x, the Study form must then have the entries b(f1, x) = b(f3, x) = 0,
    b(f2, x)² = (μ3 − μ2)(μ2 − μ1) and b(x, x) = μ1 + μ3 − μ2.  The eigenvectors are f1, f3 and two combinations
    of f2 and x.  The sign of b(f2, x) tells the two dyads apart.
    """
    mu1, mu2, mu3 = (plane.values[..., n, None] for n in range(3))
    low, high, sign = np.maximum(mu2 - mu1, 0), np.maximum(mu3 - mu2, 0), np.array([1, -1])
    sine, cosine = sign * np.sqrt(low / (mu3 - mu1)), np.sqrt(high / (mu3 - mu1))
    f1, f2, f3 = (f[..., None] for f in plane.basis)
    x = _fourth_point(plane.normal[..., None], (f1, f2, f3), sign * np.sqrt(low * high), mu1 + mu3 - mu2)
    return _axes((f1, f2 * cosine - x * sine), (f3, f2 * sine + x * cosine))


def _fourth_point(normal: DualQuaternion, basis, entry, last) -> DualQuaternion:
    """The point x orthonormal to the plane with b(x, f1) = b(x, f3) = 0, b(x, f2) = entry, b(x, x) = last."""
    dual = normal * (last / 2)
    for f, value in zip(basis, (0, entry, 0), strict=True):
        dual = dual + f * (value - study_form(normal, f))
    return normal + eps_times(dual)


def _axes(minus: Pair, plus: Pair) -> Pair:
    """The half-turns of a 2R space from orthonormal bases of its two eigenspaces.

    With the sign of h2 chosen so that b(h1, h2) > 0 the eigenspaces are spanned by h1 − h2 and 1 + h1h2, and by
    h1 + h2 and 1 − h1h2.  In each, the vector orthogonal to the projection of 1 and of its length is half the
    difference, and half the sum.
    """
    difference, _ = _turned(*minus)
    total, projection = _turned(*plus)
    h1, h2 = total + difference, total - difference
    product = 1 - 2 * projection
    swap = np.where(null_form(h1 * h2, product - product.scalar_part) < 0, -1, 1)
    return tuple(_half_turn(_on_axis(h)) for h in (total + difference * swap, total - difference * swap))


def _turned(x: DualQuaternion, y: DualQuaternion) -> Pair:
    """In the plane of orthonormal x, y: the projection of 1 turned by a right angle, and itself."""
    a, b = x.scalar_part, y.scalar_part
    return y * a - x * b, x * a + y * b


def _by_factorization(problem: PoseProblem, plane: _Spectrum) -> Pair:
    k1, k2 = _factored(_conic_from(problem, _start(problem)))
    return _half_turn(_on_axis(k1)), _half_turn(_on_axis(k2))


def _by_null_quadrilateral(problem: PoseProblem, plane: _Spectrum) -> Pair:
    """The construction in the proof of Theorem 2, in complex floats.

    The conic meets the null cone in m1, n1 and their conjugates m2, n2.  The primal part of u1 is null and
    orthogonal to those of m1 and n2, the other vertices follow by projection from n1, m2, and the dual parts
    solve a linear system (Lemma 5).
    """
    C = _conic_from(problem, _start(problem))
    m1, n1 = (C(_sharpened(C, root)).coeffs for root in np.moveaxis(_upper_roots(C), -1, 0))
    pairs = [_lifted(u, m1, n1) for u in _first_vertices(m1[..., :4], n1.conj()[..., :4])]
    return tuple(DualQuaternion.stack(both, axis=-1) for both in zip(*pairs, strict=True))


def _sharpened(C, t: np.ndarray) -> np.ndarray:
    """One Newton step towards ⟨C(t), C(t)⟩ = 0, which cancels less than the expanded quartic."""
    second, first, _ = C.coefficients
    pose = C(t)
    return t - null_form(pose, pose) / (2 * null_form(pose, second * (2 * t) + first))


def _first_vertices(m: np.ndarray, n: np.ndarray) -> list[np.ndarray]:
    """The two null vectors orthogonal to m and n: on the line f, g of vectors orthogonal to both."""
    f, g = np.moveaxis(np.linalg.svd(np.stack([m, n], axis=-2))[2][..., 2:, :].conj(), -2, 0)
    a, b, c = _inner(f, f), _inner(f, g), _inner(g, g)
    root = np.sqrt(b * b - a * c)
    larger = np.where(np.abs(root - b) > np.abs(root + b), root - b, -root - b)
    return [larger * f + a * g, c * f + larger * g]


def _inner(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return (x * y).sum(axis=-1, keepdims=True)


def _lifted(u1: np.ndarray, m1: np.ndarray, n1: np.ndarray) -> Pair:
    """From the primal part of u1 to the axes of the dyad."""
    primal, dual = [u1], [np.zeros_like(u1)]
    for centre, following in ((m1, n1), (n1, m1.conj()), (m1.conj(), n1.conj())):
        step = -_inner(primal[-1], following[..., :4]) / _inner(centre[..., :4], following[..., :4])
        primal.append(primal[-1] + step * centre[..., :4])
        dual.append(dual[-1] + step * centre[..., 4:])
    vertices, known = np.stack(primal, -2), np.stack(dual, -2)
    shift = solved(vertices, -_inner(vertices, known))[..., 0]
    u, v = (np.concatenate([vertices[..., n, :], known[..., n, :] + shift], axis=-1) for n in (0, 1))
    return _axes(*_eigenspaces(np.stack([u.real, u.imag, v.real, v.imag], axis=-2)))


def _eigenspaces(basis: np.ndarray) -> tuple[Pair, Pair]:
    """Orthonormal bases of the two eigenspaces of a 2R space, given by a basis, shape (..., 4, 8).

    A 3-space that misses E is the graph of a linear map from primal to dual parts: in the basis with the units
    as primal parts the Study form is that map plus its transpose.
    """
    graph = solved(basis[..., :4], basis)
    study = graph[..., 4:] + np.swapaxes(graph[..., 4:], -1, -2)
    _, vectors = np.linalg.eigh(np.nan_to_num(study))
    rows = DualQuaternion(np.swapaxes(vectors, -1, -2) @ graph)
    return (rows[..., 0], rows[..., 1]), (rows[..., 2], rows[..., 3])


ROUTES = {
    "eigenvalues": _by_eigenvalues,
    "factorization": _by_factorization,
    "null_quadrilateral": _by_null_quadrilateral,
}
