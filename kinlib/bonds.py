"""Bonds of a rational loop: which joints share a quadratic polynomial, and the degrees that follow.

The product of all factors t − f around a loop is a real polynomial R, so R² is the product of the quadratics
(t − f)(t − f̄), and each of these belongs to an even number of factors.  At its complex roots the factors are
singular: there the motion has its bonds (Hegedüs, Schicho & Schröcker 2013).  If just two factors have a quadratic,
their joints are bonded.  If more have it, the bonds are the connection numbers, which follow from the degrees there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from kinlib.dual_quaternion import DualQuaternion
from kinlib.factorization import divide_by_quadratic, quadratic_of
from kinlib.loop import Loop
from kinlib.polishing import product_of
from kinlib.scalar import as_float, is_exact, is_zero
from kinlib.typing import Array

__all__ = ["Bond", "bonds_of", "bonds_of_loop", "degrees_of"]

SHARED = 1e-6
"""How far the quadratics of two factors in floats may differ, relative to their size."""


class Bond(NamedTuple):
    """Two joints that are bonded, and where: at the complex roots of a real quadratic polynomial.

    Attributes
    ----------
    joints : pair of int
        The numbers of the joints, from 0.
    quadratic : array, shape (..., 3)
        The polynomial t² + bt + c, highest power first.

    Examples
    --------
    >>> bond = Bond((0, 2), np.array([1, 0, 1]))
    >>> [bond.is_cut(0, link) for link in range(4)]      # joint 1, counted from 1, is between links 0 and 1
    [False, True, True, False]
    """

    joints: tuple[int, int]
    quadratic: Array

    def is_cut(self, a: int, b: int) -> bool:
        """Whether both ways from link a to link b pass one of the two joints; link n is before joint n, from 0."""
        a, b = sorted((a, b))
        return sum(a <= joint < b for joint in self.joints) == 1


def bonds_of(factors: Sequence[DualQuaternion], joints: Sequence[int]) -> tuple[Bond, ...]:
    """The bonds of a closed loop of linear factors, in the order of their joints.

    Parameters
    ----------
    factors : sequence of DualQuaternion
        The f of all factors t − f of a single linkage, in loop order.
    joints : sequence of int
        How many consecutive factors each joint has.

    Raises
    ------
    ValueError
        If a quadratic belongs to an odd number of factors: in floats, if quadratics are so near that they can not
        be told apart.
    """
    joint_of = [joint for joint, count in enumerate(joints) for _ in range(count)]
    found = []
    for group in _groups([quadratic_of(f) for f in factors]):
        if len(group) % 2:
            raise ValueError("expected factors that share their quadratics in pairs: is the loop closed?")
        for m, n in [tuple(group)] if len(group) == 2 else _connected(factors, group):
            found.append(Bond((joint_of[m], joint_of[n]), quadratic_of(factors[m])))
    return tuple(sorted(found, key=lambda bond: bond.joints))


def bonds_of_loop(loop: Loop) -> tuple[Bond, ...]:
    """The bonds of a loop; of a batch whose rows are bonded alike, with polynomials of its shape."""
    rows = [
        bonds_of(row.factors, row.joints)
        for row, undefined in zip(loop.rows(), loop.undefined.reshape(-1), strict=True)
        if not undefined
    ]
    if any([bond.joints for bond in row] != [bond.joints for bond in rows[0]] for row in rows):
        raise ValueError("the rows of the batch have different bonds: ask each row, or rows that are alike")
    return rows[0] if rows and not loop.shape else _stacked(rows, loop.shape, ~loop.undefined)


def _stacked(rows: Sequence[tuple[Bond, ...]], shape: tuple[int, ...], defined: Array) -> tuple[Bond, ...]:
    """The bonds of a batch, with NaN in NaN rows."""
    stacked = []
    for bonds in zip(*rows, strict=True):
        dtype = bonds[0].quadratic.dtype if defined.all() else float
        quadratic = np.full((*shape, 3), np.nan, dtype=dtype)
        quadratic[defined] = [bond.quadratic for bond in bonds]
        stacked.append(Bond(bonds[0].joints, quadratic))
    return tuple(stacked)


def degrees_of(bonds: Sequence[Bond], count: int) -> Array:
    """The degrees of all relative motions of so many links: how many bonds are cut; shape (n, n), whole numbers.

    Examples
    --------
    >>> degrees_of([Bond((0, 2), np.array([1, 0, 1])), Bond((1, 3), np.array([1, 0, 4]))], 4).tolist()
    [[0, 1, 2, 1], [1, 0, 1, 2], [2, 1, 0, 1], [1, 2, 1, 0]]
    """
    return np.array([[sum(bond.is_cut(a, b) for bond in bonds) for b in range(count)] for a in range(count)])


def _groups(quadratics: Sequence[Array]) -> list[list[int]]:
    """The numbers of the factors with one quadratic."""
    if all(is_exact(M) for M in quadratics):
        return _joined(len(quadratics), lambda m, n: bool(np.all(is_zero(quadratics[m] - quadratics[n]))))
    roots = [_root(as_float(M)) for M in quadratics]
    size = max(abs(p - q) for p, q in combinations([r for z in roots for r in (z, z.conjugate())], 2))
    return _joined(len(roots), lambda m, n: abs(roots[m] - roots[n]) <= SHARED * size)


def _root(M: Array) -> complex:
    """The root with positive imaginary part."""
    half = M[1] / 2
    return complex(-half, np.sqrt(max(M[2] - half * half, 0.0)))


def _joined(count: int, same: Any) -> list[list[int]]:
    groups: list[list[int]] = []
    for n in range(count):
        home = next((group for group in groups if same(group[0], n)), None)
        if home is None:
            groups.append([n])
        else:
            home.append(n)
    return groups


def _connected(factors: Sequence[DualQuaternion], group: Sequence[int]) -> list[tuple[int, int]]:
    """The bonds among factors that all have one quadratic, as often as they are bonded.

    With d(a, b) the degree that is left there between links a and b, factors m and n are bonded
    ½ (d(m, n) + d(m + 1, n + 1) − d(m + 1, n) − d(m, n + 1)) times, link m before factor m.
    """
    count = len(group)
    d = np.zeros((count + 1, count + 1), dtype=int)
    for a, b in combinations(range(count + 1), 2):
        if b - a < count:
            stretch = range(group[a], group[b - 1] + 1)
            d[a, b] = d[b, a] = b - a - 2 * _power([factors[n] for n in stretch], quadratic_of(factors[group[0]]))
    d[0, count] = d[count, 0] = 0
    pairs = []
    for m, n in combinations(range(count), 2):
        number = (d[m, n] + d[m + 1, n + 1] - d[m + 1, n] - d[m, n + 1]) // 2
        pairs += [(group[m], group[n])] * int(number)
    return pairs


def _power(factors: Sequence[DualQuaternion], M: Array) -> int:
    """How often a quadratic divides a product of linear factors."""
    coefficients, power = product_of(factors), 0
    while len(coefficients) > 2:
        quotient, remainder = divide_by_quadratic(coefficients, M)
        scale = max(float(np.abs(as_float(c.components)).max()) for c in coefficients)
        if not all(np.all(is_zero(r.components, scale, SHARED)) for r in remainder):
            break
        coefficients, power = quotient, power + 1
    return power
