"""Still drawings with matplotlib; every function takes axes and returns them.

Spatial drawings go on axes from `space_axes`, whose units are equal, plane ones on axes from `plane_axes`; the
background of both is the page.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from PIL import Image

from kinlib.displacement import act, as_matrix
from kinlib.line import Line
from kinlib.linkage import Linkage
from kinlib.pace import one_turn, parameters_of
from kinlib.scalar import as_float
from kinlib.skeleton import (
    COUPLER,
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Piece,
    coupler_pieces,
    extent,
    in_floats,
    link_colours,
    linkage_pieces,
    pose_matrices,
)

__all__ = [
    "draw_curve", "draw_frames", "draw_hyperboloid", "draw_joint_angles", "draw_line", "draw_linkage", "draw_linkages",
    "draw_path", "draw_positions", "on_hyperboloid", "plane_axes", "space_axes", "write_picture",
]  # fmt: skip

INK = "#7a7a7a"
"""The grey of letters and lines, seen on light pages and on dark ones."""

_LIGHT = np.array([0.35, -0.55, 0.76])
_SIDES = 14


def space_axes(
    rows: int = 1, columns: int = 1, *, size: float = 4.0, view: tuple[float, float] = (24, -60)
) -> np.ndarray:
    """A new figure with a grid of spatial axes on a clear background.

    Parameters
    ----------
    rows, columns : int
    size : float
        The side of each, in inches.
    view : (float, float)
        Elevation and azimuth of the direction towards the viewer, in degrees.

    Returns
    -------
    numpy.ndarray of Axes3D, shape (rows, columns)

    Examples
    --------
    >>> space_axes(2, 4).shape
    (2, 4)
    """
    figure, axes = plt.subplots(
        rows, columns, squeeze=False, figsize=(size * columns, size * rows), subplot_kw={"projection": "3d"}
    )
    figure.patch.set_alpha(0)
    figure.subplots_adjust(0, 0, 1, 1, 0, 0)
    for ax in axes.flat:
        ax.set_axis_off()
        ax.patch.set_alpha(0)
        ax.view_init(*view)
        ax.set_proj_type("ortho")
    return axes


def plane_axes(columns: int = 1, *, size: tuple[float, float] = (6.0, 3.5)) -> np.ndarray:
    """A new figure with a row of plane axes on a clear background, and letters seen on light pages and on dark ones.

    Parameters
    ----------
    columns : int
    size : (float, float)
        Width and height of the figure, in inches.

    Returns
    -------
    numpy.ndarray of Axes, shape (columns,)

    Examples
    --------
    >>> plane_axes(2).shape
    (2,)
    """
    _, axes = plt.subplots(1, columns, squeeze=False, figsize=size)
    for ax in axes.flat:
        _on_the_page(ax)
    return axes[0]


# ---- solids ------------------------------------------------------------------------------------------


def _tube(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """The surface of a round rod with closed ends, as quadrangles of shape (k, 4, 3)."""
    axis = end - start
    length = np.linalg.norm(axis)
    pieces = int(np.clip(np.ceil(length / (3 * radius)), 1, 40))
    side, other = _across(axis / length)
    turn = np.linspace(0, 2 * np.pi, _SIDES + 1)
    ring = radius * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other)
    rings = start + np.linspace(0, 1, pieces + 1)[:, None, None] * axis + ring
    caps = [np.broadcast_to(point, ring.shape) for point in (start, end)]
    return _quadrangles(np.concatenate([caps[:1], rings, caps[1:]]))


def _ball(centre: np.ndarray, radius: float) -> np.ndarray:
    """The surface of a ball, as quadrangles of shape (k, 4, 3)."""
    turn, height = np.linspace(0, 2 * np.pi, _SIDES + 1), np.linspace(0, np.pi, 8)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    up = np.array([0, 0, 1])
    return _quadrangles(centre + radius * (np.sin(height)[:, None, None] * ring + np.cos(height)[:, None, None] * up))


def _across(direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors perpendicular to a direction and to each other."""
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    return side, np.cross(direction, side)


def _quadrangles(grid: np.ndarray) -> np.ndarray:
    """The meshes of a grid of points, shape (rows, columns, 3)."""
    corners = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def _shaded(faces: np.ndarray, colour: str, opacity: float) -> np.ndarray:
    """The colours of faces, shape (k, 4), darker where they turn away from the light."""
    normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    brightness = 0.72 + 0.33 * np.abs(normals @ _LIGHT)
    shades = np.clip(brightness[:, None] * to_rgb(colour), 0, 1)
    return np.concatenate([shades, np.full((len(faces), 1), opacity)], axis=1)


def _draw_pieces(pieces: Sequence[Piece], ax: Axes3D, opacity: float = 1.0) -> Axes3D:
    """Draw rods and balls as one collection, so that what is in front covers what is behind."""
    faces = [_ball(p.start, p.radius) if np.all(p.start == p.end) else _tube(*p[:3]) for p in pieces]
    colours = np.concatenate([_shaded(f, p.colour, opacity) for f, p in zip(faces, pieces, strict=True)])
    faces, had_data = np.concatenate(faces), ax.has_data()
    edges = colours if opacity == 1 else "none"
    ax.add_collection3d(Poly3DCollection(faces, facecolors=colours, edgecolors=edges, linewidths=0.3))
    ax.auto_scale_xyz(*faces.reshape(-1, 3).T, had_data=had_data)
    return _equal(ax)


def _equal(ax: Axes3D) -> Axes3D:
    """Equal units on all axes."""
    ax.set_box_aspect([np.ptp(limits) for limits in (ax.get_xlim(), ax.get_ylim(), ax.get_zlim())], zoom=1.15)
    return ax


# ---- drawings ----------------------------------------------------------------------------------------


def draw_linkage(linkage: Linkage, t: float, ax: Axes3D, *, point=(0, 0, 0), opacity: float = 1.0) -> Axes3D:
    """Draw a linkage at the parameter t, with the rods that hold a point of its coupler.

    Parameters
    ----------
    linkage : Linkage
    t : float
        ``inf`` for home.
    ax : Axes3D
    point : array_like, shape (3,)
        In the coupler's frame, in units of length.
    opacity : float
        Less than 1 lets the drawing fade.
    """
    linkage = in_floats(linkage)
    unit = extent(linkage)
    held = coupler_pieces(linkage, as_float(act(linkage.home, point)), unit)
    matrices = as_float(as_matrix(linkage.link_displacements(np.array([t], dtype=float))[0]))
    pieces = [_moved(piece, matrices[piece.link]) for piece in linkage_pieces(linkage, unit) + held]
    return _draw_pieces(pieces, ax, opacity)


def _moved(piece: Piece, matrix: np.ndarray) -> Piece:
    start, end = np.stack([piece.start, piece.end]) @ matrix[:3, :3].T + matrix[:3, 3]
    return piece._replace(start=start, end=end)


def draw_frames(poses: Sequence, ax: Axes3D, *, size: float | None = None, names: Sequence[str] = ()) -> Axes3D:
    """Draw poses as coordinate frames: x red, y green, z blue.

    Parameters
    ----------
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``
    ax : Axes3D
    size : float, optional
        The length of their axes; a tenth of what the axes hold if not given.
    names : sequence of str
        Written next to the origins.
    """
    matrices = pose_matrices(poses)
    origins = matrices[:, :3, 3]
    size = size or 0.1 * max(np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim()), np.ptp(ax.get_zlim()))
    for axis, colour in enumerate((X_AXIS, Y_AXIS, Z_AXIS)):
        ax.quiver(*origins.T, *size * matrices[:, :3, axis].T, color=colour, linewidth=1.8, arrow_length_ratio=0.25)
    for origin, name in zip(origins, names, strict=False):
        ax.text(*(origin - 0.35 * size), name, color=INK, fontsize="large", ha="center", va="top")
    return _equal(ax)


def draw_curve(points: np.ndarray, ax: Axes3D, *, colour: str = COUPLER, width: float = 1.6) -> Axes3D:
    """Draw a curve through points, shape (k, 3)."""
    points = as_float(points)
    ax.plot(*points.T, color=colour, linewidth=width, solid_joinstyle="round")
    return _equal(ax)


def draw_path(linkage: Linkage, ax: Axes3D, *, point=(0, 0, 0), **style) -> Axes3D:
    """Draw the path of a point of the coupler's frame over one turn; colour and width as in `draw_curve`."""
    linkage = in_floats(linkage)
    t, _ = one_turn(linkage, 240)
    return draw_curve(act(linkage.coupler_motion(np.append(t, t[0])), point), ax, **style)


def draw_line(line: Line, ax: Axes3D, *, centre=(0, 0, 0), length: float = 2.0, **style) -> Axes3D:
    """Draw the piece of a line that has its middle nearest to a point, shape (3,), and a given length.

    Colour and width as in `draw_curve`; grey and thin if not given.
    """
    direction = as_float(line.direction)
    step = direction / np.linalg.norm(direction) * length / 2
    middle = as_float(line.foot(centre))
    return draw_curve(np.array([middle - step, middle + step]), ax, **{"colour": INK, "width": 1.2, **style})


def on_hyperboloid(alpha, beta) -> np.ndarray:
    """Where the pose R(cot α, cot β) of a 2R dyad lies on the hyperboloid X² + Y² − Z² = 1, shape (..., 3).

    Every dyad with skew axes has the same picture: with the coordinates x of `Dyad.coordinates` these are
    x1 + x2, x0 − x3 and x1 − x2, divided by x0 + x3.

    Examples
    --------
    >>> on_hyperboloid(0, 0)               # the pose 1
    array([0., 1., 0.])
    """
    X, Y, Z = -np.sin(np.add(alpha, beta)), np.cos(np.add(alpha, beta)), np.sin(np.subtract(beta, alpha))
    return np.stack([X, Y, Z], axis=-1) / np.cos(np.subtract(alpha, beta))[..., None] + 0.0


def draw_hyperboloid(ax: Axes3D, *, colours=("#0072b2", "#e69f00"), width: float = 1.0, rulings: int = 24) -> Axes3D:
    """Draw both families of lines on the hyperboloid of `on_hyperboloid`.

    Parameters
    ----------
    ax : Axes3D
    colours : (str, str)
        Of the lines on which α is fixed and β varies, and of those on which β is fixed and α varies.
    width : float
    rulings : int
        The number of lines of each family; the first of each passes through the pose 1.
    """
    for angle in np.linspace(0, np.pi, rulings, endpoint=False):
        other = angle + np.array([-1.05, 1.05])
        draw_curve(on_hyperboloid(angle, other), ax, colour=colours[0], width=width)
        draw_curve(on_hyperboloid(other, angle), ax, colour=colours[1], width=width)
    return ax


def draw_joint_angles(linkage: Linkage, ax: Axes, *, samples: int = 400) -> Axes:
    """Plot the angles of all joints over one turn of the linkage, in degrees.

    Joint n has the colour of link n, the last joint that of the base; curves that agree are dashed over each other.
    The pace is even: the ends of the links go equally far at each step.
    """
    linkage = in_floats(linkage)
    t, _ = one_turn(linkage, samples)
    share = np.linspace(0, 100, samples + 1)
    angles = np.degrees(linkage.joint_angles(np.append(t, -np.inf))).T
    colours = np.roll(link_colours(linkage), -1)
    for group in _alike(angles):
        for place, joint in enumerate(group):
            gaps = (place * 5, (5, 5 * (len(group) - 1))) if len(group) > 1 else "-"
            ax.plot(share, angles[joint], color=colours[joint], linewidth=2.2, linestyle=gaps)
    for group, (sample, above) in zip(_alike(angles), _clear_places(angles), strict=True):
        name = ("joints " if len(group) > 1 else "joint ") + ", ".join(str(joint + 1) for joint in group)
        ax.annotate(
            name, (share[sample], angles[group[0], sample]), xytext=(0, 7 if above else -7),
            textcoords="offset points", ha="center", va="bottom" if above else "top", color=colours[group[0]],
        )  # fmt: skip
    ax.set(xlabel="share of one turn in %", ylabel="joint angle in degrees", xlim=(0, 100))
    ax.yaxis.set_major_locator(MultipleLocator(180))
    return _on_the_page(ax)


def _alike(angles: np.ndarray) -> list[list[int]]:
    """The joints, shape (joints, samples), in groups of equal angles."""
    groups: list[list[int]] = []
    for joint, curve in enumerate(angles):
        same = [group for group in groups if np.allclose(angles[group[0]], curve, atol=0.5)]
        same[0].append(joint) if same else groups.append([joint])
    return groups


def _clear_places(angles: np.ndarray) -> list[tuple[int, bool]]:
    """For every group of joints where its name has most room: a sample, and whether above the curve."""
    curves = angles[[group[0] for group in _alike(angles)]]
    width = angles.shape[1] // 8
    starts = np.arange(width // 2, angles.shape[1] - 2 * width)
    places = []
    for number, curve in enumerate(curves):
        rise = np.delete(curves, number, axis=0) - curve
        room = []
        for side in (rise, -rise):
            ahead = np.where(side > 0, side, np.where(side < 0, 180, 0)).min(axis=0, initial=180)
            room.append([ahead[start : start + width].min() for start in starts])
        best = np.unravel_index(np.argmax(room), np.shape(room))
        places.append((int(starts[best[1]] + width // 2), best[0] == 0))
    return places


def _on_the_page(ax: Axes) -> Axes:
    """Grey letters and lines on a clear background, which read on light pages and on dark ones."""
    ax.figure.patch.set_alpha(0)
    ax.patch.set_alpha(0)
    ax.grid(color=INK, alpha=0.25)
    ax.tick_params(colors=INK)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color(INK)
    ax.xaxis.label.set_color(INK)
    ax.yaxis.label.set_color(INK)
    return ax


def draw_linkages(linkages: Sequence[Linkage], poses: Sequence, axes: np.ndarray | None = None) -> np.ndarray:
    """Draw linkages at home next to each other, each with the poses and the path of its coupler's frame.

    Parameters
    ----------
    linkages : sequence of Linkage
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``
    axes : numpy.ndarray of Axes3D, optional
        At least as many as linkages; new ones, four a row, if not given.

    Returns
    -------
    numpy.ndarray of Axes3D
    """
    if axes is None:
        axes = space_axes(-(-len(linkages) // 4), min(4, len(linkages)), size=2.6)
    for number, (linkage, ax) in enumerate(zip(linkages, axes.flat, strict=False), start=1):
        draw_path(linkage, ax, width=1)
        draw_linkage(linkage, np.inf, ax)
        draw_frames(poses, ax)
        ax.text2D(0.04, 0.9, str(number), transform=ax.transAxes, color=INK, fontsize="large")
    return axes


def draw_positions(linkage: Linkage, poses: Sequence, ax: Axes3D) -> Axes3D:
    """Draw a linkage at all of the poses that it visits, fainter from the last to the first, and its path."""
    draw_path(linkage, ax)
    parameters = parameters_of(in_floats(linkage), poses)
    for t, opacity in zip(parameters, np.linspace(0.18, 1, len(parameters)) ** 1.3, strict=True):
        draw_linkage(linkage, t, ax, opacity=opacity)
    return draw_frames(poses, ax, names=[f"$p_{n}$" for n in range(len(poses))])


def write_picture(
    path: str | os.PathLike, linkage: Linkage, poses: Sequence, *, view=(24, -60), size: float = 5.0, dpi: int = 160
) -> Path:
    """Write a picture of a linkage at all of the poses that it visits, on a clear background.

    Parameters
    ----------
    path : path-like
        The name of a PNG file.
    view : (float, float)
        Elevation and azimuth of the direction towards the viewer, in degrees.
    size : float
        The side of the square that is drawn on, in inches; its empty margins are cut off.
    """
    ax = space_axes(size=size, view=view)[0, 0]
    draw_positions(linkage, poses, ax)
    drawn = BytesIO()
    ax.figure.savefig(drawn, format="png", dpi=dpi, transparent=True)
    plt.close(ax.figure)
    picture = Image.open(drawn)
    picture.crop(picture.getbbox()).save(path)
    return Path(path)
