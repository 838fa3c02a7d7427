"""A linkage as it is drawn: colours, bars, and the joints between them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from kinlib.displacement import act, as_matrix
from kinlib.dual_quaternion import DualQuaternion
from kinlib.linkage import Linkage
from kinlib.poses import as_pose
from kinlib.scalar import as_float

__all__ = [
    "BASE", "COUPLER", "LINKS", "PIN", "X_AXIS", "Y_AXIS", "Z_AXIS", "Piece",
    "bars", "common_feet", "coupler_pieces", "extent", "floats", "holder", "in_floats", "joint", "lines_of",
    "link_colours", "link_names", "link_pieces", "linkage_pieces", "pin", "pose_matrices",
]  # fmt: skip

# Okabe & Ito's colours: told apart by colour-blind readers, and seen on white as on black.
BASE, COUPLER = "#808080", "#d55e00"
LINKS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9")
PIN = "#aab2bd"
X_AXIS, Y_AXIS, Z_AXIS = "#e5484d", "#3aa655", "#4a72f5"


def in_floats(linkage: Linkage) -> Linkage:
    """The same linkage with floats for its exact numbers: a drawing needs no more."""
    factors = [floats(f) for f in linkage.factors]
    parameters = tuple(as_float(t) for t in linkage.parameters)
    return Linkage(factors, linkage.joints, linkage.coupler, floats(linkage.home), parameters)


def floats(q: DualQuaternion) -> DualQuaternion:
    """The same dual quaternions with floats for coefficients."""
    return DualQuaternion(as_float(q.coeffs))


def link_colours(linkage: Linkage) -> tuple[str, ...]:
    """One colour a link: grey for the base, vermilion for the coupler, the others in order.

    Returns
    -------
    tuple of str
        Hexadecimal colours, link 0 first.
    """
    others = iter(LINKS)
    special = {0: BASE, linkage.coupler: COUPLER}
    return tuple(special.get(link) or next(others) for link in range(len(linkage)))


def link_names(linkage: Linkage) -> tuple[str, ...]:
    """What the links are called in a legend, link 0 first."""
    special = {0: "base (fixed)", linkage.coupler: "coupler"}
    return tuple(special.get(link, f"link {link}") for link in range(len(linkage)))


def bars(linkage: Linkage) -> np.ndarray:
    """The two ends of every link at home, on the axes that it joins.

    Link i joins the axes i and i + 1 (link 0 the last and the first).  Its ends are the feet of their common
    perpendicular.  Where these feet run far away, the bars go straight between points that lie close together;
    where all axes meet, they go between points at one distance from there.

    Returns
    -------
    numpy.ndarray, shape (n, 2, 3)
        In units of length; row i belongs to link i.
    """
    points, directions = lines_of(linkage.axes)
    near = _near_points(points, directions)
    feet = _feet(near, directions)
    origin = as_float(act(linkage.home, [0, 0, 0]))
    if _radius(near) <= 1e-9 * np.abs(np.concatenate([near, [origin]])).max():
        distance = np.linalg.norm(origin - near[0])
        near = near + (distance if distance > 1e-9 * np.abs(near).max() else 1.0) * directions
    straight = np.stack([np.roll(near, 1, axis=0), near], axis=1)
    return feet if 1e-6 < _radius(feet) / _radius(straight) <= 3 else straight


def lines_of(axes: DualQuaternion) -> tuple[np.ndarray, np.ndarray]:
    """A point and the unit direction of every axis, each of shape (n, 3), for rotations of shape (n,)."""
    coefficients = as_float(axes.coeffs)
    length = np.linalg.norm(coefficients[:, 1:4], axis=1, keepdims=True)
    directions, moments = coefficients[:, 1:4] / length, coefficients[:, 5:8] / length
    return np.cross(directions, moments), directions


def _near_points(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """One point on every axis, so that the sum of the squared distances around the loop is least."""
    n = len(points)
    sides = np.eye(n) - np.roll(np.eye(n), 1, axis=1)
    system = (sides[:, None, :] * directions.T).reshape(3 * n, n)
    along = np.linalg.lstsq(system, -(sides @ points).ravel(), rcond=1e-9)[0]
    return points + along[:, None] * directions


def _feet(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The feet of the common perpendicular of each axis and the next; near the points if parallel."""
    return np.array([common_feet(points[[k - 1, k]], directions[[k - 1, k]]) for k in range(len(points))])


def common_feet(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The feet of the common perpendicular of two lines, shape (2, 3); near the points if they are parallel."""
    system = np.stack([-directions[0], directions[1]], axis=1)
    along = np.linalg.lstsq(system, points[0] - points[1], rcond=1e-7)[0]
    return points + along[:, None] * directions


def _radius(points: np.ndarray) -> float:
    """Half of the longest side of the box about some points."""
    points = points.reshape(-1, 3)
    return np.ptp(points, axis=0).max() / 2


def extent(linkage: Linkage) -> float:
    """The size of a linkage for choosing thicknesses: the radius of the box about its bars at home.

    Returns
    -------
    float
        In units of length; 1 if the whole linkage is a point.
    """
    return float(_radius(bars(linkage))) or 1.0


def pose_matrices(poses) -> np.ndarray:
    """Poses of any kind as one array.

    Parameters
    ----------
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``

    Returns
    -------
    numpy.ndarray, shape (number of poses, 4, 4)

    Examples
    --------
    >>> pose_matrices([one, i])[:, 1, 1].tolist()
    [1.0, -1.0]
    """
    matrices = [as_float(as_matrix(as_pose(pose))) for pose in poses]
    return np.array(matrices).reshape(-1, 4, 4)


# ---- pieces ------------------------------------------------------------------------------------------


class Piece(NamedTuple):
    """A round rod from start to end, or a ball if these agree, that belongs to a link."""

    start: np.ndarray
    end: np.ndarray
    radius: float
    colour: str
    link: int


def linkage_pieces(linkage: Linkage, unit: float) -> list[Piece]:
    """All links of a linkage at home, with a sleeve at every end and a pin in every joint.

    Parameters
    ----------
    linkage : Linkage
    unit : float
        The length in which thicknesses are measured.
    """
    ends, directions = bars(linkage), lines_of(linkage.axes)[1]
    count = len(linkage)
    joints = [joint(directions[n], ends[n, 1], ends[(n + 1) % count, 0], unit) for n in range(count)]
    links = [
        piece
        for link, colour in enumerate(link_colours(linkage))
        for piece in link_pieces(joints[link - 1][1], joints[link][0], colour, link, unit)
    ]
    return links + [pin(before[1], after[1], n, unit) for n, (before, after) in enumerate(joints)]


def joint(direction: np.ndarray, before: np.ndarray, after: np.ndarray, unit: float) -> tuple:
    """Foot and sleeve, the latter of shape (2, 3), of the link before a joint and of the link after it.

    The joint is half-way between the feet.  Where these are close together, the bars end in the sleeves.
    """
    middle, gap = (before + after) / 2, (after - before) @ direction
    step = 0.1 * unit * (direction if gap >= 0 else -direction)
    sleeves = middle + np.array([[-1.03], [-0.03]]) * step, middle + np.array([[0.03], [1.03]]) * step
    feet = (before, after) if abs(gap) > 0.25 * unit else [sleeve.mean(axis=0) for sleeve in sleeves]
    return tuple(zip(feet, sleeves, strict=True))


def link_pieces(first: tuple, second: tuple, colour: str, link: int, unit: float) -> list[Piece]:
    """A bar from foot to foot, the sleeves, and an arm along the axis to each sleeve that is not at its foot."""
    radius = (0.03 if link else 0.042) * unit
    pieces = [Piece(first[0], second[0], radius, colour, link)]
    for foot, sleeve in (first, second):
        middle = sleeve.mean(axis=0)
        pieces.append(Piece(*sleeve, 0.065 * unit, colour, link))
        if np.linalg.norm(foot - middle) > radius:
            pieces += [Piece(foot, middle, radius, colour, link), Piece(foot, foot, radius, colour, link)]
    return pieces


def pin(before: np.ndarray, after: np.ndarray, link: int, unit: float) -> Piece:
    """The pin through two sleeves, a little longer than both."""
    step = 0.4 * (before[1] - before[0])
    return Piece(before[0] - step, after[1] + step, 0.025 * unit, PIN, link)


def coupler_pieces(linkage: Linkage, point: np.ndarray, unit: float) -> list[Piece]:
    """Thin rods at home from the coupler's bar to the origin of its frame, and on to a point, shape (3,)."""
    origin = as_float(act(linkage.home, [0, 0, 0]))
    start, end = bars(linkage)[linkage.coupler]
    return holder((_nearest(start, end, origin), origin, point), linkage.coupler, unit)


def holder(stations, link: int, unit: float) -> list[Piece]:
    """Thin rods from station to station in the coupler's colour, and a ball at the last."""
    rods = [Piece(a, b, 0.018 * unit, COUPLER, link) for a, b in pairwise(stations) if np.any(a != b)]
    return [*rods, Piece(stations[-1], stations[-1], 0.035 * unit, COUPLER, link)]


def _nearest(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The point of a segment that is nearest to a given point."""
    bar = end - start
    length = bar @ bar
    return start + (np.clip((point - start) @ bar / length, 0, 1) if length > 0 else 0) * bar
