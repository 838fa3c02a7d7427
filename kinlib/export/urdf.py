"""A linkage for robot programs: a URDF tree that is cut at the last joint, and what closes it in a file beside it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kinlib.export.bodies import Bodies
from kinlib.export.xml import child, text_of
from kinlib.linkage import Linkage
from kinlib.typing import Array, ArrayLike

__all__ = ["as_urdf", "closing_constraint", "save_urdf"]

DENSITY = 1000.0
"""Of the bars, in kilograms per cubic metre."""


def as_urdf(
    linkage: Linkage,
    *,
    name: str = "linkage",
    scale: float = 1.0,
    bars: ArrayLike | None = None,
    thickness: float | None = None,
) -> str:
    """The linkage as URDF, in metres: link 0 is the base, ``joint 1``, …, ``joint n − 1`` are continuous joints.

    URDF knows trees only: the last joint is left out, and :func:`closing_constraint` says where it is.  Each link's
    frame is at a point of the joint before it, at home parallel to the fixed frame; angles are 0 at t = ∞ and are those
    of :meth:`Linkage.joint_angles <kinlib.Linkage.joint_angles>`.

    Parameters
    ----------
    linkage : Linkage
        A single one.
    name : str
        Of the robot.
    scale : float
        How many metres the unit of length is.
    bars : array_like, shape (n, m, 3), optional
        As for :meth:`Linkage.clearance <kinlib.Linkage.clearance>`.
    thickness : float, optional
        Of the bars, in metres; by default a thirtieth of the size.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> text = as_urdf(bennett_linkage(*gallery.THREE_POSES))
    >>> text.count("<link "), text.count("<joint ")
    (4, 3)
    """
    bodies = Bodies.of(linkage, scale, bars)
    radius = (bodies.size / 15 if thickness is None else thickness) / 2
    root = child(None, "robot", name=name)
    origins = _origins(bodies)
    for n in range(bodies.count):
        pieces = bodies.pieces(n, radius / 100) or [(bodies.bars[n, 0], bodies.bars[n, 0] + [0, 0, radius])]
        _add_link(root, f"link_{n}", [(a - origins[n], b - origins[n]) for a, b in pieces], radius)
    for n in range(1, bodies.count):
        joint = child(root, "joint", name=f"joint_{n}", type="continuous")
        child(joint, "parent", link=f"link_{n - 1}")
        child(joint, "child", link=f"link_{n}")
        child(joint, "origin", xyz=origins[n] - origins[n - 1], rpy=(0.0, 0.0, 0.0))
        child(joint, "axis", xyz=bodies.directions[n - 1])
    return text_of(root)


def _origins(bodies: Bodies) -> Array:
    """The origins of the links' frames at home: of link 0 that of the fixed frame."""
    return np.concatenate([np.zeros((1, 3)), bodies.anchors[:-1]])


def _add_link(root: ElementTree.Element, name: str, pieces: list[tuple[Array, Array]], radius: float) -> None:
    link = child(root, "link", name=name)
    masses = [DENSITY * np.pi * radius**2 * float(np.linalg.norm(b - a)) for a, b in pieces]
    centre = np.average([(a + b) / 2 for a, b in pieces], axis=0, weights=masses)
    inertial = child(link, "inertial")
    child(inertial, "origin", xyz=centre, rpy=(0.0, 0.0, 0.0))
    child(inertial, "mass", value=sum(masses))
    child(inertial, "inertia", **_moments(pieces, masses, centre, radius))
    for kind in ("visual", "collision"):
        for a, b in pieces:
            shape = child(link, kind)
            child(shape, "origin", xyz=(a + b) / 2, rpy=_roll_pitch_yaw(b - a))
            child(child(shape, "geometry"), "cylinder", radius=radius, length=float(np.linalg.norm(b - a)))


def _moments(pieces: list[tuple[Array, Array]], masses: list[float], centre: Array, radius: float) -> dict[str, float]:
    """The inertia of cylinders about their common centre of mass."""
    total = np.zeros((3, 3))
    for mass, (a, b) in zip(masses, pieces, strict=True):
        along, arm = b - a, (a + b) / 2 - centre
        length = float(np.linalg.norm(along))
        u = np.outer(along, along) / length**2
        across = mass * (3 * radius**2 + length**2) / 12
        total += across * np.eye(3) + (mass * radius**2 / 2 - across) * u
        total += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return {f"i{'xyz'[m]}{'xyz'[n]}": float(total[m, n]) for m in range(3) for n in range(m, 3)}


def _roll_pitch_yaw(along: Array) -> tuple[float, float, float]:
    """The angles of URDF that turn z to a direction."""
    x, y, z = along / np.linalg.norm(along)
    return 0.0, float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x))


def closing_constraint(linkage: Linkage, *, scale: float = 1.0, bars: ArrayLike | None = None) -> dict[str, Any]:
    """The hinge that closes the URDF's tree: the two links, and a point and the direction of its axis in both frames.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> hinge = closing_constraint(bennett_linkage(*gallery.THREE_POSES))
    >>> hinge["type"], hinge["parent"]["link"], hinge["child"]["link"]
    ('revolute', 'link_3', 'link_0')
    """
    bodies = Bodies.of(linkage, scale, bars)
    origins, last = _origins(bodies), bodies.count - 1
    ends = {
        part: {
            "link": f"link_{n}",
            "point": (bodies.anchors[-1] - origins[n]).tolist(),
            "axis": bodies.directions[-1].tolist(),
        }
        for part, n in (("parent", last), ("child", 0))
    }
    return {"name": f"joint_{bodies.count}", "type": "revolute", **ends}


def save_urdf(linkage: Linkage, path: str | os.PathLike[str], **options: Any) -> None:
    """Write ``path`` with :func:`as_urdf`, and beside it the closing hinge with the ending ``.loop.json``.

    Parameters
    ----------
    linkage : Linkage
    path : str or path
    **options
        As for :func:`as_urdf`.
    """
    path, placed = Path(path), {key: options[key] for key in ("scale", "bars") if key in options}
    path.write_text(as_urdf(linkage, **options), encoding="utf-8")
    constraint = json.dumps({"loop": closing_constraint(linkage, **placed)}, indent=1) + "\n"
    path.with_suffix(".loop.json").write_text(constraint, encoding="utf-8")
