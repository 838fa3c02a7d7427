"""The assignment on Bennett linkages: who is right gets the points, who is wrong loses those of the slip."""

import numpy as np

from kinlib import DualQuaternion, bennett_linkage, conic_through, one, study_eigenvalues, study_form
from kinlib_assignments import bennett as exercise
from marks import Marks

UNIT = "h / math.sqrt(null_form(h, h))"

SLIPS = {
    "the weights are left out": (
        {"conic": ("first, second = p1 * b02 / b12, p2 * b01 / b12", "first, second = p1, p2")},
        {"conic-on-quadric": 1}, "look at the weights of p1 and p2"),
    "the poses are exchanged": ({"conic": ("def conic(p1, p2)", "def conic(p2, p1)")}, {"conic-passes": 2},
        "p1 and p2 are exchanged"),
    "the leading coefficient is left": (
        {"conic": ("[one, second - first - 1, first]", "[one * b12, (second - first - 1) * b12, first * b12]")},
        {"conic-passes": 2}, "the leading coefficient must be 1"),
    "the conjugate is forgotten": (
        {
            "quartic": "def quartic(C):\n    c2, c1, c0 = C\n    parts = c2 * c2, c2 * c1 + c1 * c2, "
            "c2 * c0 + c1 * c1 + c0 * c2, c1 * c0 + c0 * c1, c0 * c0\n    return [x.scalar_part for x in parts]"
        },
        {"quartic-of-conic": 2}, "that is C², the conjugate is missing"),
    "the sign of the linear term is wrong": (
        {"quadratics": ("-2 * root.real", "2 * root.real")},
        {"quadratics-of-quartic": 2}, "the sign of b is wrong"),
    "the factors of the quotient are in the wrong order": (
        {"right_factor": ("-((c1 - c2 * b).inverse() * (c0 - c2 * c))", "-((c0 - c2 * c) * (c1 - c2 * b).inverse())")},
        {"right-factor": 2, "first-factorization": 2, "second-factorization": 1}, "the order counts"),
    "the factors are in the wrong order": (
        {"both_factorizations": ("(-C[1] - last, last)", "(last, -C[1] - last)")},
        {"first-factorization": 2, "second-factorization": 1}, "that is (t − h2)(t − h1), in the wrong order"),
    "one factorization is given twice": (
        {"both_factorizations": ("for M in (M2, M1)", "for M in (M2, M2)")},
        {"second-factorization": 1}, "its last factor belongs to the other quadratic"),
    "the conjugates of the loop are forgotten": (
        {"loop": ("k2.conjugate(), k1.conjugate()", "k2, k1")},
        {"loop-closes": 2}, "each joint turns backwards: conjugate"),
    "degrees for radians": (
        {"link": ("/ math.sin(angle), angle", "/ math.sin(angle), math.degrees(angle)")},
        {"link-angle": 1}, "that is in degrees"),
    "the real parts are left in": (
        {"link": ("(h - h.scalar_part) / math.sqrt(null_form(h - h.scalar_part, h - h.scalar_part))", UNIT)},
        {"link-distance": 2, "link-angle": 1}, "leave out the real parts"),
    "the null form is forgotten": (
        {"ratio": ("np.linalg.solve(N, S)", "S")},
        {"ratio-of-poses": 2}, "the null form is missing"),
    "kinlib is asked": (
        {
            "both_factorizations": "from kinlib import MotionPolynomial, factorizations\n\n\n"
            "def both_factorizations(C, M1, M2):\n    return factorizations(MotionPolynomial([c.coeffs for c in C]))"
        },
        {"first-factorization": 2, "second-factorization": 1}, "is the answer itself: write your own"),
    "b is not doubled": (
        {"quadratics": ("-2 * root.real", "-root.real")},
        {"quadratics-of-quartic": 2},
        "b is −2 Re r",
    ),
    "the absolute value for its square": (
        {"quadratics": ("abs(root) ** 2", "abs(root)")},
        {"quadratics-of-quartic": 2},
        "c is r r̄ = |r|², not |r|",
    ),
    "the sign of the factor is wrong": (
        {"right_factor": ("return -(", "return (")},
        {"right-factor": 2, "first-factorization": 2, "second-factorization": 1},
        "the sign is wrong: r1 h + r0 = 0",
    ),
    "the chain turns in the wrong order": (
        {"body": ("(t - first) * (t - second)", "(t - second) * (t - first)")},
        {"body-in-poses": 1},
        "the chain turns about its axes in the wrong order",
    ),
    "the way back is not reversed": (
        {"loop": ("k2.conjugate(), k1.conjugate()", "k1.conjugate(), k2.conjugate()")},
        {"loop-closes": 2},
        "on the way back the last joint comes first",
    ),
    "the products of different coefficients are missing": (
        {"quartic": ("2 * null_form(c2, c0) + null_form(c1, c1)", "null_form(c1, c1)")},
        {"quartic-of-conic": 2},
        "the quartic: expected",
    ),
    "the lowest power comes first": (
        {"quartic": ("    return [", "    c2, c0 = c0, c2\n    return [")},
        {"quartic-of-conic": 2},
        "the lowest power comes last",
    ),
    "the distance is not divided by the sine": (
        {"link": ("abs(study_form(l, m)) / math.sin(angle), angle", "abs(study_form(l, m)), angle")},
        {"link-distance": 2},
        "b(l, k) of unit half-turns is a sin α",
    ),
    "the distance has a sign": (
        {"link": ("abs(study_form(l, m))", "study_form(l, m)")},
        {"link-distance": 2},
        "a distance is not negative",
    ),
    "the angle of two lines without directions": (
        {"link": ("math.acos(null_form(l, m))", "math.acos(abs(null_form(l, m)))")},
        {"link-angle": 1},
        "it is between 0 and π, and may be more than π/2",
    ),
    "the difference is not halved": (
        {"ratio": (" / 2\n", "\n")},
        {"ratio-of-poses": 2},
        "halve the difference",
    ),
    "the matrices are exchanged": (
        {"ratio": ("np.linalg.solve(N, S)", "N @ S")},
        {"ratio-of-poses": 2},
        "the eigenvalues of S N, not of N⁻¹ S, were taken",
    ),
}  # fmt: skip

ANOTHER_WAY = {
    "conic": """
def conic(p1, p2):
    values = [float(study_form(x, y)) for x, y in ((one, p1), (one, p2), (p1, p2))]
    at = lambda t: one * (values[2] * t * (t - 1)) - p1 * (values[1] * (t - 1)) + p2 * (values[0] * t)
    c0, c2 = at(0), (at(1) + at(-1) - 2 * at(0)) / 2
    c1 = at(1) - c2 - c0
    return tuple(c / c2.scalar_part for c in (c2, c1, c0))
""",
    "quartic": """
def quartic(C):
    total = [0 * one] * 5
    for n, a in enumerate(C):
        for m, b in enumerate(C):
            total[n + m] = total[n + m] + a * b.conjugate()
    return np.array([x.scalar_part for x in total])
""",
    "quadratics": """
from fractions import Fraction

from sympy import Poly, Rational, Symbol

def quadratics(coefficients):
    t = Symbol("t")
    exact = [Rational(str(Fraction(x).limit_denominator(10**6))) for x in coefficients]
    found = [f.monic().all_coeffs() for f, power in Poly(exact, t).factor_list()[1] for _ in range(power)]
    return [tuple(Fraction(int(x.p), int(x.q)) for x in row) for row in found][::-1]
""",
    "right_factor": """
def right_factor(C, M):
    def left(q):
        units = np.eye(8, dtype=int)
        return np.array([(q * DualQuaternion(row)).coeffs for row in units], dtype=float).T
    r1, r0 = C[1] - M[1] * C[0], C[2] - M[2] * C[0]
    return DualQuaternion(np.linalg.solve(left(r1), -np.array(r0.coeffs, dtype=float)))
""",
    "both_factorizations": """
def both_factorizations(C, M1, M2):
    h2 = right_factor(C, M2)
    h1 = C[2] * h2.inverse()
    v = h1.conjugate() - h2
    k2 = v.inverse() * h1 * v
    return [(h1, h2), [h1 + h2 - k2, k2]]
""",
    "body": """
def body(pair, t):
    if t == np.inf:
        return one + 0 * pair[0]
    return -3 * (pair[0] * pair[1] - t * (pair[0] + pair[1]) + t * t)
""",
    "loop": """
def loop(first, second):
    back = [2 * k.scalar_part - k for k in second]
    return (*first, *back[::-1])
""",
    "link": """
def link(f, g):
    (l, m), (k, n) = ((np.array(h.coeffs[1:4], dtype=float), np.array(h.coeffs[5:], dtype=float)) for h in (f, g))
    (l, m), (k, n) = (l / np.linalg.norm(l), m / np.linalg.norm(l)), (k / np.linalg.norm(k), n / np.linalg.norm(k))
    normal = np.cross(l, k)
    gap = np.cross(k, n) - np.cross(l, m)
    return abs(gap @ normal) / np.linalg.norm(normal), np.arctan2(np.linalg.norm(normal), l @ k)
""",
    "ratio": """
def ratio(p1, p2):
    C = conic(p1, p2)
    first, _ = both_factorizations(C, *quadratics(quartic(C)))
    a, alpha = link(*first)
    return a / math.sin(alpha)
""",
}


class TestMarks(Marks):
    assignment = "bennett"
    numbers = {"data": "65a91774db6cbb37"}  # noqa: RUF012
    slips = SLIPS
    pictures = ("bennett-table", "bennett-picture")
    another_way = ANOTHER_WAY


def test_poses_are_well_conditioned():
    found = [exercise.data(f"student {n}") for n in range(1000)]
    p1, p2 = (
        DualQuaternion(np.array([x.components.tolist() for x in row], dtype=float)) for row in zip(*found, strict=True)
    )
    both = np.concatenate([p1.coeffs, p2.coeffs], axis=1)
    assert len(np.unique(both, axis=0)) == len(found)
    assert np.abs(both).max() < 200
    assert np.abs(study_form(p1, p1)).max() == np.abs(study_form(p2, p2)).max() == 0
    roots = np.array([upper_roots(row) for row in conic_through(one.astype(float), p1, p2).norm_polynomial()])
    assert np.abs(roots[:, 0] - roots[:, 1]).min() > 0.3
    assert roots.imag.min() > 0.9
    assert np.abs(roots.real).min() > 0.9, "b of a quadratic would be 0"
    assert np.diff(study_eigenvalues(one, p1, p2)).min() > 0.01
    check_linkages(bennett_linkage(one.astype(float), p1, p2))


def upper_roots(polynomial):
    """The roots with positive imaginary part."""
    return [root for root in np.roots(polynomial) if root.imag > 0]


def check_linkages(linkages):
    """All links are of like size, no axes nearly parallel, and the loops close."""
    rows = linkages.denavit_hartenberg()
    distances, twists = (np.array([getattr(row, name) for row in rows]) for name in ("distance", "twist"))
    assert np.abs(np.cos(twists)).min() > 0.09, "a sine of 1 would hide what it is for"
    sines = np.abs(np.sin(twists))
    assert distances.min() > 0.49
    assert distances.max() < 4.01
    assert sines.min() > 0.49
    assert np.ptp(distances / sines, axis=0).max() < 1e-9
    assert np.max(linkages.closure_residual()) < 1e-9
    assert np.abs(linkages.axes.coeffs).max() < 10
