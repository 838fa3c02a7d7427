"""Bond diagrams: a linkage as a circle of links and joints, its bonds as chords."""

from __future__ import annotations

from collections import Counter

import numpy as np
from matplotlib.axes import Axes

from kinlib.linkage import Linkage
from kinlib.pictures.canvas import on_the_page
from kinlib.pictures.colours import BLUE, INK, link_colours

__all__ = ["draw_bonds"]

BEND = 0.16
"""How far the middle of a second chord between the same joints is moved, in units of the radius."""


def draw_bonds(linkage: Linkage, ax: Axes, *, cut: tuple[int, int] | None = None, names: bool = True) -> Axes:
    """Draw the bond diagram of a linkage: links are arcs of a circle, joints the points between them, bonds chords.

    The number of chords that a line from link a to link b cuts is the degree of their relative motion.

    Parameters
    ----------
    linkage : Linkage
        A single one.
    ax : Axes
        Plane axes, such as `plane_axes` makes.
    cut : pair of int, optional
        The numbers of two links: the line between them is drawn, and the chords that it cuts are drawn in blue.
    names : bool
        Whether the numbers of joints and links are written, those of joints from 1.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> from kinlib.pictures import plane_axes
    >>> ax = draw_bonds(bennett_linkage(*gallery.THREE_POSES), plane_axes(size=(3, 3))[0], cut=(0, 2))
    >>> len(ax.lines)                      # four links, two bonds, the cut
    7
    """
    if linkage.shape:
        raise ValueError(f"expected a single linkage, got a batch of shape {linkage.shape}: index it")
    count, turn = linkage.joint_count, 2 * np.pi / linkage.joint_count
    place = np.pi / 2 + turn / 2 - turn * np.arange(count)  # link 0 on top, then clockwise
    seen: Counter[tuple[int, int]] = Counter()
    for bond in linkage.bonds():
        is_cut = cut is not None and bond.is_cut(*cut)
        first, last = (place[joint] - turn for joint in bond.joints)
        chord = _chord(first, last, seen[bond.joints] * BEND)
        ax.plot(*chord, color=BLUE if is_cut else INK, linewidth=2.4 if is_cut else 1.6, zorder=1)
        seen[bond.joints] += 1
    for link, colour in enumerate(link_colours(linkage)):
        arc = np.linspace(place[link], place[link] - turn, 33)
        ax.plot(np.cos(arc), np.sin(arc), color=colour, linewidth=6, solid_capstyle="butt", zorder=2)
    _dots_and_names(ax, place - turn, place - turn / 2, names)
    if cut is not None:
        ends = place[list(cut)] - turn / 2
        ax.plot(1.06 * np.cos(ends), 1.06 * np.sin(ends), "--", color=INK, linewidth=1.4, zorder=3)
    on_the_page(ax).set_axis_off()
    ax.set(aspect="equal", xlim=(-1.32, 1.32), ylim=(-1.32, 1.32))
    return ax


def _chord(first: float, last: float, bend: float) -> np.ndarray:
    """Points from one angle on the unit circle to another, shape (2, k); bent if asked."""
    start, end = (np.array([np.cos(angle), np.sin(angle)]) for angle in (first, last))
    along = np.linspace(0, 1, 25)
    aside = np.array([start[1] - end[1], end[0] - start[0]])
    return start[:, None] * (1 - along) + end[:, None] * along + bend * aside[:, None] * 4 * along * (1 - along)


def _dots_and_names(ax: Axes, joints: np.ndarray, links: np.ndarray, names: bool) -> None:
    ax.scatter(np.cos(joints), np.sin(joints), s=90, color=INK, zorder=4)
    if not names:
        return
    for number, angle in enumerate(joints, start=1):
        ax.text(1.18 * np.cos(angle), 1.18 * np.sin(angle), str(number), color=INK, ha="center", va="center")
    for number, angle in enumerate(links):
        where = 1.2 * np.cos(angle), 1.2 * np.sin(angle)
        ax.text(*where, f"$L_{number}$", color=INK, ha="center", va="center", alpha=0.9)
