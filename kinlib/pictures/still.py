"""The still of a scene: its recording at the first frame, as a small drawing in SVG.

It stands where the scene cannot play: on paper, without WebGL, and while the viewer is on its way.  It is drawn from
what the player reads, without perspective: each shape becomes flat patches, and what is nearer covers what is behind.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from kinlib.displacement import as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.pictures.colours import INK
from kinlib.pictures.shapes import Table
from kinlib.scalar import as_float

__all__ = ["still_of"]

WIDTH, HEIGHT, MARGIN = 720.0, 380.0, 14.0
"""Of the drawing without its legend, and around each of its cells."""

STRIPES = ((-1.0, -0.5, 0.72), (-0.5, 0.25, 0.94), (0.25, 0.7, 1.12), (0.7, 1.0, 0.9))
COARSE = ((-1.0, -0.3, 0.76), (-0.3, 1.0, 1.02))
"""From where to where, in parts of the radius, and how bright a round bar is across; and the same in a small cell."""

EDGELESS = " class='n'"

Stripes: TypeAlias = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Patch:
    """Points to be joined, shape (k, 3): sideways, upwards, towards the viewer; and how they are painted.

    A patch with a thickness is a line, one without is filled.
    """

    points: np.ndarray
    colour: str
    opacity: float = 1.0
    thick: float = 0.0

    @property
    def depth(self) -> float:
        return round(float(self.points[:, 2].mean()), 4)

    def drawn(self, scale: float, shift: np.ndarray) -> str:
        """Its place on paper, which has y downwards."""
        places = (scale * self.points[:, :2] * [1, -1] + shift).round(1)
        (x, y), *steps = np.concatenate([places[:1], np.diff(places, axis=0)])
        path = f"M{_short(x)} {_short(y)}l" + " ".join(f"{_short(a)} {_short(b)}" for a, b in steps)
        faint = "" if self.opacity == 1 else f" opacity='{_short(self.opacity)}'"
        if self.thick:
            width = _short(max(scale * self.thick, 0.8))
            return f"<path color='{self.colour}' class='l' stroke-width='{width}'{faint} d='{path}'/>"
        return f"<path color='{self.colour}'{faint and faint + EDGELESS} d='{path}z'/>"


def still_of(recording: Table) -> str:
    """The drawing of a recording, as the text of an SVG file.

    Examples
    --------
    >>> from kinlib.pictures import Ball, Scene
    >>> still_of(Scene([Ball([0, 0, 0])], alt="A ball.").recording())[:45]
    "<svg xmlns='http://www.w3.org/2000/svg' viewB"
    """
    cells = recording["cells"]
    across = min(len(cells), 4)
    room = np.array([WIDTH / across, HEIGHT if len(cells) < 3 else min(HEIGHT, 1.05 * WIDTH / across)])
    drawn, height = [], 0.0
    for row in range(0, len(cells), across):
        pieces, tall = _row(cells[row : row + across], recording["view"], room, height)
        drawn += pieces
        height += tall
    legend, height = _legend(recording["legend"], height)
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {_short(WIDTH)} {_short(height)}' "
        f"width='{_short(WIDTH)}' height='{_short(height)}' font-family='sans-serif' font-size='14' fill='{INK}'>"
        "<style>path{fill:currentColor;stroke:currentColor}"
        ".l{fill:none;stroke-linecap:round;stroke-linejoin:round}.n{stroke:none}</style>"
        f"<g stroke-width='.4'>{''.join(drawn + legend)}</g></svg>"
    )


def _row(cells: Sequence[Table], view: Sequence[float], room: np.ndarray, top: float) -> tuple[list[str], float]:
    """Cells next to each other below a height, and how much height they need."""
    drawn, tall = [], 0.0
    for place, cell in enumerate(cells):
        stripes = COARSE if room[0] < WIDTH / 2 else STRIPES
        patches = sorted(_patches(cell, _axes_of(view), stripes), key=lambda patch: patch.depth)
        corners = _corners(patches)
        size = np.maximum(corners[1] - corners[0], 1e-9)
        head = 16.0 if cell["name"] else 0.0
        scale = float(((room - 2 * MARGIN - [0, head]) / size).min())
        needed = scale * size[1] + 2 * MARGIN + head
        middle = np.array([(place + 0.5) * room[0], top + head + (needed - head) / 2])
        shift = middle - scale * corners.mean(axis=0) * [1, -1]
        drawn += [patch.drawn(scale, shift) for patch in patches]
        drawn += _letters(cell, _axes_of(view), scale, shift)
        if cell["name"]:
            drawn.append(_text(cell["name"], place * room[0] + 6, top + 14))
        tall = max(tall, needed)
    return drawn, tall


def _axes_of(view: Sequence[float]) -> np.ndarray:
    """What is sideways, upwards and towards the viewer, in the rows; azimuth and elevation are in degrees."""
    (c, s), (d, e) = ((np.cos(angle), np.sin(angle)) for angle in np.radians(view))
    return np.array([[-s, c, 0], [-c * e, -s * e, d], [c * d, s * d, e]])


def _corners(patches: Sequence[Patch]) -> np.ndarray:
    """The corners of the box about all patches, shape (2, 2)."""
    if not patches:
        return np.array([[-1.0, -1.0], [1.0, 1.0]])
    low = [patch.points[:, :2].min(axis=0) - patch.thick / 2 for patch in patches]
    high = [patch.points[:, :2].max(axis=0) + patch.thick / 2 for patch in patches]
    return np.array([np.min(low, axis=0), np.max(high, axis=0)])


def _places(cell: Table) -> dict[str, np.ndarray]:
    """Where the bodies of a cell are at the first frame: their matrices; what has no motion stands still."""
    first = {body: DualQuaternion([float(x) for x in track[:8]]) for body, track in cell["tracks"].items()}
    return {body: as_float(as_matrix(pose)) for body, pose in first.items()}


def _patches(cell: Table, axes: np.ndarray, stripes: Stripes) -> Iterable[Patch]:
    """All that a cell shows at the first frame."""
    places = _places(cell)
    lights = {path: frame for path, frame, _ in cell["lights"]}
    for path, geometry, material, *rows in cell["objects"]:
        body, number, group, _ = path.split("/")
        light = lights.get(f"{body}/{number}")
        if light is not None and (group == "on") != (light == 0):
            continue
        matrix = places.get(body, np.eye(4)) @ np.vstack([np.reshape(rows, (3, 4)), [0, 0, 0, 1]])
        paint = cell["materials"][material]
        look = (f"#{paint['color']:06x}", paint.get("opacity", 1.0))
        yield from _shape(cell["geometries"][geometry], axes @ matrix[:3], look, stripes)


def _shape(shape: Table, matrix: np.ndarray, look: tuple[str, float], stripes: Stripes) -> Iterable[Patch]:
    """The patches of one shape of three.js, with its colour and opacity, seen through a matrix, shape (3, 4)."""

    def seen(points: np.ndarray) -> np.ndarray:
        return points @ matrix[:, :3].T + matrix[:, 3]

    if shape["type"] == "SphereGeometry":
        radius = float(np.linalg.norm(matrix[:3, 0])) * shape["radius"]
        yield from _ball(seen(np.zeros((1, 3)))[0], radius, *look)
    elif shape["type"] == "CylinderGeometry":
        ends = seen(np.array([[0, -0.5, 0], [0, 0.5, 0]]) * shape["height"])
        thick = float(np.linalg.norm(matrix[:3, 0])) * shape["radiusBottom"]
        yield from _rod(ends, thick, look, stripes) if shape["radiusTop"] else _cone(ends, thick, *look)
    elif shape["type"] == "TubeGeometry":
        points = _smooth(np.array(shape["path"]["points"], dtype=float), shape["closed"])
        yield from _line(seen(points), 2 * shape["radius"], *look)
    else:
        points = seen(np.reshape(shape["data"]["attributes"]["position"]["array"], (-1, 3)))
        corners = np.reshape(shape["data"]["index"]["array"], (-1, 6))[:, [0, 1, 5, 2]]
        for patch in points[corners]:
            yield Patch(patch, _shaded(look[0], _towards(patch)), look[1])


def _rod(ends: np.ndarray, radius: float, look: tuple[str, float], stripes: Stripes) -> Iterable[Patch]:
    """A round bar in short pieces, each of stripes that look round, and the end that is seen."""
    axis = ends[1] - ends[0]
    flat = np.array([axis[0], axis[1], 0.0])
    long = float(np.linalg.norm(flat))
    across = np.array([-axis[1], axis[0], 0.0]) / long if long > 1e-6 else np.array([1.0, 0.0, 0.0])
    across = -across if across @ [-0.5, 1, 0] < 0 else across
    most = 3 * len(stripes)
    pieces = int(np.clip(np.ceil(np.linalg.norm(axis) / max(5 * radius, 0.12)), 1, most))
    for start, end in pairwise(ends[0] + np.linspace(0, 1, pieces + 1)[:, None] * axis):
        for low, high, bright in stripes:
            sides = radius * np.array([[low], [high], [high], [low]]) * across
            yield Patch(np.array([start, start, end, end]) + sides, _shaded(look[0], bright), look[1])
    lean = abs(axis[2]) / max(float(np.linalg.norm(axis)), 1e-12)
    turn = np.linspace(0, 2 * np.pi, 4 * len(stripes), endpoint=False)[:, None]
    ring = np.cos(turn) * across + lean * np.sin(turn) * [across[1], -across[0], 0]
    near = ends[int(axis[2] > 0)] + [0, 0, 0.5 * radius]
    yield Patch(near + radius * ring, _shaded(look[0], 0.82 + 0.25 * lean), look[1])


def _cone(ends: np.ndarray, radius: float, colour: str, opacity: float) -> Iterable[Patch]:
    """The tip of an arrow."""
    axis = ends[1] - ends[0]
    across = np.array([-axis[1], axis[0], 0.0])
    across = radius * across / max(float(np.linalg.norm(across)), 1e-9)
    yield Patch(np.array([ends[0] + across, ends[1], ends[0] - across]), colour, opacity)


def _ball(centre: np.ndarray, radius: float, colour: str, opacity: float) -> Iterable[Patch]:
    """A disc, and a lighter one on it if it is not seen through."""
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    disc = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    yield Patch(centre + radius * disc, _shaded(colour, 0.85), opacity)
    if opacity == 1:
        yield Patch(centre + radius * (0.6 * disc + [-0.15, 0.2, 0.01]), _shaded(colour, 1.1), opacity)


def _line(points: np.ndarray, thick: float, colour: str, opacity: float) -> Iterable[Patch]:
    """A curve in pieces of a few steps."""
    for start in range(0, len(points) - 1, 4):
        yield Patch(points[start : start + 5], colour, opacity, thick)


def _smooth(points: np.ndarray, closed: bool) -> np.ndarray:
    """A curve through points, with more points between few: each third of a step on the cubic of its neighbours."""
    if len(points) < 3 or len(points) > 72:
        return np.concatenate([points, points[:1]]) if closed else points
    ends = (points[-1:], points[:2]) if closed else (points[:1], points[-1:])
    a, b, c, d = (np.concatenate([ends[0], points, ends[1]])[n : n + len(points) - (not closed)] for n in range(4))
    shares = np.arange(3)[:, None, None] / 3
    bent = shares * (c - a + shares * (2 * a - 5 * b + 4 * c - d + shares * (3 * (b - c) + d - a)))
    return np.concatenate([(b + bent / 2).swapaxes(0, 1).reshape(-1, 3), c[-1:]])


def _towards(corners: np.ndarray) -> float:
    """How bright a mesh is: it darkens as it turns away from the viewer."""
    normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
    return float(0.7 + 0.35 * abs(normal[2]) / max(float(np.linalg.norm(normal)), 1e-12))


def _shaded(colour: str, bright: float) -> str:
    """A colour made darker, or lighter if the number is above 1."""
    parts = np.array([int(colour[start : start + 2], 16) for start in (1, 3, 5)])
    mixed = parts * bright if bright <= 1 else 255 - (255 - parts) * (2 - bright)
    return "#" + "".join(f"{round(float(part)):02x}" for part in mixed)


def _letters(cell: Table, axes: np.ndarray, scale: float, shift: np.ndarray) -> list[str]:
    """What is written in a cell, on its places."""
    places = _places(cell)
    written = []
    for text, body, point, *beside in cell["labels"]:
        matrix = axes @ places.get(body, np.eye(4))[:3]
        start, *tips = (np.array([point, *(beside[1] if beside[1:] else [])]) @ matrix[:, :3].T + matrix[:, 3])[:, :2]
        u, v = scale * start * [1, -1] + shift + _between([(tip - start) * [1, -1] for tip in tips])
        written.append(_text(text, u, v + 5, " text-anchor='middle' font-style='italic'"))
    return written


def _between(arrows: Sequence[np.ndarray]) -> np.ndarray:
    """From where arrows start to where their name stands: in the widest gap between them."""
    if not arrows:
        return np.zeros(2)
    angles = np.sort([np.arctan2(down, across) for across, down in arrows])
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi)).round(6)
    middle = angles[np.argmax(gaps)] + gaps.max() / 2
    return 15 * np.array([np.cos(middle), np.sin(middle)])


def _legend(legend: Sequence[Sequence[str]], top: float) -> tuple[list[str], float]:
    """Names and colours in rows below the drawing, and where they end."""
    drawn, x, y = [], 8.0, top + 16
    for name, colour in legend:
        wide = 40 + 7.4 * len(name)
        if x + wide > WIDTH:
            x, y = 8.0, y + 20
        drawn.append(f"<path color='{colour}' class='l' stroke-width='6' d='M{_short(x)} {_short(y)}h18'/>")
        drawn.append(_text(name, x + 26, y + 5))
        x += wide
    return drawn, y + 14 if legend else top


def _text(text: str, x: float, y: float, style: str = "") -> str:
    return f"<text x='{_short(x)}' y='{_short(y)}'{style}>{html.escape(text)}</text>"


def _short(x: float) -> str:
    """A number with one decimal, in as few letters as it takes."""
    tenths = round(10 * float(x))
    return str(tenths // 10) if tenths % 10 == 0 else f"{tenths / 10}".replace("0.", ".", 1 if abs(tenths) < 10 else 0)
