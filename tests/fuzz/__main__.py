"""Runs the fuzz and prints what came of it.

python -m tests.fuzz                                    all, about a quarter of an hour on two cores
python -m tests.fuzz --triples 3000 --quadruples 300    a short run
python -m tests.fuzz --only "near planar" --out table.md
python -m tests.fuzz --replay "near planar/1e-06/0/17"  one problem again, in full
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections import Counter, defaultdict

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy is loaded: the workers share the cores

from multiprocessing import get_context

from tests.fuzz.problems import CELLS
from tests.fuzz.trial import BANDS, GOOD, try_block

ROWS = {3: 100, 4: 25}


def main(arguments=None) -> int:
    options = _options(arguments)
    if options.replay:
        return _replay(options)
    tasks = [task for count, total in ((3, options.triples), (4, options.quadruples)) for task in _tasks(count, total, options)]
    outcomes = _run(tasks, options.workers)
    report = Report(outcomes)
    print(report.summary())
    print(report.failures(options.show, options.seed))
    if options.out:
        with open(options.out, "w", encoding="utf-8") as file:
            file.write(report.table())
    return 0 if report.good() else 1


def _options(arguments):
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triples", type=int, default=10**5, metavar="N", help="problems of three poses")
    parser.add_argument("--quadruples", type=int, default=10**4, metavar="N", help="problems of four poses")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--only", default="", metavar="WORD", help="distributions whose names contain the word")
    parser.add_argument("--out", metavar="FILE", help="write the whole table, in Markdown")
    parser.add_argument("--show", type=int, default=3, metavar="N", help="failures to print for each kind")
    parser.add_argument("--replay", metavar="NAME", help="one problem: distribution/distance/block/row")
    return parser.parse_args(arguments)


def _tasks(count: int, total: int, options) -> list:
    """(count, cell number, block number, rows to use, seed), mixed so that the time left can be told."""
    cells = CELLS[count]
    weight = sum(cell.weight for cell in cells)
    tasks = []
    for number, cell in enumerate(cells):
        rows = math.ceil(total * cell.weight / weight) if total else 0
        if options.only not in cell.distribution:
            continue
        for block in range(math.ceil(rows / ROWS[count])):
            tasks.append((count, number, block, min(ROWS[count], rows - block * ROWS[count]), options.seed))
    return sorted(tasks, key=lambda task: hash((task[1] * 7919 + task[2] * 104729) % 10007))


def problems_of(task):
    """The problems of a task; a block is made whole, so that its rows don't depend on how many are used."""
    count, number, block, rows, seed = task
    made = CELLS[count][number].block(seed, block, ROWS[count])
    cut = {name: getattr(made, name)[:rows] for name in ("z", "free") if getattr(made, name) is not None}
    return type(made)(made.name, made.poses[:, :rows], form=made.form, **cut)


def _try(task) -> list:
    return try_block(problems_of(task))


def _run(tasks, workers: int) -> list:
    total, done, outcomes, start, told = sum(task[3] for task in tasks), 0, [], time.time(), 0.0
    with get_context("spawn").Pool(workers) as pool:
        for found in pool.imap_unordered(_try, tasks):
            outcomes += found
            done += len({outcome.name for outcome in found if not outcome.name.endswith(":")})
            if time.time() - told > 5 and done:
                told = time.time()
                left = (told - start) * (total - done) / done
                bad = sum(outcome.band not in GOOD for outcome in outcomes)
                print(f"\r{done} of {total} problems, {bad} bad, {left / 60:.1f} min left ", end="", file=sys.stderr, flush=True)
    print(f"\r{done} problems in {(time.time() - start) / 60:.1f} min on {workers} workers" + " " * 20, file=sys.stderr)
    return outcomes


class Report:
    """The outcomes, counted."""

    def __init__(self, outcomes):
        self.outcomes = outcomes
        self.cells = defaultdict(Counter)
        self.worst = defaultdict(float)
        for outcome in outcomes:
            distribution, distance = outcome.name.split("/")[:2]
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
        lines = [f"| function | distribution | problems | {' | '.join(BANDS)} | worst/allowed |", "|---" * (len(BANDS) + 4) + "|"]
        for function, distribution in sorted(groups, key=lambda key: (key[0], key[1] == "all", key[1])):
            lines.append(f"| {function} | {distribution} | {self._row(groups[function, distribution])} |")
        return "\n".join(lines)

    def table(self) -> str:
        """One line for each distribution and distance."""
        lines = [self.summary(), "", f"| function | distribution | distance | problems | {' | '.join(BANDS)} | worst/allowed |"]
        lines.append("|---" * (len(BANDS) + 5) + "|")
        order = sorted(self.cells, key=lambda key: (key[0], key[1], -float(key[2]) if key[2] != "-" else 0))
        return "\n".join(lines + [f"| {' | '.join(key)} | {self._row([key])} |" for key in order]) + "\n"

    def failures(self, show: int, seed: int) -> str:
        """Some failures of each kind, with the names by which they can be replayed."""
        kinds = defaultdict(list)
        for outcome in self.outcomes:
            if outcome.band not in GOOD:
                kinds[outcome.function, outcome.band, outcome.name.split("/")[0]].append(outcome)
        lines = [] if kinds else ["no failures"]
        for (function, band, distribution), found in sorted(kinds.items()):
            lines.append(f"{function}: {band}: {distribution}: {len(found)}")
            for outcome in sorted(found, key=lambda outcome: -outcome.excess)[:show]:
                lines.append(f"    --seed {seed} --replay {outcome.name!r}: {outcome.detail[:200]}")
        return "\n".join(lines)


def _replay(options) -> int:
    """One problem again: the poses, and what comes of them."""
    distribution, distance, block, row = options.replay.rsplit("/", 3)
    for count, cells in CELLS.items():
        for number, cell in enumerate(cells):
            if cell.name == f"{distribution}/{distance}":
                made = problems_of((count, number, int(block), ROWS[count], options.seed))
                rows = slice(None) if row == ":" else [int(row)]
                one = type(made)(
                    made.name, made.poses[:, rows], form=made.form,
                    **{name: getattr(made, name)[rows] for name in ("z", "free") if getattr(made, name) is not None},
                )  # fmt: skip
                if row != ":":
                    for pose in one.poses[:, 0]:
                        print([float(x) for x in pose] if pose.dtype != object else [str(x) for x in pose])
                    print(f"z = {one.z}, free = {one.free}, given as {one.form}")
                for outcome in try_block(one):
                    print(f"{outcome.function}: {outcome.band}: {outcome.detail}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
