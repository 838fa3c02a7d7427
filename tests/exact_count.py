"""The count of data, proved kind by kind: exact ranks at points with whole coordinates.

python -m tests.exact_count     all kinds of 4R, 5R (both classes) and 6R

For n data of codimensions m the pairs of a linkage with parameters t_1, …, t_n and data that it meets there form an
irreducible variety W, and if Σ (m − 1) is the number of parameters of the coupler motions, W and the space of the data
have the same dimension.  The kernel of the projection's derivative at a point of W is the kernel of a square matrix:
how the conditions change with the parameters of the motion and with the t_n.  So if this matrix is regular at one
point, general complex data have finitely many linkages and at least one; and near the data of a real such point all
real data have a real one.  All numbers here are whole, and a rank modulo a prime is never above the true one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import accumulate
from operator import mul

import numpy as np

from kinlib import DualQuaternion, Line, one

PRIME = 2**31 - 1

KINDS = ("pose", "point and direction", "line", "point", "orientation", "point on line", "direction")
CODIMENSION = dict(zip(KINDS, (6, 5, 4, 3, 3, 2, 2), strict=True))
ORIENTATION = dict(zip(KINDS, (3, 2, 2, 0, 3, 0, 2), strict=True))

PARAMETERS = {(1, 1): 10, (2, 1): 12, (1, 2): 12, (1, 1, 1): 16}
"""The parameters of the coupler motions by the numbers of factors of the joints."""


def mixtures(total: int) -> list[tuple[str, ...]]:
    """All kinds of data with Σ (codimension − 1) = total."""

    def rest(first: int, left: int):
        if left == 0:
            yield ()
        for n in range(first, len(KINDS)):
            if CODIMENSION[KINDS[n]] - 1 <= left:
                yield from ((KINDS[n], *more) for more in rest(n, left - CODIMENSION[KINDS[n]] + 1))

    return list(rest(0, total))


def obeys_the_rule(mixture: tuple[str, ...], joints: tuple[int, ...]) -> bool:
    """The rule: no part of the linkage is asked for too much."""
    dyad = sum(CODIMENSION[kind] - 2 for kind in mixture)
    sphere = sum(max(ORIENTATION[kind] - 1, 0) for kind in mixture)
    surface = sum(max(ORIENTATION[kind] - 2, 0) for kind in mixture)
    if joints == (1, 1, 1):
        return sphere <= 10
    return dyad <= 8 and (sphere <= 6 and surface <= 2 if joints == (1, 1) else sphere <= 8 and surface <= 4)


@dataclass(frozen=True)
class Point:
    """A chain with whole coordinates, at as many parameters as there may be data.

    Its axes have directions (u, v, 1) and pass through (p, q, 0); its factors are t − x − y h.
    """

    joints: tuple[int, ...]
    seed: int

    @cached_property
    def random(self) -> np.random.Generator:
        return np.random.default_rng(self.seed)

    @cached_property
    def axes(self) -> list[np.ndarray]:
        return [_whole(self.random, 4) for _ in self.joints]

    @cached_property
    def numbers(self) -> list[np.ndarray]:
        return [_whole(self.random, 2) for _ in range(sum(self.joints))]

    @cached_property
    def factors(self) -> list[DualQuaternion]:
        """The h of the factors."""
        turns = [_half_turn(axis) for axis in self.axes]
        owners = np.repeat(np.arange(len(self.joints)), self.joints)
        return [int(x) + int(y) * turns[n] for n, (x, y) in zip(owners, self.numbers, strict=True)]

    @cached_property
    def slopes(self) -> list[list[tuple[int, DualQuaternion]]]:
        """For each parameter, which factors it changes and how: four for each axis, then x and y of each factor."""
        ends = list(accumulate(self.joints, initial=0))
        changes = []
        for n, axis in enumerate(self.axes):
            for c in range(4):
                slope = _slope(axis, c)
                changes.append([(m, slope * int(self.numbers[m][1])) for m in range(ends[n], ends[n + 1])])
        for n, axis in enumerate(self.axes):
            for m in range(ends[n], ends[n + 1]):
                changes += [[(m, one)], [(m, _half_turn(axis))]]
        return changes

    def at(self, t: int) -> np.ndarray:
        """The twists of the pose at t by all parameters but those of the last factor, and by t; shape (n + 1, 6)."""
        terms = [t - h for h in self.factors]
        pose = reduce(mul, terms)
        velocities = [sum((_with(terms, m, -change) for m, change in changes), one * 0) for changes in self.slopes[:-2]]
        velocities.append(sum((_with(terms, m, one) for m in range(len(terms))), one * 0))
        return np.array([(v * pose.conjugate()).coeffs[[1, 2, 3, 5, 6, 7]].astype(object) for v in velocities])

    @cached_property
    def blocks(self) -> list[dict[str, np.ndarray]]:
        """For each of 16 parameters t, how the conditions of a datum of each kind change, shape (rows, n + 1)."""
        return [self._conditions(self.at(int(t))) for t in self.random.permutation(np.arange(-30, 31))[:16]]

    def _conditions(self, twists: np.ndarray) -> dict[str, np.ndarray]:
        turns, shifts = twists[:, :3], twists[:, 3:]
        place, direction, line = (_whole(self.random, 3) for _ in range(3))
        arriving = np.cross(turns, place) + shifts
        aiming = np.cross(turns, direction)
        rows = {
            "pose": (turns, arriving),
            "point and direction": (arriving, aiming),
            "line": (aiming, np.cross(arriving, direction)),
            "point": (arriving,),
            "orientation": (turns,),
            "point on line": (np.cross(arriving, line),),
            "direction": (aiming,),
        }
        return {kind: (np.concatenate(parts, axis=1).T % PRIME).astype(np.int64) for kind, parts in rows.items()}

    def deficiency(self, mixture: tuple[str, ...]) -> int:
        """By how much the columns exceed the rank modulo the prime."""
        blocks = [self.blocks[n][kind] for n, kind in enumerate(mixture)]
        common, count = PARAMETERS[self.joints], len(mixture)
        matrix = np.zeros((sum(map(len, blocks)), common + count), dtype=np.int64)
        row = 0
        for n, block in enumerate(blocks):
            matrix[row : row + len(block), :common] = block[:, :-1]
            matrix[row : row + len(block), common + n] = block[:, -1]
            row += len(block)
        return matrix.shape[1] - rank(matrix)


def rank(matrix: np.ndarray) -> int:
    """The rank of whole numbers modulo the prime: at most that over the rationals."""
    matrix, found = matrix % PRIME, 0
    for column in range(matrix.shape[1]):
        pivots = np.flatnonzero(matrix[found:, column])
        if not len(pivots):
            continue
        matrix[[found, found + pivots[0]]] = matrix[[found + pivots[0], found]]
        row = matrix[found] * pow(int(matrix[found, column]), -1, PRIME) % PRIME
        below = matrix[found + 1 :]
        below -= below[:, column, None] * row % PRIME
        below %= PRIME
        found += 1
    return found


def dimension(joints: tuple[int, ...], seed: int = 1) -> int:
    """The dimension of the coupler motions: the rank of all coefficients, less 2 for t ↦ a t + b."""
    point = Point(joints, seed)
    slopes = [np.concatenate([v.coeffs for v in _coefficients(point, changes)]) for changes in point.slopes]
    shift, stretch = [(n, one) for n in range(len(point.factors))], list(enumerate(point.factors))
    moves = [np.concatenate([v.coeffs for v in _coefficients(point, changes)]) for changes in (shift, stretch)]
    whole = [np.array(rows, dtype=object) % PRIME for rows in (slopes, moves, slopes + moves)]
    ranks = [rank(x.astype(np.int64)) for x in whole]
    assert ranks[2] == ranks[0]
    return ranks[0] - ranks[1]


def _coefficients(point: Point, changes) -> list[DualQuaternion]:
    """The change of the coefficients of (t − h_1) ⋯ (t − h_n)."""
    total = [one * 0] * len(point.factors)
    for m, change in changes:
        product = [one]
        for n, h in enumerate(point.factors):
            if n == m:
                product = [c * -change for c in product]
            else:
                low, high = [c * -h for c in product] + [one * 0], [one * 0, *product]
                product = [a + b for a, b in zip(low, high, strict=True)]
        total = [a + b for a, b in zip(total, product, strict=True)]
    return total


def _whole(random: np.random.Generator, count: int) -> np.ndarray:
    return random.integers(1, 9, count) * random.choice([-1, 1], count)


def _half_turn(axis: np.ndarray) -> DualQuaternion:
    u, v, p, q = (int(x) for x in axis)
    return Line.at([p, q, 0], [u, v, 1]).as_dual_quaternion()


def _slope(axis: np.ndarray, coordinate: int) -> DualQuaternion:
    """The change of l + ε a × l with a coordinate; it is linear in each."""
    step = np.eye(4, dtype=int)[coordinate]
    return _half_turn(axis + step) - _half_turn(axis)


def _with(terms: list[DualQuaternion], m: int, change: DualQuaternion) -> DualQuaternion:
    return reduce(mul, [*terms[:m], change, *terms[m + 1 :]])


def settle(joints: tuple[int, ...], mixture: tuple[str, ...], seeds=range(1, 5)) -> int:
    """The least deficiency at some points."""
    return min(POINTS.setdefault((joints, seed), Point(joints, seed)).deficiency(mixture) for seed in seeds)


POINTS: dict[tuple[tuple[int, ...], int], Point] = {}


def main() -> int:
    """Settle all kinds and print how many there are."""
    wrong = 0
    for joints, total in PARAMETERS.items():
        assert dimension(joints) == total
        all_kinds = mixtures(total)
        regular = [mixture for mixture in all_kinds if obeys_the_rule(mixture, joints)]
        lacking = {mixture: settle(joints, mixture, range(1, 3)) for mixture in all_kinds}
        bad = [mixture for mixture in all_kinds if (lacking[mixture] == 0) != obeys_the_rule(mixture, joints)]
        wrong += len(bad)
        print(
            f"joints {joints}: {total} parameters, {len(all_kinds)} kinds of data; {len(regular)} obey the rule, "
            f"{sum(x == 0 for x in lacking.values())} are regular at a point with whole coordinates; "
            f"against the rule: {bad or 'none'}"
        )
    return wrong


if __name__ == "__main__":
    raise SystemExit(main())
