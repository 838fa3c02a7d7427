"""The assignment on the algebra: each student has two dual quaternions with whole coefficients."""

from __future__ import annotations

from typing import NamedTuple

from kinlib import DualQuaternion
from kinlib_assignments.checks import assert_equal
from kinlib_assignments.lot import Lot

__all__ = ["Data", "assert_norm", "assert_product", "data"]


class Data(NamedTuple):
    """Two dual quaternions, as tuples of eight whole numbers."""

    q: tuple[int, ...]
    r: tuple[int, ...]


def data(student: str) -> Data:
    """Two dual quaternions that don't commute; no coefficient is zero, so that no slip goes unseen.

    Examples
    --------
    >>> data("ada").q
    (4, 4, 5, -1, -3, -2, 1, -1)
    """
    lot = Lot("dual_quaternions", student)
    return lot.until(lambda: Data(_coefficients(lot), _coefficients(lot)), _is_telling)


def _coefficients(lot: Lot) -> tuple[int, ...]:
    return tuple(lot.choice((-1, 1)) * lot.whole(1, 5) for _ in range(8))


def _is_telling(found: Data) -> bool:
    """Whether the products that slips give are all different, and the norms are no real numbers."""
    q, r = map(DualQuaternion, found)
    values = [q * r, *_wrong_products(q, r).values()]
    different = all(a != b for n, a in enumerate(values) for b in values[:n])
    return different and q.norm() != q.norm().eps_conjugate() and r.norm() != r.norm().eps_conjugate()


def _wrong_products(q: DualQuaternion, r: DualQuaternion) -> dict[str, DualQuaternion]:
    """What slips make of the product of two dual quaternions."""
    crossed = (q.dual * r.primal - q.primal * r.dual).coeffs[:4]
    primal = (q.primal * r.primal).coeffs[:4]
    return {
        "the factors are in the wrong order": r * q,
        "the dual part has the wrong sign": (q * r).eps_conjugate(),
        "the dual part lacks one of its two products": q * r.primal,
        "the dual part lacks one of its two products, p of the first with d of the second is there": q.primal * r,
        "the two products in the dual part must be added": DualQuaternion([*primal, *crossed]),
        "ε² is 0, not 1": q * r + q.dual * r.dual,
        "ε² is 0, not −1": q * r - q.dual * r.dual,
    }


def assert_product(answer, q, r) -> None:
    """Fail unless the answer is q r; say which slip it looks like."""
    q, r = DualQuaternion(q), DualQuaternion(r)
    assert_equal(answer, q * r, "the product", _wrong_products(q, r))


def assert_norm(answer, q) -> None:
    """Fail unless the answer holds the two coefficients a and b of q q̄ = a + εb; say which slip it looks like."""
    q = DualQuaternion(q)
    a, b = q.norm().coeffs[[0, 4]]
    square = (q * q).coeffs[[0, 4]]
    slips = {
        "b is twice as large: p d̄ and d p̄ both count": (a, b / 2),
        "b has the wrong sign": (a, -b),
        "that is q², the conjugate is missing": square,
        "the dual part d d̄ does not count, since ε² = 0": (a + (q.dual * q.dual.conjugate()).scalar_part, b),
    }
    assert_equal(answer, (a, b), "the norm", slips)
