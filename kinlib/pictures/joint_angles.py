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
    for group, (sample, height, above) in zip(_alike(angles), _clear_places(angles), strict=True):
        name = ("joints " if len(group) > 1 else "joint ") + ", ".join(str(joint + 1) for joint in group)
        ax.annotate(
            name, (share[sample], height), xytext=(0, 5 if above else -5),
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


def _clear_places(angles: np.ndarray) -> list[tuple[int, float, bool]]:
    """For every group of joints where its name has most room: a sample, a height, and whether above it.

    A name is above or below all of its own curve, as far as it is wide; other curves and names keep away.
    """
    curves = angles[[group[0] for group in _alike(angles)]]
    width = angles.shape[1] // 6
    places: list[tuple[int, float, bool]] = []
    for number, curve in enumerate(curves):
        others = np.delete(curves, number, axis=0)
        choices = []
        for start in range(width // 8, angles.shape[1] - width, 4):
            own, middle = curve[start : start + width], start + width // 2
            names = [angles.min() - 10, *(height for sample, height, _ in places if abs(sample - middle) < 1.2 * width)]
            for sign, height in ((1, own.max()), (-1, own.min())):
                room = _room(np.append(others[:, start : start + width], names), height, sign)
                choices.append((room - np.ptp(own) / 2, middle, float(height), sign > 0))
        places.append(max(choices)[1:])
    return places


def _room(obstacles: np.ndarray, height: float, sign: int) -> float:
    """How far obstacles keep from a height on one side of it, at most a quarter of a turn; less near the frame."""
    ahead = sign * (obstacles - height)
    free = float(np.where(ahead >= 0, ahead, 90).min(initial=90))
    return min(free, 45) if height > -30 and sign > 0 else free
