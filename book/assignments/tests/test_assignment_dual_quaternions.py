"""The assignment on dual quaternions: who is right gets the points, who is wrong loses those of the slip."""

from kinlib import DualQuaternion
from kinlib_assignments import dual_quaternions as exercise
from marks import Marks

SLIPS = {
    "the factors are in the wrong order": (
        {"product": ("def product(q, r):", "def product(r, q):")},
        {"product-of-yours": 1, "product-for-all": 2, "moved-point": 2},
    ),
    "the sign of ε is dropped": (
        {"moved": ("-number for number in q[4:]", "number for number in q[4:]")},
        {"moved-point": 2},
    ),
    "the conjugate is forgotten": (
        {"norm": ("product(q, conjugate(q))", "product(q, q)")},
        {"norm-of-all": 2, "norm-law": 2, "inverse-exact": 2},
    ),
    "the conjugate stops at the primal part": (
        {"conjugate": "def conjugate(q):\n    return [q[0], -q[1], -q[2], -q[3], *q[4:]]"},
        {
            "conjugate-of-all": 1,
            "norm-of-all": 2,
            "reversal-law": 2,
            "norm-law": 2,
            "inverse-exact": 2,
            "moved-point": 2,
        },
    ),
    "the visible test's value is returned": (
        {"norm": "def norm(q):\n    return 5, 0"},
        {"norm-of-all": 2, "norm-law": 2, "inverse-exact": 2, "inverse-missing": 1},
    ),
    "the law is asserted, not computed": (
        {"reversal_defect": "def reversal_defect(q, r):\n    return [0] * 8"},
        {"reversal-law": 2},
    ),
    "kinlib is asked": (
        {
            "product": "from kinlib import DualQuaternion\n\n\ndef product(q, r):\n"
            "    return list((DualQuaternion(q) * DualQuaternion(r)).coeffs)"
        },
        {"product-of-yours": 1, "product-for-all": 2, "norm-of-all": 2, "inverse-exact": 2, "moved-point": 2},
    ),
    "the inverse of what has none": (
        {"inverse": ('raise ZeroDivisionError("the primal part vanishes")', "return [0] * 8")},
        {"inverse-missing": 1},
    ),
    "a number typed in that is not one's own": ({"study": "d0 = Fraction(1, 3)"}, {"study-quadric": 2}),
}

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
    numbers = {"data": "cdeb642d8e0199df"}  # noqa: RUF012
    slips = SLIPS
    another_way = ANOTHER_WAY


def test_numbers_are_well_conditioned():
    found = [exercise.data(f"student {n}") for n in range(3000)]
    assert len(set(found)) == len(found)
    for q, r in found:
        assert 0 not in q + r
        assert max(map(abs, q + r)) <= 5
        q, r = DualQuaternion(q), DualQuaternion(r)
        assert q * r != r * q
        assert q.norm() != q.norm().eps_conjugate()
