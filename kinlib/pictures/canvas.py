"""What is drawn on: axes with equal units in space, axes in the plane, the page behind them."""

from __future__ import annotations

import re
from io import StringIO
from itertools import product
from typing import Any, cast

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d.axes3d import Axes3D
from mpl_toolkits.mplot3d.proj3d import proj_transform

from kinlib.pictures.colours import INK

__all__ = ["Drawing", "equal_units", "on_the_page", "plane_axes", "space_axes"]

LONGEST = 250_000
"""Letters of an SVG file; a drawing that needs more, such as one of shaded bodies, is shown as pixels only."""


class Drawing(Figure):
    """A figure without blank margins; notebooks get it as SVG, too, if that is not too long."""

    def get_tightbbox(self, renderer: Any = None, bbox_extra_artists: Any = None) -> Bbox:
        """The box about the ink, in inches."""
        canvas, shown = self.canvas, cast(Any, FigureCanvasAgg)(self)
        shown.draw()
        ink = np.asarray(shown.buffer_rgba())[..., 3] > 0
        self.set_canvas(canvas)
        across, down = np.flatnonzero(ink.any(axis=0)), np.flatnonzero(ink.any(axis=1))
        if not len(across):
            return Bbox.from_bounds(0, 0, *self.get_size_inches())
        left, right, high, low = across[0], across[-1] + 1, len(ink) - down[0], len(ink) - down[-1] - 1
        return Bbox(np.array([[left, low], [right, high]]) / self.dpi)

    def _repr_svg_(self) -> str | None:
        """The drawing in lines; the same drawing gives the same text."""
        drawn = StringIO()
        with plt.rc_context({"svg.hashsalt": "kinlib"}):
            self.savefig(drawn, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})
        text = drawn.getvalue()
        short = re.sub(r'(?<= d=")[^"]*', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), text)
        return short if len(short) <= LONGEST else None


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
        rows, columns, squeeze=False, figsize=(size * columns, size * rows), subplot_kw={"projection": "3d"},
        FigureClass=Drawing,
    )  # fmt: skip
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
    _, axes = plt.subplots(1, columns, squeeze=False, figsize=size, FigureClass=Drawing)
    for ax in axes.flat:
        on_the_page(ax)
    return axes[0]


def on_the_page(ax: Axes) -> Axes:
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


def equal_units(ax: Axes3D) -> Axes3D:
    """Equal units on all axes, and as large as their box lets them be."""
    limits = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])
    ax.set_box_aspect(np.ptp(limits, axis=1), zoom=1)
    x, y, _ = proj_transform(*np.transpose(list(product(*limits))), ax.get_proj())
    corners = ax.transData.transform(np.transpose([x, y]))
    ax.set_box_aspect(np.ptp(limits, axis=1), zoom=float(np.min(ax.bbox.size / np.ptp(corners, axis=0))))
    return ax
