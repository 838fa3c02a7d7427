"""The assignment on null lines: who is right gets the points, who is wrong loses those of the slip."""

from kinlib import EXCEPTIONAL_SPACE, STUDY_QUADRIC, DualQuaternion, eps, join, meet, null_form, study_form
from kinlib_assignments import null_lines as exercise
from marks import Marks

SLIPS = {
    "the third product of Lemma 1 is forgotten": (
        {"null_line": "def null_line(x, y):\n    return x.norm() == 0 and y.norm() == 0"},
        {"null-line-yours": 1, "null-line-for-all": 2},
        "the third product x ȳ + y x̄ counts too",
    ),
    "the conjugate is forgotten": (
        {"forms": ("x * y.conjugate() + y * x.conjugate()", "x * y + y * x")},
        {"forms-for-all": 2},
        "the conjugates are missing: x ȳ and y x̄",
    ),
    "the null cone is taken for its real points": (
        {"places": ("norm.primal == 0", "q.primal == 0")},
        {"places-for-all": 1},
        "it may for complex points with p ≠ 0",
    ),
    "the factors are in the wrong order": (
        {"pose_at": ("(t1 - h1) * (t2 - h2)", "(t2 - h2) * (t1 - h1)")},
        {"pose-at-for-all": 1, "null-lines-of-dyads": 2, "quadrilateral-of-dyads": 2},
        "the joint at the base is the left factor",
    ),
    "real parameters": (
        {"null_lines": ("for t1 in (I, -I)", "for t1 in (1, -1)")},
        {"null-lines-of-dyads": 2},
        "x x̄, y ȳ, x ȳ + y x̄ should be 0",
    ),
    "both signs change from vertex to vertex": (
        {"quadrilateral": ("(1, -1), (1, 1), (-1, 1), (-1, -1)", "(1, 1), (-1, -1), (1, -1), (-1, 1)")},
        {"quadrilateral-of-dyads": 2},
        "the edge to vertex 2 is no null line",
    ),
    "only the four points are looked at, not their span": (
        {
            "inside_study_quadric": "def inside_study_quadric(points):\n"
            "    return all(forms(x, x)[1] == 0 for x in points)",
            "meets_exceptional_space": "def meets_exceptional_space(points):\n"
            "    return any(x.primal == 0 for x in points)",
        },
        {"inside-study-quadric": 1, "meets-exceptional-space": 1, "found-yours": 1},
        "is b(x, y) = 0 for each two of them?",
    ),
    "a vertex of the quadrilateral for a point off the Study quadric": (
        {"stray": "stray = (I - g1) * (I - g2)"},
        {"stray-yours": 2},
        "the point is on the Study quadric",
    ),
    "complex points for real ones": (
        {"real_pair": "real_pair = null_lines(h1, h2)[0]"},
        {"real-pair": 1},
        "both points must be real",
    ),
    "a neighbour's spaces": (
        {"found": "found = dict(zip('ABCD', ('parallel axes', 'skew axes', 'prismatic joint', 'intersecting axes')))"},
        {"found-yours": 1},
        "let your two functions tell you",
    ),
    "one of the three lines is there twice": (
        {"three_lines": ("(slide, h * slide)", "(I - h, (I - h) * (1 + slide))")},
        {"three-lines-of-slides": 1},
        "is missing; is another there twice?",
    ),
    "the forms are twice too large": (
        {"forms": ("mixed.coeffs[n] / 2", "mixed.coeffs[n]")},
        {"forms-for-all": 2},
        "both are twice too large",
    ),
    "the forms are exchanged": (
        {"forms": ("(0, 4)", "(4, 0)")},
        {"forms-for-all": 2, "inside-study-quadric": 1, "meets-exceptional-space": 1, "found-yours": 1},
        "they are exchanged: the null form comes first",
    ),
    "the half-turns have the wrong sign": (
        {"pose_at": ("(t1 - h1) * (t2 - h2)", "(t1 + h1) * (t2 + h2)")},
        {"pose-at-for-all": 1},
        "the sign of the half-turns is wrong",
    ),
    "two of the null lines are there twice": (
        {"null_lines": ("for t2 in (I, -I)", "for t2 in (I, I)")},
        {"null-lines-of-dyads": 2},
        "is missing; is another there twice?",
    ),
    "kinlib is asked": (
        {
            "forms": "import kinlib\n\n\ndef forms(x, y):\n    return kinlib.null_form(x, y), kinlib.study_form(x, y)",
            "null_line": "def null_line(x, y):\n    return kinlib.is_null_line(x, y)",
        },
        {
            "forms-for-all": 2,
            "null-line-yours": 1,
            "null-line-for-all": 2,
            "inside-study-quadric": 1,
            "meets-exceptional-space": 1,
        },
        "of kinlib is the answer itself",
    ),
}

ANOTHER_WAY = {
    "forms": """
def forms(x, y):
    p, d, r, e = x.coeffs[:4], x.coeffs[4:], y.coeffs[:4], y.coeffs[4:]
    return (p * r).sum(), (p * e + d * r).sum()
""",
    "places": """
def places(q):
    null, study = forms(q, q)
    return [sympy.expand(study) == 0, sympy.expand(null) == 0, all(sympy.expand(x) == 0 for x in q.coeffs[:4])]
""",
    "null_line": """
def null_line(x, y):
    return all(sympy.expand(value) == 0 for pair in ((x, x), (x, y), (y, y)) for value in forms(*pair))
""",
    "pose_at": "def pose_at(h1, h2, t1, t2):\n    return (t1 * t2 - t1 * h2 - t2 * h1 + h1 * h2) * 3",
    "null_lines": """
def null_lines(h1, h2):
    pairs = []
    for root in (1j, -1j):
        pairs.append([(h1 - root) * 2, (h1 - root) * (h2 - 5)])
        pairs.append([(h1 + 1) * (h2 - root), h2 - root])
    return pairs[::-1]
""",
    "quadrilateral": """
def quadrilateral(h1, h2):
    m, m_, n, n_ = h1 - 1j, h1 + 1j, h2 - 1j, h2 + 1j
    return np.array([(2 * m_ * n_).coeffs, (1j * m_ * n).coeffs, (m * n).coeffs, (m * n_).coeffs])
""",
    "stray": "stray = 3 + 4 * g1 + 5 * I * g2",
    "real_pair": "real_pair = [DualQuaternion([0, 0, 0, 0, 0.5, 1, 2, 3]), eps * k]",
    "inside_study_quadric": """
def inside_study_quadric(points):
    form = sympy.Matrix(np.roll(np.eye(8, dtype=int), 4, axis=0))
    rows = sympy.Matrix([list(x.coeffs) for x in points])
    return (rows * form * rows.T).is_zero_matrix
""",
    "meets_exceptional_space": """
def meets_exceptional_space(points):
    return sympy.Matrix([list(x.coeffs[:4]) for x in points]).det() == 0
""",
    "found": "found = {'D': 'skew axes', 'A': 'prismatic joint', 'C': 'parallel axes', 'B': 'intersecting axes'}",
    "three_lines": """
def three_lines(h, v):
    slide = DualQuaternion([0, 0, 0, 0, 0, *v])
    lines = [((t - h) * (2 + slide), (t - h) * (slide - 1)) for t in (1j, -1j)]
    return [((1 - h) * slide, (2 - h) * slide), *lines]
""",
}


class TestMarks(Marks):
    assignment = "null_lines"
    numbers = {"data": "47fe913f88986dec", "_kinds": "294c5b96ac647bae", "spaces": "90ccc91a71263064"}  # noqa: RUF012
    slips = SLIPS
    pictures = ("null-lines-picture",)
    another_way = ANOTHER_WAY
    by_hand = 2


def test_numbers_are_well_conditioned():
    found = [exercise.data(f"student {n}") for n in range(1000)]
    assert len(set(found)) == len(found)
    for number, one in enumerate(found):
        h1, h2, g1, g2, h = (DualQuaternion(row) for row in one[:5])
        if number % 20 == 0:
            assert h1.norm() == h2.norm() == g1.norm() == g2.norm() == h.norm() == 1
        assert 0.1 <= abs(null_form(h1, h2)) <= 0.9
        assert null_form(g1, g2) == 0
        assert min(abs(study_form(h1, h2)), abs(study_form(g1, g2))) >= 0.25
        assert study_form(h, eps * DualQuaternion([0, *one.v, 0, 0, 0, 0])) != 0


def test_spaces_are_what_they_are_called():
    expected = {
        "skew axes": (False, -1),
        "parallel axes": (True, 1),
        "intersecting axes": (True, -1),
        "prismatic joint": (False, 1),
    }
    for n in range(30):
        kinds = exercise._kinds(f"student {n}")
        for name, points in exercise.spaces(f"student {n}").items():
            space = join(points)
            assert space.dimension == 3
            inside, common = STUDY_QUADRIC.contains(space), meet(space, EXCEPTIONAL_SPACE).dimension
            assert (inside, common) == expected[kinds[name]]
            assert inside or STUDY_QUADRIC.restrict(space).rank() == 4
            assert not any(point.primal == 0 for point in points)
