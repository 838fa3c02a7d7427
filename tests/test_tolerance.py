"""What errors of the poses do to a linkage: as finite differences say, and as one error after the other says."""

import numpy as np
import pytest

from kinlib import Spread, ZGrid, as_rigid_transform, goldberg_linkages, search, spread_under_errors
from kinlib.gallery import THREE_POSES
from kinlib.measures import bar_lengths
from kinlib.testing import random_poses
from kinlib.tolerance import _errors
from laws import COVERED

COVERED.update(("Spread", "spread_under_errors"))

GRID = ZGrid(-2 - 2j, 2 + 2.5j, (9, 8))
FOUND = search(*THREE_POSES, GRID, best="longest_bar", keep=4)


def test_errors_have_the_full_size():
    errors = as_rigid_transform(_errors(np.random.default_rng(3), 50, 0.2, 0.01))
    np.testing.assert_allclose(errors.rotation.magnitude(), 0.01)
    np.testing.assert_allclose(np.linalg.norm(errors.translation, axis=-1), 0.2)
    assert np.linalg.norm(errors.translation.mean(axis=0)) < 0.1


def test_without_errors_nothing_changes():
    spread = spread_under_errors(*THREE_POSES, FOUND, shift=0, turn=0, samples=2)
    assert np.max(spread[:3]) < 1e-9
    np.testing.assert_allclose(spread.clearance, FOUND.measures["clearance"], atol=1e-9)
    assert not spread.lost.any()


def test_small_errors_do_what_is_proportional_to_them():
    """As long as they are small, and apart from the clearance."""
    one, half = (spread_under_errors(*THREE_POSES, FOUND, shift=size, turn=size, samples=20) for size in (2e-6, 1e-6))
    assert isinstance(one, Spread)
    assert np.all(one.bar > 1e-7)
    np.testing.assert_allclose(np.array(one[:3]) / 2, half[:3], rtol=1e-3, atol=1e-11)


def test_the_spread_is_that_of_one_error_after_the_other():
    poses, random = random_poses(3, seed=4), np.random.default_rng(5)
    found = search(*poses, GRID, best="longest_bar", keep=3)
    errors = [_errors(random, 10, 1e-3, 2e-3) for _ in range(3)]
    spread = spread_under_errors(*poses, found, shift=1e-3, turn=2e-3, samples=10, seed=5)
    for n, linkage in enumerate(found.linkages):
        bars, clearance = [], []
        for m in range(10):
            moved = [pose * error[m] for pose, error in zip(poses, errors, strict=True)]
            wrong = goldberg_linkages(*moved, complex(found.z[n]))[2 * found.planes[n] + found.partners[n]]
            bars.append(np.abs(bar_lengths(wrong) - bar_lengths(linkage)).max())
            clearance.append(wrong.clearance())
        assert spread.bar[n] == pytest.approx(max(bars), rel=1e-6)
        assert spread.clearance[n] == pytest.approx(min(clearance), rel=1e-6, abs=1e-12)


def test_a_linkage_is_followed_where_the_dyads_change_places():
    """The quadratic factors of these poses have one real part, so that errors decide which dyad is the first."""
    errors = [_errors(np.random.default_rng(n), 10, 1e-6, 1e-6) for n in range(3)]
    poses = [pose.astype(float) * error for pose, error in zip(THREE_POSES, errors, strict=True)]
    number, linkage = 2 * FOUND.planes[0] + FOUND.partners[0], FOUND.linkages[0]
    wrong = goldberg_linkages(*poses, complex(FOUND.z[0]))[number]
    jumps = np.abs(bar_lengths(wrong) - bar_lengths(linkage)).max(axis=-1)
    assert 0 < np.count_nonzero(jumps > 1e-2) < 10
    assert spread_under_errors(*THREE_POSES, FOUND, shift=1e-6, turn=1e-6).bar.max() < 1e-4


def test_nothing_chosen_has_no_spread():
    nothing = search(*THREE_POSES, [0.5], best="longest_bar")
    assert len(nothing) == 0
    assert spread_under_errors(*THREE_POSES, nothing, shift=1, turn=1).bar.shape == (0,)


@pytest.mark.parametrize("wrong", [{"shift": -1}, {"turn": np.nan}, {"shift": np.inf}, {"samples": 0}])
def test_errors_that_are_none_are_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        spread_under_errors(*THREE_POSES, FOUND, **{"shift": 0.1, "turn": 0.1, **wrong})
