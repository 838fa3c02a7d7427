"""What a datum costs, and which mixtures of data determine finitely many linkages: by exact ranks, all of them."""

import numpy as np
import pytest

from exact_count import (
    CODIMENSION,
    KINDS,
    ORIENTATION,
    PARAMETERS,
    Point,
    dimension,
    mixtures,
    obeys_the_rule,
    rank,
    settle,
)  # fmt: skip
from kinlib.task_count import COUNTS
from task_problems import problem

CLASSES = list(PARAMETERS)
NAMES = {(1, 1): "4R", (2, 1): "5R", (1, 2): "5R", (1, 1, 1): "6R"}
NUMBERS = {(1, 1): (219, 171), (2, 1): (416, 358), (1, 2): (416, 358), (1, 1, 1): (1249, 1057)}


@pytest.mark.parametrize("joints", CLASSES)
def test_t3_the_coupler_motions_have_10_12_and_16_parameters(joints):
    assert dimension(joints) == PARAMETERS[joints]


@pytest.mark.parametrize("joints", CLASSES)
def test_t4_the_rule_holds_for_every_kind_of_data(joints):
    """A regular matrix at one point proves that general data have finitely many linkages; where the rule is broken
    none is regular, since a part of the linkage has fewer parameters than its conditions."""
    kinds = mixtures(PARAMETERS[joints])
    regular = [kind for kind in kinds if obeys_the_rule(kind, joints)]
    assert (len(kinds), len(regular)) == NUMBERS[joints]
    assert [kind for kind in regular if settle(joints, kind) != 0] == []
    assert [kind for kind in set(kinds) - set(regular) if settle(joints, kind, seeds=(1,)) == 0] == []


@pytest.mark.parametrize("joints", CLASSES)
def test_the_count_of_the_package_is_the_rule(joints):
    count = COUNTS[NAMES[joints]]
    one_of = dict(zip(KINDS, problem(KINDS, seed=0).data, strict=True))
    for kind in mixtures(PARAMETERS[joints]):
        data = [one_of[name] for name in kind]
        refused = any(budget.exceeded_by(data) for budget in count.budgets)
        assert refused != obeys_the_rule(kind, joints)


def test_t4_two_poses_and_a_point_are_one_short_for_a_5r():
    kind = ("pose", "pose", "point")
    assert not obeys_the_rule(kind, (2, 1))
    assert [settle(joints, kind) for joints in ((2, 1), (1, 2))] == [1, 1]


def test_the_derivatives_are_those_of_the_motion():
    """The twists of the exact point against differences of floats."""
    point = Point((2, 1), 3)
    exact = point.at(2)[-1].astype(float)

    def pose(t):
        product = None
        for h in point.factors:
            product = t - h if product is None else product * (t - h)
        return product.astype(float)

    step = 1e-6
    change = (pose(2 + step) - pose(2 - step)) / (2 * step) * pose(2).conjugate()
    assert change.coeffs[[1, 2, 3, 5, 6, 7]] == pytest.approx(exact, rel=1e-6)


def test_the_rank_modulo_the_prime():
    random = np.random.default_rng(0)
    for size in (1, 5, 20):
        matrix = random.integers(-9, 10, (size + 3, size)) @ random.integers(-9, 10, (size, size + 1))
        assert rank(matrix) == np.linalg.matrix_rank(matrix)


def test_codimensions_are_those_of_the_package():
    data = problem(KINDS, seed=0).data
    for kind, of in zip(KINDS, data, strict=True):
        assert (of.codimension, of.orientation_codimension) == (CODIMENSION[kind], ORIENTATION[kind])
