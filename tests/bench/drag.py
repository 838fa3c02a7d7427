"""Prints how long one drag step of the landing page's scene takes in Chromium, in seconds: the script, not the drawing.

A step moves z, evaluates the formulas, writes the table, and lays bars and path; ``python -m tests.bench.drag NAME``.
"""

import statistics
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from kinlib.gallery import THREE_POSES
from kinlib.pictures import goldberg_scene
from tests.browser import start_chromium, wait_until

STEPS = """
const pad = document.querySelector(".pad"), box = pad.getBoundingClientRect(), took = [];
pad.setPointerCapture = () => {};
pad.hasPointerCapture = () => true;
const event = (name, n) => new PointerEvent(name, {
  pointerId: 1, clientX: box.left + box.width * (0.3 + n / 1000), clientY: box.top + 0.4 * box.height });
pad.dispatchEvent(event("pointerdown", 0));
for (let n = 0; n < 300; n += 1) {
  const start = performance.now();
  pad.dispatchEvent(event("pointermove", n));
  kinlib.seek(n % 120);
  took.push(performance.now() - start);
}
return took;
"""


def drag_step() -> float:
    """The median of three hundred steps."""
    with TemporaryDirectory() as folder:
        page = goldberg_scene(THREE_POSES, alt="A 5R linkage follows z.").save(Path(folder) / "scene.html")
        driver = start_chromium()
        try:
            driver.get(page.as_uri())
            wait_until(lambda: driver.execute_script("return window.kinlib && kinlib.ready"))
            return statistics.median(driver.execute_script(STEPS)) / 1000
        finally:
            driver.quit()


if __name__ == "__main__":
    sys.exit(print(drag_step()))
