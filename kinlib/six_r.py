"""Overconstrained 6R linkages through four poses (Hegedüs, Schicho & Schröcker 2014)."""

from __future__ import annotations

from functools import reduce
from itertools import combinations, permutations
from operator import mul

import numpy as np

from kinlib.cubics import MET, CubicFamilies, CubicFault, CubicRows, families_of
from kinlib.dual_quaternion import DualQuaternion, eps_times, null_form, study_form
from kinlib.errors import first_fault
from kinlib.factorization import NO_INVERSE, FactorFault, divided_off, factored, split_motion
from kinlib.interpolation import Families
from kinlib.linkage import Linkage, verified_loop
from kinlib.polishing import polished_at
from kinlib.poses import opening
from kinlib.rows import replaced
from kinlib.scalar import divide
from kinlib.typing import Array, ArrayLike, Degenerate, PoseLike, ScalarLike

__all__ = ["ADMISSIBLE_PAIRS", "six_r_linkages"]

ORDERS = tuple(permutations(range(3)))

ADMISSIBLE_PAIRS = tuple(
    (m, n) for m, n in combinations(range(6), 2) if ORDERS[m][0] != ORDERS[n][0] and ORDERS[m][2] != ORDERS[n][2]
)
"""The nine pairs of factorizations, by number, with different first and different last quadratic factors."""

BLOCK = 2048
"""So many cubics are factored at a time: their numbers stay in the cache."""

POLISH = 1e-11
"""Linkages that miss a pose by more than this are polished."""

FAR_OFF = 1e-4
"""Only factors that miss a pose by more than this are blamed on the cubic instead of on rounding."""

FACTOR_FAULTS = {
    FactorFault.REAL_ROOT: CubicFault.REAL_ROOT,
    FactorFault.REAL_FACTOR: CubicFault.UNSPLIT,
    FactorFault.UNSPLIT: CubicFault.UNSPLIT,
}


def six_r_linkages(
    p0: PoseLike,
    p1: PoseLike,
    p2: PoseLike,
    p3: PoseLike,
    free: ScalarLike | ArrayLike = 0,
    *,
    degenerate: Degenerate = "raise",
) -> Families[Linkage]:
    """The 6R linkages whose couplers visit four poses: nine for each real family of cubics.

    Parameters
    ----------
    p0, p1, p2, p3 : DualQuaternion, 4×4 matrix or RigidTransform
        Four poses in general position; batches broadcast.
    free : scalar or array_like
        The position in the family, see :func:`~kinlib.cubics_through`.
    degenerate : {"raise", "nan"}
        What becomes of rows of a batch without linkages.  An error names them; with NaN all eighteen are returned
        in any case, and NaN stands where there is none.

    Returns
    -------
    Families of Linkage
        Nine for the first family, then nine for the second.  Where only one family can be built these are nine, and
        ``.missing`` says what is wrong with the other.  Each linkage passes the poses to 1e-9, about the middle of
        their displacements and in the length of the problem.

    Raises
    ------
    DegenerateError
        If no family is real, or the poses are not in general position.
    ValueError
        If exact poses need a number field that is too large to be of use: convert them to floats.

    Examples
    --------
    >>> from kinlib.gallery import FOUR_POSES
    >>> linkages = six_r_linkages(*(pose.astype(float) for pose in FOUR_POSES))
    >>> len(linkages), linkages[0].mobility()
    (18, 1)
    """
    families, factors = _factored(families_of(p0, p1, p2, p3, free, degenerate))
    kept, missing = families.judged(degenerate)
    factors = [families.outward(h) for h in factors]
    linkages = [linkage for n in kept for linkage in _linkages(families, factors, n)]
    return Families(linkages, tuple(families.parameters(n) for n in kept), missing)


def _factored(families: CubicFamilies) -> tuple[CubicFamilies, list[DualQuaternion]]:
    """The six factorizations of each cubic, shape (rows, 6), and the families that are left."""
    rows = families.rows
    if rows.is_exact:
        factors, faults = factored(rows.cubics(), ORDERS)
        return families.less(_as_cubic_faults(faults), 0), factors
    blocks = [rows.some(slice(n, n + BLOCK)) for n in range(0, max(len(rows.t3), 1), BLOCK)]
    found, faulty, missed = zip(*map(_factored_block, blocks), strict=True)
    whole = [DualQuaternion(np.concatenate([h.coeffs for h in parts])) for parts in zip(*found, strict=True)]
    return families.less(np.concatenate(faulty), np.concatenate(missed)), whole


def _factored_block(rows: CubicRows) -> tuple[list[DualQuaternion], Array, Array]:
    """The factors, what is wrong with them, and by how much they miss a pose; floats."""
    with np.errstate(all="ignore"):
        centre, unit = rows.centre_and_unit()
        C = rows.cubics(centre, unit)
        quadratics, real = split_motion(C)
        factors, least = divided_off(C, quadratics, ORDERS)
        factors = [_on_quadric(h * unit[:, None] + centre[:, None]) for h in factors]
        factors, missed = _repaired(rows, factors)
    lost = ~(missed <= MET)
    faults = first_fault(
        (real, CubicFault.REAL_ROOT),
        (lost & ~(missed < FAR_OFF) & (least <= NO_INVERSE).any(axis=-1), CubicFault.UNSPLIT),
        (lost, CubicFault.LOST),
    )
    return factors, faults, missed


def _repaired(rows: CubicRows, factors: list[DualQuaternion]) -> tuple[list[DualQuaternion], Array]:
    """The factors, or better ones in rows where they miss a pose; and by how much these still do."""
    missed = _missed(rows, factors)
    poor = np.flatnonzero((missed > POLISH) & (missed < 1))
    if not len(poor):
        return factors, missed
    part = rows.some(poor)
    values = [DualQuaternion(v.coeffs[:, None] * np.ones((6, 1))) for v in part.values_at_poses()]
    better = polished_at(part.parameters.T[..., None], values, [h[poor] for h in factors])
    better = [_on_quadric(h) for h in better]
    off = _missed(part, better)
    gain = off < missed[poor]
    missed = missed.copy()
    missed[poor[gain]] = off[gain]
    return [replaced(h, (poor[gain],), new[gain]) for h, new in zip(factors, better, strict=True)], missed


def _missed(rows: CubicRows, factors: list[DualQuaternion]) -> Array:
    """How far factorizations are from the poses, and from each other where a joint turns fastest, at t = Re h."""
    turning = np.stack([h.scalar_part[:, 0] for h in factors], axis=-1)
    values = _product_at(factors, turning)
    apart = opening(values[:, :1], values).max(axis=(1, 2))
    return np.maximum(rows.missed(_product_at(factors, rows.parameters)), apart)


def _as_cubic_faults(faults: Array) -> Array:
    return np.select([faults == fault for fault in FACTOR_FAULTS], list(FACTOR_FAULTS.values()), 0)


def _product_at(factors: list[DualQuaternion], t: Array) -> DualQuaternion:
    """(t − h_1)(t − h_2)(t − h_3), shape (rows, 6, 3), with three parameters for each row."""
    return reduce(mul, [_linear_factor_at(h, t) for h in factors])


def _linear_factor_at(h: DualQuaternion, t: Array) -> DualQuaternion:
    components = np.repeat(-h.components[..., None], 3, axis=-1)
    components[0] += t[:, None, :]
    return DualQuaternion.from_components(components)


def _on_quadric(h: DualQuaternion) -> DualQuaternion:
    """A real number and a half-turn: what rounding has added to them is taken away."""
    components = h.components.copy()
    components[[0, 4]] = 0
    v = DualQuaternion.from_components(components)
    return v - eps_times(v) * divide(study_form(v, v), 2 * null_form(v, v)) + h.scalar_part


def _linkages(families: CubicFamilies, factors: list[DualQuaternion], family: int) -> list[Linkage]:
    """The nine linkages of one family: all six chains are known to have the cubic as their product."""
    chains = families.spread_all(factors, family)
    home, parameters = families.problem.home, families.parameters(family)
    return [verified_loop(chains[m], chains[n], home=home, parameters=parameters) for m, n in ADMISSIBLE_PAIRS]
