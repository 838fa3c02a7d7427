"""The table: what is measured against what, what is asked, and whether that is met."""

import os
import platform
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from . import peers, work
from .clock import Setup, importing, limited, race
from .peers import slow

HEADINGS = ("work", "kinlib", "measured against", "takes", "ratio", "asked", "met")
SIZE = 100_000  # problems in a batch
BUDGET = 3.0  # seconds for a row; a slow one is measured once

PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


@dataclass(frozen=True)
class Row:
    """Work of kinlib beside a yardstick, or beside the same work of a peer."""

    work: str
    ours: Setup
    against: str
    theirs: Setup
    ratio: float | None = None  # asked: at most this many times as much as theirs
    seconds: float | None = None  # asked: at most this time
    unit: str = "s"
    patience: float = 1  # how many times as long as the others it is measured, where the noise is large

    def cells(self, size: int, budget: float) -> list[str]:
        """What is printed, measured for batches of a size."""
        release = _release(self.against)
        setups = [self.ours, self.theirs] if release is not None else [self.ours]
        ours, *theirs = race([setup(size) for setup in setups], budget * self.patience)
        ratio = ours / theirs[0] if theirs else None
        takes = _quantity(theirs[0], self.unit) if theirs else "not installed"
        shown = f"{ratio:.2g}" if ratio and np.isfinite(ratio) else "–"
        name = f"{self.against} {release or ''}".strip()
        return [self.work, _quantity(ours, self.unit), name, takes, shown, *self._verdict(ours, ratio)]

    def _verdict(self, ours: float, ratio: float | None) -> tuple[str, str]:
        value, limit = (ours, self.seconds) if self.seconds else (ratio, self.ratio)
        if limit is None:
            return "–", "–"
        asked = f"≤ {_quantity(limit, 's')}" if self.seconds else f"ratio ≤ {limit:g}"
        return asked, "–" if value is None else "yes" if value <= limit else "NO"


def _release(name: str) -> str | None:
    """The version of a peer, None if it is not installed; yardsticks have none and are always there."""
    if name not in peers.NAMES:
        return ""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _quantity(value: float, unit: str) -> str:
    """Three digits and a prefix: 0.00123 s is 1.23 ms."""
    if not np.isfinite(value):
        return "failed" if np.isnan(value) else f"> {peers.LIMIT} {unit}"
    prefix = next((name for name, scale in PREFIXES.items() if value >= 0.9995 * scale), "n")
    number = value / PREFIXES[prefix]
    return f"{number:.{max(0, 3 - len(str(int(number))))}f} {prefix}{unit}"


MOTION = f"motion at {work.PARAMETERS} parameters"
IMPORT = importing("kinlib")
DRAG = limited("tests.bench.drag", "goldberg", 60)

ROWS = (
    Row("product, one", work.one_product, "kingdon", peers.kingdon_one_product, ratio=1 / 4),
    Row("product, one", work.one_product, "rational-linkages", peers.rational_one_product),
    Row("product, one", work.one_product, "dqrobotics", peers.dqrobotics_one_product),
    Row("products, batch", work.products, "copying both operands", work.copies, ratio=6),
    Row("products, batch", work.products, "kingdon", peers.kingdon_batch, ratio=1),
    Row("products, batch", work.products, "pytransform3d", peers.pytransform3d_batch),
    Row("pose on a point, batch", work.act_on_points, "products, batch", work.products, ratio=2),
    Row("pose on a point, batch", work.act_on_points, "pytransform3d", peers.pytransform3d_points),
    Row("pose on a point, one", work.act_on_one_point, "rational-linkages", peers.rational_one_point),
    Row("pose on a line, batch", work.act_on_lines, "products, batch", work.products, ratio=2),
    Row(
        "three poses → Bennett, one", work.one_bennett, "rational-linkages", slow(peers.rational_bennett), seconds=5e-4
    ),
    Row("three poses → Bennett, batch", work.bennett, "eigvals of 4×4 matrices", work.eigenvalues, ratio=1.5),
    Row("three poses, z → eight 5R, batch", work.goldberg, "eigvals of 4×4 matrices", work.eigenvalues, ratio=3),
    Row(
        "cubic → six factorizations, one",
        work.six_factorizations,
        "biquaternion-py",
        slow(peers.biquaternion_factorizations),
        seconds=1.5e-3,
    ),
    Row(
        "cubic → six factorizations, one",
        work.six_factorizations,
        "rational-linkages",
        slow(peers.rational_two_factorizations),
    ),
    Row("four poses → all 6R, one", work.six_r, "rational-linkages", slow(peers.rational_six_r), seconds=5e-3),
    Row("four poses → all 6R, batch", work.six_r_batch, "eigvals of 6×6 matrices", work.larger_eigenvalues, ratio=10),
    Row(
        "axes → motion of a 5R, one",
        work.motion_of_axes,
        "singular values of the axes",
        work.singular_values,
        seconds=2e-3,
    ),
    Row(
        "all collisions of an exact 5R", work.exact_collisions, "exact eight 5R, one", work.exact_goldberg, seconds=0.3
    ),
    Row(
        f"all collisions of {work.MANY:,} 5R",
        work.collisions,
        "eigvals of 6×6 matrices",
        work.larger_eigenvalues,
        seconds=5.0,
    ),
    Row(MOTION, work.motion, "one matrix product", work.matrix_product, ratio=4),
    Row(
        "four lines → 5R, 300 starts",
        work.five_r_for_lines,
        "one start of SciPy's least_squares",
        work.one_start_of_scipy,
        seconds=10,
    ),
    Row(MOTION, work.motion, "rational-linkages", slow(peers.rational_motion)),
    Row(
        "best of 5R by clearance, one core",
        work.best_of_many,
        "eigvals of 4×4 matrices",
        work.eigenvalues,
        seconds=12.0,
    ),
    Row("one drag step in the page", DRAG, "a frame at 60 Hz", lambda size: lambda: 1 / 60, seconds=8e-3),
    Row("import kinlib", IMPORT, "import numpy", importing("numpy"), ratio=1.3, patience=4),
    Row("import a synthesis", importing("kinlib", "bennett_linkage"), "import numpy", importing("numpy"), patience=4),
    Row("import kinlib", IMPORT, "dqrobotics", importing("dqrobotics")),
    Row("import kinlib", IMPORT, "pytransform3d", importing("pytransform3d.transformations")),
    Row("import kinlib", IMPORT, "rational-linkages", importing("rational_linkages")),
    Row("memory for eight 5R, batch", work.goldberg_memory, "their numbers", work.goldberg_result, unit="B"),
)


def table(size: int = SIZE, budget: float = BUDGET) -> list[list[str]]:
    """The cells of all rows, telling on stderr which one is being measured."""
    return [_measured(row, size, budget) for row in ROWS]


def _measured(row: Row, size: int, budget: float) -> list[str]:
    print(f"\r\033[K{row.work} | {row.against}", end="", file=sys.stderr, flush=True)
    return row.cells(size, budget)


def as_text(rows: list[list[str]]) -> str:
    """The table in Markdown, its columns aligned."""
    columns = list(zip(HEADINGS, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    lines = [
        " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in (HEADINGS, *rows)
    ]
    rule = " | ".join("-" * width for width in widths)
    return "\n".join(f"| {line} |" for line in (lines[0], rule, *lines[1:]))


def machine() -> str:
    """Processor, cores, Python and NumPy."""
    return f"{_processor()}, {os.cpu_count()} cores; Python {platform.python_version()}, NumPy {np.__version__}"


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
