"""Theorem 2: the two 2R dyads through three poses, and the conic of their plane in linear factors about the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, eps, i, j, null_form, wrap
from kinlib.dyad import Dyad, homogeneous_parameters, primal_coordinates, reached
from kinlib.dyad_routes import (
    BOTH_ORDERS,
    ROUTES,
    Pair,
    Spectrum,
    by_eigenvalues,
    conic_from,
    factored,
    half_turn_of,
    has_double_roots,
    on_axis,
    rounded,
    spectrum_of,
    start_of,
)
from kinlib.errors import report_faults
from kinlib.factorization import factor_in_orders
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import polished
from kinlib.pose_faults import PoseFault, faults_of_poses, nearest_fault, tangent_faults
from kinlib.poses import PoseProblem, as_pose, gap, opening, seen_together
from kinlib.quadratics import quadratic_factors
from kinlib.rows import chosen, masked, replaced
from kinlib.scalar import as_float, divide
from kinlib.typing import Array, Degenerate, PoseLike, Scalars

__all__ = ["dyads_through_poses", "study_eigenvalues"]

MET = 1e-10
"""How far a pose may be missed, in half-angles and in the unit of the problem; more is refused."""

GOOD = 1e-12
"""How far a pose may be missed before the answer is improved."""

TIE = 1e-9
"""How near two real parts may be, relative to the imaginary parts, before the imaginary parts decide the order."""

ALMOST = "the answer would miss the poses; they are near a place where there is none: "


def dyads_through_poses(
    p0: PoseLike, p1: PoseLike, p2: PoseLike, *, method: str | None = None, degenerate: Degenerate = "raise"
) -> tuple[Dyad, Dyad]:
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
    return _dyad_of(problem, both.half_turns(0)), _dyad_of(problem, both.half_turns(1))


def _dyad_of(problem: PoseProblem, half_turns: Pair) -> Dyad:
    """The dyad with half-turns that were found in the problem's own frame."""
    h1, h2 = map(problem.outward, half_turns)
    return Dyad(h1, h2, problem.home)


def study_eigenvalues(p0: PoseLike, p1: PoseLike, p2: PoseLike) -> np.ndarray:
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
    return spectrum_of(*problem.others).values * problem.length[..., None]


def _in_floats(pose: PoseLike) -> DualQuaternion:
    return DualQuaternion(as_float(as_pose(pose).coeffs))


Stop: TypeAlias = tuple[Scalars, Scalars]
"""The parameters of both joints of a dyad in a pose."""


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

    def stops(self, n: int) -> tuple[Stop, Stop]:
        """The (s1, s2) with which dyad n is in the second pose, and in the third, as (s1 − h1)(s2 − h2).

        From t − k = y ((t − x)/y − h) for k = x + y h.
        """
        x1, y1 = _about(self.k1[..., n], self.h1[..., n])
        x2, y2 = _about(self.k2[..., n], self.h2[..., n])
        second, third = ((divide(t - x1, y1), divide(t - x2, y2)) for t in (0 - self.start, 1 - self.start))
        return second, third


def _about(k: DualQuaternion, h: DualQuaternion) -> tuple[Scalars, Scalars]:
    """The x, y of k = x + y h."""
    return k.scalar_part, divide(null_form(k, h), null_form(h, h))


def two_dyads(
    problem: PoseProblem, degenerate: Degenerate, method: str | None = None, *, tangent: bool = False
) -> TwoDyads:
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
    C = conic_from(problem, np.array(0))
    quadratics = quadratic_factors(C.norm_polynomial())
    k1, k2 = factor_in_orders(C, quadratics, BOTH_ORDERS)
    both = TwoDyads(axis_of(k1), axis_of(k2), k1, k2, np.array(0))
    _report_missed(problem, _missed(problem.others, both.start, k1, k2) > 0, "raise")
    double = np.asarray((quadratics[..., 0, :] == quadratics[..., 1, :]).all(axis=-1))
    dyad = Dyad(*both.half_turns(0), problem.home) if double.ndim == 0 and double else None
    report_faults(double * PoseFault.DOUBLE, PoseFault, "raise", dyad=dyad)
    return both


def _float_dyads(problem: PoseProblem, faults: Array, method: str, degenerate: Degenerate, tangent: bool) -> TwoDyads:
    """By one of the routes, and by all that repairs what rounding does to it; faulty rows hold a regular problem."""
    with np.errstate(all="ignore"):
        plane = spectrum_of(*problem.others)
        start = start_of(problem)
        C = conic_from(problem, start)
        h1, h2 = ROUTES[method](problem, plane)
        k1, k2, missed = _improved(problem, C, start, *_linear_factors(h1, h2, C))
        no_conic = ~(missed <= MET)
        h1, h2 = (chosen(no_conic, h, half_turn_of(k)) for h, k in ((h1, k1), (h2, k2)))
        double = has_double_roots(problem, plane) & (no_conic | _same_quadratics(k1, k2))
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
    k1, k2 = (masked(k, bad | no_conic[..., None]) for k in (k1, k2))
    return TwoDyads(masked(h1, bad), masked(h2, bad), k1, k2, start)


def _report_missed(problem: PoseProblem, lost: np.ndarray, degenerate: Degenerate) -> None:
    """Say what the rows are near to in which nothing was found that meets the poses."""
    if np.any(lost):
        nearest, how_near = nearest_fault(problem)
        report_faults(lost * nearest, PoseFault, degenerate, place=ALMOST, how_near=how_near)


def _only_dyad(problem: PoseProblem, plane: Spectrum) -> Dyad:
    """The dyad of a single problem with double roots."""
    h1, h2 = by_eigenvalues(problem, rounded(plane))
    return _dyad_of(problem, (h1[0], h2[0]))


STAND_INS = tuple(unit(q.astype(float)) for q in (i * (j - eps * i), (1 - i) * (2 - j + eps * i)))
"""The second and the third pose of a regular problem, in place of faulty rows."""


def _replaced(problem: PoseProblem, rows: np.ndarray) -> PoseProblem:
    """The same problem with a regular one in place of the given rows."""
    if not rows.any():
        return problem
    others = tuple(chosen(rows, stand_in, q) for q, stand_in in zip(problem.others, STAND_INS, strict=True))
    return replace(problem, others=others)


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


def _improved(
    problem: PoseProblem, C: MotionPolynomial, start: Array, k1: DualQuaternion, k2: DualQuaternion
) -> tuple[DualQuaternion, DualQuaternion, Array]:
    """The linear factors, or better ones where these miss a pose; and by how much they still miss one, shape (...)."""
    best, missed = (on_axis(k1), on_axis(k2)), np.asarray(_missed(problem.others, start, k1, k2))
    poor = ~(missed <= GOOD)
    if not poor.any():
        return *best, missed
    others, begin, C = [q[poor] for q in problem.others], start[poor], _rows(C, poor)
    kept, off = [k[poor] for k in best], missed[poor]
    for factors in (kept, factored(C)):
        candidate = [on_axis(k) for k in polished(_for_both(C), factors)]
        candidate_off = np.where(_coincide(candidate[0]), np.inf, _missed(others, begin, *candidate))
        gain = ~(candidate_off >= off)
        kept = [chosen(gain, new, old) for new, old in zip(candidate, kept, strict=True)]
        off = np.where(gain, candidate_off, off)
    missed = missed.copy()
    missed[poor] = off
    better1, better2 = (replaced(k, poor, new) for k, new in zip(best, kept, strict=True))
    return better1, better2, missed


def _rows(C: MotionPolynomial, rows: np.ndarray) -> MotionPolynomial:
    return MotionPolynomial.from_coefficients(c[rows] for c in C.coefficients)


def _missed(others: Sequence[DualQuaternion], start: Array, k1: DualQuaternion, k2: DualQuaternion) -> np.ndarray:
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
    (x1, y1), (x2, y2) = (_about(k[..., 0], half_turn_of(k[..., 0])) for k in (k1, k2))
    return np.maximum(np.abs(x1 - x2), np.abs(y1 - y2)) <= 1e-3 * (y1 + y2)


def _comes_later(k1: DualQuaternion) -> np.ndarray:
    """Whether the base joint of the first dyad has the later quadratic: the larger real part of the root, or both
    real parts the same and the larger imaginary part."""
    x, y = _about(k1, half_turn_of(k1))
    tied = np.abs(x[..., 0] - x[..., 1]) <= TIE * y.sum(axis=-1)
    return np.where(tied, y[..., 0] > y[..., 1], x[..., 0] > x[..., 1])


def _exchanged(q: DualQuaternion, rows: np.ndarray) -> DualQuaternion:
    """The two dyads in the other order in some rows."""
    return wrap(np.where(rows[..., None], q.components[..., ::-1], q.components))
