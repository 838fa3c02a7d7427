"""How often data have linkages that are found, and how many: the table of the book, from seeded problems.

python -m tests.task_table                   make the table anew (five minutes on an idle core) and save it
python -m tests.task_table --check 2         solve that many problems of each row again and compare
"""

from __future__ import annotations

import argparse
import json
import platform
from pathlib import Path

import numpy as np

import kinlib as kl
from tests.task_problems import FIVE_R, problem, random_problem

FILE = Path(__file__).resolve().parents[1] / "book" / "beyond" / "how_often.json"
STARTS = 100
PROBLEMS = {"random": 10, "of a linkage": 6}


def motions_found(home, data) -> list[kl.Linkage]:
    """One of the two linkages for each cubic that was found."""
    try:
        return list(kl.goldberg_linkages_for(home, data, starts=STARTS)[::2])
    except kl.NotFoundError:
        return []


def solved(kind: str, sort: str, seed: int) -> tuple[int, bool | None]:
    """The number of cubics that were found, and whether the one from which the data were made is among them."""
    if sort == "random":
        return len(motions_found(*random_problem(FIVE_R[kind], seed=seed))), None
    given = problem(FIVE_R[kind], ((2, 1), (1, 2))[seed % 2], seed=seed)
    found = motions_found(given.home, given.data)
    poses = [given.motion(t) for t in given.parameters]
    return len(found), any(_visits(linkage, poses) for linkage in found)


def _visits(linkage: kl.Linkage, poses) -> bool:
    reached = [linkage.coupler_motion(t) for t in linkage.parameters[1:]]
    return all(kl.same_point(a, b, rtol=1e-6, length=10) for a, b in zip(reached, poses, strict=True))


def row(kind: str, sort: str, seeds) -> dict:
    """A row of the table."""
    answers = [solved(kind, sort, seed) for seed in seeds]
    line = {"kind": kind, "data": sort, "seeds": len(answers), "cubics": [count for count, _ in answers]}
    if sort != "random":
        line["same"] = [bool(same) for _, same in answers]
    print(line, flush=True)
    return line


def make() -> None:
    """All rows, saved with what they depend on."""
    rows = [row(kind, sort, range(count)) for kind in FIVE_R for sort, count in PROBLEMS.items()]
    versions = {"python": platform.python_version(), "numpy": np.__version__, "kinlib": kl.__version__}
    text = json.dumps({"starts": STARTS, "versions": versions, "rows": rows}, indent=1, ensure_ascii=False)
    FILE.write_text(text + "\n", encoding="utf-8")


def check(count: int) -> int:
    """How many rows come out in another way than in the table, for their first problems.

    Compared is which problems have a linkage: of twenty motions another machine may find one more or less.
    """
    rows = json.loads(FILE.read_text(encoding="utf-8"))["rows"]
    again = [row(line["kind"], line["data"], range(count)) for line in rows]
    pairs = [([n > 0 for n in x["cubics"][:count]] for x in both) for both in zip(rows, again, strict=True)]
    wrong = [old for old, new in pairs if old != new]
    print(f"{len(wrong)} of {len(rows)} rows differ")
    return len(wrong)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.task_table", description=__doc__)
    parser.add_argument("--check", type=int, default=0, metavar="N")
    options = parser.parse_args()
    raise SystemExit(check(options.check) if options.check else make())
