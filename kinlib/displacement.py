"""Displacements of space and their points on the Study quadric: equation (1) of the paper."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, as_dual_quaternion, blockwise, eps_times, null_form, study_form, wrap
from kinlib.errors import DegenerateError, check_degenerate, named_rows, rows_where
from kinlib.line import Line, wrap_line
from kinlib.number_field import square_root
from kinlib.scalar import (
    ROUNDING,
    RTOL,
    as_float,
    as_scalars,
    as_vectors,
    divide,
    finite_rows,
    is_exact,
    is_zero,
    own_precision,
    plain,
)
from kinlib.typing import Array, Degenerate, MatrixLike, PointLike, PoseLike, RigidTransformLike, ScalarLike, VectorLike

__all__ = [
    "act", "as_matrix", "as_rigid_transform", "axis_of", "from_matrix", "from_rigid_transform", "half_turn",
    "rotation", "translation", "unit",
]  # fmt: skip


def translation(v: VectorLike) -> DualQuaternion:
    """The translation 1 + ½εv by a vector v, shape (..., 3), in units of length.

    Raises
    ------
    ValueError
        If a vector is not real, or a single one not finite; in a batch such rows become NaN.

    Examples
    --------
    >>> translation([0, 4, 0])
    1 + 2 εj
    """
    half = divide(as_vectors(v), 2)
    components = np.zeros((8, *half.shape[:-1]), dtype=half.dtype)
    components[0], components[5:] = 1, np.moveaxis(half, -1, 0)
    if half.dtype.kind == "f":
        components[:5, np.isnan(half[..., 0])] = np.nan
    return wrap(components)


def half_turn(line: Line) -> DualQuaternion:
    """The half-turn l + εm about a line; a unit dual quaternion if the direction has length 1."""
    if not isinstance(line, Line):
        raise TypeError(f"expected a Line, got {type(line).__name__}: Line.at(point, direction) makes one")
    return line.as_dual_quaternion()


def rotation(line: Line, angle: ScalarLike | Array) -> DualQuaternion:
    """The rotation cos(½ angle) + sin(½ angle) h about a line, with h the unit half-turn about it.

    Parameters
    ----------
    line : Line
        The axis; its orientation gives the sense of the rotation.
    angle : float, array or SymPy expression
        In radians, counter-clockwise when the axis points at the viewer.  An expression keeps an exact line
        exact; with any other angle the result is in floats, since sine and cosine leave the rational numbers.

    Raises
    ------
    ValueError
        If an angle is not real, or a single one not finite; in a batch such rows become NaN.

    Examples
    --------
    >>> import sympy
    >>> rotation(Line([0, 0, 1], [0, 0, 0]), sympy.pi / 3)
    sqrt(3)/2 + 1/2 k
    """
    h = half_turn(line)
    if hasattr(angle, "free_symbols") and hasattr(plain(angle), "free_symbols"):
        from sympy import cos, sin, sqrt, sympify

        half = sympify(angle) / 2
        return h / sqrt(sympify(null_form(h, h))) * sin(half) + cos(half)
    half = _angles(angle) / 2
    return unit(h.astype(float)) * np.sin(half) + np.cos(half)


def _angles(angle: Any) -> np.ndarray:
    angles = np.array(as_float(as_scalars(angle)))
    if angles.dtype.kind == "c":
        raise ValueError("expected real angles, got complex numbers")
    return finite_rows(angles, "angles", core=0)[()]


def unit(q: DualQuaternion) -> DualQuaternion:
    """The same point of P⁷ with primal part of length 1, where that root can be taken.

    Exact coefficients are left as they are if the square of the length is not the square of a fraction.

    Raises
    ------
    DegenerateError
        If the primal part vanishes; rows of a batch of floats become NaN instead.

    Examples
    --------
    >>> unit(3 * i + 4 * j), unit(i + j)
    (3/5 i + 4/5 j, i + j)
    """
    square = null_form(as_dual_quaternion(q), q)
    zero = np.asarray(is_zero(square, rtol=0))
    if not is_exact(q.components) and q.shape:
        return q / np.sqrt(np.where(zero, np.nan, square) if zero.any() else square)
    _refuse(zero, EXCEPTIONAL, "raise")
    if not is_exact(q.components):
        return q / np.sqrt(square)
    return q / np.frompyfunc(_rational_root, 1, 1)(square)


def axis_of(h: PoseLike, *, degenerate: Degenerate = "raise") -> DualQuaternion:
    """The half-turn about the axis of a rotation; what rounding has added to a line is taken away.

    Parameters
    ----------
    h : DualQuaternion of shape (...), matrices of shape (..., 4, 4), or RigidTransform
    degenerate : {"raise", "nan"}
        What becomes of rows without an axis.

    Raises
    ------
    DegenerateError
        If there is no axis: for the identity and for translations.

    Examples
    --------
    >>> axis_of(3 + 2 * (j - eps * i))
    j - εi
    """
    check_degenerate(degenerate)
    components = displacement(h).components.copy()
    components[[0, 4]] = 0
    v = wrap(components)
    lost = np.asarray(_refuse(is_zero(null_form(v, v), rtol=0), NO_AXIS, degenerate))
    if lost.any():
        v = DualQuaternion(np.where(lost[..., None], np.nan, as_float(v.coeffs)))
    return unit(v - eps_times(v) * divide(study_form(v, v), 2 * null_form(v, v)))


NO_AXIS = "the primal part is a number: the identity and translations have no axis"


def _rational_root(square: Any) -> Any:
    """The root of an exact number if it lies in the same field, else 1."""
    try:
        root = square_root(square)
    except (TypeError, ValueError):
        return 1
    return root if type(root) in (type(divide(square, 1)), type(square)) else 1


def _matrix_formula(q: Any) -> tuple[Any, Any]:
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


def _turned(turn: Any, x: Any) -> tuple[Any, ...]:
    x1, x2, x3 = x
    return tuple(a * x1 + b * x2 + c * x3 for a, b, c in turn)


def _point_formula(q: Any, x: Any) -> tuple[Any, ...]:
    turn, shift = _matrix_formula(q)
    return tuple(y + t for y, t in zip(_turned(turn, x), shift, strict=True))


def _line_formula(q: Any, l: Any, m: Any) -> tuple[Any, ...]:
    """The direction turns; the moment turns and gains shift × (turned direction)."""
    turn, (t1, t2, t3) = _matrix_formula(q)
    l1, l2, l3 = _turned(turn, l)
    m1, m2, m3 = _turned(turn, m)
    return l1, l2, l3, m1 + (t2 * l3 - t3 * l2), m2 + (t3 * l1 - t1 * l3), m3 + (t1 * l2 - t2 * l1)


def act(q: PoseLike, x: PointLike | Line, *, degenerate: Degenerate = "raise") -> Any:
    """Move points or lines by the displacement [q], equation (1).

    Parameters
    ----------
    q : DualQuaternion of shape (...), matrices of shape (..., 4, 4), or RigidTransform
        On the Study quadric, off the exceptional space.
    x : array_like, shape (..., 3), or Line
        Points, or lines; batches broadcast.
    degenerate : {"raise", "nan"}
        What becomes of rows in the exceptional space.

    Returns
    -------
    numpy.ndarray, shape (..., 3), or Line
        Where a row of a batch has NaN or infinity, NaN.

    Raises
    ------
    ValueError
        If the points or the displacements are not real, or single ones not finite.
    DegenerateError
        If q lies in the exceptional space.

    Examples
    --------
    >>> act(translation([0, 0, 2]), [1, 1, 1]).tolist()
    [Fraction(1, 1), Fraction(1, 1), Fraction(3, 1)]
    >>> act(k, Line([1, 0, 0], [0, 1, 0])).direction.tolist()
    [Fraction(-1, 1), Fraction(0, 1), Fraction(0, 1)]
    """
    if isinstance(x, Line):
        l, m = (np.moveaxis(part, -1, 0) for part in (x.direction, x.moment))
        return wrap_line(np.moveaxis(blockwise(_line_formula, _divisible(q, degenerate), l, m, rows=6), 0, -1))
    components = np.moveaxis(as_vectors(x, "points"), -1, 0)
    return np.moveaxis(blockwise(_point_formula, _divisible(q, degenerate), components, rows=3), 0, -1)


def _divisible(q: PoseLike, degenerate: Degenerate) -> np.ndarray:
    """Components of a pose, whose primal part must not vanish; whole numbers as fractions."""
    check_degenerate(degenerate)
    q = displacement(q)
    if q.components.dtype.kind == "c":
        raise ValueError("expected a real displacement, got complex coefficients: it moves points out of real space")
    zero = is_zero(null_form(q, q), rtol=0)
    if zero is not False and np.any(_refuse(zero, EXCEPTIONAL, degenerate)):
        q = DualQuaternion(np.where(np.asarray(zero)[..., None], np.nan, as_float(q.coeffs)))
    if q.components.dtype.kind != "f":
        return divide(q.components, 1)
    if np.isfinite(q.components).all():
        return q.components
    return np.moveaxis(finite_rows(np.array(q), "displacements"), -1, 0)


EXCEPTIONAL = "the point lies in the exceptional three-space (primal part zero): it moves nothing"


def _refuse(where: Any, message: str, degenerate: Degenerate) -> Any:
    """Raise an error about rows, or say again where they are."""
    if degenerate == "raise" and np.any(where):
        rows = rows_where(where)
        raise DegenerateError(named_rows(rows) + message, rows=rows)
    return where


def displacement(x: PoseLike) -> DualQuaternion:
    """A displacement given as dual quaternion, 4×4 matrix or SciPy ``RigidTransform``, as a dual quaternion.

    It is not checked whether it is on the Study quadric.
    """
    if isinstance(x, DualQuaternion):
        return x
    if isinstance(x, RigidTransformLike):
        return from_rigid_transform(x)
    if not isinstance(x, (np.ndarray, list, tuple)):
        raise TypeError(
            f"expected a displacement (a DualQuaternion, a 4×4 matrix or a RigidTransform), got {type(x).__name__}"
        )
    return from_matrix(x)


def as_matrix(q: PoseLike, *, degenerate: Degenerate = "raise") -> Array:
    """The homogeneous 4×4 matrix of the displacement [q], shape (..., 4, 4); rational in q.

    Examples
    --------
    >>> (as_matrix(translation([1, 2, 3])) == [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]).all()
    np.True_
    """
    q = wrap(_divisible(q, degenerate))
    turned = act(q.primal[..., None], np.eye(3, dtype=int))
    matrix = np.zeros((*q.shape, 4, 4), dtype=turned.dtype)
    matrix[..., :3, :3] = np.swapaxes(turned, -1, -2)
    matrix[..., :3, 3] = act(q, [0, 0, 0])
    matrix[..., 3, 3] = 1
    return matrix


def from_matrix(matrix: MatrixLike, *, rtol: float = RTOL, degenerate: Degenerate = "raise") -> DualQuaternion:
    """The point of the Study quadric for homogeneous matrices of displacements, shape (..., 4, 4).

    No root is taken for exact matrices; the primal part has length 1 for floats.  A float matrix that is accepted,
    but rounded, gives the nearest rotation; the result is in double precision.

    Parameters
    ----------
    matrix : array_like, shape (..., 4, 4)
    rtol : float
        How far the entries of floats may be off those of a rotation: 1e-6 for numbers that were printed with six
        decimals.  Matrices in single precision are judged by their own precision.
    degenerate : {"raise", "nan"}
        What becomes of the rows of a batch that are no displacements.  Rows with NaN stay rows of NaN.

    Raises
    ------
    ValueError
        If the upper left block is no rotation or the last row is not (0, 0, 0, 1); if a matrix is not real, or a
        single one not finite.

    Examples
    --------
    >>> from_matrix([[1, 0, 0, 2], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]])
    i - ε
    """
    check_degenerate(degenerate)
    matrix = as_scalars(matrix)
    if matrix.shape[-2:] != (4, 4):
        raise ValueError(f"expected matrices of shape (..., 4, 4), got {matrix.shape}")
    if matrix.dtype.kind == "c":
        raise ValueError("expected a real matrix, got complex numbers")
    matrix = finite_rows(matrix, "matrices", core=2)
    rtol = own_precision(matrix, rtol)
    if matrix.dtype.kind == "f":
        matrix = matrix.astype(float)
    bad = _no_displacement(matrix, rtol, degenerate)
    if np.any(bad):
        matrix = np.where(bad[..., None, None], np.nan, as_float(matrix))
    R = matrix[..., :3, :3] if is_exact(matrix) else _nearest_rotation(matrix[..., :3, :3])
    outer = _outer_square(R)
    diagonal = np.diagonal(outer, axis1=-2, axis2=-1)
    best = np.argmax(diagonal, axis=-1)[..., None, None]
    primal = np.take_along_axis(outer, best, axis=-2)[..., 0, :]
    p = unit(DualQuaternion(np.concatenate([primal, np.zeros_like(primal)], axis=-1)))
    return _shifted(matrix[..., :3, 3], p)


def _shifted(v: np.ndarray, p: DualQuaternion) -> DualQuaternion:
    """The translation by v after the rotation p."""
    half = np.moveaxis(divide(v, 2), -1, 0)
    zero = np.zeros_like(half[:1])
    return p + wrap(np.concatenate([zero, zero, zero, zero, zero, half])) * p


def _no_displacement(matrix: np.ndarray, rtol: float, degenerate: Degenerate) -> np.ndarray:
    """Where a matrix is no displacement; an error about it, unless NaN is asked for."""
    R, last = matrix[..., :3, :3], matrix[..., 3, :] - np.array([0, 0, 0, 1])
    difference = R @ np.swapaxes(R, -1, -2) - np.eye(3, dtype=int)
    turns = np.asarray((np.cross(R[..., 0], R[..., 1]) * R[..., 2]).sum(-1))
    lost = _is_nan(matrix)
    skew = ~np.all(is_zero(difference, rtol=10 * rtol), axis=(-1, -2)) & ~lost
    bad = np.asarray(skew | (turns < 0) & ~lost), ~np.asarray(np.all(is_zero(last, rtol=rtol), axis=-1) | lost)
    if degenerate == "raise" and np.any(bad[0]):
        raise ValueError(named_rows(rows_where(bad[0])) + _no_rotation(difference[bad[0]], turns[bad[0]], rtol))
    if degenerate == "raise" and np.any(bad[1]):
        raise ValueError(f"{named_rows(rows_where(bad[1]))}expected the last row (0, 0, 0, 1) of a displacement")
    return bad[0] | bad[1]


def _is_nan(matrix: np.ndarray) -> Any:
    return np.isnan(matrix[..., 0, 0]) if matrix.dtype.kind == "f" else np.zeros(matrix.shape[:-2], dtype=bool)


def _no_rotation(difference: np.ndarray, turns: np.ndarray, rtol: float) -> str:
    """What is wrong with the upper left block R, from R Rᵀ − 1 and the determinant."""
    off = float(np.abs(as_float(difference)).max(initial=0))
    text = "expected a rotation in the upper left block R: an orthogonal matrix of determinant 1; "
    if off < 0.1 and np.any(turns < 0):
        return text + "here the determinant is -1, a reflection"
    text += f"here R Rᵀ is off 1 by {off:.2g}"
    if off > 1e-2 or is_exact(difference):
        return text
    return f"{text}, more than 10 rtol = {10 * rtol:.0e}; if that is rounding, give rtol={_rounded_up(off / 10)}"


def _rounded_up(x: float) -> str:
    """The next number with one digit."""
    power = 10.0 ** math.floor(math.log10(x))
    return f"{math.ceil(x / power) * power:.0e}"


def _nearest_rotation(R: np.ndarray) -> np.ndarray:
    """The orthogonal factor of the polar decomposition, by Newton's iteration R ← ½(R + R⁻ᵀ); rotations stay."""
    for _ in range(4):
        off = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(axis=(-1, -2), keepdims=True)
        if not np.any(off > ROUNDING):
            break
        x, y, z = np.moveaxis(R, -2, 0)
        cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=-2)
        determinant = (x * cofactors[..., 0, :]).sum(-1)[..., None, None]
        R = np.where(off > ROUNDING, (R + cofactors / determinant) / 2, R)
    return R


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


def from_rigid_transform(transform: RigidTransformLike) -> DualQuaternion:
    """The pose of a SciPy ``RigidTransform``, single or batch."""
    if not isinstance(transform, RigidTransformLike):
        raise TypeError(f"expected a RigidTransform of SciPy, got {type(transform).__name__}")
    return from_matrix(transform.as_matrix())


def as_rigid_transform(q: PoseLike) -> Any:
    """The displacement [q] as a SciPy ``RigidTransform`` (floats; needs SciPy)."""
    from scipy.spatial.transform import RigidTransform

    return RigidTransform.from_matrix(as_float(as_matrix(q)))
