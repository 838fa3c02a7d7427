"""A Sphinx extension: the docstrings of kinlib, written to be read in a console, also make pages."""

import re

import kinlib

PUBLIC = re.compile(r"(:\w+:`~?)kinlib\.(\w+)`")
TYPE = re.compile(r"~(?:\w+\.)*(\w+)")


def where_it_is_defined(match: re.Match) -> str:
    """A reference to a public name of kinlib, as one to the module that has it."""
    role, name = match.groups()
    owner = getattr(getattr(kinlib, name, None), "__module__", "kinlib")
    return f"{role}{owner}.{name}`"


def prepare(app, what, name, obj, options, lines) -> None:
    """Let bars mean absolute values and not substitutions, and references find their module."""
    lines[:] = [PUBLIC.sub(where_it_is_defined, line.replace("|", r"\|")) for line in lines]


def shorten(app, what, name, obj, options, signature, returned) -> tuple[str, str] | None:
    """Types by their last names in a signature that Sphinx cannot read, for a default such as <factory>."""
    return (TYPE.sub(r"\1", signature), returned) if "<" in (signature or "") else None


def skip(app, what, name, obj, skipped, options) -> bool | None:
    """Leave out the fields of named tuples, which their class describes."""
    return True if type(obj).__name__ == "_tuplegetter" else None


def setup(app):
    app.connect("autodoc-process-docstring", prepare)
    app.connect("autodoc-process-signature", shorten)
    app.connect("autodoc-skip-member", skip)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
