"""The count: how many data determine finitely many linkages, and which ask too much of a part of them.

The coupler motions of 4R, 5R and 6R linkages through a home pose have 10, 12 and 16 parameters.  A datum of codimension
m costs m − 1, since the motion may meet it at any of its parameters.  Of this a dyad, whose poses have two parameters,
has to pay m − 2; the spherical motion of the orientations has its own budget.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from kinlib.errors import DegenerateError
from kinlib.task import Datum

__all__ = ["COUNTS", "Count"]


def _of_motion(datum: Datum) -> int:
    return datum.codimension - 1


def _of_dyad(datum: Datum) -> int:
    return datum.codimension - 2


def _of_spherical_motion(datum: Datum) -> int:
    return max(datum.orientation_codimension - 1, 0)


def _of_spherical_dyad(datum: Datum) -> int:
    return max(datum.orientation_codimension - 2, 0)


@dataclass(frozen=True)
class Budget:
    """A part of a linkage: what it is, how many parameters it has, and how many of them a datum takes."""

    part: str
    parameters: int
    cost: Callable[[Datum], int]
    rule: str

    def exceeded_by(self, data: Sequence[Datum]) -> list[Datum]:
        """The smallest choice of data that takes more than there is; none if all are paid."""
        chosen: list[Datum] = []
        for datum in sorted(data, key=self.cost, reverse=True):
            chosen.append(datum)
            if sum(map(self.cost, chosen)) > self.parameters:
                return chosen
        return []

    def refusal(self, data: Sequence[Datum]) -> str:
        """Who asks for how much."""
        named = ", ".join(f"{type(datum).__name__} ({datum.codimension})" for datum in data)
        costs = [self.cost(datum) for datum in data]
        return (
            f"{named} take {' + '.join(map(str, costs))} = {sum(costs)} of the {self.parameters} parameters of "
            f"{self.part} ({self.rule})"
        )


MOTION = "a datum of codimension m takes m − 1"
SURFACE = "a datum of codimension m takes m − 2"
SPHERE = "an orientation part of codimension o takes o − 1"
SPHERE_SURFACE = "an orientation part of codimension o takes o − 2"


@dataclass(frozen=True)
class Count:
    """The budgets of one kind of linkage, that of its coupler motions first."""

    name: str
    budgets: tuple[Budget, ...]

    def free(self, data: Sequence[Datum]) -> int:
        """How many parameters general data leave free; negative if they ask for too many."""
        whole = self.budgets[0]
        return whole.parameters - sum(map(whole.cost, data))

    def check(self, data: Sequence[Datum]) -> int:
        """How many parameters the data leave free.

        Raises
        ------
        DegenerateError
            If general data of these kinds have no solution, naming those that ask too much.
        """
        for budget in self.budgets:
            chosen = budget.exceeded_by(data)
            if chosen:
                raise DegenerateError(
                    f"general data of these kinds are met by no {self.name}: {budget.refusal(chosen)}"
                )
        return self.free(data)


def _motion(name: str, parameters: int) -> Budget:
    return Budget(f"the coupler motions of {name} linkages through the home pose", parameters, _of_motion, MOTION)


def _sphere(parameters: int) -> Budget:
    return Budget("the orientations along such a motion", parameters, _of_spherical_motion, SPHERE)


DYAD = Budget("the 2R dyad that carries the coupler", 8, _of_dyad, SURFACE)
PLANE = Budget("the plane in which the orientations along such a motion lie", 2, _of_spherical_dyad, SPHERE_SURFACE)
DIRECTIONS = Budget("the directions of the axes of that dyad", 4, _of_spherical_dyad, SPHERE_SURFACE)

COUNTS = {
    "4R": Count("4R", (_motion("4R", 10), DYAD, _sphere(6), PLANE)),
    "5R": Count("5R", (_motion("5R", 12), DYAD, _sphere(8), DIRECTIONS)),
    "6R": Count("6R", (_motion("6R", 16), _sphere(10))),
}
"""The counts by the name of the linkage."""
