"""Data other than poses: what they ask, what they cost, and the linkages that are found for them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import RigidTransform, Rotation

import kinlib as kl
from kinlib import DegenerateError, DualQuaternion, Line, NotFoundError, act, as_matrix, i, k, one, task, translation
from kinlib.gallery import THREE_POSES
from kinlib.pictures import Ball, Frame, task_scene
from kinlib.testing import assert_closes, random_poses
from laws import COVERED
from task_problems import FIVE_R, FOUR_R, A, D, L, P, R, T, X, datum, problem

COVERED.update(("bennett_linkages_for", "goldberg_linkages_for", "six_r_linkages_for", "NotFoundError", "follow"))
KINDS = (P, D, L, X, R, T, A)
CODIMENSIONS = dict(zip(KINDS, (6, 5, 4, 3, 3, 2, 2), strict=True))
ORIENTATIONS = dict(zip(KINDS, (3, 2, 2, 0, 3, 0, 2), strict=True))


# --- data ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_the_codimension_is_the_rank_of_the_equations(kind):
    """How many of the six velocities of a body change the residuals of the parts, by differences."""
    random = np.random.default_rng(5)
    (pose,) = random_poses(1, seed=3)
    asked = datum(kind, pose, random, 1.0)

    def ranks(parts):
        rows = []
        for velocity in np.eye(8)[[1, 2, 3, 5, 6, 7]] * 1e-6:
            moved = (one + DualQuaternion(velocity)) * pose
            rows.append(np.concatenate([_equations(part, moved) - _equations(part, pose) for part in parts]))
        return np.linalg.matrix_rank(np.array(rows) * 1e6, tol=1e-3)

    assert ranks(asked.parts()) == asked.codimension == CODIMENSIONS[kind]
    turns = [part for part in asked.parts() if isinstance(part, task.Direction | task.Orientation)]
    assert (ranks(turns) if turns else 0) == asked.orientation_codimension == ORIENTATIONS[kind]


def _equations(part, pose):
    """What a part is about, as coordinates in the fixed frame."""
    matrix = as_matrix(pose)
    if isinstance(part, task.Orientation):
        return matrix[:3, :3].ravel()
    if isinstance(part, task.Direction):
        return matrix[:3, :3] @ part.direction
    place = matrix[:3, :3] @ kl.as_float(part.point) + matrix[:3, 3]
    return place if isinstance(part, task.Point) else np.cross(place, part.line.direction)


@pytest.mark.parametrize("kind", KINDS)
def test_a_residual_vanishes_where_the_datum_was_made_and_nowhere_else(kind):
    random = np.random.default_rng(1)
    pose, other = random_poses(2, seed=7)
    asked = datum(kind, pose, random, 1.0)
    assert asked.residual(pose) < 1e-14
    assert asked.residual(other) > 1e-2
    assert asked.residual(DualQuaternion.stack([pose, other])) == pytest.approx([0, asked.residual(other)], abs=1e-14)


def test_residuals_are_angles_and_distances():
    quarter = Rotation.from_euler("z", 90, degrees=True)
    at = RigidTransform.from_components([0, 3, 0], quarter)
    assert task.Pose(one).residual(at, length=6) == pytest.approx(np.pi / 2)
    assert task.Pose(one).residual(translation([0, 3, 0]), length=6) == pytest.approx(0.5)
    assert task.Orientation(quarter).residual(at) == pytest.approx(0, abs=1e-15)
    assert task.Orientation(quarter.as_matrix()).residual(one) == pytest.approx(np.pi / 2)
    assert task.Point([1, 0, 0], to=[0, 4, 2]).residual(at) == pytest.approx(2)
    assert task.Direction([5, 0, 0], to=[0, -1, 0]).residual(at) == pytest.approx(np.pi)
    x_axis = Line.at([0, 0, 0], [1, 0, 0])
    assert task.Line(x_axis, to=Line.at([0, 0, 2], [0, 7, 0])).residual(at) == pytest.approx(2)
    assert task.PointOnLine([0, 0, 1], x_axis.as_dual_quaternion()).residual(at, length=2) == pytest.approx(
        np.sqrt(10) / 2
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: task.Direction([0, 0, 0], [1, 0, 0]), "a direction that is not zero"),
        (lambda: task.Point([0, 0], [1, 0, 0]), r"points of shape \(\.\.\., 3\)"),
        (lambda: task.Point([0, 0, np.nan], [1, 0, 0]), "finite"),
        (lambda: task.Line([1, 0, 0], [1, 0, 0]), "expected a Line"),
        (lambda: task.Orientation(np.eye(2)), r"matrix of shape \(\.\.\., 3, 3\)"),
        (lambda: task.Orientation(np.diag([1.0, 1.0, -1.0])), "determinant is -1"),
        (lambda: task.Pose(one + kl.eps), "Study quadric"),
    ],
)
def test_data_that_are_none_are_refused(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


# --- the count ----------------------------------------------------------------------------------------------------


def data_of(kinds):
    return problem(kinds, seed=0).data


@pytest.mark.parametrize(
    ("function", "kinds", "message"),
    [
        (
            kl.goldberg_linkages_for,
            (P, P, X),
            r"Pose \(6\), Pose \(6\), Point \(3\) take 4 \+ 4 \+ 1 = 9 of the 8 .* dyad",
        ),
        (kl.goldberg_linkages_for, (P, P, P), r"Pose \(6\), Pose \(6\), Pose \(6\) take 5 \+ 5 \+ 5 = 15 of the 12"),
        (
            kl.goldberg_linkages_for,
            (R,) * 5,
            r"2 \+ 2 \+ 2 \+ 2 \+ 2 = 10 of the 8 parameters of the orientations",
        ),
        (kl.goldberg_linkages_for, (A,) * 9, r"= 9 of the 8 parameters of the orientations"),
        (kl.goldberg_linkages_for, (P, X), "leave 5 of the 12 parameters of 5R linkages free"),
        (kl.goldberg_linkages_for, (), "leave 12 of the 12"),
        (kl.bennett_linkages_for, (R, R, R), r"= 3 of the 2 parameters of the plane in which the orientations"),
        (kl.bennett_linkages_for, (P, P, A), r"= 11 of the 10 parameters of the coupler motions of 4R"),
        (kl.six_r_linkages_for, (A,) * 11, r"= 11 of the 10 parameters of the orientations"),
        (kl.six_r_linkages_for, (P, P, P), "leave 1 of the 16 parameters of 6R linkages free"),
    ],
)
def test_what_the_count_forbids_is_named(function, kinds, message):
    with pytest.raises(DegenerateError, match=message):
        function(one, data_of(kinds))


def test_the_smallest_choice_that_asks_too_much_is_named():
    with pytest.raises(DegenerateError) as error:
        kl.goldberg_linkages_for(one, data_of((L, P, L, P)))
    assert "Pose (6), Pose (6), Line (4) take 5 + 5 + 3 = 13" in str(error.value)


# --- the search ---------------------------------------------------------------------------------------------------


def assert_meets(linkage, home, data, length=1.0, wishes=()):
    """By the linkage's own motion, in matrices: at home at infinity, all data met, closed, of mobility one."""
    assert len(linkage.parameters) == len(data) + len(wishes) + 1
    assert kl.same_point(linkage.coupler_motion(np.inf), kl.as_pose(home), rtol=1e-9, length=length)
    for t, asked in zip(linkage.parameters[1:], data, strict=not wishes):
        assert asked.residual(as_matrix(linkage.coupler_motion(t)), length=length) < 1e-9
    assert_closes(linkage)
    assert linkage.mobility() == 1


@pytest.mark.parametrize("seed", range(2))
def test_two_poses_give_the_bennett_linkage_of_theorem_2(seed):
    home, *others = random_poses(3, seed=seed)
    (found,) = kl.bennett_linkages_for(home, [task.Pose(pose) for pose in others], starts=20)
    known = kl.bennett_linkage(home, *others)
    rows = (sorted((row.distance, np.sin(row.twist)) for row in x.denavit_hartenberg()) for x in (found, known))
    assert np.abs(next(rows)) == pytest.approx(np.abs(next(rows)), abs=1e-9)
    assert_meets(found, home, [task.Pose(pose) for pose in others])


@pytest.mark.parametrize("joints", [(2, 1), (1, 2)])
def test_5r_linkages_are_found_for_data_of_one(joints):
    given = problem(FIVE_R["pose, line, two points"], joints, seed=11)
    found = kl.goldberg_linkages_for(given.home, given.data, starts=60)
    assert len(found) >= 2
    for linkage in found:
        assert (linkage.joint_count, linkage.coupler) == (5, 2)
        assert_meets(linkage, given.home, given.data)


def test_6r_linkages_are_found_for_data_of_one():
    given = problem((P, P, P, T), (1, 1, 1), seed=0)
    found = kl.six_r_linkages_for(given.home, given.data, starts=20)
    assert len(found) % 9 == 0
    assert_meets(found[0], given.home, given.data)


def test_neither_unit_nor_origin_nor_frames_matter():
    """The same 4R linkages from the same starts, moved and stretched."""
    given = problem(FOUR_R["two lines, point and direction"], (1, 1), seed=4)
    shift, size = translation([50.0, -80.0, 20.0]), 1000.0

    def there(pose):
        return shift * kl.DualQuaternion(pose.coeffs * np.r_[np.ones(4), np.full(4, size)])

    moved = [_moved(asked, shift, size) for asked in given.data]
    first = kl.bennett_linkages_for(given.home, given.data, starts=30)
    second = kl.bennett_linkages_for(there(given.home), moved, starts=30)
    assert len(first) == len(second) >= 1
    for one_of, other in zip(first, second, strict=True):
        assert_meets(other, there(given.home), moved, length=size)
        distances = [np.array([row.distance for row in x.denavit_hartenberg()]) for x in (one_of, other)]
        assert distances[1] == pytest.approx(distances[0] * size, rel=1e-6)


def _moved(asked, shift, size):
    """A line or a point with a direction in a unit that is so much smaller, with the fixed frame moved."""
    if isinstance(asked, task.Line):
        lines = [Line(line.direction, line.moment * size) for line in (asked.line, asked.to)]
        return task.Line(lines[0], act(shift, lines[1]))
    return task.PointAndDirection(
        asked.point * size, asked.direction, act(shift, asked.to_point * size), asked.to_direction
    )


def test_the_same_seed_finds_the_same_and_tells_its_progress():
    given = problem(FOUR_R["two poses"], (1, 1), seed=1)
    told = []
    once, again = (kl.bennett_linkages_for(given.home, given.data, starts=20, progress=told.append) for _ in range(2))
    assert all((a == b) for x, y in zip(once, again, strict=True) for a, b in zip(x.factors, y.factors, strict=True))
    assert told[len(told) // 2 - 1] == told[-1] == 1


def test_what_is_left_free_is_filled_on_request():
    given = problem((P, X), (1, 1), seed=3)
    found = kl.bennett_linkages_for(given.home, given.data, starts=10, fill=True)
    assert len(found) > 3
    for linkage in found[:3]:
        assert_meets(linkage, given.home, given.data)


def test_wishes_are_met_as_nearly_as_the_surface_of_the_dyad_allows():
    """Through three poses, with two places that a point does not reach: the nearest of what the dyads reach."""
    home, *others = (pose.astype(float) for pose in THREE_POSES)
    point, places = [0, 1, 0], [[2, 2, 1], [-2, 0, -1]]
    data, wishes = [task.Pose(pose) for pose in others], [task.Point(point, to=place) for place in places]
    linkage = kl.goldberg_linkages_for(home, data, wishes=wishes, starts=30)[0]
    assert_meets(linkage, home, data, wishes=wishes)
    dyads = kl.dyads_through_poses(home, *others)
    reached = [[kl.nearest_stop(dyad, point, place).distance for place in places] for dyad in dyads]
    nearest = min(reached, key=np.linalg.norm)
    assert task.residuals(linkage, [*data, *wishes])[2:] == pytest.approx(nearest, abs=1e-7)


def test_a_wish_that_can_be_met_is_met():
    home, *others = random_poses(3, seed=1)
    data = [task.Pose(pose) for pose in others]
    found = kl.bennett_linkages_for(home, data[:1], wishes=data[1:], starts=20)[0]
    assert_meets(found, home, data)
    known = kl.bennett_linkage(home, *others)
    assert found.denavit_hartenberg()[0].distance == pytest.approx(known.denavit_hartenberg()[0].distance)


def test_wishes_alone_have_a_nearest_linkage():
    """SciPy starts where the search ended, with turns and feet of the axes as unknowns, and comes no nearer."""
    home, *others = random_poses(8, seed=3)
    wishes = [task.Point([1, 0, 0], act(pose, [1, 0, 0])) for pose in others] * 1
    linkage = kl.goldberg_linkages_for(home, [], wishes=wishes, starts=40)[0]
    first, second = linkage.joints[:2]
    axes = [linkage.factors[0], linkage.factors[first]]
    lines = [Line.from_dual_quaternion(h) for h in axes]
    numbers = [(h.scalar_part, kl.null_form(h, h) - h.scalar_part**2) for h in linkage.factors[: first + second]]
    along = [h.coeffs[1:4] @ axes[n >= first].coeffs[1:4] for n, h in enumerate(linkage.factors[: first + second])]
    start = np.concatenate([
        *(np.r_[line.direction, line.foot()] for line in lines),
        *((x, np.copysign(np.sqrt(y), sign)) for (x, y), sign in zip(numbers, along, strict=True)),
        linkage.parameters[1:],
    ])  # fmt: skip

    def misses(x):
        turns = [kl.unit(kl.half_turn(Line.at(place, way))) for way, place in np.reshape(x[:12], (2, 2, 3))]
        pairs = np.reshape(x[12:18], (3, 2))
        factors = [a + b * turns[n >= first] for n, (a, b) in enumerate(pairs)]
        poses = [(t - factors[0]) * (t - factors[1]) * (t - factors[2]) * home for t in x[18:]]
        return np.concatenate([act(pose, wish.point) - wish.to for pose, wish in zip(poses, wishes, strict=True)])

    found = least_squares(misses, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    before = np.array(task.residuals(linkage, wishes))
    assert np.linalg.norm(misses(start)) == pytest.approx(np.linalg.norm(before))
    assert np.linalg.norm(found.fun) == pytest.approx(np.linalg.norm(before), rel=1e-6)


def test_residuals_are_asked_for_all_data():
    given = problem(FOUR_R["two poses"], (1, 1), seed=1)
    linkage = kl.bennett_linkages_for(given.home, given.data, starts=10)[0]
    assert max(task.residuals(linkage, given.data)) < 1e-12
    moved = [task.Pose(translation([0, 0, 0.3]) * asked.pose) for asked in given.data]
    assert task.residuals(linkage, moved, length=3) == pytest.approx((0.1, 0.1))
    with pytest.raises(ValueError, match="expected 2 data, as the linkage has parameters, got 1"):
        task.residuals(linkage, given.data[:1])


def test_a_turned_frame_finds_the_same():
    """The random chains are drawn in a frame that turns with the data, and the order of the data does not matter."""
    given = problem(FIVE_R["pose, line, two points"], seed=2)
    turn = kl.unit(1 + 2 * i - k)
    turned = (
        task.Pose(turn * given.data[0].pose),
        task.Line(given.data[1].line, act(turn, given.data[1].to)),
        *(task.Point(asked.point, act(turn, asked.to)) for asked in given.data[:1:-1]),
    )
    first = kl.goldberg_linkages_for(given.home, given.data, starts=20)
    second = kl.goldberg_linkages_for(turn * given.home, turned, starts=20)
    assert len(first) == len(second) >= 2
    for one_of, other in zip(first, second, strict=True):
        assert other.parameters[1:3] == pytest.approx(one_of.parameters[1:3], rel=1e-5)
        assert kl.same_point(other.factors[0], turn * one_of.factors[0] * turn.conjugate(), rtol=1e-6)


def test_nothing_found_is_not_said_to_be_nothing():
    far = [task.Point([0, 0, 0], [10.0**n, 0, n]) for n in range(6)]
    with pytest.raises(NotFoundError, match=r"from 2 starts with seed 7 .* does not say that there is none"):
        kl.goldberg_linkages_for(one, far, starts=2, seed=7)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (task.Pose(i), "expected a sequence of data"),
        ([i, k], "expected data such as"),
        (None, "expected a sequence of data"),
        ([task.Pose(DualQuaternion.stack([i, k])), task.Pose(i)], "a batch is a search for each of its rows"),
    ],
)
def test_what_is_no_task_is_refused(data, message):
    with pytest.raises((TypeError, ValueError), match=message):
        kl.bennett_linkages_for(one, data)


PIN, BORE = Line.at([0, 0, 0], [0, 0, 1]), Line.at([1, 2, 0], [0, 1, 2])
TOOL = task.PointAndDirection([0, 0, 0], [0, 0, 1], to_point=[1, 2, 3], to_direction=[1, 0, 0])
SLIDES = [task.PointOnLine([0, 0, 0], BORE), task.PointOnLine([1, 0, 0], BORE)]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ([task.Pose(i), task.Pose(-2 * i), *SLIDES], r"datum 2 \(Pose\) is met whenever datum 1 \(Pose\) is"),
        ([TOOL, TOOL, task.Line(PIN, BORE), SLIDES[0]], r"datum 2 \(PointAndDirection\) is met whenever datum 1"),
        (
            [task.Line(PIN, BORE), task.Line(PIN.as_dual_quaternion(), BORE), TOOL, *SLIDES],
            "datum 2 .* whenever datum 1",
        ),
        (
            [task.Pose(i), task.Orientation(i), TOOL, SLIDES[1]],
            r"datum 2 \(Orientation\) is met whenever datum 1 \(Pose",
        ),
        ([*SLIDES, task.PointOnLine([0, 0, 0], Line.at([1, 3, 2], [0, -1, -2])), TOOL], "datum 3 .* whenever datum 1"),
        ([task.Pose(one), task.Pose(i), *SLIDES], r"datum 1 \(Pose\) is met by the home pose already"),
        ([task.Point([1, 1, 1], [1, 1, 1]), *SLIDES], r"datum 1 \(Point\) is met by the home pose already"),
    ],
)
def test_data_that_ask_for_nothing_are_named(data, message):
    with pytest.raises(DegenerateError, match=message):
        kl.goldberg_linkages_for(one, data, starts=20, fill=True)


def test_data_in_a_special_place_are_named():
    """A tool that aims in two ways in one place: general data of these kinds determine finitely many linkages."""
    again = task.PointAndDirection([0, 0, 0], [0, 0, 1], [1, 2, 3], [0, 1, 0])
    with pytest.raises(DegenerateError, match=r"lie in a special way: .* can be changed without end"):
        kl.goldberg_linkages_for(one, [TOOL, again, task.Line(PIN, BORE), SLIDES[0]], starts=20)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"starts": 0}, "starts of at least 1, got 0"),
        ({"starts": 2.5}, "starts as a whole number, got 2.5"),
        ({"seed": -1}, "seed of at least 0"),
        ({"seed": None}, "seed as a whole number, got None"),
        ({"wishes": [i]}, "expected data such as"),
        ({"data": (), "fill": True}, "at least one datum or wish"),
        ({"data": [task.Point([0, 0, 0], [1e200, 0, n]) for n in range(6)]}, "coordinates that can be squared"),
    ],
)
def test_settings_that_are_none_are_refused(settings, message):
    with pytest.raises((TypeError, ValueError), match=message):
        kl.goldberg_linkages_for(one, **{"data": [task.Pose(i), TOOL, task.Point([0, 0, 1], [2, 2, 0])], **settings})


def test_a_datum_is_one_of_the_kinds_and_has_a_size():
    with pytest.raises(TypeError, match="abstract"):
        task.Datum()
    with pytest.raises(ValueError, match="positive length, the size of the problem, got 0"):
        task.Pose(i).residual(one, length=0)


def test_exact_data_and_matrices_are_taken():
    exact = [
        kl.bennett_linkages_for(home, [task.Pose(p) for p in others], starts=10) for home, *others in [THREE_POSES]
    ]
    matrices = [as_matrix(pose.astype(float)) for pose in THREE_POSES]
    floats = kl.bennett_linkages_for(matrices[0], [task.Pose(matrix) for matrix in matrices[1:]], starts=10)
    assert np.abs(exact[0][0].factors[0].coeffs - floats[0].factors[0].coeffs).max() < 1e-9


# --- data that change ---------------------------------------------------------------------------------------------


def a_path(count, step):
    """Four data, of which the point goes up."""
    given = problem(FIVE_R["pose, line, two points"], seed=11)
    ups = [step * n * np.array([0, 0, 1]) for n in range(count)]
    return given.home, [[*given.data[:3], task.Point(given.data[3].point, given.data[3].to + up)] for up in ups]


def test_a_linkage_follows_its_data():
    """And comes to linkages that the search finds for the last data, too."""
    home, path = a_path(6, 0.004)
    linkage = kl.goldberg_linkages_for(home, path[0], starts=30)[0]
    found = kl.follow(linkage, home, path)
    assert found[0] is linkage
    assert len(found) == 6
    for each, data in zip(found, path, strict=True):
        assert_meets(each, home, data)
    searched = kl.goldberg_linkages_for(home, path[-1], starts=30)
    poses = [found[-1].coupler_motion(t) for t in found[-1].parameters]
    assert any(
        all(kl.same_point(other.coupler_motion(t), q, rtol=1e-6) for t, q in zip(other.parameters, poses, strict=True))
        for other in searched
    )


def test_following_ends_where_it_cannot_go_on():
    home, path = a_path(3, 40.0)
    linkage = kl.goldberg_linkages_for(home, path[0], starts=30)[0]
    assert len(kl.follow(linkage, home, path)) == 1
    with pytest.raises(ValueError, match="misses the first data by"):
        kl.follow(linkage, home, path[1:])
    with pytest.raises(ValueError, match="expected 4 data"):
        kl.follow(linkage, home, [path[0][:3]])


# --- the picture --------------------------------------------------------------------------------------------------


def test_a_scene_shows_points_where_they_go_when_the_frame_lights_up():
    given = problem(FIVE_R["pose, line, two points"], seed=11)
    linkage = kl.goldberg_linkages_for(given.home, given.data, starts=30)[0]
    scene = task_scene(linkage, given.data, alt="A linkage.")
    lit = [part.lights_at for part in scene.parts if isinstance(part, Frame) and part.lights_at is not None]
    balls = [part for part in scene.parts if isinstance(part, Ball)]
    for asked, frame in zip(given.data[2:], lit[3:], strict=True):
        (carried,) = (ball for ball in balls if ball.body and np.allclose(ball.centre, act(given.home, asked.point)))
        reached = act(scene.motions[carried.body][frame], carried.centre)
        assert np.abs(reached - asked.to).max() < 1e-8
        assert any(not ball.body and np.allclose(ball.centre, asked.to) for ball in balls)
    with pytest.raises(ValueError, match="expected 4 data"):
        task_scene(linkage, given.data[:2], alt="A linkage.")
