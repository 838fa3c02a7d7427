"""The wheel holds all that kinlib needs."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from email import message_from_bytes
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


def test_the_wheel_has_its_types_and_its_player(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    player = {f"kinlib/pictures/{name}" for name in ("__init__.py", "explorer.js", "viewer.js", "viewer.css")}
    assert {"kinlib/py.typed", *player} <= set(names)


def test_the_theory_needs_numpy_and_sympy_only(wheel):
    (metadata,) = (name for name in zipfile.ZipFile(wheel).namelist() if name.endswith("/METADATA"))
    needs = message_from_bytes(zipfile.ZipFile(wheel).read(metadata)).get_all("Requires-Dist")
    always = {re.match(r"[\w-]+", need)[0] for need in needs if "extra ==" not in need}
    pictures = {re.match(r"[\w-]+", need)[0] for need in needs if re.search(r"extra == .pictures.", need)}
    assert (always, pictures) == ({"numpy", "sympy"}, {"matplotlib", "meshcat"})
    (meshcat,) = (need for need in needs if need.startswith("meshcat"))
    assert "<" in meshcat, "a version of meshcat that was not tried may break the player"


def test_the_wheel_works_outside_the_source_tree(wheel, tmp_path):
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--no-deps", "--target", str(site), str(wheel))
    code = """
import importlib, pathlib, kinlib
folder = pathlib.Path(kinlib.__file__).parent
for path in folder.rglob("*.py"):
    importlib.import_module(".".join(path.relative_to(folder.parent).with_suffix("").parts).removesuffix(".__init__"))
from kinlib import eps, i, j, k
from kinlib.pictures import static_files
assert i * j * k == -1 and eps * eps == 0
assert all(path.exists() for path in static_files().values())
print(folder)
"""
    printed = run(sys.executable, "-c", code, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(site)})
    assert Path(printed.strip()) == site / "kinlib"
