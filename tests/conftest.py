"""The built book and a browser to look at it."""

from pathlib import Path

import pytest

from browser import missing_programs, start_chromium

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def html() -> Path:
    """The folder of the built book."""
    folder = ROOT / "_build" / "html"
    if not (folder / "index.html").exists():
        pytest.skip("the book is not built: run `make book`")
    return folder


@pytest.fixture(scope="session")
def chromium():
    """A Chromium driven by Selenium; the tests that need it skip where it is missing."""
    if missing_programs():
        missing = " and ".join(missing_programs())
        pytest.skip(f"not installed: {missing} (Debian: apt install chromium chromium-driver)")
    driver = start_chromium()
    yield driver
    driver.quit()
