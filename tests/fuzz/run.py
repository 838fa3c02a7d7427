"""Cuts the problems into tasks and lets several processes work on them."""

from __future__ import annotations

import math
import sys
import time
import zlib
from dataclasses import replace
from multiprocessing import get_context

from tests.fuzz.problems import CELLS, Block
from tests.fuzz.trial import GOOD, Outcome, try_block

ROWS = {3: 100, 4: 25}
"""How many problems a block has."""


def tasks_of(count: int, total: int, *, seed: int = 1, only: str = "") -> list:
    """(count, cell number, block number, rows to use, seed), mixed so that the time left can be told."""
    cells = CELLS[count]
    weight = sum(cell.weight for cell in cells)
    tasks = []
    for number, cell in enumerate(cells):
        rows = math.ceil(total * cell.weight / weight) if total else 0
        if only not in cell.distribution:
            continue
        for block in range(math.ceil(rows / ROWS[count])):
            tasks.append((count, number, block, min(ROWS[count], rows - block * ROWS[count]), seed))
    return sorted(tasks, key=lambda task: zlib.crc32(repr(task).encode()))


def problems_of(task) -> Block:
    """The problems of a task; a block is made whole, so that its rows don't depend on how many are used."""
    count, number, block, rows, seed = task
    return rows_of(CELLS[count][number].block(seed, block, ROWS[count]), slice(rows))


def rows_of(block: Block, rows) -> Block:
    cut = {name: getattr(block, name)[rows] for name in ("z", "free") if getattr(block, name) is not None}
    return replace(block, poses=block.poses[:, rows], **cut)


def attempt(task) -> list[Outcome]:
    """The outcomes of a task; that the judge fails is an outcome too."""
    block = problems_of(task)
    try:
        return try_block(block)
    except Exception as error:
        return [Outcome(f"{block.name}/:", "the judge", "crash", f"{type(error).__name__}: {error}")]


def run(tasks, workers: int) -> list[Outcome]:
    """All outcomes; tells on the way how long it will take, and gives what there is when it is interrupted."""
    total, outcomes, clock = sum(task[3] for task in tasks), [], Clock()
    names = set()
    with get_context("spawn").Pool(workers) as pool:
        try:
            for found in pool.imap_unordered(attempt, tasks):
                outcomes += found
                names.update(outcome.name for outcome in found if not outcome.name.endswith(":"))
                clock.tell(len(names), total, sum(outcome.band not in GOOD for outcome in outcomes))
        except KeyboardInterrupt:
            print("\ninterrupted", file=sys.stderr)
    print(f"\n{len(names)} problems in {clock.minutes():.1f} min, {workers} workers", file=sys.stderr)
    return outcomes


class Clock:
    """Tells every few seconds how far things are."""

    def __init__(self):
        self.start = self.told = time.time()

    def minutes(self) -> float:
        return (time.time() - self.start) / 60

    def tell(self, done: int, total: int, bad: int) -> None:
        if time.time() - self.told > 5 and done:
            self.told = time.time()
            left = self.minutes() * (total - done) / done
            text = f"\r{done} of {total} problems, {bad} bad, {left:.1f} min left   "
            print(text, end="", file=sys.stderr, flush=True)
