"""Theorem 2: the two 2R dyads through three poses, by three routes.

After a change of the fixed frame the plane of the poses is spanned by [1], [q1], [q2].  Let μ1 ≤ μ2 ≤ μ3 be the
eigenvalues of the Study form relative to the null form on it.  There are two 2R spaces through the plane if the
three differ, and one if two of them agree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinlib.displacement import axis_of, unit
from kinlib.dual_quaternion import DualQuaternion, eps, eps_times, i, j, null_form, one, study_form
from kinlib.dyad import Dyad
from kinlib.errors import DegenerateError, report_faults
from kinlib.factorization import factor_in_orders, quadratic_factors, upper_roots
from kinlib.interpolation import conic, is_tangent
from kinlib.poses import as_pose
from kinlib.projective import same_point
from kinlib.scalar import as_float, is_exact, is_zero, size

__all__ = ["dyads_through_poses", "study_eigenvalues"]

FAULTS = (
    "the plane of the three poses meets the exceptional three-space",
    "the plane of the three poses lies in the Study quadric: no 2R space contains it, as its quadric is regular",
    "the quartic of the three poses has double roots: one 2R dyad passes through them, not two",
    "the plane of the three poses is tangent to the Study quadric (two poses differ by a rotation): there are two "
    "2R dyads, which method='eigenvalues' finds, but no conic and no Bennett linkage",
)
MEETS_E, INSIDE, DOUBLE, TANGENT = 1, 2, 3, 4

Pair = tuple[DualQuaternion, DualQuaternion]


def dyads_through_poses(p0, p1, p2, *, method: str | None = None, degenerate: str = "raise") -> tuple[Dyad, Dyad]:
    """The two 2R dyads through three poses (Theorem 2).

    Parameters
    ----------
    p0, p1, p2 : DualQuaternion of shape (...), 4×4 matrices or SciPy RigidTransforms
        Any poses; p0 becomes the home pose of the dyads.  Batches broadcast.
    method : {"eigenvalues", "factorization", "null_quadrilateral"}, optional
        The route.  ``"eigenvalues"``: from the Study form relative to the null form on the plane of the poses;
        floats; the most accurate, and right on tangent planes; the default for floats.  ``"factorization"``:
        from the two factorizations of the conic through the poses; exact for exact poses, and the default
        for them.  ``"null_quadrilateral"``: the construction of the paper's proof, in complex floats.
    degenerate : {"raise", "nan"}
        What to do about rows of a batch for which the answer is not determined; ``"nan"`` needs floats.

    Returns
    -------
    tuple of two Dyads
        Each passes through all three poses.

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
    poses = [as_pose(p) for p in (p0, p1, p2)]
    return tuple(Dyad(h1, h2, poses[0]) for h1, h2 in pairs_through(poses, method, degenerate))


def pairs_through(poses: list[DualQuaternion], method: str | None, degenerate: str) -> list[Pair]:
    """The half-turns of the dyads through three poses, as seen from the first."""
    exact = all(is_exact(p.components) for p in poses)
    method = method or ("factorization" if exact else "eigenvalues")
    if method not in ROUTES:
        raise ValueError(f"expected a method among {', '.join(ROUTES)}, got {method!r}")
    if exact and method == "factorization":
        return _exact_pairs(poses, degenerate)
    return _float_pairs([p.astype(float) for p in poses], method, degenerate)


def study_eigenvalues(p0, p1, p2) -> np.ndarray:
    """The eigenvalues μ1 ≤ μ2 ≤ μ3 of the Study form relative to the null form on the plane of three poses.

    Both dyads through the poses have (μ3 − μ1)/2 as the ratio of distance and sine of the angle of their axes,
    and −μ1 μ3 as the square of the distance.  Floats, in units of length, shape (..., 3).

    Examples
    --------
    >>> study_eigenvalues(one, i * (j - eps * i), (1 - i) * (2 - j + eps * i)).round(6).tolist()
    [-1.0, -0.8, 1.0]
    """
    poses = [as_pose(p).astype(float) for p in (p0, p1, p2)]
    return _spectrum(*relative(*poses)).values


def relative(p0: DualQuaternion, p1: DualQuaternion, p2: DualQuaternion) -> Pair:
    """The second and third pose as seen from the first."""
    back = p0.inverse()
    return unit(p1 * back), unit(p2 * back)


def _exact_pairs(poses: list[DualQuaternion], degenerate: str) -> list[Pair]:
    """The half-turns of both dyads, from the two factorizations of the conic; exact."""
    if degenerate == "nan":
        raise ValueError("degenerate='nan' needs floats, since NaN is one: convert the poses, or use 'raise'")
    q1, q2 = relative(*poses)
    faults = _exact_faults(q1, q2)
    if faults.ndim == 0 and faults == MEETS_E:
        raise DegenerateError(_exceptional(q1, q2))
    report_faults(faults, FAULTS, degenerate)
    C = conic(one, q1, q2)
    quadratics = quadratic_factors(C.norm_polynomial())
    pairs = _factored(C, quadratics)
    equal = np.asarray((quadratics[..., 0, :] == quadratics[..., 1, :]).all(axis=-1))
    dyad = Dyad(*pairs[0], poses[0]) if equal.ndim == 0 and equal else None
    report_faults(equal * DOUBLE, FAULTS, degenerate, dyad=dyad)
    return pairs


def _exact_faults(q1: DualQuaternion, q2: DualQuaternion) -> np.ndarray:
    u1, u2 = (q.coeffs[..., 1:4] for q in (q1, q2))
    parallel = np.all(is_zero(np.cross(u1, u2)), axis=-1)
    zeros = [is_zero(b) for b in (study_form(one, q1), study_form(one, q2), study_form(q1, q2))]
    inside, tangent = np.all(zeros, axis=0), np.any(zeros, axis=0)
    return np.select([parallel, inside, tangent], [MEETS_E, INSIDE, TANGENT], 0)


def _exceptional(q1: DualQuaternion, q2: DualQuaternion) -> str:
    """What makes the plane of 1, q1, q2 meet the exceptional space."""
    if q1.shape or q2.shape:
        return FAULTS[MEETS_E - 1]
    named = ((0, 1, one, q1), (0, 2, one, q2), (1, 2, q1, q2))
    for m, n, x, y in named:
        if same_point(x, y, length=max(size(x.coeffs[4:]), size(y.coeffs[4:]), 1e-300)):
            return f"poses {m} and {n} are equal: three different poses are needed"
    for m, n, x, y in named:
        if same_point(x.primal, y.primal, rtol=1e-12):
            return f"{FAULTS[MEETS_E - 1]}: poses {m} and {n} differ by a pure translation"
    return f"{FAULTS[MEETS_E - 1]}: the three orientations differ by rotations about parallel axes"


class _Spectrum(NamedTuple):
    """The plane of three poses: a basis orthonormal for the null form and diagonal for the Study form."""

    basis: tuple[DualQuaternion, DualQuaternion, DualQuaternion]
    normal: DualQuaternion  # the primal quaternion orthonormal to the plane
    values: np.ndarray  # (..., 3), ascending
    length: np.ndarray  # the largest dual part, (...)
    apart: np.ndarray  # how far the plane is from the exceptional space, at most 1, (...)


def _spectrum(q1: DualQuaternion, q2: DualQuaternion) -> _Spectrum:
    e1, first = _normalised(q1 - q1.scalar_part)
    rest, second = _normalised(q2 - q2.scalar_part)
    e2, third = _normalised(rest - e1 * null_form(e1, rest))
    e2, _ = _normalised(e2 - e1 * null_form(e1, e2))
    plane = DualQuaternion.stack([one, e1, e2], axis=-1).coeffs
    mixed = plane[..., :4] @ np.swapaxes(plane[..., 4:], -1, -2)
    gram = mixed + np.swapaxes(mixed, -1, -2)
    values, vectors = np.linalg.eigh(np.where(np.isfinite(gram), gram, 0))
    rows = DualQuaternion(np.swapaxes(vectors, -1, -2) @ plane)
    basis = tuple(rows[..., n] for n in range(3))
    length = np.maximum(size(q1.coeffs[..., 4:], -1), size(q2.coeffs[..., 4:], -1))
    return _Spectrum(basis, (e1 * e2).primal, values, length, np.minimum(np.minimum(first, second), third))


def _normalised(x: DualQuaternion) -> tuple[DualQuaternion, np.ndarray]:
    """A point scaled to null form 1, and the length that it had."""
    length = np.sqrt(null_form(x, x))
    with np.errstate(divide="ignore", invalid="ignore"):
        return x / length, length


def _faults(plane: _Spectrum) -> np.ndarray:
    """The number of the fault of each row: differences that rounding may have made count as none."""
    mu1, mu2, mu3 = np.moveaxis(plane.values, -1, 0)
    spread = mu3 - mu1
    noise = 1e-14 * plane.length / np.maximum(plane.apart, 1e-12)
    double = np.minimum(mu3 - mu2, mu2 - mu1) <= 1e-13 * spread + noise
    return np.select([~(plane.apart > 1e-12), spread <= 8 * noise, double], [MEETS_E, INSIDE, DOUBLE], 0)


def _float_pairs(poses: list[DualQuaternion], method: str, degenerate: str) -> list[Pair]:
    q1, q2 = relative(*poses)
    with np.errstate(invalid="ignore"):
        plane = _spectrum(q1, q2)
    faults = _faults(plane)
    if method != "eigenvalues":
        faults = np.where((faults == 0) & is_tangent(one, q1, q2), TANGENT, faults)
    if degenerate == "raise" and faults.ndim == 0 and faults:
        raise _explained(int(faults), q1, q2, plane, poses[0])
    faulty = report_faults(faults, FAULTS, degenerate)
    safe = [_replaced(q, faulty, stand_in) for q, stand_in in zip((q1, q2), STAND_INS, strict=True)]
    pairs = _by_eigenvalues(plane) if method == "eigenvalues" else ROUTES[method](*safe)
    return [(masked(h1, faulty), masked(h2, faulty)) for h1, h2 in pairs]


def _explained(fault: int, q1: DualQuaternion, q2: DualQuaternion, plane: _Spectrum, home) -> DegenerateError:
    if fault == MEETS_E:
        return DegenerateError(_exceptional(q1, q2))
    dyad = Dyad(*_by_eigenvalues(_rounded(plane))[0], home) if fault == DOUBLE else None
    return DegenerateError(FAULTS[fault - 1], dyad=dyad)


def _rounded(plane: _Spectrum) -> _Spectrum:
    """The plane with its middle eigenvalue moved to the nearer of the others."""
    mu1, mu2, mu3 = plane.values
    return plane._replace(values=np.array([mu1, mu1 if mu2 - mu1 < mu3 - mu2 else mu3, mu3]))


STAND_INS = (i * (j - eps * i), (1 - i) * (2 - j + eps * i))  # a regular problem, in place of faulty rows


def _replaced(q: DualQuaternion, rows: np.ndarray, stand_in: DualQuaternion) -> DualQuaternion:
    if not rows.any():
        return q
    return DualQuaternion(np.where(rows[..., None], stand_in.astype(float).coeffs, q.coeffs))


def masked(q: DualQuaternion, rows: np.ndarray) -> DualQuaternion:
    """NaN in place of the given rows."""
    return DualQuaternion(np.where(rows[..., None], np.nan, as_float(q.coeffs))) if rows.any() else q


def _by_eigenvalues(plane: _Spectrum) -> list[Pair]:
    """Both spaces from the bordered eigenvalue problem of the plane.

    A 2R space has two double eigenvalues; by interlacing they are μ1 and μ3.  In the basis f1, f2, f3 of the
    plane, completed by a point x, the Study form must then have the entries b(f1, x) = b(f3, x) = 0,
    b(f2, x)² = (μ3 − μ2)(μ2 − μ1) and b(x, x) = μ1 + μ3 − μ2.  The eigenvectors are f1, f3 and two combinations
    of f2 and x.
    """
    mu1, mu2, mu3 = np.moveaxis(plane.values, -1, 0)
    low, high = np.maximum(mu2 - mu1, 0), np.maximum(mu3 - mu2, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        sine, cosine = np.sqrt(low / (mu3 - mu1)), np.sqrt(high / (mu3 - mu1))
    f1, f2, f3 = plane.basis
    pairs = []
    for sign in (1, -1):
        x = _fourth_point(plane, sign * np.sqrt(low * high), mu1 + mu3 - mu2)
        negative, positive = f2 * cosine - x * (sign * sine), f2 * (sign * sine) + x * cosine
        pairs.append(_axes((f1, negative), (f3, positive)))
    return pairs


def _fourth_point(plane: _Spectrum, entry, last) -> DualQuaternion:
    """The point x orthonormal to the plane with b(x, f1) = b(x, f3) = 0, b(x, f2) = entry, b(x, x) = last."""
    dual = plane.normal * (last / 2)
    for f, value in zip(plane.basis, (0, entry, 0), strict=True):
        dual = dual + f * (value - study_form(plane.normal, f))
    return plane.normal + eps_times(dual)


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
    straight = (h1 * h2).components[1:4] * product.components[1:4]
    swap = np.where(straight.sum(axis=0) < 0, -1, 1)
    return axis_of(total + difference * swap), axis_of(total - difference * swap)


def _turned(x: DualQuaternion, y: DualQuaternion) -> Pair:
    """In the plane of orthonormal x, y: the projection of 1 turned by a right angle, and itself."""
    a, b = x.scalar_part, y.scalar_part
    return y * a - x * b, x * a + y * b


def _factored(C, quadratics) -> list[Pair]:
    h1, h2 = factor_in_orders(C, quadratics, [(0, 1), (1, 0)])
    return [(axis_of(h1[..., n]), axis_of(h2[..., n])) for n in range(2)]


def _by_factorization(q1: DualQuaternion, q2: DualQuaternion) -> list[Pair]:
    C = conic(one, q1, q2)
    return _factored(C, quadratic_factors(C.norm_polynomial()))


def _by_null_quadrilateral(q1: DualQuaternion, q2: DualQuaternion) -> list[Pair]:
    """The construction in the proof of Theorem 2, in complex floats.

    The conic meets the null cone in m1, n1 and their conjugates m2, n2.  The primal part of u1 is null and
    orthogonal to those of m1 and n2, the other vertices follow by projection from n1, m2, and the dual parts
    solve a linear system (Lemma 5).
    """
    C = conic(one, q1, q2)
    roots = upper_roots(C.norm_polynomial())
    m1, n1 = (C(_sharpened(C, roots[..., n])).coeffs for n in range(2))
    return [_lifted(u, m1, n1) for u in _first_vertices(m1[..., :4], n1.conj()[..., :4])]


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
    shift = np.linalg.solve(vertices, -_inner(vertices, known))[..., 0]
    u, v = (np.concatenate([vertices[..., n, :], known[..., n, :] + shift], axis=-1) for n in (0, 1))
    return _axes(*_eigenspaces(np.stack([u.real, u.imag, v.real, v.imag], axis=-2)))


def _eigenspaces(basis: np.ndarray) -> tuple[Pair, Pair]:
    """Orthonormal bases of the two eigenspaces of a 2R space, given by a basis, shape (..., 4, 8).

    A 3-space that misses E is the graph of a linear map from primal to dual parts: in the basis with the units
    as primal parts the Study form is that map plus its transpose.
    """
    graph = np.linalg.solve(basis[..., :4], basis)
    study = graph[..., 4:] + np.swapaxes(graph[..., 4:], -1, -2)
    _, vectors = np.linalg.eigh(study)
    rows = DualQuaternion(np.swapaxes(vectors, -1, -2) @ graph)
    return (rows[..., 0], rows[..., 1]), (rows[..., 2], rows[..., 3])


ROUTES = {
    "eigenvalues": _by_eigenvalues,
    "factorization": _by_factorization,
    "null_quadrilateral": _by_null_quadrilateral,
}
