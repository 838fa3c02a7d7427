"""How often data have linkages that are found, and how many: the table of the book, from seeded problems.

python -m tests.task_table --rounds 3       go on with the table by three rounds of five problems a row (a round: five
                                            minutes on an idle core); it is saved after each row
python -m tests.task_table --anew           begin it again
python -m tests.task_table --check 2        solve that many problems of each row again and compare
"""

from __future__ import annotations

import argparse
import json
import platform
from pathlib import Path

import numpy as np

import kinlib as kl
from kinlib import task
from tests.task_problems import FIVE_R, problem, random_problem

FILE = Path(__file__).resolve().parents[1] / "book" / "beyond" / "how_often.json"
STARTS = 40
ROUND = 5
SORTS = ("random", "of a linkage")


def solved(kind: str, sort: str, seed: int) -> tuple[int, float, bool | None]:
    """The number of cubics, by how much the data are missed, and whether the cubic that they were made of is there."""
    if sort == "random":
        home, data = random_problem(FIVE_R[kind], seed=seed)
        poses = []
    else:
        given = problem(FIVE_R[kind], ((2, 1), (1, 2))[seed % 2], seed=seed)
        home, data = given.home, given.data
        poses = [given.motion(t) for t in given.parameters]
    try:
        found = kl.goldberg_linkages_for(home, data, starts=STARTS)[::2]  # one of the two linkages for each cubic
    except kl.NotFoundError:
        found = ()
    missed = max((max(task.residuals(linkage, data)) for linkage in found), default=0.0)
    return len(found), missed, any(_visits(linkage, poses) for linkage in found) if poses else None


def _visits(linkage: kl.Linkage, poses) -> bool:
    reached = [linkage.coupler_motion(t) for t in linkage.parameters[1:]]
    return all(kl.same_point(a, b, rtol=1e-6, length=10) for a, b in zip(reached, poses, strict=True))


def with_more(row: dict, seeds) -> dict:
    """A row of the table with more problems."""
    answers = [solved(row["kind"], row["data"], seed) for seed in seeds]
    more = {
        "cubics": row["cubics"] + [count for count, *_ in answers],
        "missed": max([row["missed"], *(missed for _, missed, _ in answers)]),
    }
    if row["data"] != "random":
        more["same"] = row["same"] + [bool(same) for *_, same in answers]
    return {**row, **more}


def empty() -> list[dict]:
    """The rows before any problem is solved."""
    rows = [{"kind": kind, "data": sort, "missed": 0.0, "cubics": []} for kind in FIVE_R for sort in SORTS]
    return [{**row, **({} if row["data"] == "random" else {"same": []})} for row in rows]


def save(rows: list[dict]) -> None:
    """The rows, with what they depend on."""
    versions = {"python": platform.python_version(), "numpy": np.__version__, "kinlib": kl.__version__}
    lines = ",\n".join("  " + json.dumps(row, ensure_ascii=False) for row in rows)
    head = json.dumps({"starts": STARTS, "versions": versions})[:-1]
    FILE.write_text(f'{head}, "rows": [\n{lines}\n]}}\n', encoding="utf-8")


def load() -> list[dict]:
    """The rows that are saved."""
    table = json.loads(FILE.read_text(encoding="utf-8"))
    if table["starts"] != STARTS:
        raise SystemExit(f"the table was made with {table['starts']} starts, not {STARTS}: begin it again with --anew")
    return table["rows"]


def go_on(rows: list[dict], rounds: int) -> None:
    """More problems for each row, those with fewest first."""
    for _ in range(rounds * len(rows)):
        n = min(range(len(rows)), key=lambda n: len(rows[n]["cubics"]))
        begin = len(rows[n]["cubics"])
        rows[n] = with_more(rows[n], range(begin, begin + ROUND))
        save(rows)
        print(rows[n]["kind"], rows[n]["data"], len(rows[n]["cubics"]), rows[n]["cubics"][begin:], flush=True)


def check(count: int) -> int:
    """How many rows come out in another way than in the table, for their first problems.

    Compared is which problems have a linkage: of twenty motions another machine may find one more or less.
    """
    rows = load()
    again = [with_more(row, range(count)) for row in empty()]
    pairs = [([n > 0 for n in x["cubics"][:count]] for x in both) for both in zip(rows, again, strict=True)]
    wrong = [old for old, new in pairs if old != new]
    print(f"{len(wrong)} of {len(rows)} rows differ")
    return len(wrong)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.task_table", description=__doc__)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--anew", action="store_true")
    parser.add_argument("--check", type=int, metavar="N")
    options = parser.parse_args()
    if options.check is not None:
        raise SystemExit(check(options.check))
    go_on(empty() if options.anew else load(), options.rounds)
