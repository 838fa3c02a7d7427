"""A Sphinx extension: a page in which ``<!-- statements -->`` becomes the list of all statements, by chapter."""

import json
import re
from pathlib import Path

import yaml

MARK = "<!-- statements -->"
STATEMENT = re.compile(r"^[`:]{3,}\{prf:(?!proof)\w+\}[ ]*(.*)\n((?::.*\n)*)", re.MULTILINE)
LABEL = re.compile(r"^:label:\s*(\S+)", re.MULTILINE)


def pages(entries: list) -> list[str]:
    """The pages of a table of contents, in their order."""
    found = []
    for entry in entries:
        found += [entry["file"]] if "file" in entry else []
        for below in ("parts", "chapters", "sections"):
            found += pages(entry.get(below, []))
    return found


def text_of(path: Path) -> str:
    """What is written in a notebook."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def statements(text: str) -> list[tuple[str, str]]:
    """The labels and the titles of all statements in a text."""
    found = [(LABEL.search(options), title) for title, options in STATEMENT.findall(text + "\n")]
    return [(label[1], title.strip()) for label, title in found if label]


def listed(root: Path) -> str:
    """One section a chapter, one line a statement."""
    toc = yaml.safe_load((root / "_toc.yml").read_text(encoding="utf-8"))
    lines = []
    for page in pages([toc]):
        path = root / f"{page}.ipynb"
        found = statements(text_of(path)) if path.exists() else []
        if found:
            lines += [f"## {{doc}}`/{page}`", ""]
            lines += [f"- {{prf:ref}}`{label}`" + (f": {title}" if title else "") for label, title in found] + [""]
    return "\n".join(lines)


def write_out(app, docname, source) -> None:
    if MARK in source[0]:
        source[0] = source[0].replace(MARK, listed(Path(app.srcdir)))


def setup(app):
    app.connect("source-read", write_out)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
