"""Where the bars of a linkage meet, and how near they come: exact, in floats, and by dense sampling."""

import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from kinlib import (
    CollisionFault,
    DegenerateError,
    DualQuaternion,
    Linkage,
    act,
    bennett_flip,
    bennett_linkage,
    eps,
    goldberg_linkages,
    i,
    is_exact,
    j,
    k,
    six_r_linkages,
)  # fmt: skip
from kinlib.gallery import LINEAR_TERMS_EQUAL, THREE_POSES
from kinlib.moving_bars import distance, pairs_without_joint
from kinlib.testing import random_poses

EXACT_5R = goldberg_linkages(*THREE_POSES, (-2, 3))
FREE = goldberg_linkages(*random_poses(3, seed=0), 0.4 + 0.7j)[1]


# --- a second source ----------------------------------------------------------------------------------------------


def bars_at(linkage, t, bars=None):
    """The points of all bars at parameters t, in the fixed frame; shape (times, n, m, 3)."""
    bars = linkage.bars() if bars is None else bars
    return act(linkage.link_displacements(np.asarray(t, dtype=float))[..., None], bars)


def segment_distances(points, a, b):
    """The distances of two straight bars by sampling one of them: each of its points to the other segment."""
    steps = np.linspace(0, 1, 201)[:, None, None]
    x = points[:, a, 0] + steps * (points[:, a, 1] - points[:, a, 0])
    start, way = points[:, b, 0], points[:, b, 1] - points[:, b, 0]
    along = np.clip(((x - start) * way).sum(-1) / (way * way).sum(-1), 0, 1)[..., None]
    return np.linalg.norm(x - start - along * way, axis=-1).min(axis=0)


def sampled_clearance(linkage, times=2000, bars=None):
    """The least distance of bars without a common joint at many t, and how much two samples in a row differ."""
    angle = np.pi * (np.arange(times) + 0.5) / times
    points = bars_at(linkage, 1 / np.tan(angle), bars)
    count = linkage.joint_count
    pairs = [(a, b) for a in range(count) for b in range(a + 2, min(count, a + count - 1))]
    distances = np.array([segment_distances(points, a, b) for a, b in pairs])
    return distances.min(), np.abs(np.diff(distances, axis=-1)).max()


def size_of(bars):
    return np.linalg.norm(bars - bars.mean(axis=(0, 1)), axis=-1).max()


def exact_linkages():
    return [bennett_linkage(*THREE_POSES), *EXACT_5R]


# --- segments and pairs -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(30))
def test_the_distance_of_two_segments_is_a_bounded_least_squares_problem(seed):
    a, b, c, d = np.random.default_rng(seed).normal(size=(4, 3))
    d = c + (b - a) * 0.7 if seed % 5 == 0 else d  # parallel ones too
    best = lsq_linear(np.stack([b - a, c - d], axis=-1), c - a, bounds=(0, 1), tol=1e-14)
    gap, s, r = distance(a, b, c, d)
    assert gap == pytest.approx(np.linalg.norm(best.fun), abs=1e-6)
    assert np.linalg.norm(a + s * (b - a) - c - r * (d - c)) == pytest.approx(gap)


def test_links_that_share_no_joint():
    assert [set(pair[:2]) for pair in pairs_without_joint((1, 1, 1, 1))] == [{0, 2}, {1, 3}]
    assert len(pairs_without_joint((2, 1, 1, 1, 1))) == 5
    assert len(pairs_without_joint((1,) * 6)) == 9
    assert pairs_without_joint((1, 1, 1)) == []


# --- exact collisions ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(5))
def test_exact_bars_meet_exactly_where_it_is_said(number):
    linkage = exact_linkages()[number]
    hits = linkage.collisions()
    assert hits.count == len(hits.entries) > 0
    for hit in hits.entries:
        assert is_exact(np.array([hit.t, *hit.point], dtype=object)) or hit.t == math.inf
        points = bars_at(linkage.astype(float), float(hit.t))
        where = np.array(hit.point, dtype=float)
        for link in hit.links:
            assert distance(*points[link], where, where)[0] < 1e-9


@pytest.mark.parametrize("number", range(5))
def test_floats_find_what_exact_numbers_find(number):
    linkage = exact_linkages()[number]
    exact, floats = linkage.collisions(), linkage.astype(float).collisions()
    assert floats.count == exact.count
    assert np.array_equal(floats.links, exact.links)
    assert np.array_equal(floats.crossing, exact.crossing)
    np.testing.assert_allclose(floats.t, exact.t.astype(float), atol=1e-9)
    np.testing.assert_allclose(floats.point, exact.point.astype(float), atol=1e-9)


@pytest.mark.parametrize(
    "z",
    [
        (-8, Fraction(-2, 3)),
        (Fraction(4, 5), Fraction(3, 10000)),
        (3, Fraction(1, 2000)),
        (8000, 401),
        (Fraction(5000, 3), -1999),
    ],
    ids=str,
)
@pytest.mark.parametrize("number", [0, 1])
def test_where_joints_turn_fast_floats_find_what_exact_numbers_find(z, number):
    """Meetings lie near each other, next to roots where nothing meets, and the lines are nearly parallel there."""
    linkage = goldberg_linkages(*THREE_POSES, z)[3 * number]
    exact, floats = linkage.collisions(), linkage.astype(float).collisions()
    assert floats.links.tolist() == exact.links.tolist()
    assert floats.crossing.tolist() == exact.crossing.tolist()
    np.testing.assert_allclose(floats.t, exact.t.astype(float), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(floats.point, exact.point.astype(float), atol=1e-7)


def test_the_point_at_infinity_is_no_exception():
    hits = bennett_linkage(*THREE_POSES).collisions()
    assert hits.t.tolist() == [0, math.inf]
    assert hits.point[1].tolist() == [Fraction(-1, 3), 0, 0]


def test_a_crossing_changes_sides():
    linkage = EXACT_5R[0].astype(float)
    hits = linkage.collisions().entries
    assert all(hit.crossing for hit in hits)
    for hit in hits:
        before, after = bars_at(linkage, [hit.t - 1e-4, hit.t + 1e-4])
        a, b = hit.links
        sides = [np.linalg.det([*np.diff(p[[a, b]], axis=1)[:, 0], p[b, 0] - p[a, 0]]) for p in (before, after)]
        assert sides[0] * sides[1] < 0


def test_an_irrational_linkage_is_asked_for_in_floats():
    linkage = bennett_linkage(*LINEAR_TERMS_EQUAL)
    with pytest.raises(ValueError, match="float"):
        linkage.collisions()
    assert linkage.astype(float).collisions().count >= 0


# --- Bennett linkages fold flat -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_the_straight_bars_of_a_bennett_linkage_always_meet(seed):
    linkage = bennett_linkage(*random_poses(3, seed=seed))
    hits = linkage.collisions()
    assert hits.count > 0
    assert linkage.clearance() == 0
    flat = [hit for hit in hits.entries if not hit.crossing]
    points = bars_at(linkage, [hit.t for hit in flat])
    for all_bars in points:  # all bars on one line
        ends = all_bars.reshape(-1, 3)
        spread = np.linalg.svd(ends - ends.mean(axis=0), compute_uv=False)
        assert spread[1] < 1e-6 * spread[0]


def shifted(linkage, heights):
    """Bent bars: each joint sits at two heights on its axis, one for each link."""
    l = linkage.axes.coeffs[..., 1:4].astype(float)
    l = l / np.linalg.norm(l, axis=-1, keepdims=True)
    bars = linkage.bars()
    before, after = np.roll(l, 1, axis=0), l
    down, up = bars[:, 0] + heights[0] * before, bars[:, 1] + heights[1] * after
    return np.stack([down, bars[:, 0], bars[:, 1], up], axis=1)


def test_bars_between_other_points_of_the_axes_need_not_meet():
    linkage = bennett_linkage(*random_poses(3, seed=1))
    l = linkage.axes.coeffs[:, 1:4]
    heights = np.random.default_rng(0).normal(size=(60, 4)) * 2
    ends = [linkage.bars() + np.stack([np.roll(h[:, None] * l, 1, 0), h[:, None] * l], axis=1) for h in heights]
    clearances = linkage.clearance(np.array(ends))
    assert clearances.shape == (60,)
    assert np.max(clearances) > 0
    best = int(np.argmax(clearances))
    assert linkage.collisions(ends[best]).count == 0
    sampled, step = sampled_clearance(linkage, bars=ends[best])
    assert sampled - step <= clearances[best] <= sampled + 1e-3 * size_of(ends[best])


def test_a_bar_through_a_bend_is_met_once():
    """Bars with a point more in the middle are the same bars."""
    linkage = EXACT_5R[0]
    straight = linkage.collisions()
    bars = linkage.astype(float).bars()
    bent = np.stack([bars[:, 0], bars.mean(axis=1), bars[:, 1]], axis=1)
    same = linkage.collisions(bent)
    assert same.count == straight.count
    np.testing.assert_allclose(same.t, straight.t.astype(float))
    np.testing.assert_allclose(same.point, straight.point.astype(float), atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_bent_bars_hold_straight_ones(seed):
    linkage = bennett_linkage(*random_poses(3, seed=seed))
    bent = shifted(linkage, (0.0, 0.0))
    straight, same = linkage.collisions(), linkage.collisions(bent)
    assert same.count == straight.count
    np.testing.assert_allclose(same.t, straight.t, rtol=1e-6)
    pieces = linkage.collisions(shifted(linkage, (0.3, -0.2)))
    assert set(np.round(straight.t, 5)) <= set(np.round(pieces.t, 5))


# --- 5R -----------------------------------------------------------------------------------------------------------


def test_a_5r_whose_bars_never_meet():
    assert FREE.collisions().count == 0
    assert FREE.collisions().entries == ()


def test_clearance_is_what_dense_sampling_finds():
    for linkage in (*goldberg_linkages(*random_poses(3, seed=3), 0.4 + 0.7j), FREE):
        sampled, step = sampled_clearance(linkage)
        for rtol in (1e-1, 1e-2, 1e-4):
            found = linkage.clearance(rtol=rtol)
            assert found <= sampled + rtol * size_of(linkage.bars()) + 1e-9
            assert found >= sampled - step


@pytest.mark.parametrize("seed", range(8))
def test_no_meeting_is_missed(seed):
    """Where samples come very near each other and far again, a collision is listed, or the clearance is as small."""
    for linkage in goldberg_linkages(*random_poses(3, seed=seed), 0.3 - 0.9j)[::3]:
        sampled, step = sampled_clearance(linkage)
        clearance = linkage.clearance()
        assert (clearance == 0) == (linkage.collisions().count > 0)
        assert clearance >= sampled - step
        assert clearance <= sampled + 1e-3 * size_of(linkage.bars())


def test_a_part_of_the_5r_of_three_poses_is_free():
    random = np.random.default_rng(3)
    z = random.normal(size=400) + 1j * random.normal(size=400)
    linkages = goldberg_linkages(*random_poses(3, seed=2), z, degenerate="nan")
    free = np.concatenate([linkage.collisions(degenerate="nan").count == 0 for linkage in linkages])
    assert 0.02 < free.mean() < 0.98


@pytest.mark.parametrize("seed", range(2))
def test_the_bars_of_a_6r(seed):
    for linkage in six_r_linkages(*random_poses(4, seed=seed + 1))[:3]:
        hits = linkage.collisions()
        assert (linkage.clearance() == 0) == (hits.count > 0)
        for hit in hits.entries:
            points = bars_at(linkage, hit.t)
            assert distance(*points[hit.links[0]], *points[hit.links[1]])[0] < 1e-8 * size_of(linkage.bars())


# --- batches, frames, units ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(1,), (3, 1, 2)])
def test_a_batch_is_answered_row_by_row(shape):
    linkage = goldberg_linkages(*random_poses(3, seed=4, shape=shape), 0.4 + 0.7j)[0]
    hits, clearance = linkage.collisions(), linkage.clearance()
    assert hits.shape == np.shape(hits.count) == np.shape(clearance) == shape
    for index in np.ndindex(shape):
        alone = linkage[index].collisions()
        assert hits[index].count == alone.count
        np.testing.assert_allclose(hits[index].t[: alone.count], alone.t, rtol=1e-6)
        assert linkage[index].clearance() == pytest.approx(clearance[index], rel=1e-6, abs=1e-12)
    assert [row.shape for row in hits] == [shape[1:]] * shape[0]


def test_nan_rows_stay_rows():
    linkage = goldberg_linkages(*random_poses(3, seed=4, shape=(3,)), 0.4 + 0.7j)[0]
    spoiled = DualQuaternion(np.where(np.arange(3)[:, None] == 1, np.nan, linkage.factors[0].coeffs))
    whole = Linkage((spoiled, *linkage.factors[1:]), linkage.joints, linkage.coupler, linkage.home)
    hits, clearance = whole.collisions(), whole.clearance()
    assert np.isnan(hits.count).tolist() == np.isnan(clearance).tolist() == [False, True, False]
    assert np.isnan(hits.t[1]).all()
    assert hits[1].entries == ()
    assert "no answer" in repr(hits[1])
    np.testing.assert_allclose(clearance[[0, 2]], linkage.clearance()[[0, 2]])


@pytest.mark.parametrize("length", [1e-6, 1e6])
@pytest.mark.parametrize("seed", range(3))
def test_frames_and_units_do_not_matter(seed, length):
    linkage = goldberg_linkages(*random_poses(3, seed=seed), 0.4 + 0.7j)[1]
    (q,) = random_poses(1, seed=9)
    factors = [q * f * q.inverse() for f in linkage.factors]
    scale = np.array([1] * 4 + [length] * 4)
    factors = [DualQuaternion(f.coeffs * scale) for f in factors]
    moved = Linkage(factors, linkage.joints, linkage.coupler)
    bars = act(q, linkage.bars()) * length
    assert moved.clearance(bars) == pytest.approx(linkage.clearance() * length, rel=1e-6, abs=1e-12 * length)
    first, second = linkage.collisions(), moved.collisions(bars)
    assert first.count == second.count
    np.testing.assert_allclose(second.t, first.t, rtol=1e-5)
    if first.count:
        np.testing.assert_allclose(second.point, act(q, first.point) * length, atol=1e-5 * length)


def test_exact_batches():
    poses = [DualQuaternion.stack([p, p]) for p in THREE_POSES]
    hits = bennett_linkage(*poses).collisions()
    assert hits.count.tolist() == [2, 2]
    assert hits[1].entries[0].t == 0


# --- what is refused ----------------------------------------------------------------------------------------------


def planar_loop():
    """A planar loop: all axes parallel to k."""
    h1, h2 = k, 2 * k + 2 * eps * i
    return Linkage.from_chains([h1, h2], bennett_flip(h1, h2))


@pytest.mark.parametrize("kind", [None, float])
def test_bars_of_one_plane_are_named(kind):
    linkage = planar_loop() if kind is None else planar_loop().astype(float)
    with pytest.raises(DegenerateError, match="one plane"):
        linkage.collisions()
    assert np.isnan(linkage.collisions(degenerate="nan").count)
    assert linkage.clearance() >= 0
    assert CollisionFault(1) is CollisionFault.IN_A_PLANE


def test_bars_must_go_from_axis_to_axis():
    linkage = bennett_linkage(*THREE_POSES)
    bars = linkage.bars().copy()
    with pytest.raises(ValueError, match="shape"):
        linkage.collisions(bars[:3])
    with pytest.raises(ValueError, match="link 0 on axis 1"):
        linkage.clearance(bars + np.array([[0.0, 0, 0], [0.1, 0.2, 0.3]]) * (np.arange(4) == 0)[:, None, None])
    with pytest.raises(ValueError, match="rtol"):
        linkage.clearance(rtol=0)
    with pytest.raises(ValueError, match="degenerate"):
        linkage.collisions(degenerate="perhaps")


def test_a_batch_has_no_entries_and_a_single_answer_no_length():
    single = bennett_linkage(*THREE_POSES).collisions()
    with pytest.raises(TypeError):
        len(single)
    with pytest.raises(TypeError):
        goldberg_linkages(*random_poses(3, seed=4, shape=(2,)), 0.4 + 0.7j)[0].collisions().entries  # noqa: B018


@pytest.mark.parametrize("kind", [None, float])
def test_a_bar_of_length_zero_is_a_point(kind):
    h1, h2 = i, i + 2 * j  # a spherical loop: all axes meet
    linkage = Linkage.from_chains([h1, h2], bennett_flip(h1, h2))
    directions = linkage.axes.coeffs[:, 1:4]
    ends = np.stack([np.roll(directions, 1, axis=0), directions], axis=1)
    ends[0] = 0
    linkage = linkage if kind is None else linkage.astype(float)
    hits = linkage.collisions(ends if kind is None else ends.astype(float))
    assert all(hit.links == (1, 3) for hit in hits.entries)
    assert linkage.clearance(ends) >= 0
