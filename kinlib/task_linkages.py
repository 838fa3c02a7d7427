"""4R, 5R and 6R linkages that meet data of every kind that the count allows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from kinlib.dual_quaternion import DualQuaternion, null_form
from kinlib.errors import DegenerateError, NotFoundError
from kinlib.factorization import bennett_flip, exchange, factorizations
from kinlib.linkage import Linkage
from kinlib.motion_polynomial import MotionPolynomial
from kinlib.polishing import product_of
from kinlib.scalar import RTOL
from kinlib.six_r import ADMISSIBLE_PAIRS
from kinlib.task import Datum
from kinlib.task_count import COUNTS
from kinlib.task_problem import TaskProblem
from kinlib.task_search import Search, Unknowns
from kinlib.task_wishes import nearest_to_wishes, with_parameters
from kinlib.typing import Array, PoseLike

__all__ = ["bennett_linkages_for", "goldberg_linkages_for", "linkages_of", "six_r_linkages_for"]

Progress = Callable[[float], None]
"""Is told which part of a search is done, from 0 to 1."""

CHAINS = {"4R": ((1, 1),), "5R": ((2, 1), (1, 2)), "6R": ((1, 1, 1),)}
"""How many factors the joints of the first chain have: for 5R there are two classes of cubics."""

MISSED = 1e-10
"""A datum is met if it is missed by no more than this, in radians and in parts of the size of the problem."""

SAME = 1e-6
"""Motions whose coefficients differ by less than this are the same; numbers z this near to a bad place are left out."""


def bennett_linkages_for(
    home: PoseLike,
    data: Sequence[Datum],
    *,
    starts: int = 300,
    seed: int = 0,
    fill: bool = False,
    wishes: Sequence[Datum] = (),
    progress: Progress | None = None,
) -> tuple[Linkage, ...]:
    """All Bennett linkages found whose couplers meet data from a home pose: as :func:`goldberg_linkages_for`.

    General data determine finitely many if the sum of codimension − 1 is 10: two poses, for which there is one, or two
    lines and a point with a direction.

    Examples
    --------
    >>> from kinlib import task
    >>> from kinlib.gallery import THREE_POSES
    >>> home, *others = THREE_POSES
    >>> bennett_linkages_for(home, [task.Pose(pose) for pose in others], starts=20)[0].joint_count
    4
    """
    return _linkages_for("4R", home, data, starts, seed, fill, wishes, progress)


def goldberg_linkages_for(
    home: PoseLike,
    data: Sequence[Datum],
    *,
    starts: int = 300,
    seed: int = 0,
    fill: bool = False,
    wishes: Sequence[Datum] = (),
    progress: Progress | None = None,
) -> tuple[Linkage, ...]:
    """All 5R linkages found whose couplers meet data from a home pose.

    A datum of codimension m costs m − 1, and general data determine finitely many linkages if these costs have the sum
    12 and none asks too much of the dyad that carries the coupler.  The search starts from random chains, so it may
    miss some linkages; those that it finds are right.

    Parameters
    ----------
    home : PoseLike
        The pose of the coupler at t = ∞; any.
    data : sequence of :class:`task.Datum`
        Such as ``task.Pose``, ``task.Line``, ``task.Point``, in any order.
    starts : int
        How many chains are followed to the end for each of the two classes of cubics; each is the best of eight.
    seed : int
        Of the random chains; the same seed finds the same linkages.
    fill : bool
        Whether parameters that the data leave free are filled: each start then leads to the linkage next to it in
        the sense of least squares, and there are as many linkages as starts that led to one.
    wishes : sequence of :class:`task.Datum`
        Further data, as many as you like, for the parameters that the data leave free: of the linkages that meet the
        data, those are sought that miss the wishes least, in the sum of the squares of angles and of distances in
        parts of the size of the problem.  :func:`task.residuals` says by how much.
    progress : callable, optional
        Is told which part of the search is done, from 0 to 1.

    Returns
    -------
    tuple of Linkage
        Two for each cubic motion, which share it; compact ones first, or those that miss the wishes least.  Their
        ``parameters`` are those at which they are at home, meet the data, and are nearest to the wishes.  Each was
        checked: all data are met to 1e-10 of the size of the problem, the loop is closed, its mobility is one.

    Raises
    ------
    DegenerateError
        If the data ask for too much, naming them, or leave parameters free.
    NotFoundError
        If nothing was found; this does not mean that there is nothing.

    Examples
    --------
    >>> from kinlib import one, task
    >>> goldberg_linkages_for(one, [task.Pose(i), task.Pose(1 + j - eps * i), task.Point([0, 0, 0], [1, 2, 3])])
    Traceback (most recent call last):
    ...
    kinlib.errors.DegenerateError: general data of these kinds are met by no 5R: Pose (6), Pose (6), Point (3) take \
4 + 4 + 1 = 9 of the 8 parameters of the 2R dyad that carries the coupler (a datum of codimension m takes m − 2)
    """
    return _linkages_for("5R", home, data, starts, seed, fill, wishes, progress)


def six_r_linkages_for(
    home: PoseLike,
    data: Sequence[Datum],
    *,
    starts: int = 300,
    seed: int = 0,
    fill: bool = False,
    wishes: Sequence[Datum] = (),
    progress: Progress | None = None,
) -> tuple[Linkage, ...]:
    """All 6R linkages found whose couplers meet data from a home pose: as :func:`goldberg_linkages_for`.

    The sum of codimension − 1 has to be 16: eight points, for instance, or three poses and a direction.  There are
    nine linkages for each cubic motion.

    Examples
    --------
    >>> from kinlib import one, task
    >>> six_r_linkages_for(one, [task.Point([0, 0, 0], [n, 1, n * n]) for n in range(7)])
    Traceback (most recent call last):
    ...
    kinlib.errors.DegenerateError: the data leave 2 of the 16 parameters of 6R linkages free: ask for more, or \
give wishes or fill=True
    """
    return _linkages_for("6R", home, data, starts, seed, fill, wishes, progress)


def _linkages_for(
    name: str,
    home: PoseLike,
    data: Sequence[Datum],
    starts: int,
    seed: int,
    fill: bool,
    wishes: Sequence[Datum],
    progress: Progress | None,
) -> tuple[Linkage, ...]:
    starts, seed = (_whole(x, what) for x, what in ((starts, "starts"), (seed, "seed")))
    problem = TaskProblem.of(home, data, wishes)
    free = COUNTS[name].check(problem.data)
    if free and not fill and not problem.wishes:
        whole = COUNTS[name].budgets[0].parameters
        raise DegenerateError(
            f"the data leave {free} of the {whole} parameters of {name} linkages free: ask for more, or "
            "give wishes or fill=True"
        )
    if not problem.data and not problem.wishes:
        raise ValueError("expected at least one datum or wish: without any, there is nothing to search for")
    problem.check_independent()
    found: list[tuple[float, float, Linkage]] = []
    families = 0
    for number, joints in enumerate(CHAINS[name]):
        told = _part(progress, number, len(CHAINS[name]))
        search = Search(joints, problem.conditions(wishes=True))
        solutions, missed = _solutions(problem, search, starts, (seed, number), told)
        isolated = search.is_isolated(solutions) if not free and not problem.wishes else np.ones(len(missed), bool)
        families += int(np.count_nonzero(~isolated))
        for row in np.flatnonzero(isolated).tolist():
            reach = _reach(solutions, row)
            found += [(missed[row], reach, linkage) for linkage in linkages_of(problem, search, solutions, row)]
    if not found and families:
        raise DegenerateError(
            f"the data lie in a special way: {families} motions of {name} linkages were found, and each can be changed "
            "without end while it meets them; ask for other data"
        )
    if not found:
        raise NotFoundError(
            f"no real {name} linkage was found from {starts} starts with seed {seed} for each of the "
            f"{len(CHAINS[name])} classes of chains; that does not say that there is none: try more starts"
        )
    return tuple(linkage for *_, linkage in sorted(found, key=lambda row: row[:2]))


def _solutions(
    problem: TaskProblem, search: Search, starts: int, seed: Sequence[int], progress: Progress | None
) -> tuple[Unknowns, Array]:
    """The different solutions, in the balanced parameter, and the sums of squares by which they miss the wishes."""
    if problem.data:
        data = Search(search.joints, problem.conditions())
        solutions = with_parameters(search, distinct(data, data.found(starts, seed, progress)))
    else:
        solutions = search.random(starts, np.random.default_rng(seed))
    missed = np.zeros(solutions.count)
    if problem.wishes:
        solutions, missed = nearest_to_wishes(search, solutions, len(problem.data))
        order = np.argsort(missed, kind="stable")
        solutions, missed = solutions.some(order), missed[order]
        kept = different(search, solutions)
        solutions, missed = solutions.some(kept), missed[kept]
    return balanced(solutions), np.round(missed, 20)


def _whole(x: int, what: str) -> int:
    """A whole number that is not negative; of starts at least one."""
    least = 1 if what == "starts" else 0
    if isinstance(x, bool) or not isinstance(x, int | np.integer):
        raise TypeError(f"expected {what} as a whole number, got {x!r}")
    if x < least:
        raise ValueError(f"expected {what} of at least {least}, got {x}")
    return int(x)


def _part(progress: Progress | None, number: int, count: int) -> Progress | None:
    return progress and (lambda done: progress((number + done) / count))


def _reach(solutions: Unknowns, row: int) -> float:
    """How far the axes of a chain are from the middle."""
    return float(np.linalg.norm(solutions.p[..., row], axis=0).max())


def distinct(search: Search, solutions: Unknowns) -> Unknowns:
    """Each solution once, without those whose cubic is a motion of lower degree or belongs to no linkage."""
    return solutions.some(different(search, solutions))


def different(search: Search, solutions: Unknowns) -> Array:
    """The numbers of the solutions that :func:`distinct` takes."""
    regular = np.flatnonzero(_is_regular(search, solutions))
    solutions = solutions.some(regular)
    numbers, kept = coefficients(search, solutions), np.zeros(solutions.count, dtype=bool)
    mirrored = numbers * np.array([(-1.0) ** n for n in range(1, numbers.shape[1] + 1)])[:, None]
    size = np.abs(numbers).max(axis=(1, 2), initial=1)
    for row in range(len(kept)):
        apart = [np.abs(x[kept] - numbers[row]).max(axis=(1, 2), initial=0) for x in (numbers, mirrored)]
        kept[row] = not (np.minimum(*apart) < SAME * size[row]).any()
    return regular[kept]


def _is_regular(search: Search, solutions: Unknowns) -> Array:
    """Whether all joints turn, those that turn twice do not turn back, and neighbours are different."""
    z, size = solutions.z, np.abs(solutions.z).max(axis=0, initial=1)
    fine = (np.abs(z.imag) > SAME * size).all(axis=0)
    owner = np.repeat(np.arange(len(search.joints)), search.joints)
    for m, n in pairwise(range(len(owner))):
        near = np.abs(z[m] - z[n].conj()) <= SAME * size
        same_quadratic = near | (np.abs(z[m] - z[n]) <= SAME * size)
        fine &= ~(near if owner[m] == owner[n] else same_quadratic & (len(search.joints) == 2))
    for m, n in pairwise(range(len(search.joints))):
        parallel = np.linalg.norm(np.cross(solutions.l[:, m], solutions.l[:, n], axis=0), axis=0) < SAME
        fine &= ~parallel
    return fine


def coefficients(search: Search, solutions: Unknowns) -> Array:
    """The coefficients of the monic motions in the balanced parameter, shape (rows, degree, 8)."""
    product = product_of(factors_of(search, balanced(solutions)))
    return np.stack([c.coeffs for c in product[1:]], axis=1)


def balanced(solutions: Unknowns) -> Unknowns:
    """The same chains with t such that the z have a mean on the imaginary axis, and imaginary parts of square sum 1.

    So all chains of one motion have the same t, up to its sign.
    """
    shift = solutions.z.real.mean(axis=0)
    scale = np.sqrt((solutions.z.imag**2).sum(axis=0))
    c, s = np.cos(solutions.phi), np.sin(solutions.phi)
    phi = np.arctan2(scale * s, c - shift * s)
    return Unknowns(solutions.l, solutions.p, (solutions.z - shift) / scale, phi)


def factors_of(search: Search, solutions: Unknowns) -> list[DualQuaternion]:
    """The linear factors of the chains, about the middle; each of shape (rows,)."""
    owner = np.repeat(np.arange(len(search.joints)), search.joints)
    factors = []
    for n, joint in enumerate(owner):
        l, p, z = solutions.l[:, joint], solutions.p[:, joint], solutions.z[n]
        turn = [z.real, *(z.imag * l), np.zeros_like(z.real), *(z.imag * np.cross(p, l, axis=0))]
        factors.append(DualQuaternion.from_components(np.stack(turn)))
    return factors


def linkages_of(problem: TaskProblem, search: Search, solutions: Unknowns, row: int) -> Iterator[Linkage]:
    """The linkages of one solution that stand the check.

    The parameter and the order of factors are those that every start would give: t is balanced, it is positive at the
    first datum that is farthest from 0 and ∞, and the factor with the smaller real part stands first.
    """
    phi = solutions.phi[:, row]
    slope = np.sin(2 * phi)
    farthest = np.abs(slope) >= 0.99 * np.abs(slope).max()
    sign = -1 if slope[farthest.argmax()] < 0 else 1
    with np.errstate(divide="ignore"):
        parameters = (np.inf, *np.where(np.sin(phi) == 0, np.inf, sign * np.cos(phi) / np.sin(phi)).tolist())
    chain = _in_order(search.joints, tuple(sign * h[row] for h in factors_of(search, solutions)))
    for first, second, joints in _loops(search.joints, chain):
        halves = [[problem.outward(h) for h in half] for half in (first, second)]
        try:
            linkage = Linkage.from_chains(*halves, home=problem.home, joints=joints, parameters=parameters)
        except ValueError:  # it does not close: factors that nearly agree have been exchanged
            continue
        if _holds(problem, linkage):
            yield linkage


def _in_order(joints: tuple[int, ...], chain: tuple[DualQuaternion, ...]) -> tuple[DualQuaternion, ...]:
    """The same motion with factors that may be exchanged in the order of their real parts."""
    if joints == (1, 1) and not _stands_first(*chain):
        return bennett_flip(*chain)
    first = joints.index(2) if 2 in joints else None
    if first is None or _stands_first(*chain[first : first + 2]):
        return chain
    return (*chain[:first], chain[first + 1], chain[first], *chain[first + 2 :])


def _stands_first(h: DualQuaternion, k: DualQuaternion) -> bool:
    """Whether h has the smaller real part; if they have the same, whether it turns slower."""
    apart = float(h.scalar_part - k.scalar_part)
    return apart < 0 if abs(apart) > RTOL else bool(null_form(h, h) <= null_form(k, k))


def _loops(joints: tuple[int, ...], chain: tuple[DualQuaternion, ...]) -> Iterator[tuple]:  # type: ignore[type-arg]
    """The pairs of chains that carry one motion, and the factors of their joints."""
    if joints == (1, 1):
        yield chain, bennett_flip(*chain), (1, 1, 1, 1)
    elif joints == (1, 1, 1):
        all_six = factorizations(MotionPolynomial.from_factors(chain))
        yield from ((all_six[m], all_six[n], (1,) * 6) for m, n in ADMISSIBLE_PAIRS)
    else:  # the factor of the joint that turns once is brought to the other end
        places = (1, 0) if joints == (2, 1) else (0, 1)
        twice = slice(0, 2) if joints == (2, 1) else slice(1, 3)
        for pair in (chain[twice], chain[twice][::-1]):
            start = (*pair, chain[2]) if joints == (2, 1) else (chain[0], *pair)
            yield chain, exchange(exchange(start, places[0]), places[1]), (*joints, 1, 1, 1)


def _holds(problem: TaskProblem, linkage: Linkage) -> bool:
    """Whether a linkage meets all data, is closed, and has mobility one."""
    allowed = MISSED + problem.noise
    poses = [linkage.coupler_motion(t) for t in linkage.parameters[1 : len(problem.data) + 1]]
    missed = [problem.missed(pose, datum) for pose, datum in zip(poses, problem.data, strict=True)]
    closed = linkage.closure_residual() <= RTOL
    return closed and max(missed, default=0) <= allowed and linkage.mobility() == 1
