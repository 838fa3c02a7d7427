"""Elements of XML with numbers in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np

__all__ = ["child", "text_of", "words"]

_FORBIDDEN = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def child(parent: ElementTree.Element | None, tag: str, **attributes: Any) -> ElementTree.Element:
    """An element with attributes, of which numbers have all their digits; below a parent, if there is one."""
    given = {name.rstrip("_"): words(value) for name, value in attributes.items()}
    return ElementTree.Element(tag, given) if parent is None else ElementTree.SubElement(parent, tag, given)


def words(value: Any) -> str:
    """A value of an attribute: characters that XML does not know become spaces."""
    if isinstance(value, str):
        return _FORBIDDEN.sub(" ", value)
    if isinstance(value, (Sequence, np.ndarray)):
        return " ".join(words(x) for x in value)
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


def text_of(root: ElementTree.Element) -> str:
    """The document, indented."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
