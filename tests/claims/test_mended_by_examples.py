"""The one-line counter-examples of the page of results that no other test computes, once more."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from sympy import Matrix

from kinlib import (
    NULL_CONE,
    STUDY_QUADRIC,
    DegenerateError,
    Dyad,
    Linkage,
    bennett_flip,
    bennett_linkage,
    conic_through,
    dyads_through_poses,
    eps,
    factorizations,
    goldberg_linkages,
    i,
    is_null_line,
    j,
    k,
    linear_factor,
    one,
    same_point,
    six_r_linkages,
    square_root,
)
from kinlib.gallery import THREE_POSES

H1, H2 = i, j - eps * i  # perpendicular, one apart


def test_axes_that_meet_have_no_surface():
    """D1."""
    basis = one, i, j, i * j
    assert not np.any(STUDY_QUADRIC.gram(basis))


def test_on_the_null_cone_and_not_on_the_study_quadric():
    """L2c."""
    x = one + 1j * (H1 * H2)
    assert NULL_CONE.contains(x)
    assert not STUDY_QUADRIC.contains(x)


def test_one_dyad_instead_of_two_and_no_bennett_linkage():
    """T2c, I1."""
    poses = one, H1 * H2, (1 - H1) * (1 - H2)
    for build in (dyads_through_poses, bennett_linkage):
        with pytest.raises(DegenerateError, match="one 2R dyad passes through them, not two") as error:
            build(*poses)
        assert all(pose in error.value.dyad.space() for pose in poses)


def test_a_centre_over_a_vertex_leaves_its_neighbour_free():
    """L5: v1 + s εv1 is joined to u1 and u2 by null lines, for each s."""
    u1, v1, u2, _ = Dyad(H1, H2).space().null_quadrilateral()
    for s in (1, 2, -5):
        other = v1 + s * eps * v1
        assert not same_point(other, v1)
        assert is_null_line(u1, other)
        assert is_null_line(other, u2)


def test_chains_with_the_same_first_factor_hang_on_one_hinge():
    """M2: the other four make a Bennett linkage."""
    six = factorizations(linear_factor(i) * linear_factor(2 * (j - eps * i)) * linear_factor(3 * (k - 2 * eps * j)))
    shared = [(f, g) for f, g in combinations(six, 2) if f[0] == g[0]]
    assert len(shared) == 3
    for f, g in shared:
        rows = Linkage.from_chains(f[1:], g[1:]).denavit_hartenberg()
        ratios = [abs(row.distance / np.sin(row.twist)) for row in rows]
        np.testing.assert_allclose(ratios, ratios[0])
        np.testing.assert_allclose([row.offset for row in rows], 0, atol=1e-12)


def test_four_poses_of_one_conic_have_no_6r_linkage():
    """I2."""
    with pytest.raises(DegenerateError):
        six_r_linkages(*THREE_POSES, conic_through(*THREE_POSES)(3))


def cubics(places):
    """A basis of the cubics t1 = p(t2)/q(t2) through some points (t1, t2): the coefficients of p and q."""
    return Matrix([[y**2, y, 1, -x * y**2, -x * y, -x] for x, y in places]).nullspace()


def test_every_point_of_the_other_ruling_picks_the_same_cubic():
    """C2: further points with t2 = 1 give one and the same, reducible; those with t1 = 0 do not."""

    def member(a, b):
        (solution,) = cubics([(0, 1), (1, 3), (2, -1), (5, 2), (a, b)])
        return solution / next(c for c in solution if c)

    assert member(7, 1) == member(-3, 1) == member(Fraction(1, 2), 1)
    assert sum(member(7, 1)[:3]) == sum(member(7, 1)[3:]) == 0  # p and q vanish at t2 = 1
    assert member(0, 5) != member(0, 7)


def test_one_partner_where_two_quadratics_agree():
    """G2: the incentre of the triangle, z1 = z2, has one linkage and not two."""
    dyad = dyads_through_poses(*THREE_POSES)[1]
    h = (2 - square_root(2)) * (1 + dyad.h1)
    cubic = linear_factor(h) * linear_factor(h) * linear_factor(dyad.h2)
    middle, k3 = bennett_flip(h, dyad.h2)
    chain = *bennett_flip(h, middle), k3
    product = linear_factor(chain[0]) * linear_factor(chain[1]) * linear_factor(chain[2])
    assert product == cubic
    assert Linkage.from_chains([h, h, dyad.h2], chain, joints=(2, 1, 1, 1, 1)).mobility(0) == 1
    with pytest.raises(DegenerateError):
        goldberg_linkages(*THREE_POSES, (2 - square_root(2), 2 - square_root(2)))


def test_spanning_a_2r_space_does_not_suffice():
    """O1: the cubics of either class through four poses that span the space of their dyad all contain a ruling."""
    places = [(0, 1), (0, 2), (3, 1), (5, 6)]
    dyad = dyads_through_poses(*THREE_POSES)[1]
    assert Matrix([dyad(a, b).coeffs.tolist() for a, b in places]).rank() == 4
    second, first = cubics(places), cubics([(b, a) for a, b in places])
    assert len(second) == len(first) == 2
    assert all(sum(c[:3]) == sum(c[3:]) == 0 for c in second)  # p and q vanish at t2 = 1
    assert all(c[2] == c[5] == 0 for c in first)  # they vanish at t1 = 0
