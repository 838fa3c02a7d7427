"""Statements beyond the paper: eigenvalues of the Study form, the z-plane, Karger's conditions, four linkages per z."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy

from kinlib import (
    DegenerateError,
    DualQuaternion,
    Dyad,
    conic_through,
    dyads_through_poses,
    eps,
    factorizations,
    fourth_parameters,
    goldberg_linkages,
    i,
    j,
    null_form,
    one,
    quadratic_of,
    recognise,
    same_point,
    six_r_linkages,
    study_eigenvalues,
    study_form,
)
from kinlib.gallery import FIELD_OF_DEGREE_SIX, FOUR_POSES, THREE_POSES
from kinlib.testing import random_poses
from problems import random_half_turns


def matrices(points):
    """The null form and the Study form on some points."""
    return (sympy.Matrix([[form(x, y) for x in points] for y in points]) for form in (null_form, study_form))


def general_dyad():
    """h1 about the x-axis and h2 at distance a and with cosine c, up to a displacement."""
    a, c, s = sympy.symbols("a c s", real=True)
    return i, c * i + s * j + a * eps * (c * j - s * i), (a, c, s)


def on_circle(matrix, c, s):
    return matrix.applyfunc(lambda x: sympy.rem(sympy.expand(x), s**2 + c**2 - 1, s))


def test_two_double_eigenvalues_on_every_2r_space():
    """S1: m/(1 + c) and −m/(1 − c), with m = b(h1, h2), that is (S − μN) has rank two for both."""
    h1, h2, (a, c, s) = general_dyad()
    null, study = matrices((one, h1, h2, h1 * h2))
    m = -a * s
    for numerator, denominator in ((m, 1 + c), (-m, 1 - c)):
        pencil = on_circle(study * denominator - null * numerator, c, s)
        values = {a: 3, c: sympy.Rational(3, 5), s: sympy.Rational(4, 5)}
        assert pencil.subs(values).rank() == 2
        minors = [
            pencil.extract(rows, cols).det() for rows in ([0, 1, 2], [0, 1, 3]) for cols in ([0, 1, 2], [1, 2, 3])
        ]
        assert all(x == 0 for x in on_circle(sympy.Matrix(minors).applyfunc(sympy.expand), c, s))


def test_the_rational_test_finds_2r_spaces_and_no_others():
    """S1: random spaces through [1] are refused, random 2R spaces are not."""
    random = np.random.default_rng(1)
    for seed in range(50):
        space = Dyad(*random_half_turns(2, seed=seed)).space().points.coeffs
        recognise(random.normal(size=(4, 4)) @ space)
        with pytest.raises(DegenerateError, match=r"null quadrilateral|without real lines"):
            recognise(np.vstack([one.coeffs, random.normal(size=(3, 8))]))


def test_interlacing_entries_of_the_fourth_row():
    """S2: in an orthonormal basis that is diagonal on the plane, s1 = s3 = 0 and s2² = (μ3 − μ2)(μ2 − μ1)."""
    for seed in range(100):
        poses = random_poses(3, seed=seed)
        mu = study_eigenvalues(*poses)
        for dyad in dyads_through_poses(*poses):
            points = [*poses, dyad.basis[0] + 2 * dyad.basis[1] - dyad.basis[3]]
            null, study = (np.array(m.tolist(), dtype=float) for m in matrices(points))
            frame = np.linalg.inv(np.linalg.cholesky(null))
            whole = frame @ study @ frame.T
            _, rotation = np.linalg.eigh(whole[:3, :3])
            s1, s2, s3 = rotation.T @ whole[:3, 3]
            scale = mu[2] - mu[0]
            assert abs(s1) + abs(s3) < 1e-7 * scale
            assert np.isclose(s2**2, (mu[2] - mu[1]) * (mu[1] - mu[0]), rtol=1e-6, atol=1e-9 * scale**2)
            assert np.isclose(whole[3, 3], mu[0] + mu[2] - mu[1], rtol=1e-6, atol=1e-7 * scale)


def test_one_space_where_eigenvalues_agree_two_where_they_differ():
    """S2."""
    h1, h2 = random_half_turns(2, seed=2, shape=(300,))
    mu = study_eigenvalues(one, h1 * h2, (1 - h1) * (1 - h2))
    gaps = np.diff(mu).min(-1) / np.ptp(mu, axis=-1)
    assert gaps.max() < 1e-9
    generic = study_eigenvalues(*random_poses(3, seed=2, shape=(300,)))
    assert (np.diff(generic).min(-1) / np.ptp(generic, axis=-1)).min() > 1e-6


def test_tangent_planes_have_two_spaces():
    """S2: ⟨1, h1, h2⟩ lies in the spaces of both orders."""
    h1, h2 = random_half_turns(2, seed=3)
    for dyad in dyads_through_poses(one, 2 - h1, 3 - h2):
        assert all(pose in dyad.space() for pose in (one, h1, h2))
        assert (h1 * h2 in dyad.space()) != (h2 * h1 in dyad.space())


def test_distance_and_ratio_straight_from_the_poses():
    """S3: a² = −μ1μ3 and a/sin α = (μ3 − μ1)/2 for both dyads and for four links of every 5R."""
    for seed in range(10):
        poses = random_poses(3, seed=seed)
        mu1, _, mu3 = study_eigenvalues(*poses)
        for dyad in dyads_through_poses(*poses):
            first, second = dyad.axes
            assert np.isclose(first.distance(second) ** 2, -mu1 * mu3, rtol=1e-6)
            assert np.isclose(first.distance(second) / np.sin(first.angle(second)), (mu3 - mu1) / 2, rtol=1e-6)
        for linkage in goldberg_linkages(*poses, 0.7 + 0.6j):
            ratios = [abs(row.distance / np.sin(row.twist)) for row in linkage.denavit_hartenberg()]
            assert np.isclose(ratios, (mu3 - mu1) / 2, rtol=1e-6).sum() == 4


def z_pair(linkage, axis):
    return [complex(f.scalar_part, null_form(f, axis)) for f in linkage.joint_factors(0)]


def test_partners_are_isogonal_conjugates():
    """S4: lines from each corner to z1 and z2 make equal angles with the two sides."""
    for seed in range(10):
        poses = random_poses(3, seed=seed)
        dyad = dyads_through_poses(*poses)[0]
        (a1, b1), (a2, b2) = (dyad.parameters(pose) for pose in poses[1:])
        y = (b2 - b1) / (a2 - a1)
        corners = [complex(b1), complex(b2), complex(b1 - a1 * y, y)]
        z1, z2 = z_pair(goldberg_linkages(*poses, 0.7 + 0.6j)[0], dyad.h1)
        for n in range(3):
            corner, p, q = (corners[(n + m) % 3] for m in range(3))
            ratio = (z1 - corner) * (z2 - corner) / ((p - corner) * (q - corner))
            assert abs(ratio.imag) < 1e-7 * abs(ratio)


def test_the_joint_turns_twice_if_both_are_on_one_side_of_the_real_axis():
    """S4."""
    swings = 0
    for seed in range(20):
        poses = random_poses(3, seed=seed)
        dyad, linkage = dyads_through_poses(*poses)[0], goldberg_linkages(*poses, 0.7 + 0.6j)[0]
        z1, z2 = z_pair(linkage, dyad.h1)
        rounds = abs(linkage.joint_angles(-math.inf)[0]) / (2 * math.pi)
        assert np.isclose(rounds, 2 if z1.imag * z2.imag > 0 else 0)
        swings += rounds < 1
    assert 0 < swings < 20


def test_kargers_conditions_with_signs():
    """S5: offsets vanish but for an equal pair at the ends of the link with another ratio; its neighbours agree."""
    for seed in range(10):
        for linkage in goldberg_linkages(*random_poses(3, seed=seed), 0.7 + 0.6j):
            rows = linkage.denavit_hartenberg()
            offsets = np.abs([row.offset for row in rows])
            large = np.flatnonzero(offsets > 1e-6 * max(row.distance for row in rows))
            assert len(large) == 2
            assert np.isclose(offsets[large[0]], offsets[large[1]], rtol=1e-6)
            odd = large[0] if large[1] == large[0] + 1 else large[1]
            before, after = rows[odd - 1], rows[(odd + 1) % 5]
            assert np.isclose(before.distance, after.distance, rtol=1e-6)


def test_kargers_signed_ratios_exactly():
    """S5: with directions kept by the exchanges; the other link has another ratio."""
    for dyad, linkage in zip(
        np.repeat(dyads_through_poses(*THREE_POSES), 2),
        [linkage for linkage in goldberg_linkages(*THREE_POSES, (1, 3)) if linkage.joints[0] == 2],
        strict=True,
    ):
        h1, h2, hB, *back = linkage.factors
        heights = {repr(quadratic_of(h)): null_form(h, dyad.h1) for h in (h1, h2)}
        k1, *ks = (k.conjugate() for k in reversed(back))
        k2, k3 = ((k - k.scalar_part) / heights[repr(quadratic_of(k))] for k in ks)
        loop = [dyad.h1, hB, k3, k2, k1]
        pairs = list(zip(loop, loop[1:] + loop[:1], strict=True))
        ratios = [study_form(p, q) / (1 - null_form(p, q) ** 2) for p, q in pairs]
        assert [ratio == ratios[0] for ratio in ratios] == [True, True, False, True, True]
        assert null_form(*pairs[1]) == null_form(*pairs[3])


def exchange_of(poses):
    """The map q ↦ v⁻¹ q̄ v with v = h1 − k2 from the two factorizations of the conic."""
    (h1, _), (_, k2) = factorizations(conic_through(*poses))
    v = h1 - k2
    return lambda q: v.inverse() * q.conjugate() * v


BACKWARDS = [1, 0, 4, 3, 2]  # the axes of a loop read from its coupler


@pytest.mark.parametrize(("poses", "z"), [(THREE_POSES, (1, 3)), (FIELD_OF_DEGREE_SIX, (1, 2))])
def test_the_eight_linkages_of_one_z_are_four_exactly(poses, z):
    """S8: base and coupler change places in linkages 0, 1, 2, 3 and 6, 7, 4, 5."""
    phi, linkages = exchange_of(poses), goldberg_linkages(*poses, z)
    assert all(phi(pose) == pose for pose in poses)
    for n, m in ((0, 6), (1, 7), (2, 4), (3, 5)):
        assert list(map(phi, linkages[n].coupler_motion.coefficients)) == list(linkages[m].coupler_motion.coefficients)
        images = [phi(linkages[n].axes[place]) for place in BACKWARDS]
        assert all(same_point(a, b) for a, b in zip(images, linkages[m].axes, strict=True))
        others = [phi(linkages[n].axes[place]) for place in BACKWARDS[2:]]
        wrong = linkages[m ^ 1].axes[2:]
        assert not all(same_point(a, b) for a, b in zip(others, wrong, strict=True))


def test_the_eight_linkages_of_one_z_are_four():
    """S8: lengths and twists, read from the base of the one and from the coupler of the other."""
    linkages = goldberg_linkages(*random_poses(3, seed=8, shape=(100,)), 0.7 + 0.6j)
    for n, m in ((0, 6), (1, 7), (2, 4), (3, 5)):
        ours, theirs = ([(r.distance, abs(np.sin(r.twist))) for r in linkages[k].denavit_hartenberg()] for k in (n, m))
        read = [ours[k] for k in (0, 4, 3, 2, 1)]  # link k joins axes k and k + 1
        assert np.allclose(read, theirs, rtol=1e-6, atol=1e-9)


def test_the_exchange_of_the_two_spaces():
    """S8, R2: an involution that reverses products, keeps both forms and exchanges the spaces."""
    phi = exchange_of(THREE_POSES)
    first, second = dyads_through_poses(*THREE_POSES)
    x, y = (DualQuaternion(np.random.default_rng(n).integers(-9, 10, 8)) for n in (1, 2))
    assert phi(x * y) == phi(y) * phi(x)
    assert phi(phi(x)) == x
    assert study_form(phi(x), phi(y)) == study_form(x, y)
    assert null_form(phi(x), phi(y)) == null_form(x, y)
    assert all(phi(point) in second.space() for point in first.basis)
    assert not all(phi(point) in first.space() for point in first.basis)


def test_shares_at_the_corners_are_real_with_sum_one():
    """S4: two real shares make the third real; so conjugates at two corners are conjugates at the third."""
    z1, z2, *corners = sympy.symbols("z1 z2 c:3")
    shares = [(c - z1) * (c - z2) / ((c - corners[n - 1]) * (c - corners[n - 2])) for n, c in enumerate(corners)]
    assert sympy.cancel(sum(shares)) == 1


def test_three_angle_symmetric_and_six_double_bennett_pairs():
    """S6: by the degrees of the relative motions of opposite links."""
    for family in (slice(0, 9), slice(9, 18)):
        linkages = six_r_linkages(*(pose.astype(float) for pose in FOUR_POSES), 0.2)[family]
        opposite = [sorted(linkage.relative_motion(n, n + 3).degree for n in range(3)) for linkage in linkages]
        assert opposite.count([3, 3, 3]) == 3
        assert opposite.count([1, 3, 3]) == 6
        assert all(linkage.relative_motion(n, (n + 2) % 6).degree == 2 for linkage in linkages for n in range(6))
        symmetric = [linkage for linkage, degrees in zip(linkages, opposite, strict=True) if degrees == [3, 3, 3]]
        for linkage in symmetric:
            reals = [(f.scalar_part, f.norm().scalar_part) for f in linkage.factors]
            assert all(np.allclose(reals[n], reals[n + 3], rtol=1e-6) for n in range(3))


def test_the_discriminant_is_the_gram_determinant():
    """S7: as polynomials in the six b_jk; and where it is negative neither family is real."""
    b = {(m, n): sympy.Symbol(f"b{m}{n}") for m in range(4) for n in range(m + 1, 4)}
    gram = sympy.Matrix(4, 4, lambda m, n: 0 if m == n else b[min(m, n), max(m, n)])
    x, y, z = b[0, 1] * b[2, 3], b[0, 2] * b[1, 3], b[0, 3] * b[1, 2]
    assert sympy.expand(gram.det() - ((x - y - z) ** 2 - 4 * y * z)) == 0
    for seed in range(300):
        poses = random_poses(4, seed=seed)
        determinant = np.linalg.det([[study_form(p, q) for q in poses] for p in poses])
        if determinant > 0:
            assert len(fourth_parameters(*poses)) == 2
        else:
            with pytest.raises(DegenerateError, match="neither family is real"):
                fourth_parameters(*poses)
