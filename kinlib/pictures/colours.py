"""One name a colour, and which link has which."""

from __future__ import annotations

from kinlib.linkage import Linkage

__all__ = [
    "BASE", "COUPLER", "GLOW", "INK", "LINKS", "PIN", "X_AXIS", "Y_AXIS", "Z_AXIS", "link_colours", "link_names",
]  # fmt: skip

# Okabe & Ito's colours: told apart by colour-blind readers, and seen on white as on black.
BASE = "#808080"
"""The grey of the base."""

COUPLER = "#d55e00"
"""The vermilion of the coupler, its path and its hand."""

LINKS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9")
"""The colours of the other links in their order: blue, orange, green, purple, sky blue."""

PIN = "#aab2bd"
"""The light grey of pins."""

X_AXIS, Y_AXIS, Z_AXIS = "#e5484d", "#3aa655", "#4a72f5"
"""Red, green and blue for the axes of a frame."""

GLOW = "#ffc531"
"""The light about a pose that is reached."""

INK = "#7a7a7a"
"""The grey of letters and lines, seen on light pages and on dark ones."""


def link_colours(linkage: Linkage) -> tuple[str, ...]:
    """One colour a link: grey for the base, vermilion for the coupler, the others in order.

    After five others the same colours come again, darker each time.

    Returns
    -------
    tuple of str
        Hexadecimal colours, link 0 first.
    """
    special = {0: BASE, linkage.coupler: COUPLER}
    others = [link for link in range(len(linkage.joints)) if link not in special]
    colours = special | {link: _colour(place) for place, link in enumerate(others)}
    return tuple(colours[link] for link in sorted(colours))


def _colour(place: int) -> str:
    """The colour number 0, 1, …: those of `LINKS`, then the same by a third darker, and so on."""
    around, place = divmod(place, len(LINKS))
    parts = (int(LINKS[place][start : start + 2], 16) for start in (1, 3, 5))
    return "#" + "".join(f"{round(part * (2 / 3) ** around):02x}" for part in parts)


def link_names(linkage: Linkage) -> tuple[str, ...]:
    """What the links are called in a legend, link 0 first."""
    special = {0: "base (fixed)", linkage.coupler: "coupler"}
    return tuple(special.get(link, f"link {link}") for link in range(len(linkage.joints)))
