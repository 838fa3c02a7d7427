"""The search finds what looking at every linkage finds, and its measures are those of dense sampling."""

import numpy as np
import pytest

from kinlib import Brief, ZGrid, act, as_matrix, goldberg_linkages, refine, search
from kinlib.brief import NAMES
from kinlib.collision import clearances
from kinlib.gallery import THREE_POSES
from kinlib.measures import bar_lengths, clearance_at_most, folds, moving_bars, room_about, smallest_angle, travel
from kinlib.testing import random_poses
from laws import COVERED

COVERED.update(("Brief", "Choice", "ZGrid", "refine", "search"))

GRID = ZGrid(-2 - 2j, 2 + 2.5j, (9, 8))
POSES = [pose.astype(float) for pose in THREE_POSES]
CENTRE = np.mean([as_matrix(pose)[:3, 3] for pose in POSES], axis=0)


@pytest.fixture(scope="module")
def everything():
    """All linkages of the grid in eight batches, and their measures, shape (8, points)."""
    linkages = goldberg_linkages(*POSES, GRID.points(0, len(GRID)), degenerate="nan")
    lengths = np.array([bar_lengths(linkage) for linkage in linkages])
    clearance = np.array([linkage.clearance() for linkage in linkages])
    measures = {
        "shortest_bar": lengths.min(axis=-1),
        "longest_bar": lengths.max(axis=-1),
        "total_length": lengths.sum(axis=-1),
        "smallest_angle": np.array([smallest_angle(linkage) for linkage in linkages]),
        "travel": np.array([travel(linkage) for linkage in linkages]),
        "room": np.array([room_about(linkage, CENTRE) for linkage in linkages]),
        "clearance": clearance,
        "relative_clearance": clearance / lengths.sum(axis=-1),
    }
    return linkages, measures


BRIEFS = [
    (Brief(), "relative_clearance"),
    (Brief(longest_bar=1.8, smallest_angle=0.3, clearance=0.05), "room"),
    (Brief(travel=4.8, order=(0, 1, 2)), "clearance"),
    (Brief(room=2.1, relative_clearance=0.02), "travel"),
    (Brief(shortest_bar=0.5, total_length=6.0), "longest_bar"),
    (Brief(longest_bar=2.5), "smallest_angle"),
]


@pytest.mark.parametrize(("brief", "best"), BRIEFS, ids=[f"{brief} {best}" for brief, best in BRIEFS])
def test_the_best_are_those_of_all(everything, brief, best):
    linkages, measures = everything
    fine = np.isfinite(measures["room"])
    if brief.order is not None:
        fine &= [(linkage.order_of_visits() == brief.order).all(axis=-1) for linkage in linkages]
    for name in NAMES:
        fine &= brief.allows(name, measures[name])
    sign = 1 if best in ("clearance", "relative_clearance", "smallest_angle", "shortest_bar") else -1
    wanted = np.sort(np.where(fine, sign * measures[best], -np.inf), axis=None)[::-1][:7]
    found = search(*THREE_POSES, GRID, brief, best=best, keep=7, block=30)
    assert fine.sum() >= 7
    np.testing.assert_allclose(sign * found.measures[best], wanted, rtol=1e-6)
    for number, linkage in enumerate(found.linkages):
        column = int(np.argmin(np.abs(GRID.points(0, len(GRID)) - found.z[number])))
        which = 2 * found.planes[number] + found.partners[number]
        assert fine[which, column]
        np.testing.assert_allclose(linkage.axes.coeffs, linkages[which][column].axes.coeffs, atol=1e-9)


def test_what_is_left_is_counted(everything):
    _, measures = everything
    found = search(*THREE_POSES, GRID, Brief(longest_bar=1.8, travel=4.0), best="room", keep=2)
    short = measures["longest_bar"] <= 1.8
    counts = [np.isfinite(measures["room"]).sum(), short.sum(), (short & (measures["travel"] <= 4.0)).sum()]
    assert found.left == dict(zip(("linkages", "longest_bar", "travel"), map(int, counts), strict=True)) | {
        "room": counts[-1]
    }


def test_points_of_a_grid_are_the_middles_of_its_cells():
    x, y = np.meshgrid(
        np.linspace(-2, 2, 9, endpoint=False) + 2 / 9, np.linspace(-2, 2.5, 8, endpoint=False) + 4.5 / 16
    )
    np.testing.assert_allclose(GRID.points(0, 72), (x + 1j * y).ravel())
    np.testing.assert_array_equal(GRID.points(5, 40), GRID.points(0, 72)[5:40])


def test_given_points_are_searched_as_a_grid_is():
    given = search(*THREE_POSES, GRID.points(0, len(GRID)), keep=3)
    grid = search(*THREE_POSES, GRID, keep=3)
    np.testing.assert_array_equal(given.z, grid.z)
    assert {name: values.tolist() for name, values in given.measures.items()} == {
        name: values.tolist() for name, values in grid.measures.items()
    }


@pytest.mark.parametrize("seed", range(3))
def test_bars_that_are_known_to_touch_do(seed):
    """No row with room between its bars is left out, and the bound is one."""
    poses = random_poses(3, seed=seed)
    z = np.random.default_rng(seed).normal(size=(60, 2)) @ [1, 1j]
    touching = 0
    for linkage in goldberg_linkages(*poses, z, degenerate="nan"):
        known, clearance = folds(linkage), linkage.clearance()
        assert np.all(clearance[known] == 0)
        assert np.all((clearance_at_most(linkage) >= clearance * (1 - 1e-9)) | np.isnan(clearance))
        touching += known.sum()
    assert touching > 240


@pytest.mark.parametrize("seed", range(2))
def test_what_is_not_enough_need_not_be_known(seed):
    """Clearances that are enough are found to the last bit, the others to be below, at any bound."""
    poses = random_poses(3, seed=seed)
    z = np.random.default_rng(seed).normal(size=(40, 2)) @ [1, 1j]
    for linkage in goldberg_linkages(*poses, z, degenerate="nan")[::3]:
        bars, clearance = moving_bars(linkage), linkage.clearance()
        for enough in (0.0, np.nanquantile(clearance, 0.6), np.nanquantile(clearance, 0.9)):
            found = clearances(bars, linkage.joints, 1e-3, np.full(40, enough))
            above = clearance >= enough
            np.testing.assert_array_equal(found[above], clearance[above])
            assert np.all((found[~above] < enough) | np.isnan(clearance[~above]))
            most = clearance_at_most(linkage, enough)
            assert np.all((most >= enough) | ~above)


def sampled(linkage, count=3000):
    return np.tan(np.linspace(-np.pi / 2, np.pi / 2, count, endpoint=False))


def test_travel_is_that_of_dense_sampling(everything):
    linkages, measures = everything
    for number in (0, 3):
        for column in range(0, 72, 5):
            linkage = linkages[number][column]
            if not np.isfinite(measures["travel"][number, column]):
                continue
            stops = sorted(float(t) for t in linkage.parameters[1:])
            full = linkage.joint_angles(-np.inf)
            ways = []
            for low, high, more in ((stops[0], np.inf, None), (-np.inf, stops[1], None), (stops[1], stops[0], True)):
                t = sampled(linkage)
                if more is None:
                    angles = linkage.joint_angles(np.append(t[(t >= low) & (t <= high)], [low, high]))
                else:  # from stop 1 through infinity to stop 0
                    first = linkage.joint_angles(np.append(t[t <= high], [high, -np.inf]))
                    angles = np.concatenate([first, linkage.joint_angles(np.append(t[t >= low], low)) + full])
                ways.append(np.ptp(angles, axis=0).max())
            assert measures["travel"][number, column] == pytest.approx(min(ways), abs=2e-2)
            assert measures["travel"][number, column] >= min(ways) - 1e-9


def test_room_is_nearly_that_of_dense_sampling(everything):
    linkages, measures = everything
    linkage = linkages[2][30]
    ends = act(linkage.link_displacements(sampled(linkage))[..., None], linkage.bars())
    dense = np.linalg.norm(ends - CENTRE, axis=-1).max()
    assert 0.97 * dense < measures["room"][2, 30] <= dense * (1 + 1e-6)


def test_the_smallest_angle_is_that_of_the_table(everything):
    linkages, measures = everything
    twists = np.abs([row.twist for row in linkages[5].denavit_hartenberg()])
    np.testing.assert_allclose(measures["smallest_angle"][5], np.minimum(twists, np.pi - twists).min(axis=0), atol=1e-7)


def test_refining_stays_within_the_brief_and_gets_better():
    brief, best = Brief(smallest_angle=0.5), "total_length"
    found = search(*THREE_POSES, GRID, brief, best=best, keep=2)
    better = refine(*THREE_POSES, found, brief, best=best)
    assert len(better) == 2
    assert np.all(np.sort(better.measures[best]) < np.sort(found.measures[best]))
    assert np.all(better.measures["smallest_angle"] >= 0.5)


def test_nothing_is_found_if_nothing_fits():
    found = search(*THREE_POSES, GRID, Brief(longest_bar=0.1))
    assert len(found) == 0
    assert found.left["longest_bar"] == 0
    assert len(refine(*THREE_POSES, found)) == 0


def test_progress_is_told():
    told = []
    search(*THREE_POSES, GRID, best="longest_bar", block=30, progress=lambda done, count: told.append((done, count)))
    assert told == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"best": "beauty"}, "expected one of shortest_bar"),
        ({"planes": (4,)}, "numbers of planes from 0 to 3"),
        ({"keep": 0}, "at least one linkage"),
        ({"block": 0}, "at least one point"),
        ({"z": [np.nan]}, "finite points"),
        ({"z": []}, "at least one point z"),
    ],
)
def test_wrong_wishes_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        search(*THREE_POSES, **{"z": GRID, **arguments})


def test_wrong_briefs_and_grids_are_named():
    for wrong in ({"room": -1}, {"travel": np.nan}, {"order": (0, 1)}, {"order": (1, 0, 2)}):
        with pytest.raises(ValueError, match="expected"):
            Brief(**wrong)
    with pytest.raises(ValueError, match="at least one column"):
        ZGrid(0, 1 + 1j, (0, 4))
    with pytest.raises(ValueError, match="three single poses"):
        search(*random_poses(3, seed=1, shape=(2,)), GRID)
