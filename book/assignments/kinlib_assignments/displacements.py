"""The assignment on displacements: each student has a pose, and two lines through two points each."""

from __future__ import annotations

import math
from collections.abc import Callable
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
from kinlib_assignments.seal import seal
from kinlib_assignments.withhold import answer_of, defined_beside

__all__ = [
    "LIBRARIES", "Data", "check_carried", "check_carried_floats", "check_carry", "check_half_turn",
    "check_half_turn_elsewhere", "check_in_turn", "check_matrix", "check_pose_of", "check_pose_of_half_turns",
    "check_readings", "check_shift", "check_turn", "check_turn_elsewhere", "data", "samples",
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
    image = q * DualQuaternion([1, 0, 0, 0, 0, *x]) * last
    return (image / (image.scalar_part or 1)).coeffs[5:]


def _assert_carried(answer, q, x) -> None:
    """Fail unless the answer is where the pose q carries the point x; say which slip it looks like.

    Examples
    --------
    >>> _assert_carried((1, 5, 0), translation([0, 4, 0]), (1, 1, 0))
    """
    q = DualQuaternion(q) if not isinstance(q, DualQuaternion) else q
    assert_equal(answer, act(q, x), "the point that was carried", _wrong_images(q, x))


def _assert_pose(answer, expected: DualQuaternion, what: str, slips: dict[str, DualQuaternion]) -> None:
    """Fail unless the answer is a pose, up to a factor and to rounding."""
    point = as_float(numbers(answer, (8,), what))
    assert_point(point, expected.astype(float), what, {said: q.astype(float) for said, q in slips.items()})


def _assert_shift(answer, v) -> None:
    """Fail unless the answer is the translation by v."""
    right = translation(v)
    slips = {
        "the vector is halved: 1 + ½εv": translation(2 * np.array(v)),
        "the sign of ε is wrong: that is the translation by −v": right.eps_conjugate(),
        "the shift is a quarter of v now: it is halved once only": translation(np.array(v) / 2),
    }
    _assert_pose(answer, right, "the translation", slips)


def _assert_through(answer, a, b) -> None:
    """Fail unless the answer is the half-turn about the line through two points."""
    right = half_turn(Line.through(a, b))
    slips = {
        "the moment has the wrong sign: it is a × l, not l × a": right.eps_conjugate(),
        "the moment is missing: that line goes through the origin": right.primal,
        "that is the line through a with the direction b: its direction is b − a": half_turn(Line.at(a, b)),
    }
    _assert_pose(answer, right, "the half-turn", slips)


def _assert_turn(answer, a, b, angle: float) -> None:
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


def _assert_read(answer, q: DualQuaternion, library: str, way: str, own: DualQuaternion) -> None:
    """Fail unless the answer is the pose q, which a library wrote in its own way."""
    numbers = written(way, q)
    slips = {f"that would be right for the library {what}": read(one, numbers) for one, what in WAYS_IN_WORDS.items()}
    slips = {said: DualQuaternion(value) for said, value in slips.items()}
    slips["these are its numbers as they are: none of the libraries writes as we do"] = DualQuaternion(numbers)
    slips["that is your own pose, but the library may write any"] = own
    right = slips.pop(f"that would be right for the library {WAYS_IN_WORDS[way]}")
    _assert_pose(answer, right, f"the pose that library {library} wrote", slips)


WAYS_IN_WORDS = {
    "sign": "with the other sign of ε",
    "order": "that writes scalars last",
    "return": "that writes the displacement back",
}


def _assert_in_turn(answer, first, second) -> None:
    """Fail unless the answer is the pose of first the one, then the other displacement."""
    slips = {"the right factor acts first: that is the second displacement, then the first": first * second}
    _assert_pose(answer, second * first, "one displacement after the other", slips)


def _assert_matrix(answer, q) -> None:
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


def _assert_pose_of_matrix(answer, q: DualQuaternion) -> None:
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


def _assert_carries(answer, found: Data) -> None:
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


# ---- checks of functions, on the numbers of a student ----------------------------------------------------


def _another(student: str) -> Data:
    """Other numbers that belong to a student too."""
    return data(f"{student}, another")


def check_carried(carried: Callable, student: str) -> None:
    """Fail unless a function carries a student's points by a student's pose."""
    own = data(student)
    for x in (own.a, own.d):
        answer = answer_of(carried, DualQuaternion(own.pose), x, without=SHORTCUTS)
        _assert_carried(answer, own.pose, x)


def check_carried_floats(carried: Callable, student: str) -> None:
    """Fail unless it does so for a pose of any length, exact or in floats."""
    own = _another(student)
    for q in (-2 * DualQuaternion(own.pose), 0.7 * DualQuaternion(own.pose).astype(float)):
        _assert_carried(answer_of(carried, q, own.c, without=SHORTCUTS), q, own.c)


def check_shift(shift: Callable, student: str) -> None:
    """Fail unless a function gives translations."""
    for v in (np.subtract(data(student).b, data(student).a).tolist(), (0.5, -1.25, 3.0), (1, 0, 0)):
        _assert_shift(answer_of(shift, v, without=SHORTCUTS), v)


def check_half_turn(half_turn_about: Callable, student: str) -> None:
    """Fail unless a function gives the half-turn about a student's line."""
    a, b = data(student)[1:3]
    _assert_through(answer_of(half_turn_about, a, b, without=SHORTCUTS), a, b)


def check_half_turn_elsewhere(half_turn_about: Callable, student: str) -> None:
    """Fail unless it does so for other lines, one through the origin among them."""
    for a, b in (data(student)[3:], _another(student)[1:3], ((0, 0, 0), data(student).b)):
        _assert_through(answer_of(half_turn_about, a, b, without=SHORTCUTS), a, b)


def check_turn(turn: Callable, student: str) -> None:
    """Fail unless a function gives a rotation about a student's line."""
    a, b = data(student)[1:3]
    _assert_turn(answer_of(turn, a, b, 2.0, without=SHORTCUTS), a, b, 2.0)


def check_turn_elsewhere(turn: Callable, student: str) -> None:
    """Fail unless it does so for other lines and angles, either way round."""
    for (a, b), angle in ((data(student)[3:], 0.3), (_another(student)[1:3], -1.7), (_another(student)[3:], 2.9)):
        _assert_turn(answer_of(turn, a, b, angle, without=SHORTCUTS), a, b, angle)


def _poses(student: str) -> list[DualQuaternion]:
    return [DualQuaternion(found.pose) for found in (data(student), _another(student))]


def check_in_turn(in_turn: Callable, student: str) -> None:
    """Fail unless a function composes two poses of a student in their order."""
    own, other = _poses(student)
    for first, second in ((own, other), (other, own)):
        _assert_in_turn(answer_of(in_turn, first, second, without=SHORTCUTS), first, second)


def check_matrix(matrix_of: Callable, student: str) -> None:
    """Fail unless a function gives the matrices of a student's poses."""
    for q in _poses(student):
        _assert_matrix(answer_of(matrix_of, q, without=SHORTCUTS), q)


def check_pose_of(pose_of: Callable, student: str) -> None:
    """Fail unless a function gives the poses of a student's matrices, exact or in floats."""
    for q in _poses(student):
        for matrix in (as_matrix(q), as_matrix(q).astype(float)):
            _assert_pose_of_matrix(answer_of(pose_of, matrix, without=SHORTCUTS), q)


def check_pose_of_half_turns(pose_of: Callable, student: str) -> None:
    """Fail unless it does so for half-turns, and for turns that are almost half-turns."""
    own = data(student)
    lines = [Line.through(own.a, own.b), Line.through(own.c, own.d), Line.at([1, 2, 0], [0, 1, 0])]
    lines += [Line.at([0, 3, 1], [0, 1, 2]), Line.at([2, 0, 1], [0, 0, 1]), Line.at([0, 1, 1], [1, 0, 0])]
    for line in lines:
        for q in (half_turn(line), rotation(line, 3.1415926)):
            try:
                answer = answer_of(pose_of, as_matrix(q), without=SHORTCUTS)
            except ZeroDivisionError as error:
                raise AssertionError("the pose of a half-turn: a division by 0; another v does better") from error
            if not any(numbers(answer, (8,), "the pose of a half-turn")):
                raise AssertionError("the pose of a half-turn: w_v is 0 for this v; take the one that is largest")
            _assert_pose_of_matrix(answer, q)


def check_readings(from_library: Callable, student: str) -> None:
    """Fail unless a function reads what the libraries write, of a student's pose and of another."""
    for q in _poses(student):
        for library, way in conventions(student).items():
            answer = answer_of(from_library, library, written(way, q), without=SHORTCUTS)
            _assert_read(answer, q, library, way, _poses(student)[0])


def check_carry(carry, student: str) -> None:
    """Fail unless a pose carries a to c and b to d."""
    _assert_carries(carry, data(student))


# ---- what is withheld --------------------------------------------------------------------------------

SHORTCUTS = (
    *defined_beside(act), as_pose, Line.as_dual_quaternion, Line.at.__func__, Line.through.__func__,
    MotionPolynomial.trajectory, read, conventions,
)  # fmt: skip
"""Functions that are the answer to a task, or nearly so: refused while an answer works."""


def __dir__() -> list[str]:
    return __all__


seal()
