"""Rods and balls as shaded faces, which matplotlib can draw."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb

from kinlib.pictures.parts import Ball, Rod

__all__ = ["faces_of", "shaded"]

_LIGHT = np.array([0.35, -0.55, 0.76])
_SIDES = 14


def faces_of(part: Rod | Ball) -> np.ndarray:
    """The surface of a rod or a ball with a radius, as quadrangles of shape (k, 4, 3)."""
    radius = part.radius or 0.0
    if isinstance(part, Ball):
        return _ball(part.points()[0], radius)
    start, end = part.points()
    return _tube(start, end, radius)


def _tube(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """The surface of a round rod with closed ends, as quadrangles of shape (k, 4, 3)."""
    axis = end - start
    length = np.linalg.norm(axis)
    pieces = int(np.clip(np.ceil(length / (3 * radius)), 1, 40))
    side, other = _across(axis / length)
    turn = np.linspace(0, 2 * np.pi, _SIDES + 1)
    ring = radius * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other)
    rings = start + np.linspace(0, 1, pieces + 1)[:, None, None] * axis + ring
    caps = [np.broadcast_to(point, ring.shape) for point in (start, end)]
    return _quadrangles(np.concatenate([caps[:1], rings, caps[1:]]))


def _ball(centre: np.ndarray, radius: float) -> np.ndarray:
    """The surface of a ball, as quadrangles of shape (k, 4, 3)."""
    turn, height = np.linspace(0, 2 * np.pi, _SIDES + 1), np.linspace(0, np.pi, 8)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    up = np.array([0, 0, 1])
    return _quadrangles(centre + radius * (np.sin(height)[:, None, None] * ring + np.cos(height)[:, None, None] * up))


def _across(direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors perpendicular to a direction and to each other."""
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    return side, np.cross(direction, side)


def _quadrangles(grid: np.ndarray) -> np.ndarray:
    """The meshes of a grid of points, shape (rows, columns, 3)."""
    corners = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def shaded(faces: np.ndarray, colour: str, opacity: float) -> np.ndarray:
    """The colours of faces, shape (k, 4), darker where they turn away from the light."""
    normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
    brightness = 0.72 + 0.33 * np.abs(normals @ _LIGHT)
    shades = np.clip(brightness[:, None] * to_rgb(colour), 0, 1)
    return np.concatenate([shades, np.full((len(faces), 1), opacity)], axis=1)
