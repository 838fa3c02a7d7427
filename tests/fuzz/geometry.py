"""Is a refusal true?  How near problems are to each degeneracy, in 50 digits, by formulas of their own.

Each measure is 0 where the problem is degenerate and about 1 where it is far from it: angles in radians, lengths
in units of the problem's length, places in the plane of z in units of the triangle.  A refusal is true if what it
names is nearer than :data:`BORDER`, or if it is near and something else is near as well, so that their product is less
than :data:`BOTH`; if it names nothing known, if anything is.
"""

from __future__ import annotations

from itertools import combinations, product

import mpmath as mp
import numpy as np
from mpmath.libmp import NoConvergence

from tests.fuzz.judge import ROUNDING, frame_of

mp.mp.dps = 50
BORDER = 1e-5
BOTH = 1e-8

KIN = (
    {"equal", "translation", "meets E", "parallel", "cubic meets E"},
    {"rotation", "inside the Study quadric"},
    {"dependent", "not real", "missed"},
    {"z real", "side", "Bennett corner", "circumcircle"},
)
"""Measures that go to zero together: these are one degeneracy, not two."""

# What a message may say, and the measures that make it true.
CLAIMS = {
    "neither family": ("not real",),
    "gram determinant": ("not real",),
    "double root": ("double roots",),
    "one 2r dyad": ("double roots",),
    "dependent": ("dependent",),
    "on the conic": ("dependent",),
    "in the study quadric": ("inside the Study quadric",),
    "one point": ("inside the Study quadric",),
    "tangent": ("rotation",),
    "by a rotation": ("rotation",),
    "by rotations": ("rotation",),
    "translation": ("translation", "equal"),
    "equal": ("equal",),
    "parallel": ("parallel",),
    "exceptional": ("meets E", "cubic meets E"),
    "misses": ("missed", "side"),
    "z is real": ("z real",),
    "real z": ("z real",),
    "belongs to the bennett": ("Bennett corner",),
    "circumcircle": ("circumcircle",),
    "side of the triangle": ("side",),
    "√−1": ("√−1",),
    "incentre": ("in- or excentre",),
    "excentre": ("in- or excentre",),
    "no factorization": ("cubic meets E", "repeated factors"),
    "number field": ("exact",),
    "powers of t": ("powers of t",),
}


def is_true(message: str, measures: dict, reach: float = 0.0) -> tuple[bool, str]:
    """Whether a refusal holds, and why; ``reach`` is the distance from the origin in lengths of the problem."""
    border = max(BORDER, 1e3 * ROUNDING * reach)
    text = message.lower()
    named = {reason for claim, reasons in CLAIMS.items() if claim in text for reason in reasons}
    known = {reason: measures[reason] for reason in named if reason in measures}
    nearest = min(measures, key=measures.get)
    if known:
        best = min(known, key=known.get)
        kin = set().union({best}, *(kin for kin in KIN if best in kin))
        second = min([1.0, *(measure for reason, measure in measures.items() if reason not in kin)])
        truth = known[best] <= border or known[best] * second <= BOTH
        other = "" if truth else f"; nearest is {nearest}, {measures[nearest]:.1e}"
        return truth, f"{best} at {known[best]:.1e}{other}"
    return measures[nearest] <= border, f"names nothing known; nearest is {nearest}, {measures[nearest]:.1e}"


# --- poses ------------------------------------------------------------------------------------------------------


def _exactly(x):
    """A float, whole number or fraction in 50 digits."""
    if hasattr(x, "numerator") and hasattr(x, "denominator"):
        return mp.mpf(int(x.numerator)) / int(x.denominator)
    return mp.mpf(float(x))


def _unit(q) -> list:
    norm = mp.sqrt(sum(x * x for x in q[:4]))
    return [x / norm for x in q]


def _hamilton(p, r) -> list:
    return [
        p[0] * r[0] - p[1] * r[1] - p[2] * r[2] - p[3] * r[3],
        p[0] * r[1] + p[1] * r[0] + p[2] * r[3] - p[3] * r[2],
        p[0] * r[2] - p[1] * r[3] + p[2] * r[0] + p[3] * r[1],
        p[0] * r[3] + p[1] * r[2] - p[2] * r[1] + p[3] * r[0],
    ]


def _times(a, b) -> list:
    p, d, r, e = a[:4], a[4:], b[:4], b[4:]
    dual = [x + y for x, y in zip(_hamilton(p, e), _hamilton(d, r), strict=True)]
    return _hamilton(p, r) + dual


def _conjugate(q) -> list:
    return [x * s for x, s in zip(q, (1, -1, -1, -1) * 2, strict=True)]


def _length(vector):
    return mp.sqrt(sum(x * x for x in vector))


def _cross(a, b) -> list:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _study(x, y):
    return sum(x[n] * y[n + 4] + x[n + 4] * y[n] for n in range(4))


def _null(x, y):
    return sum(x[n] * y[n] for n in range(4))


class Poses:
    """The poses of one problem, of unit length, with the middle as origin and the length as unit."""

    def __init__(self, poses):
        frame = frame_of(np.asarray(poses, dtype=float)[:, None, :])
        self.length = float(frame.length[0]) or 1e-300
        self.reach = float(frame.reach[0]) / self.length
        home = [mp.mpf(1), 0, 0, 0, 0, *(-x / 2 for x in map(mp.mpf, frame.middle[0].tolist()))]
        first = _unit([_exactly(x) for x in poses[0]])
        seen = [_times(_unit([_exactly(x) for x in pose]), _conjugate(first)) for pose in poses]
        moved = [_times(_times(home, q), _conjugate(home)) for q in seen]
        self.seen = [q[:4] + [x / mp.mpf(self.length) for x in q[4:]] for q in moved]

    def pairs(self) -> list:
        return [_times(y, _conjugate(x)) for x, y in combinations(self.seen, 2)]

    def measures(self) -> dict:
        """The distance from what can be wrong with any poses."""
        turns = [2 * mp.asin(min(1, _length(q[1:4]))) for q in self.pairs()]
        shifts = [2 * _length(_hamilton(q[4:], _conjugate(q)[:4])[1:]) for q in self.pairs()]
        tangent = [abs(2 * q[4]) / _length(q[1:4]) if any(q[1:4]) else mp.mpf(0) for q in self.pairs()]
        return {
            "equal": float(min(max(a, s) for a, s in zip(turns, shifts, strict=True))),
            "translation": float(min(turns)),
            "rotation": float(min(tangent)),
            "inside the Study quadric": float(max(tangent)),
        }


def of_three_poses(poses) -> dict:
    """The measures of three poses."""
    problem = Poses(poses)
    _, q1, q2 = problem.seen
    crossed = _length(_cross(q1[1:4], q2[1:4]))
    lengths = _length(q1[1:4]) * _length(q2[1:4])
    return {
        **problem.measures(),
        "powers of t": _digits_of_conic(problem),
        "meets E": float(crossed),
        "parallel": float(crossed / lengths) if lengths else 0.0,
        "double roots": _gap_of_eigenvalues(problem.seen),
    }


def _digits_of_conic(problem: Poses) -> float:
    """What is left of the digits of the conic's value at t = 1 if it is added up from powers of t."""
    one, q1, q2 = problem.seen
    b01, b02, b12 = _study(one, q1), _study(one, q2), _study(q1, q2)
    if not b12:
        return 1.0
    constant, last = [x * b02 / b12 for x in q1[:4]], [x * b01 / b12 for x in q2[:4]]
    linear = [y - x - w for w, x, y in zip(one, constant, last, strict=False)]
    return float(_length(last) / (1 + _length(linear) + _length(constant)) / (1 + problem.reach))


def _gap_of_eigenvalues(seen) -> float:
    """The smaller gap of the eigenvalues of the Study form relative to the null form, over the larger."""
    S, N = (mp.matrix(3, 3) for _ in "SN")
    for m, n in product(range(3), repeat=2):
        S[m, n], N[m, n] = _study(seen[m], seen[n]), _null(seen[m], seen[n])
    if abs(_determinant(N)) < mp.mpf(10) ** -90:
        return 0.0
    A = mp.inverse(N) * S
    middle = (A[0, 0] + A[1, 1] + A[2, 2]) / 3
    B = A - middle * mp.eye(3)
    square = sum(B[m, n] * B[n, m] for m, n in product(range(3), repeat=2)) / 6
    if square <= 0:
        return 0.0
    angle = mp.acos(max(-1, min(1, _determinant(B) / (2 * square * mp.sqrt(square))))) / 3  # the roots by cosines
    low, mean, high = sorted(mp.cos(angle + 2 * mp.pi * n / 3) for n in range(3))
    return float(min(high - mean, mean - low) / (high - low))


def _determinant(M):
    """Of a 3×3 matrix; mpmath's own stumbles over singular ones."""
    rows = [[M[m, n] for n in range(3)] for m in range(3)]
    return sum(x * y for x, y in zip(rows[0], _cross(rows[1], rows[2]), strict=True))


# --- the plane of z ---------------------------------------------------------------------------------------------


def of_z(poses, z) -> dict:
    """The measures of three poses with a z: those of z are the least over the four planes."""
    measures = of_three_poses(poses)
    z = mp.mpc(_exactly(z.real), _exactly(z.imag))
    try:
        for sA, sB in _planes(Poses(poses).seen):
            for name, measure in _of_plane(z, sB, [a + 1j for a in sA]).items():
                measures[name] = min(measures.get(name, 1.0), float(measure))
    except (ZeroDivisionError, NoConvergence):  # the poses themselves have no plane
        pass
    return measures


def _of_plane(z, sB, u) -> dict:
    """One plane: z and its partner are tried for all bad places."""
    triangle = max(abs(sB[0] - sB[1]), abs(_corner(sB, u) - sB[0]))
    w = [(s - z) * x for s, x in zip(sB, u, strict=True)]
    sides = [abs(mp.im(x)) / abs(x) if x else mp.mpf(0) for x in w]
    circle = abs(mp.im(w[0] * mp.conj(w[1]))) / (abs(w[0] * w[1]) or 1)
    found = {
        "z real": abs(mp.im(z)) / (abs(z) + abs(sB[0]) + abs(sB[1])),
        "Bennett corner": min(max(sides), abs(_corner(sB, u) - z) / triangle),
        "circumcircle": circle,
        "side": min(sides),
        "√−1": min(abs(z - 1j), abs(z + 1j)),
    }
    if circle:
        partner = _corner(sB, w)
        scale = abs(z) + abs(partner)
        found["side"] = min(found["side"], abs(mp.im(partner)) / scale)
        found["√−1"] = min(found["√−1"], abs(partner - 1j), abs(partner + 1j))
        found["in- or excentre"] = min(abs(z - partner), abs(z - mp.conj(partner))) / scale
    return found


def _corner(sB, u):
    """The common point of the lines Im (s_B − z) u = 0."""
    (s, x), (r, y) = zip(sB, u, strict=True)
    determinant = mp.im(x) * mp.re(y) - mp.re(x) * mp.im(y)
    a, b = s * mp.im(x), r * mp.im(y)
    return mp.mpc((a * mp.re(y) - mp.re(x) * b) / determinant, (mp.im(x) * b - a * mp.im(y)) / determinant)


def _planes(seen) -> list:
    """The parameters (s_A, s_B) of both poses for each of the four joints that may turn twice.

    The dyads are found from the conic: its norm has two quadratic factors, and each order of them gives one.  The
    half-turns point so that the parameters increase from the second pose to the third, as kinlib documents.
    """
    one, q1, q2 = seen
    b01, b02, b12 = _study(one, q1), _study(one, q2), _study(q1, q2)
    c0 = [x * b02 / b12 for x in q1]
    c1 = [y * b01 / b12 - x - w for w, x, y in zip(one, c0, q2, strict=True)]
    quartic = [1, 2 * _null(one, c1), _null(c1, c1) + 2 * _null(one, c0), 2 * _null(c1, c0), _null(c0, c0)]
    roots = sorted(mp.polyroots(quartic, maxsteps=200, extraprec=200), key=lambda r: -mp.im(r))[:2]
    planes = []
    for root in roots:
        h2 = _right_factor(c1, c0, root)
        h1 = [-x - y for x, y in zip(c1, h2, strict=True)]
        k1, k2 = ([mp.mpf(0), *(x / _length(h[1:4]) for x in h[1:4]), 0, 0, 0, 0] for h in (h1, h2))
        t = [_turns(k1, k2, q) for q in (q1, q2)]
        base, moving = zip(*t, strict=True)
        planes += [(base, moving), (moving, base)]
    return planes


def _right_factor(c1, c0, root) -> list:
    """The h for which t − h divides t² + c1 t + c0 from the right, with (t − root)(t − its conjugate)."""
    r1 = list(c1)
    r1[0] += 2 * mp.re(root)
    r0 = list(c0)
    r0[0] -= abs(root) ** 2
    a, b = _null(r1, r1), _study(r1, r1)
    inverse = [x / a for x in _conjugate(r1)]
    inverse[4:] = [y - x * b / a for x, y in zip(inverse[:4], inverse[4:], strict=True)]
    return [-x for x in _times(inverse, r0)]


def _turns(k1, k2, q) -> tuple:
    """The s1, s2 with (s1 − k1)(s2 − k2) in the orientation of q."""
    rows = [[mp.mpf(1), 0, 0, 0], k1[:4], k2[:4], _hamilton(k1[:4], k2[:4])]
    _, x1, x2, x3 = mp.lu_solve(mp.matrix(rows).T, mp.matrix(q[:4]))
    return -x2 / x3, -x1 / x3


# --- four poses -------------------------------------------------------------------------------------------------


def of_four_poses(poses, free=0) -> dict:
    """The measures of four poses, with those of the cubics for a value of the free parameter."""
    problem = Poses(poses)
    measures = problem.measures()
    rows = np.array([[float(x) for x in q] for q in problem.seen])
    singular = np.linalg.svd(rows / np.linalg.norm(rows, axis=1)[:, None], compute_uv=False)
    measures["dependent"] = float(singular[-1] / singular[0])
    p = problem.seen
    x, y, z = _study(p[0], p[1]) * _study(p[2], p[3]), _study(p[0], p[2]) * _study(p[1], p[3]), 0
    z = _study(p[0], p[3]) * _study(p[1], p[2])
    scale = max(abs(x), abs(y), abs(z)) or mp.mpf(1)
    discriminant = ((x - y - z) ** 2 - 4 * y * z) / scale**2
    measures["not real"] = float(max(discriminant, 0))
    if discriminant > 0 and z:
        for sign in (1, -1):
            _of_cubic(p, (-(x - y - z) + sign * mp.sqrt(discriminant) * scale) / (2 * z), free, measures)
    if "powers of t" in measures:
        measures["powers of t"] /= 1 + problem.reach
    return measures


def _of_cubic(p, t3, free, measures) -> None:
    """What can be wrong with the cubic whose fourth parameter is t3, as cubics_through defines its family."""
    t = [mp.mpf(0), mp.mpf(1), t3]
    b = [_study(p[0], q) for q in p[1:]]
    b12, b13, b23 = _study(p[1], p[2]), _study(p[1], p[3]), _study(p[2], p[3])
    try:
        kernel = [b23 / (1 - t3), b13 / t3, -b12]
        total = sum(k * k for k in kernel)
        special = [v / total for v in _cross(b, kernel)]
        weights = [s + _exactly(free) * k * b[0] / (b12 * b13) for s, k in zip(special, kernel, strict=True)]
    except ZeroDivisionError:
        return
    largest = max(abs(w) for w in weights)
    missed = min(abs(w) for w in weights) / largest
    measures["missed"] = min(measures.get("missed", 1.0), float(missed))
    measures["powers of t"] = min(measures.get("powers of t", 1.0), _digits_of_cubic(p, weights, t))
    try:
        roots = mp.polyroots(_norm_of(_coefficients(p, weights, t)), maxsteps=500, extraprec=400)
    except NoConvergence:  # roots that (nearly) agree
        measures["repeated factors"] = 0.0
        return
    upper = sorted(roots, key=lambda r: -mp.im(r))[:3]
    meets = min(abs(mp.im(r)) / (1 + abs(r)) for r in upper)
    apart = min(abs(r - s) / (1 + abs(r)) for r, s in combinations(upper, 2))
    measures["cubic meets E"] = min(measures.get("cubic meets E", 1.0), float(meets))
    measures["repeated factors"] = min(measures.get("repeated factors", 1.0), float(apart))


def _coefficients(p, weights, t) -> list:
    """The primal parts of the coefficients of C = p0 Π (t − t_j) + Σ λ_j p_j Π_{m≠j} (t − t_m), highest power first."""
    coefficients = [[mp.mpf(0)] * 4 for _ in range(4)]

    def add(q, polynomial):
        for n, c in enumerate(polynomial, start=4 - len(polynomial)):
            coefficients[n] = [x + y * c for x, y in zip(coefficients[n], q[:4], strict=True)]

    a, b, c = t
    add(p[0], [1, -(a + b + c), a * b + b * c + c * a, -a * b * c])
    for j, weight in enumerate(weights):
        r, s = (t[m] for m in range(3) if m != j)
        add([x * weight for x in p[j + 1]], [1, -(r + s), r * s])
    return coefficients


def _norm_of(coefficients) -> list:
    """C C̄, highest power first."""
    total = [mp.mpf(0)] * 7
    for m, n in product(range(4), repeat=2):
        total[m + n] += sum(x * y for x, y in zip(coefficients[m], coefficients[n], strict=True))
    return total


def _digits_of_cubic(p, weights, t) -> float:
    """What is left of the digits of the cubic's values in the poses if they are added up from powers of t."""
    sizes, left = [_length(c) for c in _coefficients(p, weights, t)], mp.mpf(1)
    for n, (weight, s) in enumerate(zip(weights, t, strict=True)):
        others = [s - r for m, r in enumerate(t) if m != n]
        terms = sum(size * abs(s) ** power for size, power in zip(sizes, (3, 2, 1, 0), strict=True))
        left = min(left, abs(weight) * _length(p[n + 1][:4]) * abs(others[0] * others[1]) / terms)
    return float(left)
