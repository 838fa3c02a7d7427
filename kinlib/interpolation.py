"""Rational motions through given poses: conics through three, twisted cubics through four."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from itertools import combinations
from typing import Any, Self, TypeVar

import numpy as np

from kinlib.cubics import (
    CubicFamilies,
    CubicFault,
    Parameters,
    families_of,
    no_displacement,
    rounding,
    rounding_of_form,
)
from kinlib.dual_quaternion import DualQuaternion, one, primal_size, study_form
from kinlib.errors import Fault, first_fault, report_faults
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.poses import PoseProblem, as_poses, gap, seen_together
from kinlib.rows import masked
from kinlib.scalar import divide, is_exact, is_zero
from kinlib.typing import Array, ArrayLike, Degenerate, PoseLike, ScalarLike, Scalars

__all__ = ["Families", "conic_through", "cubics_through", "fourth_parameters"]


POWERS_MET = 2e-10
"""How near a polynomial must pass the poses, in half-angles and in the unit of length of the problem."""


class ConicFault(Fault):
    """Why no conic passes through three poses."""

    EQUAL = 1, "two of the three poses are equal: three different poses are needed"
    TANGENT = (
        2,
        "two of the three poses differ by a rotation or a translation: their plane is tangent to the Study quadric, "
        "no conic passes through the poses",
    )
    LOST = (
        3,
        "powers of t lose a pose in floats, since two of the poses nearly differ by a rotation or a translation, or "
        "the poses are far from the origin; bennett_linkage keeps it in linear factors",
    )


def conic_through(p0: PoseLike, p1: PoseLike, p2: PoseLike, *, degenerate: Degenerate = "raise") -> MotionPolynomial:
    """The quadratic motion with pose p0 at t = ∞, p1 at t = 0 and p2 at t = 1.

    With b_jk = b(p_j, p_k) it is C = p0 t(t − 1) − (b_02/b_12)(t − 1) p1 + (b_01/b_12) t p2.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion, 4×4 matrix or RigidTransform
        Poses; batches broadcast.
    degenerate : {"raise", "nan"}
        What becomes of rows of a batch that have no conic: an error that names them, or NaN.

    Raises
    ------
    DegenerateError
        If a b_jk vanishes: the plane of the three poses is tangent to the Study quadric.

    Examples
    --------
    >>> C = conic_through(one, i * (j - eps * i), (1 - i) * (1 - j + eps * i))
    >>> C.degree, bool(C.is_motion())
    (2, True)
    """
    poses = as_poses(p0, p1, p2, degenerate=degenerate)
    if all(is_exact(p.components) for p in poses):
        steps = [q * p.conjugate() for p, q in combinations(poses, 2)]
        report_faults(_conic_faults(steps, [0, 0, 0], 0), ConicFault, "raise")
        return conic(*poses)
    problem = seen_together(*poses, degenerate=degenerate)
    with np.errstate(all="ignore"):
        C = _outward(problem, conic(one.astype(float), *problem.others))
        missed = _missed(problem, C, (0.0, 1.0))
        steps = list(problem.steps)
        limits = [rounding_of_form(step, problem.noise) for step in steps]
        faults = _conic_faults(steps, limits, rounding(problem))
    faults = np.where((faults == 0) & ~(missed <= POWERS_MET), ConicFault.LOST, faults)
    return _without(C, report_faults(faults, ConicFault, degenerate, how_near=missed))


def _missed(problem: PoseProblem, C: MotionPolynomial, parameters: Sequence[Scalars]) -> Array:
    """How far C may be from the second, third, … pose of a problem, beyond what rounding has made of those.

    What is seen at t is not all: rounding changes the sum of the c_k t^k as it has changed the c_k.
    """
    off = []
    for t, wanted in zip(parameters, problem.others, strict=True):
        reached = C(t)
        terms = sum(primal_size(c) * np.abs(t) ** (C.degree - k) for k, c in enumerate(C.coefficients))
        seen = gap(problem.inward(reached * problem.home.conjugate()), wanted)
        off.append(seen + np.finfo(float).eps * terms / primal_size(reached))
    return reduce(np.maximum, off) - 24 * problem.noise


def _conic_faults(steps: Sequence[DualQuaternion], limits: Sequence[Array | float], tolerance: Any) -> np.ndarray:
    """What is wrong with three poses, given the displacements between them; 0 if nothing."""
    zero = [np.asarray(is_zero(step.components[4], limit, 1.0)) for step, limit in zip(steps, limits, strict=True)]
    equal = [z & no_displacement(step, tolerance) if z.any() else z for z, step in zip(zero, steps, strict=True)]
    return first_fault((np.any(equal, axis=0), ConicFault.EQUAL), (np.any(zero, axis=0), ConicFault.TANGENT))


def _outward(problem: PoseProblem, C: MotionPolynomial) -> MotionPolynomial:
    """A motion that was found about the middle, in the frame and unit of the poses."""
    return MotionPolynomial.from_coefficients(problem.outward(c) * problem.home for c in C.coefficients)


def _without(C: MotionPolynomial, bad: Array) -> MotionPolynomial:
    """The motion with NaN in the bad rows."""
    return MotionPolynomial.from_coefficients(masked(c, bad) for c in C.coefficients)


def conic(p0: DualQuaternion, p1: DualQuaternion, p2: DualQuaternion) -> MotionPolynomial:
    """The conic through three poses, unchecked."""
    b01, b02, b12 = study_form(p0, p1), study_form(p0, p2), study_form(p1, p2)
    q1, q2 = p1 * divide(b02, b12), p2 * divide(b01, b12)
    return MotionPolynomial.from_coefficients((p0, q2 - q1 - p0, q1))


Member = TypeVar("Member")


class Families(tuple[Member, ...]):
    """What was found in the families of cubics through four poses: a tuple that says what is missing.

    Attributes
    ----------
    parameters : tuple
        For each family that is there the parameter values of the four poses, (∞, 0, 1, t3).
    missing : tuple of str
        What is wrong with a family that is not there (or, in a batch, not in all rows); empty if nothing is missing.

    Examples
    --------
    >>> from kinlib.gallery import FOUR_POSES
    >>> cubics = cubics_through(*FOUR_POSES, -1)
    >>> len(cubics), [str(t3) for *_, t3 in cubics.parameters], cubics.missing
    (2, ['4/3', '-1'], ())
    """

    parameters: tuple[Parameters, ...]
    missing: tuple[str, ...]

    def __new__(
        cls, items: Iterable[Member] = (), parameters: tuple[Parameters, ...] = (), missing: tuple[str, ...] = ()
    ) -> Self:
        self = super().__new__(cls, items)
        self.parameters, self.missing = parameters, missing
        return self

    def __getnewargs__(self) -> tuple[tuple[Member, ...], tuple[Parameters, ...], tuple[str, ...]]:
        return tuple(self), self.parameters, self.missing

    def __repr__(self) -> str:
        return super().__repr__() + "".join(f"\nmissing: {text}" for text in self.missing)


def cubics_through(
    p0: PoseLike,
    p1: PoseLike,
    p2: PoseLike,
    p3: PoseLike,
    free: ScalarLike | ArrayLike = 0,
    *,
    degenerate: Degenerate = "raise",
) -> Families[MotionPolynomial]:
    """The cubic motions of both families through four poses, for one value of the free parameter.

    A cubic has p0 at t = ∞, p1 at 0, p2 at 1 and p3 at a value t_3; the Study condition asks
    z t_3² + (x − y − z) t_3 + y = 0 with x = b_01 b_23, y = b_02 b_13, z = b_03 b_12.  Its discriminant is the
    Gram determinant of the four poses, so both families are real or neither is.  The family with the larger |t_3|
    comes first.

    Parameters
    ----------
    p0, p1, p2, p3 : DualQuaternion, 4×4 matrix or RigidTransform
        Poses; batches broadcast.
    free : scalar or array_like
        The position in the family, without unit; broadcasts with the poses.  The cubic is
        C = p0 Π(t − t_j) + Σ λ_j p_j Π_{m≠j}(t − t_m) with λ = μ + (free + base) · r · κ, where κ spans the kernel of
        the Study condition, μ is the solution with the smallest Σ λ_j² p_j p̄_j, and r = b_0j / (b_jk b_jl) for the
        first pose j with which rκ is neither small nor large (less than 10⁻³, more than 10³ of C), else the number
        that makes it as large as C.  The base is 0, unless the cubic there all but misses a pose: then it is the
        first of 1, −1, 2, −2 where it does not.  So neither frames nor the unit of length nor the factors of the
        poses matter.
    degenerate : {"raise", "nan"}
        What becomes of rows of a batch without a cubic.  An error names them; with NaN both families are returned
        in any case, and NaN stands where there is none.

    Returns
    -------
    Families of MotionPolynomial
        One for each real family: two, or one in the limiting cases and where free is bad for the other; then
        ``.missing`` says why.  ``.parameters`` are the parameters of the poses.

    Raises
    ------
    DegenerateError
        If no family is real, the poses are not in general position, or the cubics miss a pose.
    """
    families = families_of(p0, p1, p2, p3, free, degenerate)
    coefficients = [families.outward(c) for c in families.rows.cubics().coefficients]
    if not families.problem.is_exact:
        with np.errstate(all="ignore"):
            missed = np.stack([_missed_by_family(families, coefficients, n) for n in (0, 1)], axis=-1)[families.chosen]
        families = families.less(np.where(missed <= POWERS_MET, 0, CubicFault.POWERS), missed)
    kept, missing = families.judged(degenerate)
    found = [_of_family(families, coefficients, n) for n in kept]
    return Families(found, tuple(families.parameters(n) for n in kept), missing)


def _of_family(families: CubicFamilies, coefficients: Sequence[DualQuaternion], n: int) -> MotionPolynomial:
    """The cubics of one family, of the shape of the batch; NaN where there is none."""
    home = families.problem.home
    return MotionPolynomial.from_coefficients(families.spread(c, n) * home for c in coefficients)


def _missed_by_family(families: CubicFamilies, coefficients: Sequence[DualQuaternion], n: int) -> Array:
    C = _of_family(families, coefficients, n)
    return _missed(families.problem, C, [np.asarray(t, dtype=float)[()] for t in families.parameters(n)[1:]])


def fourth_parameters(p0: PoseLike, p1: PoseLike, p2: PoseLike, p3: PoseLike) -> tuple[Scalars, ...]:
    """The parameter values t_3 of the fourth pose in the real families, when the others are at ∞, 0, 1."""
    families = families_of(p0, p1, p2, p3, 0)
    families = families.less(0, np.nan)
    kept, _ = families.judged("raise")
    return tuple(families.parameters(n)[3] for n in kept)
