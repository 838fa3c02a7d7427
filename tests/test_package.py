"""The wheel holds all that kinlib needs."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def run(*command, **options) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel of this source, built from a copy of it."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    shutil.copytree(ROOT / "kinlib", source / "kinlib", ignore=shutil.ignore_patterns("__pycache__"))
    options = ("--no-deps", "--no-build-isolation", "--wheel-dir", str(target))
    run(sys.executable, "-m", "pip", "wheel", *options, str(source))
    return next(target.glob("kinlib-*.whl"))


def test_the_wheel_holds_every_file(wheel):
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("kinlib/")}
    sources = [path for path in (ROOT / "kinlib").rglob("*") if path.is_file() and path.parent.name != "__pycache__"]
    files = {path.relative_to(ROOT).as_posix() for path in sources}
    assert packed == files


def test_the_wheel_works_outside_the_source_tree(wheel, tmp_path):
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--no-deps", "--target", str(site), str(wheel))
    code = """
import importlib, pathlib, kinlib
folder = pathlib.Path(kinlib.__file__).parent
for path in folder.glob("*.py"):
    importlib.import_module(f"kinlib.{path.stem}")
from kinlib import eps, i, j, k, scene
assert i * j * k == -1 and eps * eps == 0
assert all(path.exists() for path in scene.static_files().values())
print(folder)
"""
    printed = run(sys.executable, "-c", code, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(site)})
    assert Path(printed.strip()) == site / "kinlib"
