"""Data that are met as well as can be: the linkages nearest to wishes among those that meet the other data.

Gauss and Newton's method in the directions that the data leave free, damped; the data themselves are kept by Newton's
method with the shortest steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinlib.task_search import MET, Search, Unknowns, shortened
from kinlib.typing import Array

__all__ = ["nearest_to_wishes", "with_parameters"]

STEPS = 300
"""The steps of one search."""

FIRST, KEPT = 40, 24
"""After so many steps only so many chains, those that miss the wishes least, are followed on."""

WEIGHT = 100.0
"""The data weigh so much more than the wishes where a step is judged that leaves them a little."""

LEVEL = 1e-6
"""The sum of squares is taken to be least where its slope is less than this."""


def with_parameters(search: Search, known: Unknowns) -> Unknowns:
    """Chains with parameters for some data, the first ones, and the best of some parameters for the others."""
    if len(known.phi) == search.conditions.count:
        return known
    missing = np.zeros((search.conditions.count - len(known.phi), known.count))
    guessed = search.nearest(known.at(np.concatenate([known.phi, missing]))).phi
    return known.at(np.concatenate([known.phi, guessed[len(known.phi) :]]))


def nearest_to_wishes(search: Search, unknowns: Unknowns, data: int) -> tuple[Unknowns, Array]:
    """Chains that meet the first data, and the others as well as possible; and the sums of squares by which they fail.

    The sum of squares is least among the chains next to each; those that do not arrive are left out.
    """
    state = _State.at(search, unknowns, data)
    damping = np.ones(unknowns.count)
    for number in range(STEPS):
        if number == FIRST:
            best = np.sort(np.argsort(state.merit, kind="stable")[:KEPT])
            state, damping = _State.at(search, state.unknowns.some(best), data), damping[best]
        tried = _State.at(search, state.unknowns.moved(shortened(state.step(damping)).T), data)
        nearer = tried.merit < state.merit
        state = state.chosen(nearer, tried)
        damping = np.where(nearer, np.maximum(damping / 4, 1e-12), np.minimum(damping * 4, 1e10))
    for _ in range(3):
        state = _State.at(search, state.unknowns.moved(state.back.T), data)
    arrived = ((state.off**2).sum(axis=1) < MET) & (state.slope < LEVEL)
    return state.unknowns.some(arrived), (state.wished[arrived] ** 2).sum(axis=1)


@dataclass
class _State:
    """Chains, by how much they miss the data and the wishes, and the derivatives of both."""

    unknowns: Unknowns
    off: Array
    wished: Array
    off_by: Array
    wished_by: Array

    @classmethod
    def at(cls, search: Search, unknowns: Unknowns, data: int) -> _State:
        values, matrix = search.derivatives(unknowns)
        hard = search.conditions.owners < data
        return cls(unknowns, values[hard].T, values[~hard].T, matrix[:, hard], matrix[:, ~hard])

    def chosen(self, where: Array, other: _State) -> _State:
        """The other chains at some places."""
        rest = [
            np.where(where.reshape(-1, *(1,) * (mine.ndim - 1)), theirs, mine)
            for mine, theirs in zip(self._arrays(), other._arrays(), strict=True)
        ]
        return _State(self.unknowns.chosen(where, other.unknowns), *rest)

    def _arrays(self) -> tuple[Array, ...]:
        return self.off, self.wished, self.off_by, self.wished_by

    @property
    def merit(self) -> Array:
        """What has to become less."""
        return (self.wished**2).sum(axis=1) + WEIGHT * (self.off**2).sum(axis=1)

    @cached_property
    def inverse(self) -> Array:
        """The pseudo-inverse of the derivatives of the data."""
        return np.linalg.pinv(self.off_by, rcond=1e-10)

    @cached_property
    def back(self) -> Array:
        """The shortest step that meets the data, shape (chains, unknowns)."""
        return -(self.inverse @ self.off[..., None])[..., 0]

    @cached_property
    def free(self) -> Array:
        """The projections to the directions in which nothing about the data changes."""
        return np.eye(self.off_by.shape[-1]) - self.inverse @ self.off_by

    def step(self, damping: Array) -> Array:
        """The step that meets the data, and the wishes as well as possible, shape (chains, unknowns)."""
        slopes = self.wished_by @ self.free
        left = self.wished[..., None] + self.wished_by @ self.back[..., None]
        transposed = np.swapaxes(slopes, 1, 2)
        normal = transposed @ slopes
        diagonal = np.einsum("nii->ni", normal)
        diagonal += damping[:, None] * (diagonal.mean(axis=-1, keepdims=True) + 1e-12) * 0.1 + 1e-14
        return self.back - (self.free @ np.linalg.solve(normal, transposed @ left))[..., 0]

    @property
    def slope(self) -> Array:
        """The largest derivative of half the sum of squares in the free directions."""
        slopes = np.swapaxes(self.wished_by @ self.free, 1, 2) @ self.wished[..., None]
        return np.abs(slopes).max(axis=(1, 2), initial=0)
