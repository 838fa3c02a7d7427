"""Tables as text: what is written as CSV is read back, what is written to be read has its form."""

import csv
import io

import numpy as np
import pytest

from kinlib import Chain, ConstantSpeed, bennett_linkage, goldberg_linkages
from kinlib.testing import random_poses

FIVE = goldberg_linkages(*random_poses(3, seed=1), 0.4 + 0.9j)[0]


def test_a_denavit_hartenberg_table_in_csv_gives_the_chain_back():
    rows = list(csv.DictReader(io.StringIO(FIVE.chain.table_text("csv"))))
    table = [[float(row[name]) for name in ("distance", "twist", "offset")] for row in rows]
    chain = Chain.from_denavit_hartenberg(table, [float(row["angle"]) for row in rows])
    assert np.allclose(chain.denavit_hartenberg(), FIVE.denavit_hartenberg(), atol=1e-12)
    assert table == [[row.distance, row.twist, row.offset] for row in FIVE.denavit_hartenberg()]  # all digits


def test_tables_to_be_read_have_a_line_for_each_joint():
    markdown, latex = FIVE.chain.table_text("markdown"), FIVE.chain.table_text("latex")
    assert [line.count("|") for line in markdown.splitlines()] == [6] * 7
    assert latex.count(r"\\") == 6
    assert latex.count("&") == 4 * 6
    assert "°" not in latex
    assert latex.startswith(r"\begin{tabular}{rrrrr}")


def test_a_timetable_in_csv_has_all_digits():
    table = FIVE.drive(ConstantSpeed(1), np.linspace(0, 3, 7))
    head, *rows = csv.reader(io.StringIO(table.as_csv()))
    assert head == ["time", "t", *(f"joint {n}" for n in range(1, 6))]
    assert np.array_equal(np.array(rows, dtype=float), np.column_stack([table.time, table.t, table.angles]))


def test_what_has_no_single_table_is_refused():
    batch = bennett_linkage(*random_poses(3, seed=1, shape=(2,)))
    with pytest.raises(ValueError, match="expected a single chain: a batch has many tables"):
        batch.chain.table_text("csv")
    with pytest.raises(ValueError, match="expected the table of a single linkage"):
        batch.drive(ConstantSpeed(), [0.0]).as_csv()
    with pytest.raises(ValueError, match="expected one of csv, markdown, latex, got 'html'"):
        FIVE.chain.table_text("html")
