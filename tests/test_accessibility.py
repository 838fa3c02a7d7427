"""Every page of the book, with all its scenes, can be read by those who see little or hear it read out."""

from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path

import pytest

from browser import screen, wait_until
from pages import PAGES

AXE = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
LOOKS = Path(__file__).with_name("looks.js").read_text(encoding="utf-8")

WIDE, NARROW = 1300, 390  # screens
CONTRAST = ["color-contrast", "link-in-text-block"]  # all that the look of a text decides
OTHER_RULES = {
    "label-content-name-mismatch": {"enabled": True},  # in newer versions it is from the start
    **{rule: {"enabled": False} for rule in CONTRAST},
}

RUN_AXE = """
const [options, picked, done] = arguments;
const SERIOUS = ["serious", "critical"];
const serious = ({ impact }) => SERIOUS.includes(impact);
// A rule is at most as serious as the worst of what it looks for: those that can never be are not asked.
const { rules, data } = axe._audit;
const worst = ({ impact, any, all, none }) => impact ? [impact] :
  [...any, ...all, ...none].map((check) => data.checks[check.id ?? check]?.impact ?? "serious");
const mild = rules.filter((rule) => !worst(rule).some((impact) => SERIOUS.includes(impact)));
const others = Object.fromEntries(mild.map(({ id }) => [id, { enabled: false }]));
if (options.rules) options.rules = { ...others, ...options.rules };
const context = picked ? { include: looks.picked } : document;
axe.run(context, { iframes: false, resultTypes: ["violations"], ...options }).then(
  ({ violations }) => done(violations.filter(serious).flatMap(
    ({ id, nodes }) => nodes.map(({ target, html }) => `${id}: ${target} ${html.slice(0, 200)}`))),
  (error) => done([String(error)]));
"""

good_looks = set()  # of texts that had contrast enough, on whatever page they were met


def complaints(driver, where: str) -> list[str]:
    """The serious violations in the current document; contrast, in both themes, for looks not met before."""
    found = driver.execute_async_script(RUN_AXE, {"rules": OTHER_RULES}, False)
    driver.execute_script("looks.remember()")
    return [f"{where}: {complaint}" for complaint in found] + faint_texts(driver, where)


def further_complaints(driver, where: str) -> list[str]:
    """The same for a screen of another size: only what is shown there and was not before is new, but for contrast."""
    shown = driver.execute_script("return looks.pickNew()")
    found = driver.execute_async_script(RUN_AXE, {"rules": OTHER_RULES}, True) if shown else []
    return [f"{where}: {complaint}" for complaint in found] + faint_texts(driver, where)


def complaints_on_two_screens(driver) -> list[str]:
    with screen(driver, WIDE) as become:
        found = complaints(driver, "wide")
        become(NARROW)
        return found + further_complaints(driver, "narrow")


def faint_texts(driver, where: str) -> list[str]:
    """The texts with too little contrast, one for each look in either theme."""
    found = []
    for theme in ("dark", "light"):
        new = [
            look for look in driver.execute_script("return looks.all(arguments[0])", theme) if look not in good_looks
        ]
        if not new:
            continue
        driver.execute_script("looks.pick(arguments[0])", new)
        bad = driver.execute_async_script(RUN_AXE, {"runOnly": CONTRAST}, True)
        found += [f"{where}, {theme}: {complaint}" for complaint in bad]
        good_looks.update(new if not bad else ())
    return found


# The glyphs of formulas are hidden from those who listen, and come from the style sheet: axe, which would take half of
# its time for them, finds nothing there to judge.
TAKE_GLYPHS = """
{ const formulas = [...document.querySelectorAll("mjx-math[aria-hidden=true]")];
window.glyphs = formulas.map((math) => [math, [...math.childNodes]]);
for (const [math] of glyphs) math.replaceChildren(); }
"""
GIVE_GLYPHS = "for (const [math, parts] of glyphs) math.replaceChildren(...parts);"


@contextmanager
def axe_in(driver):
    """Bring axe to the current document, and leave it as it was."""
    driver.execute_script(AXE + LOOKS + TAKE_GLYPHS)
    try:
        yield
    finally:
        driver.execute_script(GIVE_GLYPHS)


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_serious(look, name):
    driver = look(name)
    with axe_in(driver):
        assert complaints_on_two_screens(driver) == []
    for frame in driver.find_elements("css selector", "iframe"):
        driver.switch_to.frame(frame)
        wait_until(lambda: driver.find_elements("css selector", ".controls"))
        with axe_in(driver):
            assert complaints(driver, "scene") == []
        driver.switch_to.default_content()


FAINT = "#ccc"
PAGE = """<!doctype html><html lang="en" data-theme="light"><meta charset="utf-8"><title>Faint</title>
<meta name="viewport" content="width=device-width"><style>body {{ background: #fff; color: #000 }} {style}</style>
<main><h1>Faint</h1><p>Some text.</p></main></html>"""


@pytest.mark.parametrize(
    ("style", "where"),
    [
        (f"p {{ color: {FAINT} }}", "wide, light"),
        (f"[data-theme=dark] p {{ color: {FAINT} }}", "wide, dark"),
        (f"@media (max-width: 600px) {{ p {{ color: {FAINT} }} }}", "narrow, light"),
        (f"@media (max-width: 600px) {{ main {{ color: {FAINT} }} }}", "narrow, dark"),
        (f"@media (max-width: 600px) {{ [data-theme=dark] p {{ color: {FAINT} }} }}", "narrow, dark"),
    ],
)
def test_faint_text_is_found_where_it_is(chromium, tmp_path, style, where):
    path = tmp_path / "page.html"
    path.write_text(PAGE.format(style=style), encoding="utf-8")
    chromium.get(path.as_uri())
    with axe_in(chromium):
        found = complaints_on_two_screens(chromium)
    assert f"{where}: color-contrast" in " ".join(found)
    assert all("color-contrast" in complaint for complaint in found)


UNNAMED = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Unnamed</title>
<meta name="viewport" content="width=device-width"><style>button {{ display: {wide} }}
@media (max-width: 600px) {{ button {{ display: {narrow} }} }}</style>
<main><h1>Unnamed</h1><div><button></button></div></main></html>"""


@pytest.mark.parametrize(("wide", "narrow"), [("inline", "none"), ("none", "inline")])
def test_a_button_without_a_name_is_found_where_it_is_shown(chromium, tmp_path, wide, narrow):
    path = tmp_path / "page.html"
    path.write_text(UNNAMED.format(wide=wide, narrow=narrow), encoding="utf-8")
    chromium.get(path.as_uri())
    with axe_in(chromium):
        found = complaints_on_two_screens(chromium)
    (complaint,) = found
    assert complaint.startswith(f"{'wide' if narrow == 'none' else 'narrow'}: button-name: button")
