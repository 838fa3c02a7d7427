"""Bonds: the degrees that follow from them are those of the relative motions themselves."""

from __future__ import annotations

import numpy as np
import pytest

from kinlib import Bond, Linkage, bennett_linkage, eps, gallery, goldberg_linkages, i, j, k, six_r_linkages
from kinlib.bonds import degrees_of
from kinlib.testing import random_poses

THREE, FOUR = random_poses(3, seed=1), random_poses(4, seed=5)
BENNETT, GOLDBERG, SIX = bennett_linkage(*THREE), goldberg_linkages(*THREE, 0.4 + 0.9j), six_r_linkages(*FOUR)
PARALLELOGRAM = Linkage.from_axes([k, k - 2 * eps * j, k + eps * i - 3 * eps * j, k + eps * i - eps * j])


def degrees_by_products(linkage: Linkage) -> np.ndarray:
    count = linkage.joint_count
    return np.array([[linkage.relative_motion(a, b).degree for b in range(count)] for a in range(count)])


@pytest.mark.parametrize("linkage", [BENNETT, *GOLDBERG, *SIX, PARALLELOGRAM], ids=repr)
def test_degrees_are_numbers_of_bonds_that_are_cut(linkage):
    assert np.array_equal(linkage.degrees(), degrees_by_products(linkage))


def test_degrees_of_exact_linkages():
    for linkage in (bennett_linkage(*gallery.THREE_POSES), *goldberg_linkages(*gallery.THREE_POSES, (1, 2))[::3]):
        assert np.array_equal(linkage.degrees(), degrees_by_products(linkage))


def test_opposite_joints_of_a_bennett_linkage_are_bonded():
    assert [bond.joints for bond in BENNETT.bonds()] == [(0, 2), (1, 3)]


def test_the_joint_that_turns_twice_has_two_bonds():
    for linkage in GOLDBERG:
        twice = linkage.joints.index(2)
        bonds = [bond.joints for bond in linkage.bonds()]
        assert len(bonds) == 3
        assert sum(twice in joints for joints in bonds) == 2
        assert not any(abs(a - b) in (0, 1, 4) for a, b in bonds)  # neighbours are never bonded


def test_two_of_five_links_see_each_other_move_by_cubics():
    degrees = GOLDBERG[0].degrees()
    opposite = [degrees[n, (n + 2) % 5] for n in range(5)]
    assert sorted(opposite) == [2, 2, 2, 3, 3]
    assert sorted(map(tuple, np.sort(degrees)))[0] == (0, 1, 1, 2, 2) or (0, 1, 2, 2, 2) in map(tuple, np.sort(degrees))


def test_the_6r_are_of_two_kinds():
    kinds = [sorted(linkage.degrees()[n, n + 3] for n in range(3)) for linkage in SIX]
    assert {tuple(kind) for kind in kinds} == {(3, 3, 3), (1, 3, 3)}
    angle_symmetric = [[bond.joints for bond in linkage.bonds()] == [(0, 3), (1, 4), (2, 5)] for linkage in SIX]
    assert angle_symmetric == [kind == [3, 3, 3] for kind in kinds]
    assert sum(angle_symmetric) * 3 == len(SIX)


def test_bonds_of_a_batch_and_its_nan_rows():
    batch = bennett_linkage(*random_poses(3, seed=4, shape=(3,)))
    bonds = batch.bonds()
    assert [bond.joints for bond in bonds] == [(0, 2), (1, 3)]
    assert np.allclose(bonds[0].quadratic[1], batch[1].bonds()[0].quadratic)


def test_all_factors_of_a_parallelogram_share_one_quadratic():
    assert [bond.joints for bond in PARALLELOGRAM.bonds()] == [(0, 2), (1, 3)]
    assert all(bond.quadratic.tolist() == [1, 0, 1] for bond in PARALLELOGRAM.bonds())


def test_a_bond_is_cut_if_one_joint_is_on_either_side():
    bond = Bond((1, 4), np.array([1, 0, 1]))
    assert [bond.is_cut(0, link) for link in range(6)] == [False, False, True, True, True, False]
    assert degrees_of([bond], 6)[2, 4] == 0
