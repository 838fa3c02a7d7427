"""A Sphinx extension: a page in which the line ``<!-- claims -->`` becomes the table of claims, from claims.toml."""

import json
import tomllib
from pathlib import Path

MARK = "<!-- claims -->"
HEAD = [":::{table}", ":class: claims", "", "| Id | Claim | How | Found |", "|---|---|---|---|"]


def title_of(notebook: Path) -> str:
    """The heading that a notebook begins with."""
    first = json.loads(notebook.read_text(encoding="utf-8"))["cells"][0]
    return "".join(first["source"]).splitlines()[0].removeprefix("# ")


def sections(book: Path) -> str:
    """One section a page, one row a claim; the id leads to the place that settles it."""
    table = tomllib.loads((book / "claims.toml").read_text(encoding="utf-8"))
    lines = []
    for page, claims in table.items():
        rows = [
            f"| {{ref}}`{name} <claim-{name.lower()}>` | {claim} | {how} | {found} |"
            for name, (how, claim, found) in claims.items()
        ]
        lines += [f"## {title_of(book / f'{page}.ipynb')}", "", *HEAD, *rows, ":::", ""]
    return "\n".join(lines)


def write_out(app, docname, source) -> None:
    if MARK in source[0]:
        source[0] = source[0].replace(MARK, sections(Path(app.srcdir, "book")))


def setup(app):
    app.connect("source-read", write_out)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
