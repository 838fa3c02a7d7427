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


@pytest.fixture
def page(chromium, html):
    """Opens a page of the book and waits for its mathematics; afterwards nothing may have been amiss."""
    chromium.set_script_timeout(120)
    chromium.get("about:blank")
    console_messages(chromium), requested_urls(chromium)

    def open_page(name: str):
        path, mark, query = name.partition("?")
        chromium.get((html / path).as_uri() + mark + query)
        chromium.execute_async_script(SETTLED)
        return chromium

    yield open_page
    assert [url for url in requested_urls(chromium) if is_elsewhere(url)] == []
    assert console_messages(chromium) == []


def is_elsewhere(url: str) -> bool:
    return urlsplit(url).scheme not in ("file", "data", "blob", "about")
