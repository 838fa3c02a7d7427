"""The page of results names the statements that the table of claims calls mended or new."""

import json
import re
import tomllib
from pathlib import Path

BOOK = Path(__file__).resolve().parents[1] / "book"
TABLE = tomllib.loads((BOOK / "claims.toml").read_text(encoding="utf-8"))
CLAIMS = {name: row for rows in TABLE.values() for name, row in rows.items()}


def results() -> str:
    cells = json.loads((BOOK / "start/results.ipynb").read_text(encoding="utf-8"))["cells"]
    return "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def named(pattern: str) -> set[str]:
    return set(re.findall(pattern, results(), re.MULTILINE))


def test_the_table_of_what_was_mended_is_complete():
    old = {name for name, (_, claim, _) in CLAIMS.items() if not claim.startswith(("Not in", "Open in"))}
    mended = {name for name in old if not re.match(r"True(\.|;|:|, for)|Drawn", CLAIMS[name][2])}
    assert named(r"^\| \{ref\}`(\w+) <claim-") == mended


def test_everything_new_is_told():
    new = {name for name, (_, claim, _) in CLAIMS.items() if claim.startswith(("Not in", "Open in"))}
    assert named(r"\(\{ref\}`(\w+) <claim-") == new
