"""Drawings: on the axes that were given, in equal units, without titles, and true."""

import matplotlib as mpl

mpl.use("agg")

import re
from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import kinlib as kl
from kinlib.gallery import THREE_POSES
from kinlib.pictures import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    Ball,
    draw_bonds,
    draw_curve,
    draw_frames,
    draw_hyperboloid,
    draw_joint_angles,
    draw_line,
    draw_linkage,
    draw_linkages,
    draw_path,
    draw_positions,
    on_hyperboloid,
    plane_axes,
    space_axes,
    write_picture,
)
from kinlib.pictures import draw as still
from kinlib.pictures.colours import LIME, RASPBERRY, VIOLET


@pytest.fixture(scope="module")
def linkages():
    return kl.goldberg_linkages(*THREE_POSES, (1, 2))


@pytest.fixture(scope="module")
def lost():
    """Two Bennett linkages, of which the second does not exist: its poses are those of one rotation."""
    rows = zip(THREE_POSES, (kl.one, kl.i, kl.one + kl.i), strict=True)
    poses = [kl.DualQuaternion.stack([pose.astype(float) for pose in row]) for row in rows]
    return kl.bennett_linkage(*poses, degenerate="nan")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


@pytest.fixture
def ax():
    return space_axes()[0, 0]


def limits(ax) -> np.ndarray:
    return np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])


def contains(ax, points) -> bool:
    low, high = limits(ax).T
    return bool(np.all((low <= points) & (points <= high)))


DRAWINGS = {
    "linkage": lambda linkage, ax: draw_linkage(linkage, 0.5, ax),
    "frames": lambda linkage, ax: draw_frames(THREE_POSES, ax, names=["a", "b", "c"]),
    "curve": lambda linkage, ax: draw_curve([[0, 0, 0], [1, 2, 3]], ax),
    "path": draw_path,
    "hyperboloid": lambda linkage, ax: draw_hyperboloid(ax),
    "line": lambda linkage, ax: draw_line(kl.Line.through([0, 0, 1], [1, 1, 1]), ax),
    "positions": lambda linkage, ax: draw_positions(linkage, THREE_POSES, ax),
}


@pytest.mark.parametrize("name", DRAWINGS)
def test_drawings_return_their_axes_in_equal_units(linkages, ax, name):
    assert DRAWINGS[name](linkages[0], ax) is ax
    assert ax.get_title() == ""
    units = np.ptp(limits(ax), axis=1) / ax._box_aspect  # which matplotlib does not tell otherwise
    np.testing.assert_allclose(units, units[0])


@pytest.mark.parametrize("t", [np.inf, -2.0, 0, 1])
def test_a_linkage_is_drawn_where_its_axes_are(monkeypatch, linkages, ax, t):
    """At every axis, as the linkage itself has it at t, two rods lie on it at least: the sleeves of the joint."""
    drawn = []
    monkeypatch.setattr(still, "_draw_parts", lambda parts, ax, opacity: drawn.extend(parts))
    for linkage in linkages:
        drawn.clear()
        draw_linkage(linkage, t, ax)
        axes = kl.Line.from_dual_quaternion(linkage.configuration(t))
        for direction, moment in zip(as_floats(axes.direction), as_floats(axes.moment), strict=True):
            line = kl.Line(direction, moment)
            rods = [part for part in drawn if not isinstance(part, Ball)]
            on_it = [rod for rod in rods if all(line.contains(point, rtol=1e-7) for point in rod.points())]
            assert len({rod.body for rod in on_it}) >= 2


def test_bars_are_computed_once(monkeypatch, linkages, ax):
    """However many positions are drawn."""
    asked = []
    compute = kl.Chain._bars_near
    monkeypatch.setattr(kl.Chain, "_bars_near", lambda chain, near: asked.append(chain) or compute(chain, near))
    draw_positions(linkages[0], THREE_POSES, ax)
    assert len(asked) == 1


@pytest.mark.parametrize("draw", [lambda linkage, ax: draw_linkage(linkage, 0.5, ax), draw_path])
def test_what_is_not_one_linkage_is_named(ax, lost, draw):
    with pytest.raises(ValueError, match=r"batch of shape \(2,\).*pick one"):
        draw(lost, ax)
    assert draw(lost[0], ax) is ax
    with pytest.raises(ValueError, match="degenerate row of a batch"):
        draw(lost[1], ax)


def test_the_linkage_that_cannot_be_drawn_is_counted(lost):
    with pytest.raises(ValueError, match="linkage 2 of those given"):
        draw_linkages([lost[0], lost[1]], [])


def as_floats(values) -> np.ndarray:
    return np.asarray(values, dtype=float)


def test_nothing_is_cut_off(linkages, ax):
    draw_frames(THREE_POSES, ax, size=0.5)
    draw_path(linkages[0], ax)
    draw_linkage(linkages[0], np.inf, ax)
    origins = as_floats(kl.as_matrix(kl.DualQuaternion.stack(THREE_POSES)))[:, :3, 3]
    assert contains(ax, origins)
    draw_curve(np.array([[0.0, 0, 0], [30, 0, 0]]), ax)
    assert contains(ax, np.array([[30.0, 0, 0]]))
    assert contains(ax, origins)


def test_a_path_passes_through_the_poses(linkages, ax):
    draw_path(linkages[3], ax, point=(0, 0, 0))
    path = np.transpose(ax.lines[0].get_data_3d())
    origins = as_floats(kl.as_matrix(kl.DualQuaternion.stack(THREE_POSES)))[:, :3, 3]
    gaps = np.linalg.norm(path[:, None] - origins, axis=2).min(axis=0)
    assert gaps.max() < 0.05 * np.ptp(path)
    np.testing.assert_allclose(path[0], path[-1])


def test_a_line_is_drawn_where_it_is(ax):
    line = kl.Line.through([0, 0, 1], [1, 1, 1])
    draw_line(line, ax, centre=(5, 5, 0), length=3)
    ends = np.transpose(ax.lines[0].get_data_3d())
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(3)
    np.testing.assert_allclose(ends.mean(axis=0), [5, 5, 1])


def test_a_line_is_drawn_in_the_colour_asked_for(ax):
    draw_line(kl.Line([0, 0, 1], [0, 0, 0]), ax, colour="#0072b2", width=3)
    assert (ax.lines[0].get_color(), ax.lines[0].get_linewidth()) == ("#0072b2", 3)


def test_every_dyad_has_one_picture():
    """The coordinates of its poses, as the docstring combines them."""
    rng = np.random.default_rng(4)
    a1, l1, a2, l2 = rng.normal(size=(4, 3))
    h1, h2 = (kl.half_turn(kl.Line.at(a, l / np.linalg.norm(l))) for a, l in ((a1, l1), (a2, l2)))
    alpha, beta = rng.uniform(0.1, 3, size=(2, 50))
    x0, x1, x2, x3 = kl.Dyad(h1, h2).coordinates(kl.Dyad(h1, h2)(1 / np.tan(alpha), 1 / np.tan(beta)))
    expected = np.stack([x1 + x2, x0 - x3, x1 - x2], axis=-1) / (x0 + x3)[:, None]
    np.testing.assert_allclose(on_hyperboloid(alpha, beta), expected, rtol=1e-9)


def test_rulings_lie_on_the_hyperboloid_and_the_first_pass_through_the_identity(ax):
    draw_hyperboloid(ax, rulings=5)
    lines = [np.transpose(line.get_data_3d()) for line in ax.lines]
    assert len(lines) == 10
    for first, second in lines:
        for x in (first, second, (first + second) / 2):
            np.testing.assert_allclose(x @ np.diag([1, 1, -1]) @ x, 1)
    for first, second in lines[:2]:
        assert np.linalg.norm(np.cross(second - first, on_hyperboloid(0, 0) - first)) == pytest.approx(0)


def test_joint_angles_over_one_turn(linkages):
    linkage = linkages[0]
    _, ax = plt.subplots()
    assert draw_joint_angles(linkage, ax) is ax
    assert len(ax.lines) == linkage.joint_count
    whole_turns = {tuple(np.round(line.get_ydata()[[0, -1]] / 360).astype(int)) for line in ax.lines}
    assert whole_turns == {(0, -2), (0, -1)}
    named = {number for text in ax.texts for number in text.get_text() if number.isdigit()}
    assert named == {"1", "2", "3", "4", "5"}
    assert ax.get_title() == ""
    assert "degrees" in ax.get_ylabel()


def test_equal_joint_angles_are_named_together(linkages):
    """Joints 2 and 5 of the first linkage turn alike."""
    t = np.linspace(-3, 3, 7)
    angles = linkages[0].joint_angles(t)
    same = np.allclose(angles[:, 1], angles[:, 4])
    _, ax = plt.subplots()
    draw_joint_angles(linkages[0], ax)
    assert ("joints 2, 5" in [text.get_text() for text in ax.texts]) == same


def test_linkages_side_by_side(linkages):
    axes = draw_linkages(linkages, THREE_POSES)
    assert axes.shape == (2, 4)
    assert [ax.texts[-1].get_text() for ax in axes.flat] == [str(n) for n in range(1, 9)]
    mine = space_axes(1, 2)
    assert draw_linkages(linkages[:2], THREE_POSES, mine) is mine


def test_a_picture_is_written_on_a_clear_background(linkages, tmp_path):
    path = write_picture(tmp_path / "linkage.png", linkages[0], THREE_POSES, dpi=60)
    picture = Image.open(path).convert("RGBA")
    alpha = np.asarray(picture)[..., 3]
    assert picture.width > 150
    assert alpha.min() == 0
    assert all(edge.max() > 0 for edge in (alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]))
    assert plt.get_fignums() == []


def test_the_background_is_the_page(ax):
    assert ax.figure.patch.get_alpha() == 0
    _, plain = plt.subplots()
    draw_joint_angles(kl.bennett_linkage(*THREE_POSES), plain)
    assert plain.patch.get_alpha() == plain.figure.patch.get_alpha() == 0
    for empty in plane_axes(2, size=(4, 2)):
        assert empty.patch.get_alpha() == empty.figure.patch.get_alpha() == 0


@pytest.mark.parametrize("cut", [None, (0, 2), (3, 1)])
def test_a_bond_diagram_has_as_many_blue_chords_as_the_degree(linkages, cut):
    (ax,) = plane_axes(size=(3, 3))
    draw_bonds(linkages[0], ax, cut=cut)
    chords = [line for line in ax.lines if len(line.get_xdata()) == 25]
    ends = [np.round(line.get_xydata()[[0, -1]], 9) for line in chords]
    dots = ax.collections[0].get_offsets().round(9).tolist()
    assert [[dots.index(end.tolist()) for end in pair] for pair in ends] == [[0, 2], [0, 3], [1, 4]]
    assert len({line.get_color() for line in chords}) == 1 + (cut == (3, 1))
    blue = sum(line.get_linewidth() > 2 for line in chords)
    assert blue == (0 if cut is None else linkages[0].degrees()[cut])


def test_a_bond_diagram_is_of_one_linkage():
    (ax,) = plane_axes(size=(3, 3))
    batch = kl.goldberg_linkages(*THREE_POSES, np.array([1 + 2j, 2 + 1j]))[0]
    with pytest.raises(ValueError, match="a single linkage"):
        draw_bonds(batch, ax)


def seen(colour: str) -> np.ndarray:
    """A colour in the space L*a*b* of the CIE, where distances are those that are seen."""
    parts = np.array([int(colour[n : n + 2], 16) for n in (1, 3, 5)]) / 255
    light = np.where(parts > 0.04045, ((parts + 0.055) / 1.055) ** 2.4, parts / 12.92)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    x, y, z = np.cbrt(to_xyz @ light / [0.9505, 1, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_frames_have_colours_that_no_link_has():
    links, axes = (GREY, BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILION), (RASPBERRY, LIME, VIOLET)
    assert min(np.linalg.norm(seen(axis) - seen(link)) for axis in axes for link in links) > 40
    assert min(np.linalg.norm(seen(a) - seen(b)) for a, b in combinations(axes, 2)) > 40


def test_drawings_are_cropped_to_their_ink_and_always_the_same_text():
    def drawn() -> str:
        ax = space_axes(size=4)[0, 0]
        draw_curve([[0, 0, 0], [1, 0, 0], [1, 1, 1]], ax)
        return ax.figure._repr_svg_()

    first = drawn()
    assert first == drawn()
    box = np.array(re.search(r'viewBox="([^"]+)"', first)[1].split(), dtype=float)[2:]
    path = re.search(r'<path d="([^"]+)" clip-path|<path d="([^"]+)" style="fill: none', first)
    points = np.array(re.findall(r"[ML] (\S+) (\S+)", path[1] or path[2]), dtype=float)
    assert np.ptp(points, axis=0).max() > 200
    np.testing.assert_allclose(np.ptp(points, axis=0), box, atol=20)


def test_a_drawing_of_many_faces_stays_pixels():
    ax = space_axes(size=4)[0, 0]
    draw_linkage(kl.bennett_linkage(*THREE_POSES), np.inf, ax)
    assert ax.figure._repr_svg_() is None


def test_names_of_joints_stand_off_all_curves():
    for linkage in kl.goldberg_linkages(*THREE_POSES, (1, 2)):
        (ax,) = plane_axes(size=(6.4, 4.6))
        draw_joint_angles(linkage, ax)
        ax.figure.canvas.draw()
        boxes = [text.get_window_extent() for text in ax.texts]
        curves = [ax.transData.transform(line.get_xydata()) for line in ax.lines]
        assert not any(box.contains(*point) for box in boxes for curve in curves for point in curve)
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
        plt.close(ax.figure)
