"""A Sphinx extension: the built book asks nothing of the network.

It copies MathJax and the 3-D viewer from the installed packages into ``_static``, and drops thebe, which
would fetch itself from a server (and fails on every page).  It also keeps a comma
with the formula before it.
"""

import re
from importlib.metadata import distribution
from pathlib import Path
from shutil import copyfile, copytree

from docutils import nodes

from kinlib.pictures import static_files

# What TeX input and HTML output need; speech, SVG and the other inputs stay behind.
MATHJAX_PARTS = ("tex-chtml.js", "input/tex/extensions", "output/chtml/fonts")
MATHJAX_NOTICE = """MathJax 3.2.2. Copyright The MathJax Consortium.
Licensed under the Apache License, Version 2.0: https://www.apache.org/licenses/LICENSE-2.0
"""
PUNCTUATION = re.compile(r"[.,;:!?)’”]+")


def copy_part(source: Path, target: Path) -> None:
    """Copy a file or a folder, making the folders above it."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        copytree(source, target, dirs_exist_ok=True)
    else:
        copyfile(source, target)


def copy_bundles(app, exception) -> None:
    """Put MathJax and the viewer of the scenes into the built pages."""
    if exception or app.builder.format != "html":
        return
    static = Path(app.outdir) / "_static"
    mathjax = distribution("sphinx-mathjax-offline").locate_file("sphinx-mathjax-offline/static/mathjax")
    for part in MATHJAX_PARTS:
        copy_part(Path(mathjax) / part, static / "mathjax" / part)
    (static / "mathjax" / "NOTICE.txt").write_text(MATHJAX_NOTICE)
    for name, file in static_files().items():
        copy_part(file, static / name)


def drop_thebe_scripts(app, pagename, templatename, context, doctree) -> None:
    """Take thebe's scripts out of a page's head."""
    context["script_files"] = [script for script in context["script_files"] if not is_thebe(script)]


def is_thebe(script) -> bool:
    body = getattr(script, "attributes", {}).get("body") or ""
    return "thebe" in str(getattr(script, "filename", "")) or "THEBE" in body


def drop_thebe_nodes(app, doctree, docname) -> None:
    """Take thebe's configuration out of a page's body."""
    for node in list(doctree.findall(nodes.raw)):
        if "x-thebe-config" in node.astext() or "kernelName" in node.astext():
            node.parent.remove(node)


def keep_punctuation(app, doctree) -> None:
    """Keep a formula and the punctuation behind it on one line; browsers would break between them."""
    for formula in list(doctree.findall(nodes.math)):
        follower = formula.next_node(descend=False, siblings=True)
        if isinstance(follower, nodes.Text) and (found := PUNCTUATION.match(follower)):
            comma = nodes.Text(found[0])
            together = nodes.inline("", "", formula.deepcopy(), comma, classes=["keep-together"])
            formula.replace_self(together)
            follower.parent.replace(follower, nodes.Text(follower[found.end() :]))


def setup(app):
    app.connect("doctree-read", keep_punctuation)
    app.connect("html-page-context", drop_thebe_scripts, priority=900)
    app.connect("doctree-resolved", drop_thebe_nodes, priority=900)
    app.connect("build-finished", copy_bundles)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
