"""A Sphinx extension: mends the roles and names that Sphinx, its theme and MyST-NB give wrongly to parts of a page."""

import re
from pathlib import Path

MENDS = {
    # The list of sources asks for items, not for entries of a bibliography.
    r'role="doc-biblioentry"': 'role="listitem"',
    # Every statement and every exercise would have the same.
    r' id="(?:proof|exercise|solution)-content"': "",
    # The line that unfolds a cell says itself what it does.
    r'<summary aria-label="Toggle hidden content">': "<summary>",
    # So does the search field; its other name leaves out the keys that are written on it.
    r'(<button class="btn search-button-field[^>]*?) aria-label="[^"]*"': r"\1",
    # The button of the colour mode has a name of its own, and needs none of its three pictures.
    r'(<i class="theme-switch [^>]*?) *title="[^"]*"': r"\1",
}


def mend(page: str) -> str:
    """A page with all that is to be replaced in it."""
    for pattern, replacement in MENDS.items():
        page = re.sub(pattern, replacement, page)
    return page


def mend_pages(app, exception) -> None:
    """Mend what was built."""
    if exception or app.builder.format != "html":
        return
    for path in Path(app.outdir).rglob("*.html"):
        path.write_text(mend(path.read_text(encoding="utf-8")), encoding="utf-8")


def setup(app):
    app.connect("build-finished", mend_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
