"""Scenes that answer: the reader changes parameters, and what is seen follows by formulas recorded from kinlib.

A function of the parameters says what is to be seen, in the parts of which other scenes are made.  It is run once a
choice with scalars that write down what is done to them, see `kinlib.pictures.formula`; the page evaluates that, and
lays rods from point to point.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from kinlib.displacement import as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.pictures.colours import PIN, X_AXIS, Y_AXIS, Z_AXIS
from kinlib.pictures.controls import Control, Pad, Samples, Turn, combinations, starts
from kinlib.pictures.formula import record
from kinlib.pictures.page import page_of, shown
from kinlib.pictures.parts import Ball, Curve, Frame, Label, Part, Rod
from kinlib.pictures.recording import tidy
from kinlib.pictures.scene import Scene
from kinlib.pictures.shapes import Table, View
from kinlib.poses import as_pose
from kinlib.typing import PointLike

__all__ = ["ExplorableScene", "Seen", "Trail", "explorable_scene"]

NEAR = 1e-9
"""How near to a bad place nothing is drawn."""

CLOSE = 0.02
"""How near to a bad place the reader is told so."""

AGREE = 1e-6
"""How well the formulas must agree with the function at points by chance, some of which are near bad places."""

HEIGHT = "clamp(36rem, 84rem - 86vw, 64rem)"
"""Of a scene on a page: on a phone, what can be changed stands above it."""

SOME_T = (-3.0, 3.0)
"""Where the parameter of a turn is recorded and compared."""


@dataclass(frozen=True)
class Trail:
    """The path of a point over one turn; the point is given where it is at the parameter of the turn."""

    point: PointLike
    colour: str = PIN
    radius: float | None = None
    opacity: float = 1.0


@dataclass(frozen=True)
class Seen:
    """What is seen at some parameters.

    Parameters
    ----------
    parts : sequence of Rod, Ball, Curve, Frame, Label, Trail
        At all parameters as many, of the same kinds; their points may depend on the parameters.
    numbers : sequence of (str, sequence)
        The rows of a table: a name and numbers.
    axes : sequence of DualQuaternion
        Half-turns that a reader may ask for.
    marks : sequence of points of a plane
        Further points on the pad.
    bad : sequence of (number, str)
        How far the parameters are from where there is nothing to be seen, and what is wrong there.
    words : sequence of (number, str, str)
        What is said if a number is positive, and what if it is not.
    """

    parts: Sequence[Any] = ()
    numbers: Sequence[tuple[str, Sequence[Any]]] = ()
    axes: Sequence[DualQuaternion] = ()
    marks: Sequence[Sequence[Any]] = ()
    bad: Sequence[tuple[Any, str]] = ()
    words: Sequence[tuple[Any, str, str]] = ()

    def outputs(self) -> Table:
        """All numbers of it, to be recorded."""
        return {
            "points": [list(point) for part in self.parts for point in points_of(part)],
            "table": [list(row) for _, row in self.numbers],
            "axes": [list(h.coeffs) for h in self.axes],
            "marks": [list(point) for point in self.marks],
            "bad": [number for number, _ in self.bad],
            "signs": [number for number, _, _ in self.words],
        }


def points_of(part: Any) -> list[Any]:
    """The points on which a part depends: of a frame, its origin and the tips of axes of length 1."""
    if isinstance(part, Rod):
        return [part.start, part.end]
    if isinstance(part, Ball):
        return [part.centre]
    if isinstance(part, (Label, Trail)):
        return [part.point]
    if isinstance(part, Curve):
        return list(np.asarray(part.path))
    if isinstance(part, Frame):
        known = isinstance(part.pose, DualQuaternion)  # perhaps with roots in it, which only the page evaluates
        matrix = as_matrix(part.pose if known else as_pose(part.pose))
        return [matrix[:3, 3], *(matrix[:3, 3] + matrix[:3, n] for n in range(3))]
    raise TypeError(f"expected rods, balls, curves, frames, labels or trails, got {type(part).__name__}")


Show: TypeAlias = Callable[..., Seen | Sequence[Any]]


def explorable_scene(
    show: Show,
    controls: Sequence[Control],
    *,
    alt: str,
    turn: Turn | None = None,
    fixed: Sequence[Part] = (),
    columns: Sequence[tuple[str, float, int]] = (),
    caption: str = "",
    nothing: str = "Nothing to be seen here",
    legend: Sequence[tuple[str, str]] = (),
    recipe: Table | None = None,
    seconds: float = 9.0,
    view: tuple[float, float] | None = None,
    height: str = HEIGHT,
) -> ExplorableScene:
    """A scene whose parameters the reader changes.

    Parameters
    ----------
    show : callable
        Takes all parameters by name, the choices as whole numbers, and returns the parts that are seen, or `Seen`.
    controls : sequence of Pad, Slider, Samples, Choice
        What can be changed.
    alt : str
        A sentence that says what is to be seen.
    turn : Turn, optional
        A parameter that runs by itself, once around.
    fixed : sequence of Rod, Ball, Curve, Surface, Frame, Label
        What does not depend on the parameters.
    columns : sequence of (str, float, int)
        Of the table: a name, what its numbers are multiplied with when they are written, and how many decimals.
    caption : str
        Of the table.
    nothing : str
        What is said first where nothing can be seen.
    legend, seconds, view, height
        As in a `Scene`.
    recipe : dict, optional
        What was recorded, for those who ask the page.

    Raises
    ------
    ValueError
        If the function cannot be recorded, see `record`.

    Examples
    --------
    >>> from kinlib import act, i, j
    >>> from kinlib.pictures import Rod, Slider
    >>> scene = explorable_scene(
    ...     lambda a: [Rod([0, 0, 0], act(1 + a * i, [0, 0, 1]))],
    ...     [Slider("a", -1, 1, 0.5)],
    ...     alt="A rod is turned by a slider.",
    ... )
    >>> scene
    <ExplorableScene of a: A rod is turned by a slider.>
    """
    start = starts(controls)
    sights = [_Sight(show, choices, controls, turn) for choices in combinations(controls)]
    first = next(sight for sight in sights if all(start[name] == n for name, n in sight.choices.items()))
    slider = "Position along one turn"
    stage = _Stage(
        first.points(start), fixed, alt=alt, slider=slider, seconds=seconds, legend=legend, view=view
    )  # fmt: skip
    said = {"columns": list(columns), "caption": caption, "nothing": nothing, "recipe": recipe or {}}
    table = stage.table | _pace(turn) | {"explorer": said | _explorer(sights, stage, first.seen(start, 1.0))}
    pictured = Scene((*fixed, *first.still(start)), alt=alt, legend=legend, view=view).recording()
    return ExplorableScene(alt, tuple(start), table, height, pictured)


def _pace(turn: Turn | None) -> Table:
    """The frames of a turn, and what is written next to the slider."""
    frames = turn.frames if turn else 1
    return {"frames": frames, "captions": [f"{100 * n / frames:.0f} %" for n in range(frames)]}


@dataclass(frozen=True)
class _Sight:
    """What is seen for one way to choose."""

    show: Show
    choices: dict[str, int]
    controls: Sequence[Control]
    turn: Turn | None

    def __call__(self, **parameters: Any) -> Seen:
        found = self.show(**self.choices, **parameters)
        return found if isinstance(found, Seen) else Seen(tuple(found))

    def ranges(self) -> dict[str, tuple[float, float]]:
        found: dict[str, tuple[float, float]] = {}
        for control in self.controls:
            found |= control.ranges()
        return found | ({self.turn.name: SOME_T} if self.turn else {})

    def formula(self) -> str:
        """The formula of all numbers, as JavaScript."""
        return record(
            lambda **parameters: self(**parameters).outputs(), self.ranges(), rtol=AGREE, points=16
        ).javascript

    def seen(self, start: dict[str, float], angle: float) -> Seen:
        """What is seen at the start, at an angle of the turn."""
        parameters = {name: start[name] for name in self.ranges() if name in start}
        for control in self.controls:
            if isinstance(control, Samples):
                parameters |= control.at(self.choices, start[control.name])
        t = {self.turn.name: 1 / np.tan(angle / 2) if angle else 1e9} if self.turn else {}
        return self(**parameters, **t)

    def still(self, start: dict[str, float]) -> list[Part]:
        """The parts at the start, with the paths of points over one turn."""
        angles = self.turn.at(self.choices)[::2] if self.turn else [0.0]
        seen = [self.seen(start, angle).parts for angle in angles]
        return [
            Curve([parts[n].point for parts in seen], part.colour, part.radius, True, opacity=part.opacity)
            if isinstance(part, Trail)
            else part
            for n, part in enumerate(seen[-7 % len(seen)])
        ]

    def points(self, start: dict[str, float]) -> np.ndarray:
        """All points of the parts at the start, over one turn, shape (k, 3)."""
        angles = self.turn.at(self.choices)[::5] if self.turn else [0.0]
        seen = [self.seen(start, angle).outputs()["points"] for angle in angles]
        return np.array([[float(x) for x in point] for points in seen for point in points]).reshape(-1, 3)


class _Stage:
    """Where the scene is, how large, and what stands still in it."""

    def __init__(self, points: np.ndarray, fixed: Sequence[Part], **options: Any):
        room = [Label("", point) for point in points]
        self.table = Scene((*fixed, *room), **options).recording()
        (self.cell,) = self.table["cells"]
        self.view = View(np.array(self.cell["centre"]), self.cell["unit"])
        still = [self.view.place(part.points()).reshape(-1, 3) for part in fixed]
        self.kept = tidy(np.concatenate(still)) if still and sum(map(len, still)) < 200 else self.cell["hull"]

    def item(self, part: Any) -> Table:
        """How a part is drawn, but for its points."""
        kind = type(part).__name__.lower()
        kinds = {"ball": 0.025, "frame": 0, "label": 0, "rod": 0.012}
        radius = part.radius if not isinstance(part, (Frame, Label)) else None
        item = {
            "kind": kind, "count": len(points_of(part)), "radius": self.view.length(radius, kinds.get(kind, 0.007)),
            "colour": getattr(part, "colour", PIN), "opacity": getattr(part, "opacity", 1.0),
        }  # fmt: skip
        if isinstance(part, Frame):
            size = part.size or 0.18 * self.view.radius
            item |= {"size": size, "radius": part.radius * self.view.length(size, 0)}
        if isinstance(part, Curve):
            item |= {"closed": part.closed}
        return item


def _explorer(sights: Sequence[_Sight], stage: _Stage, example: Seen) -> Table:
    """What the page needs to follow the parameters, in full digits."""
    controls, turn = sights[0].controls, sights[0].turn
    start = starts(controls)
    items: list[Any] = []
    pictures: list[Any] = []
    formulas: list[str] = []
    lists = [_place_in(items, _items(sight.seen(start, 1.0), stage)) for sight in sights]
    which = [_place_in(formulas, sight.formula()) for sight in sights]
    turns: list[Any] = []
    paces = [_place_in(turns, np.round(turn.at(sight.choices), 7).tolist() if turn else [0]) for sight in sights]
    return {
        "inputs": list(sights[0].ranges()),
        "formulas": formulas, "formulaOf": which,
        "controls": [control.table() | _for_choices(control, sights, pictures) for control in controls],
        "pictures": pictures,
        "turn": turn.name if turn else "",
        "turns": turns, "turnOf": paces,
        "items": items, "itemsOf": lists, "triad": [X_AXIS, Y_AXIS, Z_AXIS], "steps": 96,
        "kept": stage.kept, "near": NEAR, "close": CLOSE,
        "bad": [text for _, text in example.bad],
        "words": [list(pair) for _, *pair in example.words],
        "rows": [name for name, _ in example.numbers],
    }  # fmt: skip


def _items(seen: Seen, stage: _Stage) -> list[Table]:
    """How all parts are drawn; letters get a place among those of the cell."""
    items = [stage.item(part) for part in seen.parts]
    for item, part in zip(items, seen.parts, strict=True):
        if isinstance(part, Label):
            item["label"] = _place_in(stage.cell["labels"], [part.text, "", [0, 0, 0], None, []])
    return items


def _for_choices(control: Control, sights: Sequence[_Sight], pictures: list[Any]) -> Table:
    """What of a control depends on the choices."""
    if isinstance(control, Pad):
        return {"pictures": [_place_in(pictures, control.picture(sight.choices)) for sight in sights]}
    return {"samples": [control.rows(sight.choices) for sight in sights]} if isinstance(control, Samples) else {}


def _place_in(known: list[Any], value: Any) -> int:
    """The place of a value in a list, to which it is added if it is new."""
    if value not in known:
        known.append(value)
    return known.index(value)


@dataclass(frozen=True, repr=False)
class ExplorableScene:
    """A scene with parameters that the reader changes."""

    alt: str
    names: tuple[str, ...]
    table: Table
    height: str = HEIGHT
    pictured: Table | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {', '.join(self.names)}: {self.alt}>"

    def recording(self) -> Table:
        """All that the page needs, ready to be written as JSON."""
        return self.table

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write one HTML file that works by itself, without a network."""
        path = Path(path)
        path.write_text(page_of(self.table, shared=False), encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        return shown(self.table, self.height, self.pictured)
