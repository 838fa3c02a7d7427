"""Still drawings with matplotlib; every function takes axes and returns them.

Spatial drawings go on axes from `space_axes`, whose units are equal, plane ones on axes from `plane_axes`; the
background of both is the page.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from PIL import Image

from kinlib.displacement import act, as_matrix
from kinlib.line import Line
from kinlib.linkage import Linkage
from kinlib.pictures.bars import Bars
from kinlib.pictures.canvas import equal_units, space_axes
from kinlib.pictures.colours import BLUE, COUPLER, INK, ORANGE, X_AXIS, Y_AXIS, Z_AXIS
from kinlib.pictures.floats import pose_matrices
from kinlib.pictures.linkage_parts import body_of, coupler_parts, linkage_parts
from kinlib.pictures.meshes import faces_of, shaded
from kinlib.pictures.parts import Ball, Rod
from kinlib.pictures.turn import one_turn, parameters_of
from kinlib.scalar import as_float
from kinlib.typing import ArrayLike, PointLike, PoseLike

__all__ = [
    "draw_curve", "draw_frames", "draw_hyperboloid", "draw_line", "draw_linkage", "draw_linkages", "draw_path",
    "draw_positions", "on_hyperboloid", "write_picture",
]  # fmt: skip


def draw_linkage(
    linkage: Linkage, t: float, ax: Axes3D, *, point: PointLike = (0, 0, 0), opacity: float = 1.0
) -> Axes3D:
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
    return _draw_at(Bars.of(linkage), t, ax, point, opacity)


def _draw_at(bars: Bars, t: float, ax: Axes3D, point: PointLike = (0, 0, 0), opacity: float = 1.0) -> Axes3D:
    """`draw_linkage` for a linkage whose bars are known."""
    linkage, unit = bars.linkage, bars.size
    parts = linkage_parts(bars, unit) + coupler_parts(bars, as_float(act(linkage.home, point)), unit)
    matrices = as_float(as_matrix(linkage.link_displacements(np.array([t], dtype=float))[0]))
    places = {body_of(link): matrix for link, matrix in enumerate(matrices)}
    return _draw_parts([_moved(part, places[part.body]) for part in parts], ax, opacity)


def _moved(part: Rod | Ball, matrix: np.ndarray) -> Rod | Ball:
    points = part.points() @ matrix[:3, :3].T + matrix[:3, 3]
    names = ("start", "end") if isinstance(part, Rod) else ("centre",)
    return replace(part, **dict(zip(names, points, strict=True)))


def _draw_parts(parts: Sequence[Rod | Ball], ax: Axes3D, opacity: float) -> Axes3D:
    """Draw rods and balls as one collection, so that what is in front covers what is behind."""
    surfaces = [faces_of(part) for part in parts]
    colours = np.concatenate([shaded(f, part.colour, opacity) for f, part in zip(surfaces, parts, strict=True)])
    faces, had_data = np.concatenate(surfaces), ax.has_data()
    edges = colours if opacity == 1 else "none"
    ax.add_collection3d(Poly3DCollection(faces, facecolors=colours, edgecolors=edges, linewidths=0.3))
    ax.auto_scale_xyz(*faces.reshape(-1, 3).T, had_data=had_data)
    return equal_units(ax)


def draw_frames(
    poses: Sequence[PoseLike], ax: Axes3D, *, size: float | None = None, names: Sequence[str] = ()
) -> Axes3D:
    """Draw poses as coordinate frames: x raspberry, y lime, z violet.

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
    return equal_units(ax)


def draw_curve(points: PointLike, ax: Axes3D, *, colour: str = COUPLER, width: float = 1.6) -> Axes3D:
    """Draw a curve through points, shape (k, 3)."""
    points = as_float(points)
    ax.plot(*points.T, color=colour, linewidth=width, solid_joinstyle="round")
    return equal_units(ax)


def draw_path(linkage: Linkage, ax: Axes3D, *, point: PointLike = (0, 0, 0), **style: Any) -> Axes3D:
    """Draw the path of a point of the coupler's frame over one turn; colour and width as in `draw_curve`."""
    return _draw_path(Bars.of(linkage), ax, point, **style)


def _draw_path(bars: Bars, ax: Axes3D, point: PointLike = (0, 0, 0), **style: Any) -> Axes3D:
    """`draw_path` for a linkage whose bars are known."""
    t, _ = one_turn(bars, 240)
    return draw_curve(act(bars.linkage.coupler_motion(np.append(t, t[0])), point), ax, **style)


def draw_line(line: Line, ax: Axes3D, *, centre: PointLike = (0, 0, 0), length: float = 2.0, **style: Any) -> Axes3D:
    """Draw the piece of a line that has its middle nearest to a point, shape (3,), and a given length.

    Colour and width as in `draw_curve`; grey and thin if not given.
    """
    direction = as_float(line.direction)
    step = direction / np.linalg.norm(direction) * length / 2
    middle = as_float(line.foot(centre))
    return draw_curve(np.array([middle - step, middle + step]), ax, **{"colour": INK, "width": 1.2, **style})


def on_hyperboloid(alpha: ArrayLike, beta: ArrayLike) -> np.ndarray:
    """Where the pose R(cot α, cot β) of a 2R dyad lies on the hyperboloid X² + Y² − Z² = 1, shape (..., 3).

    Every dyad with skew axes has the same picture: with the coordinates x of `Dyad.coordinates` these are
    x1 + x2, x0 − x3 and x1 − x2, divided by x0 + x3.

    Examples
    --------
    >>> on_hyperboloid(0, 0)               # the pose 1
    array([0., 1., 0.])
    """
    first, second = as_float(alpha), as_float(beta)
    X, Y, Z = -np.sin(first + second), np.cos(first + second), np.sin(second - first)
    return np.stack([X, Y, Z], axis=-1) / np.cos(first - second)[..., None] + 0.0


def draw_hyperboloid(
    ax: Axes3D, *, colours: tuple[str, str] = (BLUE, ORANGE), width: float = 1.0, rulings: int = 24
) -> Axes3D:
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


def draw_linkages(linkages: Sequence[Linkage], poses: Sequence[PoseLike], axes: np.ndarray | None = None) -> np.ndarray:
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
        bars = Bars.of(linkage, f"linkage {number} of those given")
        _draw_path(bars, ax, width=1)
        _draw_at(bars, np.inf, ax)
        draw_frames(poses, ax)
        ax.text2D(0.04, 0.9, str(number), transform=ax.transAxes, color=INK, fontsize="large")
    return axes


def draw_positions(linkage: Linkage, poses: Sequence[PoseLike], ax: Axes3D) -> Axes3D:
    """Draw a linkage at all of the poses that it visits, fainter from the last to the first, and its path."""
    bars = Bars.of(linkage)
    _draw_path(bars, ax)
    parameters = parameters_of(bars, poses)
    for t, opacity in zip(parameters, np.linspace(0.18, 1, len(parameters)) ** 1.3, strict=True):
        _draw_at(bars, t, ax, opacity=opacity)
    return draw_frames(poses, ax, names=[f"$p_{n}$" for n in range(len(poses))])


def write_picture(
    path: str | os.PathLike[str],
    linkage: Linkage,
    poses: Sequence[PoseLike],
    *,
    view: tuple[float, float] = (24, -60),
    size: float = 5.0,
    dpi: int = 160,
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
