"""Theorem 2: the two 2R dyads through three poses, and the conic of their plane in linear factors about the axes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, eps, i, j, null_form, wrap
from kinlib.dyad import Dyad, homogeneous_parameters, reached
from kinlib.dyad_routes import (
    ROUTES,
    Pair,
    by_eigenvalues,
    conic_from,
    factored,
    half_turn_of,
    has_double_roots,
    in_both_orders,
    on_axis,
    rounded,
    size_of_turn,
    spectrum_of,
    start_of,
)
from kinlib.errors import report_faults
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import polished
from kinlib.pose_faults import PoseFault, faults_of_poses, nearest_fault, tangent_faults
from kinlib.poses import PoseProblem, as_pose, gap, opening, seen_together
from kinlib.quadratics import quadratic_factors
from kinlib.rows import BLOCK, broadcast, chosen, joined, masked, replaced
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
    return np.moveaxis(spectrum_of(problem.others).values * problem.length, 0, -1)


def _in_floats(pose: PoseLike) -> DualQuaternion:
    return DualQuaternion(as_float(as_pose(pose).coeffs))


Stop: TypeAlias = tuple[Scalars, Scalars]
"""The parameters of both joints of a dyad in a pose."""


class TwoDyads(NamedTuple):
    """Both dyads through three poses, and the conic in linear factors about their axes, in the problem's own frame.

    The first axis of each batch tells the dyads apart.  The factors are those of C(start + τ), a polynomial in τ: near
    t = start they keep digits that the factors of C(t) lose.  They are NaN where there is no conic.
    """

    h1: DualQuaternion
    h2: DualQuaternion
    k1: DualQuaternion
    k2: DualQuaternion
    start: np.ndarray

    def half_turns(self, n: int) -> Pair:
        """The half-turns about the axes of dyad n."""
        return self.h1[n], self.h2[n]

    def factors(self, n: int) -> Pair:
        """The k1, k2 about the axes of dyad n with C(t) = (t − k1)(t − k2)."""
        return self.k1[n] + self.start, self.k2[n] + self.start

    def stops(self, n: int) -> tuple[Stop, Stop]:
        """The (s1, s2) with which dyad n is in the second pose, and in the third, as (s1 − h1)(s2 − h2).

        From t − k = y ((t − x)/y − h) for k = x + y h.
        """
        x1, y1 = _about(self.k1[n], self.h1[n])
        x2, y2 = _about(self.k2[n], self.h2[n])
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
    only_conics = not tangent or method != "eigenvalues"
    if not problem.is_exact:
        return _checked(problem, _float_dyads(problem, method, only_conics, tangent), degenerate)
    report_faults(_faults(problem, only_conics), PoseFault, degenerate)
    return _exact_dyads(problem)


def _faults(problem: PoseProblem, only_conics: bool) -> np.ndarray:
    """What is wrong with the poses themselves."""
    faults = faults_of_poses(problem)
    return np.where(faults, faults, tangent_faults(problem)) if only_conics else faults


def _exact_dyads(problem: PoseProblem) -> TwoDyads:
    """From the two factorizations of the conic; the only irrational step is to split its quartic."""
    C = conic_from(problem, np.array(0))
    quadratics = quadratic_factors(C.norm_polynomial())
    k1, k2 = in_both_orders(C, quadratics)
    both = TwoDyads(axis_of(k1), axis_of(k2), k1, k2, np.array(0))
    _report_missed(problem, _missed(problem.others, both.start, k1, k2) > 0, "raise")
    double = np.asarray((quadratics[..., 0, :] == quadratics[..., 1, :]).all(axis=-1))
    dyad = Dyad(*both.half_turns(0), problem.home) if double.ndim == 0 and double else None
    report_faults(double * PoseFault.DOUBLE, PoseFault, "raise", dyad=dyad)
    return both


class Found(NamedTuple):
    """Both dyads in floats, what is wrong with the poses, how far the dyads are from them; rows on the last axis."""

    h1: DualQuaternion
    h2: DualQuaternion
    k1: DualQuaternion
    k2: DualQuaternion
    start: np.ndarray
    faults: np.ndarray
    close: np.ndarray  # whether two eigenvalues of the plane agree as nearly as they can be told
    missed: np.ndarray

    @property
    def no_conic(self) -> np.ndarray:
        """Where the factors are those of no conic through the poses."""
        return ~(self.missed <= MET)

    def in_order(self) -> Found:
        """The half-turns of the factors, and first the dyad that is to come first."""
        no_conic = self.no_conic
        h1, h2 = (chosen(no_conic, h, half_turn_of(k)) for h, k in ((self.h1, self.k1), (self.h2, self.k2)))
        later = ~no_conic & _comes_later(self.k1)
        h1, h2, k1, k2 = (_exchanged(q, later) for q in (h1, h2, self.k1, self.k2))
        return self._replace(h1=h1, h2=h2, k1=k1, k2=k2)


def _float_dyads(problem: PoseProblem, method: str, only_conics: bool, tangent: bool) -> Found:
    """By one of the routes, and by all that repairs what rounding does to it."""
    with np.errstate(all="ignore"):
        found = in_blocks(problem, lambda part: _by_one_route(part, method, only_conics))
        poor = ~(found.missed <= GOOD) & (found.faults == 0)
        if poor.any():
            found = _with(found, poor, _improved(problem.some(poor), _of_rows(found, poor)))
        double = found.close & (found.faults == 0)
        if double.any():
            double &= found.no_conic | _same_quadratics(found.k1, found.k2)
            found = found._replace(faults=np.where(double, PoseFault.DOUBLE, found.faults))
        return _without_conic(problem, found) if tangent and found.no_conic.any() else found


def _without_conic(problem: PoseProblem, found: Found) -> Found:
    """Dyads are judged by themselves where there is no conic."""
    k1, k2 = (masked(k, found.no_conic) for k in (found.k1, found.k2))
    missed = np.where(found.no_conic, _missed_by(problem, found.h1, found.h2), found.missed)
    return found._replace(k1=k1, k2=k2, missed=missed)


def _by_one_route(problem: PoseProblem, method: str, only_conics: bool) -> Found:
    """What one of the routes finds; faulty rows hold a regular problem."""
    faults = _faults(problem, only_conics)
    problem = _replaced(problem, faults > 0)
    plane, start = spectrum_of(problem.others), start_of(problem)
    h1, h2 = ROUTES[method](problem, plane)
    k1, k2 = (on_axis(k) for k in _linear_factors(h1, h2, conic_from(problem, start)))
    missed, close = _missed(problem.others, start, k1, k2), has_double_roots(problem, plane)
    return Found(h1, h2, k1, k2, start, faults, np.asarray(close), np.asarray(missed)).in_order()


def _improved(problem: PoseProblem, found: Found) -> Found:
    """Better linear factors where they miss a pose, from those that there are or from the conic itself."""
    C = conic_from(problem, found.start)
    kept, off = [found.k1, found.k2], found.missed
    for factors in (kept, factored(C)):
        candidate = [on_axis(k) for k in polished(C, factors)]
        candidate_off = _missed(problem.others, found.start, *candidate)
        candidate_off = np.where(_coincide(candidate[0]), np.inf, candidate_off)
        gain = ~(candidate_off >= off)
        kept = [chosen(gain, new, old) for new, old in zip(candidate, kept, strict=True)]
        off = np.where(gain, candidate_off, off)
    return found._replace(k1=kept[0], k2=kept[1], missed=off).in_order()


def _of_rows(found: Found, rows: np.ndarray) -> Found:
    """Some of the rows."""
    h1, h2, k1, k2 = (q[:, rows] for q in (found.h1, found.h2, found.k1, found.k2))
    return Found(h1, h2, k1, k2, found.start[rows], found.faults[rows], found.close[rows], found.missed[rows])


def _with(found: Found, rows: np.ndarray, new: Found) -> Found:
    """The same with other factors in some rows."""
    turns = zip((found.h1, found.h2, found.k1, found.k2), (new.h1, new.h2, new.k1, new.k2), strict=True)
    h1, h2, k1, k2 = (replaced(old, (slice(None), rows), better) for old, better in turns)
    missed = found.missed.copy()
    missed[rows] = new.missed
    return found._replace(h1=h1, h2=h2, k1=k1, k2=k2, missed=missed)


def in_blocks(problem: PoseProblem, solve: Callable[[PoseProblem], Found]) -> Found:
    """What is found for a problem, a block of its rows at a time."""
    shape, rows = problem.home.shape, math.prod(problem.home.shape)
    if rows <= BLOCK:
        return solve(problem)
    problem = problem.flat()
    parts = zip(*(solve(problem.some(slice(n, n + BLOCK))) for n in range(0, rows, BLOCK)), strict=True)
    return Found(*(joined(part, shape) for part in parts))


def _checked(problem: PoseProblem, found: Found, degenerate: Degenerate) -> TwoDyads:
    """What was found, where it meets the poses."""
    only = degenerate == "raise" and found.faults.ndim == 0 and found.faults == PoseFault.DOUBLE
    bad = report_faults(found.faults, PoseFault, degenerate, dyad=_only_dyad(problem) if only else None)
    lost = ~bad & ~(found.missed <= MET)
    _report_missed(problem, lost, degenerate)
    h1, h2, k1, k2 = (masked(q, bad | lost) for q in (found.h1, found.h2, found.k1, found.k2))
    return TwoDyads(h1, h2, k1, k2, found.start)


def _report_missed(problem: PoseProblem, lost: np.ndarray, degenerate: Degenerate) -> None:
    """Say what the rows are near to in which nothing was found that meets the poses."""
    if np.any(lost):
        nearest, how_near = nearest_fault(problem)
        report_faults(lost * nearest, PoseFault, degenerate, place=ALMOST, how_near=how_near)


def _only_dyad(problem: PoseProblem) -> Dyad:
    """The dyad of a single problem with double roots."""
    h1, h2 = by_eigenvalues(problem, rounded(spectrum_of(problem.others)))
    return _dyad_of(problem, (h1[0], h2[0]))


STAND_INS = unit(DualQuaternion.stack([i * (j - eps * i), (1 - i) * (2 - j + eps * i)]).astype(float))
"""The second and the third pose of a regular problem, in place of faulty rows."""


def _replaced(problem: PoseProblem, rows: np.ndarray) -> PoseProblem:
    """The same problem with a regular one in place of the given rows."""
    if not rows.any():
        return problem
    stand_ins = STAND_INS.components.reshape(8, 2, *(1,) * rows.ndim)
    return replace(problem, others=wrap(np.where(rows, stand_ins, problem.others.components)))


def _linear_factors(h1: DualQuaternion, h2: DualQuaternion, C: MotionPolynomial) -> Pair:
    """The k1, k2 about the axes of h1, h2 of length 1 with C = (τ − k1)(τ − k2), for a monic conic in their 2R space.

    With k = x + y h for each axis the coefficients of C in the basis 1, h1, h2, h1h2 are those of
    τ² − (x1 + x2 + y1 h1 + y2 h2) τ + (x1 + y1 h1)(x2 + y2 h2); those with h1 and h2 follow from the inner products
    with these.
    """
    cosine = null_form(h1, h2)
    area = 1 - cosine * cosine
    linear, constant = ((null_form(c, h1) / area, null_form(c, h2) / area) for c in C.coefficients[1:])
    y1, y2 = cosine * linear[1] - linear[0], cosine * linear[0] - linear[1]
    first, second = constant[0] - cosine * constant[1], constant[1] - cosine * constant[0]
    return h1 * y1 + second / y2, h2 * y2 + first / y1


def _missed(others: DualQuaternion, start: Array, k1: DualQuaternion, k2: DualQuaternion) -> np.ndarray:
    """How far both chains together are from the poses at t = 0 and t = 1, and from each other on the way.

    The loop of both chains is most open where one joint turns fastest, at t = Re f.
    """
    f1, f2 = k1 + start, k2 + start
    x1, x2 = (f.scalar_part[0] for f in (f1, f2))
    t = np.stack(np.broadcast_arrays(0 * x1, 0 * x1 + 1, x1, x2))[:, None]
    reached = (t - f1) * (t - f2)
    off = gap(reached[:2], wrap(others.components[:, :, None]))
    apart = opening(reached[2:, 0], reached[2:, 1])
    return np.maximum(off.max(axis=(0, 1)), apart.max(axis=0))


def _missed_by(problem: PoseProblem, h1: DualQuaternion, h2: DualQuaternion) -> np.ndarray:
    """How far both dyads together are from the poses, whatever their parameters there."""
    seen = [broadcast(q, h1.shape) for q in problem.others]
    off = [gap(reached(h1, h2, homogeneous_parameters(q, h1, h2)), q) for q in seen]
    return np.maximum(*off).max(axis=0)


def _coincide(k: DualQuaternion) -> np.ndarray:
    """Whether what should be the factors of two dyads is the same twice."""
    return gap(k[0], k[1]) <= MET


def _same_quadratics(k1: DualQuaternion, k2: DualQuaternion) -> np.ndarray:
    """Whether the two quadratics of the conic agree more or less, so that double roots are believed."""
    y1, y2 = (size_of_turn(k[0]) for k in (k1, k2))
    x1, x2 = (k.scalar_part[0] for k in (k1, k2))
    return np.maximum(np.abs(x1 - x2), np.abs(y1 - y2)) <= 1e-3 * (y1 + y2)


def _comes_later(k1: DualQuaternion) -> np.ndarray:
    """Whether the base joint of the first dyad has the later quadratic: the larger real part of the root, or both
    real parts the same and the larger imaginary part."""
    x, y = k1.scalar_part, size_of_turn(k1)
    tied = np.abs(x[0] - x[1]) <= TIE * (y[0] + y[1])
    return np.where(tied, y[0] > y[1], x[0] > x[1])


def _exchanged(q: DualQuaternion, rows: np.ndarray) -> DualQuaternion:
    """The two dyads in the other order in some rows."""
    return wrap(np.where(rows, q.components[:, ::-1], q.components)) if rows.any() else q
