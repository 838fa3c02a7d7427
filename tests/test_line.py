"""Lines in Plücker coordinates, checked by the points on them."""

import copy
import math
import pickle
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


# Nearly parallel, parallel, through the origin


@pytest.mark.parametrize("turn", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-16, 0])
@pytest.mark.parametrize("place", [0.0, 1.0])
def test_the_distance_of_nearly_parallel_lines(turn, place):
    rng = np.random.default_rng(7)
    for point in place * rng.normal(size=(20, 3)):
        l, n = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
        g = Line.at(point, l)
        h = Line.at(point + n, l + turn * np.cross(l, n))
        tolerance = min(1e-14 / max(turn, 1e-16), 1e-3) + 1e-12
        assert g.distance(h) == pytest.approx(1, rel=tolerance)
        assert h.distance(g) == pytest.approx(1, rel=tolerance)


def test_a_batch_with_one_parallel_pair_has_distances():
    g = Line.at([0, 0, 0], [1, 0, 0])
    for scalar in (int, float):
        directions = np.array([[2, 0, 0], [0, 1, 0], [1, 1, 0]], dtype=scalar)
        h = Line.at(np.array([5, 0, 3], dtype=scalar), directions)
        assert g.distance(h).tolist() == h.distance(g).tolist() == [3, 3, 3]
    assert g.is_parallel(h).tolist() == [True, False, False]


@pytest.mark.parametrize("turn", [1e-1, 1e-3, 1e-4])
def test_feet_of_nearly_parallel_lines(turn):
    l, n = np.array([2, 1, 2]) / 3, np.array([1, 2, -2]) / 3
    g, h = Line.at([1.0, 2, 3], l), Line.at(np.array([1.0, 2, 3]) + n, l + turn * np.cross(l, n))
    p, q = common_perpendicular(g, h)
    assert p == pytest.approx([1, 2, 3], abs=1e-14 / turn**2)
    assert q - p == pytest.approx(n, abs=1e-14 / turn**2)


@pytest.mark.parametrize("turn", [1e-7, 1e-9, 1e-11])
def test_feet_that_rounding_decides_are_not_given(turn):
    l, n = np.array([2, 1, 2]) / 3, np.array([1, 2, -2]) / 3
    g, h = Line.at([0.0, 0, 0], l), Line.at(n, l + turn * np.cross(l, n))
    with pytest.raises(DegenerateError, match="nearly parallel"):
        common_perpendicular(g, h)
    assert all(np.isnan(foot).all() for foot in common_perpendicular(g, h, degenerate="nan"))
    meeting = Line.at(g.foot() + l, l + turn * np.cross(l, n))  # here the foot is where they meet
    assert common_perpendicular(g, meeting)[0] == pytest.approx(l, abs=1e-14 / turn)


def test_rows_with_parallel_lines_may_become_nan():
    for scalar in (int, float):
        sheaf = Line(np.array([[1, 0, 0], [0, 1, 0]], dtype=scalar), np.zeros(3, dtype=scalar))
        with pytest.raises(DegenerateError, match=r"row 1: .*parallel") as caught:
            common_perpendicular(sheaf, y_axis)
        assert caught.value.rows == (1,)
        p, q = common_perpendicular(sheaf, y_axis, degenerate="nan")
        assert np.isnan([p[1], q[1]]).all()
        assert p[0].tolist() == q[0].tolist() == [0, 0, 0]


def test_lines_through_the_origin_in_decimals():
    line = Line.through([0.1, 0.3, 0.5], [0.3, 0.9, 1.5])
    assert line.contains([0, 0, 0])
    assert line.distance(Line.at([0, 0, 1.0], [3.0, -1, 0])) == pytest.approx(10 / math.sqrt(350))
    rng = np.random.default_rng(5)
    for scale in (1e-6, 1, 1e6):
        a = scale * rng.normal(size=(300, 3))
        batch = Line.through(a, a * rng.uniform(-3, 0.9, size=(300, 1)))
        assert batch.contains([0, 0, 0]).all()
        again = Line.from_dual_quaternion(batch.as_dual_quaternion())
        assert again.contains([0, 0, 0]).all()
        assert Line(batch.direction, batch.moment).contains(a).all()


def test_axes_of_rotations_about_the_origin_up_to_rounding():
    rng = np.random.default_rng(6)
    for scale in (1e-6, 1e-3, 1, 1e3):
        q = DualQuaternion(np.concatenate([rng.normal(size=(300, 4)), np.zeros((300, 4))], axis=-1))
        there = 1 + eps * (i - 2 * j + 3 * k) / 2
        turned = there * (1 + scale * q) * there.conjugate()
        back = there.conjugate() * turned * there
        feet = Line.from_dual_quaternion(back).foot()
        assert np.abs(feet).max() < 1e-12 / min(scale, 1)


# Batches, copies, printing, wrong types


def test_a_batch_is_a_sequence():
    points = np.arange(12).reshape(2, 2, 3)
    batch = Line.at(points, [1, 2, 2])
    assert (len(batch), batch.shape) == (2, (2, 2))
    assert batch[1, 0].contains(points[1, 0])
    assert [row.shape for row in batch] == [(2,), (2,)]
    assert batch[0][1].contains(points[0, 1])
    assert batch[..., None].shape == (2, 2, 1)
    with pytest.raises(TypeError, match="no length"):
        len(x_axis)
    with pytest.raises(IndexError):
        x_axis[0]
    with pytest.raises(ValueError, match="read-only"):
        batch[1].direction[0] = 7


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda line: pickle.loads(pickle.dumps(line))])
def test_copies_are_equal_and_do_not_change(duplicate):
    line = duplicate(Line.at([1.0, 2, 3], [1, 2, 2]))
    assert line.moment.tolist() == [-2, 1, 0]
    with pytest.raises(ValueError, match="read-only"):
        line.moment[0] = 7


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (x_axis, "Line(direction=(1, 0, 0), moment=(0, 0, 0))"),
        (Line.at([0, 1 / 3, 0], [0.0, 0, 1]), "Line(direction=(0, 0, 1), moment=(0.333333, 0, 0))"),
        (Line.at([0, Fraction(1, 3), 0], [0, 0, a]), "Line(direction=(0, 0, a), moment=(1/3*a, 0, 0))"),
        (Line.at([[0.0, 0, 0]] * 6, [0, 0, 1]), "Line of shape (6,), float64"),
    ],
)
def test_reading(line, text):
    assert repr(line) == text


def test_rows_of_nan_stay_rows():
    points = np.array([[0.0, 0, 1], [math.nan, 0, 0], [0, math.inf, 0]])
    for batch in (Line.at(points, [1, 0, 0]), Line.through(points, [1.0, 0, 1]), Line([1.0, 0, 0], points * [0, 1, 1])):
        rows = np.concatenate([batch.direction, batch.moment], axis=-1)
        assert np.isfinite(rows[0]).all()
        assert np.isnan(rows[1:]).all()
    batch = Line.at(points, [1, 0, 0])
    assert np.isnan(batch.distance(y_axis)[1:]).all()
    assert batch.distance(y_axis)[0] == 1
    assert batch.contains([5.0, 0, 1]).tolist() == [True, False, False]


@pytest.mark.parametrize(
    "build",
    [
        lambda: Line.at([math.nan, 0, 0], [1, 0, 0]),
        lambda: Line.through([0, 0, 0], [math.inf, 0, 0]),
        lambda: x_axis.contains([math.nan, 0, 0]),
        lambda: x_axis.foot([math.nan, 0, 0]),
        lambda: Line.at([1j, 0, 0], [1, 0, 0]),
        lambda: x_axis.contains([1j, 0, 0]),
    ],
)
def test_single_points_are_real_and_finite(build):
    with pytest.raises(ValueError, match=r"expected (finite|real)"):
        build()


@pytest.mark.parametrize("wrong", [None, "x", [1, 2, 3], i, {}])
def test_other_things_are_no_lines(wrong):
    for use in (x_axis.distance, x_axis.angle, x_axis.is_parallel, lambda w: common_perpendicular(x_axis, w)):
        with pytest.raises(TypeError, match="expected a Line"):
            use(wrong)
    if wrong is not i:
        with pytest.raises(TypeError, match="expected a rotation as DualQuaternion"):
            Line.from_dual_quaternion(wrong)


@pytest.mark.parametrize("wrong", [None, "abc", {}, i, x_axis, [None] * 3])
def test_other_things_are_no_points(wrong):
    for use in (x_axis.contains, x_axis.foot, lambda w: Line.at(w, [1, 0, 0]), lambda w: Line.through([1, 0, 0], w)):
        with pytest.raises(TypeError, match="expected numbers"):
            use(wrong)


def test_a_zero_direction_is_named_by_its_row():
    with pytest.raises(ValueError, match="row 1: expected a direction that is not zero"):
        Line.at([[0, 0, 1], [0, 0, 2]], [[1, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize("degenerate", ["no", None])
def test_what_to_do_about_parallel_lines_is_one_of_two_words(degenerate):
    with pytest.raises(ValueError, match="'raise' or 'nan'"):
        common_perpendicular(x_axis, y_axis, degenerate=degenerate)


def test_lines_in_single_precision():
    point = np.array([0.1, 0.7, 0.3], dtype=np.float32)
    line = Line.at(point, np.array([0.3, 0.1, 0.9], dtype=np.float32))
    assert line.direction.dtype == np.float32
    assert line.contains(point)
    assert Line(line.direction, line.moment).shape == ()
