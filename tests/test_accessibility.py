"""Every page of the book, with all its scenes, can be read by those who see little or hear it read out."""

from importlib.resources import files

import pytest

from browser import screen, wait_until
from pages import PAGES

AXE = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
CONTRAST = {"runOnly": ["color-contrast", "link-in-text-block"]}  # all that the theme decides
ALL_RULES = {"rules": {"label-content-name-mismatch": {"enabled": True}}}  # in newer versions it is from the start

RUN_AXE = """
const [options, done] = arguments;
const serious = ({ impact }) => ["serious", "critical"].includes(impact);
axe.run(document, { iframes: false, resultTypes: ["violations"], ...options }).then(
  ({ violations }) => done(violations.filter(serious).flatMap(
    ({ id, nodes }) => nodes.map(({ target, html }) => `${id}: ${target} ${html.slice(0, 200)}`))),
  (error) => done([String(error)]));
"""


@pytest.fixture
def still(chromium):
    """Nothing moves, as for a reader who asks for that, so that no colour is on its way to another."""
    preference = {"name": "prefers-reduced-motion", "value": "reduce"}
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [preference]})
    yield
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def complaints(driver) -> list[str]:
    """The serious violations in the current document, in light and dark."""
    driver.execute_script(AXE)
    found = []
    for theme, options in (("light", ALL_RULES), ("dark", CONTRAST)):
        driver.execute_script("document.documentElement.dataset.theme = arguments[0]", theme)
        found += [f"{theme}: {complaint}" for complaint in driver.execute_async_script(RUN_AXE, options)]
    return found


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_serious(chromium, still, page, name):
    driver = page(name)
    for width in (1300, 390):
        with screen(chromium, width):
            assert complaints(driver) == []
    for frame in driver.find_elements("css selector", "iframe"):
        driver.switch_to.frame(frame)
        wait_until(lambda: driver.find_elements("css selector", ".controls"))
        assert complaints(driver) == []
        driver.switch_to.default_content()
