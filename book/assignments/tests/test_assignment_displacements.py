"""The assignment on displacements: who is right gets the points, who is wrong loses those of the slip."""

import math
from itertools import permutations

import numpy as np

from kinlib import DualQuaternion, same_point, study_form
from kinlib_assignments import displacements as exercise
from marks import Marks

SLIPS = {
    "the sign of ε in equation (1) is dropped": (
        {"carried": ("q.conjugate().eps_conjugate()", "q.conjugate()")},
        {"carried-yours": 1, "carried-for-all": 2, "matrix-for-all": 2},
        "the sign of ε in the last factor is wrong",
    ),
    "a pose is taken to have length 1": (
        {"carried": ("(image / image.scalar_part)", "image")},
        {"carried-yours": 1, "carried-for-all": 2, "matrix-for-all": 2, "carry-yours": 2},
        "it is not divided by p p̄",
    ),
    "the conjugate is forgotten": (
        {"carried": ("q.conjugate().eps_conjugate()", "q.eps_conjugate()")},
        {"carried-yours": 1, "carried-for-all": 2, "matrix-for-all": 2},
        "the last factor is not conjugated",
    ),
    "the translation is not halved": (
        {"shift": (" / 2", "")},
        {"shift-for-all": 1, "pose-of-yours": 1, "pose-of-half-turns": 2, "carry-yours": 2},
        "the vector is halved: 1 + ½εv",
    ),
    "the moment is l × a": (
        {"half_turn_about": ("np.cross(a, l)", "np.cross(l, a)")},
        {"half-turn-yours": 1, "half-turn-for-all": 2, "turn-yours": 1, "turn-for-all": 2},
        "it is a × l, not l × a",
    ),
    "degrees for radians": (
        {"turn": ("    h =", "    angle = math.radians(angle)\n    h =")},
        {"turn-yours": 1, "turn-for-all": 2},
        "the angle is in radians, not in degrees",
    ),
    "the whole angle for its half": (
        {"turn": ("math.cos(angle / 2) + math.sin(angle / 2)", "math.cos(angle) + math.sin(angle)")},
        {"turn-yours": 1, "turn-for-all": 2},
        "the pose has half the angle",
    ),
    "the factors are in the wrong order": (
        {"in_turn": ("second * first", "first * second")},
        {"in-turn-for-all": 1},
        "the right factor acts first",
    ),
    "always the root of the trace, which fails for half-turns": (
        {"pose_of": ("max(multiples, key=lambda w: w.norm().scalar_part)", "multiples[0]")},
        {"pose-of-half-turns": 2},
        "w_v is 0 for this v",
    ),
    "rows and columns are exchanged": (
        {"matrix_of": ("for *row, shift in zip(*columns, t, strict=True)", "for row, shift in zip(columns, t)")},
        {"matrix-for-all": 2},
        "rows and columns of the rotation are exchanged",
    ),
    "the point is shifted the wrong way": (
        {
            "carried": (
                "return (image / image.scalar_part).coeffs[5:]",
                "turned = q.primal * (x[0] * i + x[1] * j + x[2] * k) * q.primal.conjugate()\n"
                "    t = (turned / q.primal.norm().scalar_part).coeffs[1:4]\n"
                "    return 2 * t - (image / image.scalar_part).coeffs[5:]",
            )
        },
        {"carried-yours": 1, "carried-for-all": 2, "matrix-for-all": 2},
        "that is where the displacement with the other sign of ε carries it",
    ),
    "the moment is missing": (
        {"half_turn_about": ("*np.cross(a, l)", "0, 0, 0")},
        {"half-turn-yours": 1, "half-turn-for-all": 2, "turn-yours": 1, "turn-for-all": 2},
        "the moment is missing: that line goes through the origin",
    ),
    "a point for the direction": (
        {"half_turn_about": ("np.subtract(b, a)", "np.array(b)")},
        {"half-turn-yours": 1, "half-turn-for-all": 2, "turn-yours": 1, "turn-for-all": 2},
        "that is the line through a with the direction b",
    ),
    "the direction has not length 1": (
        {"turn": (" / math.dist(a, b)", "")},
        {"turn-yours": 1, "turn-for-all": 2},
        "the direction must have length 1",
    ),
    "it turns the other way": (
        {"turn": ("+ math.sin", "- math.sin")},
        {"turn-yours": 1, "turn-for-all": 2},
        "it turns the other way",
    ),
    "the shift of the pose is missing": (
        {"pose_of": ("shift(matrix[:3, 3]) * max", "max")},
        {"pose-of-yours": 1, "pose-of-half-turns": 2},
        "the shift is missing",
    ),
    "it shifts first and turns then": (
        {
            "pose_of": (
                "shift(matrix[:3, 3]) * max(multiples, key=lambda w: w.norm().scalar_part)",
                "max(multiples, key=lambda w: w.norm().scalar_part) * shift(matrix[:3, 3])",
            )
        },
        {"pose-of-yours": 1, "pose-of-half-turns": 2},
        "it turns first and shifts then",
    ),
    "the way there for the way back": (
        {
            "carry": (
                "carry = shift(c - carried(flip, a)) * flip",
                "carry = (shift(c - carried(flip, a)) * flip).conjugate()",
            )
        },
        {"carry-yours": 2},
        "it is c that goes to a: that is the way back",
    ),
    "the student's own pose, whatever was written": (
        {"from_library": "def from_library(library, numbers):\n    return pose"},
        {"from-library-for-all": 2},
        "that is your own pose",
    ),
    "a neighbour's displacement": (
        {"carry": "carry = DualQuaternion([0, 2, 1, 2, 0, 3, 0, -3])"},
        {"carry-yours": 2},
        "where a goes: expected",
    ),
    "kinlib is asked": (
        {
            "carried": "import kinlib\n\n\ndef carried(q, x):\n    return kinlib.act(q, x)",
            "pose_of": "def pose_of(matrix):\n    return kinlib.from_matrix(matrix)",
        },
        {"carried-yours": 1, "carried-for-all": 2, "matrix-for-all": 2, "pose-of-yours": 1, "pose-of-half-turns": 2},
        "act of kinlib is the answer itself",
    ),
}

ANOTHER_WAY = {
    "carried": """
def rotation_and_shift(q):
    w, *v = (x / 1.0 for x in q.coeffs[:4])
    e, *u = (x / 1.0 for x in q.coeffs[4:])
    v, u = np.array(v), np.array(u)
    size = w * w + v @ v
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * (w * cross + cross @ cross) / size, 2 * (w * u - e * v + np.cross(v, u)) / size


def carried(q, x):
    R, t = rotation_and_shift(q)
    return tuple(R @ np.array(x, dtype=float) + t)
""",
    "shift": "def shift(v):\n    return DualQuaternion([-2, 0, 0, 0, 0, *(-1 * np.array(v))])",
    "half_turn_about": """
def half_turn_about(a, b):
    (a1, a2, a3), (b1, b2, b3) = a, b
    moment = (a2 * b3 - a3 * b2) * i + (a3 * b1 - a1 * b3) * j + (a1 * b2 - a2 * b1) * k
    return (a1 - b1) * i + (a2 - b2) * j + (a3 - b3) * k - eps * moment
""",
    "turn": """
def turn(a, b, angle):
    l = np.array(b, dtype=float) - a
    l /= np.linalg.norm(l)
    there = shift(np.array(a, dtype=float))
    back = shift(-np.array(a, dtype=float))
    return there * DualQuaternion([1 / math.tan(angle / 2), *l, 0, 0, 0, 0]) * back
""",
    "in_turn": "def in_turn(first, second):\n    return -(first.conjugate() * second.conjugate()).conjugate()",
    "matrix_of": """
def matrix_of(q):
    R, t = rotation_and_shift(q)
    return np.block([[R, t[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
""",
    "pose_of": """
def pose_of(matrix):
    M = np.array(matrix, dtype=float)
    R, t = M[:3, :3], M[:3, 3]
    squares = 1 + np.array([R.trace(), *(2 * R.diagonal() - R.trace())])
    best = int(squares.argmax())
    p = np.zeros(4)
    p[best] = np.sqrt(squares[best]) / 2
    skew = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    if best == 0:
        p[1:] = np.array(skew) / (4 * p[0])
    else:
        p[0] = skew[best - 1] / (4 * p[best])
        for n in {1, 2, 3} - {best}:
            p[n] = (R[n - 1, best - 1] + R[best - 1, n - 1]) / (4 * p[best])
    p = DualQuaternion([*p, 0, 0, 0, 0])
    return p + eps * DualQuaternion([0, *t, 0, 0, 0, 0]) * p / 2
""",
    "from_library": """
def from_library(library, numbers):
    p, d = np.array(numbers[:4]), np.array(numbers[4:])
    own = np.array(pose.coeffs)
    sample = np.array(samples[library])
    if (sample[:4] == own[:4]).all():
        return [*p, *-d]
    if sample[3] == own[0] and sample[0] == own[1]:
        return [p[3], *p[:3], d[3], *d[:3]]
    return [p[0], *-p[1:], d[0], *-d[1:]]
""",
    "carry": """
u, v = np.subtract(b, a), np.subtract(d, c)
axis = np.cross(u, v)
straight = turn((0, 0, 0), axis, math.atan2(np.linalg.norm(axis), u @ v))
carry = shift(c) * straight * shift(np.negative(a))
""",
}


class TestMarks(Marks):
    assignment = "displacements"
    numbers = {"data": "298a7af2144a4358", "conventions": "4347683ef0f2a642", "samples": "df341d7aec1c82f1"}  # noqa: RUF012
    slips = SLIPS
    pictures = ("displacements-picture",)
    another_way = ANOTHER_WAY


def test_numbers_are_well_conditioned():
    found = [exercise.data(f"student {n}") for n in range(1000)]
    assert len(set(found)) == len(found)
    assert len({one.pose for one in found}) > 960
    for pose, a, b, c, d in found:
        q = DualQuaternion(pose)
        assert 0 not in pose
        assert max(map(abs, pose)) <= 27
        assert study_form(q, q) == 0
        assert math.dist(a, b) == math.dist(c, d) >= 3
        assert np.any(np.cross(a, np.subtract(b, a)))
        assert abs(np.dot(np.subtract(b, a), np.subtract(d, c))) <= 0.9 * math.dist(a, b) ** 2


def test_libraries_can_be_told_apart():
    ways = [exercise.conventions(f"student {n}") for n in range(60)]
    assert {tuple(way.values()) for way in ways} == set(permutations(exercise.WAYS))
    q = DualQuaternion(exercise.data("ada").pose)
    for way in exercise.WAYS:
        others = [exercise.read(other, exercise.written(way, q)) for other in exercise.WAYS]
        assert [same_point(DualQuaternion(x), q) for x in others] == [other == way for other in exercise.WAYS]
