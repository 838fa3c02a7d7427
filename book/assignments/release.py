"""Makes the students' copies from the solved notebooks: ``python book/assignments/release.py [NAME …]``.

nbgrader removes solutions and hidden tests and locks what students must not change.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

import nbformat
from nbgrader.apps import NbGraderAPI
from traitlets.config import Config

HERE = Path(__file__).parent


def generate(assignments: list[str], folder: Path) -> None:
    """Write the students' copies below a folder, as nbgrader's command generate_assignment does."""
    beside_python = str(Path(sys.executable).parent)  # where nbgrader looks for the program alembic
    os.environ["PATH"] = os.pathsep.join([beside_python, os.environ.get("PATH", os.defpath)])
    with tempfile.TemporaryDirectory() as course:
        shutil.copytree(HERE / "source", Path(course, "source"), ignore=shutil.ignore_patterns(".*"))
        settings = Config()
        settings.CourseDirectory.root = course
        api = NbGraderAPI(config=settings)
        for name in assignments:
            answer = api.generate_assignment(name)
            if not answer["success"]:
                raise RuntimeError(f"nbgrader could not make {name}:\n{answer['log']}")
            made, kept = Path(course, "release", name), folder / name
            kept.mkdir(parents=True, exist_ok=True)
            normalise(made / f"{name}.ipynb", kept / f"{name}.ipynb")


def normalise(made: Path, kept: Path) -> None:
    """Save a copy so that generating it again changes nothing."""
    notebook = nbformat.read(made, as_version=4)
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number:02d}"
    nbformat.write(notebook, kept)


def assignments() -> list[str]:
    """The names of all assignments."""
    return sorted(path.parent.name for path in HERE.glob("source/*/*.ipynb"))


if __name__ == "__main__":
    names = sys.argv[1:] or assignments()
    generate(names, HERE / "release")
    print(f"students' copies of {', '.join(names)}")
