"""The benchmark runs, at tiny sizes and without peers, and its table has every row."""

import pytest

from bench import peers
from bench.table import HEADINGS, ROWS, as_text, table

YARDSTICKS = [
    "a frame at 60 Hz",
    "copying both operands",
    "eigvals of 4×4 matrices",
    "eigvals of 6×6 matrices",
    "exact eight 5R, one",
    "import numpy",
    "one matrix product",
    "one start of SciPy's least_squares",
    "products, batch",
    "singular values of the axes",
]
WORK = [
    "product, one",
    "products, batch",
    "pose on a point, one",
    "pose on a point, batch",
    "pose on a line, batch",
    "three poses → Bennett, one",
    "three poses → Bennett, batch",
    "three poses, z → eight 5R, batch",
    "cubic → six factorizations, one",
    "four poses → all 6R, one",
    "four poses → all 6R, batch",
    "axes → motion of a 5R, one",
    "all collisions of an exact 5R",
    "all collisions of 10,000 5R",
    "four lines → 5R, 300 starts",
    "motion at 1000 parameters",
    "best of 5R by clearance, one core",
    "one drag step in the page",
    "import kinlib",
    "import a synthesis",
    "memory for eight 5R, batch",
]


@pytest.fixture(scope="module")
def rows():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench.table._release", lambda name: None if name in peers.NAMES else "")
        return table(size=4, budget=0)


def test_every_work_has_a_row(rows):
    assert {row[0] for row in rows} == set(WORK)


def test_yardsticks_are_measured_and_missing_peers_named(rows):
    measured = {row[2] for row in rows if row[3] != "not installed"}
    assert measured == {*YARDSTICKS, "their numbers"}
    assert {row[2] for row in rows} - measured == set(peers.NAMES)


def test_what_is_asked_is_answered(rows):
    for row, cells in zip(ROWS, rows, strict=True):
        answerable = row.seconds or (row.ratio and row.against not in peers.NAMES)
        assert (cells[-1] in ("yes", "NO")) == bool(answerable)


def test_the_table_prints(rows):
    lines = as_text(rows).splitlines()
    assert len(lines) == len(ROWS) + 2
    assert len({len(line) for line in lines}) == 1
    assert all(heading in lines[0] for heading in HEADINGS)
