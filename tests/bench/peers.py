"""The same work done by other packages (the optional extra ``bench``), each checked once before it is timed.

rational-linkages and biquaternion_py act with the opposite sign of ε.  ``python -m tests.bench.peers NAME`` times
one call of a slow one.
"""

import sys
from itertools import permutations
from time import perf_counter

import numpy as np

import kinlib as kl
from kinlib.gallery import FOUR_POSES
from kinlib.testing import random_poses

from . import work
from .clock import limited, timed

NAMES = ("biquaternion-py", "dqrobotics", "kingdon", "pytransform3d", "rational-linkages")
LIMIT = 30  # seconds that a slow peer may take


def kingdon_products(shape=()):
    """In PGA i, j, k are −e23, e13, −e12 and ε is e0123; kingdon has 1, e01, e02, e03, e12, e13, e23, e0123."""
    from kingdon import Algebra

    algebra, order, signs = Algebra(3, 0, 1), [0, 5, 6, 7, 3, 2, 1, 4], [1, 1, 1, 1, -1, 1, -1, 1]

    def multivector(q):
        values = [sign * q.components[n] for sign, n in zip(signs, order, strict=True)]
        return algebra.multivector(values=values, grades=(0, 2, 4))

    p, q = random_poses(2, seed=1, shape=shape)
    x, y = multivector(p), multivector(q)
    assert np.allclose((x * y).values(), multivector(p * q).values())
    return lambda: x * y


@timed
def kingdon_one_product(size):
    return kingdon_products()


@timed
def kingdon_batch(size):
    return kingdon_products((size,))


@timed
def dqrobotics_one_product(size):
    from dqrobotics import DQ

    p, q = random_poses(2, seed=1)
    x, y = DQ(p.coeffs), DQ(q.coeffs)
    assert np.allclose((x * y).vec8(), (p * q).coeffs)
    return lambda: x * y


@timed
def pytransform3d_batch(size):
    from pytransform3d.trajectories import batch_concatenate_dual_quaternions as product

    p, q = work.poses(2, size)
    x, y = p.coeffs.copy(), q.coeffs.copy()
    assert np.allclose(product(x, y), (p * q).coeffs)
    return lambda: product(x, y)


@timed
def pytransform3d_points(size):
    from pytransform3d.trajectories import batch_dq_prod_vector as act

    (pose,), x = work.poses(1, size), work.points(size)
    q = pose.coeffs.copy()
    assert np.allclose(act(q, x), kl.act(pose, x))
    return lambda: act(q, x)


def _rational(pose, **options):
    from rational_linkages import DualQuaternion

    return DualQuaternion(pose.eps_conjugate().coeffs.tolist(), **options)


def _exact_poses(count):
    return [_rational(pose, rational=True) for pose in FOUR_POSES[:count]]


@timed
def rational_one_product(size):
    p, q = random_poses(2, seed=1)
    x, y = _rational(p), _rational(q)
    assert np.allclose((x * y).array(), (p * q).eps_conjugate().coeffs)
    return lambda: x * y


@timed
def rational_one_point(size):
    from rational_linkages import PointHomogeneous

    (pose,), x = random_poses(1, seed=1), work.points(1)[0]
    q, point = _rational(pose), PointHomogeneous([1, *x])
    assert np.allclose(q.act(point).array(), [1, *kl.act(pose, x)])
    return lambda: q.act(point)


def rational_bennett() -> float:
    from rational_linkages import MotionInterpolation, RationalMechanism

    poses = _exact_poses(3)
    start = perf_counter()
    chains = MotionInterpolation.interpolate(poses).factorize()
    RationalMechanism(chains)
    seconds = perf_counter() - start
    axes = kl.bennett_linkage(*work.FLOAT_POSES[:3]).axes
    assert all(any(kl.same_point(axis, h, length=10) for axis in axes) for chain in chains for h in _half_turns(chain))
    return seconds


def _half_turns(chain):
    return [kl.axis_of(kl.DualQuaternion(h.array().astype(float)).eps_conjugate()) for h in chain.dq_axes]


def rational_six_r() -> float:
    """One 6R of each family: it has two of the six factorizations, hence one pair of the nine."""
    from rational_linkages import MotionInterpolation, RationalMechanism

    poses = _exact_poses(4)
    start = perf_counter()
    curves = [MotionInterpolation.interpolate(poses, motion_family=n) for n in range(2)]
    mechanisms = [RationalMechanism(curve.factorize()) for curve in curves]
    seconds = perf_counter() - start
    assert all(mechanism.num_joints == 6 for mechanism in mechanisms)
    return seconds


def rational_motion() -> float:
    from rational_linkages import MotionInterpolation

    curve = MotionInterpolation.interpolate(_exact_poses(4))
    parameters = np.linspace(-3, 3, work.PARAMETERS)
    start = perf_counter()
    poses = [curve.evaluate(t) for t in parameters]
    seconds = perf_counter() - start
    assert np.all(kl.STUDY_QUADRIC.contains(kl.DualQuaternion(np.array(poses))))
    return seconds


def _biquaternion_cubic():
    """The cubic as their polynomial, and the quadratic factors of its norm."""
    import biquaternion_py as bq
    from sympy import Symbol

    t = Symbol("t")
    coefficients = [bq.BiQuaternion(c.eps_conjugate().coeffs.tolist()) for c in work.cubic().coefficients]
    C = bq.Poly(sum((c * t**n for n, c in enumerate(reversed(coefficients))), 0 * bq.II), t)
    return C, bq.Poly(C.norm().poly.scal, t)


def biquaternion_factorizations() -> float:
    from biquaternion_py import factorize_from_list, irreducible_factors

    C, norm = _biquaternion_cubic()
    start = perf_counter()
    orders = permutations(irreducible_factors(norm, "RR")[1])
    factorizations = [factorize_from_list(C, list(order)) for order in orders]
    seconds = perf_counter() - start
    _check_first_factors([factors[0] for factors in factorizations])
    return seconds


def rational_two_factorizations() -> float:
    from rational_linkages.FactorizationProvider import FactorizationProvider

    C, _ = _biquaternion_cubic()
    start = perf_counter()
    factorizations = FactorizationProvider().factorize_polynomial(C)
    seconds = perf_counter() - start
    _check_first_factors([factors[0] for factors in factorizations])
    return seconds


def _check_first_factors(factors) -> None:
    ours = [h1.eps_conjugate().coeffs for h1, _, _ in kl.factorizations(work.cubic())]
    for factor in factors:
        h = -np.array(factor.all_coeffs()[0].args, dtype=float)
        assert any(np.allclose(h, k) for k in ours)


SLOW = (
    rational_bennett,
    rational_six_r,
    rational_motion,
    biquaternion_factorizations,
    rational_two_factorizations,
)


def slow(measure):
    """The sampler of a slow peer, in a process of its own."""
    return limited("tests.bench.peers", measure.__name__, LIMIT)


if __name__ == "__main__":
    print(next(measure for measure in SLOW if measure.__name__ == sys.argv[1])())
