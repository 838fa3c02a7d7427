"""The table of claims and the pages of the book agree, and each claim is asserted where it is settled."""

import json
import re
import tomllib
from pathlib import Path

import pytest

BOOK = Path(__file__).resolve().parents[1] / "book"
TABLE = tomllib.loads((BOOK / "claims.toml").read_text(encoding="utf-8"))
ROWS = [(name, page, row) for page, rows in TABLE.items() for name, row in rows.items()]
ANCHOR = re.compile(r"^\(claim-([a-z0-9]+)\)=$", re.MULTILINE)
NEAR = 2  # how many code cells after an anchor may settle it


def cells(page: Path) -> list[dict]:
    return json.loads(page.read_text(encoding="utf-8"))["cells"]


def anchors() -> list[tuple[str, str, bool]]:
    """The anchors of all notebooks: the claim, the page, and whether an assert stands in a code cell next to it."""
    found = []
    for path in sorted(BOOK.rglob("*.ipynb")):
        if ".ipynb_checkpoints" in path.parts:
            continue
        page, here = path.relative_to(BOOK).with_suffix("").as_posix(), cells(path)
        for n, cell in enumerate(here):
            if cell["cell_type"] == "markdown":
                near = ["".join(c["source"]) for c in here[n:] if c["cell_type"] == "code"][:NEAR]
                settled = any(re.search(r"^\s*assert", code, re.MULTILINE) for code in near)
                found += [(name, page, settled) for name in ANCHOR.findall("".join(cell["source"]))]
    return found


ANCHORS = anchors()


def test_each_claim_has_one_anchor_on_its_page_and_each_anchor_a_claim():
    wanted = sorted((name.lower(), page) for name, page, _ in ROWS)
    assert sorted((name, page) for name, page, _ in ANCHORS) == wanted


@pytest.mark.parametrize(("name", "page", "settled"), ANCHORS, ids=[name for name, *_ in ANCHORS])
def test_a_cell_near_the_anchor_asserts(name, page, settled):
    assert settled


@pytest.mark.parametrize(("name", "page", "row"), ROWS, ids=[name for name, *_ in ROWS])
def test_rows_say_how_they_were_settled(name, page, row):
    how, claim, found = row
    assert set(how.split(", ")) <= set("GXFD")
    assert claim.endswith(".")
    assert found.endswith(".")
    assert "|" not in claim + found  # it would end the cell of the table
