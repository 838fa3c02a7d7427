"""What is drawn on: axes with equal units in space, axes in the plane, the page behind them."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.axes3d import Axes3D

from kinlib.pictures.colours import INK

__all__ = ["equal_units", "on_the_page", "plane_axes", "space_axes"]


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
    """Equal units on all axes."""
    ax.set_box_aspect([np.ptp(limits) for limits in (ax.get_xlim(), ax.get_ylim(), ax.get_zlim())], zoom=1.15)
    return ax
