"""A linkage for MuJoCo: a tree of hinges, closed by equality constraints."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from kinlib.export.bodies import Bodies
from kinlib.export.xml import child, text_of
from kinlib.linkage import Linkage
from kinlib.typing import ArrayLike

__all__ = ["as_mjcf"]


def as_mjcf(
    linkage: Linkage,
    *,
    name: str = "linkage",
    scale: float = 1.0,
    bars: ArrayLike | None = None,
    thickness: float | None = None,
    drive: int | None = 0,
    gravity: bool = False,
) -> str:
    """The linkage as a model of MuJoCo, MJCF, in metres.

    Link 0 stands still; the links behind it hang on one another by the hinges ``joint 1``, …, ``joint n − 1``.  The
    last link is tied to link 0 at two points of the last axis.  All hinges are at 0 at t = ∞ and turn as
    :meth:`Linkage.joint_angles <kinlib.Linkage.joint_angles>` says.  Bars do not collide.

    Parameters
    ----------
    linkage : Linkage
        A single one.
    name : str
        The name of the model.
    scale : float
        How many metres the unit of length is.
    bars : array_like, shape (n, m, 3), optional
        As for :meth:`Linkage.clearance <kinlib.Linkage.clearance>`.
    thickness : float, optional
        Of the bars, in metres; by default a thirtieth of the size.
    drive : int or None
        The number of the joint, from 0, that has a motor which holds a speed; not the last one.
    gravity : bool
        Whether things fall, against z.

    Returns
    -------
    str
        The text of an XML file.

    Examples
    --------
    >>> from kinlib import bennett_linkage, gallery
    >>> text = as_mjcf(bennett_linkage(*gallery.THREE_POSES))
    >>> [text.count(word) for word in ("<body ", "<joint ", "<connect ")]
    [4, 3, 2]
    """
    bodies = Bodies.of(linkage, scale, bars)
    if drive is not None and not 0 <= drive < bodies.count - 1:
        raise ValueError(f"expected a joint to drive among 0, …, {bodies.count - 2}, got {drive!r}")
    radius = (bodies.size / 15 if thickness is None else thickness) / 2
    root = child(None, "mujoco", model=name)
    child(root, "compiler", angle="radian", autolimits="true")
    child(root, "option", timestep=5e-4, gravity=(0, 0, -9.81 if gravity else 0), integrator="implicitfast")
    child(child(root, "default"), "geom", contype=0, conaffinity=0, density=1000)
    _add_bodies(child(root, "worldbody"), bodies, radius)
    _close(child(root, "equality"), bodies)
    if drive is not None:
        _add_motor(root, f"joint {drive + 1}", _inertia(bodies, radius))
    return text_of(root)


def _add_bodies(world: ElementTree.Element, bodies: Bodies, radius: float) -> None:
    parent = child(world, "body", name="link 0")
    _add_bar(parent, bodies, 0, radius)
    for n in range(1, bodies.count):
        parent = child(parent, "body", name=f"link {n}")
        place = {"pos": bodies.anchors[n - 1], "axis": bodies.directions[n - 1]}
        child(parent, "joint", name=f"joint {n}", type="hinge", **place)
        _add_bar(parent, bodies, n, radius)


def _add_bar(body: ElementTree.Element, bodies: Bodies, link: int, radius: float) -> None:
    """Capsules from point to point; a ball where the bar has no length."""
    pieces = bodies.pieces(link, radius / 100)
    for a, b in pieces:
        child(body, "geom", type="capsule", fromto=[*a, *b], size=radius)
    if not pieces:
        child(body, "geom", type="sphere", pos=bodies.bars[link, 0], size=radius)


def _close(equality: ElementTree.Element, bodies: Bodies) -> None:
    """Two points of the last axis, in the last link and in link 0; stiff, but not so that steps must be tiny."""
    for sign in (-1, 1):
        point = bodies.anchors[-1] + sign * bodies.size / 2 * bodies.directions[-1]
        stiff = {"solref": (0.002, 1.0), "solimp": (0.99, 0.9999, 1e-4, 0.5, 2.0)}
        child(equality, "connect", body1=f"link {bodies.count - 1}", body2="link 0", anchor=point, **stiff)


def _inertia(bodies: Bodies, radius: float) -> float:
    """Of the whole linkage about its middle, about: so strong is the motor."""
    length = np.linalg.norm(np.diff(bodies.bars, axis=1), axis=-1).sum() + 2 * radius * bodies.count
    return float(1000 * np.pi * radius**2 * length * bodies.size**2)


def _add_motor(root: ElementTree.Element, joint: str, inertia: float) -> None:
    child(child(root, "actuator"), "velocity", name="drive", joint=joint, kv=200 * inertia)
