"""A Sphinx extension: what stands in the head of a page: a description, and the title of the book only once."""

import html
import re

from docutils import nodes

LONGEST = 200
LIST = re.compile(r"^After this (chapter|page) you can\b")


def first_words(doctree) -> str:
    """The first paragraph of a page that says something by itself, on one line and not too long."""
    for paragraph in doctree.findall(nodes.paragraph):
        text = " ".join(paragraph.astext().split())
        if len(text) > 40 and not LIST.match(text) and not paragraph.next_node(nodes.math):
            return text if len(text) <= LONGEST else text[:LONGEST].rsplit(" ", 1)[0] + " …"
    return ""


def describe(app, pagename, templatename, context, doctree) -> None:
    """Give a page its description: its own first words, or else the title of the book."""
    words = (doctree and first_words(doctree)) or app.config.html_title
    context["metatags"] = context.get("metatags", "") + f'<meta name="description" content="{html.escape(words)}">\n'
    if pagename == app.config.root_doc:
        context["docstitle"] = ""


def setup(app):
    app.connect("html-page-context", describe)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
