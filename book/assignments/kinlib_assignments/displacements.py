"""The assignment on displacements: each student has a pose, and two lines through two points each."""

from __future__ import annotations

import math
from itertools import permutations
from typing import NamedTuple

import numpy as np

from kinlib import (
    DualQuaternion,
    Line,
    MotionPolynomial,
    act,
    as_float,
    as_matrix,
    as_pose,
    half_turn,
    rotation,
    same_point,
    size,
    translation,
)
from kinlib_assignments.checks import assert_equal, assert_point, numbers
from kinlib_assignments.lot import Lot
from kinlib_assignments.withhold import defined_beside

__all__ = [
    "LIBRARIES", "SHORTCUTS", "Data", "assert_carried", "assert_carries", "assert_in_turn", "assert_matrix",
    "assert_pose_of_matrix", "assert_read", "assert_shift", "assert_through", "assert_turn", "conventions", "data",
    "samples", "written",
]  # fmt: skip

LIBRARIES = ("A", "B", "C")
"""The names of three libraries that write poses in ways of their own."""

VECTORS = {3: ((1, 2, 2),), 7: ((2, 3, 6),), 9: ((1, 4, 8), (4, 4, 7))}
"""Vectors with whole coordinates, by their length."""


class Data(NamedTuple):
    """A pose as eight whole numbers; points with whole coordinates, c and d at the same distance as a and b."""

    pose: tuple[int, ...]
    a: tuple[int, ...]
    b: tuple[int, ...]
    c: tuple[int, ...]
    d: tuple[int, ...]


def data(student: str) -> Data:
    """A pose whose primal part has not length 1, and two pairs of points whose lines miss the origin.

    Examples
    --------
    >>> found = data("ada")
    >>> len(found.pose), math.dist(found.a, found.b) == math.dist(found.c, found.d)
    (8, True)
    """
    lot = Lot("displacements", student)
    pose = lot.until(lambda: _pose(lot.wholes(3, 3), lot.wholes(4, 3)), _is_telling)
    length = lot.choice(tuple(VECTORS))
    a, b = lot.until(lambda: _segment(lot, length), _misses_origin)
    c, d = lot.until(lambda: _segment(lot, length), lambda found: _misses_origin(found) and _is_another((a, b), found))
    return Data(pose, a, b, c, d)


def _pose(half_shift: list[int], primal: list[int]) -> tuple[int, ...]:
    """The coefficients of (1 + εv) p; no function that may be withheld is used, so students may draw their data."""
    v, p = DualQuaternion([1, 0, 0, 0, 0, *half_shift]), DualQuaternion([*primal, 0, 0, 0, 0])
    return tuple((v * p).coeffs)


def _segment(lot: Lot, length: int) -> tuple[tuple[int, ...], ...]:
    start = lot.wholes(3, 3)
    vector = [lot.choice((-1, 1)) * x for x in lot.shuffled(lot.choice(VECTORS[length]))]
    return tuple(start), tuple(x + y for x, y in zip(start, vector, strict=True))


def _misses_origin(segment) -> bool:
    """Whether the line through two points is at least a tenth of their distance away from the origin."""
    a, b = np.array(segment)
    moment, square = np.cross(a, b - a), (b - a) @ (b - a)
    return bool(100 * (moment @ moment) >= square * square)


def _is_another(first, second) -> bool:
    """Whether two segments of one length have directions that are well apart, either way."""
    (a, b), (c, d) = np.array(first), np.array(second)
    return bool(abs((b - a) @ (d - c)) <= 0.9 * ((b - a) @ (b - a)))


def _is_telling(pose: tuple[int, ...]) -> bool:
    """Whether no coefficient is zero, and what two libraries write cannot be taken for each other."""
    if 0 in pose:
        return False
    q = DualQuaternion(pose)
    mistaken = [read(way, written(other, q)) for way, other in permutations(WAYS, 2)]
    return not np.any(same_point(DualQuaternion(mistaken), q))


# ---- three libraries ---------------------------------------------------------------------------------

WAYS = ("sign", "order", "return")
"""What a library does in another way: the sign of ε, the scalars last, the displacement back."""


def conventions(student: str) -> dict[str, str]:
    """Which library has which way of its own: ``sign``, ``order`` or ``return``.

    Examples
    --------
    >>> sorted(conventions("ada").values())
    ['order', 'return', 'sign']
    """
    lot = Lot("displacements, libraries", student)
    return dict(zip(LIBRARIES, lot.choice(tuple(permutations(WAYS))), strict=True))


def written(way: str, q: DualQuaternion) -> tuple[int, ...]:
    """Eight numbers, as a library writes a pose.

    Parameters
    ----------
    way : str
        ``sign``: ε has the opposite sign.  ``order``: the scalar is the last number of each part.  ``return``: the
        displacement from the fixed to the moving frame.
    q : DualQuaternion

    Examples
    --------
    >>> q = DualQuaternion([1, 2, 3, 4, 5, 6, 7, 8])
    >>> written("order", q)
    (2, 3, 4, 1, 6, 7, 8, 5)
    """
    return tuple(WRITE[way](q))


WRITE = {
    "sign": lambda q: q.eps_conjugate().coeffs,
    "order": lambda q: q.coeffs[[1, 2, 3, 0, 5, 6, 7, 4]],
    "return": lambda q: q.conjugate().coeffs,
}


def read(way: str, numbers) -> list:
    """The other way round: eight numbers in our convention."""
    if way == "order":
        return [numbers[n] for n in (3, 0, 1, 2, 7, 4, 5, 6)]
    return list(written(way, DualQuaternion(numbers)))


def samples(student: str) -> dict[str, tuple[int, ...]]:
    """How the three libraries write the student's pose.

    Examples
    --------
    >>> list(samples("ada"))
    ['A', 'B', 'C']
    """
    q = DualQuaternion(data(student).pose)
    return {name: written(way, q) for name, way in conventions(student).items()}


# ---- checks ------------------------------------------------------------------------------------------


def _wrong_images(q: DualQuaternion, x) -> dict[str, np.ndarray]:
    """Where slips in equation (1) carry a point."""
    right, turned = act(q, x), act(q.primal, x)
    return {
        "the sign of ε in the last factor is wrong: the point is turned well, but not shifted": turned,
        "the last factor is not conjugated": _image(q, x, q.eps_conjugate()),
        "it is not divided by p p̄: a pose may have any length": right * q.norm().scalar_part,
        "that is where the displacement with the other sign of ε carries it": act(q.eps_conjugate(), x),
        "that is the way back: the conjugate comes last": act(q.conjugate(), x),
        "the shift is twice too large: the point is 1 + εx": right + (right - turned),
    }


def _image(q: DualQuaternion, x, last: DualQuaternion) -> np.ndarray:
    return (q * DualQuaternion([1, 0, 0, 0, 0, *x]) * last / q.norm().scalar_part).coeffs[5:]


def assert_carried(answer, q, x) -> None:
    """Fail unless the answer is where the pose q carries the point x; say which slip it looks like.

    Examples
    --------
    >>> assert_carried((1, 5, 0), translation([0, 4, 0]), (1, 1, 0))
    """
    q = DualQuaternion(q) if not isinstance(q, DualQuaternion) else q
    assert_equal(answer, act(q, x), "the point that was carried", _wrong_images(q, x))


def _assert_pose(answer, expected: DualQuaternion, what: str, slips: dict[str, DualQuaternion]) -> None:
    """Fail unless the answer is a pose, up to a factor and to rounding."""
    point = as_float(numbers(answer, (8,), what))
    assert_point(point, expected.astype(float), what, {said: q.astype(float) for said, q in slips.items()})


def assert_shift(answer, v) -> None:
    """Fail unless the answer is the translation by v."""
    right = translation(v)
    slips = {
        "the vector is halved: 1 + ½εv": translation(2 * np.array(v)),
        "the sign of ε is wrong: that is the translation by −v": right.eps_conjugate(),
        "the shift is a quarter of v now: it is halved once only": translation(np.array(v) / 2),
    }
    _assert_pose(answer, right, "the translation", slips)


def assert_through(answer, a, b) -> None:
    """Fail unless the answer is the half-turn about the line through two points."""
    right = half_turn(Line.through(a, b))
    slips = {
        "the moment has the wrong sign: it is a × l, not l × a": right.eps_conjugate(),
        "the moment is missing: that line goes through the origin": right.primal,
        "that is the line through a with the direction b: its direction is b − a": half_turn(Line.at(a, b)),
    }
    _assert_pose(answer, right, "the half-turn", slips)


def assert_turn(answer, a, b, angle: float) -> None:
    """Fail unless the answer is the rotation about the line from a to b by an angle in radians."""
    line = Line.through(a, b)
    cosine, sine = math.cos(angle / 2), math.sin(angle / 2)
    slips = {
        "it turns twice as far: the pose has half the angle": rotation(line, 2 * angle),
        "it turns half as far: halve the angle once only": rotation(line, angle / 2),
        "it turns the other way: counter-clockwise when b − a points at you": rotation(line, -angle),
        "the angle is in radians, not in degrees": rotation(line, math.radians(angle)),
        "the direction must have length 1": cosine + sine * half_turn(line),
        "the axis has the wrong moment: a × l": rotation(line, angle).eps_conjugate(),
        "that turns about a parallel line through the origin: the moment is missing": rotation(line, angle).primal,
    }
    assert_point(answer, rotation(line, angle), "the rotation", slips)


def assert_read(answer, q: DualQuaternion, library: str) -> None:
    """Fail unless the answer is the pose q, which a library wrote in its own way."""
    _assert_pose(answer, q, f"the pose that library {library} wrote", {})


def assert_in_turn(answer, first, second) -> None:
    """Fail unless the answer is the pose of first the one, then the other displacement."""
    slips = {"the right factor acts first: that is the second displacement, then the first": first * second}
    _assert_pose(answer, second * first, "one displacement after the other", slips)


def assert_matrix(answer, q) -> None:
    """Fail unless the answer is the 4×4 matrix of the pose q."""
    q = DualQuaternion(q) if not isinstance(q, DualQuaternion) else q
    right = as_matrix(q)
    mirrored, doubled = right.copy(), right.copy()
    mirrored[:3, :3], doubled[:3, 3] = right[:3, :3].T, 2 * right[:3, 3]
    slips = {
        "rows and columns of the rotation are exchanged: its columns are the turned axes": mirrored,
        "the whole matrix is transposed: the shift is its last column": right.T,
        "that is the matrix of the way back": as_matrix(q.conjugate()),
        "the shift has the wrong sign": as_matrix(q.eps_conjugate()),
        "it is not divided by p p̄: a pose may have any length": right * q.norm().scalar_part,
        "the shift is missing: where does the origin go?": as_matrix(q.primal),
        "the shift is twice too large": doubled,
        "the coordinate 1 stands first here: it comes last": np.roll(right, 1, axis=(0, 1)),
    }
    assert_equal(answer, right, "the matrix", slips)


def assert_pose_of_matrix(answer, q: DualQuaternion) -> None:
    """Fail unless the answer is the pose q, which was given by its matrix."""
    shift = translation(as_matrix(q)[:3, 3])
    slips = {
        "the shift has the wrong sign": q.eps_conjugate(),
        "it turns the wrong way: that is the pose of the transposed rotation": shift * q.primal.conjugate(),
        "it turns first and shifts then, so the translation is the left factor": q.primal * shift,
        "the shift is not halved: the translation by t is 1 + ½εt": shift * q,
        "the shift is missing": q.primal,
    }
    _assert_pose(answer, q, "the pose of the matrix", slips)


def assert_carries(answer, found: Data) -> None:
    """Fail unless the answer is a pose that carries a to c and b to d."""
    try:
        q = as_pose(DualQuaternion(numbers(answer, (8,), "the displacement")))
    except ValueError as error:
        raise AssertionError(f"the displacement: {error}") from error
    is_back = size(act(q, found.c) - found.a) < 1e-9
    back = {"it is c that goes to a: that is the way back": act(q, found.a)} if is_back else {}
    assert_equal(act(q, found.a), found.c, "where a goes", back)
    reflected = [2 * x - y for x, y in zip(found.c, found.d, strict=True)]
    slips = {"a goes to c and your line to the other, but it runs the other way": reflected}
    assert_equal(act(q, found.b), found.d, "where b goes", slips)


# ---- what is withheld --------------------------------------------------------------------------------

SHORTCUTS = (
    *defined_beside(act), as_pose, Line.as_dual_quaternion, Line.at.__func__, Line.through.__func__,
    MotionPolynomial.trajectory, read,
)  # fmt: skip
"""Functions that are the answer to a task, or nearly so: refused while answers are marked."""
