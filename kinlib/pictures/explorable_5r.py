"""5R linkages through three poses that follow the number z which the reader moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from kinlib.chain import link_columns
from kinlib.displacement import act
from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.goldberg import PLACES
from kinlib.line import Line, common_perpendicular
from kinlib.linkage import Linkage
from kinlib.pictures.bars import Bars
from kinlib.pictures.colours import COUPLER, INK, PIN, PURPLE, link_colours, link_names
from kinlib.pictures.controls import Choice, Control, Pad, Turn
from kinlib.pictures.explorable import ExplorableScene, Seen, Trail, explorable_scene
from kinlib.pictures.parts import Frame, Rod
from kinlib.pictures.turn import one_turn
from kinlib.poses import as_poses
from kinlib.scalar import as_float, root_of
from kinlib.typing import PoseLike
from kinlib.z_plane import ZFault, ZPlane, z_planes

__all__ = ["goldberg_scene", "linkage_seen", "map_scene"]

FRAMES = 120

DH_COLUMNS = (("distance", 1.0, 3), ("twist in °", 180 / np.pi, 1), ("offset", 1.0, 3))


def goldberg_scene(
    poses: Sequence[PoseLike],
    z: tuple[float, float] = (1.0, 2.0),
    *,
    alt: str,
    choice: int = 4,
    point: Sequence[float | Fraction] = (0, 0, 0),
    **options: Any,
) -> ExplorableScene:
    """The eight 5R linkages through three exact poses: the reader moves z, and chooses which one is seen.

    Parameters
    ----------
    poses : sequence of three poses with exact numbers
    z : (float, float)
        Where the point is at first.
    alt : str
        A sentence that says what is to be seen.
    choice : int
        Which of the eight is shown at first, 0, 1, ….
    point : array_like, shape (3,)
        The point of the coupler's frame whose path is drawn, in units of length.
    **options
        More of what `explorable_scene` takes: ``seconds``, ``view``, ``height``.
    """
    shown = _FiveBars.of(poses, z, choice, point)
    names = [f"{n + 1}: {PLACES[n // 2].removesuffix(': ')}" for n in range(8)]
    pad = Pad(("x", "y"), *_limits(shown.drawn, z), z, "the number z", "z", partial(_draw, shown.drawn), ("z₂",))
    return shown.scene(shown.seen, [pad, Choice("linkage", names, choice)], alt, options)


def map_scene(
    poses: Sequence[PoseLike],
    z: tuple[float, float],
    maps: Mapping[str, Callable[[Axes], None]],
    *,
    alt: str,
    x: tuple[float, float],
    y: tuple[float, float],
    choice: int = 4,
    point: Sequence[float | Fraction] = (0, 0, 0),
    **options: Any,
) -> ExplorableScene:
    """One of the eight 5R linkages through three exact poses: the reader moves z over maps of its plane.

    Parameters
    ----------
    maps : mapping of str to callable
        By their names, what draws the maps: ``draw(axes)`` on axes of matplotlib that fill the pad.
    x, y : (float, float)
        The part of the plane in which z can be moved.
    poses, z, alt, choice, point, **options
        As for `goldberg_scene`.
    """
    shown = _FiveBars.of(poses, z, choice, point)

    def draw(ax: Axes, map: int) -> None:
        list(maps.values())[map](ax)
        _draw(shown.drawn, ax, choice)

    def seen(map: int, **parameters: Any) -> Seen:
        return shown.seen(linkage=choice, **parameters)

    return shown.scene(
        seen, [Pad(("x", "y"), x, y, z, "the number z", "z", draw, ("z₂",)), Choice("map", list(maps))], alt, options
    )


@dataclass(frozen=True)
class _FiveBars:
    """The eight linkages for any z: the planes of z, exact and in floats, and those of one z."""

    poses: Sequence[DualQuaternion]
    planes: Sequence[ZPlane]
    drawn: Sequence[ZPlane]
    examples: Sequence[Linkage]
    choice: int
    point: Sequence[float | Fraction]

    @classmethod
    def of(
        cls, poses: Sequence[PoseLike], z: tuple[float, float], choice: int, point: Sequence[float | Fraction]
    ) -> _FiveBars:
        p0, p1, p2 = as_poses(*poses)
        planes = z_planes(p0, p1, p2)
        drawn = z_planes(*(p.astype(float) for p in (p0, p1, p2)))
        examples = [linkage for plane in planes for linkage in plane.linkages(z)]
        return cls((p0, p1, p2), planes, drawn, examples, choice, [exactly(float(c)) for c in point])

    @cached_property
    def size(self) -> Fraction:
        """The length in which thicknesses are measured."""
        return exactly(Bars.of(self.examples[self.choice]).size)

    @cached_property
    def places(self) -> np.ndarray:
        """The frames at which the poses are met."""
        example = self.examples[self.choice]
        return one_turn(Bars.of(example), FRAMES, _stops(example))[1]

    def angles(self, linkage: int | None = None, **_: int) -> np.ndarray:
        """The angles with t = cot(½ angle) at an even pace, the poses at their frames."""
        example = self.examples[self.choice if linkage is None else linkage]
        t, _places = one_turn(Bars.of(example), FRAMES, _stops(example), self.places)
        return np.where(np.isinf(t), 0.0, 2 * np.arctan2(1.0, t))

    def seen(self, x: Any, y: Any, linkage: int, t: Any) -> Seen:
        """One of the eight linkages at t, its table, and how far z is from the bad places."""
        plane = self.planes[linkage // 2]
        partner = plane.partner((x, y))
        seen = linkage_seen(plane.linkages((x, y))[linkage % 2], t, point=self.point, size=self.size)
        turns = (y * partner[1], "The joint of z turns twice.", "The joint of z swings: it turns forth and back.")
        return replace(seen, marks=[partner], bad=_distances(plane, x, y, *partner), words=[turns])

    def scene(
        self, seen: Callable[..., Seen], controls: Sequence[Control], alt: str, options: dict[str, Any]
    ) -> ExplorableScene:
        """The scene, with the poses that light up."""
        example, size = self.examples[self.choice], 0.3 * float(self.size)
        return explorable_scene(
            seen,
            controls,
            turn=Turn("t", self.angles, FRAMES),
            fixed=[
                Frame(pose, size, f"p{'₀₁₂'[n]}", lights_at=int(self.places[n])) for n, pose in enumerate(self.poses)
            ],
            columns=DH_COLUMNS,
            caption="Denavit–Hartenberg rows, link by link",
            nothing="No linkage here",
            legend=[*zip(link_names(example), link_colours(example), strict=True)],
            recipe={"poses": [[float(c) for c in p.coeffs] for p in self.poses]},
            alt=alt,
            **options,
        )


def exactly(x: float) -> Fraction:
    """A number as a short fraction, which goes with recorded ones."""
    return Fraction(x).limit_denominator(10**6)


def _stops(linkage: Linkage) -> list[float]:
    return [float(as_float(t)) for t in linkage.parameters]


def linkage_seen(
    linkage: Linkage, t: Any, *, point: Sequence[float | Fraction] = (0, 0, 0), size: Fraction | int = 1
) -> Seen:
    """A linkage of any numbers at t: bars between the feet of common perpendiculars, sleeves, pins, and a path.

    Parameters
    ----------
    linkage : Linkage
        Neighbouring axes of which are not parallel.
    t : number
        The parameter of its motion.
    point : array_like, shape (3,)
        The point of the coupler's frame whose path is drawn, in units of length.
    size : float
        The length in which thicknesses are measured.
    """
    axes = [unit_axis(h) for h in linkage.axes]
    lines = [Line.from_dual_quaternion(h) for h in linkage.axes]
    feet = [common_perpendicular(a, b) for a, b in zip(lines, lines[1:] + lines[:1], strict=True)]
    moves = linkage.link_displacements(t)
    start = act(linkage.home, list(point))
    parts: list[Any] = []
    for n, colour in enumerate(link_colours(linkage)):
        parts += _link(moves[n], n, colour, feet, axes, size)
    coupler = moves[linkage.coupler]
    hand = act(coupler, start)
    parts += [
        Rod(act(coupler, feet[linkage.coupler - 1][0]), hand, COUPLER, 0.018 * float(size)),
        Frame(coupler * linkage.home, 0.24 * float(size)),
        Trail(hand, COUPLER, 0.012 * float(size)),
    ]
    rows = link_columns(
        np.array([h.coeffs[1:4] for h in axes]), np.array([f[0] for f in feet]), np.array([f[1] for f in feet])
    )
    return Seen(parts, [(str(n), row) for n, row in enumerate(zip(*rows, strict=True), start=1)], axes)


def unit_axis(h: DualQuaternion) -> DualQuaternion:
    """The half-turn about an axis with a direction of length 1."""
    return h / root_of(null_form(h, h))


def _link(
    move: DualQuaternion, n: int, colour: str, feet: Sequence[Any], axes: Sequence[DualQuaternion], size: Fraction | int
) -> list[Rod]:
    """Link n: a bar, a sleeve at each end, and the pin of the joint after it."""
    start, end = feet[n - 1]
    own, before = (axes[m].coeffs[1:4] for m in (n, n - 1))
    step = size / 10

    def rod(a: Any, b: Any, radius: float, colour: str = colour) -> Rod:
        return Rod(act(move, a), act(move, b), colour, radius * float(size))

    return [
        rod(start, end, 0.03 if n else 0.042),
        rod(start, start + step * before, 0.065),
        rod(end, end - step * own, 0.065),
        rod(end - Fraction(7, 5) * step * own, feet[n][0] + Fraction(7, 5) * step * own, 0.025, PIN),
    ]


def _distances(plane: ZPlane, x: Any, y: Any, u: Any, v: Any) -> list[tuple[Any, str]]:
    """How far z = (x, y) and its partner (u, v) are from the bad places of the plane."""
    (b1, _), (b2, _), (bx, by) = plane.corners
    n, m = null_form(plane.hA, plane.hA), null_form(plane.hB, plane.hB)

    def apart(a: Any, b: Any) -> Any:
        return root_of(a * a + n * (b * b))

    def off(p: Any, q: Any) -> Any:
        """How far the quadratic of p + √−1 q is from that of the other axis."""
        return apart(p, (p * p + n * (q * q) - m) / n)

    found = {
        ZFault.REAL: y,
        ZFault.BENNETT: apart(x - bx, y - by),
        ZFault.CIRCUMCIRCLE: 1 / apart(u, v),
        ZFault.MISSES_1: apart(u - b1, v),
        ZFault.MISSES_2: apart(u - b2, v),
        ZFault.SAME_QUADRATIC: off(x, y) * off(u, v),
        ZFault.OWN_CONJUGATE: apart(x - u, y - v) * apart(x - u, y + v),
    }
    return [(distance, fault.message) for fault, distance in found.items()]


def _limits(planes: Sequence[ZPlane], z: tuple[float, float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """A square of the plane in which all triangles and circles, √−1 and a point are seen."""
    circles = [plane.circumcircle for plane in planes]
    low, high = (np.array([[c.real + s * r, c.imag + s * r] for c, r in circles] + [z, [0, 1]]) for s in (-1, 1))
    least, most = low.min(axis=0), high.max(axis=0)
    half = 0.6 * float((most - least).max())
    middle = (least + most) / 2
    (x0, y0), (x1, y1) = np.round(middle - half, 1).tolist(), np.round(middle + half, 1).tolist()
    return (x0, x1), (y0, y1)


def _draw(planes: Sequence[ZPlane], ax: Axes, linkage: int) -> None:
    """The triangle s_B1, s_B2, z* with its circle, and the curve on which all offsets vanish; in planes of floats."""
    plane = planes[linkage // 2]
    corners = np.array([[float(c) for c in corner] for corner in (*plane.corners, plane.corners[0])])
    turn = np.linspace(0, 2 * np.pi, 200)
    centre, radius = plane.circumcircle
    ax.axhline(0, color=INK, linewidth=1)
    ax.plot(*corners.T, color=INK, linewidth=1.6)
    ax.plot(centre.real + radius * np.cos(turn), centre.imag + radius * np.sin(turn), color=INK, linestyle="--")
    for text, corner in zip(("$s_{B1}$", "$s_{B2}$", "$z^*$"), corners, strict=False):
        away = (corner - corners[:3].mean(axis=0)) / np.hypot(*(corner - corners[:3].mean(axis=0)))
        ax.annotate(text, corner, 13 * away, textcoords="offset points", color=INK, ha="center", va="center", size=12)
    ax.plot(0, 1, ".", color=INK)
    ax.annotate("√−1", (0, 1), (4, 2), textcoords="offset points", color=INK, size=9)
    _draw_zero_offsets(plane, ax)


def _draw_zero_offsets(plane: ZPlane, ax: Axes) -> None:
    """Where x₂(|z₁|² − 1) = x₁(|z₂|² − 1): Goldberg's own linkages."""
    x, y = np.meshgrid(*(np.linspace(*limits, 241) for limits in (ax.get_xlim(), ax.get_ylim())))
    u, v = plane.partner((x, y))
    first, second = x * x + y * y, u * u + v * v
    with np.errstate(invalid="ignore"):  # next to the circle
        value = (u * (first - 1) - x * (second - 1)) / (1 + second)
    ax.contour(x, y, value, levels=[0], colors=PURPLE, linewidths=1.2)
