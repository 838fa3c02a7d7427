"""Moving scenes of dyads and linkages."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinlib.displacement import act, as_pose
from kinlib.dual_quaternion import DualQuaternion, one
from kinlib.parts import INK, Ball, Curve, Frame, Label, Rod, Surface
from kinlib.player import Scene, SceneGrid, static_files
from kinlib.scalar import as_float
from kinlib.skeleton import (
    BASE,
    COUPLER,
    LINKS,
    bars,
    common_feet,
    extent,
    floats,
    in_floats,
    lines_of,
    link_colours,
    link_names,
    one_turn,
    parameters_of,
)

__all__ = [
    "Ball", "Curve", "Frame", "Label", "Rod", "Scene", "SceneGrid", "Surface",
    "dyad_scene", "linkage_scene", "linkages_side_by_side", "static_files",
]  # fmt: skip


def linkage_scene(
    linkage, poses=(), *, alt, point=(0, 0, 0), parameters=None, places=None, names=None, frames=90, **options
) -> Scene:
    """A linkage that makes one turn after another, through the poses.

    Links are bars along the common perpendiculars of their axes, joints are sleeves about the axes.  The coupler
    carries its frame, which passes through the poses; each lights up when it is reached.

    Parameters
    ----------
    linkage : Linkage
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``
        Poses that the coupler visits.
    alt : str
        A sentence that says what is to be seen.
    point : array_like, shape (3,)
        The point of the coupler's frame whose path is drawn, in units of length; its origin if not given.
    parameters : sequence of float, optional
        Where along the motion the poses are; found if not given.
    places : sequence of int, optional
        At which frames the poses are reached; as an even pace has it if not given.
    names : sequence of str, optional
        What the poses are called; p₀, p₁, … if not given.
    frames : int
        How many positions are recorded, one of them at each pose.
    **options
        More of what a `Scene` takes: ``seconds``, ``view``, ``height``.

    Returns
    -------
    Scene

    Raises
    ------
    ValueError
        If the coupler does not visit one of the poses.
    """
    linkage = in_floats(linkage)
    stops = parameters_of(linkage, poses) if parameters is None else parameters
    t, places = one_turn(linkage, frames, stops, places)
    path = as_float(act(linkage.coupler_motion(t), point))
    unit = max(extent(linkage), np.ptp(path, axis=0).max() / 2)
    moves = linkage.link_displacements(t)
    return Scene(
        parts=[
            *_links(linkage, unit),
            *_coupler(linkage, path[0], unit),
            Curve(path, COUPLER, 0.012 * unit, closed=True),
            *_reached(poses, places, unit, names),
        ],
        motions={_body(n): moves[:, n] for n in range(1, moves.shape[1])},
        captions=[f"t = {_short(x)}" for x in t],
        legend=[*zip(link_names(linkage), link_colours(linkage), strict=True)],
        alt=alt,
        slider="Position along one turn",
        **options,
    )


def _body(link: int) -> str:
    return f"link {link}" if link else ""


def _links(linkage, unit: float) -> list:
    """The links, and a pin in every joint."""
    ends, directions = bars(linkage), lines_of(linkage.axes)[1]
    count = len(ends)
    joints = [_joint(directions[n], ends[n, 1], ends[(n + 1) % count, 0], unit) for n in range(count)]
    parts = []
    for link, colour in enumerate(link_colours(linkage)):
        radius = 0.03 * unit if link else 0.042 * unit
        parts += _bar(joints[link - 1][1], joints[link][0], colour, radius, 0.065 * unit, _body(link))
    return parts + [_pin(before[1], after[1], unit, _body(n)) for n, (before, after) in enumerate(joints)]


def _joint(direction: np.ndarray, before: np.ndarray, after: np.ndarray, unit: float) -> tuple:
    """Foot and sleeve, of shape (2, 3), of the link before a joint and of the link after it.

    The joint is half-way between the feet.  Where these are close together, the bars end in the sleeves.
    """
    middle, gap = (before + after) / 2, (after - before) @ direction
    step = 0.1 * unit * (direction if gap >= 0 else -direction)
    sleeves = middle + np.array([[-1.03], [-0.03]]) * step, middle + np.array([[0.03], [1.03]]) * step
    feet = (before, after) if abs(gap) > 0.25 * unit else [sleeve.mean(axis=0) for sleeve in sleeves]
    return tuple(zip(feet, sleeves, strict=True))


def _bar(first: tuple, second: tuple, colour: str, radius: float, wide: float, body: str) -> list:
    """A bar from foot to foot, an arm along the axis to each sleeve that is not at its foot, and the sleeves."""
    parts = [Rod(first[0], second[0], colour, radius, body)]
    for foot, sleeve in (first, second):
        parts.append(Rod(*sleeve, colour, wide, body))
        if np.linalg.norm(foot - sleeve.mean(axis=0)) > radius:
            parts.append(Rod(foot, sleeve.mean(axis=0), colour, radius, body))
            parts.append(Ball(foot, colour, radius, body))
    return parts


def _pin(before: np.ndarray, after: np.ndarray, unit: float, body: str) -> Rod:
    """The pin through two sleeves, a little longer than both."""
    step = 0.4 * (before[1] - before[0])
    return Rod(before[0] - step, after[1] + step, INK, 0.03 * unit, body)


def _coupler(linkage, point: np.ndarray, unit: float) -> list:
    """The coupler's frame and the point whose path is drawn, with rods that hold them to its bar."""
    body = _body(linkage.coupler)
    home = linkage.coupler_motion(np.array([np.inf]))[0]
    origin = as_float(act(home, [0, 0, 0]))
    holder = _nearest(*bars(linkage)[linkage.coupler], origin)
    return [*_holder((holder, origin, point), unit, body), Frame(home, 0.24 * unit, body=body)]


def _nearest(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The point of a segment that is nearest to a given point."""
    bar = end - start
    length = bar @ bar
    return start + (np.clip((point - start) @ bar / length, 0, 1) if length > 0 else 0) * bar


def _subscript(number: int) -> str:
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def _short(x: float) -> str:
    """A parameter in a few letters."""
    if np.isinf(x):
        return "∞"
    text = f"{x:.2f}" if abs(x) < 100 else f"{x:.0f}" if abs(x) < 1e5 else f"{x:.0e}"
    return text.replace("-", "−") if float(text) else "0"


def linkages_side_by_side(linkages, poses=(), *, alt, names=None, frames=36, height="", **options) -> SceneGrid:
    """Several linkages next to each other, which reach their poses at the same times.

    Parameters
    ----------
    linkages : sequence of Linkage
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``
        Poses that every coupler visits.
    alt : str
        A sentence that says what is to be seen.
    names : sequence of str, optional
        What the linkages are called; 1, 2, … if not given.
    frames : int
        How many positions of each are recorded.
    height : str
        Of the scene on a page, in units of CSS; by the number of linkages if not given.
    **options
        More of what a `SceneGrid` takes: ``seconds``, ``view``.

    Returns
    -------
    SceneGrid
    """
    places = [frames * n // len(poses) for n in range(len(poses))]
    scenes = [linkage_scene(linkage, poses, alt=alt, places=places, frames=frames) for linkage in linkages]
    return SceneGrid(
        scenes,
        [str(n + 1) for n in range(len(linkages))] if names is None else names,
        alt=alt,
        captions=[f"{100 * n / frames:.0f} % of a turn" for n in range(frames)],
        legend=[entry for entry in scenes[0].legend if all(entry in scene.legend for scene in scenes)],
        slider="Position along one turn",
        height=height or _grid_height(len(linkages)),
        **options,
    )


def _grid_height(count: int) -> str:
    """Room for four cells a row on a wide page, for two on a narrow one."""
    wide, narrow = 10 + 10 * -(-count // 4), 8 + 10 * -(-count // 2)
    return f"clamp({wide}rem, {wide + 2 * (narrow - wide)}rem - {5 * (narrow - wide)}vw, {narrow}rem)"


def dyad_scene(dyad, poses=(), *, alt, point=(0, 0, 0), frames=96, **options) -> Scene:
    """A 2R dyad that goes from pose to pose; without poses it turns once about each of its axes.

    Its hand carries a frame, and a point that sweeps a surface as both angles run.

    Parameters
    ----------
    dyad : Dyad
    poses : sequence of DualQuaternion
        Poses that the dyad reaches; each lights up when it is reached.
    alt : str
        A sentence that says what is to be seen.
    point : array_like, shape (3,)
        The point of the hand's frame whose surface is drawn, in units of length; its origin if not given.
    frames : int
        How many positions are recorded.
    **options
        More of what a `Scene` takes: ``seconds``, ``view``, ``height``.

    Returns
    -------
    Scene
    """
    h1, h2, home = floats(dyad.h1), floats(dyad.h2), floats(dyad.home)
    angles, places = _tour(dyad, poses, frames) if poses else _two_turns(frames)
    first, second = _rotations(h1, angles[:, 0]), _rotations(h2, angles[:, 1])
    start = as_float(act(home, point))
    surface = _swept_surface(h1, h2, start)
    lines = lines_of(DualQuaternion.stack([h1, h2]))
    unit = max(np.ptp(surface.reshape(-1, 3), axis=0).max() / 2, np.ptp(common_feet(*lines), axis=0).max())
    return Scene(
        parts=[
            *_arm(*lines, home, start, unit),
            Surface(surface, COUPLER, opacity=0.13),
            *_reached(poses, places, unit),
            *([] if poses else [Curve(surface[:-1, 0], LINKS[0], closed=True)]),
            *([] if poses else [Curve(surface[0, :-1], COUPLER, closed=True)]),
        ],
        motions={"link": first, "hand": first * second},
        captions=[f"θ₁ = {a:.0f}°, θ₂ = {b:.0f}°" for a, b in np.degrees(angles) % 360],
        legend=[("base (fixed)", BASE), ("link", LINKS[0]), ("hand", COUPLER)],
        alt=alt,
        slider="Position along the motion",
        **options,
    )


def _reached(poses, places, unit: float, names=None) -> list[Frame]:
    """Frames at poses, which light up at their places in time."""
    names = [f"p{_subscript(n)}" for n in range(len(poses))] if names is None else names
    return [
        Frame(pose, 0.2 * unit, name, lights_at=int(place))
        for pose, name, place in zip(poses, names, places, strict=True)
    ]


def _two_turns(frames: int) -> tuple[np.ndarray, tuple]:
    """One turn about the first axis, then one about the second: angles in radians, shape (frames, 2)."""
    turn = np.linspace(0, 2 * np.pi, frames // 2, endpoint=False)
    rest = 0 * turn
    return np.concatenate([np.stack([turn, rest], axis=1), np.stack([rest, turn], axis=1)]), ()


def _tour(dyad, poses, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """The angles on the shortest way from pose to pose and back, shape (frames, 2), and when poses are reached."""
    stops = np.unwrap([_angles(dyad, pose) for pose in (*poses, poses[0])], axis=0)
    places = np.round(np.linspace(0, frames, len(stops))).astype(int)
    angles = [np.interp(np.arange(frames), places, stop) for stop in stops.T]
    return np.stack(angles, axis=1), places[:-1]


def _angles(dyad, pose) -> list[float]:
    """The two angles at which a dyad reaches a pose: t − h turns by θ if t = −|l| cot ½θ."""
    parameters = dyad.parameters(as_pose(pose))
    lengths = [np.linalg.norm(as_float(h.coeffs)[1:4]) for h in (dyad.h1, dyad.h2)]
    return [2 * np.arctan2(1, -as_float(t) / l) for t, l in zip(parameters, lengths, strict=True)]


def _rotations(h: DualQuaternion, angles: np.ndarray) -> DualQuaternion:
    """The rotations about the axis of a half-turn h = l + εm by some angles."""
    cosine, sine = np.cos(angles / 2), np.sin(angles / 2) / np.linalg.norm(h.coeffs[1:4])
    return DualQuaternion(cosine[..., None] * one.coeffs + sine[..., None] * h.coeffs)


def _swept_surface(h1: DualQuaternion, h2: DualQuaternion, point: np.ndarray, steps: int = 25) -> np.ndarray:
    """All places of a point, shape (steps, steps, 3): the first angle grows with the rows."""
    angles = np.linspace(0, 2 * np.pi, steps)
    return act(_rotations(h1, angles)[:, None] * _rotations(h2, angles)[None, :], point)


def _arm(points: np.ndarray, directions: np.ndarray, home: DualQuaternion, point: np.ndarray, unit: float) -> list:
    """A post on the first axis, the link to the second, and the hand with its frame and its point."""
    feet = common_feet(points, directions)
    joints = [_joint(direction, foot, foot, unit) for direction, foot in zip(directions, feet, strict=True)]
    (post, near), (far, hand) = joints
    origin = as_float(act(home, [0, 0, 0]))
    return [
        Rod(post[0] - 0.5 * unit * directions[0], post[0], BASE, 0.042 * unit),
        Rod(*post[1], BASE, 0.065 * unit),
        *_bar(near, far, LINKS[0], 0.03 * unit, 0.065 * unit, "link"),
        Rod(*hand[1], COUPLER, 0.065 * unit, "hand"),
        *_holder((hand[0], origin, point), unit, "hand"),
        _pin(post[1], near[1], unit, ""),
        _pin(far[1], hand[1], unit, "link"),
        Frame(home, 0.24 * unit, body="hand"),
        Label("h₁", feet[0]),
        Label("h₂", feet[1], "link"),
    ]


def _holder(stations, unit: float, body: str) -> list:
    """Thin rods from station to station, and a ball at the last."""
    pairs = [(a, b) for a, b in pairwise(stations) if np.any(a != b)]
    rods = [Rod(a, b, COUPLER, 0.018 * unit, body) for a, b in pairs]
    return [*rods, Ball(stations[-1], COUPLER, 0.035 * unit, body)]
