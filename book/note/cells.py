"""A Sphinx extension: ``<!-- cells PAGE FIRST LAST -->`` becomes those cells of a chapter, with what they printed.

So the note says what the book says, and what was run. ``<!-- output PAGE CELL -->`` is what one cell printed, alone.
``<!-- statement LABEL -->`` is one statement of the book, and ``<!-- proof LABEL -->`` what follows it, listings
included, from the word “Proof” to the end of the proof.
"""

import base64
import json
import os
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import ClassVar

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

BOOK = Path(__file__).resolve().parents[1]
MARK = re.compile(r"^<!-- (cells|output|statement|proof|figure|claims) (.*?) -->$", re.MULTILINE)
STATEMENT = re.compile(r"```\{prf:(\w+)\} ?([^\n]*)\n:label: (\S+)\n.*?\n```$", re.MULTILINE | re.DOTALL)
ROLE = re.compile(r"\{(doc|eq|ref|prf:ref|numref|py:\w+|term)\}`([^`]*)`")
BETWEEN = re.compile(r"^(\([\w-]+\)=|#+ .*)\n", re.MULTILINE)  # anchors and headings


@cache
def cells(page: str) -> list[dict]:
    found = json.loads((BOOK / f"{page}.ipynb").read_text(encoding="utf-8"))["cells"]
    return [{**cell, "source": "".join(cell["source"])} for cell in found]


@cache
def chapters() -> list[str]:
    paths = (path.relative_to(BOOK) for path in BOOK.rglob("*.ipynb"))
    return sorted(
        path.with_suffix("").as_posix() for path in paths if not {"assignments", ".ipynb_checkpoints"} & set(path.parts)
    )


@cache
def statements() -> dict[str, re.Match]:
    """The statements of all chapters by their labels."""
    texts = [cell["source"] for page in chapters() for cell in cells(page)]
    return {match[3]: match for text in texts for match in STATEMENT.finditer(text)}


def output(cell: dict) -> str:
    """What a cell showed: a formula, or text."""
    parts = []
    for shown in cell["outputs"]:
        data = shown.get("data", {"text/plain": shown.get("text", "")})
        if "text/latex" in data:
            formula = "".join(data["text/latex"]).strip("$").replace("\\displaystyle", "")
            parts.append(f"$$\n{formula}\n$$")
        elif not any(kind.startswith(("image/", "text/html")) for kind in data):
            parts.append(f"```{{code-block}} text\n{''.join(data['text/plain']).rstrip()}\n```")
    return "\n\n".join(parts)


def as_text(cell: dict) -> str:
    if cell["cell_type"] == "markdown":
        return BETWEEN.sub("", cell["source"]).replace(" cell", " listing")
    return f"```{{code-block}} python\n{cell['source']}\n```\n\n{output(cell)}"


def between(page: str, first: str, last: str) -> str:
    """The cells of a chapter from one to another."""
    ids = [cell["id"] for cell in cells(page)]
    return "\n\n".join(map(as_text, cells(page)[ids.index(first) : ids.index(last) + 1]))


def proof(label: str) -> str:
    """The proof that follows a statement: it may run through several cells, and ends with a square."""
    page, n = next(
        (page, n) for page in chapters() for n, cell in enumerate(cells(page)) if f":label: {label}\n" in cell["source"]
    )
    text = "\n\n".join(map(as_text, cells(page)[n:]))
    text = text[text.index(f":label: {label}\n") :]
    start = re.search(r"^(\*Proof|```\{prf:proof\})", text, re.MULTILINE)
    last = r"\$\\square\$" if start[1] == "*Proof" else r"^```$"
    end = re.search(last, text[start.end() :], re.MULTILINE)
    return text[start.start() : start.end() + end.end()]


def figure(folder: Path, page: str, name: str) -> str:
    """The picture that a cell drew, with its caption in the book."""
    cell = next(cell for cell in cells(page) if cell["id"] == name)
    (picture,) = [data for shown in cell["outputs"] if (data := shown.get("data", {}).get("image/png"))]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.png").write_bytes(base64.b64decode("".join(picture)))
    about = cell["metadata"].get("mystnb", {})
    caption = about.get("figure", {}).get("caption", "")
    here = os.path.relpath(folder, BOOK / "note")
    return f"```{{figure}} {here}/{name}.png\n:width: 55%\n\n{caption}\n```"


def claims(names: list[str]) -> str:
    """Rows of the table of claims as a list."""
    table = tomllib.loads((BOOK / "claims.toml").read_text(encoding="utf-8"))
    rows = {name: row for page in table.values() for name, row in page.items()}
    return "\n".join(f"- **{name}.** *{rows[name][1]}* {rows[name][2]}" for name in names)


def named(role: str, target: str, here: set[str]) -> str:
    """A reference to another page of the book as words: the note has no such page."""
    if role == "eq":
        return f"{{eq}}`{target}`" if target in here else "the form above"
    if role == "prf:ref" and target in here:
        return f"{{cref}}`{target}`"
    if role == "prf:ref":
        kind, title = statements()[target].group(1, 2)
        return f"the {kind} “{title}” of the book" if title else f"a {kind} of the book"
    text = re.sub(r"\s*<.*>$", "", target).removeprefix("~kinlib.").rpartition("/")[2]
    return f"`{text.removeprefix('~')}`" if role.startswith("py:") else text.replace("_", " ")


def filled(text: str, folder: Path) -> str:
    """The note with all its marks replaced."""

    def replace(mark: re.Match) -> str:
        kind, words = mark[1], mark[2].split()
        match kind:
            case "statement":
                return statements()[words[0]][0]
            case "proof":
                return proof(words[0])
            case "output":
                return output(next(cell for cell in cells(words[0]) if cell["id"] == words[1]))
            case "claims":
                return claims(words)
            case "figure":
                return figure(folder, *words)
        return between(*words)

    text = MARK.sub(replace, text)
    here = set(re.findall(r"^:label: (\S+)$", text, re.MULTILINE))
    text = ROLE.sub(lambda match: named(match[1], match[2], here), text)
    return text.replace("```{prf:", "```{")


def latex(text: str) -> nodes.raw:
    return nodes.raw("", text, format="latex")


def cref(name, rawtext, text, lineno, inliner, options=None, content=()) -> tuple[list, list]:
    """A role: the name and number of a statement of the note."""
    return [latex(rf"\cref{{{text}}}")], []


class Statement(SphinxDirective):
    """A theorem, a lemma or a proof, as LaTeX has them."""

    has_content = True
    optional_arguments = 1
    final_argument_whitespace = True
    option_spec: ClassVar = {"label": str}

    def run(self) -> list[nodes.Node]:
        title, _ = self.state.inline_text(self.arguments[0], self.lineno) if self.arguments else ([], [])
        label = rf"\label{{{self.options['label']}}}" if "label" in self.options else ""
        head = [latex("["), *title, latex("]")] if title else []
        start = nodes.paragraph("", "", latex(rf"\begin{{{self.name}}}"), *head, latex(label))
        return [start, *self.parse_content_to_nodes(), latex(rf"\end{{{self.name}}}")]


def write_out(app, docname, source) -> None:
    source[0] = filled(source[0], Path(app.outdir, "figures"))


def setup(app):
    app.connect("source-read", write_out)
    app.add_role("cref", cref)
    for kind in ("theorem", "lemma", "proposition", "definition", "remark", "proof"):
        app.add_directive(kind, Statement)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
