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

__all__ = ["Conditions", "Search", "Unknowns", "shortened"]

CANDIDATES = 8
"""So many random chains are tried for each one that is followed to the end."""

STAGES = ((12, 2), (25, 4), (60, 8))
"""After so many steps only one in so many candidates, those that miss the data least, is followed on."""

STEPS = 250
"""The steps of one search."""

LONGEST_STEP = 0.7
"""No unknown changes by more in one step: radians, or parts of the size of the problem."""

SPREAD = 0.8
"""The standard deviation of the parts of the random z."""

GRID = 12
"""At so many parameters along a random chain it is looked where it comes nearest to each datum."""

ISOLATED = 1e-12
"""Derivatives whose least singular value is smaller than so many of the greatest leave a direction free."""

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
        The numbers of the data; then, with a row for each part: for points: point, place; for points on lines: point,
        foot, two normals; for directions of length 1: before, after; for orientations: the conjugate of the unit
        quaternion.
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
        return np.concatenate([np.tile(part[0], size) for part, size in rows])

    @property
    def frame(self) -> Array:
        """A frame that turns with the data: the principal directions of all that they are about, right-handed.

        They point to where most is, in third powers; the order of the data does not matter.
        """
        (_, point, place), (_, touching, foot, _), (_, before, after) = self.arrive, self.touch, self.aim
        turned = self.turn[1][:, 1:] * np.copysign(1, self.turn[1][:, :1])
        vectors = np.concatenate([point, place, place - point, touching, foot, before, after, turned])
        _, axes = np.linalg.eigh(vectors.T @ vectors)
        axes = axes * np.copysign(1, ((vectors @ axes) ** 3).sum(axis=0))
        return np.stack([axes[:, 2], axes[:, 1], np.cross(axes[:, 2], axes[:, 1])], axis=1)

    def seen_in(self, frame: Array) -> Conditions:
        """The same in another frame, whose axes are the columns of a rotation matrix."""
        arrive, touch, aim = ((part[0], *(x @ frame for x in part[1:])) for part in (self.arrive, self.touch, self.aim))
        data, turns = self.turn
        return Conditions(
            self.count, arrive, touch, aim, (data, np.concatenate([turns[:, :1], turns[:, 1:] @ frame], axis=1))
        )


@dataclass
class Unknowns:
    """Chains: directions l (length 1) and feet p of the axes, numbers z, and the φ of each datum with t = cot φ.

    Shapes (3, joints, chains) twice, (factors, chains), (data, chains): the chains stand last, for speed.
    """

    l: Array
    p: Array
    z: Array
    phi: Array

    @property
    def count(self) -> int:
        """The number of chains."""
        return self.phi.shape[-1]

    def arrays(self) -> tuple[Array, ...]:
        """All of them."""
        return self.l, self.p, self.z, self.phi

    def some(self, which: Array | slice) -> Unknowns:
        """Some of the chains."""
        return Unknowns(*(x[..., which] for x in self.arrays()))

    def chosen(self, where: Array, others: Unknowns) -> Unknowns:
        """The other chains at some places."""
        return Unknowns(*(np.where(where, y, x) for x, y in zip(self.arrays(), others.arrays(), strict=True)))

    def at(self, phi: Array) -> Unknowns:
        """The same chains at other parameters."""
        return Unknowns(self.l, self.p, self.z, phi)

    @staticmethod
    def joined(parts: Sequence[Unknowns]) -> Unknowns:
        """All chains of several parts."""
        return Unknowns(*(np.concatenate(x, axis=-1) for x in zip(*(part.arrays() for part in parts), strict=True)))

    @cached_property
    def normals(self) -> tuple[Array, Array]:
        """Two unit vectors perpendicular to each axis."""
        return normals_of(self.l)

    def moved(self, step: Array) -> Unknowns:
        """The chains after a step in all unknowns: two turns and two shifts of each axis, then z, then φ.

        Parameters
        ----------
        step : numpy.ndarray, shape (unknowns, chains)
        """
        joints, free = self.l.shape[1], len(self.z) - 1
        axes = step[: 4 * joints].reshape(joints, 4, -1)
        e1, e2 = self.normals
        l = self.l - axes[:, 0] * e2 + axes[:, 1] * e1  # turned about e1 and e2
        l = l / np.sqrt((l * l).sum(axis=0))
        p = self.p + axes[:, 2] * e1 + axes[:, 3] * e2
        numbers = step[4 * joints : 4 * joints + 2 * free].reshape(free, 2, -1)
        z = np.concatenate([self.z[:free] + numbers[:, 0] + 1j * numbers[:, 1], self.z[free:]])
        return Unknowns(l, p - (p * l).sum(axis=0) * l, z, self.phi + step[4 * joints + 2 * free :])


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

    def random(self, count: int, random: np.random.Generator) -> Unknowns:
        """Random chains, each with the best of some parameters for each datum."""
        joints, factors = len(self.joints), sum(self.joints)
        l = random.normal(size=(count, joints, 3)).T
        l = l / np.sqrt((l * l).sum(axis=0))
        p = random.normal(size=(count, joints, 3)).T
        z = SPREAD * random.normal(size=(count, factors, 2)) @ np.array([1, 1j])
        z[:, -1] = 1j
        return self.nearest(Unknowns(l, p - (p * l).sum(axis=0) * l, z.T, np.zeros((self.conditions.count, count))))

    def nearest(self, unknowns: Unknowns) -> Unknowns:
        """The same chains with each datum at the best of some parameters."""
        owner = (np.arange(self.conditions.count)[:, None] == self.conditions.owners).astype(float)
        best, phi = np.full(unknowns.phi.shape, np.inf), unknowns.phi
        for angle in (np.arange(GRID) + 0.5) * np.pi / GRID:
            missed = owner @ self.residuals(unknowns.at(np.full_like(phi, angle))) ** 2
            phi = np.where(missed < best, angle, phi)
            best = np.minimum(missed, best)
        return unknowns.at(phi)

    # ---- values and derivatives ------------------------------------------------------------------------

    def residuals(self, unknowns: Unknowns) -> Array:
        """How far the chains are from the data, shape (residuals, chains)."""
        return self._measured(Motion(self.joints, unknowns), None)[0]

    def derivatives(self, unknowns: Unknowns) -> tuple[Array, Array]:
        """The residuals, and their derivatives by all unknowns, shape (chains, residuals, unknowns)."""
        motion = Motion(self.joints, unknowns)
        values, slopes = self._measured(motion, motion.twists())
        owners, common = self.conditions.owners, len(slopes) - 1
        matrix = np.zeros((unknowns.count, len(values), common + self.conditions.count))
        matrix[..., :common] = slopes[:common].transpose(2, 1, 0)
        matrix[:, np.arange(len(owners)), common + owners] = slopes[common].T
        return values, matrix

    def _measured(self, motion: Motion, twists: tuple[Array, Array] | None) -> tuple[Array, Array]:
        """The residuals, and how they change along twists (ω, v) of shape (twists, 3, data, chains)."""
        values: list[Array] = []
        slopes: list[Array] = []

        def add(data: Array, value: Array, slope: Callable[[Array, Array], Array]) -> None:
            values.append(value.reshape(len(value) * len(data), -1))
            if twists is not None:
                changes = slope(twists[0][:, :, data], twists[1][:, :, data])
                slopes.append(changes.reshape(len(changes), len(value) * len(data), -1))

        data, x, place = self.conditions.arrive
        if len(data):
            at = motion.points(data, x)
            add(data, at - _columns(place), lambda w, v: cross(w, at) + v)
        data, x, foot, across = self.conditions.touch
        if len(data):
            on, normals = motion.points(data, x), np.moveaxis(across, 0, -1)[..., None]
            beside = (normals * (on - _columns(foot))).sum(axis=1)
            add(data, beside, lambda w, v: _dot(w, cross(on, normals)) + _dot(v, normals))
        data, before, after = self.conditions.aim
        if len(data):
            aimed = motion.directions(data, before)
            add(data, aimed - _columns(after), lambda w, v: cross(w, aimed))
        data, wanted = self.conditions.turn
        if len(data):
            error = quaternion_product(motion.turn[:, data], _columns(wanted))
            add(data, 2 * error[1:], lambda w, v: error[0] * w + cross(w, error[1:]))
        return np.concatenate(values), np.concatenate(slopes, axis=1) if slopes else np.empty(0)

    # ---- the search ------------------------------------------------------------------------------------

    def found(self, starts: int, seed: Sequence[int], progress: Callable[[float], None] | None = None) -> Unknowns:
        """The solutions that were found from random starts, each as often as it was found.

        The chains of a block that miss the data most are given up on the way; the others are followed together.
        """
        random = np.random.default_rng(seed)
        whole = CANDIDATES * starts
        solved, left = [], []
        for begin in range(0, whole, BLOCK):
            descent = Descent.of(self, self.random(min(BLOCK, whole - begin), random))
            found, descent = descent.followed(0, STAGES[-1][0])
            solved.append(found)
            left.append(descent.unknowns)
            if progress:
                progress(0.6 * min(begin + BLOCK, whole) / whole)
        found, _ = Descent.of(self, Unknowns.joined(left)).followed(STAGES[-1][0], STEPS)
        solutions = self.polished(Unknowns.joined([*solved, found]))
        if progress:
            progress(1.0)
        return solutions

    def is_isolated(self, unknowns: Unknowns) -> Array:
        """Whether there are no other solutions next to solutions: the derivatives have full rank."""
        values = np.linalg.svd(self.derivatives(unknowns)[1], compute_uv=False)
        return values[:, -1] > ISOLATED * values[:, 0]

    def polished(self, unknowns: Unknowns, steps: int = 3) -> Unknowns:
        """Solutions up to rounding, by Newton's method with the shortest steps; those that run away are left out."""
        for _ in range(steps):
            values, matrix = self.derivatives(unknowns)
            step = -(np.linalg.pinv(matrix, rcond=1e-10) @ values.T[..., None])[..., 0]
            unknowns = unknowns.moved(shortened(step).T)
        return unknowns.some((self.residuals(unknowns) ** 2).sum(axis=0) < MET)


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
        return cls(search, unknowns, values.T, matrix, (values**2).sum(axis=0), np.ones(unknowns.count))

    @property
    def is_sensible(self) -> Array:
        """Whether the axes are not far away."""
        return np.abs(self.unknowns.p).max(axis=(0, 1), initial=0) < FAR

    def followed(self, begin: int, end: int) -> tuple[Unknowns, Descent]:
        """The solutions that are reached in some steps, and the chains that are still on their way."""
        descent, whole, shares = self, self.unknowns.count, dict(STAGES)
        solved = [self.unknowns.some(slice(0))]
        for step in range(begin + 1, end + 1):
            if not descent.unknowns.count:
                break
            descent = descent.stepped()
            if step % 4 == 0 or step == end:
                done = descent.missed < MET
                solved.append(descent.unknowns.some(done))
                descent = descent.some(np.flatnonzero(~done & descent.is_sensible))
            if step in shares:
                descent = descent.some(np.sort(np.argsort(descent.missed, kind="stable")[: whole // shares[step]]))
        return Unknowns.joined(solved), descent

    def some(self, which: Array) -> Descent:
        """Some of the chains."""
        rest = (x[which] for x in (self.values, self.matrix, self.missed, self.damping))
        return Descent(self.search, self.unknowns.some(which), *rest)

    def stepped(self) -> Descent:
        """One step of Levenberg and Marquardt, taken where it leads nearer."""
        transposed = np.swapaxes(self.matrix, 1, 2)
        normal = transposed @ self.matrix
        diagonal = np.einsum("nii->ni", normal)
        mean = diagonal.mean(axis=-1, keepdims=True)
        diagonal += self.damping[:, None] * (diagonal + 1e-3 * mean + 1e-12)
        step = -np.linalg.solve(normal, transposed @ self.values[..., None])[..., 0]
        tried = self.unknowns.moved(shortened(step).T)
        values, matrix = self.search.derivatives(tried)
        missed = (values**2).sum(axis=0)
        nearer = missed < self.missed
        self.values[nearer], self.matrix[nearer] = values.T[nearer], matrix[nearer]
        return Descent(
            self.search,
            self.unknowns.chosen(nearer, tried),
            self.values,
            self.matrix,
            np.where(nearer, missed, self.missed),
            np.where(nearer, np.maximum(self.damping / 4, 1e-15), np.minimum(self.damping * 4, 1e10)),
        )


def shortened(step: Array) -> Array:
    """Steps of shape (chains, unknowns) that are not too long."""
    longest = np.abs(step).max(axis=-1, keepdims=True, initial=0)
    return step * np.minimum(1, LONGEST_STEP / np.maximum(longest, 1e-300))


class Motion:
    """The displacement of the end of each chain at each datum: rotation (3, 3), shift (3), unit quaternion (4)."""

    def __init__(self, joints: tuple[int, ...], unknowns: Unknowns):
        self.joints, self.unknowns = joints, unknowns
        self.first = [0, *accumulate(joints[:-1])]
        self.c, self.s = np.cos(unknowns.phi), np.sin(unknowns.phi)
        self.factors = self.c - self.s * unknowns.z[:, None]
        half = np.add.reduceat(np.angle(self.factors), self.first)
        self.halves = np.cos(half), np.sin(half)
        self.before: list[tuple[Array, Array, Array]] = []  # of each joint: two normals and a point of its axis
        shape = unknowns.phi.shape
        self.rotation = np.broadcast_to(np.eye(3)[..., None, None], (3, 3, *shape))
        self.shift = np.zeros((3, *shape))
        self.turn = np.broadcast_to(np.array([1.0, 0, 0, 0])[:, None, None], (4, *shape))
        for n in range(len(joints)):
            self._add_joint(n)

    def _add_joint(self, n: int) -> None:
        l, p, e1, e2 = (x[:, n, None] for x in (self.unknowns.l, self.unknowns.p, *self.unknowns.normals))
        foot = _image(self.rotation, p) + self.shift
        self.before.append((_image(self.rotation, e1), _image(self.rotation, e2), foot))
        cosine, sine = (x[n] for x in self.halves)
        self.turn = quaternion_product(self.turn, np.stack([cosine, *(sine * l)]))
        self.rotation = rotation_matrix(self.turn)
        self.shift = foot - _image(self.rotation, p)

    def points(self, data: Array, x: Array) -> Array:
        """Where points come, shape (3, points, chains)."""
        return self.directions(data, x) + self.shift[:, data]

    def directions(self, data: Array, x: Array) -> Array:
        """Where directions point, shape (3, directions, chains)."""
        return _image(self.rotation[:, :, data], _columns(x))

    def twists(self) -> tuple[Array, Array]:
        """The velocities ω, and v at the origin, by all unknowns and, last, φ: (n, 3, data, chains)."""
        turns, shifts, spins = [], [], []
        zero = np.zeros_like(self.shift)
        for n, (e1, e2, foot) in enumerate(self.before):
            axis = cross(e1, e2)
            spins.append((axis, cross(foot, axis)))
            cosine, sine = (x[n] for x in self.halves)
            versine, sine = 2 * sine * sine, 2 * sine * cosine
            left = versine * e1 - sine * e2, versine * e2 + sine * e1  # e − own rotation of e
            turns += [*left, zero, zero]
            shifts += [cross(foot, left[0]), cross(foot, left[1]), *left]
        for joint, rate in self._rates():
            turns.append(rate * spins[joint][0])
            shifts.append(rate * spins[joint][1])
        drive = np.add.reduceat(2 * ((-self.s - self.c * self.unknowns.z[:, None]) / self.factors).imag, self.first)
        turns.append(sum(rate * axis for rate, (axis, _) in zip(drive, spins, strict=True)))
        shifts.append(sum(rate * moment for rate, (_, moment) in zip(drive, spins, strict=True)))
        return np.stack(turns), np.stack(shifts)

    def _rates(self) -> list[tuple[int, Array]]:
        """How fast the joints turn by the parts x and y of all z but the last."""
        owner = [n for n, count in enumerate(self.joints) for _ in range(count)][:-1]
        slope = -2 * self.s / self.factors
        return [(joint, rate) for n, joint in enumerate(owner) for rate in (slope[n].imag, slope[n].real)]


def cross(a: Array, b: Array) -> Array:
    """The vector product, of shapes (..., 3, data, chains)."""
    a1, a2, a3, b1, b2, b3 = (x[..., n, :, :] for x in (a, b) for n in range(3))
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    product[..., 0, :, :] = a2 * b3 - a3 * b2
    product[..., 1, :, :] = a3 * b1 - a1 * b3
    product[..., 2, :, :] = a1 * b2 - a2 * b1
    return product


def normals_of(l: Array) -> tuple[Array, Array]:
    """Two unit vectors perpendicular to unit vectors, shape (3, ...), and to each other: e1 × e2 = l.

    The formula of Duff et al. (2017), which divides by no small number.
    """
    sign = np.copysign(1.0, l[2])
    a = -1 / (sign + l[2])
    b = l[0] * l[1] * a
    first = np.stack([1 + sign * l[0] * l[0] * a, sign * b, -sign * l[0]])
    return first, np.stack([b, sign + l[1] * l[1] * a, -l[1]])


def quaternion_product(a: Array, b: Array) -> Array:
    """The product of quaternions (scalar, vector), shape (4, data, chains)."""
    scalar = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    return np.concatenate([scalar[None], a[0] * b[1:] + b[0] * a[1:] + cross(a[1:], b[1:])])


def rotation_matrix(q: Array) -> Array:
    """The matrices of unit quaternions, shape (3, 3, data, chains)."""
    w, x, y, z = q
    a, b, c = 2 * x, 2 * y, 2 * z
    xx, yy, zz, xy, yz, zx, wx, wy, wz = a * x, b * y, c * z, a * y, b * z, c * x, w * a, w * b, w * c
    rows = (1 - yy - zz, xy - wz, zx + wy), (xy + wz, 1 - xx - zz, yz - wx), (zx - wy, yz + wx, 1 - xx - yy)
    return np.stack([np.stack(row) for row in rows])


def _image(rotation: Array, x: Array) -> Array:
    return rotation[:, 0] * x[0] + rotation[:, 1] * x[1] + rotation[:, 2] * x[2]


def _dot(twists: Array, vectors: Array) -> Array:
    """The inner products of (twists, 3, data, chains) and (vectors, 3, data, chains)."""
    a, b, c = (twists[:, None, n] * vectors[:, n] for n in range(3))
    return a + b + c


def _columns(rows: Array) -> Array:
    """The components first, for all chains."""
    return rows.T[..., None]
