"""Stops of a dyad: where it brings a point to a line or next to a place, and the linkages through four of them."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import kinlib as kl
from kinlib import Dyad, Line, act, as_matrix, eps, i, j, k, one, task, translation
from kinlib.testing import assert_closes, random_poses
from laws import COVERED

COVERED.update(("goldberg_linkages_with_stops", "stops_on_line", "nearest_stop", "NearestStop"))
PLACES = [(0, 0), (1, 2), (-2, 1), (1, -2)]


def random_dyad(random, length=1.0, place=(0, 0, 0)):
    """Skew axes about a place, and a home that is not the identity."""
    axes = [Line.at(length * random.normal(size=3) + place, random.normal(size=3)) for _ in range(2)]
    turn = kl.DualQuaternion(np.r_[random.normal(size=4), np.zeros(4)])
    home = translation(length * random.normal(size=3) + place) * kl.unit(turn)
    return Dyad(*(kl.unit(kl.half_turn(axis)) for axis in axes), home=home)


def carried(dyad, angles, point):
    """Where SciPy's rotations about the axes carry a point."""
    at = as_matrix(dyad.home)[:3, :3] @ point + as_matrix(dyad.home)[:3, 3]
    for axis, angle in zip(reversed(dyad.axes), reversed(angles), strict=True):
        turn, foot = Rotation.from_rotvec(angle * axis.direction), axis.foot()
        at = foot + turn.apply(at - foot)
    return at


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("seed", range(3))
def test_all_stops_on_a_line_are_found(seed, length):
    """As many as an interval that is searched by hand: sign changes of the determinant along the line."""
    random = np.random.default_rng(seed)
    place = 10 * length * random.normal(size=3)
    dyad, point = random_dyad(random, length, place), length * random.normal(size=3)
    angles = random.uniform(-3, 3, 2)
    line = Line.at(carried(dyad, angles, point), random.normal(size=3))
    stops = kl.stops_on_line(dyad, point, line)
    assert len(stops) in (2, 4)
    assert all(task.PointOnLine(point, line).residual(dyad(*stop), length=length) < 1e-10 for stop in stops)
    assert min(np.abs(np.subtract(stop, -1 / np.tan(angles / 2))).max() for stop in stops) < 1e-6
    assert len(kl.stops_on_line(dyad, point, line, real=False)) == 4
    assert len(stops) == _crossings(dyad, point, line, length)


def _crossings(dyad, point, line, length):
    """How often the determinant of the theorem "one more position" changes its sign along the line."""
    ways = np.tan(np.linspace(-1.57, 1.57, 20001)) * length
    l = line.direction / np.linalg.norm(line.direction)
    centre = act(dyad.home, point)
    places = (line.foot(centre) - centre + ways[:, None] * l) / length
    h = [translation(-centre) * turn * translation(centre) for turn in (dyad.h1, dyad.h2)]
    h = [kl.DualQuaternion(turn.coeffs / np.repeat([1, length], 4)) for turn in h]
    basis = [np.broadcast_to(x.coeffs, (len(ways), 8)) for x in (one, *h, h[0] * h[1])]
    bundle = [(translation(places) * e).coeffs for e in (one, i, j, k)]
    signs = np.sign(np.linalg.det(np.stack([*basis, *bundle], axis=1).astype(float)))
    return np.count_nonzero(np.diff(signs))


def test_a_line_that_touches_has_the_stop_once():
    dyad, point = Dyad(i, j - eps * i), [1, 2, 0]
    place = act(dyad(1, 2), point)
    step = 1e-6
    along = (act(dyad(1 + step, 2), point) - act(dyad(1 - step, 2), point)) / (2 * step)
    across = (act(dyad(1, 2 + step), point) - act(dyad(1, 2 - step), point)) / (2 * step)
    stops = kl.stops_on_line(dyad, point, Line.at(place, along + 0.3 * across))
    near = [stop for stop in stops if np.abs(np.subtract(stop, (1, 2))).max() < 1e-3]
    assert len(near) == 2 or near[0] == pytest.approx((1, 2), abs=1e-3)
    assert len(kl.stops_on_line(dyad, point, Line.at(place, along), real=False)) == 4


@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_nearer_than_the_nearest_stop(seed):
    """SciPy goes downhill from several starts, and comes no nearer."""
    random = np.random.default_rng(seed)
    length = 10.0 ** (seed - 3)
    place = 10 * length * random.normal(size=3)
    dyad, point = random_dyad(random, length, place), length * random.normal(size=3)
    target = place + 3 * length * random.normal(size=3)
    found = kl.nearest_stop(dyad, point, target)
    tried = [
        minimize(lambda x: np.linalg.norm(carried(dyad, x, point) - target) / length, random.uniform(-3, 3, 2)).fun
        for _ in range(8)
    ]
    assert found.distance / length == pytest.approx(min(tried), rel=1e-7)
    assert np.linalg.norm(act(dyad(*found.stop), point) - target) == pytest.approx(found.distance)
    assert act(dyad(*found.stop), point) == pytest.approx(found.place)


def test_what_is_reached_is_nearest():
    dyad = Dyad(2 * i, j - eps * i)  # a half-turn that is not of length 1
    target = act(dyad(2, -3), [1, 2, 3])
    assert kl.nearest_stop(dyad, [1, 2, 3], target).distance < 1e-12
    on_axis = kl.nearest_stop(dyad, [1, 2, 3], [5, 0, 0])
    assert on_axis.stop[0] == np.inf


def test_planar_and_spherical_dyads_have_nearest_stops():
    planar, spherical = Dyad(k, k + eps * j), Dyad(i, j)
    # The parallel axes are one apart, and the point is two from the moving one.
    assert kl.nearest_stop(planar, [1, 0, 0], [9, 0, 5]).distance == pytest.approx(np.hypot(5, 9 - 1 - 2))
    assert kl.nearest_stop(spherical, [0, 0, 2], [0, 0, 5]).distance == pytest.approx(3)


@pytest.mark.parametrize("side", ["base", "moving"])
def test_five_poses_exactly(side):
    """The equations of the theorem, by substitution: at t = s_B the cubic is the pose."""
    dyad = Dyad(k, (3 * j + 4 * k - 4 * eps * j + 3 * eps * k) / 5)
    stops = PLACES if side == "base" else [stop[::-1] for stop in PLACES]
    linkages = kl.goldberg_linkages_with_stops(dyad, stops, side=side)
    for linkage in linkages:
        assert linkage.closure_residual() == 0
        assert linkage.joints == ((2, 1, 1, 1, 1) if side == "base" else (1, 2, 1, 1, 1))
        for t, stop in zip(linkage.parameters[1:], stops, strict=True):
            assert kl.same_point(linkage.coupler_motion(t), dyad(*stop))


@pytest.mark.parametrize("seed", range(4))
def test_five_poses_in_floats(seed):
    random = np.random.default_rng(seed)
    length, side = 10.0 ** (2 * seed - 3), ("base", "moving")[seed % 2]
    dyad = random_dyad(random, length, 10 * length * random.normal(size=3))
    stops = random.normal(size=(4, 2))
    stops[0, seed % 2] = np.inf  # where the joint that turns twice is at home
    for linkage in kl.goldberg_linkages_with_stops(dyad, stops, side=side):
        for t, stop in zip(linkage.parameters, [(np.inf, np.inf), *stops], strict=True):
            assert task.Pose(dyad(*stop)).residual(as_matrix(linkage.coupler_motion(t)), length=length) < 1e-8
        assert_closes(linkage)
        assert linkage.mobility() == 1


def test_lines_of_sight_are_found_by_the_search_too():
    """Two poses and two points on lines: each cubic of the search belongs to a choice of stops."""
    home, *others = random_poses(3, seed=4)
    random = np.random.default_rng(8)
    points, lines, made = random.normal(size=(2, 3)), [], kl.dyads_through_poses(home, *others)[0]
    for point in points:
        lines.append(Line.at(act(made(*random.normal(size=2)), point), random.normal(size=3)))
    data = [*map(task.Pose, others), *map(task.PointOnLine, points, lines)]
    closed = []
    for dyad in kl.dyads_through_poses(home, *others):
        given = [dyad.parameters(pose) for pose in others]
        for first in kl.stops_on_line(dyad, points[0], lines[0]):
            for second in kl.stops_on_line(dyad, points[1], lines[1]):
                for side in ("base", "moving"):
                    closed.append(kl.goldberg_linkages_with_stops(dyad, [*given, first, second], side=side)[0])
    searched = kl.goldberg_linkages_for(home, data, starts=40)
    for linkage in searched[::2]:
        reached = [linkage.coupler_motion(t) for t in linkage.parameters[3:]]
        assert any(
            all(
                kl.same_point(pose, other.coupler_motion(t), rtol=1e-6)
                for pose, t in zip(reached, other.parameters[3:], strict=True)
            )
            for other in closed
        )
    for linkage in closed:
        met = [asked.residual(linkage.coupler_motion(t)) for asked, t in zip(data, linkage.parameters[1:], strict=True)]
        assert max(met) < 1e-8


DYAD = Dyad(i, j - eps * i)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: kl.goldberg_linkages_with_stops(DYAD, PLACES[:3]), r"four pairs \(t1, t2\) .* shape \(3, 2\)"),
        (lambda: kl.goldberg_linkages_with_stops(DYAD, [*PLACES[:3], (5, 1)]), "in one place"),
        (lambda: kl.goldberg_linkages_with_stops(DYAD, [*PLACES[:3], (5, np.inf)]), "t = ∞ is the home pose"),
        (lambda: kl.goldberg_linkages_with_stops(DYAD, [(n, n + 1) for n in range(4)]), "a conic meets the poses"),
        (lambda: kl.goldberg_linkages_with_stops(DYAD, PLACES, side="left"), "'base' or 'moving', got 'left'"),
        (lambda: kl.goldberg_linkages_with_stops(i, PLACES), "a single Dyad, got i"),
        (lambda: kl.stops_on_line(DYAD, [1, 2, 0], [0, 0, 1]), "a single Line"),
        (lambda: kl.stops_on_line(DYAD, [1, 2], Line.at([0, 0, 1], [1, 0, 0])), r"points of shape \(\.\.\., 3\)"),
        (lambda: kl.stops_on_line(Dyad(i, j), [1, 2, 0], Line.at([0, 0, 1], [1, 0, 0])), "axes are coplanar"),
        (lambda: kl.stops_on_line(DYAD, [0, 3, 1], Line.at([0, 0, 1], [1, 0, 0])), "lies on the moving axis"),
        (lambda: kl.nearest_stop(DYAD, [0, 3, 1], [1, 2, 3]), "lies on the moving axis"),
        (lambda: kl.nearest_stop(DYAD, [1, 2, 0], [[1, 2, 3]]), r"a single place of shape \(3,\)"),
        (lambda: kl.nearest_stop(DYAD, [1, 2, 0], [1, np.nan, 3]), "finite"),
    ],
)
def test_what_has_no_answer_is_said(call, message):
    with pytest.raises((ValueError, TypeError), match=message):
        call()


def test_exact_stops_stay_exact():
    (linkage, _) = kl.goldberg_linkages_with_stops(Dyad(k, j - eps * i), [(Fraction(a), b) for a, b in PLACES])
    assert linkage.factors[0] in (1 - k, 2 - 2 * k)
