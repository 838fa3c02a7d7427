"""Closed chains of axes: the table rebuilds the chain, whatever its shape, numbers, place and size."""

from __future__ import annotations

import copy
import math
import pickle
from fractions import Fraction
from functools import reduce

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from kinlib import Chain, DHRow, DualQuaternion, Line, act, bennett_flip, eps, i, j, k, one, translation
from problems import random_displacement

SHAPES = [(), (1,), (3, 1, 2)]
NAN_ROWS = pytest.mark.filterwarnings("error")


def line(direction, point) -> DualQuaternion:
    """The half-turn about a line, of no particular length."""
    return Line.at(point, direction).as_dual_quaternion()


def moved(chain: Chain, pose: DualQuaternion) -> Chain:
    return Chain(pose * chain.axes * pose.inverse())


def random_axes(count: int, *, seed: int, shape=(), length: float = 1.0) -> DualQuaternion:
    random = np.random.default_rng(seed)
    directions, points = random.normal(size=(2, *shape, count, 3))
    return Line.at(length * points, directions).as_dual_quaternion()


def whole_axes(count: int, *, seed: int) -> DualQuaternion:
    """Exact axes, most of them not of length 1."""
    random = np.random.default_rng(seed)
    directions = random.integers(-3, 4, size=(count, 3))
    directions[~directions.any(axis=-1)] = [1, 2, 2]
    points = random.integers(-4, 5, size=(count, 3))
    return DualQuaternion.stack(
        [line([int(x) for x in l], [Fraction(int(x), 3) for x in a]) for l, a in zip(directions, points, strict=True)]
    )


CHAINS = {
    **{f"{count} axes": random_axes(count, seed=count) for count in (3, 4, 5, 6, 7)},
    **{f"exact, {seed}": whole_axes(5, seed=seed) for seed in range(4)},
    "two parallel": DualQuaternion.stack([k, k + eps * i, j - eps * i, i + 2 * eps * k, i + j]),
    "first and last parallel": DualQuaternion.stack([k, j - eps * i, i + 2 * eps * k, k * 3 + eps * i]),
    "antiparallel": DualQuaternion.stack([2 * k, -k - eps * j, j - eps * i, i + 2 * eps * k]),
    "two pairs": DualQuaternion.stack([k, k + eps * i, i + eps * j, i + 2 * eps * k, j + eps * k]),
    "planar": DualQuaternion.stack([k, k + eps * i, 2 * k + 3 * eps * (i + j), -k + eps * (2 * i - j)]),
    "one axis twice": DualQuaternion.stack([k, k, j - eps * i, i + 2 * eps * k]),
    "one axis back and forth": DualQuaternion.stack([k, -2 * k, j - eps * i, i + 2 * eps * k]),
    "one axis throughout": DualQuaternion.stack([j + eps * i] * 4),
    "spherical": DualQuaternion.stack([i, j, i + j + k, 2 * i - k]),
    "in a plane": DualQuaternion.stack([i, j + eps * k, i + j - eps * k, i - 2 * j + 3 * eps * k]),
    "meeting one by one": DualQuaternion.stack([i, k, i + eps * j, j + eps * i, j + k + eps * (i + j - k)]),
}
NAMES = list(CHAINS)


def dh_step(angle: float, row: DHRow) -> RigidTransform:
    """SciPy's turn about z and shift along z, then shift along x and turn about x."""
    z = RigidTransform.from_components([0, 0, row.offset], Rotation.from_rotvec([0, 0, angle]))
    x = RigidTransform.from_components([row.distance, 0, 0], Rotation.from_rotvec([row.twist, 0, 0]))
    return z * x


def plucker(axes: DualQuaternion) -> np.ndarray:
    """Unit direction and moment of each axis in floats, shape (..., n, 6)."""
    coeffs = axes.coeffs[..., [1, 2, 3, 5, 6, 7]].astype(float)
    return coeffs / np.linalg.norm(coeffs[..., :3], axis=-1, keepdims=True)


def size_of(axes: DualQuaternion) -> float:
    """The distance of the farthest axis from the origin, at least 1."""
    return max(1.0, np.linalg.norm(plucker(axes)[..., 3:], axis=-1).max())


def assert_rebuilds(chain: Chain, atol: float) -> None:
    """The steps of the table close, and carry the axis of z through all axes of the chain."""
    steps = [dh_step(angle, row) for angle, row in zip(chain.angles(), chain.denavit_hartenberg(), strict=True)]
    assert np.allclose(reduce(lambda x, y: x * y, steps).as_matrix(), np.eye(4), atol=atol)
    frame, rebuilt = RigidTransform.identity(), []
    for step in steps:
        direction = frame.rotation.apply([0, 0, 1])
        rebuilt.append([*direction, *np.cross(frame.translation, direction)])
        frame = frame * step
    assert np.allclose(products(np.array(rebuilt)), products(plucker(chain.axes)), atol=atol * size_of(chain.axes))


def products(lines: np.ndarray) -> np.ndarray:
    """Both forms of each two lines, which displacements leave as they are."""
    l, m = lines[..., :3], lines[..., 3:]
    mixed = l @ np.swapaxes(m, -1, -2)
    return np.stack([l @ np.swapaxes(l, -1, -2), mixed + np.swapaxes(mixed, -1, -2)])


# --- the table -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_table_rebuilds_the_chain(name):
    assert_rebuilds(Chain(CHAINS[name]), 1e-12)
    assert_rebuilds(Chain(CHAINS[name].astype(float)), 1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_exact_and_float_chains_have_one_table(name):
    exact, floats = Chain(CHAINS[name]), Chain(CHAINS[name].astype(float))
    assert np.allclose(exact.denavit_hartenberg(), floats.denavit_hartenberg(), atol=1e-12)
    assert np.allclose(exact.angles(), floats.angles(), atol=1e-12)
    assert exact.mobility() == floats.mobility()
    assert np.allclose(exact.bars(), floats.bars(), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_length_of_a_half_turn_is_nothing_of_its_axis(name):
    scales = np.array([2, 3, Fraction(1, 7), 5, 1, 2, 3], dtype=object)[: CHAINS[name].shape[-1]]
    chain, other = Chain(CHAINS[name]), Chain(CHAINS[name] * scales)
    assert np.allclose(chain.denavit_hartenberg(), other.denavit_hartenberg(), atol=1e-12)
    assert chain.mobility() == other.mobility()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", NAMES)
def test_the_table_goes_with_the_frame(name, seed):
    """Signs are free only where a distance is zero; else table and angles are the same from everywhere."""
    chain = Chain(CHAINS[name].astype(float))
    other = moved(chain, random_displacement(seed=seed))
    assert_rebuilds(other, 1e-11)
    rows, others = chain.denavit_hartenberg(), other.denavit_hartenberg()
    assert np.allclose([row.distance for row in rows], [row.distance for row in others], atol=1e-11)
    assert np.allclose([abs(row.twist) for row in rows], [abs(row.twist) for row in others], atol=1e-11)
    assert np.allclose([row.offset for row in rows], [row.offset for row in others], atol=1e-10)
    assert chain.mobility() == other.mobility()


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("away", [0.0, 1e3, 1e6])
@pytest.mark.parametrize("seed", range(3))
def test_digits_are_lost_only_as_the_distance_from_the_origin(seed, away, length):
    near = Chain(random_axes(5, seed=seed, length=length))
    far = moved(near, translation(length * away * np.array([1.0, -0.7, 0.4])))
    rows, others = np.array(near.denavit_hartenberg()), np.array(far.denavit_hartenberg())
    error = 1e-14 * (away + 10)
    unit = np.array([length, 1, length])
    assert np.abs((rows - others) / unit).max() < 1e3 * error
    assert near.mobility() == far.mobility() == 0
    shift = length * away * np.array([1.0, -0.7, 0.4])
    assert np.abs(far.bars() - shift - near.bars()).max() < 1e3 * error * length


@pytest.mark.parametrize("angle", [10.0**-n for n in range(1, 17)])
def test_nearly_parallel_neighbours(angle):
    """Half of the digits are lost at worst: at 1e-8, where the feet stop being determined."""
    tilted = line([math.sin(angle), 0, math.cos(angle)], [0.3, 1.0, 0.2])
    chain = Chain([k, tilted, j - eps * i, i + 2 * eps * k])
    assert_rebuilds(chain, 1e-6)
    assert math.isclose(chain.denavit_hartenberg()[0].distance, 1.0, rel_tol=1e-6) or angle <= 1e-8
    assert abs(abs(chain.denavit_hartenberg()[0].twist) - angle) < 1e-7


def test_parallel_neighbours_take_the_perpendicular_through_the_foot_before():
    chain = Chain([k, k + eps * i, j - 3 * eps * i, i])
    first, second, *_ = chain.denavit_hartenberg()
    assert first == (1.0, 0.0, 0.0)
    assert np.isclose(second.offset, 3.0)


def test_intersecting_axes_have_distance_zero_and_no_undefined_twist():
    first = Chain([i, j, k + eps * i, i + j]).denavit_hartenberg()[0]
    assert first.distance == 0
    assert np.isclose(first.twist, math.pi / 2)


def test_rows_of_one_chain_are_plain_numbers():
    assert {type(x) for row in Chain(CHAINS["5 axes"]).denavit_hartenberg() for x in row} == {float}
    assert repr(Chain(CHAINS["planar"]).denavit_hartenberg()[0]) == "DHRow(distance=1.0, twist=0.0, offset=0.0)"


# --- from a table --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_a_table_with_its_angles_gives_the_chain(name):
    chain = Chain(CHAINS[name])
    again = Chain.from_denavit_hartenberg(chain.denavit_hartenberg(), chain.angles())
    assert np.allclose(products(plucker(again.axes)), products(plucker(chain.axes)), atol=1e-10)
    assert np.isclose(np.abs(again.axes.coeffs[0]), [0, 0, 0, 1, 0, 0, 0, 0]).all()
    assert again.mobility() == chain.mobility()
    assert_rebuilds(again, 1e-11)


@pytest.mark.parametrize("shape", SHAPES)
def test_tables_in_batches(shape):
    chain = Chain(random_axes(5, seed=1, shape=shape))
    again = Chain.from_denavit_hartenberg(chain.denavit_hartenberg(), chain.angles())
    assert again.shape == shape
    assert np.allclose(products(plucker(again.axes)), products(plucker(chain.axes)), atol=1e-10)


def test_a_table_that_does_not_close_says_by_how_much():
    chain = Chain(CHAINS["5 axes"])
    rows, angles = chain.denavit_hartenberg(), chain.angles()
    with pytest.raises(ValueError, match=r"turned by 0\.1 and shifted by"):
        Chain.from_denavit_hartenberg(rows, angles + np.array([0.1, 0, 0, 0, 0]))
    longer = [rows[0]._replace(offset=rows[0].offset + 0.2), *rows[1:]]
    with pytest.raises(ValueError, match=r"turned by .*e-1. and shifted by 0\.2"):
        Chain.from_denavit_hartenberg(longer, angles)
    with pytest.raises(ValueError, match="4 angles and 5 rows"):
        Chain.from_denavit_hartenberg(rows, angles[:4])
    for wrong in (None, 5, [1, 2, 3], [(1, 2)] * 5, [("a", 0, 0)] * 5):
        with pytest.raises(TypeError, match="three numbers"):
            Chain.from_denavit_hartenberg(wrong, angles)


def test_rows_of_a_batch_that_do_not_close_are_named_or_nan():
    chain = Chain(random_axes(4, seed=1, shape=(3,)))
    angles = chain.angles() + np.array([[0, 0, 0, 0], [0, 0.3, 0, 0], [0, 0, 0, 0]])
    with pytest.raises(ValueError, match=r"row 1: the loop does not close: its end is turned by 0\.3"):
        Chain.from_denavit_hartenberg(chain.denavit_hartenberg(), angles)
    kept = Chain.from_denavit_hartenberg(chain.denavit_hartenberg(), angles, degenerate="nan")
    assert np.isnan(kept.axes.coeffs).all((-1, -2)).tolist() == [False, True, False]
    with pytest.raises(ValueError, match="'raise' or 'nan'"):
        Chain.from_denavit_hartenberg(chain.denavit_hartenberg(), angles, degenerate="no")


def bennett_table() -> tuple[list[DHRow], np.ndarray]:
    """The table of a Bennett linkage that somebody wrote down to six decimals."""
    h1, h2 = 3 * i + eps * k, 2 * j - 2 * eps * i
    k1, k2 = bennett_flip(h1, h2)
    chain = Chain([h1, h2, -k2, -k1])
    rows = [DHRow(*np.round(row, 6)) for row in chain.denavit_hartenberg()]
    return rows, np.round(chain.angles(), 6)


def test_a_table_with_six_decimals_needs_a_tolerance():
    rows, angles = bennett_table()
    with pytest.raises(ValueError, match="rtol="):
        Chain.from_denavit_hartenberg(rows, angles)
    chain = Chain.from_denavit_hartenberg(rows, angles, rtol=1e-5)
    assert chain.mobility() == 0
    assert chain.mobility(rtol=1e-5) == 1


# --- mobility ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axes", "mobility"),
    [
        ([i, j, k, i + j + k, 2 * i - j], 2),  # through one point: rank three
        ([k, k + eps * i, k + eps * j, k + eps * (i + j)], 1),  # parallel: rank three
        ([i, j + eps * k, i + j - eps * k, i - 2 * j], 1),  # in a plane: rank three
        ([i, j - eps * i, k + eps * j, i + j + k + eps * (i - k)], 0),  # four skew lines: rank four
        ([i, i, i, i], 3),
    ],
)
def test_mobility_of_axes_in_special_position(axes, mobility):
    """Exact, in floats, anywhere, of any size."""
    chain = Chain(axes)
    assert chain.mobility() == mobility
    for length in (1e-6, 1.0, 1e6):
        stretched = DualQuaternion(chain.axes.coeffs.astype(float) * ([1.0] * 4 + [length] * 4))
        pose = translation([1e4 * length, 0.3 * length, -2e3 * length]) * random_displacement(seed=1).primal
        assert moved(Chain(stretched), pose).mobility() == mobility


def test_a_mobility_is_a_whole_number():
    assert type(Chain(CHAINS["planar"]).mobility()) is int
    assert Chain(random_axes(5, seed=1, shape=(2,))).mobility().dtype == int


# --- bars ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_bars_end_on_their_axes(name):
    chain = Chain(CHAINS[name])
    bars, lines = chain.bars(), plucker(chain.axes)
    assert bars.shape == (chain.joint_count, 2, 3)
    for link, (start, end) in enumerate(bars):
        for point, axis in ((start, lines[link - 1]), (end, lines[link])):
            assert np.allclose(np.cross(point, axis[:3]), axis[3:], atol=1e-10)


@pytest.mark.parametrize("name", ["3 axes", "4 axes", "5 axes", "planar", "exact, 1"])
def test_a_bar_is_as_long_as_the_table_says(name):
    chain = Chain(CHAINS[name])
    lengths = np.linalg.norm(np.diff(chain.bars(), axis=1)[:, 0], axis=-1)
    distances = np.roll([row.distance for row in chain.denavit_hartenberg()], 1)
    assert np.allclose(lengths, distances) or np.all(lengths > distances)  # straight, where feet run away


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", NAMES)
def test_bars_move_with_the_chain(name, seed):
    chain, pose, near = Chain(CHAINS[name].astype(float)), random_displacement(seed=seed), [0.2, -1.0, 3.0]
    assert np.allclose(moved(chain, pose).bars(near=act(pose, near)), act(pose, chain.bars(near=near)), atol=1e-8)


def test_where_all_axes_meet_the_bars_lie_on_a_sphere():
    chain = moved(Chain(CHAINS["spherical"]), translation([1, 2, 3]))
    for near, radius in ((None, 1.0), ([1.2, 2, 3], 0.2), ([1, 2, 8], 5.0)):
        ends = chain.bars(near=near).reshape(-1, 3) - [1, 2, 3]
        assert np.allclose(np.linalg.norm(ends, axis=-1), radius)


def test_where_all_axes_are_parallel_the_bars_lie_in_the_plane_of_a_point():
    assert np.allclose(Chain(CHAINS["planar"]).bars(near=[3, 1, 7])[..., 2], 7)


# --- shapes and input ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_a_batch_is_the_chain_of_its_rows(shape):
    chain = Chain(random_axes(5, seed=2, shape=shape))
    assert (chain.shape, chain.joint_count) == (shape, 5)
    for index in np.ndindex(shape):
        single = Chain(chain.axes[(*index, slice(None))])
        assert np.allclose([[part[index] for part in row] for row in map(_arrays, chain.denavit_hartenberg())],
                           single.denavit_hartenberg())  # fmt: skip
        assert np.allclose(chain.angles()[index], single.angles())
        assert np.allclose(chain.bars()[index], single.bars())
        assert np.asarray(chain.mobility())[index] == single.mobility()
        if shape:
            assert chain[index].axes.shape == (5,)
            assert np.allclose(chain[index].axes.coeffs, single.axes.coeffs)


def _arrays(row) -> list[np.ndarray]:
    return [np.asarray(part) for part in row]


@pytest.mark.parametrize("name", NAMES)
def test_a_row_of_nan_stays_a_row(name):
    axes = CHAINS[name].astype(float)
    coeffs = np.stack([axes.coeffs, axes.coeffs * np.nan, axes.coeffs])
    chain, single = Chain(DualQuaternion(coeffs)), Chain(axes)
    for row, other in zip(chain.denavit_hartenberg(), single.denavit_hartenberg(), strict=True):
        for part, expected in zip(row, other, strict=True):
            assert np.allclose(part, [expected, np.nan, expected], equal_nan=True)
    for values, expected in ((chain.angles(), single.angles()), (chain.bars(), single.bars())):
        assert np.isnan(values[1]).all()
        assert np.allclose(values[[0, 2]], expected)
    assert np.array_equal(chain.mobility(), [single.mobility(), np.nan, single.mobility()], equal_nan=True)
    assert math.isnan(chain[1].mobility())
    assert len([entry for entry in chain if np.isnan(entry.axes.coeffs).any()]) == 1


def test_one_axis_of_nan_makes_its_whole_row_undefined():
    coeffs = np.array(random_axes(4, seed=1, shape=(2,)).coeffs)
    coeffs[1, 2] = np.nan
    chain = Chain(DualQuaternion(coeffs))
    assert np.isnan(chain.mobility()).tolist() == [False, True]
    assert np.isnan([row.distance for row in chain.denavit_hartenberg()]).tolist() == [[False, True]] * 4


def test_a_batch_has_a_length_and_a_single_chain_has_not():
    chain, batch = Chain([i, j, k]), Chain(random_axes(4, seed=1, shape=(3, 2)))
    assert (len(batch), batch[1].shape, batch[1, 0].shape, batch[..., 0].shape) == (3, (2,), (), (3,))
    assert [entry.shape for entry in batch] == [(2,)] * 3
    assert batch[:2].joint_count == 4
    for ask in (len, list, lambda c: c[0]):
        with pytest.raises(TypeError, match="a single chain"):
            ask(chain)
    with pytest.raises(IndexError):
        batch[0, 0, 0]


def test_axes_may_be_lines():
    lines = [Line.at([0, 0, 0], [1, 0, 0]), Line.at([0, 0, 1], [0, 1, 0]), Line.at([1, 0, 0], [0, 0, 1])]
    assert np.all(Chain(lines).axes == Chain([line.as_dual_quaternion() for line in lines]).axes)
    together = Line(np.stack([x.direction for x in lines]), np.stack([x.moment for x in lines]))
    assert np.all(Chain(together).axes == Chain(lines).axes)


@pytest.mark.parametrize(
    ("axes", "error", "words"),
    [
        ([1, 2, 3], TypeError, "DualQuaternion or Line, got int"),
        (None, TypeError, "got NoneType"),
        ([], TypeError, "got nothing"),
        ([i, "j", k], TypeError, "got DualQuaternion, str"),
        (i, ValueError, "at least three axes"),
        ([i, j], ValueError, "at least three axes"),
        ([i, j, 1 + k], ValueError, r"half-turns .* at \(2,\) there is something else"),
        ([i, j + eps * j, k], ValueError, r"at \(1,\) there is something else"),
        ([i, j + eps, k], ValueError, r"at \(1,\) there is something else"),
        ([i, j, k * 1j], ValueError, "real axes"),
        ([i, j, one * 0], ValueError, "no axis"),
    ],
)
def test_what_is_no_chain_gets_words(axes, error, words):
    with pytest.raises(error, match=words):
        Chain(axes)


def test_a_chain_can_be_kept():
    chain = Chain(CHAINS["5 axes"])
    chain.bars()
    for other in (pickle.loads(pickle.dumps(chain)), copy.deepcopy(chain)):
        assert np.array_equal(other.axes.coeffs, chain.axes.coeffs)
        assert other.denavit_hartenberg() == chain.denavit_hartenberg()
    assert {chain: 1}[chain] == 1
    with pytest.raises(AttributeError):
        chain.axes = one


def test_a_chain_is_shown_in_a_line():
    assert repr(Chain([i, j, k])) == "Chain of 3 joints"
    assert repr(Chain(random_axes(4, seed=1, shape=(2, 3)))) == "Chain of 4 joints, shape (2, 3)"


def test_a_chain_is_shown_as_a_table():
    chain = Chain(CHAINS["planar"])
    assert "<td>1</td><td>26.5651°</td><td>0</td><td>1</td><td>0°</td>" in chain._repr_html_()
    assert chain._repr_html_().count("<tr>") == 5
    assert r"1 & 26.5651^\circ & 0 & 1 & 0^\circ \\" in chain._repr_latex_()
    batch = Chain(random_axes(4, seed=1, shape=(2, 3)))
    assert batch._repr_html_() == "<p>Chain of 4 joints, shape (2, 3)</p>"
    assert batch._repr_latex_() is None


def test_bars_are_not_for_changing():
    with pytest.raises(ValueError, match="read-only"):
        Chain(CHAINS["planar"]).bars()[0] = 0
