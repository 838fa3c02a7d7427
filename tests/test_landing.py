"""The map and the menu of the landing page."""

import re
import tomllib

import pytest

from pages import HTML, ROOT

TABLE = tomllib.loads((ROOT / "book" / "chapters.toml").read_text(encoding="utf-8"))
TOC = re.findall(r"file: book/((?:preliminaries|dyads|synthesis|beyond)/\w+)", (ROOT / "_toc.yml").read_text())


def test_every_chapter_is_on_the_map_behind_those_that_it_needs():
    assert set(TOC) <= set(TABLE)
    for name in TOC:
        for need in TABLE[name]["needs"]:
            assert need in TABLE
            assert TABLE[need]["at"][0] < TABLE[name]["at"][0]  # above it
            assert TOC.index(need) < TOC.index(name)


def test_no_two_boxes_overlap():
    places = [tuple(TABLE[name]["at"]) for name in TOC]
    apart = [abs(c - d) for n, (r, c) in enumerate(places) for q, d in places[:n] if r == q]
    assert min(apart) >= 1


@pytest.mark.parametrize("kind", ["chapter-map", "chapter-menu"])
def test_map_and_menu_lead_to_every_chapter(html, kind):
    page = (html / "book" / "index.html").read_text(encoding="utf-8")
    drawn = re.search(rf'class="{kind}".*?</(?:svg|ul)>', page, re.DOTALL)[0]
    assert re.findall(r'<a href="([^"]*)\.html"', drawn) == TOC
    for source in re.findall(r'<img src="\.\./([^"]*)"', drawn):
        assert (HTML / source).stat().st_size > 500
