"""One name a colour, and which link has which."""

from __future__ import annotations

from kinlib.linkage import Linkage

__all__ = [
    "BASE", "BLUE", "COUPLER", "GLOW", "GREEN", "GREY", "INK", "LIME", "LINKS", "ORANGE", "PIN", "PURPLE",
    "RASPBERRY", "SILVER", "SKY", "VERMILION", "VIOLET", "X_AXIS", "YELLOW", "Y_AXIS", "Z_AXIS", "link_colours",
    "link_names",
]  # fmt: skip

# Okabe & Ito's colours: told apart by colour-blind readers, and seen on white as on black.
BLUE = "#0072b2"
"""The colour of link 1, if that is not the coupler."""

ORANGE = "#e69f00"
"""The colour of the next link."""

GREEN = "#009e73"
"""The colour of the link after that."""

PURPLE = "#cc79a7"
"""The fourth colour of links."""

SKY = "#56b4e9"
"""The fifth colour of links, a light blue."""

VERMILION = "#d55e00"
"""The colour of the coupler, of its path, and of a dyad's hand."""

YELLOW = "#f0e442"
"""A colour for areas: too light for letters and lines on white."""

GREY = "#808080"
"""The colour of the base."""

SILVER = "#aab2bd"
"""The light grey of pins, and of what has no colour of its own."""

INK = "#7a7a7a"
"""The grey of letters and lines, seen on light pages and on dark ones."""

# Frames' axes have colours that no link has.
RASPBERRY = "#d81b60"
"""The colour of x-axes."""

LIME = "#84b718"
"""The colour of y-axes."""

VIOLET = "#7c4dff"
"""The colour of z-axes."""

BASE, COUPLER, PIN = GREY, VERMILION, SILVER
LINKS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
X_AXIS, Y_AXIS, Z_AXIS = RASPBERRY, LIME, VIOLET
GLOW = "#ffc531"  # the light about a pose that is reached


def link_colours(linkage: Linkage) -> tuple[str, ...]:
    """One colour a link: grey for the base, vermilion for the coupler, the others in order.

    After five others the same colours come again, darker each time.

    Returns
    -------
    tuple of str
        Hexadecimal colours, link 0 first.
    """
    special = {0: BASE, linkage.coupler: COUPLER}
    others = [link for link in range(linkage.joint_count) if link not in special]
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
    return tuple(special.get(link, f"link {link}") for link in range(linkage.joint_count))
