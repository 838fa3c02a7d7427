"""Counts outcomes and prints them as tables."""

from __future__ import annotations

import math
from collections import Counter, defaultdict

from tests.fuzz.trial import BANDS, GOOD


def _head(*columns: str) -> list[str]:
    names = (*columns, "problems", *BANDS, "worst/allowed")
    return [f"| {' | '.join(names)} |", "|---" * len(names) + "|"]


class Report:
    """The outcomes, counted."""

    def __init__(self, outcomes):
        self.outcomes = outcomes
        self.cells = defaultdict(Counter)
        self.worst = defaultdict(float)
        for outcome in outcomes:
            distribution, distance = outcome.name.split("/")[1:3]
            key = (outcome.function, distribution, distance)
            self.cells[key][outcome.band] += 1
            if math.isfinite(outcome.excess):
                self.worst[key] = max(self.worst[key], outcome.excess)

    def good(self) -> bool:
        return all(outcome.band in GOOD for outcome in self.outcomes)

    def _row(self, keys) -> str:
        counts = sum((self.cells[key] for key in keys), Counter())
        worst = max(self.worst[key] for key in keys)
        return " | ".join([str(sum(counts.values())), *(str(counts[band] or "") for band in BANDS), f"{worst:.0e}"])

    def summary(self) -> str:
        """One line for each distribution, all distances together."""
        groups = defaultdict(list)
        for function, distribution, distance in self.cells:
            groups[function, distribution].append((function, distribution, distance))
            groups[function, "all"].append((function, distribution, distance))
        lines = _head("function", "distribution")
        for function, distribution in sorted(groups, key=lambda key: (key[0], key[1] == "all", key[1])):
            lines.append(f"| {function} | {distribution} | {self._row(groups[function, distribution])} |")
        return "\n".join(lines)

    def table(self) -> str:
        """One line for each distribution and distance."""
        lines = [self.summary(), "", *_head("function", "distribution", "distance")]
        lines.append("|---" * (len(BANDS) + 5) + "|")
        order = sorted(self.cells, key=lambda key: (key[0], key[1], -float(key[2]) if key[2] != "-" else 0))
        return "\n".join(lines + [f"| {' | '.join(key)} | {self._row([key])} |" for key in order]) + "\n"

    def failures(self, show: int, seed: int) -> str:
        """Some failures of each kind, with the names by which they can be replayed."""
        kinds = defaultdict(list)
        for outcome in self.outcomes:
            if outcome.band not in GOOD:
                kinds[outcome.function, outcome.band, outcome.name.split("/")[1]].append(outcome)
        lines = [] if kinds else ["no failures"]
        for (function, band, distribution), found in sorted(kinds.items()):
            lines.append(f"{function}: {band}: {distribution}: {len(found)}")
            for outcome in sorted(found, key=lambda outcome: -outcome.excess)[:show]:
                lines.append(f"    --seed {seed} --replay {outcome.name!r}: {outcome.detail[:500]}")
        return "\n".join(lines)
