"""Lines in Plücker coordinates, checked by the points on them."""

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from kinlib import DegenerateError, DualQuaternion, Line, common_perpendicular, eps, i, j, k, square_root, study_form
from strategies import fraction_vectors, fractions, lines, vectors

x_axis, y_axis, z_axis = (Line([*axis], [0, 0, 0]) for axis in np.eye(3, dtype=int).tolist())
a = square_root(2)
nonzero = vectors.filter(any)


def on(line: Line, s) -> np.ndarray:
    """The point foot + s · direction, written out."""
    return line.foot() + s * line.direction


def same_direction(l, k) -> bool:
    return not np.cross(l, k).any()


@given(vectors, nonzero, fractions)
def test_a_line_consists_of_its_points(point, direction, s):
    line = Line.at(point, direction)
    assert line.contains(np.array(point) + s * np.array(direction))


@given(vectors, nonzero, fraction_vectors)
def test_a_point_is_on_the_line_exactly_if_its_way_there_is_along_it(point, direction, other):
    assert Line.at(point, direction).contains(other) == same_direction(np.array(other) - point, direction)


@given(vectors, vectors)
def test_the_line_through_two_points(a, b):
    assume(a != b)
    line = Line.through(a, b)
    assert line.contains(a)
    assert line.contains(b)
    assert (line.direction == np.array(b) - a).all()


@given(lines(), fractions)
def test_the_moment_is_that_of_every_point(line, s):
    assert (np.cross(on(line, s), line.direction) == line.moment).all()


@given(lines(), vectors)
def test_the_foot_is_the_nearest_point(line, point):
    foot = line.foot(point)
    assert line.contains(foot)
    assert (foot - point) @ line.direction == 0


def test_feet_by_coordinates():
    line = Line.at([0, 3, 0], [2, 0, 0])
    assert line.foot().tolist() == [0, 3, 0]
    assert line.foot([7, 8, 9]).tolist() == [7, 3, 0]
    assert line.foot([[7, 8, 9], [1, 0, 0]]).tolist() == [[7, 3, 0], [1, 3, 0]]


@given(lines(), lines())
def test_the_common_perpendicular(g, h):
    if same_direction(g.direction, h.direction):
        with pytest.raises(DegenerateError, match="parallel"):
            common_perpendicular(g, h)
        return
    p, q = common_perpendicular(g, h)
    assert g.contains(p)
    assert h.contains(q)
    assert (p - q) @ g.direction == (p - q) @ h.direction == 0


@given(lines(), lines(), fractions, fractions)
def test_no_two_points_are_nearer_than_the_distance(g, h, s, t):
    gap = on(g, s) - on(h, t)
    distance = g.distance(h)
    assert distance == h.distance(g)
    assert distance * distance <= gap @ gap


@given(lines(), lines())
def test_two_lines_meet_exactly_if_their_study_form_vanishes(g, h):
    assume(not same_direction(g.direction, h.direction))
    assert (g.distance(h) == 0) == (study_form(g.as_dual_quaternion(), h.as_dual_quaternion()) == 0)


@pytest.mark.parametrize(
    ("first", "second", "distance", "angle"),
    [
        (x_axis, Line.at([5, 7, 3], [0, 2, 0]), 3, math.pi / 2),
        (x_axis, Line.at([1, 1, 4], [-1, -1, 0]), 4, 3 * math.pi / 4),
        (x_axis, Line.at([9, 3, 4], [2, 0, 0]), 5, 0),
        (x_axis, Line.at([9, 3, 4], [-2, 0, 0]), 5, math.pi),
        (x_axis, x_axis, 0, 0),
        (x_axis, y_axis, 0, math.pi / 2),
        (Line.at([0, 0, 1], [1, 1, 1]), Line.at([0, 0, 1], [1, 1, 0]), 0, math.acos(math.sqrt(2 / 3))),
        (Line.at([1, 0, 0], [0, 1, 1]), Line.at([0, 0, 0], [0, 0, 1]), 1, math.pi / 4),
    ],
)
def test_distance_and_angle_by_coordinates(first, second, distance, angle):
    assert first.distance(second) == second.distance(first) == distance
    assert first.angle(second) == pytest.approx(angle, abs=1e-15)


def test_an_irrational_distance_is_exact():
    line = Line.at([0, 0, 0], [1, 1, 1])
    distance = line.distance(Line.at([1, 0, 0], [0, 0, 1]))
    assert distance * distance == Fraction(1, 2)


@given(lines(), lines())
def test_distance_and_angle_in_floats(g, h):
    assume(not same_direction(g.direction, h.direction))
    g_float, h_float = (Line(line.direction.astype(float), line.moment.astype(float)) for line in (g, h))
    assert g_float.distance(h_float) == pytest.approx(float(g.distance(h)), abs=1e-12)
    l, m = (np.array(line.direction, dtype=float) for line in (g, h))
    assert g.angle(h) == pytest.approx(math.acos(l @ m / np.linalg.norm(l) / np.linalg.norm(m)), abs=1e-7)


@pytest.mark.parametrize("turn", [1e-3, 1e-6, 1e-9])
def test_small_angles_are_accurate(turn):
    line = Line.at([0.0, 0, 2], [math.cos(turn), math.sin(turn), 0])
    assert x_axis.angle(line) == pytest.approx(turn, rel=1e-12)
    assert x_axis.distance(line) == pytest.approx(2, rel=1e-12)


@pytest.mark.parametrize("length", [1e-6, 1e6])
def test_lines_at_every_scale(length):
    g = Line.through([0.0, 0, 0], [length, 0, 0])
    h = Line.through([0, 0, 3 * length], [0.0, length, 3 * length])
    assert g.distance(h) == pytest.approx(3 * length, rel=1e-12)
    assert h.contains([0, 0.5 * length, 3 * length])
    assert not h.contains([0, 0.5 * length, 3.00001 * length])


@pytest.mark.parametrize("factor", [2, -3, Fraction(1, 3), a, 1e-3, 1e3])
def test_the_length_of_the_direction_does_not_matter(factor):
    g = Line.at([5, 7, 3], [1, 2, 2])
    h = Line(factor * g.direction, factor * g.moment)
    assert h.contains([6, 9, 5])
    assert h.distance(x_axis) == pytest.approx(float(g.distance(x_axis)))
    assert h.angle(g) == pytest.approx(0 if factor > 0 else math.pi, abs=1e-7)


@pytest.mark.parametrize("n", [2**16, 2**22, 10**9, 10**20])
def test_large_whole_coordinates_do_not_overflow(n):
    g, h = Line.at([0, 0, 0], [n, 1, 0]), Line.at([0, 0, n], [0, n, 1])
    p, q = common_perpendicular(g, h)
    assert g.contains(p)
    assert h.contains(q)
    assert (p - q) @ g.direction == (p - q) @ h.direction == 0
    assert g.contains(g.foot([n, n, 0]))
    assert (g.foot([n, n, 0]) - [n, n, 0]) @ g.direction == 0


@given(lines())
def test_a_line_as_a_dual_quaternion(line):
    h = line.as_dual_quaternion()
    l, m = line.direction, line.moment
    assert h == l[0] * i + l[1] * j + l[2] * k + eps * (m[0] * i + m[1] * j + m[2] * k)
    assert h * h == -(l @ l)
    again = Line.from_dual_quaternion(h)
    assert (again.direction == l).all()
    assert (again.moment == m).all()


@given(lines(), fractions)
def test_the_axis_of_a_rotation(line, s):
    axis = Line.from_dual_quaternion(s - line.as_dual_quaternion())
    assert all(axis.contains(on(line, t)) for t in (0, 1))


def test_lines_over_other_numbers():
    s = sympy.Symbol("s", real=True)
    assert Line.at([0, 0, s], [1, s, 0]).contains([2, 2 * s, s])
    assert not Line.at([0, 0, s], [1, s, 0]).contains([2, 2 * s, 0])
    line = Line.at([a, 0, 1], [a, 1, 0])
    assert line.contains([2 * a, 1, 1])
    assert line.foot([0, 0, 0]).tolist() == [a / 3, Fraction(-2, 3), 1]
    assert line.distance(Line.at([0, 0, 0], [1, 0, 0])) == 1


def test_a_batch_is_answered_line_by_line():
    random = np.random.default_rng(2)
    points, directions = random.normal(size=(2, 6, 3))
    batch = Line.at(points, directions)
    singles = [Line.at(p, d) for p, d in zip(points, directions, strict=True)]
    other = Line.at([1.0, 2, 3], [0, 1, 1.0])
    assert batch.contains(points).all()
    assert not batch.contains(points + 1e-3 * np.cross(directions, [1, 2, 3])).any()
    assert batch.distance(other) == pytest.approx([line.distance(other) for line in singles])
    assert batch.angle(other) == pytest.approx([line.angle(other) for line in singles])
    assert batch.foot() == pytest.approx(np.array([line.foot() for line in singles]))
    assert batch.as_dual_quaternion().shape == (6,)


def test_batches_broadcast():
    sheaf = Line([[1, 0, 0], [0, 1, 0]], [0, 0, 0])
    assert sheaf.direction.shape == sheaf.moment.shape == (2, 3)
    grid = Line.at(np.zeros((4, 1, 3), dtype=int), sheaf.direction)
    assert grid.direction.shape == (4, 2, 3)
    assert grid.contains([1, 0, 0]).tolist() == [[True, False]] * 4


def test_one_parallel_line_in_a_batch_is_enough():
    with pytest.raises(DegenerateError, match="parallel"):
        common_perpendicular(Line([[1, 0, 0], [0, 1, 0]], [0, 0, 0]), y_axis)


@pytest.mark.parametrize(
    ("direction", "moment", "message"),
    [
        ([0, 0, 0], [0, 0, 0], "a direction that is not zero"),
        ([[1, 0, 0], [0, 0, 0]], [0, 0, 0], "a direction that is not zero"),
        ([1, 0, 0], [1, 0, 0], "perpendicular"),
        ([1.0, 0, 0], [1e-6, 1, 0], "perpendicular"),
        ([1, 0], [0, 1], r"shape \(\.\.\., 3\)"),
        (1, [0, 1, 0], r"shape \(\.\.\., 3\)"),
        ([1, 0, 0], [0, 1, 0, 0], r"shape \(\.\.\., 3\)"),
        ([math.nan, 0, 0], [0, 1, 0], "perpendicular|finite"),
    ],
)
def test_what_is_no_line(direction, moment, message):
    with pytest.raises(ValueError, match=message):
        Line(direction, moment)


@pytest.mark.parametrize("build", [Line.through, Line.at])
@pytest.mark.parametrize("points", [([0, 0], [1, 0]), ([0, 0, 0], [1, 0]), (0, 1), (np.zeros(4), np.ones(4))])
def test_points_have_three_coordinates(build, points):
    with pytest.raises(ValueError, match=r"expected .* of shape \(\.\.\., 3\)"):
        build(*points)


def test_one_point_gives_no_line():
    with pytest.raises(ValueError, match="not zero"):
        Line.through([1, 2, 3], [1, 2, 3])


@pytest.mark.parametrize("q", [1 + eps * i, 1 + i + eps * i, DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0])])
def test_a_screw_or_a_translation_has_no_axis_of_rotation(q):
    with pytest.raises(ValueError, match=r"perpendicular|not zero"):
        Line.from_dual_quaternion(q)


def test_a_line_does_not_change():
    source = np.array([1.0, 0, 0])
    line = Line(source, [0, 0, 1])
    source[0] = 0
    assert line.contains([5, -1, 0])
    for array in (line.direction, line.moment):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 7
    with pytest.raises(AttributeError):
        line.direction = source


@given(st.lists(fractions, min_size=3, max_size=3).filter(any))
def test_fractions_stay_fractions(direction):
    foot = Line.at([1, 2, 3], direction).foot()
    assert all(isinstance(c, Fraction) for c in foot)
