"""The motion of a closed chain from its axes, and from its Denavit–Hartenberg table: round trips, and what fails."""

from __future__ import annotations

from fractions import Fraction
from math import pi

import numpy as np
import pytest

from kinlib import (
    Chain,
    DegenerateError,
    DualQuaternion,
    Line,
    Linkage,
    as_float,
    axis_of,
    bennett_flip,
    bennett_linkage,
    eps,
    gallery,
    goldberg_linkages,
    i,
    j,
    k,
    same_point,
    six_r_linkages,
    translation,
)
from kinlib.testing import random_poses

THREE, FOUR = random_poses(3, seed=1), random_poses(4, seed=5)
LINKAGES = [bennett_linkage(*THREE), *goldberg_linkages(*THREE, 0.4 + 0.9j), *six_r_linkages(*FOUR)]
SHORT = [LINKAGES[n] for n in (0, 1, 3, 9)]
TURNS = [-1.9, -0.6, 0.0, 0.4, 2.7]


def assert_same_motion(found: Linkage, given: Linkage, *, rtol: float = 1e-7) -> None:
    """All links of both are moved alike when a joint that turns once has the same angle."""
    joint = given.joints.index(1)
    f, g = found.joint_factors(joint)[0].astype(float), given.joint_factors(joint)[0].astype(float)
    h = given.axes.astype(float)[..., joint]
    for u in TURNS:
        t, s = (
            q.scalar_part + u * (as_float(q.coeffs[..., 1:4]) * as_float(h.coeffs[..., 1:4])).sum(-1) for q in (f, g)
        )
        moved = [x.astype(float).link_displacements(y) for x, y in ((found, t), (given, s))]
        length = 1 + np.abs(moved[1].coeffs[..., 4:]).max()
        assert np.all(same_point(*moved, rtol=rtol, length=length))


@pytest.mark.parametrize("linkage", LINKAGES, ids=repr)
def test_the_axes_of_a_linkage_give_its_motion_back(linkage):
    found = Linkage.from_axes(linkage.axes)
    assert found.joints == linkage.joints
    assert found.closure_residual() < 1e-11
    assert_same_motion(found, linkage)


def test_exact_axes_give_exact_motions():
    for linkage in (bennett_linkage(*gallery.THREE_POSES), *goldberg_linkages(*gallery.THREE_POSES, (1, 2))[::3]):
        found = Linkage.from_axes(linkage.axes)
        assert found.joints == linkage.joints
        assert found.closure_residual() == 0
        assert all(isinstance(x, (int, Fraction)) for x in found.joint_factors(2)[0].coeffs)
        assert_same_motion(found, linkage)


@pytest.mark.parametrize("linkage", SHORT, ids=repr)
def test_lines_chains_and_sequences_are_axes(linkage):
    expected = Linkage.from_axes(linkage.axes)
    axes = [linkage.axes[n] for n in range(linkage.joint_count)]
    for given in (
        linkage.chain,
        axes,
        [Line.from_dual_quaternion(h) for h in axes],
        Line.from_dual_quaternion(linkage.axes),
    ):
        found = Linkage.from_axes(given)
        assert all(np.allclose(f.coeffs, g.coeffs) for f, g in zip(found.factors, expected.factors, strict=True))


@pytest.mark.parametrize("linkage", SHORT, ids=repr)
def test_the_first_joint_that_turns_once_gives_the_parameter(linkage):
    found = Linkage.from_axes(linkage.axes)
    joint = found.joints.index(1)
    assert np.allclose(found.joint_factors(joint)[0].coeffs, linkage.axes[joint].coeffs)


@pytest.mark.parametrize("length", [1e-6, 1e6])
@pytest.mark.parametrize("linkage", SHORT, ids=repr)
def test_the_unit_of_length_does_not_matter(linkage, length):
    coeffs = linkage.axes.coeffs * np.repeat([1.0, length], 4)
    found, expected = Linkage.from_axes(DualQuaternion(coeffs)), Linkage.from_axes(linkage.axes)
    for f, g in zip(found.factors, expected.factors, strict=True):
        assert np.allclose(f.coeffs / np.repeat([1.0, length], 4), g.coeffs, atol=1e-9)


@pytest.mark.parametrize("linkage", SHORT, ids=repr)
def test_the_frame_does_not_matter(linkage):
    expected = Linkage.from_axes(linkage.axes)
    for move in (*random_poses(1, seed=3), translation([1e6, -2e6, 5e5])):
        found = Linkage.from_axes(move * linkage.axes * move.conjugate())
        assert found.joints == expected.joints
        for f, g in zip(found.factors, expected.factors, strict=True):
            moved = move * g * move.conjugate()
            assert np.allclose(f.coeffs[:4], moved.coeffs[:4], atol=1e-6)


def test_orientation_of_axes_does_not_matter():
    given = LINKAGES[1]
    signs = np.array([1, -1, 1, -1, -1.0])
    found = Linkage.from_axes(DualQuaternion(given.axes.coeffs * signs[:, None]))
    assert found.joints == given.joints
    assert_same_motion(found, given)


def test_batches_row_by_row_with_nan_rows():
    batch = goldberg_linkages(*random_poses(3, seed=2, shape=(4,)), 0.4 + 0.9j)[0]
    coeffs = batch.axes.coeffs.copy()
    coeffs[2] = np.nan
    found = Linkage.from_axes(DualQuaternion(coeffs))
    assert found.shape == (4,)
    for n in range(4):
        if n == 2:
            assert all(np.isnan(f.coeffs[n]).all() for f in found.factors)
        else:
            single = Linkage.from_axes(batch.axes[n])
            assert all(np.allclose(f.coeffs[n], g.coeffs) for f, g in zip(found.factors, single.factors, strict=True))


def test_rows_that_do_not_move_are_named_or_nan():
    coeffs = np.stack([LINKAGES[0].axes.coeffs] * 3)
    coeffs[1, 3] = (j + eps * k + eps * i).coeffs.astype(float)
    with pytest.raises(DegenerateError, match=r"^row 1: the axes are independent: the chain is rigid$"):
        Linkage.from_axes(DualQuaternion(coeffs))
    found = Linkage.from_axes(DualQuaternion(coeffs), degenerate="nan")
    assert [bool(np.isnan(found.factors[0].coeffs[n]).any()) for n in range(3)] == [False, True, False]


def axes_at(*pairs) -> list[DualQuaternion]:
    return [Line.at(point, direction).as_dual_quaternion() for point, direction in pairs]


PARALLELOGRAM = axes_at(([0, 0, 0], [0, 0, 1]), ([2, 0, 0], [0, 0, 1]), ([3, 1, 0], [0, 0, 1]), ([1, 1, 0], [0, 0, 1]))
ANTIPARALLELOGRAM = axes_at(
    ([0, 0, 0], [0, 0, 1]),
    ([4, 0, 0], [0, 0, 1]),
    ([1, 3, 0], [0, 0, 1]),
    ([Fraction(21, 5), Fraction(3, 5), 0], [0, 0, 1]),
)
SPHERICAL_ANTIPARALLELOGRAM = [axis_of(f) for f in (i, 2 * j + k, *bennett_flip(i, 1 + 2 * j + k)[::-1])]
FOUR_BAR = axes_at(([0, 0, 0], [0, 0, 1]), ([4, 0, 0], [0, 0, 1]), ([5, 3, 0], [0, 0, 1]), ([0, 2, 0], [0, 0, 1]))
SPHERICAL = [i, j, k, i + 2 * j - 3 * k]


@pytest.mark.parametrize("kind", [lambda h: h, lambda h: h.astype(float)], ids=["exact", "floats"])
def test_a_parallelogram_moves(kind):
    found = Linkage.from_axes([kind(h) for h in PARALLELOGRAM])
    assert found.joints == (1, 1, 1, 1)
    assert found.degrees()[0, 2] == found.relative_motion(0, 2).degree == 2


@pytest.mark.parametrize("axes", [ANTIPARALLELOGRAM, SPHERICAL_ANTIPARALLELOGRAM], ids=["planar", "spherical"])
def test_an_antiparallelogram_moves_as_a_bennett_linkage(axes):
    exact, floats = Linkage.from_axes(axes), Linkage.from_axes([h.astype(float) for h in axes])
    assert exact.closure_residual() == 0
    assert floats.closure_residual() < 1e-12
    assert exact.joints == floats.joints == (1, 1, 1, 1)
    assert [bond.joints for bond in exact.bonds()] == [(0, 2), (1, 3)]
    assert_same_motion(floats, exact)


@pytest.mark.parametrize("axes", [FOUR_BAR, SPHERICAL], ids=["planar", "spherical"])
def test_a_general_four_bar_moves_but_not_rationally(axes):
    for given in (axes, [h.astype(float) for h in axes]):
        with pytest.raises(DegenerateError, match="is mobile, but its motion is not of this kind"):
            Linkage.from_axes(given)


def sarrus() -> list[DualQuaternion]:
    """Two groups of three parallel axes, in planes at a right angle: the last link goes up and down."""
    return axes_at(
        ([0, 0, 0], [0, 1, 0]), ([1, 0, 1], [0, 1, 0]), ([0, 0, 2], [0, 1, 0]),
        ([0, 0, 2], [1, 0, 0]), ([0, 1, 1], [1, 0, 0]), ([0, 0, 0], [1, 0, 0]),
    )  # fmt: skip


def test_sarruss_linkage_moves_in_another_way():
    with pytest.raises(DegenerateError, match="is mobile, but its motion is not of this kind"):
        Linkage.from_axes(sarrus())


def test_a_parallelogram_stretched_out_is_singular():
    axes = axes_at(*[([x, 0, 0], [0, 0, 1]) for x in (0, 2, 3, 1)])
    for given in (axes, [h.astype(float) for h in axes]):
        with pytest.raises(DegenerateError, match="the position is flat or singular"):
            Linkage.from_axes(given)


def goldberg_of_three_bennetts() -> Linkage:
    """A joint that turns three times, and one that its three factors are exchanged with."""
    a = i + eps * 0
    thrice = [a, 2 * a + 1, 3 * a - 1]
    b = 2 * j - 3 * eps * i + 1 + 1
    first, chain = [*thrice, b], [*thrice, b]
    for n in (2, 1, 0):
        chain[n : n + 2] = bennett_flip(*chain[n : n + 2])
    return Linkage.from_chains(first, chain, joints=(3, 1, 1, 1, 1, 1))


def test_goldbergs_6r_has_a_joint_that_turns_three_times():
    given = goldberg_of_three_bennetts()
    for linkage in (given, given.astype(float)):
        found = Linkage.from_axes(linkage.axes)
        assert found.joints == (3, 1, 1, 1, 1, 1)
        assert found.closure_residual() < 1e-12
        assert_same_motion(found, linkage)


def test_five_axes_through_a_point_have_more_than_one_freedom():
    with pytest.raises(DegenerateError, match="in more than one way"):
        Linkage.from_axes([i, j, k, i + j, j + k])


def test_four_axes_of_a_regulus_are_shaky():
    """The rulings of x y = z through the points (s, 0, 0)."""
    axes = axes_at(*[([s, 0, 0], [0, 1, s]) for s in (0, 1, 2, 5)])
    assert Chain(axes).mobility() == 1
    for given in (axes, [h.astype(float) for h in axes]):
        with pytest.raises(DegenerateError, match="mobile only infinitesimally"):
            Linkage.from_axes(given)


def test_a_joint_that_stands_still_is_named():
    bennett = LINKAGES[0]
    axes = [bennett.axes[n] for n in range(4)] + [(j + eps * k + 2 * eps * i).astype(float)]
    with pytest.raises(DegenerateError, match="a joint does not turn"):
        Linkage.from_axes(axes)


def test_three_and_seven_axes_are_refused():
    for count in (3, 7):
        with pytest.raises(ValueError, match="expected four, five or six axes"):
            Linkage.from_axes([i, j, k, i + j, i + k, j + k, i - j][:count])


def test_rounded_axes_need_a_tolerance():
    axes = DualQuaternion(LINKAGES[1].axes.coeffs.round(6))
    with pytest.raises((DegenerateError, ValueError)):
        Linkage.from_axes(Chain.wrap(axes))
    found = Linkage.from_axes(Chain.wrap(axes), rtol=1e-3)
    assert found.joints == LINKAGES[1].joints


def test_the_coupler_and_its_home():
    home = random_poses(1, seed=9)[0]
    found = Linkage.from_axes(LINKAGES[9].axes, coupler=2, home=home)
    assert found.coupler == 2
    assert same_point(found.coupler_motion(np.inf), home)


@pytest.mark.parametrize("linkage", [*LINKAGES[:9], *LINKAGES[9::3]], ids=repr)
def test_the_table_and_one_angle_give_the_motion_back(linkage):
    rows, joint = linkage.denavit_hartenberg(), linkage.joints.index(1)
    found = Linkage.from_denavit_hartenberg(rows, angle=linkage.chain.angles()[joint], joint=joint)
    assert found.closure_residual() < 1e-7
    for a, b in zip(rows, found.denavit_hartenberg(), strict=True):
        assert np.allclose([a.distance, abs(a.offset)], [b.distance, abs(b.offset)], atol=1e-6)
        assert (
            abs(np.sin(a.twist - b.twist)) < 1e-6 or abs(np.sin(a.twist + b.twist)) < 1e-6
        )  # axes may be turned round


def test_a_table_that_closes_nowhere_is_refused():
    with pytest.raises(ValueError, match="no position was found"):
        Linkage.from_denavit_hartenberg([(1, 0, 0), (1, 0, 0), (1, 0, 0), (9, 0, 0)], angle=1.0)


def test_tables_in_a_batch_have_each_its_own_fate():
    """As one by one; a table that closes nowhere, one that does not move and NaN rows do not spoil the others."""
    linkages = bennett_linkage(*random_poses(3, seed=3, shape=(5,)))
    table = np.stack([np.stack(row, axis=-1) for row in linkages.denavit_hartenberg()], axis=-2)
    angles = linkages.chain.angles()[..., 1]
    table[1] = np.nan
    table[2] = [(1, 0, 0), (1, 0, 0), (1, 0, 0), (9, 0, 0)]
    rows = [tuple(np.moveaxis(table[:, n], -1, 0)) for n in range(4)]
    with pytest.raises(ValueError, match=r"^row 2: no position was found"):
        Linkage.from_denavit_hartenberg(rows, angle=angles, joint=1)
    found = Linkage.from_denavit_hartenberg(rows, angle=angles, joint=1, degenerate="nan")
    assert found.shape == (5,)
    assert np.isnan(found.closure_residual()).tolist() == [False, True, True, False, False]
    for n in (0, 3, 4):
        alone = Linkage.from_denavit_hartenberg(table[n].tolist(), angle=angles[n], joint=1)
        for f, g in zip(found[n].factors, alone.factors, strict=True):
            assert np.allclose(f.coeffs, g.coeffs, atol=1e-9)
        assert np.allclose(found[n].chain.angles()[1], angles[n])
    none = Linkage.from_denavit_hartenberg([(row[0][:0], row[1][:0], row[2][:0]) for row in rows], angle=1.0)
    assert none.shape == (0,)
    one_table = Linkage.from_denavit_hartenberg(table[0].tolist(), angle=[1.0, 1.2], joint=1)
    assert np.allclose(one_table.chain.angles()[..., 1], [1.0, 1.2])


@pytest.mark.parametrize("rows", [[(1, 0)] * 4, 3, [(1, 0, 0, 0)] * 4])
def test_tables_of_other_shapes_are_refused(rows):
    with pytest.raises(ValueError, match="three numbers"):
        Linkage.from_denavit_hartenberg(rows, angle=1.0)


def test_the_angle_is_that_of_the_table():
    rows = [(1, pi / 6, 0), (2, pi / 2, 0), (1, pi / 6, 0), (2, pi / 2, 0)]
    angles = Linkage.from_denavit_hartenberg(rows, angle=1.0).chain.angles()
    assert np.allclose(angles[0], 1.0)


def test_exact_batches_stay_exact_and_name_their_rows():
    good, other = gallery.BENNETT_OF_HEGEDUS, gallery.PARALLELOGRAM
    found = Linkage.from_axes(DualQuaternion(np.array([[h.coeffs for h in good], [h.coeffs for h in other]])))
    assert found.shape == (2,)
    assert found.closure_residual().tolist() == [0, 0]
    rigid = [*good[:3], j + eps * k + 0 * i]
    batch = DualQuaternion(np.array([[h.coeffs for h in good], [h.coeffs for h in rigid]]))
    with pytest.raises(DegenerateError, match=r"^row 1: the axes are independent"):
        Linkage.from_axes(batch)
    kept = Linkage.from_axes(batch, degenerate="nan")
    assert np.isnan(kept.factors[0].coeffs).any(axis=-1).tolist() == [False, True]


@pytest.mark.parametrize("wrong", [{"joint": 4}, {"joint": -1}, {"angle": np.nan}])
def test_a_table_needs_a_joint_and_an_angle(wrong):
    rows = [(1, pi / 6, 0), (2, pi / 2, 0)] * 2
    with pytest.raises(ValueError, match=r"^expected"):
        Linkage.from_denavit_hartenberg(rows, **{"angle": 1.0, **wrong})
