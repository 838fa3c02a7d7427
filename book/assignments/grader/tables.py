"""CSV files as spreadsheets write and read them: other encodings, other separators, no formulas."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path

SEPARATORS = (",", ";", "\t")
MARKS_OF_ORDER = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}


class EntryError(ValueError):
    """Something that a person has entered in a file or a command cannot be."""


def decoded(content: bytes) -> str:
    """A text in whatever a spreadsheet or editor has saved it: UTF-8, UTF-16 or that of Western Windows.

    Examples
    --------
    >>> {decoded("Zoë".encode(name)) for name in ("utf-8", "utf-8-sig", "utf-16", "cp1252")}
    {'Zoë'}
    """
    for mark, name in MARKS_OF_ORDER.items():
        if content.startswith(mark):
            return content.decode(name)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def separator_of(text: str) -> str:
    """The character between the columns: that of which the first line has most, or the one that it names."""
    first = (text.splitlines() or [""])[0]
    if first.startswith("sep=") and len(first) == 5:
        return first[4]
    return max(SEPARATORS, key=first.count)


def read(file: Path) -> list[dict[str, str]]:
    """The rows of a CSV file by the names of their columns, none if there is no file.

    Names of columns are taken without regard to capitals and blanks around them; empty rows are left out.
    """
    if not file.exists():
        return []
    text = decoded(file.read_bytes())
    separator = separator_of(text)
    if text.startswith("sep="):
        text = text.partition("\n")[2]
    lines = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    names = [name.strip().casefold() for name in next(lines, [])]
    rows = [dict(zip(names, line, strict=False)) for line in lines if any(part.strip() for part in line)]
    return [{name: row.get(name, "").strip().removeprefix("'") for name in names} for row in rows]


def write(file: Path, columns: Iterable[str], rows: list[dict], separator: str = ",") -> None:
    """A CSV file that spreadsheets read with all its letters: it begins with the mark of byte order."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", newline="", encoding="utf-8-sig") as out:
        writer = csv.DictWriter(out, list(columns), restval="", delimiter=separator, extrasaction="ignore")
        writer.writeheader()
        decimal = separator != ","
        writer.writerows({key: harmless(value, decimal) for key, value in row.items()} for row in rows)


def harmless(value, comma: bool = False):
    """A value that no spreadsheet takes for a formula: some of the text comes from students.

    Where columns are not divided by commas, numbers have one.
    """
    if isinstance(value, float):
        text = f"{value:g}"
        return text.replace(".", ",") if comma else text
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t")) else value
