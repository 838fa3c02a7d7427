"""The assignment on dual quaternions: who is right gets the points, who is wrong loses those of the slip."""

import pytest

from kinlib import DualQuaternion
from kinlib_assignments import dual_quaternions as exercise
from marks import Marks

ALL_PRODUCTS = {"product-of-yours": 1, "product-for-all": 2}
NORMS = {"norm-of-all": 2, "inverse-exact": 2}

SUM = "[x + y for x, y in zip(first, second, strict=True)]"

SLIPS = {
    "the quaternions are multiplied in the wrong order": (
        {"quaternion_product": ("def quaternion_product(a, b):", "def quaternion_product(b, a):")},
        {"quaternion-product": 2, **ALL_PRODUCTS, "moved-point": 2},
        "the factors are in the wrong order: i j = k, but j i = −k",
    ),
    "i² = 1": (
        {"quaternion_product": ("a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3", "a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3")},
        {
            "quaternion-product": 2, **ALL_PRODUCTS, "norm-of-all": 2, "norm-law": 2, "inverse-exact": 2,
            "moved-point": 2,
        },
        "the squares of the units have the wrong sign",
    ),
    "the dual factors are in the wrong order": (
        {"product": ("def product(q, r):", "def product(r, q):")},
        {**ALL_PRODUCTS, "moved-point": 2},
        "the factors are in the wrong order",
    ),
    "one of the two dual products is missing": (
        {"product": (SUM, "first")},
        {**ALL_PRODUCTS, "norm-of-all": 2, "reversal-law": 2, "norm-law": 2, "inverse-exact": 2, "moved-point": 2},
        "the dual part lacks one of its two products, p of the first with d of the second is there",
    ),
    "the other of the two dual products is missing": (
        {"product": (SUM, "second")},
        {**ALL_PRODUCTS, "norm-of-all": 2, "reversal-law": 2, "norm-law": 2, "inverse-exact": 2, "moved-point": 2},
        "the dual part lacks one of its two products, d of the first with p of the second is there",
    ),
    "ε² = 1": (
        {"product": ("    return quaternion_product(q[:4], r[:4]) +",
                     "    primal, dual = quaternion_product(q[:4], r[:4]), quaternion_product(q[4:], r[4:])\n"
                     "    return [x + y for x, y in zip(primal, dual)] +")},
        {**ALL_PRODUCTS, "norm-of-all": 2, "norm-law": 2, "inverse-exact": 2, "inverse-missing": 1, "moved-point": 2},
        "ε² is 0, not 1",
    ),
    "the dual products are subtracted": (
        {"product": ("x + y for", "x - y for")},
        {**ALL_PRODUCTS, "norm-of-all": 2, "reversal-law": 2, "inverse-exact": 2, "moved-point": 2},
        "the two products in the dual part must be added, not subtracted",
    ),
    "the conjugate changes the sign of ε": (
        {"conjugate": ("q[4], -q[5], -q[6], -q[7]", "-q[4], q[5], q[6], q[7]")},
        {"conjugate-of-all": 1, **NORMS, "moved-point": 2},
        "the sign of ε stays",
    ),
    "the conjugate stops at the primal part": (
        {"conjugate": ("q[4], -q[5], -q[6], -q[7]", "*q[4:]")},
        {"conjugate-of-all": 1, **NORMS, "reversal-law": 2, "norm-law": 2, "moved-point": 2},
        "the signs of i, j, k in the dual part change too",
    ),
    "all signs of the dual part change": (
        {"conjugate": ("q[4], -q[5], -q[6], -q[7]", "-q[4], -q[5], -q[6], -q[7]")},
        {"conjugate-of-all": 1, **NORMS, "reversal-law": 2, "norm-law": 2, "moved-point": 2},
        "d0 keeps its sign",
    ),
    "b of the norm is halved": (
        {"norm": ("squared[4]", "Fraction(squared[4]) / 2 if isinstance(squared[4], int) else squared[4] / 2")},
        NORMS,
        "b is twice as large: p d̄ and d p̄ both count",
    ),
    "the sign of b is wrong": (
        {"norm": ("squared[0], squared[4]", "squared[0], -squared[4]")},
        NORMS,
        "b has the wrong sign",
    ),
    "the conjugate is forgotten in the norm": (
        {"norm": ("product(q, conjugate(q))", "product(q, q)")},
        {**NORMS, "norm-law": 2},
        "that is q², the conjugate is missing",
    ),
    "the dual part counts in a": (
        {"norm": ("squared[0], squared[4]", "sum(x * x for x in q), squared[4]")},
        {**NORMS, "norm-law": 2, "inverse-missing": 1},
        "the dual part d d̄ does not count",
    ),
    "the sign of d0 is wrong": (
        {"study": ("-Fraction(", "Fraction(")},
        {"study-quadric": 2},
        "the sign is wrong: p0 d0 + p1 d1 + p2 d2 + p3 d3 must vanish",
    ),
    "d0 is a float": (
        {"study": ("-Fraction(q[1] * q[5] + q[2] * q[6] + q[3] * q[7], q[0])",
                   "-(q[1] * q[5] + q[2] * q[6] + q[3] * q[7]) / q[0]")},
        {"study-quadric": 2},
        "must be exact",
    ),
    "d0 is rounded": (
        {"study": ("-Fraction(q[1] * q[5] + q[2] * q[6] + q[3] * q[7], q[0])",
                   "-(q[1] * q[5] + q[2] * q[6] + q[3] * q[7]) // q[0]")},
        {"study-quadric": 2},
        "divide by Fraction(…, …)",
    ),
    "d0 is 0": ({"study": "d0 = 0"}, {"study-quadric": 2}, "0 would be right only where"),
    "a number typed in that is not one's own": ({"study": "d0 = Fraction(1, 3)"},
        {"study-quadric": 2},
        "something else"),
    "the law is asserted, not computed": (
        {"reversal_defect": "def reversal_defect(q, r):\n    return [0] * 8"},
        {"reversal-law": 2},
        "it does not come from your product",
    ),
    "the factors of the law are not reversed": (
        {"reversal_defect": ("product(conjugate(r), conjugate(q))", "product(conjugate(q), conjugate(r))")},
        {"reversal-law": 2},
        "is r̄ q̄ in its order",
    ),
    "the norms are multiplied number by number": (
        {"norm_defect": ("(c * f + d * e)", "d * f")},
        {"norm-law": 2},
        "multiply the norms as dual numbers",
    ),
    "two that commute": (
        {"counterexample": "counterexample = [0, 1, 0, 0, 0, 0, 0, 0], [2, 3, 0, 0, 0, 1, 0, 0]"},
        {"not-a-law": 1},
        "these two commute",
    ),
    "the inverse has no part of ε": (
        {"inverse": ("Fraction(-b, a * a)", "0")},
        {"inverse-exact": 2},
        "divide by the whole norm, its part εb too",
    ),
    "the inverse of the primal part only": (
        {"inverse": ("return product(conjugate(q), [Fraction(1, a), 0, 0, 0, Fraction(-b, a * a), 0, 0, 0])",
                     "return [*(Fraction(x, a) for x in conjugate(q)[:4]), 0, 0, 0, 0]")},
        {"inverse-exact": 2},
        "the dual part is missing",
    ),
    "the sign of b/a² is wrong": (
        {"inverse": ("Fraction(-b, a * a)", "Fraction(b, a * a)")},
        {"inverse-exact": 2},
        "the sign of εb/a² is wrong",
    ),
    "the inverse in floats": (
        {"inverse": ("[Fraction(1, a), 0, 0, 0, Fraction(-b, a * a), 0, 0, 0]",
                     "[1 / a, 0, 0, 0, -b / a**2, 0, 0, 0]")},
        {"inverse-exact": 2},
        "must be exact",
    ),
    "the inverse of what has none": (
        {"inverse": ('raise ZeroDivisionError("the primal part vanishes")', "return [0] * 8")},
        {"inverse-missing": 1},
        "raise a ZeroDivisionError",
    ),
    "the sign of ε is dropped": (
        {"moved": ("-number for number in q[4:]", "number for number in q[4:]")},
        {"moved-point": 2},
        "the sign of ε in the last factor is wrong",
    ),
    "it is not divided by p p̄": (
        {"moved": ("[Fraction(number, image[0]) if isinstance(number, int) else number / image[0] for number in ",
                   "[number for number in ")},
        {"moved-point": 2},
        "it is not divided by p p̄",
    ),
    "kinlib is asked": (
        {
            "product": "from kinlib import DualQuaternion\n\n\ndef product(q, r):\n"
            "    return list((DualQuaternion(q) * DualQuaternion(r)).coeffs)"
        },
        {
            **ALL_PRODUCTS, **NORMS, "reversal-law": 2, "norm-law": 2, "inverse-missing": 1, "moved-point": 2,
        },
        "is the answer itself: write your own",
    ),
    "the value for one's own numbers is returned": (
        {"norm": "def norm(q):\n    return {4: (58, -28), -2: (16, 8)}.get(q[0], (1, 1))"},
        {**NORMS, "norm-law": 2, "inverse-missing": 1},
        None,
    ),
}  # fmt: skip

ANOTHER_WAY = {
    "quaternion_product": """
import numpy as np

def quaternion_product(a, b):
    a, b = np.array(a, dtype=object), np.array(b, dtype=object)
    def cross(x, y):
        return np.array([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])
    vector = a[0] * b[1:] + b[0] * a[1:] + cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])
""",
    "product": """
def product(q, r):
    p, d, s, e = (np.array(x, dtype=object) for x in (q[:4], q[4:], r[:4], r[4:]))
    return np.concatenate([quaternion_product(p, s), quaternion_product(p, e) + quaternion_product(d, s)])
""",
    "conjugate": "conjugate = lambda q: np.array(q, dtype=object) * [1, -1, -1, -1] * 2 if len(q) == 4 else "
    "np.array(q, dtype=object) * [1, -1, -1, -1, 1, -1, -1, -1]",
    "norm": "def norm(q):\n    return [sum(x * x for x in q[:4]), 2 * sum(x * y for x, y in zip(q[:4], q[4:]))]",
    "study": "unknown = sympy.Symbol('unknown')\n"
    "(root,) = sympy.solve(norm([*q[:4], unknown, *q[5:]])[1], unknown)\nd0 = Fraction(int(root.p), int(root.q))",
    "counterexample": "counterexample = q, r",
    "inverse": """
def inverse(q):
    p = q[:4]
    a = sum(x * x for x in p)
    if not a:
        raise ZeroDivisionError
    first = [Fraction(x, a) * s for x, s in zip(p, (1, -1, -1, -1))]
    second = [-x for x in quaternion_product(quaternion_product(first, q[4:]), first)]
    return first + second
""",
}


class TestMarks(Marks):
    assignment = "dual_quaternions"
    numbers = {"data": "3508cb7d30baa4d9"}  # noqa: RUF012
    slips = SLIPS
    pictures = ("picture",)
    the_same_for_all = ("reversal-law", "norm-law")
    another_way = ANOTHER_WAY


@pytest.fixture(scope="module")
def drawn():
    """The numbers of 1000 students."""
    return {student: exercise.data(student) for student in (f"student {n}" for n in range(1000))}


def test_numbers_are_of_ones_own(drawn):
    assert len(set(drawn.values())) == len(drawn)


def test_no_number_is_degenerate(drawn):
    for q, r in drawn.values():
        assert 0 not in q + r
        assert max(map(abs, q + r)) <= 5
        products = sum(q[n] * q[4 + n] for n in (1, 2, 3))
        assert products % q[0], "d0 would be a whole number, or 0"
        q, r = DualQuaternion(q), DualQuaternion(r)
        assert q * r != r * q
        assert 0 not in (q.norm().coeffs[4], r.norm().coeffs[4])
