"""Displacements of space and their points on the Study quadric: equation (1) of the paper."""

from __future__ import annotations

import numpy as np

from kinlib.dual_quaternion import (
    DualQuaternion,
    blockwise,
    eps_times,
    null_form,
    study_form,
)
from kinlib.errors import DegenerateError
from kinlib.line import Line, wrap_line
from kinlib.number_field import square_root
from kinlib.scalar import RTOL, as_float, as_scalars, divide, is_exact, is_zero

__all__ = [
    "act", "as_matrix", "as_rigid_transform", "axis_of", "from_matrix", "from_rigid_transform", "half_turn",
    "rotation", "translation", "unit",
]  # fmt: skip


def translation(v) -> DualQuaternion:
    """The translation 1 + ½εv by a vector v, shape (..., 3), in units of length.

    Examples
    --------
    >>> translation([0, 4, 0])
    1 + 2 εj
    """
    v = as_scalars(v)
    if v.shape[-1:] != (3,):
        raise ValueError(f"expected vectors of shape (..., 3), got shape {v.shape}")
    half = divide(v, 2)
    components = np.zeros((8, *v.shape[:-1]), dtype=half.dtype)
    components[0], components[5:] = 1, np.moveaxis(half, -1, 0)
    return DualQuaternion.from_components(components)


def half_turn(line: Line) -> DualQuaternion:
    """The half-turn l + εm about a line; a unit dual quaternion if the direction has length 1."""
    return line.as_dual_quaternion()


def rotation(line: Line, angle) -> DualQuaternion:
    """The rotation cos(½ angle) + sin(½ angle) h about a line, with h the unit half-turn about it.

    Parameters
    ----------
    line : Line
        The axis; its orientation gives the sense of the rotation.
    angle : float, array or SymPy expression
        In radians, counter-clockwise when the axis points at the viewer.  An expression keeps an exact line
        exact; with any other angle the result is in floats, since sine and cosine leave the rational numbers.

    Examples
    --------
    >>> import sympy
    >>> rotation(Line([0, 0, 1], [0, 0, 0]), sympy.pi / 3)
    sqrt(3)/2 + 1/2 k
    """
    h = half_turn(line)
    if hasattr(angle, "free_symbols"):
        from sympy import cos, sin, sqrt, sympify

        return h / sqrt(sympify(null_form(h, h))) * sin(angle / 2) + cos(angle / 2)
    half = as_float(as_scalars(angle)) / 2
    return unit(h.astype(float)) * np.sin(half) + np.cos(half)


def unit(q: DualQuaternion) -> DualQuaternion:
    """The same point of P⁷ with primal part of length 1, where that root can be taken.

    Exact coefficients are left as they are if the square of the length is not the square of a fraction.
    """
    square = null_form(q, q)
    if not is_exact(q.components):
        return q / np.sqrt(square)
    return q / np.frompyfunc(_rational_root, 1, 1)(square)


def axis_of(h: DualQuaternion) -> DualQuaternion:
    """The half-turn about the axis of a rotation; what rounding has added to a line is taken away.

    Raises
    ------
    DegenerateError
        If there is no axis: for the identity and for translations.

    Examples
    --------
    >>> axis_of(3 + 2 * (j - eps * i))
    j - εi
    """
    components = h.components.copy()
    components[[0, 4]] = 0
    v = DualQuaternion.from_components(components)
    if np.any(is_zero(null_form(v, v), rtol=0)):
        raise DegenerateError("the primal part is a number: the identity and translations have no axis")
    return unit(v - eps_times(v) * divide(study_form(v, v), 2 * null_form(v, v)))


def _rational_root(square):
    """The root of an exact number if it lies in the same field, else 1."""
    try:
        root = square_root(square)
    except (TypeError, ValueError):
        return 1
    return root if type(root) in (type(divide(square, 1)), type(square)) else 1


def _matrix_formula(q):
    """The rotation matrix and the translation vector of equation (1), in components.

    x ↦ (p x p̄ + d p̄ − p d̄) / (p p̄) is x + 2 p × (p0 x + p × x) / (p p̄) + 2 (d p̄ without its real part) / (p p̄).
    """
    p0, p1, p2, p3, d0, d1, d2, d3 = q
    s = divide(2, p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    s0, s1, s2, s3 = s * p0, s * p1, s * p2, s * p3
    xx, yy, zz, xy, yz, zx = s1 * p1, s2 * p2, s3 * p3, s1 * p2, s2 * p3, s3 * p1
    wx, wy, wz = s0 * p1, s0 * p2, s0 * p3
    turn = (1 - (yy + zz), xy - wz, zx + wy), (xy + wz, 1 - (zz + xx), yz - wx), (zx - wy, yz + wx, 1 - (xx + yy))
    shift = (
        s0 * d1 - s1 * d0 + s2 * d3 - s3 * d2,
        s0 * d2 - s2 * d0 + s3 * d1 - s1 * d3,
        s0 * d3 - s3 * d0 + s1 * d2 - s2 * d1,
    )
    return turn, shift


def _turned(turn, x):
    x1, x2, x3 = x
    return tuple(a * x1 + b * x2 + c * x3 for a, b, c in turn)


def _point_formula(q, x):
    turn, shift = _matrix_formula(q)
    return tuple(y + t for y, t in zip(_turned(turn, x), shift, strict=True))


def _line_formula(q, line):
    """The direction turns; the moment turns and gains shift × (turned direction)."""
    turn, (t1, t2, t3) = _matrix_formula(q)
    l1, l2, l3 = _turned(turn, line[:3])
    m1, m2, m3 = _turned(turn, line[3:])
    return l1, l2, l3, m1 + (t2 * l3 - t3 * l2), m2 + (t3 * l1 - t1 * l3), m3 + (t1 * l2 - t2 * l1)


def act(q: DualQuaternion, x):
    """Move points or lines by the displacement [q], equation (1).

    Parameters
    ----------
    q : DualQuaternion, shape (...)
        On the Study quadric, off the exceptional space.
    x : array_like, shape (..., 3), or Line
        Points, or lines; batches broadcast.

    Returns
    -------
    numpy.ndarray, shape (..., 3), or Line

    Examples
    --------
    >>> act(translation([0, 0, 2]), [1, 1, 1]).tolist()
    [Fraction(1, 1), Fraction(1, 1), Fraction(3, 1)]
    >>> act(k, Line([1, 0, 0], [0, 1, 0])).direction.tolist()
    [Fraction(-1, 1), Fraction(0, 1), Fraction(0, 1)]
    """
    if isinstance(x, Line):
        components = np.moveaxis(np.concatenate([x.direction, x.moment], axis=-1), -1, 0)
        return wrap_line(np.moveaxis(blockwise(_line_formula, _divisible(q), components, rows=6), 0, -1))
    points = as_scalars(x)
    if points.shape[-1:] != (3,):
        raise ValueError(f"expected points of shape (..., 3), got {points.shape}")
    components = np.moveaxis(points, -1, 0)
    return np.moveaxis(blockwise(_point_formula, _divisible(q), components, rows=3), 0, -1)


def _divisible(q: DualQuaternion) -> np.ndarray:
    """Components of a pose, whose primal part must not vanish; whole numbers as fractions."""
    if np.any(is_zero(null_form(q, q), rtol=0)):
        raise DegenerateError("the point lies in the exceptional three-space (primal part zero): it moves nothing")
    return q.components if q.components.dtype.kind in "fc" else divide(q.components, 1)


def as_matrix(q: DualQuaternion) -> np.ndarray:
    """The homogeneous 4×4 matrix of the displacement [q], shape (..., 4, 4); rational in q.

    Examples
    --------
    >>> (as_matrix(translation([1, 2, 3])) == [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]).all()
    np.True_
    """
    turned = act(q.primal[..., None], np.eye(3, dtype=int))
    matrix = np.zeros((*q.shape, 4, 4), dtype=turned.dtype)
    matrix[..., :3, :3] = np.swapaxes(turned, -1, -2)
    matrix[..., :3, 3] = act(q, [0, 0, 0])
    matrix[..., 3, 3] = 1
    return matrix


def from_matrix(matrix, *, rtol: float = RTOL) -> DualQuaternion:
    """The point of the Study quadric for homogeneous matrices of displacements, shape (..., 4, 4).

    No root is taken for exact matrices; the primal part has length 1 for floats.

    Raises
    ------
    ValueError
        If the upper left block is no rotation or the last row is not (0, 0, 0, 1).

    Examples
    --------
    >>> from_matrix([[1, 0, 0, 2], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]])
    i - ε
    """
    matrix = as_scalars(matrix)
    if matrix.shape[-2:] != (4, 4):
        raise ValueError(f"expected matrices of shape (..., 4, 4), got {matrix.shape}")
    _check_finite(matrix)
    R, last = matrix[..., :3, :3], matrix[..., 3, :]
    _check_rotation(R, last, rtol)
    outer = _outer_square(R)
    diagonal = np.diagonal(outer, axis1=-2, axis2=-1)
    best = np.argmax(diagonal, axis=-1)[..., None, None]
    primal = np.take_along_axis(outer, best, axis=-2)[..., 0, :]
    p = unit(DualQuaternion(np.concatenate([primal, np.zeros_like(primal)], axis=-1)))
    return translation(matrix[..., :3, 3]) * p


def _check_finite(numbers: np.ndarray) -> None:
    if numbers.dtype.kind in "fc" and not np.all(np.isfinite(numbers)):
        raise ValueError("expected finite numbers, got NaN or infinity")


def _check_rotation(R: np.ndarray, last: np.ndarray, rtol: float) -> None:
    orthogonal = np.all(is_zero(R @ np.swapaxes(R, -1, -2) - np.eye(3, dtype=int), rtol=10 * rtol))
    turns = (np.cross(R[..., 0], R[..., 1]) * R[..., 2]).sum(-1)
    if not orthogonal or np.any(turns < 0):
        raise ValueError("expected a rotation in the upper left block: an orthogonal matrix of determinant 1")
    if not np.all(is_zero(last - np.array([0, 0, 0, 1]), rtol=rtol)):
        raise ValueError("expected the last row (0, 0, 0, 1) of a displacement")


def _outer_square(R: np.ndarray) -> np.ndarray:
    """The matrix 4 p pᵀ of the unit quaternion p of a rotation matrix; every row is a multiple of p."""
    trace = R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2]
    outer = np.zeros((*R.shape[:-2], 4, 4), dtype=R.dtype)
    outer[..., 0, 0] = 1 + trace
    for m in range(3):
        n, r = (m + 1) % 3, (m + 2) % 3
        outer[..., m + 1, m + 1] = 1 + 2 * R[..., m, m] - trace
        outer[..., 0, m + 1] = outer[..., m + 1, 0] = R[..., r, n] - R[..., n, r]
        outer[..., n + 1, r + 1] = outer[..., r + 1, n + 1] = R[..., r, n] + R[..., n, r]
    return outer


def from_rigid_transform(transform) -> DualQuaternion:
    """The pose of a SciPy ``RigidTransform``, single or batch."""
    return from_matrix(transform.as_matrix())


def as_rigid_transform(q: DualQuaternion):
    """The displacement [q] as a SciPy ``RigidTransform`` (floats; needs SciPy)."""
    from scipy.spatial.transform import RigidTransform

    return RigidTransform.from_matrix(as_float(as_matrix(q)))
