"""What is measured: kinlib's work, and the yardsticks that always run."""

from contextlib import suppress
from copy import copy

import numpy as np
from scipy.optimize import least_squares

import kinlib as kl
from kinlib.gallery import FOUR_POSES, THREE_POSES
from kinlib.task_problem import TaskProblem
from kinlib.task_search import Search
from kinlib.testing import random_poses

from .clock import measured_in_bytes, timed

Z = 1 + 2j
PARAMETERS = 1000
FLOAT_POSES = [pose.astype(float) for pose in FOUR_POSES]


def cubic() -> kl.MotionPolynomial:
    """A monic cubic motion polynomial."""
    C = kl.cubics_through(*FLOAT_POSES)[0]
    return C * C.leading.inverse()


def poses(count: int, size: int) -> list[kl.DualQuaternion]:
    return random_poses(count, seed=1, shape=(size,))


def points(size: int) -> np.ndarray:
    return np.random.default_rng(2).normal(size=(size, 3))


def lines(size: int) -> kl.Line:
    a, b = points(2 * size).reshape(2, size, 3)
    return kl.Line.through(a, b)


@timed
def one_product(size):
    p, q = random_poses(2, seed=1)
    return lambda: p * q


@timed
def products(size):
    p, q = poses(2, size)
    return lambda: p * q


@timed
def copies(size):
    """Into memory that is there already: the cost of new memory depends on what the process did before."""
    operands = [pose.components for pose in poses(2, size)]
    copies = [np.zeros_like(x) for x in operands]
    return lambda: [np.copyto(*pair) for pair in zip(copies, operands, strict=True)]


@timed
def act_on_one_point(size):
    (pose,), x = random_poses(1, seed=1), points(1)[0]
    return lambda: kl.act(pose, x)


@timed
def act_on_points(size):
    (pose,), x = poses(1, size), points(size)
    return lambda: kl.act(pose, x)


@timed
def act_on_lines(size):
    (pose,), x = poses(1, size), lines(size)
    return lambda: kl.act(pose, x)


@timed
def one_bennett(size):
    return lambda: kl.bennett_linkage(*FLOAT_POSES[:3])


@timed
def bennett(size):
    three = poses(3, size)
    return lambda: kl.bennett_linkage(*three, degenerate="nan")


def _goldberg(size):
    three = poses(3, size)
    return lambda: kl.goldberg_linkages(*three, Z, degenerate="nan")


goldberg = timed(_goldberg)
goldberg_memory = measured_in_bytes(_goldberg)


def goldberg_result(size):
    """The bytes of the numbers in which the eight linkages differ: four new factors each."""
    return lambda: 8 * 4 * 8 * size * np.dtype(float).itemsize


@timed
def eigenvalues(size):
    matrices = np.random.default_rng(3).normal(size=(size, 4, 4))
    return lambda: np.linalg.eigvals(matrices)


@timed
def six_factorizations(size):
    C = cubic()
    return lambda: kl.factorizations(C)


@timed
def six_r(size):
    return lambda: kl.six_r_linkages(*FLOAT_POSES)


MANY = 10_000  # problems in a batch of 6R, and linkages whose bars are looked at


@timed
def six_r_batch(size):
    four = poses(4, min(size, MANY))
    return lambda: kl.six_r_linkages(*four, degenerate="nan")


@timed
def larger_eigenvalues(size):
    matrices = np.random.default_rng(3).normal(size=(min(size, MANY), 6, 6))
    return lambda: np.linalg.eigvals(matrices)


STARTS = 300  # chains that are followed to the end for each class of 5R


def _four_lines():
    """A home pose, and four places of a line."""
    home, *others = random_poses(5, seed=1)
    line = lines(1)[0]
    return home, [kl.task.Line(line, kl.act(pose, line)) for pose in others]


def _found_or_not(home, data, starts):
    with suppress(kl.NotFoundError):
        kl.goldberg_linkages_for(home, data, starts=starts)


@timed
def five_r_for_lines(size):
    home, data = _four_lines()
    return lambda: _found_or_not(home, data, min(STARTS, size))


@timed
def one_start_of_scipy(size):
    """The same equations and derivatives, one start, by SciPy's method of Levenberg and Marquardt."""
    search = Search((2, 1), TaskProblem.of(*_four_lines()).conditions())
    start = search.random(1, np.random.default_rng(0))
    zero = np.zeros(16)

    def values(step):
        return search.residuals(start.moved(step[:, None]))[:, 0]

    def slopes(step):
        return search.derivatives(start.moved(step[:, None]))[1][0]

    return lambda: least_squares(values, zero, slopes, method="lm", max_nfev=250)


@timed
def motion_of_axes(size):
    axes = kl.goldberg_linkages(*FLOAT_POSES[:3], Z)[0].axes
    return lambda: kl.Linkage.from_axes(axes)


@timed
def singular_values(size):
    columns = kl.goldberg_linkages(*FLOAT_POSES[:3], Z)[0].axes.coeffs[:, [1, 2, 3, 5, 6, 7]].T.copy()
    return lambda: np.linalg.svd(columns)


@timed
def exact_goldberg(size):
    return lambda: kl.goldberg_linkages(*THREE_POSES, (1, 3))


@timed
def exact_collisions(size):
    """Each time of a copy, which has not kept its axes and bars."""
    linkage = kl.goldberg_linkages(*THREE_POSES, (1, 3))[0]
    return lambda: copy(linkage).collisions()


@timed
def collisions(size):
    linkage = kl.goldberg_linkages(*poses(3, min(size, MANY)), Z, degenerate="nan")[0]
    return lambda: copy(linkage).collisions(degenerate="nan")


@timed
def motion(size):
    C, t = cubic(), np.linspace(-3, 3, PARAMETERS)
    return lambda: C(t)


@timed
def matrix_product(size):
    """Powers of the parameters times coefficients, (1000, 4) by (4, 8): the arithmetic of a cubic motion."""
    powers, coeffs = np.vander(np.linspace(-3, 3, PARAMETERS), 4), cubic().coeffs.copy()
    return lambda: powers @ coeffs


@timed
def best_of_many(size):
    """Of so many 5R linkages the ten with most room between their bars, for a brief, in one process."""
    side = max(1, round((size / 8) ** 0.5))
    grid, brief = kl.ZGrid(-3 - 3j, 3 + 3j, (side, side)), kl.Brief(longest_bar=3.0, smallest_angle=0.2, travel=6.0)
    return lambda: kl.search(*FLOAT_POSES[:3], grid, brief)
