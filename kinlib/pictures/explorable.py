"""Scenes that answer: the reader moves a point of the plane of z, and the linkage follows by recorded formulas."""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.goldberg import PLACES, goldberg_linkages
from kinlib.line import Line, common_perpendicular
from kinlib.linkage import Linkage
from kinlib.pictures.colours import INK, PIN, link_colours
from kinlib.pictures.formula import Formula, record
from kinlib.pictures.moving import linkage_scene
from kinlib.pictures.page import page_of, shown
from kinlib.pictures.parts import Frame
from kinlib.pictures.recording import record as record_parts
from kinlib.pictures.recording import tidy
from kinlib.pictures.shapes import View
from kinlib.poses import as_poses
from kinlib.typing import PoseLike
from kinlib.z_plane import ZFault, ZPlane, z_planes

__all__ = ["ExplorableScene", "goldberg_scene"]

NEAR = 1e-6
"""How near to a bad place there is no linkage drawn."""

FAULTS = (ZFault.REAL, ZFault.BENNETT, ZFault.CIRCUMCIRCLE, ZFault.MISSES_1, ZFault.MISSES_2,
          ZFault.SAME_QUADRATIC, ZFault.OWN_CONJUGATE)  # fmt: skip


@dataclass(frozen=True, repr=False)
class ExplorableScene:
    """A scene with parameters that the reader changes."""

    alt: str
    table: dict[str, Any]
    height: str = "34rem"
    pictured: dict[str, Any] | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.alt}>"

    def recording(self) -> dict[str, Any]:
        """All that the page needs, ready to be written as JSON."""
        return self.table

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write one HTML file that works by itself, without a network."""
        path = Path(path)
        path.write_text(page_of(self.table, shared=False), encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        return shown(self.table, self.height, self.pictured)


def goldberg_scene(
    poses: Sequence[PoseLike],
    z: tuple[float, float] = (1.0, 2.0),
    *,
    alt: str,
    x: tuple[float, float] = (-3.0, 3.0),
    y: tuple[float, float] = (-2.0, 4.0),
    choice: int = 4,
    point: Sequence[float] = (0, 0, 0),
    height: str = "34rem",
) -> ExplorableScene:
    """The eight Goldberg linkages through three exact poses: the reader moves z, and chooses which one is seen.

    Parameters
    ----------
    poses : sequence of three poses with exact numbers
    z : (float, float)
        Where the point is at first.
    alt : str
        A sentence that says what is to be seen.
    x, y : (float, float)
        The part of the plane in which z can be moved.
    choice : int
        Which of the eight is shown at first, 0, 1, ….
    point : array_like, shape (3,)
        The point of the coupler's frame whose path is drawn, in units of length.
    height : str
        Of the scene on a page, in units of CSS.
    """
    p0, p1, p2 = as_poses(*poses)
    planes = z_planes(p0, p1, p2)
    shapes = record(lambda x, y: _shapes((p0, p1, p2), planes, x, y), {"x": x, "y": y})
    shown_at_first = goldberg_linkages(p0, p1, p2, z)
    example = shown_at_first[choice]
    scene = linkage_scene(example, poses, alt=alt, point=point)
    cell = scene.cell()
    view = View(np.array(cell["centre"]), cell["unit"])
    frames = [Frame(pose, 0.16 * view.radius, f"p{'₀₁₂'[n]}") for n, pose in enumerate((p0, p1, p2))]
    labels = [(frame.name, "", view.place(frame.points()[0]), None) for frame in frames]
    explorer = {
        "shapes": shapes.javascript,
        "motions": [motion_formula(shown_at_first[n]).javascript for n in (0, 2)],
        "motion": [0, 0, 1, 1, 0, 0, 1, 1], "plane": [n // 2 for n in range(8)],
        "choices": [f"{n + 1}: {PLACES[n // 2].removesuffix(': ')}" for n in range(8)],
        "chooser": "linkage", "pad": "the number z", "limits": [x, y], "choice": choice,
        "bad": [fault.message for fault in FAULTS],
        "colours": link_colours(example), "pin": PIN, "coupler": example.coupler, "steps": 96,
        "point": _home_point(example, point), "picture": _plane_picture(planes, x, y),
        "kept": [view.place(frame.points()[0]) for frame in frames],
        "recipe": {"poses": [[float(c) for c in p.coeffs] for p in (p0, p1, p2)]},
    }  # fmt: skip
    table = scene.recording() | tidy({
        "frames": 360, "captions": [f"{n}°" for n in range(360)], "slider": "Angle of the joint that drives",
        "cells": [cell | {"tracks": {}, "lights": [], "labels": labels, **record_parts(frames, view)}],
        "explorer": explorer,
    })  # fmt: skip
    table["explorer"] |= {"near": NEAR, "start": [float(c) for c in z]}  # in full
    return ExplorableScene(alt, table, height, scene.recording())


def _home_point(linkage: Linkage, point: Sequence[float]) -> list[float]:
    return [float(c) for c in act(linkage.home, list(point))]


def motion_formula(linkage: Linkage) -> Formula:
    """The displacements of all links from home, of the coefficients of the factors and of t = c : s."""
    names = [f"f{n}_{m}" for n in range(len(linkage.factors)) for m in range(8)]

    def displacements(**v: Any) -> list[DualQuaternion]:
        factors = [DualQuaternion([v[f"f{n}_{m}"] for m in range(8)]) for n in range(len(linkage.factors))]
        turns = [v["c"] - v["s"] * f for f in factors]
        moves, done = [DualQuaternion([1, 0, 0, 0, 0, 0, 0, 0])], 0
        for count in linkage.joints[:-1]:
            move = moves[-1]
            for turn in turns[done : done + count]:
                move = move * turn
            moves.append(move)
            done += count
        return moves

    return record(displacements, dict.fromkeys([*names, "c", "s"], (-2.0, 2.0)))


def _root(x: Any) -> Any:
    return np.sqrt(x if hasattr(x, "sqrt") else float(x))


def _shapes(poses: Sequence[DualQuaternion], planes: Sequence[ZPlane], x: Any, y: Any) -> dict[str, Any]:
    """Axes, bars, factors and rows of all eight, partners, and how far bad places are."""
    partners = [plane.partner((x, y)) for plane in planes]
    return {
        "linkages": [_shape(linkage) for linkage in goldberg_linkages(poses[0], poses[1], poses[2], (x, y))],
        "partner": [list(partner) for partner in partners],
        "bad": [_distances(plane, x, y, *partner) for plane, partner in zip(planes, partners, strict=True)],
    }


def _shape(linkage: Linkage) -> list[Any]:
    """Unit axes; feet of the common perpendicular of each and the next; factors; distance, twist, offset by link."""
    axes = [h / _root(null_form(h, h)) for h in linkage.axes]
    lines = [Line.from_dual_quaternion(h) for h in linkage.axes]
    feet = [common_perpendicular(a, b) for a, b in zip(lines, lines[1:] + lines[:1], strict=True)]
    rows = []
    for n, (start, end) in enumerate(feet):
        way, (l, k) = end - start, (axes[m % len(axes)].coeffs[1:4] for m in (n, n + 1))
        distance = _root((way * way).sum())
        twist = np.arctan2((np.cross(l, k) * way).sum() / distance, (l * k).sum())
        rows.append([distance, twist, ((start - feet[n - 1][1]) * l).sum()])
    return [axes, [list(pair) for pair in feet], list(linkage.factors), rows]


def _distances(plane: ZPlane, x: Any, y: Any, u: Any, v: Any) -> list[Any]:
    """How far z = (x, y) and its partner (u, v) are from the bad places, in the order of `FAULTS`."""
    (b1, _), (b2, _), (bx, by) = plane.corners
    n, m = null_form(plane.hA, plane.hA), null_form(plane.hB, plane.hB)

    def apart(a: Any, b: Any) -> Any:
        return _root(a * a + n * (b * b))

    quadratics = [_root(p * p + (p * p + n * (q * q) - m) * (p * p + n * (q * q) - m)) for p, q in ((x, y), (u, v))]
    size = apart(u, v)
    return [
        y, apart(x - bx, y - by), 1 / size, apart(u - b1, v), apart(u - b2, v), quadratics[0] * quadratics[1],
        apart(x - u, y - v) * apart(x - u, y + v),
    ]  # fmt: skip


def _plane_picture(planes: Sequence[ZPlane], x: tuple[float, float], y: tuple[float, float]) -> str:
    """The triangles and circles of the planes, as a picture that fills the pad."""
    figure = plt.figure(figsize=(3.6, 3.6 * (y[1] - y[0]) / (x[1] - x[0])))
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=x, ylim=y)
    ax.set_axis_off()
    turn = np.linspace(0, 2 * np.pi, 200)
    for plane in planes[::2]:
        corners = np.array([[float(c) for c in corner] for corner in (*plane.corners, plane.corners[0])])
        ax.plot(*corners.T, color=INK, linewidth=1.2)
        centre, radius = plane.circumcircle
        ax.plot(centre.real + radius * np.cos(turn), centre.imag + radius * np.sin(turn), color=INK, linestyle="--")
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110, transparent=True, metadata={"Software": None})
    plt.close(figure)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()
