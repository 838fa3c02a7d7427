"""Rational motions through given poses: conics through three, twisted cubics through four."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form, study_form
from kinlib.errors import DegenerateError, report_faults
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.number_field import square_root
from kinlib.poses import as_pose
from kinlib.projective import same_point
from kinlib.scalar import divide, is_zero, size

__all__ = ["conic_through", "cubics_through", "fourth_parameters"]


def conic_through(p0, p1, p2) -> MotionPolynomial:
    """The quadratic motion with pose p0 at t = ∞, p1 at t = 0 and p2 at t = 1.

    With b_jk = b(p_j, p_k) it is C = p0 t(t − 1) − (b_02/b_12)(t − 1) p1 + (b_01/b_12) t p2.

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion, 4×4 matrix or RigidTransform
        Poses; batches broadcast.

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
    p0, p1, p2 = (as_pose(p) for p in (p0, p1, p2))
    equal = same_point(p0, p1) | same_point(p0, p2) | same_point(p1, p2)
    faults = np.where(equal, 1, 2 * is_tangent(p0, p1, p2))
    report_faults(faults, CONIC_FAULTS, "raise")
    return conic(p0, p1, p2)


CONIC_FAULTS = (
    "two of the three poses are equal: three different poses are needed",
    "two of the three poses differ by a rotation: their plane is tangent to the Study quadric, no conic passes "
    "through the poses",
)


def conic(p0: DualQuaternion, p1: DualQuaternion, p2: DualQuaternion) -> MotionPolynomial:
    """The conic through three poses, unchecked."""
    b01, b02, b12 = study_form(p0, p1), study_form(p0, p2), study_form(p1, p2)
    q1, q2 = p1 * divide(b02, b12), p2 * divide(b01, b12)
    return MotionPolynomial.from_coefficients((p0, q2 - q1 - p0, q1))


def is_tangent(p0: DualQuaternion, p1: DualQuaternion, p2: DualQuaternion) -> np.ndarray:
    """Where the plane of three poses is tangent to the Study quadric: two of them are conjugate."""
    sizes = [(size(p.components[:4], 0), size(p.components[4:], 0)) for p in (p0, p1, p2)]
    pairs = zip(combinations((p0, p1, p2), 2), combinations(sizes, 2), strict=True)
    return np.any([is_zero(study_form(x, y), a * d + b * c, 1e-14) for (x, y), ((a, b), (c, d)) in pairs], axis=0)


def cubics_through(p0, p1, p2, p3, free=0) -> tuple[MotionPolynomial, ...]:
    """The cubic motions of both families through four poses, for one value of the free parameter.

    A cubic has p0 at t = ∞, p1 at 0, p2 at 1 and p3 at a value t_3; the Study condition asks
    z t_3² + (x − y − z) t_3 + y = 0 with x = b_01 b_23, y = b_02 b_13, z = b_03 b_12.  Its discriminant is the
    Gram determinant of the four poses, so both families are real or neither is.

    Parameters
    ----------
    p0, p1, p2, p3 : DualQuaternion, 4×4 matrix or RigidTransform
    free : scalar
        The position in the family, without unit.  The cubic is C = p0 Π(t − t_j) + Σ λ_j p_j Π_{m≠j}(t − t_m)
        with λ = μ + free · r · κ, where κ spans the kernel of the Study condition, μ is the solution with the
        smallest Σ λ_j² p_j p̄_j, and r makes the cubic independent of the factors of the poses.  Where some λ_j
        vanishes pose j is missed.

    Returns
    -------
    tuple of MotionPolynomial
        One for each real family: two, or one in the limiting cases.

    Raises
    ------
    DegenerateError
        If no family is real, the poses are not in general position, or the cubic misses a pose.
    """
    poses = [as_pose(p) for p in (p0, p1, p2, p3)]
    cubics = [_cubic(poses, t3, free) for t3 in fourth_parameters(*poses)]
    return tuple(cubics)


def fourth_parameters(p0, p1, p2, p3) -> tuple:
    """The parameter values t_3 of the fourth pose in the real families, when the others are at ∞, 0, 1."""
    x = study_form(p0, p1) * study_form(p2, p3)
    y = study_form(p0, p2) * study_form(p1, p3)
    z = study_form(p0, p3) * study_form(p1, p2)
    scale = size([x, y, z])
    if scale == 0:
        raise DegenerateError("each two of the four poses differ by a rotation: their span lies in the Study quadric")
    discriminant = (x - y - z) ** 2 - 4 * y * z
    if discriminant < 0:
        raise DegenerateError(
            f"neither family is real: the Gram determinant of the four poses is negative, {float(discriminant):.3g}"
        )
    root = square_root(discriminant)
    roots = _quadratic_roots(z, x - y - z, y, root, scale)
    usable = [t for t in roots if not (is_zero(t, rtol=1e-12) or is_zero(t - 1, rtol=1e-12))]
    if not usable:
        raise DegenerateError("the fourth pose falls on another one in both families: two poses differ by a rotation")
    return tuple(usable)


def _quadratic_roots(a, b, c, root, scale) -> list:
    """The finite roots of at² + bt + c, with the given root of the discriminant, without cancellation."""
    larger = -b - root if b > 0 else -b + root
    if is_zero(larger, scale, rtol=1e-14):
        return []
    if is_zero(a, scale, rtol=1e-14):
        return [divide(2 * c, larger)]
    first, second = divide(larger, 2 * a), divide(2 * c, larger)
    return [first] if is_zero(root, scale, rtol=1e-14) else [first, second]


def _cubic(poses: list[DualQuaternion], t3, free) -> MotionPolynomial:
    p0, *others = poses
    t = (0, 1, t3)
    b = [study_form(p0, p) for p in others]
    mutual = [study_form(x, y) for x, y in combinations(others, 2)]
    A12, A13, A23 = (divide(x, t[m] - t[n]) for x, (m, n) in zip(mutual, combinations(range(3), 2), strict=True))
    weights = [null_form(p, p) for p in others]
    kernel = [A23, -A13, A12]
    scales = _weights(kernel, b, weights, free * _unit_of_freedom(b, mutual))
    for number, (scale, weight) in enumerate(zip(scales, weights, strict=True), start=1):
        if is_zero(scale, size(scales) * size(weight), rtol=1e-12):
            raise DegenerateError(f"for this value of the free parameter the cubic misses pose {number}")
    return _lagrange(p0, [p * s for p, s in zip(others, scales, strict=True)], t)


def _unit_of_freedom(b, mutual):
    """A factor b_0j / (b_jk b_jl) for κ: with it the cubic does not depend on the factors of the poses.

    It is taken for the first pose j with which it is defined and not zero.
    """
    b12, b13, b23 = mutual
    for x, y, z in ((b[0], b12, b13), (b[1], b12, b23), (b[2], b13, b23)):
        if not any(is_zero(value, rtol=0) for value in (x, y, z)):
            return divide(x, y * z)
    raise DegenerateError("too many of the four poses differ by rotations: the free parameter has no unit")


def _weights(kernel, b, weights, ratio) -> list:
    """λ = μ + ratio · κ with Aλ = −b for the skew matrix A with the kernel κ.

    With A = [[0, A12, A13], [−A12, 0, A23], [−A13, −A23, 0]] one has Aλ = −κ × λ for κ = (A23, −A13, A12).  So
    κ × λ = b; the λ with smallest Σ w_j λ_j² is the one with Σ w_j κ_j λ_j = 0, that is
    λ = b × (wκ) / (κ · wκ).
    """
    weighted = [w * x for w, x in zip(weights, kernel, strict=True)]
    total = sum(x * y for x, y in zip(kernel, weighted, strict=True))
    if is_zero(total, rtol=0):
        raise DegenerateError("the last three poses differ by rotations about concurrent or coplanar axes")
    special = [
        divide(b[(n + 1) % 3] * weighted[(n + 2) % 3] - b[(n + 2) % 3] * weighted[(n + 1) % 3], total) for n in range(3)
    ]
    return [s + ratio * x for s, x in zip(special, kernel, strict=True)]


def _lagrange(p0: DualQuaternion, scaled: list[DualQuaternion], t) -> MotionPolynomial:
    """p0 Π(t − t_j) + Σ q_j Π_{m≠j}(t − t_m) for three nodes."""
    total = _cubic_with_roots(t)
    coefficients = [p0 * c for c in total]
    for j, q in enumerate(scaled):
        a, b = (t[m] for m in range(3) if m != j)
        for n, c in enumerate((1, -(a + b), a * b), start=1):
            coefficients[n] = coefficients[n] + q * c
    return MotionPolynomial.from_coefficients(coefficients)


def _cubic_with_roots(t) -> tuple:
    a, b, c = t
    return 1, -(a + b + c), a * b + b * c + c * a, -a * b * c
