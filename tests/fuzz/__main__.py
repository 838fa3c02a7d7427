"""Runs the fuzz and prints what came of it.

python -m tests.fuzz                                    all, about a quarter of an hour on two cores
python -m tests.fuzz --triples 3000 --quadruples 300    a short run
python -m tests.fuzz --only "near planar" --out table.md
python -m tests.fuzz --replay "3/near planar/1e-06/0/17"  one problem again, in full
"""

from __future__ import annotations

import argparse
import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy is loaded: the workers share the cores

from tests.fuzz.problems import CELLS
from tests.fuzz.report import Report
from tests.fuzz.run import ROWS, problems_of, rows_of, run, tasks_of
from tests.fuzz.trial import try_block


def main(arguments=None) -> int:
    options = _options(arguments)
    if options.replay:
        return _replay(options)
    tasks = [
        task
        for count, total in ((3, options.triples), (4, options.quadruples))
        for task in tasks_of(count, total, seed=options.seed, only=options.only)
    ]
    report = Report(run(tasks, options.workers))
    print(report.summary())
    print(report.failures(options.show, options.seed))
    if options.out:
        with open(options.out, "w", encoding="utf-8") as file:
            file.write(report.table())
    return 0 if report.good() else 1


def _options(arguments):
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__, formatter_class=verbatim)
    parser.add_argument("--triples", type=int, default=10**5, metavar="N", help="problems of three poses")
    parser.add_argument("--quadruples", type=int, default=10**4, metavar="N", help="problems of four poses")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--only", default="", metavar="WORD", help="distributions whose names contain the word")
    parser.add_argument("--out", metavar="FILE", help="write the whole table, in Markdown")
    parser.add_argument("--show", type=int, default=3, metavar="N", help="failures to print for each kind")
    parser.add_argument("--replay", metavar="NAME", help="one problem: count/distribution/distance/block/row")
    return parser.parse_args(arguments)


def _replay(options) -> int:
    """One problem again: the poses, and what comes of them."""
    name, block, row = options.replay.rsplit("/", 2)
    for count, cells in CELLS.items():
        for number, cell in enumerate(cells):
            if cell.name == name:
                made = problems_of((count, number, int(block), ROWS[count], options.seed))
                _show(made if row == ":" else rows_of(made, [int(row)]))
    return 0


def _show(block) -> None:
    for number, pose in enumerate(block.poses[:, 0]):
        print(f"p{number} =", [str(x) if block.exact else float(x) for x in pose])
    print(f"z = {block.z}, free = {block.free}, given as {block.form}")
    for outcome in try_block(block):
        print(f"{outcome.function}: {outcome.band}: {outcome.detail}")


if __name__ == "__main__":
    sys.exit(main())
