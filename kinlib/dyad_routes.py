"""Three routes from three poses to the axes of the two 2R dyads through them.

As seen from the first pose the plane of the poses is spanned by [1], [q1], [q2].  Let μ1 ≤ μ2 ≤ μ3 be the eigenvalues
of the Study form relative to the null form on it.  There are two 2R spaces through the plane if the three differ, and
one if two of them agree.  Everything here is in floats, in the problem's own frame, and comes unchecked; the first axis
of a batch tells the two dyads apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, eps_times, null_form, study_form, wrap
from kinlib.factorization import factor_in_orders
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import solved
from kinlib.pose_faults import distance_from_exceptional_space
from kinlib.poses import PoseProblem
from kinlib.scalar import divide
from kinlib.typing import Array

__all__ = ["ROUTES"]

Pair = tuple[DualQuaternion, DualQuaternion]

BOTH_ORDERS = ((0, 1), (1, 0))
"""In which of its two quadratic factors the first joint of each dyad has its own."""


# ---- the conic through the poses ----------------------------------------------------------------------


def start_of(problem: PoseProblem) -> np.ndarray:
    """Which of t = 0 and t = 1 the conic passes more slowly: there its polynomial needs its digits."""
    first, second = _weights(problem)
    return np.where(np.abs(second) < np.abs(first), 1.0, 0.0)


def _weights(problem: PoseProblem) -> tuple[Array, Array]:
    """The b02/b12 and b01/b12 with which C(0) and C(1) are multiples of the second and third pose."""
    b01, b02, b12 = problem.forms
    return divide(b02, b12), divide(b01, b12)


def conic_from(problem: PoseProblem, start: np.ndarray) -> MotionPolynomial:
    """C(start + τ) as a polynomial in τ, for the conic C with [1] at ∞, [q1] at 0 and [q2] at 1.

    C = t(t − 1) + (1 − t) λ1 q1 + t λ2 q2 with the weights λ.
    """
    q1, q2 = (q * weight for q, weight in zip(problem.others, _weights(problem), strict=True))
    linear = q2 - q1 + (2 * start - 1)
    constant = q1 * (1 - start) + q2 * start
    return MotionPolynomial.from_coefficients((linear * 0 + 1, linear, constant))


def factored(C: MotionPolynomial) -> Pair:
    """The linear factors from the roots of the norm polynomial of the conic, in both orders."""
    upper = _upper_roots(C)
    quadratics = np.stack([np.ones(upper.shape), -2 * upper.real, np.abs(upper) ** 2], axis=-1)
    return in_both_orders(C, quadratics)


def in_both_orders(C: MotionPolynomial, quadratics: np.ndarray) -> Pair:
    """The linear factors of the conic from the quadratic factors of its norm polynomial."""
    k1, k2 = (wrap(np.moveaxis(k.components, -1, 1)) for k in factor_in_orders(C, quadratics, BOTH_ORDERS))
    return k1, k2


def _upper_roots(C: MotionPolynomial) -> np.ndarray:
    """The roots of the norm polynomial of a monic conic with the larger imaginary parts, shape (..., 2)."""
    quartic = C.norm_polynomial()
    companion = np.zeros((*quartic.shape[:-1], 4, 4)) + np.eye(4, k=-1)
    companion[..., 0, :] = np.nan_to_num(-quartic[..., 1:], posinf=0, neginf=0)
    roots = np.linalg.eigvals(companion)
    return np.take_along_axis(roots, np.argsort(-roots.imag, axis=-1)[..., :2], -1)


# ---- half-turns -----------------------------------------------------------------------------------------


def on_axis(k: DualQuaternion) -> DualQuaternion:
    """The factor x + y h with the axis that k nearly has: what rounding has added to a line is taken away."""
    components = k.components.copy()
    components[4] = 0
    l, m = components[1:4], components[5:]
    m -= l * (_dot(l, m) / _dot(l, l))
    return wrap(components)


def half_turn_of(k: DualQuaternion) -> DualQuaternion:
    """The half-turn h with k = x + y h and y > 0; NaN where there is none."""
    components = k.components / size_of_turn(k)
    components[[0, 4]] = 0
    return wrap(components)


def size_of_turn(k: DualQuaternion) -> np.ndarray:
    """The y > 0 of k = x + y h with a half-turn h of length 1."""
    l = k.components[1:4]
    return np.sqrt(_dot(l, l))


def _dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Inner products of vectors with their components first."""
    return np.add.reduce(x * y, axis=0)


def normalised(x: DualQuaternion) -> DualQuaternion:
    """A point scaled to null form 1; NaN where it is 0."""
    return x / np.sqrt(null_form(x, x))


# ---- the plane of the poses -----------------------------------------------------------------------------


class Spectrum(NamedTuple):
    """The plane of three poses: a basis orthonormal for the null form and diagonal for the Study form."""

    basis: DualQuaternion  # (3, ...)
    normal: DualQuaternion  # the primal quaternion orthonormal to the plane
    values: np.ndarray  # (3, ...), ascending


def spectrum_of(others: DualQuaternion) -> Spectrum:
    """The plane of [1] and two poses, shape (2, ...)."""
    e1, rest = normalised(others - others.scalar_part)
    e2 = normalised(rest - e1 * null_form(e1, rest))
    e2 = normalised(e2 - e1 * null_form(e1, e2))
    values, vectors = np.linalg.eigh(_gram(e1, e2))  # of its rows and columns the lower triangle is read
    x, y, z = vectors.transpose(-2, -1, *range(vectors.ndim - 2))
    return Spectrum(e1 * y + e2 * z + x, (e1 * e2).primal, values.transpose(-1, *range(values.ndim - 1)))


def _gram(e1: DualQuaternion, e2: DualQuaternion) -> np.ndarray:
    """The Study form in the basis 1, e1, e2, below the diagonal and on it; 0 for what is not finite."""
    gram = np.zeros((*e1.shape, 3, 3))
    gram[..., 1, 0], gram[..., 2, 0] = e1.components[4], e2.components[4]
    gram[..., 1, 1], gram[..., 2, 1], gram[..., 2, 2] = study_form(e1, e1), study_form(e1, e2), study_form(e2, e2)
    return gram if np.isfinite(gram).all() else np.where(np.isfinite(gram), gram, 0)


def has_double_roots(problem: PoseProblem, plane: Spectrum) -> np.ndarray:
    """Whether two eigenvalues agree as nearly as they can be told."""
    mu1, mu2, mu3 = plane.values
    noise = (1e-14 + 4 * problem.noise) / distance_from_exceptional_space(problem.others)
    return np.minimum(mu3 - mu2, mu2 - mu1) <= 1e-13 * (mu3 - mu1) + noise


def rounded(plane: Spectrum) -> Spectrum:
    """The plane with its middle eigenvalue moved to the nearer of the others."""
    mu1, mu2, mu3 = plane.values
    return plane._replace(values=np.array([mu1, mu1 if mu2 - mu1 < mu3 - mu2 else mu3, mu3]))


# ---- the routes -----------------------------------------------------------------------------------------


def by_eigenvalues(problem: PoseProblem, plane: Spectrum) -> Pair:
    """Both spaces from the bordered eigenvalue problem of the plane.

    A 2R space has two double eigenvalues; by interlacing they are μ1 and μ3.  In the basis f1, f2, f3 of the
    plane, completed by a point x, the Study form must then have the entries b(f1, x) = b(f3, x) = 0,
    b(f2, x)² = (μ3 − μ2)(μ2 − μ1) and b(x, x) = μ1 + μ3 − μ2.  The eigenvectors are f1, f3 and two combinations
    of f2 and x.  The sign of b(f2, x) tells the two dyads apart.
    """
    (mu1, mu2, mu3), (f1, f2, f3) = plane.values, plane.basis
    low, high = np.maximum(mu2 - mu1, 0), np.maximum(mu3 - mu2, 0)
    sine, cosine = np.multiply.outer(SIGNS, np.sqrt(low / (mu3 - mu1))), np.sqrt(high / (mu3 - mu1))
    x = eps_times(f2) * np.multiply.outer(SIGNS, np.sqrt(low * high)) + _fourth_point(plane)
    return _axes((f1, f2 * cosine - x * sine), (f3, f2 * sine + x * cosine))


SIGNS = np.array([1.0, -1.0])


def _fourth_point(plane: Spectrum) -> DualQuaternion:
    """The point x orthonormal to the plane with b(x, f) = 0 for its basis and b(x, x) = μ1 + μ3 − μ2."""
    normal, (mu1, mu2, mu3) = plane.normal, plane.values
    along = plane.basis * study_form(normal, plane.basis)
    return normal + eps_times(normal * ((mu1 + mu3 - mu2) / 2) - wrap(along.components.sum(axis=1)))


def _axes(minus: Pair, plus: Pair) -> Pair:
    """The half-turns of a 2R space from orthonormal bases of its two eigenspaces.

    With the sign of h2 chosen so that b(h1, h2) > 0 the eigenspaces are spanned by h1 − h2 and 1 + h1h2, and by
    h1 + h2 and 1 − h1h2.  In each, the vector orthogonal to the projection of 1 and of its length is half the
    difference, and half the sum.
    """
    difference, total = _turned(*minus), _turned(*plus)
    swap = np.where(null_form((total + difference) * (total - difference), _projection(*plus)) > 0, -1.0, 1.0)
    return half_turn_of(on_axis(total + difference * swap)), half_turn_of(on_axis(total - difference * swap))


def _turned(x: DualQuaternion, y: DualQuaternion) -> DualQuaternion:
    """In the plane of orthonormal x, y: the projection of 1 turned by a right angle."""
    return y * x.scalar_part - x * y.scalar_part


def _projection(x: DualQuaternion, y: DualQuaternion) -> DualQuaternion:
    """In the plane of orthonormal x, y: the projection of 1, without its scalar part."""
    projection = x * x.scalar_part + y * y.scalar_part
    return projection - projection.scalar_part


def _by_factorization(problem: PoseProblem, plane: Spectrum) -> Pair:
    k1, k2 = factored(conic_from(problem, start_of(problem)))
    return half_turn_of(on_axis(k1)), half_turn_of(on_axis(k2))


def _by_null_quadrilateral(problem: PoseProblem, plane: Spectrum) -> Pair:
    """The construction in the proof of Theorem 2, in complex floats.

    The conic meets the null cone in m1, n1 and their conjugates m2, n2.  The primal part of u1 is null and
    orthogonal to those of m1 and n2, the other vertices follow by projection from n1, m2, and the dual parts
    solve a linear system (Lemma 5).
    """
    C = conic_from(problem, start_of(problem))
    m1, n1 = (C(_sharpened(C, root)).coeffs for root in np.moveaxis(_upper_roots(C), -1, 0))
    pairs = [_lifted(u, m1, n1) for u in _first_vertices(m1[..., :4], n1.conj()[..., :4])]
    h1, h2 = (DualQuaternion.stack(half_turns) for half_turns in zip(*pairs, strict=True))
    return h1, h2


def _sharpened(C: MotionPolynomial, t: np.ndarray) -> np.ndarray:
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
    "eigenvalues": by_eigenvalues,
    "factorization": _by_factorization,
    "null_quadrilateral": _by_null_quadrilateral,
}
