"""The search for chains whose end meets data: Levenberg and Marquardt's method from many random starts at once.

A chain of revolute joints turns by products of linear factors: joint k by the sum of the angles 2 arg(c − s z) over its
numbers z, with t = c/s on the projective line.  The last z is √−1, which fixes the parameter up to its sign.  So a
chain of k joints with f factors has 4k + 2f − 2 unknowns, and each datum adds the t at which it is met.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np

from kinlib.typing import Array

__all__ = ["Conditions", "Search", "Unknowns"]

CANDIDATES = 8
"""So many random chains are tried for each one that is followed to the end."""

STAGES = ((12, 2), (25, 4), (60, 8))
"""After so many steps only one in so many candidates, those that miss the data least, is followed on."""

STEPS = 250
"""The steps of one search."""

LONGEST_STEP = 0.7
"""No unknown changes by more in one step: radians, or parts of the size of the problem."""

GRID = 12
"""At so many parameters along a random chain it is looked where it comes nearest to each datum."""

FAR = 100.0
"""Chains with axes farther away than so many sizes of the problem are given up."""

MET = 1e-20
"""Sums of squares below this are solutions up to rounding."""

BLOCK = 600
"""So many chains are followed at a time: their numbers stay in the cache."""


@dataclass(frozen=True)
class Conditions:
    """The parts of all data, in the fixed frame at home: what each is about, its datum, and where it has to go.

    Attributes
    ----------
    count : int
        The number of data.
    arrive, touch, aim, turn : tuple of arrays
        The numbers of the data and, for points: point, place; for points on lines: point, foot, two normals; for
        directions of length 1: before, after; for orientations: the conjugate of the unit quaternion.
    """

    count: int
    arrive: tuple[Array, ...]
    touch: tuple[Array, ...]
    aim: tuple[Array, ...]
    turn: tuple[Array, ...]

    @cached_property
    def owners(self) -> Array:
        """The number of the datum of each residual."""
        rows = (self.arrive, 3), (self.touch, 2), (self.aim, 3), (self.turn, 3)
        return np.concatenate([np.repeat(part[0], size) for part, size in rows])


@dataclass
class Unknowns:
    """Chains: directions l (length 1) and feet p of the axes, numbers z, and the φ of each datum with t = cot φ.

    Shapes (rows, joints, 3) twice, (rows, factors), (rows, data).
    """

    l: Array
    p: Array
    z: Array
    phi: Array

    def arrays(self) -> tuple[Array, ...]:
        """All of them."""
        return self.l, self.p, self.z, self.phi

    def some(self, rows: Array | slice) -> Unknowns:
        """Some of the chains."""
        return Unknowns(*(x[rows] for x in self.arrays()))

    def chosen(self, rows: Array, others: Unknowns) -> Unknowns:
        """The other chains in some rows."""
        pairs = zip(others.arrays(), self.arrays(), strict=True)
        return Unknowns(*(np.where(rows.reshape(-1, *[1] * (x.ndim - 1)), y, x) for y, x in pairs))

    def at(self, phi: Array) -> Unknowns:
        """The same chains at other parameters."""
        return Unknowns(self.l, self.p, self.z, phi)

    @staticmethod
    def joined(parts: Sequence[Unknowns]) -> Unknowns:
        """All chains of several parts."""
        return Unknowns(*(np.concatenate(x) for x in zip(*(part.arrays() for part in parts), strict=True)))

    @property
    def normals(self) -> tuple[Array, Array]:
        """Two unit vectors perpendicular to each axis."""
        return normals_of(self.l)

    def moved(self, step: Array) -> Unknowns:
        """The chains after a step in all unknowns: two turns and two shifts of each axis, then z, then φ."""
        joints, free = self.l.shape[1], self.z.shape[1] - 1
        axes = step[:, : 4 * joints].reshape(-1, joints, 4, 1)
        e1, e2 = self.normals
        l = self.l + axes[:, :, 0] * cross(e1, self.l) + axes[:, :, 1] * cross(e2, self.l)
        l = l / np.linalg.norm(l, axis=-1, keepdims=True)
        p = self.p + axes[:, :, 2] * e1 + axes[:, :, 3] * e2
        numbers = step[:, 4 * joints : 4 * joints + 2 * free].reshape(-1, free, 2)
        z = self.z.copy()
        z[:, :free] += numbers[..., 0] + 1j * numbers[..., 1]
        return Unknowns(l, p - (p * l).sum(-1, keepdims=True) * l, z, self.phi + step[:, 4 * joints + 2 * free :])


@dataclass(frozen=True)
class Search:
    """A kind of chain and the conditions for it.

    Parameters
    ----------
    joints : tuple of int
        How many factors each joint has.
    conditions : Conditions
    """

    joints: tuple[int, ...]
    conditions: Conditions

    @property
    def _first(self) -> list[int]:
        """The first factor of each joint."""
        return [0, *accumulate(self.joints[:-1])]

    def random(self, rows: int, random: np.random.Generator) -> Unknowns:
        """Random chains, each with the best of some parameters for each datum."""
        joints, factors = len(self.joints), sum(self.joints)
        l = random.normal(size=(rows, joints, 3))
        l /= np.linalg.norm(l, axis=-1, keepdims=True)
        p = random.normal(size=(rows, joints, 3))
        z = 0.8 * (random.normal(size=(rows, factors)) + 1j * random.normal(size=(rows, factors)))
        z[:, -1] = 1j
        unknowns = Unknowns(l, p - (p * l).sum(-1, keepdims=True) * l, z, np.zeros((rows, self.conditions.count)))
        return self._nearest(unknowns)

    def _nearest(self, unknowns: Unknowns) -> Unknowns:
        """The same chains with each datum at the best of some parameters."""
        owner = np.arange(self.conditions.count)[:, None] == self.conditions.owners
        best = np.full(unknowns.phi.shape, np.inf)
        phi = unknowns.phi
        for angle in (np.arange(GRID) + 0.5) * np.pi / GRID:
            residuals = self.residuals(unknowns.at(np.full_like(phi, angle)))
            missed = residuals**2 @ owner.T
            phi = np.where(missed < best, angle, phi)
            best = np.minimum(missed, best)
        return unknowns.at(phi)

    # ---- values and derivatives ------------------------------------------------------------------------

    def residuals(self, unknowns: Unknowns) -> Array:
        """How far the chains are from the data, shape (rows, residuals)."""
        return self._measured(Motion(self.joints, unknowns), None)[0]

    def derivatives(self, unknowns: Unknowns) -> tuple[Array, Array]:
        """The residuals, and their derivatives by all unknowns, shape (rows, residuals, unknowns)."""
        motion = Motion(self.joints, unknowns)
        values, by_datum = self._measured(motion, motion.twists())
        owners, common = self.conditions.owners, by_datum.shape[-1] - 1
        matrix = np.zeros((*values.shape, common + self.conditions.count))
        matrix[..., :common] = by_datum[..., :common]
        matrix[:, np.arange(len(owners)), common + owners] = by_datum[..., common]
        return values, matrix

    def _measured(self, motion: Motion, twists: tuple[Array, Array] | None) -> tuple[Array, Array]:
        """The residuals, and how they change along twists (ω, v) of shape (rows, data, twists, 3)."""
        values: list[Array] = []
        slopes: list[Array] = []

        def add(value: Array, slope: Callable[[Array, Array], Array], data: Array) -> None:
            rows, size = len(value), value.shape[1] * value.shape[2]
            values.append(value.reshape(rows, size))
            if twists is not None:
                changes = slope(twists[0][:, data], twists[1][:, data])
                slopes.append(np.swapaxes(changes, 2, 3).reshape(rows, size, changes.shape[2]))

        data, x, place = self.conditions.arrive
        at = motion.points(data, x)
        add(at - place, lambda w, v: cross(w, at[:, :, None]) + v, data)
        data, x, foot, across = self.conditions.touch
        on = motion.points(data, x)
        beside = np.einsum("kci,nki->nkc", across, on - foot)
        add(beside, lambda w, v: np.einsum("kci,nkgi->nkgc", across, cross(w, on[:, :, None]) + v), data)
        data, before, after = self.conditions.aim
        aimed = motion.directions(data, before)
        add(aimed - after, lambda w, v: cross(w, aimed[:, :, None]), data)
        data, wanted = self.conditions.turn
        error = quaternion_product(motion.turn[:, data], np.broadcast_to(wanted, (len(at), *wanted.shape)))
        scalar, vector = error[..., None, :1], error[..., None, 1:]
        add(2 * error[..., 1:], lambda w, v: scalar * w + cross(w, vector), data)
        return np.concatenate(values, axis=1), np.concatenate(slopes, axis=1) if slopes else np.empty(0)

    # ---- the search ------------------------------------------------------------------------------------

    def found(self, starts: int, seed: Sequence[int], progress: Callable[[float], None] | None = None) -> Unknowns:
        """The solutions that were found from random starts, each as often as it was found."""
        random = np.random.default_rng(seed)
        rows = CANDIDATES * starts
        parts = []
        for begin in range(0, rows, BLOCK):
            parts.append(self.followed(self.random(min(BLOCK, rows - begin), random)))
            if progress:
                progress(min(begin + BLOCK, rows) / rows)
        return Unknowns.joined(parts)

    def followed(self, unknowns: Unknowns, stages: Sequence[tuple[int, int]] = STAGES) -> Unknowns:
        """The solutions to which chains lead; those that miss the data most are given up on the way."""
        rows, solved = len(unknowns.phi), [unknowns.some(slice(0))]
        descent = Descent.of(self, unknowns)
        for step in range(1, STEPS + 1):
            descent = descent.stepped()
            if step % 4 == 0:
                done = descent.missed < MET
                solved.append(descent.unknowns.some(done))
                descent = descent.some(~done & descent.is_sensible)
            for number, share in stages:
                if step == number:
                    descent = descent.some(np.sort(np.argsort(descent.missed, kind="stable")[: rows // share]))
            if not len(descent.missed):
                break
        return self.polished(Unknowns.joined(solved))

    def polished(self, unknowns: Unknowns, steps: int = 3) -> Unknowns:
        """Solutions up to rounding, by Newton's method with the shortest steps; those that run away are left out."""
        for _ in range(steps):
            values, matrix = self.derivatives(unknowns)
            step = -(np.linalg.pinv(matrix, rcond=1e-10) @ values[..., None])[..., 0]
            unknowns = unknowns.moved(_shortened(step))
        return unknowns.some((self.residuals(unknowns) ** 2).sum(-1) < MET)


@dataclass
class Descent:
    """Chains on their way: what they miss, and how much they are damped."""

    search: Search
    unknowns: Unknowns
    values: Array
    matrix: Array
    missed: Array
    damping: Array

    @classmethod
    def of(cls, search: Search, unknowns: Unknowns) -> Descent:
        """The beginning."""
        values, matrix = search.derivatives(unknowns)
        return cls(search, unknowns, values, matrix, (values**2).sum(-1), np.ones(len(values)))

    @property
    def is_sensible(self) -> Array:
        """Whether the axes are not far away."""
        return np.abs(self.unknowns.p).max(axis=(1, 2), initial=0) < FAR

    def some(self, rows: Array) -> Descent:
        """Some of the chains."""
        rest = (x[rows] for x in (self.values, self.matrix, self.missed, self.damping))
        return Descent(self.search, self.unknowns.some(rows), *rest)

    def stepped(self) -> Descent:
        """One step of Levenberg and Marquardt, taken where it leads nearer."""
        transposed = np.swapaxes(self.matrix, 1, 2)
        normal = transposed @ self.matrix
        diagonal = np.einsum("nii->ni", normal)
        diagonal = diagonal + 1e-3 * diagonal.mean(axis=-1, keepdims=True) + 1e-12
        normal = normal + (self.damping[:, None] * diagonal)[:, :, None] * np.eye(normal.shape[1])
        step = -np.linalg.solve(normal, transposed @ self.values[..., None])[..., 0]
        tried = self.unknowns.moved(_shortened(step))
        values, matrix = self.search.derivatives(tried)
        missed = (values**2).sum(-1)
        nearer = missed < self.missed
        damping = np.where(nearer, np.maximum(self.damping / 4, 1e-15), np.minimum(self.damping * 4, 1e10))
        return Descent(
            self.search,
            self.unknowns.chosen(nearer, tried),
            np.where(nearer[:, None], values, self.values),
            np.where(nearer[:, None, None], matrix, self.matrix),
            np.where(nearer, missed, self.missed),
            damping,
        )


def _shortened(step: Array) -> Array:
    longest = np.abs(step).max(axis=-1, keepdims=True)
    return step * np.minimum(1, LONGEST_STEP / np.maximum(longest, 1e-300))


class Motion:
    """The displacement of the end of each chain at each datum: rotation matrix, shift, and unit quaternion."""

    def __init__(self, joints: tuple[int, ...], unknowns: Unknowns):
        self.joints, self.unknowns = joints, unknowns
        self.first = [0, *accumulate(joints[:-1])]
        self.c, self.s = np.cos(unknowns.phi)[..., None], np.sin(unknowns.phi)[..., None]
        self.factors = self.c - self.s * unknowns.z[:, None, :]
        half = np.add.reduceat(np.angle(self.factors), self.first, axis=-1)
        self.before: list[tuple[Array, Array, Array]] = []  # of each joint: rotation, point of the axis, own rotation
        rows, data = unknowns.phi.shape
        self.rotation = np.broadcast_to(np.eye(3), (rows, data, 3, 3))
        self.shift = np.zeros((rows, data, 3))
        self.turn = np.broadcast_to([1.0, 0, 0, 0], (rows, data, 4))
        for n in range(len(joints)):
            self._add_joint(n, half[..., n, None])

    def _add_joint(self, n: int, half: Array) -> None:
        l, p = self.unknowns.l[:, None, n], self.unknowns.p[:, None, n]
        quaternion = np.concatenate([np.cos(half), np.sin(half) * l], axis=-1)
        own = rotation_matrix(quaternion)
        foot = _image(self.rotation, p) + self.shift
        self.before.append((self.rotation, foot, own))
        self.rotation = self.rotation @ own
        self.shift = foot - _image(self.rotation, p)
        self.turn = quaternion_product(self.turn, quaternion)

    def points(self, data: Array, x: Array) -> Array:
        """Where points come, shape (rows, points, 3)."""
        return self.directions(data, x) + self.shift[:, data]

    def directions(self, data: Array, x: Array) -> Array:
        """Where directions point, shape (rows, directions, 3)."""
        return _image(self.rotation[:, data], x)

    def twists(self) -> tuple[Array, Array]:
        """The velocities (ω, v at the origin) by all unknowns and, last, by the φ of the datum: (rows, data, n, 3)."""
        turns, shifts, spins = [], [], []
        zero = np.zeros_like(self.shift)
        e1, e2 = self.unknowns.normals
        for n, (rotation, foot, own) in enumerate(self.before):
            axis = _image(rotation, self.unknowns.l[:, None, n])
            spins.append((axis, cross(foot, axis)))
            across = np.broadcast_to(np.stack([e1[:, n], e2[:, n]], axis=-1)[:, None], (*zero.shape, 2))
            left = np.moveaxis(rotation @ (across - own @ across), -1, 0)
            turns += [left[0], left[1], zero, zero]
            shifts += [cross(foot, left[0]), cross(foot, left[1]), left[0], left[1]]
        for joint, rate in self._rates():
            turns.append(rate[..., None] * spins[joint][0])
            shifts.append(rate[..., None] * spins[joint][1])
        drive = np.add.reduceat(2 * ((-self.s - self.c * self.unknowns.z[:, None]) / self.factors).imag, self.first, -1)
        for found, part in ((turns, 0), (shifts, 1)):
            found.append(sum(drive[..., n, None] * spin[part] for n, spin in enumerate(spins)))
        return np.stack(turns, axis=2), np.stack(shifts, axis=2)

    def _rates(self) -> list[tuple[int, Array]]:
        """How fast the joints turn by the parts x and y of all z but the last."""
        owner = np.repeat(np.arange(len(self.joints)), self.joints)
        slope = -2 * self.s / self.factors
        return [
            (int(owner[n]), rate) for n in range(len(owner) - 1) for rate in (slope[..., n].imag, slope[..., n].real)
        ]


def cross(a: Array, b: Array) -> Array:
    """The vector product."""
    a1, a2, a3, b1, b2, b3 = (x[..., n] for x in (a, b) for n in range(3))
    return np.stack([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1], axis=-1)


def normals_of(l: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to each other and to unit vectors."""
    e1 = cross(l, np.eye(3)[np.abs(l).argmin(axis=-1)])
    e1 = e1 / np.linalg.norm(e1, axis=-1, keepdims=True)
    return e1, cross(l, e1)


def quaternion_product(a: Array, b: Array) -> Array:
    """The product of quaternions (scalar, vector), shape (..., 4)."""
    scalar = a[..., :1] * b[..., :1] - (a[..., 1:] * b[..., 1:]).sum(-1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def rotation_matrix(q: Array) -> Array:
    """The matrices of unit quaternions, shape (..., 3, 3)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _image(rotation: Array, x: Array) -> Array:
    return np.einsum("...ij,...j->...i", rotation, x)
