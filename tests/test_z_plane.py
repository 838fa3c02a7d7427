"""The plane of z against plane geometry in complex numbers, and against itself from elsewhere."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy

from kinlib import (
    DegenerateError,
    DualQuaternion,
    ZFault,
    ZPlane,
    as_matrix,
    dyads_through_poses,
    goldberg_linkages,
    linear_factor,
    null_form,
    study_projection,
    z_planes,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, THREE_POSES
from kinlib.testing import random_poses
from laws import assert_same_linkages

SEEDS = range(8)


def corners_of(plane: ZPlane) -> list[complex]:
    return [complex(float(x), float(y)) for x, y in plane.corners]


def random_z(seed: int, count: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return random.normal(size=count) + 1j * random.normal(size=count)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_partner_is_the_isogonal_conjugate(seed):
    """At each corner the lines to z and to its partner have the same angle to the bisector: a quotient is real."""
    for plane in z_planes(*random_poses(3, seed=seed)):
        a, b, c = corners_of(plane)
        z = random_z(seed, 50)
        w = plane.partner(z)
        for corner, other, third in ((a, b, c), (b, c, a), (c, a, b)):
            quotient = (z - corner) * (w - corner) / ((other - corner) * (third - corner))
            assert np.allclose(quotient.imag / np.abs(quotient), 0, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_partner_of_the_partner_is_z(seed):
    z = random_z(seed, 50)
    for plane in z_planes(*random_poses(3, seed=seed)):
        assert np.allclose(plane.partner(plane.partner(z)), z, rtol=1e-7)


def test_pairs_keep_fractions():
    plane = z_planes(*THREE_POSES)[2]
    z = Fraction(1), Fraction(2, 3)
    x, y = plane.partner(z)
    assert isinstance(x, Fraction)
    assert plane.partner((x, y)) == z
    assert np.isclose(plane.partner(complex(*map(float, z))), complex(x, y))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_circumcircle_passes_through_the_corners(seed):
    for plane in z_planes(*random_poses(3, seed=seed)):
        centre, radius = plane.circumcircle
        assert np.allclose([abs(corner - centre) for corner in corners_of(plane)], radius)


def bad_places(plane: ZPlane) -> dict[ZFault, complex]:
    a, b, c = corners_of(plane)
    centre, radius = plane.circumcircle
    weights = abs(b - c), abs(c - a), abs(a - b)
    incentre = sum(w * p for w, p in zip(weights, (a, b, c), strict=True)) / sum(weights)
    return {
        ZFault.REAL: 0.3 + 0j, ZFault.BENNETT: c, ZFault.CIRCUMCIRCLE: centre + radius * np.exp(2j),
        ZFault.MISSES_1: b + 0.3 * (c - b), ZFault.MISSES_2: a - 0.7 * (c - a), ZFault.SAME_QUADRATIC: 1j,
        ZFault.OWN_CONJUGATE: incentre,
    }  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_wrong_is_named_one_by_one_and_in_arrays(seed):
    for plane in z_planes(*random_poses(3, seed=seed)):
        places = bad_places(plane)
        for fault, z in places.items():
            assert plane.fault(z) is fault
            with pytest.raises(DegenerateError) as caught:
                plane.linkages(z)
            assert fault.message in str(caught.value)
        found = plane.fault(np.array([*places.values(), 0.4 + 1.7j]))
        assert found.tolist() == [*map(int, places), 0]
        assert plane.fault(0.4 + 1.7j) is None


@pytest.mark.parametrize("seed", SEEDS)
def test_the_three_chains_multiply_to_one_cubic(seed):
    for plane in z_planes(*random_poses(3, seed=seed)):
        products = [linear_factor(f) * linear_factor(g) * linear_factor(h) for f, g, h in plane.chains(0.7 - 1.2j)]
        for other in products[1:]:
            assert np.allclose(other.coeffs, products[0].coeffs, atol=1e-9 * np.abs(products[0].coeffs).max())


@pytest.mark.parametrize("side", ["base", "moving"])
def test_a_dyad_and_two_poses_have_the_plane_of_the_three_poses(side):
    poses = random_poses(3, seed=3)
    for n, dyad in enumerate(dyads_through_poses(*poses)):
        plane, expected = ZPlane.of(dyad, *poses[1:], side=side), z_planes(*poses)[2 * n + (side == "moving")]
        assert np.allclose(corners_of(plane), corners_of(expected))
        assert_same_linkages(plane.linkages(1 + 2j), expected.linkages(1 + 2j))


def test_a_dyad_that_misses_a_pose_has_no_plane():
    poses = random_poses(4, seed=4)
    with pytest.raises(DegenerateError, match="does not reach the pose"):
        ZPlane.of(dyads_through_poses(*poses[:3])[0], poses[1], poses[3])
    with pytest.raises(ValueError, match="'base' or 'moving'"):
        ZPlane.of(dyads_through_poses(*poses[:3])[0], *poses[1:3], side="left")


def test_exact_half_turns_that_are_longer_measure_the_plane_in_their_own_length():
    exact, floats = z_planes(*FIELD_OF_DEGREE_SIX), z_planes(*(p.astype(float) for p in FIELD_OF_DEGREE_SIX))
    for plane, other in zip(exact, floats, strict=True):
        lengths = [math.sqrt(float(null_form(h, h))) for h in (plane.hA, plane.hB)]
        for (x, y), (u, v) in zip(plane.corners, other.corners, strict=True):
            assert np.allclose([float(x) / lengths[1], float(y) * lengths[0] / lengths[1]], [u, v])


# --- a stored z gives its design again ------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_representatives_frames_and_matrices_do_not_change_the_linkages(seed):
    poses, z = random_poses(3, seed=seed), complex(random_z(seed, 1)[0])
    expected = goldberg_linkages(*poses, z)
    (frame,) = random_poses(1, seed=seed + 100)
    scaled = [-poses[0], poses[1] * 1e5, poses[2] * -1e-3]
    for other in (scaled, [as_matrix(p) for p in poses], [p * frame for p in poses]):
        for linkage, same in zip(goldberg_linkages(*other, z), expected, strict=True):
            for f, g in zip(linkage.factors, same.factors, strict=True):
                assert np.allclose(f.coeffs, g.coeffs, atol=1e-8 * np.abs(g.coeffs).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_exchanging_the_other_poses_mirrors_the_planes(seed):
    """The conic runs backwards, t to 1 − t: half-turns are reversed, and so is the order of the dyads."""
    p0, p1, p2 = random_poses(3, seed=seed)
    ahead, back = z_planes(p0, p1, p2), z_planes(p0, p2, p1)
    for plane, mirrored in zip(ahead, back[2:] + back[:2], strict=True):
        a, b, c = corners_of(plane)
        assert np.allclose(corners_of(mirrored), [-b.conjugate(), -a.conjugate(), -c.conjugate()])
        z = 0.6 + 1.1j
        for linkage, other in zip(plane.linkages(z), mirrored.linkages(-z.conjugate()), strict=True):
            reversed_axes = np.array(other.denavit_hartenberg()) * [1, 1, -1]
            assert np.allclose(linkage.denavit_hartenberg(), reversed_axes, atol=1e-7)


@pytest.mark.parametrize("poses", [THREE_POSES, FIELD_OF_DEGREE_SIX])
def test_along_a_smooth_path_of_poses_the_dyads_do_not_jump(poses):
    p0, p1, p2 = (p.astype(float) for p in poses)
    steps = np.linspace(0, 0.02, 40)
    moved = DualQuaternion(p2.coeffs + steps[:, None] * np.array([0.3, -0.2, 0.1, 0.4, 0, 0, 0, 0]))
    for dyad in dyads_through_poses(p0, p1, study_projection(moved)):
        assert np.abs(np.diff(dyad.h1.coeffs, axis=0)).max() < 0.05


# --- what is no z ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("z", [(1, 2, 3), (1,), (1j, 2), "z", None, (1, None)])
def test_what_is_no_point_of_the_plane_is_refused_in_words(z):
    with pytest.raises((ValueError, TypeError), match="expected"):
        goldberg_linkages(*THREE_POSES, z)


@pytest.mark.parametrize("z", [math.nan, complex(1, math.inf), (1, math.nan), (sympy.oo, 1)])
def test_a_number_that_is_not_finite_is_refused_and_in_an_array_a_row(z):
    with pytest.raises((ValueError, TypeError), match="expected"):
        goldberg_linkages(*THREE_POSES, z)
    poses = random_poses(3, seed=1)
    rows = goldberg_linkages(*poses, np.array([1 + 2j, math.nan]), degenerate="nan")[0].factors[1].coeffs
    assert np.isnan(rows).any(-1).tolist() == [False, True]
