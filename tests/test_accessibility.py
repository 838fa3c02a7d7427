"""Every page of the book, with all its scenes, can be read by those who see little or hear it read out."""

from importlib.resources import files
from pathlib import Path

import pytest

from browser import screen, wait_until
from pages import PAGES

AXE = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
LOOKS = Path(__file__).with_name("looks.js").read_text(encoding="utf-8")

CONTRAST = ["color-contrast", "link-in-text-block"]  # all that the theme decides
ALL_RULES = {"label-content-name-mismatch": {"enabled": True}}  # in newer versions it is from the start
OTHER_RULES = {**ALL_RULES, **{rule: {"enabled": False} for rule in CONTRAST}}

RUN_AXE = """
const [options, where, done] = arguments;
const serious = ({ impact }) => ["serious", "critical"].includes(impact);
const context = where === "changed" ? { include: looks.changed } : document;
if (where === "changed" && !looks.changed.length) done([]);
else axe.run(context, { iframes: false, resultTypes: ["violations"], ...options }).then(
  ({ violations }) => done(violations.filter(serious).flatMap(
    ({ id, nodes }) => nodes.map(({ target, html }) => `${id}: ${target} ${html.slice(0, 200)}`))),
  (error) => done([String(error)]));
"""


def complaints(driver, options: dict, where: str = "everywhere") -> list[str]:
    """The serious violations in the current document, or in what has changed its look in it."""
    return driver.execute_async_script(RUN_AXE, options, where)


def wide_complaints(driver) -> list[str]:
    """All rules in light, and in dark those that the theme decides; how all looked is remembered."""
    found = []
    for theme, options in (("light", {"rules": ALL_RULES}), ("dark", {"runOnly": CONTRAST})):
        driver.execute_script("looks.remember(arguments[0])", theme)
        found += [f"{theme}: {complaint}" for complaint in complaints(driver, options)]
    return found


def narrow_complaints(driver) -> list[str]:
    """All rules again; those of contrast, in both themes, where an element looks otherwise than on the wide screen."""
    found = [f"narrow: {complaint}" for complaint in complaints(driver, {"rules": OTHER_RULES})]
    for theme in ("dark", "light"):
        driver.execute_script("looks.compare(arguments[0])", theme)
        changed = complaints(driver, {"runOnly": CONTRAST}, "changed")
        found += [f"narrow, {theme}: {complaint}" for complaint in changed]
    return found


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_serious(look, name):
    driver = look(name)
    driver.execute_script(AXE + LOOKS)
    with screen(driver, 1300):
        assert wide_complaints(driver) == []
    with screen(driver, 390):
        assert narrow_complaints(driver) == []
    for frame in driver.find_elements("css selector", "iframe"):
        driver.switch_to.frame(frame)
        wait_until(lambda: driver.find_elements("css selector", ".controls"))
        driver.execute_script(AXE + LOOKS)
        assert wide_complaints(driver) == []
        driver.switch_to.default_content()


FAINT = "#ccc"
PAGE = """<!doctype html><html lang="en" data-theme="light"><meta charset="utf-8"><title>Faint</title>
<meta name="viewport" content="width=device-width"><style>body {{ background: #fff; color: #000 }} {style}</style>
<main><h1>Faint</h1><p>Some text.</p></main></html>"""


@pytest.mark.parametrize(
    ("style", "where"),
    [
        (f"p {{ color: {FAINT} }}", "light"),
        (f"[data-theme=dark] p {{ color: {FAINT} }}", "dark"),
        (f"@media (max-width: 600px) {{ p {{ color: {FAINT} }} }}", "narrow, light"),
        (f"@media (max-width: 600px) {{ main {{ color: {FAINT} }} }}", "narrow, dark"),
        (f"@media (max-width: 600px) {{ [data-theme=dark] p {{ color: {FAINT} }} }}", "narrow, dark"),
    ],
)
def test_faint_text_is_found_where_it_is(chromium, tmp_path, style, where):
    path = tmp_path / "page.html"
    path.write_text(PAGE.format(style=style), encoding="utf-8")
    chromium.get(path.as_uri())
    chromium.execute_script(AXE + LOOKS)
    with screen(chromium, 1300):
        found = wide_complaints(chromium)
    with screen(chromium, 390):
        found += narrow_complaints(chromium)
    assert f"{where}: color-contrast" in " ".join(found)
    assert all("color-contrast" in complaint for complaint in found)
