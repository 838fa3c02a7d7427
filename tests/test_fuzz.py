"""The judge of the fuzz tells right from wrong; a short run of the fuzz finds nothing wrong."""

import math
from collections import Counter
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

from tests.fuzz import geometry, matrices
from tests.fuzz.fixed_point import ONE, fixed, product, ratio
from tests.fuzz.judge import RTOL, frame_of, judge_dyad, judge_linkage, judge_motion
from tests.fuzz.poses import compose, factor, inverse, of_unit_length, pose, quaternions, study_form
from tests.fuzz.problems import CELLS, plain
from tests.fuzz.run import attempt, tasks_of
from tests.fuzz.trial import GOOD

# A Bennett linkage whose factorizations are known in whole fractions: (t − h1)(t − h2) = (t − k1)(t − k2).
H1, H2 = np.array([0, 1, 0, 0, 0, 0, 0, 0]), np.array([0, 0, 2, 0, 0, -2, 0, 0])
K1 = np.array([0, 8 / 5, 6 / 5, 0, 0, -18 / 25, 24 / 25, 0])
K2 = np.array([0, -3 / 5, 4 / 5, 0, 0, -32 / 25, -24 / 25, 0])
CONJUGATE = np.array([1, -1, -1, -1] * 2)
TIMES = (math.inf, 0.0, 1.0)


def bennett():
    """Its factors around the loop, its home and its poses, as the judge takes them."""
    factors = [x[None].astype(float) for x in (H1, H2, CONJUGATE * K2, CONJUGATE * K1)]
    home = np.eye(8)[:1]
    poses = [home, *(of_unit_length(compose(factor(t, factors[0]), factor(t, factors[1]))) for t in TIMES[1:])]
    return factors, home, np.array(poses)


def verdict(factors, home, poses, joints=(1, 1, 1, 1)):
    return judge_linkage(factors, joints, 2, home, [np.array([t]) for t in TIMES], poses, frame_of(poses))


def displaced(x, by):
    """A factor about another axis: seen after a displacement."""
    return compose(compose(by, x), inverse(by))


def small_shift(size: float):
    return np.array([[1, 0, 0, 0, 0, 0, size / 2, size / 3]])


def test_fixed_point_reads_floats_and_fractions_without_loss():
    numbers = np.array([0.1, -3.5, 1e-30, 1e30])
    assert ratio(fixed(numbers), ONE).tolist() == numbers.tolist()
    assert fixed(np.array([Fraction(1, 3)]))[0] == ONE // 3


def test_fixed_point_multiplies_as_hamilton_does():
    units = [fixed(np.eye(8)[n][:, None]) for n in range(8)]
    one, i, j, k, eps = units[:5]
    assert all((x == -one).all() for x in (product(i, i), product(j, j), product(product(i, j), k)))
    assert (product(eps, eps) == 0).all()
    assert (product(eps, i) == units[5]).all()


def test_a_right_linkage_is_right():
    assert verdict(*bennett()).excess[0] < 1e-3


@pytest.mark.parametrize("joint", range(4))
def test_an_axis_moved_by_a_ten_millionth_is_wrong(joint):
    factors, home, poses = bennett()
    factors[joint] = displaced(factors[joint], small_shift(1e-7))
    assert not verdict(factors, home, poses).right[0]


@pytest.mark.parametrize("joint", range(4))
def test_an_axis_turned_by_a_ten_millionth_is_wrong(joint):
    factors, home, poses = bennett()
    factors[joint] = displaced(factors[joint], np.array([[1, 0, 0, 1e-7, 0, 0, 0, 0]]))
    assert not verdict(factors, home, poses).right[0]


def test_swapped_poses_are_missed():
    factors, home, poses = bennett()
    found = verdict(factors, home, poses[[0, 2, 1]])
    assert not found.right[0]
    assert "missed" in found.worst(0)


def test_another_home_is_wrong():
    factors, home, poses = bennett()
    assert not verdict(factors, compose(home, small_shift(1e-7)), poses).right[0]


def test_an_open_loop_is_wrong_though_the_poses_are_met():
    factors, home, poses = bennett()
    found = verdict([*factors[:2], factors[3], factors[2]], home, poses)
    assert found.worst(0).startswith("loop open")
    assert not found.right[0]


def test_a_screw_is_no_axis():
    factors, home, poses = bennett()
    factors[0] = factors[0] + np.array([[0, 0, 0, 0, 0, 1e-7, 0, 0]])
    assert verdict(factors, home, poses).parts["axes that are no lines"][0] > 1


def test_two_axes_are_not_one_joint():
    factors, home, poses = bennett()
    assert verdict(factors, home, poses, joints=(2, 1, 1)).parts["factors of one joint about two axes"][0] > 1


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("reach", [0.0, 1e4])
def test_the_verdict_depends_on_neither_frame_nor_unit(length, reach):
    factors, home, poses = bennett()
    unit = np.array([1] * 4 + [length] * 4)
    away = pose(quaternions(np.random.default_rng(1), 1), length * np.array([[reach, 1, 1]]))
    there = [displaced(f * unit, away) for f in factors]
    home_there, poses_there = compose(away, home * unit), compose(away, poses * unit)
    assert verdict(there, home_there, poses_there).right[0]
    there[1] = displaced(there[1], small_shift(1e-6 * length))
    assert not verdict(there, home_there, poses_there).right[0]


def test_a_representative_does_not_matter():
    factors, home, poses = bennett()
    assert verdict(factors, -1e8 * home, poses * np.array([1e-9, -1, 1e7])[:, None, None]).right[0]


@pytest.mark.parametrize("seed", range(5))
def test_both_judges_measure_the_same_miss(seed):
    random = np.random.default_rng(seed)
    factors, home, poses = bennett()
    moves = [
        np.array([[1, 0, 0, 0, 0, 0, 0, 0]]) + 1e-6 * random.normal(size=(1, 8)) * (np.arange(8) % 4 > 0)
        for _ in "1234"
    ]
    factors = [displaced(f, of_unit_length(move)) for f, move in zip(factors, moves, strict=True)]
    frame = frame_of(poses)
    found = verdict(factors, home, poses)
    for number in (1, 2):
        there = matrices.carried([f[0] for f in factors[:2]], TIMES[number])
        wanted = matrices.matrix_of_pose(poses[number, 0])
        shift = matrices.shift_between(there, wanted, frame.middle[0]) / (RTOL * frame.length[0])
        assert shift <= found.parts[f"pose {number} missed"][0] * 1.01
        off = there[:3, :3] * wanted[:3, :3].T
        turn = float(mp.norm(off - mp.eye(3))) / math.sqrt(2) / (RTOL * frame.turn[0])
        assert max(shift, turn) == pytest.approx(found.parts[f"pose {number} missed"][0], rel=0.05)


def test_the_second_judge_finds_the_loop_closed():
    factors, _, _ = bennett()
    for t in (-1.3, 0.2, 5.0):
        assert float(mp.norm(matrices.carried([f[0] for f in factors], t) - mp.eye(4))) < 1e-14


# --- dyads ------------------------------------------------------------------------------------------------------


def dyad_and_poses(tilt: float):
    """A dyad whose axes make a given angle, and poses of it."""
    random = np.random.default_rng(4)
    directions = np.array([[0, 0, 1], [math.sin(tilt), 0, math.cos(tilt)]])
    points = random.normal(size=(2, 3))
    h = [np.concatenate([[0], l, [0], np.cross(a, l)])[None] for l, a in zip(directions, points, strict=True)]
    turns = random.normal(size=(2, 2))
    poses = [np.eye(8)[:1], *(of_unit_length(compose(factor(s, h[0]), factor(t, h[1]))) for s, t in turns)]
    return h, np.array(poses)


@pytest.mark.parametrize("tilt", [1.0, 1e-3, 1e-6, 1e-9])
def test_a_dyad_contains_its_poses_and_no_others(tilt):
    (h1, h2), poses = dyad_and_poses(tilt)
    frame, home = frame_of(poses), poses[0]
    assert judge_dyad(h1, h2, home, poses, frame).right[0]
    assert not judge_dyad(displaced(h1, small_shift(1e-6)), h2, home, poses, frame).right[0]
    assert not judge_dyad(h2, h1, home, poses, frame).right[0]


def conic(poses):
    """The coefficients of the conic at ∞, 0 and 1, from p0 t (t − 1) − (b02/b12) (t − 1) p1 + (b01/b12) t p2."""
    p0, p1, p2 = poses
    q1, q2 = p1 * (study_form(p0, p2) / study_form(p1, p2)), p2 * (study_form(p0, p1) / study_form(p1, p2))
    return [p0, q2 - q1 - p0, q1]


def test_a_motion_passes_through_its_poses_and_through_no_others():
    poses = plain(3)(np.random.default_rng(2), 1, None)
    frame = frame_of(poses)
    assert judge_motion(conic(poses), poses, frame).right[0]
    assert not judge_motion(conic(poses), poses[[0, 2, 1]], frame).right[0]
    first, second, third = conic(poses)
    off = judge_motion([first, second + 1e-6 * np.eye(8)[4], third], poses, frame)
    assert off.parts["off the Study quadric"][0] > 1


# --- refusals ---------------------------------------------------------------------------------------------------

NEAR = {
    "p0, p1 nearly equal": "poses 0 and 1 are equal",
    "p0, p1 nearly a translation": "poses 0 and 1 differ by a pure translation",
    "p1, p2 nearly a rotation": "the plane is tangent to the Study quadric",
    "axes nearly parallel": "the orientations differ by rotations about parallel axes",
    "nearly double roots": "the quartic has double roots",
    "nearly spherical": "the plane lies in the Study quadric",
    "near planar": "the plane meets the exceptional three-space",
}


def _cell(count: int, distribution: str, distance: float | None):
    near = [cell for cell in CELLS[count] if cell.distribution == distribution]
    return min(near, key=lambda cell: abs(math.log(cell.distance / distance)) if distance else 0)


@pytest.mark.parametrize(("distribution", "message"), NEAR.items())
def test_refusals_are_true_near_what_they_name_and_false_elsewhere(distribution, message):
    close = _cell(3, distribution, 1e-14).block(1, 0, 3).poses
    apart = _cell(3, distribution, 1e-1).block(1, 0, 3).poses
    for row in range(3):
        problem = geometry.Poses(close[:, row])
        assert geometry.is_true(message, geometry.of_three_poses(close[:, row]), problem.reach)[0]
        assert not geometry.is_true(message, geometry.of_three_poses(apart[:, row]))[0]


@pytest.mark.parametrize(
    ("distribution", "message"),
    [
        ("z near the real axis", "z is real"),
        ("z near a side", "z lies on a side of the triangle: the cubic misses pose 1"),
        ("z near the circumcircle", "z lies on the circumcircle"),
        ("z near the corner of Bennett", "z belongs to the Bennett linkage through the poses"),
        ("z near √−1", "the quadratic is that of the other axis (z = ±√−1)"),
        ("partner near √−1", "the quadratic of its partner is that of the other axis (z = ±√−1)"),
        ("z near an in- or excentre", "z is an incentre or excentre of the triangle"),
    ],
)
def test_refusals_of_z_are_true_near_what_they_name(distribution, message):
    for distance, expected in ((1e-10, True), (1e-1, False)):
        block = _cell(3, distribution, distance).block(1, 0, 3)
        for row in range(3):
            measures = geometry.of_z(block.poses[:, row], complex(block.z[row]))
            assert geometry.is_true(message, measures)[0] == expected


@pytest.mark.parametrize(
    ("distribution", "message"),
    [
        ("p3 nearly on the conic", "the four poses are dependent"),
        ("p0, p1 nearly equal", "poses 0 and 1 are equal"),
        ("p2, p3 nearly a rotation", "poses 2 and 3 differ by a rotation"),
        ("free near a missed pose", "for this value of the free parameter the cubic misses pose 1"),
    ],
)
def test_refusals_of_four_poses_are_true_near_what_they_name(distribution, message):
    for distance, expected in ((1e-10, True), (1e-1, False)):
        block = _cell(4, distribution, distance).block(1, 0, 3)
        for row in range(3):
            free = 0 if block.free is None else float(block.free[row])
            assert geometry.is_true(message, geometry.of_four_poses(block.poses[:, row], free))[0] == expected


def test_ordinary_problems_are_far_from_everything():
    poses = plain(3)(np.random.default_rng(1), 20, None)
    assert all(min(geometry.of_three_poses(poses[:, row]).values()) > 1e-4 for row in range(20))


# --- problems and runs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [3, 4])
def test_problems_are_the_same_for_the_same_name(count):
    for cell in CELLS[count][::17]:
        first, again, other = cell.block(1, 0, 5), cell.block(1, 0, 5), cell.block(2, 0, 5)
        assert first.name == again.name
        assert (first.poses == again.poses).all()
        assert (first.poses != other.poses).any()


@pytest.mark.parametrize("count", [3, 4])
def test_a_short_fuzz_finds_nothing_wrong(count):
    tasks = [task for task in tasks_of(count, 1) if task[1] % 4 == 0]
    outcomes = [outcome for task in tasks for outcome in attempt(task)]
    bad = [outcome for outcome in outcomes if outcome.band not in GOOD]
    counts = Counter((outcome.function, outcome.band) for outcome in bad)
    assert bad == [], f"{dict(counts)} of {len(outcomes)}; python -m tests.fuzz --replay {bad[0].name!r}"
