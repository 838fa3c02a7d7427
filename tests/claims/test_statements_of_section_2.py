"""Section 2: dual quaternions, Study quadric and kinematic mapping."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy

from kinlib import (
    EXCEPTIONAL_SPACE,
    STUDY_QUADRIC,
    DualQuaternion,
    act,
    as_matrix,
    eps,
    from_matrix,
    i,
    j,
    join,
    k,
    one,
    same_point,
    study_form,
    translation,
)
from problems import whole_poses

BASIS = [one, i, j, k, eps, eps * i, eps * j, eps * k]


def symbols(name: str) -> DualQuaternion:
    return DualQuaternion(sympy.symbols(f"{name}0:8", real=True))


def vanishes(q: DualQuaternion) -> bool:
    return all(sympy.expand(c) == 0 for c in q.coeffs)


def test_eight_dimensional_associative_algebra_with_central_epsilon():
    """P1: associativity is trilinear, so the basis decides."""
    assert join(*BASIS).dimension == 7
    assert all((p * q) * r == p * (q * r) for p, q, r in product(BASIS, repeat=3))
    assert all(eps * q == q * eps for q in BASIS)
    assert eps * eps == 0
    assert i * j != j * i


def test_conjugation_reverses_products():
    """P2."""
    q, r = symbols("q"), symbols("r")
    assert vanishes((q * r).conjugate() - r.conjugate() * q.conjugate())
    assert not vanishes((q * r).conjugate() - q.conjugate() * r.conjugate())


def test_the_norm_is_a_dual_number_and_multiplicative():
    """P3."""
    q, r = symbols("q"), symbols("r")
    assert vanishes(q * q.conjugate() - q.norm())
    assert all(c == 0 for c in q.norm().coeffs[[1, 2, 3, 5, 6, 7]])
    assert vanishes((q * r).norm() - q.norm() * r.norm())


def test_the_study_quadric_is_regular_of_signature_four_four():
    """P4."""
    q = symbols("q")
    p, d = q.primal, q.dual
    assert vanishes(p * d.conjugate() + d * p.conjugate() - study_form(q, q) * one)
    assert sympy.expand(q.norm().coeffs[4] - study_form(q, q)) == 0
    assert STUDY_QUADRIC.rank() == 8
    assert STUDY_QUADRIC.signature() == (4, 4)


def test_the_action_is_a_rigid_displacement():
    """P5: for q = (1 + ½εv)p in symbols."""
    v, p = sympy.symbols("v1:4", real=True), sympy.symbols("p0:4", real=True)
    q = translation(v) * DualQuaternion([*p, 0, 0, 0, 0])
    T = as_matrix(q)
    R = sympy.Matrix(T[:3, :3])
    assert (R * R.T - sympy.eye(3)).applyfunc(sympy.cancel) == sympy.zeros(3)
    assert sympy.cancel(R.det()) == 1
    assert [sympy.cancel(x - y) for x, y in zip(T[:3, 3], v, strict=True)] == [0, 0, 0]


def test_the_action_does_not_depend_on_the_representative():
    """P5."""
    for pose in whole_poses(10, seed=1):
        points = np.array([[0, 0, 0], [1, 2, 3], [-1, 0, 5]])
        assert (act(pose, points) == act(pose * -7, points)).all()
        image = pose * (1 + eps * (i + 2 * j + 3 * k)) * pose.eps_conjugate().conjugate()
        assert image.primal == image.scalar_part * one
        assert (image.coeffs[5:] == act(pose, [1, 2, 3]) * image.scalar_part).all()


def test_products_are_compositions_and_the_mapping_is_one_to_one():
    """P6."""
    poses = whole_poses(8, seed=2)
    for p, q in product(poses, repeat=2):
        assert (as_matrix(p * q) == as_matrix(p) @ as_matrix(q)).all()
        assert same_point(p, q) == (as_matrix(p) == as_matrix(q)).all()
    for pose in poses:
        assert same_point(from_matrix(as_matrix(pose)), pose)
    with pytest.raises((ValueError, ZeroDivisionError)):
        as_matrix(eps * i)
    assert STUDY_QUADRIC.contains(EXCEPTIONAL_SPACE)
