"""A Sphinx extension: the docstrings of kinlib, written to be read in a console, also make pages.

Each public name stands on its page under the door from which it is imported, wherever it is defined.
"""

import pkgutil
import re
from importlib import import_module

from docutils import nodes
from sphinx.pycode import ModuleAnalyzer

import kinlib
from kinlib import typing
from kinlib.errors import Fault

DOORS = ("kinlib", "kinlib.pictures", "kinlib.gallery", "kinlib.testing", "kinlib.typing")
FILE = re.compile(r"kinlib\.(?:pictures\.)?[a-z_]+\.")
CODE_OR_BAR = re.compile(r"(?P<code>``.+?``|^ *>>>.*?(?:\n *$|\Z))|\|", re.DOTALL | re.MULTILINE)
TYPE = re.compile(r"~(?:\w+\.)*(\w+)")


def prepare(app, what, name, obj, options, lines) -> None:
    """Let bars mean absolute values and not substitutions; data have the words below them, faults their messages."""
    if is_fault(obj):
        lines += [text for fault in obj for text in ("", f":{fault.name}: {fault.message}")]
    if what == "data":
        lines[:] = words_below(name.rpartition(".")[2]) or lines
    lines[:] = with_bars("\n".join(lines)).split("\n")


def with_bars(text: str) -> str:
    """The text with its bars escaped, but for those in code: there a bar is a bar already."""
    return CODE_OR_BAR.sub(lambda found: found["code"] or r"\|", text)


def is_fault(obj) -> bool:
    return isinstance(obj, type) and issubclass(obj, Fault)


def words_below(name: str) -> list[str]:
    """The docstring that stands in a file of kinlib below a value of this name."""
    for file in pkgutil.walk_packages(kinlib.__path__, "kinlib."):
        analyzer = ModuleAnalyzer.for_module(file.name)
        analyzer.analyze()
        if name in getattr(import_module(file.name), "__all__", ()) and ("", name) in analyzer.attr_docs:
            return analyzer.attr_docs["", name]
    return []


def from_its_door(app, env, node, content):
    """A reference to where a name is defined, as one to where it is imported from; plain words if it is not public."""
    target = node.get("reftarget", "")
    if node.get("refdomain") != "py" or not FILE.match(target):
        return None
    name, python = FILE.sub("", target, count=1), env.get_domain("py")
    found = (
        python.resolve_xref(env, node["refdoc"], app.builder, "obj", f"{door}.{name}", node, content) for door in DOORS
    )
    return next((reference for reference in found if reference is not None), content)


def keep_names(app, config) -> None:
    """Show the kinds of arguments by their names, not by the types that they stand for."""
    config.autodoc_type_aliases = {name: f"kinlib.typing.{name}" for name in typing.__all__}


def drop_aliases(app, doctree) -> None:
    """Take away what Sphinx adds to the words about a kind of arguments: the long type that it stands for."""
    for paragraph in list(doctree.findall(nodes.paragraph)):
        if paragraph.astext().startswith("alias of "):
            paragraph.parent.remove(paragraph)


def shorten(app, what, name, obj, options, signature, returned) -> tuple[str, str | None] | None:
    """Types by their last names in a signature that Sphinx cannot read, for a default such as <factory>.

    Faults are not made by calling: they have no signature.
    """
    if is_fault(obj):
        return "", None
    return (TYPE.sub(r"\1", signature), returned) if "<" in (signature or "") else None


def skip(app, what, name, obj, skipped, options) -> bool | None:
    """Leave out the fields of named tuples, which their class describes."""
    return True if type(obj).__name__ == "_tuplegetter" else None


def setup(app):
    app.connect("config-inited", keep_names)
    app.connect("autodoc-process-docstring", prepare)
    app.connect("autodoc-process-signature", shorten)
    app.connect("autodoc-skip-member", skip)
    app.connect("doctree-read", drop_aliases)
    app.connect("missing-reference", from_its_door)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
