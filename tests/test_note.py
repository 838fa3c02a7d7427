"""The research note is made of the book's own cells, and its source can be made."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

NOTE = Path(__file__).resolve().parents[1] / "book" / "note"
MARKS = re.compile(r"<!-- (\w+) ([^>]*) -->")


@pytest.mark.book
def test_the_source_of_the_note_is_made_without_a_warning(tmp_path):
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "latex", NOTE, tmp_path]
    subprocess.run(command, check=True, capture_output=True, text=True)
    text = (tmp_path / "note.tex").read_text(encoding="utf-8")
    labels = set(re.findall(r"\\begin\{\w+\}(?:\[.*\])?\\label\{([^}]*)\}", text))
    assert set(re.findall(r"\\cref\{([^}]*)\}", text)) <= labels
    wanted = [
        words for kind, words in MARKS.findall((NOTE / "index.md").read_text(encoding="utf-8")) if kind == "statement"
    ]
    assert set(wanted) <= labels
    assert "<!--" not in text
