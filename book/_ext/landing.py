"""A Sphinx extension: the directives ``chapter-map`` and ``chapter-menu`` of the landing page, from chapters.toml.

The map is a drawing in which every box leads to its chapter; the menu shows a picture that the chapter made itself.
Titles and minutes are read from the chapters.
"""

import base64
import json
import re
import tomllib
from html import escape
from pathlib import Path
from textwrap import wrap
from urllib.parse import unquote

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

BOX, STEP, LETTERS = (196, 58), (206, 84), 28  # sizes and distances of the boxes, and how long a line in them is
PICTURES = "_static/chapters"
STILL = re.compile(r'<img class="kinlib-still"[^>]*? src="data:image/svg\+xml,([^"]*)"')


class Chapter:
    """A chapter and what its notebook says of itself."""

    def __init__(self, book: Path, name: str, about: str, needs: list[str], at: list[float]):
        self.name, self.about, self.needs, self.at = name, about, needs, at
        self.cells = json.loads((book / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]

    @property
    def title(self) -> str:
        heading = "".join(self.cells[0]["source"]).splitlines()[0].removeprefix("# ")
        return heading.replace("$", "").replace(r"\,", " ")

    @property
    def minutes(self) -> int:
        """Of a first reading, without exercises: 130 words a minute, half a minute for each listing."""
        texts = ["".join(cell["source"]) for cell in self.cells]
        end = next((n for n, text in enumerate(texts) if "## Exercises" in text), len(texts))
        prose = [text for text, cell in zip(texts[:end], self.cells, strict=False) if cell["cell_type"] == "markdown"]
        words = re.findall(r"\w+", re.sub(r"\$[^$]+\$|\{[^}]*\}`[^`]*`", " x ", " ".join(prose).replace("$$", "$")))
        return 5 * round((len(words) / 130 + 0.5 * (end - len(prose))) / 5)

    def picture(self) -> tuple[str, bytes]:
        """The first picture of the chapter: its ending, and the file."""
        outputs = [output.get("data", {}) for cell in self.cells for output in cell.get("outputs", [])]
        for data in outputs:
            if still := STILL.search("".join(data.get("text/html", ""))):
                return "svg", unquote(still[1]).encode()
            if "image/svg+xml" in data:
                return "svg", "".join(data["image/svg+xml"]).encode()
            if "image/png" in data:
                return "png", base64.b64decode(data["image/png"])
        raise ValueError(f"{self.name} has no picture")


def chapters(app) -> list[Chapter]:
    """The chapters of the table that are in the book, in its order."""
    book = Path(app.srcdir, "book")
    table = tomllib.loads((book / "chapters.toml").read_text(encoding="utf-8"))
    return [Chapter(book, name, **row) for name, row in table.items() if f"book/{name}" in app.env.found_docs]


def drawing(found: list[Chapter], way_to: dict[str, str]) -> str:
    """The map as SVG: lines first, boxes over them."""
    there = {chapter.name: chapter for chapter in found}
    pairs = [(there[need], chapter) for chapter in found for need in chapter.needs if need in there]
    columns, rows = (max(chapter.at[n] for chapter in found) for n in (1, 0))
    size = f"{columns * STEP[0] + BOX[0] + 4:g} {rows * STEP[1] + BOX[1] + 4:g}"
    shapes = [_line(a, b) for a, b in pairs] + [_box(chapter, way_to[chapter.name]) for chapter in found]
    name = "Which chapter needs which: from above to below"
    svg = f'<svg class="chapter-map" viewBox="-2 -2 {size}" role="group" aria-label="{name}">{"".join(shapes)}</svg>'
    return f'<div class="map-box">{svg}</div>'


def _corner(chapter: Chapter) -> tuple[float, float]:
    row, column = chapter.at
    return column * STEP[0], row * STEP[1]


def _line(a: Chapter, b: Chapter) -> str:
    (x, y), (u, v) = _corner(a), _corner(b)
    x, y, u = x + BOX[0] / 2, y + BOX[1], u + BOX[0] / 2
    middle = (y + v) / 2
    return f'<path d="M{x:g} {y:g}C{x:g} {middle:g} {u:g} {middle:g} {u:g} {v:g}"/>'


def _box(chapter: Chapter, way: str) -> str:
    (x, y), lines = _corner(chapter), wrap(chapter.title, LETTERS)
    lines = [*lines[:2], f"{chapter.minutes} minutes"]
    top = y + BOX[1] / 2 - 8 * (len(lines) - 1) + 4
    text = "".join(
        f'<text x="{x + BOX[0] / 2:g}" y="{top + 16 * n:g}"{" class=minutes" if n == len(lines) - 1 else ""}>'
        f"{escape(line)}</text>"
        for n, line in enumerate(lines)
    )
    box = f'<rect x="{x:g}" y="{y:g}" width="{BOX[0]}" height="{BOX[1]}" rx="6"/>'
    part = chapter.name.split("/")[0]
    return f'<a href="{way}" class="{part}"><title>{escape(chapter.about)}</title>{box}{text}</a>'


def cards(found: list[Chapter], way_to: dict[str, str], pictures: str) -> str:
    """The menu: a picture, a title and a line for each chapter."""
    items = [
        f'<li><a href="{way_to[chapter.name]}"><img src="{pictures}/{_file(chapter)}" alt="" loading="lazy">'
        f"<strong>{escape(chapter.title)}</strong><span>{escape(chapter.about)}; {chapter.minutes} minutes</span>"
        "</a></li>"
        for chapter in found
    ]
    return f'<ul class="chapter-menu">{"".join(items)}</ul>'


def _file(chapter: Chapter) -> str:
    return f"{chapter.name.split('/')[-1]}.{chapter.picture()[0]}"


class Landing(SphinxDirective):
    """The map, or the menu."""

    def run(self) -> list[nodes.Node]:
        found = chapters(self.env.app)
        here, builder = self.env.docname, self.env.app.builder
        way_to = {chapter.name: builder.get_relative_uri(here, f"book/{chapter.name}") for chapter in found}
        self.env.note_dependency(str(Path(self.env.app.srcdir, "book", "chapters.toml")))
        if self.name == "chapter-map":
            return [nodes.raw("", drawing(found, way_to), format="html")]
        return [nodes.raw("", cards(found, way_to, f"{'../' * here.count('/')}{PICTURES}"), format="html")]


def copy_pictures(app, exception) -> None:
    """Put the pictures of the menu into the built pages."""
    if exception or app.builder.format != "html":
        return
    folder = Path(app.outdir, PICTURES)
    folder.mkdir(parents=True, exist_ok=True)
    for chapter in chapters(app):
        (folder / _file(chapter)).write_bytes(chapter.picture()[1])


def setup(app):
    app.add_directive("chapter-map", Landing)
    app.add_directive("chapter-menu", Landing)
    app.connect("build-finished", copy_pictures)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
