"""Moving scenes on a page: bodies carried by displacements, recorded without a server and played offline.

A `Scene` is made of parts, some of them carried by bodies that move.  Shown in a notebook it embeds a small
player; ``scene.save("x.html")`` writes one file that plays by itself.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion
from kinlib.pictures.page import page_of, shown
from kinlib.pictures.parts import Frame, Label, Part
from kinlib.pictures.recording import DIGITS, record, tidy, track
from kinlib.pictures.shapes import Table, View
from kinlib.scalar import as_float

__all__ = ["Scene", "SceneGrid"]


@dataclass(frozen=True, kw_only=True, repr=False)
class Playable(ABC):
    """What can be shown on a page and saved to a file."""

    alt: str
    slider: str = "Time"
    seconds: float = 9.0
    height: str = "28rem"
    captions: Sequence[str] = ()
    legend: Sequence[tuple[str, str]] = ()
    view: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not self.alt.strip():
            raise ValueError("expected alt, a sentence that says what is to be seen")
        if len(self.captions) not in (0, self.frames):
            raise ValueError(f"expected {self.frames} captions, one a frame, got {len(self.captions)}")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.frames} frames: {self.alt}>"

    @property
    @abstractmethod
    def frames(self) -> int:
        """The number of frames; 1 if nothing moves."""

    @abstractmethod
    def cells(self) -> list[Table]:
        """The views that the page shows next to each other."""

    def recording(self) -> Table:
        """All that the player needs, ready to be written as JSON."""
        cells = self.cells()
        view = self.view or _viewpoint([cell["hull"] for cell in cells])
        return tidy({
            "alt": self.alt, "slider": self.slider, "seconds": self.seconds, "frames": self.frames,
            "captions": self.captions, "legend": self.legend, "view": view, "cells": cells,
        })  # fmt: skip

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write one HTML file that plays by itself, without a network.

        Returns
        -------
        pathlib.Path
            Where it was written.
        """
        path = Path(path)
        path.write_text(page_of(self.recording(), shared=False), encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        return shown(self.recording(), self.height)


@dataclass(frozen=True, repr=False)
class Scene(Playable):
    """Parts in space, some of them carried by bodies that move.

    Parameters
    ----------
    parts : sequence of Rod, Ball, Curve, Surface, Frame, Label
    motions : mapping of str to DualQuaternion, shape (frames,)
        The displacement of every body from where its parts are given, at every frame; after the last comes the
        first again.
    alt : str
        A sentence that says what is to be seen, for those who cannot see it.
    captions : sequence of str, optional
        What is written next to the slider, one entry a frame.
    legend : sequence of (str, str), optional
        Pairs of a name and a colour.
    slider : str
        What the slider stands for.
    seconds : float
        How long one turn takes.
    view : (float, float), optional
        Azimuth and elevation of the direction towards the viewer, in degrees; chosen to show most if not given.
    height : str
        Of the scene on a page, in units of CSS.

    Examples
    --------
    >>> from kinlib.pictures import Rod
    >>> angles = np.arange(0, np.pi, np.pi / 12)
    >>> turns = DualQuaternion([[np.cos(x), 0, 0, np.sin(x), 0, 0, 0, 0] for x in angles])
    >>> hand = Rod([0, 0, 0], [1, 0, 0], body="hand")
    >>> Scene([hand], {"hand": turns}, alt="A rod turns about one of its ends.")
    <Scene of 12 frames: A rod turns about one of its ends.>
    """

    parts: Sequence[Part] = ()
    motions: Mapping[str, DualQuaternion] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", tuple(self.parts))
        lengths = {motion.shape for motion in self.motions.values()}
        if len(lengths) > 1 or any(len(shape) != 1 for shape in lengths):
            raise ValueError(f"expected motions of one shape (frames,), got {sorted(lengths)}")
        unknown = {part.body for part in self.parts if part.body} - set(self.motions)
        if unknown:
            raise ValueError(f"no motion is given for {', '.join(sorted(unknown))}")
        super().__post_init__()

    @property
    def frames(self) -> int:
        """The number of frames; 1 if nothing moves."""
        return next((motion.shape[0] for motion in self.motions.values()), 1)

    def with_parts(self, *parts: Part) -> Scene:
        """The same scene with more parts in it."""
        return replace(self, parts=(*self.parts, *parts))

    def cells(self) -> list[Table]:
        return [self.cell()]

    def cell(self, name: str = "", digits: int = DIGITS) -> Table:
        """One view: what is in it, how it moves, where its letters stand and when its frames light up."""
        view, hull = self._bounds()
        labels = [
            (text, part.body, view.place(part.points()[0]), *_beside(part, view))
            for part in self.parts
            if isinstance(part, Frame | Label) and (text := _written(part))
        ]
        lights = [
            (f"{part.body or 'fixed'}/{number}", part.lights_at, part.name)
            for number, part in enumerate(self.parts)
            if isinstance(part, Frame) and part.lights_at is not None
        ]
        return {
            "name": name, "unit": view.radius, "centre": view.centre, "hull": hull,
            "labels": labels, "lights": lights,
            "tracks": {body: track(motion, view, digits) for body, motion in self.motions.items()},
            **record(self.parts, view),
        }  # fmt: skip

    def _bounds(self) -> tuple[View, np.ndarray]:
        """The view of the whole motion, and its outermost points in the units of the recording."""
        points = np.concatenate([self._swept(part) for part in self.parts] or [np.zeros((1, 3))])
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        radius = float(np.linalg.norm(points - centre, axis=1).max()) or 1.0
        view = View(centre, radius)
        sized = [self._swept(_sized(part, 0.18 * radius)) for part in self.parts]
        return view, _outermost(view.place(np.concatenate(sized or [points])))

    def _swept(self, part: Part) -> np.ndarray:
        """The points of a part in all its positions, shape (k, 3)."""
        points = part.points()
        if not part.body:
            return points
        return as_float(act(self.motions[part.body][:, None], points)).reshape(-1, 3)


def _written(part: Frame | Label) -> str:
    """What is written next to a part."""
    return part.name if isinstance(part, Frame) else part.text


def _beside(part: Frame | Label, view: View) -> tuple[int | None, list[list[float]]]:
    """When letters are lit, and the tips of the arrows from which they keep away."""
    return (part.lights_at, part.tips(view).tolist()) if isinstance(part, Frame) else (None, [])


def _sized(part: Part, size: float) -> Part:
    """The part as it is drawn: a frame without a size of its own has a given one."""
    return replace(part, size=size) if isinstance(part, Frame) and part.size is None else part


@dataclass(frozen=True, repr=False)
class SceneGrid(Playable):
    """Scenes next to each other, which move together and are turned together.

    Parameters
    ----------
    scenes : sequence of Scene
        All of the same number of frames.
    names : sequence of str
        What is written in the corner of each.
    alt, captions, legend, slider, seconds, view, height
        As in a `Scene`; those of the single scenes are not used.
    """

    scenes: Sequence[Scene]
    names: Sequence[str]

    def __post_init__(self) -> None:
        if len(self.names) != len(self.scenes):
            raise ValueError(f"expected {len(self.scenes)} names, one a scene, got {len(self.names)}")
        frames = sorted({scene.frames for scene in self.scenes})
        if len(frames) != 1:
            raise ValueError(f"expected scenes of the same number of frames, got {frames}")
        super().__post_init__()

    @property
    def frames(self) -> int:
        return self.scenes[0].frames

    def cells(self) -> list[Table]:
        return [scene.cell(name, DIGITS - 1) for scene, name in zip(self.scenes, self.names, strict=True)]


def _outermost(points: np.ndarray) -> np.ndarray:
    """The points that lie farthest in 26 directions, without repetition."""
    grid = np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(-1, 3)
    farthest = np.argmax((points @ grid[np.any(grid != 0, axis=1)].T).round(6), axis=0)
    return points[np.unique(farthest)]


def _viewpoint(hulls: Sequence[np.ndarray]) -> tuple[int, int]:
    """The direction from above, in degrees, from which the hulls look largest on the whole."""
    directions = [(azimuth, elevation) for elevation in (22, 38) for azimuth in range(-180, 180, 15)]
    wide = 2.0 if len(hulls) == 1 else 1.25
    return max(directions, key=lambda direction: sum(_apparent_size(hull, direction, wide) for hull in hulls))


def _apparent_size(hull: np.ndarray, direction: tuple[float, float], wide: float) -> float:
    """The logarithm of the area that points cover when they are seen from a direction, up to a constant.

    They are as large as a window lets them be that is so many times as wide as high.
    """
    azimuth, elevation = np.radians(direction)
    right = [-np.sin(azimuth), np.cos(azimuth), 0]
    over = [-np.sin(elevation) * np.cos(azimuth), -np.sin(elevation) * np.sin(azimuth), np.cos(elevation)]
    seen = hull @ np.transpose([right, over])
    spread = seen - seen.mean(axis=0)
    scale = 1 / max(float((np.ptp(seen, axis=0) / [wide, 1]).max()), 1e-3)
    return round(float(np.log(np.linalg.det(spread.T @ spread) * scale**4 + 1e-6)), 6)
