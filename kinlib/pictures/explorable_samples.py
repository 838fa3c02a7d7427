"""Linkages that need the roots of polynomials, one for each value at which a slider stops.

Roots have no formula that a page could evaluate.  So the linear factors are computed beforehand, and the page gets
these; all else follows from them by formulas, as in other scenes with parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from operator import mul
from typing import Any

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.line import Line
from kinlib.linkage import Linkage, verified_linkage
from kinlib.pictures.bars import Bars
from kinlib.pictures.colours import PURPLE, link_colours, link_names
from kinlib.pictures.controls import Choice, Samples, Turn
from kinlib.pictures.explorable import ExplorableScene, Seen, explorable_scene
from kinlib.pictures.explorable_5r import DH_COLUMNS, FRAMES, exactly, linkage_seen
from kinlib.pictures.parts import Ball, Frame
from kinlib.pictures.turn import one_turn
from kinlib.scalar import as_float, as_vectors, root_of
from kinlib.typing import Array, PoseLike

__all__ = ["sampled_linkages_scene"]

PARTS = ("x", "cx", "cy", "cz", "lx", "ly", "lz")
"""What is kept of a factor x + l + ε c×l: its real part, the foot of its axis, and the direction."""


def sampled_linkages_scene(
    families: Mapping[str, Sequence[Linkage]],
    values: Sequence[float],
    poses: Sequence[PoseLike],
    *,
    alt: str,
    start: float,
    label: str,
    which: int = 0,
    targets: Sequence[Array] = (),
    **options: Any,
) -> ExplorableScene:
    """Linkages through poses, one for each value at which a slider stops; a choice among families of them.

    Parameters
    ----------
    families : mapping of str to sequence of Linkage, each of shape (values,)
        By their names, some linkages for each value.  Of these one is shown, at each value that which is nearest to the
        one before: the order in which they are computed may change on the way.
    values : sequence of float, shape (values,)
        Where the slider stops.
    poses : sequence of poses
        What the couplers visit, at the parameters of the linkages.
    alt : str
        A sentence that says what is to be seen.
    start : float
        At which of the values the slider is at first.
    label : str
        What is written next to it.
    which : int
        The number of the linkage that is followed from the first value on.
    targets : sequence of array_like, each of shape (values, 3)
        Places that move with the slider, to be shown as balls.
    **options
        More of what `explorable_scene` takes.

    Examples
    --------
    >>> from kinlib import six_r_linkages
    >>> from kinlib.gallery import FOUR_POSES
    >>> poses, values = [pose.astype(float) for pose in FOUR_POSES], [0.25, 0.5, 0.75]
    >>> found = six_r_linkages(*poses, values)
    >>> scene = sampled_linkages_scene(
    ...     {"first": found[:9], "second": found[9:]}, values, poses,
    ...     start=0.5, label="f", alt="A 6R linkage through four poses.",
    ... )
    >>> scene
    <ExplorableScene of f, family: A 6R linkage through four poses.>
    """
    places = np.reshape([as_float(as_vectors(row, "places")) for row in targets], (len(targets), len(values), 3))
    rows = _Rows([_followed(row, which) for row in families.values()], values, start, places)
    slider = Samples("f", values, rows.samples, start, label)
    return explorable_scene(
        rows.seen,
        [slider, Choice("family", list(families))],
        turn=Turn("t", rows.angles, FRAMES),
        fixed=[Frame(pose, 0.3 * float(rows.size), f"p{'₀₁₂₃₄₅'[n]}") for n, pose in enumerate(poses)],
        columns=DH_COLUMNS,
        caption="Denavit–Hartenberg rows, link by link",
        legend=[*zip(link_names(rows.example), link_colours(rows.example), strict=True)],
        alt=alt,
        **options,
    )


def _followed(candidates: Sequence[Linkage], which: int) -> list[Linkage]:
    """One linkage a value: of the candidates, read either way, that which is nearest to the one at the value before."""
    candidates = [*candidates, *map(_backwards, candidates)]
    coefficients = np.array([[f.coeffs for f in linkage.factors] for linkage in candidates]).swapaxes(1, 2)
    found = [which]
    for n in range(1, coefficients.shape[1]):
        apart = np.abs(coefficients[:, n] - coefficients[found[-1], n - 1]).sum(axis=(1, 2))
        found.append(int(apart.argmin()))
    return [candidates[m][n] for n, m in enumerate(found)]


def _backwards(linkage: Linkage) -> Linkage:
    """The same loop with its two chains exchanged."""
    factors = [f.conjugate() for f in reversed(linkage.factors)]
    coupler = linkage.joint_count - linkage.coupler
    return verified_linkage(factors, linkage.joints[::-1], coupler, linkage.home, linkage.parameters)


@dataclass(frozen=True)
class _Rows:
    """The linkages of all families, value by value."""

    linkages: Sequence[Sequence[Linkage]]
    values: Sequence[float]
    start: float
    places: Array

    @cached_property
    def first(self) -> list[Linkage]:
        """Of each family, the linkage that is seen first."""
        n = int(np.argmin(np.abs(np.asarray(self.values) - self.start)))
        return [row[n] for row in self.linkages]

    @property
    def example(self) -> Linkage:
        """The linkage that is seen first."""
        return self.first[0]

    @cached_property
    def size(self) -> Any:
        """The length in which thicknesses are measured."""
        return exactly(Bars.of(self.example).size)

    def angles(self, family: int) -> np.ndarray:
        """The angles with t = cot(½ angle) at an even pace, that of the linkage which is seen first."""
        t, _places = one_turn(Bars.of(self.first[family]), FRAMES, self.first[family].parameters)
        return np.where(np.isinf(t), 0.0, 2 * np.arctan2(1.0, t))

    @cached_property
    def samples(self) -> dict[str, np.ndarray]:
        """The numbers of all factors, each of shape (families, values)."""
        rows = np.array([[[_parts(f) for f in linkage.factors] for linkage in row] for row in self.linkages])
        factors = {
            f"{part}{n}": rows[:, :, n, m] for n in range(len(self.example.factors)) for m, part in enumerate(PARTS)
        }
        return factors | {name: np.tile(row, (len(rows), 1)) for name, row in self.moving.items()}

    @property
    def moving(self) -> dict[str, Array]:
        """The coordinates of places that move with the slider, each of shape (values,)."""
        named = {f"{axis}{n}": row[:, m] for n, row in enumerate(self.places) for m, axis in enumerate("uvw")}
        return {name: row for name, row in named.items() if np.ptp(row)}

    def seen(self, family: int, t: Any, **numbers: Any) -> Seen:
        """The linkage of some factors at t, and how nearly a pose is missed."""
        example = self.first[family]
        factors = [_factor(*(numbers[f"{part}{n}"] for part in PARTS)) for n in range(len(example.factors))]
        home = DualQuaternion([Fraction(float(c)) for c in example.home.coeffs])
        linkage = verified_linkage(factors, example.joints, example.coupler, home)
        near = [
            (_rush(factors[: example.coupler], Fraction(float(s))), f"pose {n} is passed in a rush")
            for n, s in enumerate(example.parameters)
            if np.isfinite(s)
        ]
        balls = [
            Ball(
                [numbers.get(f"{axis}{n}", x) for axis, x in zip("uvw", row[0].tolist(), strict=True)],
                PURPLE,
                0.035 * float(self.size),
                opacity=0.6,
            )
            for n, row in enumerate(self.places)
        ]
        seen = linkage_seen(linkage, t, size=self.size)
        return replace(seen, parts=[*seen.parts, *balls], bad=near)


def _parts(f: DualQuaternion) -> list[float]:
    """A factor in numbers that may be anything: then it is still one that turns."""
    x, l, m = float(f.scalar_part), as_float(f.coeffs[1:4]), as_float(f.coeffs[5:])
    return [x, *np.cross(l, m) / (l @ l), *l]


def _factor(x: Any, cx: Any, cy: Any, cz: Any, lx: Any, ly: Any, lz: Any) -> DualQuaternion:
    return x + Line.at([cx, cy, cz], [lx, ly, lz]).as_dual_quaternion()


def _rush(factors: Sequence[DualQuaternion], s: Any) -> Any:
    """How far s is from the roots of the factors, all of them together: where it is one, the pose is missed."""
    return root_of(reduce(mul, [null_form(s - f, s - f) for f in factors]))
