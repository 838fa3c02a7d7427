"""The built book, and a browser to look at it."""

from pathlib import Path
from urllib.parse import urlsplit

import pytest

from browser import console_messages, missing_programs, requested_urls, start_chromium
from pages import HTML

SETTLED = """
const done = arguments[0];
const settle = window.MathJax && MathJax.startup ? MathJax.startup.promise : Promise.resolve();
settle.then(() => requestAnimationFrame(() => done(true)));
"""


@pytest.fixture(scope="session")
def html() -> Path:
    """The folder of the built book."""
    if not (HTML / "index.html").exists():
        pytest.skip("the book is not built: run `make book`")
    return HTML


@pytest.fixture(scope="session")
def chromium():
    """A Chromium driven by Selenium; the tests that need it skip where it is missing."""
    if missing_programs():
        missing = " and ".join(missing_programs())
        pytest.skip(f"not installed: {missing} (Debian: apt install chromium chromium-driver)")
    driver = start_chromium()
    yield driver
    driver.quit()


def opened(driver, url: str):
    """The browser at a page whose mathematics is set."""
    driver.set_script_timeout(120)
    driver.get(url)
    driver.execute_async_script(SETTLED)
    return driver


def is_elsewhere(url: str) -> bool:
    return urlsplit(url).scheme not in ("file", "data", "blob", "about")


def nothing_was_amiss(driver) -> None:
    """Since the last look nothing was asked of the network, and no page complained."""
    assert [url for url in requested_urls(driver) if is_elsewhere(url)] == []
    assert console_messages(driver) == []


@pytest.fixture
def page(chromium, html):
    """Opens a page of the book anew, to do something with it; nothing may be amiss afterwards."""
    chromium.get("about:blank")
    console_messages(chromium), requested_urls(chromium)

    def open_page(name: str):
        path, mark, query = name.partition("?")
        return opened(chromium, (html / path).as_uri() + mark + query)

    yield open_page
    nothing_was_amiss(chromium)


@pytest.fixture
def look(chromium, html):
    """Opens a page of the book only to look at it: if the test before has looked at it too, it is open still.

    Nothing moves, as for a reader who asks for that, so that no colour is on its way to another.
    """
    stillness = {"name": "prefers-reduced-motion", "value": "reduce"}
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [stillness]})

    def at(name: str):
        url = (html / name).as_uri()
        return chromium if chromium.current_url == url else opened(chromium, url)

    yield at
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    nothing_was_amiss(chromium)
