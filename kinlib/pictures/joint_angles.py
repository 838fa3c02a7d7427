"""The plot of the angles at the joints over one turn."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from kinlib.linkage import Linkage
from kinlib.pictures.bars import Bars
from kinlib.pictures.canvas import on_the_page
from kinlib.pictures.colours import link_colours
from kinlib.pictures.turn import one_turn

__all__ = ["draw_joint_angles"]


def draw_joint_angles(linkage: Linkage, ax: Axes, *, samples: int = 400) -> Axes:
    """Plot the angles of all joints over one turn of the linkage, in degrees.

    Joint n has the colour of link n, the last joint that of the base; curves that agree are dashed over each other.
    The pace is even: the ends of the links go equally far at each step.
    """
    bars = Bars.of(linkage)
    linkage = bars.linkage
    t, _ = one_turn(bars, samples)
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
    return on_the_page(ax)


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
