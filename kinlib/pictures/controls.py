"""What a reader can change in a scene: a point of a plane, a number, one of several things, and time."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from kinlib.pictures.shapes import Table
from kinlib.typing import ArrayLike

__all__ = ["Choice", "Control", "Pad", "Samples", "Slider", "Turn"]

Range: TypeAlias = tuple[float, float]

DOTS, COLOURS = 160, 64
"""Of a pad's picture: dots per inch, and how many colours it has."""


@dataclass(frozen=True)
class Pad:
    """Two parameters, the coordinates of a point that is dragged in a plane.

    Parameters
    ----------
    names : (str, str)
        What the parameters are called.
    x, y : (float, float)
        Between which numbers they run.
    start : (float, float)
        Where the point is at first.
    label : str
        What the point is, in words.
    dot : str
        The letters that are written next to it.
    draw : callable, optional
        Draws what lies under the point: ``draw(axes, **choices)``, on axes of matplotlib that fill the pad.
    marks : sequence of str
        What further points are called, which the function gives as ``marks``.
    """

    names: tuple[str, str]
    x: Range
    y: Range
    start: tuple[float, float]
    label: str = "point"
    dot: str = ""
    draw: Callable[..., None] | None = None
    marks: Sequence[str] = ()

    def table(self) -> Table:
        """For the page."""
        return {
            "kind": "pad", "names": list(self.names), "label": self.label, "dot": self.dot,
            "limits": [list(self.x), list(self.y)], "start": [float(x) for x in self.start], "marks": list(self.marks),
        }  # fmt: skip

    def ranges(self) -> dict[str, Range]:
        """The ranges of the parameters."""
        return dict(zip(self.names, (self.x, self.y), strict=True))

    def picture(self, choices: dict[str, int]) -> str:
        """What lies under the point, as the address of a picture that fills the pad."""
        figure = plt.figure(figsize=(2.6, 2.6 * (self.y[1] - self.y[0]) / (self.x[1] - self.x[0])))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=self.x, ylim=self.y)
        ax.set_axis_off()
        if self.draw is not None:
            self.draw(ax, **choices)
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=DOTS, transparent=True)
        plt.close(figure)
        small = io.BytesIO()
        Image.open(out).quantize(COLOURS, Image.Quantize.FASTOCTREE).save(small, format="png", optimize=True)
        return "data:image/png;base64," + base64.b64encode(small.getvalue()).decode()


@dataclass(frozen=True)
class Slider:
    """A parameter that runs from one number to another; the unit is written after its value."""

    name: str
    low: float
    high: float
    start: float
    label: str = ""
    unit: str = ""

    def table(self) -> Table:
        """For the page."""
        return {
            "kind": "slider", "name": self.name, "label": self.label or self.name,
            "limits": [self.low, self.high], "start": float(self.start), "unit": self.unit,
        }  # fmt: skip

    def ranges(self) -> dict[str, Range]:
        """The range of the parameter."""
        return {self.name: (self.low, self.high)}


@dataclass(frozen=True)
class Samples:
    """A slider that stops at some values only, for which further parameters were computed before.

    What is seen depends on these, by their names; the page knows them in full only where the slider stops.

    Parameters
    ----------
    name : str
        What the slider is called.
    values : sequence of float
        Where it stops, in ascending order.
    samples : mapping of str to array_like, shape (..., values)
        The further parameters, with one axis for each choice of the scene before that of the values.
    start : float
        At which of the values it is at first.
    """

    name: str
    values: Sequence[float]
    samples: Mapping[str, ArrayLike]
    start: float
    label: str = ""
    unit: str = ""

    def __post_init__(self) -> None:
        values = np.asarray(self.values, dtype=float)
        if len(values) < 2 or not (np.diff(values) > 0).all():
            raise ValueError(f"expected two values at least, in ascending order, got {self.values}")
        if self.start not in values:
            raise ValueError(f"expected a start among the values, got {self.start}")
        shapes = {name: np.asarray(row).shape for name, row in self.samples.items()}
        wrong = {name: shape for name, shape in shapes.items() if shape[-1:] != values.shape}
        if wrong:
            raise ValueError(f"expected samples of shape (..., {len(values)}), one a value, got {wrong}")

    def table(self) -> Table:
        """For the page."""
        return {
            "kind": "slider", "name": self.name, "label": self.label or self.name, "unit": self.unit,
            "limits": [float(self.values[0]), float(self.values[-1])], "start": float(self.start),
            "values": [float(value) for value in self.values], "sampled": list(self.samples),
        }  # fmt: skip

    def ranges(self) -> dict[str, Range]:
        """The ranges of the further parameters."""
        rows = {name: np.asarray(row, dtype=float) for name, row in self.samples.items()}
        return {name: (float(row.min()), float(row.max())) for name, row in rows.items()}

    def rows(self, choices: dict[str, int]) -> list[list[float]]:
        """The further parameters for one way to choose, value by value, in twelve digits."""
        picked = [np.asarray(row, dtype=float)[tuple(choices.values())] for row in self.samples.values()]
        return [[float(f"{x:.12g}") for x in row] for row in np.transpose(picked)]

    def at(self, choices: dict[str, int], value: float) -> dict[str, float]:
        """The further parameters where the slider stops."""
        place = int(np.argmin(np.abs(np.asarray(self.values) - value)))
        return dict(zip(self.samples, self.rows(choices)[place], strict=True))


@dataclass(frozen=True)
class Choice:
    """A parameter that is the number 0, 1, … of one of several options, which have names.

    Parameters
    ----------
    name : str
        What the parameter is called.
    options : sequence of str
        The names.
    start : int
        The number of the option that is chosen at first.
    label : str
        What is written next to it.
    moves : sequence of (str, sequence of int)
        If given, the reader has buttons instead of a list: what is written on each, and to which option it leads from
        the options 0, 1, ….
    """

    name: str
    options: Sequence[str]
    start: int = 0
    label: str = ""
    moves: Sequence[tuple[str, Sequence[int]]] = ()

    def __post_init__(self) -> None:
        numbers = range(len(self.options))
        wrong = [text for text, to in self.moves if len(to) != len(numbers) or not set(to) <= set(numbers)]
        if wrong:
            raise ValueError(f"expected {len(numbers)} numbers of options for a move, one an option; not so: {wrong}")

    def table(self) -> Table:
        """For the page."""
        return {
            "kind": "choice", "name": self.name, "label": self.label or self.name,
            "options": list(self.options), "start": self.start,
            "moves": [[text, [int(n) for n in to]] for text, to in self.moves],
        }  # fmt: skip

    def ranges(self) -> dict[str, Range]:
        """A choice has no range: the function is recorded for each option."""
        return {}


@dataclass(frozen=True)
class Turn:
    """A parameter t that runs by itself: t = cot(½ angle), once around.

    Parameters
    ----------
    name : str
        What the parameter is called.
    angles : callable, optional
        ``angles(**choices)`` gives the angles at all frames, in radians, shape (frames,); even ones if not given.
    frames : int
        How many there are.
    """

    name: str = "t"
    angles: Callable[..., np.ndarray] | None = None
    frames: int = 120

    def at(self, choices: dict[str, int]) -> np.ndarray:
        """The angles at all frames."""
        if self.angles is None:
            return np.linspace(0, 2 * np.pi, self.frames, endpoint=False)
        return np.asarray(self.angles(**choices), dtype=float)


Control: TypeAlias = Pad | Slider | Samples | Choice


def combinations(controls: Sequence[Control]) -> Iterator[dict[str, int]]:
    """All ways to choose, the last choice running fastest."""
    choices = [control for control in controls if isinstance(control, Choice)]
    for picked in product(*(range(len(choice.options)) for choice in choices)):
        yield dict(zip((choice.name for choice in choices), picked, strict=True))


def starts(controls: Sequence[Control]) -> dict[str, float]:
    """Where all parameters are at first."""
    found: dict[str, float] = {}
    for control in controls:
        if isinstance(control, Pad):
            found |= dict(zip(control.names, map(float, control.start), strict=True))
        else:
            found[control.name] = control.start
    return found
