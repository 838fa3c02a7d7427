"""The assignment on 2R spaces: who is right gets the points, who is wrong loses those of the slip."""

import numpy as np
import pytest

from kinlib import DegenerateError, DualQuaternion, recognise, same_point
from kinlib_assignments import two_r_spaces as exercise
from marks import Marks

SLIPS = {
    "the Study form is half of what it should be": (
        {"study_matrix": ("x.coeffs * y.coeffs[swapped]", "x.coeffs[:4] * y.coeffs[4:]")},
        {"study-gram": 2, "verdict-of-any": 2, "verdicts-of-yours": 1, "axes-in-any-order": 2, "axes-in-order": 2},
    ),
    "the null form counts the dual parts": (
        {"null_matrix": ("sum(x.coeffs[:4] * y.coeffs[:4])", "sum(x.coeffs * y.coeffs)")},
        {"null-gram": 1, "meets-exceptional": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
    ),
    "only primal parts are looked at": (
        {"contains": "def contains(basis, x):\n    rows = [point.coeffs[:4] for point in basis]\n"
         "    return Matrix([*rows, x.coeffs[:4]]).rank() == Matrix(rows).rank()"},
        {"contains-point": 2, "verdict-of-any": 2, "verdicts-of-yours": 1, "axes-in-order": 2},
    ),
    "the identity is looked for among the four points": (
        {"verdict": ("if not contains(basis, one)", "if not any(x == one for x in basis)")},
        {"verdict-of-any": 2, "verdicts-of-yours": 1},
    ),
    "the factors are in the wrong order": ({"space_matrix": ("N.inv() * S", "S * N.inv()")}, {"relative-matrix": 1}),
    "the whole trace is taken": (
        {"kappa": ("A.trace() / 2 * A", "A.trace() * A")},
        {"kappa-value": 2, "kappa-missing": 1, "proportions-of-axes": 2, "verdict-of-any": 2, "verdicts-of-yours": 1},
    ),
    "one entry of the equation is looked at": (
        {"kappa": (" if rest == rest[0, 0] * eye(4) else None", "")},
        {"kappa-missing": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
    ),
    "the sign of kappa is wrong": (
        {"kappa": ("return rest[0, 0]", "return -rest[0, 0]")},
        {"kappa-value": 2, "proportions-of-axes": 2},
    ),
    "the tangent for the cotangent": (
        {"proportions": ("A.trace() ** 2 / (16 * distance_squared)", "16 * distance_squared / A.trace() ** 2")},
        {"proportions-of-axes": 2},
    ),
    "the visible test's value is returned": (
        {"proportions": "def proportions(A):\n    return 1, 0"},
        {"proportions-of-axes": 2},
    ),
    "the order of the axes is left to chance": (
        {"axes": (" if contains(basis, first * second) else (second, first)", "")},
        {"axes-in-order": 2},
    ),
    "kinlib is asked": (
        {
            "axes": "from kinlib import recognise\n\n\ndef axes(basis):\n"
            "    dyad = recognise(DualQuaternion.stack(basis))\n    return dyad.h1, dyad.h2"
        },
        {"axes-in-any-order": 2, "axes-in-order": 2},
    ),
}  # fmt: skip

ANOTHER_WAY = {
    "study_matrix": """
from kinlib import STUDY_QUADRIC

def study_matrix(basis):
    rows = np.array([x.coeffs for x in basis])
    return Matrix(rows @ STUDY_QUADRIC.matrix @ rows.T)
""",
    "null_matrix": """
def null_matrix(basis):
    products = [[x * y.conjugate() + y * x.conjugate() for y in basis] for x in basis]
    return Matrix(len(basis), len(basis), lambda r, s: products[r][s].scalar_part) / 2
""",
    "contains": """
def contains(basis, x):
    rows = np.array([point.coeffs for point in basis], dtype=float)
    rest = np.array(x.coeffs, dtype=float)
    rest = rest - np.linalg.lstsq(rows.T, rest, rcond=None)[0] @ rows
    return np.abs(rest).max() < 1e-9
""",
    "meets_exceptional": "def meets_exceptional(basis):\n"
    "    return np.linalg.matrix_rank(np.array([x.coeffs[:4] for x in basis], dtype=float)) < 4",
    "space_matrix": "def space_matrix(S, N):\n    return N.LUsolve(S)",
    "kappa": """
def kappa(A):
    polynomial = A.charpoly().all_coeffs()
    half = polynomial[1] / 2
    last = (polynomial[2] - half**2) / 2
    square = A * A + half * A
    return last if all(square[r, s] == -last * int(r == s) for r in range(4) for s in range(4)) else None
""",
    "proportions": """
def proportions(A):
    values = np.linalg.eigvals(np.array(A, dtype=float)).real
    low, high = values.min(), values.max()
    cosine = (high + low) / (low - high)
    return -low * high, cosine**2 / (1 - cosine**2)
""",
    "half_turn_line": """
def half_turn_line(basis):
    rows = Matrix([x.coeffs for x in basis])
    return [DualQuaternion(list(v.T * rows)) for v in rows[:, [0, 4]].T.nullspace()]
""",
    "axes": """
from sympy import Symbol, roots

def axes(basis):
    x, y = half_turn_line(basis)
    x = x + y * 7
    t = Symbol("t")
    S = study_matrix([x, y])
    h, g = (x * t0 + y for t0 in roots(S[0, 0] * t**2 + 2 * S[0, 1] * t + S[1, 1], t))
    return [-3 * g, h] if contains(basis, g * h) else [h, g / 5]
""",
}


class TestMarks(Marks):
    assignment = "two_r_spaces"
    numbers = {"answers": "f2b12f85a51f1372"}  # noqa: RUF012
    slips = SLIPS
    another_way = ANOTHER_WAY


def test_the_verdicts_are_those_of_the_procedure():
    said = {
        "misses the identity": "does not contain",
        "lies on S": "lies in the Study quadric",
        "meets E": "meets the exceptional",
        "no kappa": "no null quadrilateral",
        "kappa is zero": "singular quadric",
    }
    for space in (space for n in range(5) for space in exercise.answers(f"student {n}")):
        points = DualQuaternion.stack(space.points)
        if space.axes:
            dyad = recognise(points)
            assert same_point(dyad.h1, space.axes[0])
            assert same_point(dyad.h2, space.axes[1])
        else:
            with pytest.raises(DegenerateError, match=said[space.verdict]):
                recognise(points)


def test_spaces_are_well_conditioned():
    found = [exercise.answers(f"student {n}") for n in range(3000)]
    orders = {tuple(space.verdict for space in spaces) for spaces in found}
    assert len(orders) > 1000
    rows = [[[x.components.tolist() for x in space.points] for space in spaces] for spaces in found]
    coeffs = np.array(rows, dtype=float)
    assert np.unique(coeffs.reshape(len(found), -1), axis=0).shape[0] == len(found)
    assert np.abs(coeffs).max() < 60
    verdicts = np.array([[space.verdict for space in spaces] for spaces in found])
    assert all(set(row) == set(exercise.VERDICTS) for row in verdicts)
    check_conditions(coeffs.reshape(-1, 4, 8), verdicts.ravel())


def check_conditions(rows, verdicts):
    """Every condition holds or fails by far more than rounding."""
    primal, dual = rows[..., :4], rows[..., 4:]
    N = primal @ primal.swapaxes(1, 2)
    S = primal @ dual.swapaxes(1, 2)
    S = S + S.swapaxes(1, 2)
    meets = verdicts == "meets E"
    smallest = np.linalg.svd(primal, compute_uv=False)[:, -1]
    assert smallest[meets].max() < 1e-12
    assert smallest[~meets].min() > 1e-3
    assert np.array_equal(np.abs(S).max(axis=(1, 2)) == 0, verdicts == "lies on S")
    A = np.linalg.solve(N[~meets], S[~meets])
    rest = A @ A - np.trace(A, axis1=1, axis2=2)[:, None, None] / 2 * A
    kappa = -np.trace(rest, axis1=1, axis2=2) / 4
    defect = np.abs(rest + kappa[:, None, None] * np.eye(4)).max(axis=(1, 2))
    without = verdicts[~meets] == "no kappa"
    assert defect[without].min() > 0.01
    assert defect[~without].max() < 1e-6
    assert np.abs(kappa[verdicts[~meets] == "2R space"]).min() > 0.01
    assert np.abs(kappa[verdicts[~meets] == "kappa is zero"]).max() < 1e-6
