"""Seeded problems from many distributions, for three and for four poses.

A *cell* is a distribution at one distance from what is degenerate about it.  Problems come in blocks; a block
depends only on the seed, its cell and its number, so that each problem can be made again by its name
``count of poses/distribution/distance/block/row``.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from tests.fuzz.poses import (
    compose,
    directions,
    factor,
    gaussian,
    half_turns,
    in_any_frames,
    inverse,
    of_unit_length,
    pose,
    quaternion_product,
    quaternions,
    random_screw,
    screw,
    small_turn,
    study_form,
)

DISTANCES = tuple(10.0**-n for n in range(1, 16))
LENGTHS = tuple(10.0**n for n in range(-6, 7))
REACHES = tuple(10.0**n for n in range(2, 7))
SCALES = tuple(10.0**n for n in (-12, -8, -5, -2, 2, 5, 8, 12))
TURNS = tuple(10.0**-n for n in range(1, 9))


@dataclass(frozen=True)
class Block:
    """Some problems of one cell.

    Attributes
    ----------
    poses : array, shape (3 or 4, n, 8)
        Floats, or fractions for exact problems.
    z, free : array of shape (n,) or None
        The further datum of Goldberg and of 6R linkages.
    form : {"dual quaternions", "matrices"}
        How kinlib is told the poses.
    """

    name: str
    poses: np.ndarray
    z: np.ndarray | None = None
    free: np.ndarray | None = None
    form: str = "dual quaternions"

    @property
    def exact(self) -> bool:
        return self.poses.dtype == object


@dataclass(frozen=True)
class Cell:
    """A distribution at one distance; ``weight`` is its share of the problems."""

    distribution: str
    distance: float | None
    make: Callable = field(repr=False)
    count: int
    weight: float = 1.0

    @property
    def name(self) -> str:
        return f"{self.count}/{self.distribution}/{'-' if self.distance is None else f'{self.distance:.0e}'}"

    def block(self, seed: int, number: int, rows: int) -> Block:
        """Block ``number`` with so many problems."""
        random = np.random.default_rng([seed, zlib.crc32(self.name.encode()), number])
        made = self.make(random, rows, self.distance)
        made = made if isinstance(made, dict) else {"poses": made}
        return Block(f"{self.name}/{number}", **made)


# --- any number of poses ----------------------------------------------------------------------------------------


def plain(count):
    return lambda random, n, _: gaussian(random, count, n)


def whole(count, exact=False):
    """Poses with small whole coefficients: many of them degenerate."""

    def make(random, n, _):
        turns = random.integers(-2, 3, (count, n, 4))
        turns[(turns == 0).all(-1)] = (1, 0, 0, 0)
        poses = pose(turns.astype(float), random.integers(-2, 3, (count, n, 3)).astype(float))
        return np.frompyfunc(Fraction, 1, 1)(poses) if exact else poses

    return make


def of_length(count):
    return lambda random, n, length: gaussian(random, count, n, length)


def scaled(count):
    """Each representative times a number of its own about the given scale, of any sign."""

    def make(random, n, scale):
        factors = scale ** random.uniform(0, 1, (count, n, 1)) * random.choice([-1, 1], (count, n, 1))
        return gaussian(random, count, n) * factors

    return make


def far_in_the_fixed_frame(count):
    def make(random, n, reach):
        away = pose(np.tile([1.0, 0, 0, 0], (n, 1)), reach * directions(random, n))
        return compose(away, gaussian(random, count, n))

    return make


def far_in_the_moving_frame(count):
    def make(random, n, reach):
        away = pose(np.tile([1.0, 0, 0, 0], (n, 1)), reach * directions(random, n))
        return compose(gaussian(random, count, n), away)

    return make


def small_turns(count):
    def make(random, n, angle):
        poses = pose(small_turn(angle * random.normal(size=(count, n, 3))), random.normal(size=(count, n, 3)))
        return in_any_frames(random, poses)

    return make


def near_planar(count):
    """Motions of a plane, put out of it by so much."""

    def make(random, n, s):
        about = np.zeros((count, n, 3))
        about[..., 2] = random.uniform(-2, 2, (count, n))
        position = np.concatenate([random.normal(size=(count, n, 2)), np.zeros((count, n, 1))], axis=-1)
        turn = quaternion_product(small_turn(about), small_turn(s * random.normal(size=(count, n, 3))))
        return in_any_frames(random, pose(turn, position + s * random.normal(size=(count, n, 3))))

    return make


def near_spherical(count):
    """Turns about one point, which is missed by so much."""

    def make(random, n, s):
        poses = pose(quaternions(random, count, n), s * random.normal(size=(count, n, 3)))
        away = pose(np.tile([1.0, 0, 0, 0], (n, 1)), random.normal(size=(n, 3)))
        return of_unit_length(compose(compose(away, poses), inverse(away)))

    return make


def pair(count, m, k, displacement):
    """Poses of which number k is number m, displaced in a special way."""

    def make(random, n, s):
        poses = gaussian(random, count, n)
        poses[k] = of_unit_length(compose(displacement(random, n, s), poses[m]))
        return poses

    return make


def nearly_equal(random, n, s):
    return pose(small_turn(s * random.normal(size=(n, 3))), s * random.normal(size=(n, 3)))


def nearly_a_translation(random, n, s):
    return pose(small_turn(s * random.normal(size=(n, 3))), random.normal(size=(n, 3)))


def nearly_a_rotation(random, n, s):
    return random_screw(random, n, s * random.choice([-1, 1], n))


def as_matrices(make):
    return lambda random, n, s: {"poses": make(random, n, s), "form": "matrices"}


# --- three poses ------------------------------------------------------------------------------------------------


def near_parallel(random, n, s):
    """Both turns from the first pose are about nearly parallel axes."""
    direction = directions(random, n)
    tilted = direction + s * random.normal(size=(n, 3))
    poses = [np.tile([1.0, 0, 0, 0, 0, 0, 0, 0], (n, 1))]
    for axis in (direction, tilted / np.linalg.norm(tilted, axis=-1, keepdims=True)):
        poses.append(screw(random.normal(size=(n, 3)), axis, random.uniform(0.5, 2.6, n), random.normal(size=n)))
    return in_any_frames(random, np.array(poses))


def near_double_roots(random, n, s):
    """On a conic (t − h1)(t − h2) whose two quadratic factors are nearly equal."""
    h1, h2 = half_turns(random, n), half_turns(random, n)
    t = random.normal(size=(2, n))
    poses = [np.tile([1.0, 0, 0, 0, 0, 0, 0, 0], (n, 1))]
    poses += [compose(factor(x, h1), factor(x - s * random.normal(size=n), (1 + s) * h2)) for x in t]
    poses[1:] = [of_unit_length(p) for p in poses[1:]]
    return in_any_frames(random, np.array(poses))


def with_z(make):
    """Problems with any z, now and then very large or small."""

    def made(random, n, s):
        z = (random.normal(size=n) + 1j * random.normal(size=n)) * 10.0 ** random.choice([0, 0, 0, 0, -3, 3], n)
        result = make(random, n, s)
        return {**(result if isinstance(result, dict) else {"poses": result}), "z": z}

    return made


def badly_placed(place):
    """Problems on a known dyad, with a z near a bad place of one of its triangles.

    With s_A, s_B for the parameters of a pose and u = s_A + √−1 the partner z2 of z1 has
    Im (s_B − z1)(s_B − z2) u = 0 for both poses; the triangle has the corners s_B of both poses and the meeting
    point of the two lines Im (s_B − z) u = 0.  The parameters increase, since half-turns point so.
    """

    def make(random, n, s):
        hA, hB = half_turns(random, n), half_turns(random, n)
        sA, sB = np.sort(random.normal(size=(2, 2, n)), axis=1)
        poses = [np.tile([1.0, 0, 0, 0, 0, 0, 0, 0], (n, 1))]
        poses += [of_unit_length(compose(factor(a, hA), factor(b, hB))) for a, b in zip(sA, sB, strict=True)]
        z = place(random, sB, sA + 1j, s * random.choice([-1, 1], n))
        inverted = random.integers(0, 2, n)[:, None].astype(bool)  # then A is the moving axis
        poses = [np.where(inverted, inverse(p), p) for p in poses]
        return {"poses": in_any_frames(random, np.array(poses)), "z": z}

    return make


def around(random, centre, s):
    return centre + s * np.exp(2j * np.pi * random.uniform(size=np.shape(centre)))


def near_the_real_axis(random, sB, u, s):
    return random.normal(size=s.shape) + 1j * s


def near_a_side(random, sB, u, s):
    return sB[0] - random.normal(size=s.shape) * u[0].conj() * np.exp(1j * s)


def near_the_circumcircle(random, sB, u, s):
    quotient = np.exp(random.normal(size=s.shape) + 1j * (s - np.angle(u[0] / u[1])))
    return (sB[0] - quotient * sB[1]) / (1 - quotient)


def near_the_bennett_corner(random, sB, u, s):
    return around(random, corner(sB, u), s)


def near_the_unit(random, sB, u, s):
    return around(random, 1j + 0 * s, s)


def near_the_partner_of_the_unit(random, sB, u, s):
    return partner(sB, u, around(random, 1j + 0 * s, s))


def near_a_centre(random, sB, u, s):
    """Near the incentre or an excentre."""
    corners = np.array([corner(sB, u), sB[0] + 0j, sB[1] + 0j])
    weights = np.abs(np.roll(corners, 1, 0) - np.roll(corners, -1, 0))
    weights[random.integers(0, 3, s.size), np.arange(s.size)] *= random.choice([-1, 1], s.size)
    return around(random, (weights * corners).sum(0) / weights.sum(0), s)


def corner(sB, u) -> np.ndarray:
    """Where the lines Im (s_B − z) u = 0 of both poses meet."""
    rows = np.stack([u.imag, u.real], axis=-1)  # Im((s − x − iy) u) = s Im u − x Im u − y Re u
    x, y = np.linalg.solve(np.moveaxis(rows, 0, -2), np.moveaxis(sB * u.imag, 0, -1)[..., None])[..., 0].T
    return x + 1j * y


def partner(sB, u, z) -> np.ndarray:
    """The z2 of z1 = z."""
    return corner(sB, (sB - z) * u)


# --- four poses -------------------------------------------------------------------------------------------------


def discriminant(poses) -> np.ndarray:
    """The Gram determinant of four poses with respect to the Study form: both families are real if positive."""
    p0, p1, p2, p3 = poses
    x = study_form(p0, p1) * study_form(p2, p3)
    y = study_form(p0, p2) * study_form(p1, p3)
    z = study_form(p0, p3) * study_form(p1, p2)
    return (x - y - z) ** 2 - 4 * y * z


def mostly_real(make):
    """Problems with real families in nine of ten cases, where the distribution has them."""

    def made(random, n, s):
        poses = make(random, 4 * n, s)
        order = np.argsort(~(discriminant(poses) > 0), kind="stable")
        order = np.concatenate([order[: n - n // 10], order[-(n // 10) :] if n // 10 else order[:0]])
        return poses[:, random.permutation(order)]

    return made


def near_the_conic(random, n, s):
    """The fourth pose is nearly on the conic through the others."""
    poses = gaussian(random, 4, n)
    p0, p1, p2, _ = poses
    b01, b02, b12 = study_form(p0, p1), study_form(p0, p2), study_form(p1, p2)
    t = random.normal(size=n)
    at = [x[:, None] for x in (t * (t - 1) * b12, -(t - 1) * b02, t * b01)]
    reached = of_unit_length(p0 * at[0] + p1 * at[1] + p2 * at[2])
    poses[3] = of_unit_length(compose(nearly_equal(random, n, s), reached))
    return poses


def near_a_missed_pose(random, n, s):
    """``free`` is near a value for which a pose is missed; found from the definition in cubics_through."""
    poses = mostly_real(plain(4))(random, n, s)
    free = np.array([_missing(poses[:, row], random.integers(3)) for row in range(n)])
    return {"poses": poses, "free": free * (1 + s) + s * random.choice([-1, 1], n) * (free == 0)}


def _missing(poses, which) -> float:
    """The free parameter at which a λ vanishes, 0 if there is none."""
    special, kernel = weights(poses)
    if kernel is None or kernel[which] == 0:
        return 0.0
    return float(-special[which] / kernel[which])


def weights(poses, sign: int = 1) -> tuple:
    """The λ = special + free · kernel of one family, in the form that cubics_through documents."""
    p0, p1, p2, p3 = poses
    b = [study_form(p0, p) for p in (p1, p2, p3)]
    b12, b13, b23 = study_form(p1, p2), study_form(p1, p3), study_form(p2, p3)
    x, y, z = b[0] * b23, b[1] * b13, b[2] * b12
    discriminant = (x - y - z) ** 2 - 4 * y * z
    if not discriminant > 0 or z == 0:
        return None, None
    t3 = (-(x - y - z) + sign * np.sqrt(discriminant)) / (2 * z)
    kernel = np.array([b23 / (1 - t3), b13 / t3, -b12])  # A23, −A13, A12 for the nodes 0, 1, t3
    w = np.array([(p[:4] ** 2).sum() for p in (p1, p2, p3)])
    special = np.cross(b, w * kernel) / (kernel @ (w * kernel))
    return special, kernel * b[0] / (b12 * b13)


def with_free(make):
    def made(random, n, s):
        result = make(random, n, s)
        return {**(result if isinstance(result, dict) else {"poses": result}), "free": random.normal(size=n)}

    return made


# --- all cells --------------------------------------------------------------------------------------------------


def _spread(distribution, make, count, distances=(None,), weight=1.0) -> list[Cell]:
    return [Cell(distribution, s, make, count, weight / len(distances)) for s in distances]


TRIPLES = [
    *_spread("Gaussian", plain(3), 3, weight=4),
    *_spread("whole", whole(3), 3, weight=2),
    *_spread("whole, exact", whole(3, exact=True), 3, weight=0.05),
    *_spread("matrices", as_matrices(plain(3)), 3),
    *_spread("representatives", scaled(3), 3, SCALES),
    *_spread("length", of_length(3), 3, LENGTHS),
    *_spread("far, fixed frame", far_in_the_fixed_frame(3), 3, REACHES),
    *_spread("far, moving frame", far_in_the_moving_frame(3), 3, REACHES),
    *_spread("small turns", small_turns(3), 3, TURNS),
    *_spread("near planar", near_planar(3), 3, DISTANCES, 2),
    *_spread("nearly spherical", near_spherical(3), 3, DISTANCES, 2),
    *_spread("p0, p1 nearly equal", pair(3, 0, 1, nearly_equal), 3, DISTANCES),
    *_spread("p1, p2 nearly equal", pair(3, 1, 2, nearly_equal), 3, DISTANCES),
    *_spread("p0, p1 nearly a translation", pair(3, 0, 1, nearly_a_translation), 3, DISTANCES),
    *_spread("p1, p2 nearly a translation", pair(3, 1, 2, nearly_a_translation), 3, DISTANCES),
    *_spread("p0, p1 nearly a rotation", pair(3, 0, 1, nearly_a_rotation), 3, DISTANCES),
    *_spread("p1, p2 nearly a rotation", pair(3, 1, 2, nearly_a_rotation), 3, DISTANCES),
    *_spread("rotation, as matrices", as_matrices(pair(3, 0, 1, nearly_a_rotation)), 3, DISTANCES[5:]),
    *_spread("axes nearly parallel", near_parallel, 3, DISTANCES, 2),
    *_spread("nearly double roots", near_double_roots, 3, DISTANCES, 2),
    *_spread("any z", with_z(plain(3)), 3, weight=2),
    *_spread("any z, whole", with_z(whole(3)), 3, weight=0.5),
    *_spread("any z, representatives", with_z(scaled(3)), 3, SCALES, 0.5),
    *_spread("any z, length", with_z(of_length(3)), 3, LENGTHS, 0.5),
    *_spread("any z, far", with_z(far_in_the_fixed_frame(3)), 3, REACHES, 0.5),
    *_spread("any z, near planar", with_z(near_planar(3)), 3, DISTANCES, 0.5),
    *_spread("any z, nearly a rotation", with_z(pair(3, 0, 1, nearly_a_rotation)), 3, DISTANCES, 0.5),
    *_spread("z near the real axis", badly_placed(near_the_real_axis), 3, DISTANCES, 0.5),
    *_spread("z near a side", badly_placed(near_a_side), 3, DISTANCES, 0.5),
    *_spread("z near the circumcircle", badly_placed(near_the_circumcircle), 3, DISTANCES, 0.5),
    *_spread("z near the corner of Bennett", badly_placed(near_the_bennett_corner), 3, DISTANCES, 0.5),
    *_spread("z near √−1", badly_placed(near_the_unit), 3, DISTANCES, 0.5),
    *_spread("partner near √−1", badly_placed(near_the_partner_of_the_unit), 3, DISTANCES, 0.5),
    *_spread("z near an in- or excentre", badly_placed(near_a_centre), 3, DISTANCES, 0.5),
]

QUADRUPLES = [
    *_spread("Gaussian", mostly_real(plain(4)), 4, weight=4),
    *_spread("any free", with_free(mostly_real(plain(4))), 4, weight=2),
    *_spread("whole", mostly_real(whole(4)), 4),
    *_spread("matrices", as_matrices(mostly_real(plain(4))), 4, weight=0.5),
    *_spread("representatives", mostly_real(scaled(4)), 4, SCALES),
    *_spread("length", mostly_real(of_length(4)), 4, LENGTHS),
    *_spread("far, fixed frame", mostly_real(far_in_the_fixed_frame(4)), 4, REACHES),
    *_spread("far, moving frame", mostly_real(far_in_the_moving_frame(4)), 4, REACHES),
    *_spread("small turns", mostly_real(small_turns(4)), 4, TURNS),
    *_spread("near planar", mostly_real(near_planar(4)), 4, DISTANCES),
    *_spread("nearly spherical", mostly_real(near_spherical(4)), 4, DISTANCES),
    *_spread("p0, p1 nearly equal", mostly_real(pair(4, 0, 1, nearly_equal)), 4, DISTANCES),
    *_spread("p0, p1 nearly a translation", mostly_real(pair(4, 0, 1, nearly_a_translation)), 4, DISTANCES),
    *_spread("p0, p1 nearly a rotation", mostly_real(pair(4, 0, 1, nearly_a_rotation)), 4, DISTANCES),
    *_spread("p2, p3 nearly a rotation", mostly_real(pair(4, 2, 3, nearly_a_rotation)), 4, DISTANCES),
    *_spread("p1, p3 nearly a rotation", mostly_real(pair(4, 1, 3, nearly_a_rotation)), 4, DISTANCES),
    *_spread("p3 nearly on the conic", near_the_conic, 4, DISTANCES),
    *_spread("free near a missed pose", near_a_missed_pose, 4, DISTANCES),
]

CELLS = {3: TRIPLES, 4: QUADRUPLES}
