"""Parts and motions as plain tables of numbers, which the player reads."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from meshcat import Visualizer
from meshcat.geometry import MeshPhongMaterial

from kinlib.displacement import translation
from kinlib.dual_quaternion import DualQuaternion
from kinlib.pictures.parts import Part
from kinlib.pictures.shapes import Solid, Table, View
from kinlib.scalar import as_float

__all__ = ["DIGITS", "record", "tidy", "track"]

DIGITS = 5
"""Decimals that are kept of every number, in units of a scene's radius."""


class Recorder:
    """What meshcat takes for a window: it keeps the commands instead of sending them to a server."""

    def __init__(self) -> None:
        self.commands: list[Table] = []

    def send(self, command: Any) -> None:
        self.commands.append(command.lower())


def _commands(parts: Sequence[Part], view: View) -> list[Table]:
    """The commands of meshcat that draw the parts, each under the name of its body."""
    recorder = Recorder()
    visualizer = Visualizer(window=recorder)
    for number, part in enumerate(parts):
        for piece, solid in enumerate(part.solids(view)):
            place = visualizer[f"{part.body or 'fixed'}/{number}/{solid.group or 'on'}/{piece}"]
            place.set_object(solid.shape, _material(solid))
            place.set_transform(solid.matrix)
    return recorder.commands


def _material(solid: Solid) -> MeshPhongMaterial:
    return MeshPhongMaterial(color=int(solid.colour[1:], 16), opacity=solid.opacity)


def record(parts: Sequence[Part], view: View) -> Table:
    """The parts as meshcat draws them, in plain tables: every shape once, numbers rounded, no random names.

    Returns
    -------
    dict
        ``geometries`` and ``materials`` as three.js has them, and ``objects``: path, number of the geometry, number
        of the material, and the twelve entries of the matrix by rows.
    """
    commands = _commands(parts, view)
    geometries: list[str] = []
    materials: list[str] = []
    objects = []
    for drawn, moved in zip(commands[::2], commands[1::2], strict=True):
        geometry = _number_of(_without_uuid(drawn["object"]["geometries"][0]), geometries)
        material = _number_of(_paint(drawn["object"]["materials"][0]), materials)
        matrix = np.reshape(moved["matrix"], (4, 4)).T[:3]
        objects.append([drawn["path"].removeprefix("/meshcat/"), geometry, material, *tidy(matrix.ravel())])
    return {
        "geometries": [json.loads(text) for text in geometries],
        "materials": [json.loads(text) for text in materials],
        "objects": objects,
    }


def _number_of(value: Table, table: list[str]) -> int:
    """The place of a value in a table, to which it is added if it is new."""
    text = json.dumps(tidy(value), sort_keys=True)
    if text not in table:
        table.append(text)
    return table.index(text)


def _without_uuid(shape: Table) -> Table:
    return {key: value for key, value in shape.items() if key != "uuid"}


def _paint(material: Table) -> Table:
    """The colour of a material, and how it lets light through; the rest is as the viewer would have it."""
    kept = {"type": material["type"], "color": material["color"], "side": 2}
    return kept | {"opacity": material["opacity"], "transparent": True} if material["transparent"] else kept


def tidy(value: Any) -> Any:
    """The same value with rounded numbers, whole ones without a point, and lists instead of arrays."""
    if isinstance(value, Mapping):
        return {key: tidy(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [tidy(entry) for entry in value]
    if isinstance(value, (float, np.floating)):
        rounded = round(float(value), DIGITS)
        return int(rounded) if rounded == int(rounded) else rounded
    return int(value) if isinstance(value, np.integer) else value


def track(motion: DualQuaternion, view: View, digits: int) -> list[int]:
    """A motion as dual quaternions of length 10^digits in the units of the recording; their signs do not jump."""
    moved = translation(-view.centre) * motion * translation(view.centre)
    coefficients = as_float(moved.coeffs)
    coefficients = coefficients / np.linalg.norm(coefficients[:, :4], axis=1, keepdims=True)
    coefficients[:, 4:] /= view.radius
    agree = (coefficients[1:, :4] * coefficients[:-1, :4]).sum(axis=1)
    signs = np.cumprod(np.concatenate([[_sign(coefficients[0])], np.where(agree < 0, -1, 1)]))
    return np.round(coefficients * signs[:, None] * 10**digits).astype(int).ravel().tolist()


def _sign(coefficients: np.ndarray) -> float:
    """The sign of the first coefficient that is not zero."""
    return np.sign(coefficients[np.abs(coefficients) > 1e-9][0])
