"""Moving scenes of dyads and linkages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, one
from kinlib.dyad import Dyad
from kinlib.linkage import Linkage
from kinlib.pictures.bars import Bars, common_feet, lines_of
from kinlib.pictures.colours import BASE, COUPLER, LINKS, link_colours, link_names
from kinlib.pictures.floats import one_dyad, one_linkage
from kinlib.pictures.linkage_parts import body_of, coupler_parts, holder, joint, link_parts, linkage_parts, pin
from kinlib.pictures.parts import Curve, Frame, Label, Part, Rod, Surface
from kinlib.pictures.scene import Scene, SceneGrid
from kinlib.pictures.turn import one_turn, parameters_of
from kinlib.poses import as_pose
from kinlib.scalar import as_float
from kinlib.typing import ArrayLike, PointLike, PoseLike

__all__ = ["dyad_scene", "linkage_scene", "linkages_side_by_side"]


def linkage_scene(
    linkage: Linkage,
    poses: Sequence[PoseLike] = (),
    *,
    alt: str,
    point: PointLike = (0, 0, 0),
    parameters: Sequence[float] | None = None,
    places: Sequence[int] | None = None,
    names: Sequence[str] | None = None,
    bars: ArrayLike | None = None,
    frames: int = 90,
    **options: Any,
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
    bars : array_like, shape (n, 2, 3), optional
        The ends of the bars at home, on the axes; those of the common perpendiculars if not given.
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
        If the coupler does not visit one of the poses, or an end of a bar is off its axis.
    """
    drawn = Bars.of(linkage, given=bars)
    linkage = drawn.linkage
    stops = parameters_of(drawn, poses) if parameters is None else parameters
    t, reached = one_turn(drawn, frames, stops, places)
    path = as_float(act(linkage.coupler_motion(t), point))
    unit = max(drawn.size, np.ptp(path, axis=0).max() / 2)
    start = as_float(act(linkage.home, point))
    moves = linkage.link_displacements(t)
    return Scene(
        parts=[
            *linkage_parts(drawn, unit),
            *coupler_parts(drawn, start, unit),
            Frame(linkage.home, 0.24 * unit, body=body_of(linkage.coupler)),
            Curve(path, COUPLER, 0.012 * unit, closed=True),
            *_reached(poses, reached, unit, names),
        ],
        motions={body_of(n): moves[:, n] for n in range(1, linkage.joint_count)},
        captions=[f"t = {_short(x)}" for x in t],
        legend=[*zip(link_names(linkage), link_colours(linkage), strict=True)],
        alt=alt,
        slider="Position along one turn",
        **options,
    )


def _subscript(number: int) -> str:
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def _short(x: float) -> str:
    """A parameter in a few letters."""
    if np.isinf(x):
        return "∞"
    text = f"{x:.2f}" if abs(x) < 100 else f"{x:.0f}" if abs(x) < 1e5 else f"{x:.0e}"
    return text.replace("-", "−") if float(text) else "0"


def linkages_side_by_side(
    linkages: Sequence[Linkage],
    poses: Sequence[PoseLike] = (),
    *,
    alt: str,
    names: Sequence[str] | None = None,
    frames: int = 36,
    height: str = "",
    **options: Any,
) -> SceneGrid:
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
    linkages = [one_linkage(linkage, f"linkage {n} of those given") for n, linkage in enumerate(linkages, start=1)]
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


def dyad_scene(
    dyad: Dyad,
    poses: Sequence[PoseLike] = (),
    *,
    alt: str,
    point: PointLike = (0, 0, 0),
    frames: int = 96,
    **options: Any,
) -> Scene:
    """A 2R dyad that goes from pose to pose; without poses it turns once about each of its axes.

    Its hand carries a frame, and a point that sweeps a surface as both angles run.

    Parameters
    ----------
    dyad : Dyad
    poses : sequence of DualQuaternion, 4×4 matrices or SciPy ``RigidTransform``
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
    single = one_dyad(dyad)
    h1, h2, home = single.h1, single.h2, single.home
    angles, places = _tour(dyad, poses, frames) if poses else _two_turns(frames)
    first, second = _rotations(h1, angles[:, 0]), _rotations(h2, angles[:, 1])
    start = as_float(act(home, point))
    surface = _swept_surface(h1, h2, start)
    lines = lines_of(DualQuaternion.stack([h1, h2]))
    unit = max(np.ptp(surface.reshape(-1, 3), axis=0).max() / 2, np.ptp(common_feet(*lines), axis=0).max())
    return Scene(
        parts=[
            *_arm(*lines, home, start, unit),
            Surface(surface, COUPLER, opacity=0.2),
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


def _reached(
    poses: Sequence[PoseLike], places: np.ndarray, unit: float, names: Sequence[str] | None = None
) -> list[Frame]:
    """Frames at poses, which light up at their places in time."""
    names = [f"p{_subscript(n)}" for n in range(len(poses))] if names is None else names
    return [
        Frame(pose, 0.2 * unit, name, lights_at=int(place))
        for pose, name, place in zip(poses, names, places, strict=True)
    ]


def _two_turns(frames: int) -> tuple[np.ndarray, np.ndarray]:
    """One turn about the first axis, then one about the second: angles in radians, shape (frames, 2)."""
    turn = np.linspace(0, 2 * np.pi, frames // 2, endpoint=False)
    rest = 0 * turn
    return np.concatenate([np.stack([turn, rest], axis=1), np.stack([rest, turn], axis=1)]), np.array([])


def _tour(dyad: Dyad, poses: Sequence[PoseLike], frames: int) -> tuple[np.ndarray, np.ndarray]:
    """The angles on the shortest way from pose to pose and back, shape (frames, 2), and when poses are reached."""
    stops = np.unwrap([_angles(dyad, pose) for pose in (*poses, poses[0])], axis=0)
    places = np.round(np.linspace(0, frames, len(stops))).astype(int)
    angles = [np.interp(np.arange(frames), places, stop) for stop in stops.T]
    return np.stack(angles, axis=1), places[:-1]


def _angles(dyad: Dyad, pose: PoseLike) -> list[float]:
    """The two angles at which a dyad reaches a pose: t − h turns by θ if t = −|l| cot ½θ."""
    parameters = dyad.parameters(as_pose(pose))
    lengths = [np.linalg.norm(as_float(h.coeffs)[1:4]) for h in (dyad.h1, dyad.h2)]
    return [2 * np.arctan2(1, -as_float(t) / l) for t, l in zip(parameters, lengths, strict=True)]


def _rotations(h: DualQuaternion, angles: np.ndarray) -> DualQuaternion:
    """The rotations about the axis of a half-turn h = l + εm by some angles."""
    cosine, sine = np.cos(angles / 2), np.sin(angles / 2) / np.linalg.norm(h.coeffs[1:4])
    return DualQuaternion(cosine[..., None] * one.coeffs + sine[..., None] * h.coeffs)


def _swept_surface(h1: DualQuaternion, h2: DualQuaternion, point: np.ndarray, steps: int = 31) -> np.ndarray:
    """All places of a point, shape (steps, steps, 3): the first angle grows with the rows."""
    angles = np.linspace(0, 2 * np.pi, steps)
    return act(_rotations(h1, angles)[:, None] * _rotations(h2, angles)[None, :], point)


def _arm(
    points: np.ndarray, directions: np.ndarray, home: DualQuaternion, point: np.ndarray, unit: float
) -> list[Part]:
    """A post on the first axis, the link to the second, and the hand with its frame and its point."""
    feet = common_feet(points, directions)
    (post, near), (far, hand) = [joint(directions[n], feet[n], feet[n], unit) for n in (0, 1)]
    return [
        Rod(post.foot - 0.5 * unit * directions[0], post.foot, BASE, 0.042 * unit),
        Rod(post.sleeve[0], post.sleeve[1], BASE, 0.065 * unit),
        *link_parts(near, far, LINKS[0], "link", unit),
        Rod(hand.sleeve[0], hand.sleeve[1], COUPLER, 0.065 * unit, "hand"),
        *holder((hand.foot, as_float(act(home, [0, 0, 0])), point), "hand", unit),
        pin(post, near, "", unit),
        pin(far, hand, "link", unit),
        Frame(home, 0.24 * unit, body="hand"),
        Label("h₁", post.foot - 0.66 * unit * directions[0]),
        Label("h₂", hand.sleeve[1] + 1.6 * (hand.sleeve[1] - hand.sleeve[0]), "link"),
    ]
