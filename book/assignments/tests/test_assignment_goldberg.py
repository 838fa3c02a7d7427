"""The assignment on a Goldberg linkage: who is right gets the points, who is wrong loses those of the slip."""

from fractions import Fraction

import numpy as np
import pytest

from kinlib import DualQuaternion, Dyad, goldberg_linkages, one, same_point
from kinlib_assignments import goldberg as exercise
from marks import Marks

DESIGN = {"design-room": 1, "design-lengths": 1, "design-travel": 1}
ADAS = "z = 2.033 - 1.567j"  # keeps to her brief, whatever her functions say

SLIPS = {
    "the coordinates of hA and hB are exchanged": (
        {"coordinates": ("(one, hA, hB, hA * hB, pose)", "(one, hB, hA, hA * hB, pose)")},
        {"pose-coordinates": 1, "pose-parameters": 1},
        "the coordinates of hA and hB are exchanged",
    ),
    "a pose is divided by its last coordinate": (
        {"coordinates": ("[-number / last for number in x]", "[number / x[-1] for number in x]")},
        {"pose-coordinates": 1},
        "keep the factor",
    ),
    "the last sign of the null vector is forgotten": (
        {"coordinates": ("[-number / last for number in x]", "[number / last for number in x]")},
        {"pose-coordinates": 1},
        "the sign is wrong: the pose is x0 + x1 hA",
    ),
    "floats for fractions": (
        {"coordinates": ("[-number / last for", "[-float(number / last) for")},
        {"pose-coordinates": 1},
        "it must be exact",
    ),
    "s_A and s_B are exchanged": (
        {"parameters": ("return -x2 / x3, -x1 / x3", "return -x1 / x3, -x2 / x3")},
        {"pose-parameters": 1},
        "s_A and s_B are exchanged: the coordinate of hA is −s_B",
    ),
    "the signs of s_A and s_B are wrong": (
        {"parameters": ("return -x2 / x3, -x1 / x3", "return x2 / x3, x1 / x3")},
        {"pose-parameters": 1},
        "the signs are wrong",
    ),
    "the factor of a pose is forgotten": (
        {"parameters": ("return -x2 / x3, -x1 / x3", "return -x2, -x1")},
        {"pose-parameters": 1},
        "a pose is given up to a factor only",
    ),
    "a dyad's method is asked": (
        {
            "coordinates": "from kinlib import Dyad\n\n\ndef coordinates(pose, hA, hB):\n"
            "    return Dyad(hA, hB).coordinates(pose)"
        },
        {"pose-coordinates": 1, "pose-parameters": 1},
        "Dyad.coordinates of kinlib is the answer itself",
    ),
    "the sign of √−1 is wrong": (
        {"misfit": ("(s_A + 1j)", "(s_A - 1j)")},
        {"condition-of-a-pose": 1},
        "the sign of √−1 is wrong: the factor is s_A + √−1",
    ),
    "the imaginary part is not taken": (
        {"misfit": (".imag", "")},
        {"condition-of-a-pose": 1},
        "that is the whole product",
    ),
    "the sign of √−1 is wrong in the equations": (
        {"partner": ("(complex(s_A) + 1j)", "(complex(s_A) - 1j)")},
        {"partner-of-z": 1, "bad-places": 1, "closed-loop": 1},
        "the sign of √−1 is wrong: the factor is s_A + √−1",
    ),
    "the unknowns are exchanged": (
        {"partner": ("[number.imag, number.real]", "[number.real, number.imag]")},
        {"partner-of-z": 1, "bad-places": 1, "closed-loop": 1},
        "real and imaginary part are exchanged",
    ),
    "a sign in the equations is wrong": (
        {"partner": ("[number.imag, number.real]", "[number.imag, -number.real]")},
        {"partner-of-z": 1, "closed-loop": 1},
        "the imaginary part has the wrong sign",
    ),
    "ZPlane is asked": (
        {
            "partner": "from kinlib import Dyad, ZPlane\n\n\ndef partner(z1, s1, s2):\n"
            "    poses = [(s_A - hA) * (s_B - hB) for s_A, s_B in (s1, s2)]\n"
            "    return ZPlane.of(Dyad(hA, hB), *poses).partner(z1)"
        },
        {"partner-of-z": 1, "bad-places": 1, "bad-places-any-size": 1, "closed-loop": 1},
        "ZPlane.of of kinlib is the answer itself",
    ),
    "x and y are exchanged": (
        {"chain": ("hA * z1.imag + z1.real", "hA * z1.real + z1.imag")},
        {"poses-are-met": 1, "closed-loop": 1},
        "x1 is the real part of z1",
    ),
    "the second factor turns about B": (
        {"chain": ("hA * z2.imag + z2.real", "hB * z2.imag + z2.real")},
        {"poses-are-met": 1, "closed-loop": 1},
        "it turns about A: hA, not hB",
    ),
    "the factors are in the wrong order": (
        {"chain": ("return (t - h1) * (t - h2) * (t - h3)", "return (t - h3) * (t - h2) * (t - h1)")},
        {"poses-are-met": 1},
        "the factors are in the wrong order",
    ),
    "an absolute tolerance": (
        {"what_is_wrong": ("size = max(abs(b1 - b2), abs(b1 - star), abs(b2 - star))", "size = 1")},
        {"bad-places-any-size": 1},
        "what counts as there must grow and shrink with the triangle",
    ),
    "the sides are exchanged": (
        {"what_is_wrong": ('return "misses pose 1"', 'return "misses pose 2"')},
        {"bad-places": 1, "bad-places-any-size": 1},
        "the sides are exchanged",
    ),
    "z2 is not looked at": (
        {"what_is_wrong": ("for z in (z1, partner(z1, s1, s2))", "for z in (z1,)")},
        {"bad-places": 1},
        "it is z2 that is ±√−1 there",
    ),
    "z* is not looked for": (
        {"what_is_wrong": ('    if abs(z1 - star) < 1e-9 * size:\n        return "Bennett"\n', "")},
        {"bad-places": 1, "bad-places-any-size": 1},
        "look for z* first",
    ),
    "the second chain begins with A": (
        {
            "second_chain": "def second_chain(h1, h2, hB):\n    middle, k3 = bennett_flip(h2, hB)\n"
            "    return h1, middle, k3"
        },
        {"partner-chain": 1, "closed-loop": 1},
        "k1 turns about A: bring the quadratic of hB to the front",
    ),
    "the other second chain": (
        {"second_chain": ("    middle, k3", "    h1, h2 = h2, h1\n    middle, k3")},
        {"partner-chain": 1, "closed-loop": 1},
        "the quadratics of h1 and h2 are in the wrong order",
    ),
    "the second chain is turned back by hand": (
        {"five_bar": ("second_chain(*first),", "[k.conjugate() for k in second_chain(*first)[::-1]],")},
        {"closed-loop": 1},
        "and turns the second one back by itself",
    ),
    "the stops are not told": (
        {"five_bar": (", parameters=(math.inf, s1[1], s2[1])", "")},
        {"closed-loop": 1},
        "says where the poses are",
    ),
    "kinlib's own linkage": (
        {
            "five_bar": """
from kinlib import DualQuaternion, Dyad, goldberg_linkages


def five_bar(z1, s1, s2, hA, hB):
    poses = [one, *((s_A - hA) * (s_B - hB) for s_A, s_B in (s1, s2))]
    return goldberg_linkages(*poses, (z1.real, z1.imag))[0]
"""
        },
        {"closed-loop": 1},
        "goldberg_linkages of kinlib is the answer itself",
    ),
    "radians for degrees": (
        {"dimensions": ("math.degrees(a.angle(b))", "float(a.angle(b))")},
        {"link-dimensions": 1},
        "the angles are in radians",
    ),
    "links that are numbered by their first joint": (
        {"dimensions": ("(axes[n - 1], axes[n])", "(axes[n], axes[(n + 1) % 5])")},
        {"link-dimensions": 1},
        "link 0 lies between the last joint and joint 0",
    ),
    "links that move with their neighbours": (
        {"link_ends": ("act(moves[n], ", "act(moves[n - 1], ")},
        {"ends-of-links": 1},
        "link n is carried along by displacement n, not by n − 1",
    ),
    "links that stay": (
        {"link_ends": ("act(moves[n], common_perpendicular(axes[n - 1], axes[n]))",
            "common_perpendicular(axes[n - 1], axes[n])")},
        {"ends-of-links": 1},
        "the links have not moved",
    ),
    "the ends of a link are exchanged": (
        {"link_ends": ("common_perpendicular(axes[n - 1], axes[n])", "common_perpendicular(axes[n], axes[n - 1])")},
        {"ends-of-links": 1},
        "the two ends of each link are exchanged",
    ),
    "the end of a turn in place of its travel": (
        {"travel": ("angles.max(axis=0) - angles.min(axis=0)", "abs(angles[-1] - angles[0])")},
        {"joint-travel": 1},
        "it swings to and fro, and its travel lies between",
    ),
    "half a round": (
        {"travel": ("[[np.inf], t, [-np.inf]]", "[[np.inf], t[t > 0]]")},
        {"joint-travel": 1},
        "a round is all of 0 < φ < 2π",
    ),
    "travel in radians": (
        {"travel": ("np.degrees(linkage", "(linkage")},
        {"joint-travel": 1},
        "that is in radians",
    ),
    "a neighbour's z": ({"design": "z = 4 - 1j"}, DESIGN, "but the room ends at"),
    "a z that gives no linkage": ({"design": "z = 2.0"}, DESIGN, "gives no linkage through your poses"),
}  # fmt: skip

ANOTHER_WAY = {
    "coordinates": """
def coordinates(pose, hA, hB):
    import sympy
    columns = [[sympy.Rational(str(x)) for x in q.coeffs] for q in (one, hA, hB, hA * hB, pose)]
    unknown = sympy.symbols("x:4")
    equations = sympy.Matrix(columns[:4]).T * sympy.Matrix(unknown) - sympy.Matrix(columns[4])
    return [sympy.solve(list(equations), unknown)[x] for x in unknown]
""",
    "parameters": """
from fractions import Fraction


def parameters(pose, hA, hB):
    x = [Fraction(str(number)) for number in coordinates(pose, hA, hB)]
    return x[0] / -x[1] if x[1] else None, x[0] / -x[2]
""",
    "misfit": """
import cmath


def misfit(z1, z2, s):
    numbers = [s[1] - z1, s[0] + 1j, s[1] - z2]
    return math.prod(map(abs, numbers)) * math.sin(sum(map(cmath.phase, numbers)))
""",
    "partner": """
def partner(z1, s1, s2):
    # the misfit is a + b x + c y: three values tell a, b, c
    rows = []
    for s in (s1, s2):
        s = [float(x) for x in s]
        a = misfit(z1, 0, s)
        rows.append((misfit(z1, 1, s) - a, misfit(z1, 1j, s) - a, a))
    (b, c, a), (e, f, d) = rows
    return complex(c * d - f * a, e * a - b * d) / (b * f - c * e)
""",
    "chain": """
def chain(z1, z2, hA, hB):
    return [z1.real + z1.imag * hA, z2.real + z2.imag * hA, hB]


def pose_at(chain, t):
    from kinlib import linear_factor
    return (linear_factor(chain[0]) * linear_factor(chain[1]) * linear_factor(chain[2]))(t)
""",
    "what_is_wrong": """
def what_is_wrong(z1, s1, s2):
    s1, s2 = [tuple(map(float, s)) for s in (s1, s2)]
    w = [(b - z1) * (a + 1j) for a, b in (s1, s2)]
    size = abs(s1[1] - s2[1])
    if all(abs(x.imag) < 1e-8 * abs(x) for x in w):
        return "Bennett"
    if abs(z1.imag) < 1e-8 * size:
        return "real"
    if abs((w[0].conjugate() * w[1]).imag) < 1e-8 * abs(w[0]) * abs(w[1]):
        return "circumcircle"
    z2 = partner(z1, s1, s2)
    if abs(z2 - s1[1]) < 1e-8 * size:
        return "misses pose 1"
    if abs(z2 - s2[1]) < 1e-8 * size:
        return "misses pose 2"
    return "same quadratic" if min(abs(z1 * z1 + 1), abs(z2 * z2 + 1)) < 1e-8 else ""
""",
    "second_chain": """
from kinlib import factorize, linear_factor


def second_chain(h1, h2, hB):
    h1, h2, hB = (h.astype(float) for h in (h1, h2, hB))
    C = linear_factor(h1) * linear_factor(h2) * linear_factor(hB)
    quadratics = np.array([[1, -2 * h.scalar_part, (h * h.conjugate()).scalar_part] for h in (h1, h2, hB)])
    return factorize(C, (2, 0, 1), quadratics)
""",
    "five_bar": """
def five_bar(z1, s1, s2, hA, hB):
    first = chain(z1, partner(z1, s1, s2), hA, hB)
    factors = [*first, *(k.conjugate() for k in second_chain(*first)[::-1])]
    return Linkage(factors, [2, 1, 1, 1, 1], 2, parameters=[np.inf, float(s1[1]), float(s2[1])])
""",
    "dimensions": """
def dimensions(linkage):
    rows = []
    for n in range(5):
        k, l = (linkage.axes[m].coeffs for m in (n - 1, n))
        cross = np.cross(k[1:4], l[1:4])
        sine, cosine = np.linalg.norm(cross), k[1:4] @ l[1:4]
        rows.append([abs(k[1:4] @ l[5:] + k[5:] @ l[1:4]) / sine, np.degrees(np.arctan2(sine, cosine))])
    return np.array(rows)
""",
    "link_ends": """
def link_ends(linkage, t):
    lines = [Line.from_dual_quaternion(h) for h in linkage.configuration(t)]
    return np.array([common_perpendicular(lines[n - 1], lines[n]) for n in range(5)])
""",
    "travel": """
def travel(linkage):
    spins = []
    for n in range(5):
        spin = 0
        for f in linkage.joint_factors(n):
            root = complex(f.scalar_part, f.coeffs[1:4] @ linkage.axes[n].coeffs[1:4])
            spin = spin + 2 * np.unwrap(np.angle(np.tan(np.linspace(-1.5707, 1.5707, 3000)) - root))
        spins.append(np.degrees(spin.max() - spin.min()))
    return spins
""",
    "design": ADAS,
}


class TestMarks(Marks):
    assignment = "goldberg"
    numbers = {"data": "95bd0fd330c12792", "brief": "7f1af30241a959da"}  # noqa: RUF012
    slips = SLIPS
    another_way = ANOTHER_WAY
    by_hand = 5
    pictures = ("map-of-z", "moving")
    always = {"design": ADAS}  # noqa: RUF012


def test_numbers_are_well_conditioned():
    found = [exercise.data(f"student {n}") for n in range(1000)]
    assert len({tuple(x for q in each for x in q.coeffs) for each in found}) == len(found)
    assert max(abs(x) for each in found for pose in each[2:] for x in pose.coeffs) < 3000
    hA, hB, *poses = (DualQuaternion.stack(column).astype(float) for column in zip(*found, strict=True))
    dyads = Dyad(hA, hB)
    first, second = dyads.axes
    assert np.all(np.abs(np.cos(first.angle(second))) < 0.77)
    assert np.all((first.distance(second) > 0.999) & (first.distance(second) < 3.001))
    (a1, b1), (a2, b2) = (dyads.parameters(pose) for pose in poses)
    height = (b2 - b1) / (a2 - a1)
    sides = np.abs([b1 - b2, (a1 + 1j) * height, (a2 + 1j) * height])
    assert np.all((np.abs(height) > 0.4) & (np.abs(height) < 2.5))
    assert np.all(sides.max(axis=0) < 20 * sides.min(axis=0))


@pytest.mark.parametrize("z", [(Fraction(7, 5), Fraction(9, 4)), (-3, Fraction(1, 2))])
def test_the_grader_agrees_with_the_package(z):
    found, (s1, s2) = exercise.data("emmy"), exercise._stops("emmy")
    poses = [one, *((s_a - found.hA) * (s_b - found.hB) for s_a, s_b in (s1, s2))]
    mine = exercise._linkage("emmy", complex(*map(float, z)))
    theirs = [each for sign in (1, -1) for each in goldberg_linkages(*poses, (z[0], sign * z[1]))]
    theirs += [each for sign in (1, -1) for each in goldberg_linkages(*poses, (-z[0], sign * z[1]))]
    assert any(
        all(same_point(a.astype(float), b) for a, b in zip(each.axes, mine.axes, strict=True)) for each in theirs
    )


def test_every_brief_can_be_met_and_few_choices_meet_it():
    shares, naive = [], []
    for n in range(20):
        student = f"student {n}"
        asked, grid = exercise.brief(student), exercise._candidates(student) + 0.003
        shares.append(met_by(asked, student, grid, 90).mean())
        naive.append(met_by(asked, student, np.array([1.001 + 2j, -1 + 1.003j]), 720))
    assert min(shares) > 0.01
    assert np.median(shares) < 0.06
    assert np.mean(naive) < 0.1


def met_by(asked, student: str, z: np.ndarray, steps: int) -> np.ndarray:
    return exercise._keeps(asked, exercise._measures(exercise._linkage(student, z), steps)).all(axis=0)


@pytest.mark.parametrize("student", ["ada", "emmy", "sophus"])
def test_kinlib_finds_the_same_fault_at_each_bad_place(student):
    plane, names = exercise._plane(student), {"misses pose 1": "MISSES_1", "misses pose 2": "MISSES_2"}
    found = [(plane.fault(z), word) for z, word in exercise._bad_places(student)]
    assert [
        (fault, word) for fault, word in found if fault is None or fault.name != names.get(word, word.upper())
    ] == []
    assert [plane.fault(z) for z in exercise._some_z(student)] == [None] * 3
