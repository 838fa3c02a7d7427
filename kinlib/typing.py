"""What the functions of kinlib take and give, each kind of argument named once."""

from __future__ import annotations

from typing import Any, Literal, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from kinlib.dual_quaternion import DualQuaternion
from kinlib.scalar import ArrayLike, ScalarLike, Scalars

__all__ = [
    "Array",
    "ArrayLike",
    "Degenerate",
    "DualQuaternionLike",
    "HomogeneousLike",
    "MatrixLike",
    "PointLike",
    "PoseLike",
    "RigidTransformLike",
    "ScalarLike",
    "Scalars",
    "VectorLike",
    "ZLike",
]


@runtime_checkable
class RigidTransformLike(Protocol):
    """A displacement of another library, such as SciPy's ``RigidTransform``: it gives its homogeneous 4×4 matrix."""

    def as_matrix(self) -> np.ndarray:
        """The homogeneous matrix, shape (..., 4, 4)."""


Array: TypeAlias = NDArray[Any]
"""An array of scalars of any kind: dtype float or complex, or object for exact numbers."""

PointLike: TypeAlias = ArrayLike
"""Points of space, shape (..., 3), in units of length."""

VectorLike: TypeAlias = ArrayLike
"""Vectors of space, shape (..., 3)."""

MatrixLike: TypeAlias = ArrayLike
"""A matrix, or a batch of matrices, shape (..., m, n)."""

DualQuaternionLike: TypeAlias = DualQuaternion | ArrayLike
"""A dual quaternion, or its coefficients (p0, p1, p2, p3, d0, d1, d2, d3), shape (..., 8)."""

HomogeneousLike: TypeAlias = DualQuaternion | ArrayLike
"""Points of projective space by homogeneous coordinates, shape (..., n+1); dual quaternions are points of P⁷."""

PoseLike: TypeAlias = DualQuaternion | RigidTransformLike | ArrayLike
"""Poses: dual quaternions on the Study quadric, homogeneous matrices of shape (..., 4, 4), or SciPy's
``RigidTransform``; single or a batch."""

ZLike: TypeAlias = ArrayLike
"""Points of the plane of z: complex numbers, single or in an array, or a pair (x, y) of real numbers or arrays, which
keeps exact numbers exact."""

Degenerate: TypeAlias = Literal["raise", "nan"]
"""What becomes of the rows of a batch that leave the answer undetermined: an error that names them, or NaN."""
