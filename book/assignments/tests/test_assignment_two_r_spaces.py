"""The assignment on 2R spaces: who is right gets the points, who is wrong loses those of the slip."""

import numpy as np
import pytest

from kinlib import DegenerateError, DualQuaternion, null_form, recognise, same_point, study_form
from kinlib_assignments import two_r_spaces as exercise
from marks import Marks

SLIPS = {
    "the Study form is half of what it should be": (
        {"study_matrix": ("x.coeffs * y.coeffs[swapped]", "x.coeffs[:4] * y.coeffs[4:]")},
        {"study-gram": 2, "verdict-of-any": 2, "verdicts-of-yours": 1, "axes-in-any-order": 2, "axes-in-order": 2},
        "a form is symmetric: d with r counts too"),
    "the null form counts the dual parts": (
        {"null_matrix": ("sum(x.coeffs[:4] * y.coeffs[:4])", "sum(x.coeffs * y.coeffs)")},
        {"null-gram": 1, "meets-exceptional": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "only the primal parts count"),
    "only primal parts are looked at": (
        {"contains": "def contains(basis, x):\n    rows = [point.coeffs[:4] for point in basis]\n"
         "    return Matrix([*rows, x.coeffs[:4]]).rank() == Matrix(rows).rank()"},
        {"contains-point": 2, "verdict-of-any": 2, "verdicts-of-yours": 1, "axes-in-order": 2},
        "its dual part counts too"),
    "the identity is looked for among the four points": (
        {"verdict": ("if not contains(basis, one)", "if not any(x == one for x in basis)")},
        {"verdict-of-any": 2, "verdicts-of-yours": 1}, "is not of the kind 'misses the identity': [1] is in it"),
    "the factors are in the wrong order": ({"space_matrix": ("N.inv() * S", "S * N.inv()")}, {"relative-matrix": 1},
        "that is S N⁻¹: the factors are in the wrong order"),
    "the whole trace is taken": (
        {"kappa": ("A.trace() / 2 * A", "A.trace() * A")},
        {"kappa-value": 2, "kappa-missing": 1, "proportions-of-axes": 2, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "half the trace is needed"),
    "one entry of the equation is looked at": (
        {"kappa": (" if rest == rest[0, 0] * eye(4) else None", "")},
        {"kappa-missing": 1, "verdict-of-any": 2, "verdicts-of-yours": 1}, "None is right"),
    "the sign of kappa is wrong": (
        {"kappa": ("return rest[0, 0]", "return -rest[0, 0]")},
        {"kappa-value": 2, "proportions-of-axes": 2}, "κ: the sign is wrong"),
    "the tangent for the cotangent": (
        {"proportions": ("A.trace() ** 2 / (16 * distance_squared)", "16 * distance_squared / A.trace() ** 2")},
        {"proportions-of-axes": 2}, "the tangent, not of the cotangent"),
    "b is twice as large": (
        {"study_matrix": ("Matrix([[sum", "2 * Matrix([[sum")},
        {"study-gram": 2},
        "each product counts once: it is twice as large",
    ),
    "the null form for the Study form": (
        {"study_matrix": ("y.coeffs[swapped]", "y.coeffs * [1, 1, 1, 1, 0, 0, 0, 0]")},
        {"study-gram": 2, "verdict-of-any": 2, "verdicts-of-yours": 1, "axes-in-any-order": 2, "axes-in-order": 2},
        "that is the null form",
    ),
    "E is looked for among the four points": (
        {"meets_exceptional": ("return null_matrix(basis).det() == 0", "return any(x.primal == 0 for x in basis)")},
        {"meets-exceptional": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "a sum of its points has no primal part",
    ),
    "S is inverted for N": (
        {"space_matrix": ("N.inv() * S", "S.pinv() * N")},
        {"relative-matrix": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "it is N that is inverted",
    ),
    "only the diagonal is looked at": (
        {"kappa": ("rest == rest[0, 0] * eye(4)", "len(set(rest.diagonal())) == 1")},
        {"kappa-missing": 1},
        "not at the diagonal only",
    ),
    "kappa of the values, not of the matrix": (
        {"kappa": ("return rest[0, 0] if", "return rest if")},
        {"kappa-value": 2, "kappa-missing": 1, "proportions-of-axes": 2, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "κ",
    ),
    "no kappa for zero": (
        {"kappa": ("return rest[0, 0] if", "return (rest[0, 0] or None) if")},
        {"kappa-missing": 1, "verdict-of-any": 2, "verdicts-of-yours": 1},
        "κ is 0 for this A, which is not the same as none",
    ),
    "the cosine for the cotangent": (
        {"proportions": ("A.trace() ** 2 / (16 * distance_squared)",
                         "A.trace() ** 2 / (16 * distance_squared + A.trace() ** 2)")},
        {"proportions-of-axes": 2},
        "the second number is cos²α",
    ),
    "twice two eigenvalues": (
        {"proportions": ("16 * distance", "4 * distance")},
        {"proportions-of-axes": 2},
        "there are four eigenvalues, each of them twice",
    ),
    "a for its square": (
        {"proportions": ("return distance_squared,", "return distance_squared ** 0.5,")},
        {"proportions-of-axes": 2},
        "they are squares: a, not a², was given",
    ),
    "the conditions in another order": (
        {"verdict": ('    S, N = study_matrix(basis), null_matrix(basis)\n'
                     '    if S.is_zero_matrix:\n        return "lies on S"\n'
                     '    if meets_exceptional(basis):\n        return "meets E"\n',
                     '    S, N = study_matrix(basis), null_matrix(basis)\n    if meets_exceptional(basis):\n'
                     '        return "meets E"\n')},
        {"verdict-of-any": 2, "verdicts-of-yours": 1},
        "is not of the kind 'kappa is zero'",
    ),
    "one verdict is wrong": (
        {"verdicts": ("verdicts = [verdict(space) for space in spaces]",
                      "verdicts = [verdict(space) for space in spaces]\nverdicts[0] = 'kappa is zero'")},
        {"verdicts-of-yours": 1},
        "a condition that comes earlier in the table fails already",
    ),
    "points with a real part": (
        {"half_turn_line": ("rows[:, [0, 4]].T", "rows[:, [0]].T")},
        {"half-turn-line": 1, "axes-in-any-order": 2, "axes-in-order": 2},
        "expected 2 points of it, got 3",
    ),
    "both axes are one": (
        {"axes": ("return (first, second) if", "return (first, first) if")},
        {"axes-in-any-order": 2, "axes-in-order": 2},
        "both are the same point",
    ),
    "the order of the axes is left to chance": (
        {"axes": (" if contains(basis, first * second) else (second, first)", "")},
        {"axes-in-order": 2}, "h1 and h2 are exchanged"),
    "kinlib is asked": (
        {
            "axes": "from kinlib import recognise\n\n\ndef axes(basis):\n"
            "    dyad = recognise(DualQuaternion.stack(basis))\n    return dyad.h1, dyad.h2"
        },
        {"axes-in-any-order": 2, "axes-in-order": 2}, "recognise of kinlib is the answer itself"),
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
    numbers = {"_answers": "f2b12f85a51f1372"}  # noqa: RUF012
    slips = SLIPS
    pictures = ("space-picture",)
    another_way = ANOTHER_WAY


def test_the_verdicts_are_those_of_the_procedure():
    said = {
        "misses the identity": "does not contain",
        "lies on S": "lies in the Study quadric",
        "meets E": "meets the exceptional",
        "no kappa": "no null quadrilateral",
        "kappa is zero": "singular quadric",
    }
    for space in (space for n in range(5) for space in exercise._answers(f"student {n}")):
        points = DualQuaternion.stack(space.points)
        if space.axes:
            dyad = recognise(points)
            assert same_point(dyad.h1, space.axes[0])
            assert same_point(dyad.h2, space.axes[1])
        else:
            with pytest.raises(DegenerateError, match=said[space.verdict]):
                recognise(points)


def test_spaces_are_well_conditioned():
    found = [exercise._answers(f"student {n}") for n in range(1000)]
    orders = {tuple(space.verdict for space in spaces) for spaces in found}
    assert len(orders) > 600
    for space in (space for spaces in found for space in spaces if space.axes):
        h1, h2 = space.axes
        assert 0 not in (null_form(h1, h2), study_form(h1, h2)), "cot²α or a would be 0"
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
