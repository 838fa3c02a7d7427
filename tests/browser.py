"""A headless Chromium that reaches nothing but files and this machine."""

import json
import shutil
import time
from contextlib import contextmanager

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
)


def missing_programs() -> list[str]:
    """The programs of the browser tests that are not installed."""
    return [name for name in ("chromium", "chromedriver") if not shutil.which(name)]


def start_chromium():
    """A new Chromium; the caller quits it."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in FLAGS:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = webdriver.ChromeService(executable_path=shutil.which("chromedriver"))
    driver = webdriver.Chrome(options=options, service=service)
    driver.set_page_load_timeout(60)
    return driver


def console_messages(driver) -> list[str]:
    """What the pages said on the console since the last call, worse than information."""
    bad = (entry for entry in driver.get_log("browser") if entry["level"] in ("WARNING", "SEVERE"))
    return [f"{entry['level']}: {entry['message']}" for entry in bad]


def requested_urls(driver) -> list[str]:
    """What the pages asked for since the last call, frames and workers included."""
    messages = (json.loads(entry["message"])["message"] for entry in driver.get_log("performance"))
    return [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]


@contextmanager
def screen(driver, width: int, height: int = 800):
    """A screen of another size, a phone's if it is narrow; what this gives makes it another one again."""

    def become(width: int, height: int = 800) -> None:
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    become(width, height)
    try:
        yield become
    finally:
        driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def wait_until(condition, seconds: float = 60):
    """Wait for something to become true, and return it."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.1)
    return value
