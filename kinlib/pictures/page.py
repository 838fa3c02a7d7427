"""The page of a scene: its recording, and the player with its viewer or the way to them.

In a book all scenes share one copy of the viewer, in a live Jupyter each brings its own; the environment variable
``KINLIB_SCENE`` decides otherwise if it is ``shared`` or ``inline``.
"""

from __future__ import annotations

import html
import json
import os
from pathlib import Path
from urllib.parse import quote

import meshcat

from kinlib.pictures.shapes import Table
from kinlib.pictures.still import still_of

__all__ = ["page_of", "shown", "static_files"]

_LOADER = """
(() => {
  let root;
  try { root = parent.document.documentElement.dataset.content_root; } catch { /* not our page */ }
  if (root === undefined) {
    document.body.textContent = "This scene plays in the built book and in Jupyter; "
      + "elsewhere, set KINLIB_SCENE=inline and run its cell.";
    return;
  }
  const add = (tag, values) => document.head.append(Object.assign(document.createElement(tag), values));
  add("link", { rel: "stylesheet", href: root + "_static/kinlib/viewer.css" });
  window.bundle = root + "_static/meshcat/main.min.js";
  for (const name of ["explorer.js", "viewer.js"]) {
    add("script", { src: `${root}_static/kinlib/${name}`, async: false });
  }
})();
"""


def static_files() -> dict[str, Path]:
    """The files that the scenes of a book share, by their place in the book's ``_static`` folder."""
    viewer = Path(meshcat.__file__).parent / "viewer"
    bundle = [viewer / "LICENSE", *sorted((viewer / "dist").glob("main.min.js*"))]
    ours = [Path(__file__).with_name(name) for name in ("viewer.css", "explorer.js", "viewer.js")]
    return {f"meshcat/{file.name}": file for file in bundle} | {f"kinlib/{file.name}": file for file in ours}


def _shares_the_viewer() -> bool:
    """Whether scenes use the viewer of the book around them."""
    asked = os.environ.get("KINLIB_SCENE")
    if asked not in (None, "shared", "inline"):
        raise ValueError(f"expected KINLIB_SCENE to be 'shared' or 'inline', got {asked!r}")
    return asked == "shared" if asked else "JPY_SESSION_NAME" not in os.environ


def shown(recording: Table, height: str, pictured: Table | None = None) -> str:
    """The HTML that shows a scene inside another page, at a height in units of CSS.

    Below the player lies the still of the scene, or of another recording that is pictured: it is seen on paper, and
    until the player draws.
    """
    page = page_of(recording, shared=_shares_the_viewer())
    still = quote(still_of(pictured or recording), safe=" !$'()*+,/:;<=>?@[]^_{|}~")
    over = "position:absolute;inset:0;width:100%;height:100%;border:0;border-radius:8px;color-scheme:light"
    return (
        '<div class="kinlib-box" style="position:relative">'
        f'<img class="kinlib-still" alt="" src="data:image/svg+xml,{still}" '
        f'style="display:block;width:100%;max-width:100%;height:{height};object-fit:contain">'
        f'<iframe class="kinlib-scene" title="{html.escape(recording["alt"])}" allow="fullscreen" style="{over}" '
        f"srcdoc='{page.replace('&', '&amp;').replace(chr(39), '&#39;')}'></iframe></div>"
    )


def page_of(recording: Table, *, shared: bool) -> str:
    """The HTML document of one scene."""
    data = json.dumps(recording, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    style, scripts = ("", [_LOADER]) if shared else _own_copies()
    return "\n".join([
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width">',
        f"<title>{html.escape(recording['alt'])}</title>{style}</head><body>",
        f'<script type="application/json" id="recording">{data}</script>',
        *(f"<script>{script}</script>" for script in scripts),
        "</body></html>",
    ])  # fmt: skip


def _own_copies() -> tuple[str, list[str]]:
    """The style sheet and the scripts of the player, to be written into the page."""
    shared = static_files()
    css, *scripts = (
        shared[name].read_text(encoding="utf-8")
        for name in ("kinlib/viewer.css", "meshcat/main.min.js", "kinlib/explorer.js", "kinlib/viewer.js")
    )
    return f"<style>{css}</style>", [script.replace("</script", "<\\/script") for script in scripts]
