"""How the assignments are laid out: what each consists of, what it may import, what a student installs."""

import ast
import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import kinlib
import kinlib_assignments
from grader import masters

PACKAGE = Path(kinlib_assignments.__file__).parent
BOOK = masters.HERE.parent
FILES = sorted(path.stem for path in PACKAGE.glob("*.py") if path.stem != "__init__")
SHARED = ["lot", "withhold", "seal", "checks"]  # each imports only from those before it, an assignment from all of them

# What kinlib offers to whoever uses it.
FRONT_DOOR = {"kinlib", "kinlib.gallery", "kinlib.pictures", "kinlib.testing", "kinlib.draw", "kinlib.scene"}


def imports(text: str) -> dict[str, set[str]]:
    """The names that a program imports from each module, anywhere in its text."""
    found: dict[str, set[str]] = {}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            found.setdefault(node.module, set()).update(alias.name for alias in node.names)
        elif isinstance(node, ast.Import):
            found.update({alias.name: set() for alias in node.names})
    return found


def of_kinlib(text: str) -> set[str]:
    return {module for module in imports(text) if module.split(".")[0] == "kinlib"}


def public_objects(name: str) -> list:
    module = importlib.import_module(f"kinlib_assignments.{name}")
    return [getattr(module, public) for public in module.__all__]


# ---- one assignment, few places --------------------------------------------------------------------------


def test_each_file_is_shared_or_an_assignments():
    assert set(FILES) == {*SHARED, *masters.ASSIGNMENTS}


@pytest.mark.parametrize("name", masters.ASSIGNMENTS)
def test_each_assignment_has_all_its_parts(name):
    file = f"assignments/release/{name}/{name}"
    assert masters.release(name).exists()
    assert Path(__file__).with_name(f"test_assignment_{name}.py").exists()
    assert f"- file: book/{file}\n" in (BOOK.parent / "_toc.yml").read_text(encoding="utf-8")
    assert f"]({file.removeprefix('assignments/')}.ipynb)" in (masters.HERE / "overview.md").read_text(encoding="utf-8")


def test_the_teachers_table_has_every_assignment():
    rows = re.findall(r"^\| (\d+)\. \*", (masters.HERE / "teaching.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert [int(number) for number in rows] == [n + 1 for n in range(len(masters.ASSIGNMENTS))]


# ---- what is imported ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["__init__", *FILES])
def test_a_file_uses_what_kinlib_offers(name):
    assert of_kinlib((PACKAGE / f"{name}.py").read_text(encoding="utf-8")) <= FRONT_DOOR


@pytest.mark.parametrize("name", masters.ASSIGNMENTS)
def test_a_notebook_uses_what_kinlib_offers(name):
    cells = [cell.source for cell in masters.read(masters.source(name)).cells if cell.cell_type == "code"]
    assert set().union(*map(of_kinlib, cells)) <= FRONT_DOOR


@pytest.mark.parametrize("name", FILES)
def test_assignments_do_not_import_one_another(name):
    above = SHARED[: SHARED.index(name)] if name in SHARED else SHARED
    used = imports((PACKAGE / f"{name}.py").read_text(encoding="utf-8"))
    assert {module for module in used if module.startswith("kinlib_assignments")} <= {
        f"kinlib_assignments.{other}" for other in above
    }


@pytest.mark.parametrize("name", FILES)
def test_public_names_are_documented_and_have_hints(name):
    objects = [x for x in public_objects(name) if inspect.isroutine(x) or inspect.isclass(x)]
    assert [x.__name__ for x in objects if not (x.__doc__ or "").strip()] == []
    assert [x.__name__ for x in objects if inspect.isfunction(x) and not x.__annotations__] == []


# ---- what students install -------------------------------------------------------------------------------


def run(*command, **options) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel of the assignments, built from a copy of what it is made of."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    shutil.copy(masters.HERE / "pyproject.toml", source)
    shutil.copytree(PACKAGE, source / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__"))
    options = ("--no-deps", "--no-build-isolation", "--wheel-dir", str(target))
    run(sys.executable, "-m", "pip", "wheel", *options, str(source))
    return next(target.glob("kinlib_assignments-*.whl"))


def test_the_wheel_holds_the_package_and_no_solution(wheel):
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert packed == {f"kinlib_assignments/{path.name}" for path in PACKAGE.glob("*.py")}


def test_the_page_for_teachers_names_the_wheel(wheel):
    page = (masters.HERE / "teaching.md").read_text(encoding="utf-8")
    assert f"kinlib-{kinlib.__version__}-py3-none-any.whl {wheel.name} jupyterlab" in page


def test_the_wheel_works_beside_kinlib_outside_the_source_tree(wheel, tmp_path):
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "--no-deps", "--target", str(site), str(wheel))
    shutil.copytree(Path(kinlib.__file__).parent, site / "kinlib", ignore=shutil.ignore_patterns("__pycache__"))
    code = f"""
import importlib, pathlib, kinlib_assignments
for name in {FILES}:
    importlib.import_module(f"kinlib_assignments.{{name}}")
from kinlib_assignments.dual_quaternions import data
assert data("ada").q == (4, 4, 5, -1, -3, -2, 1, -1)
print(pathlib.Path(kinlib_assignments.__file__).parent)
"""
    printed = run(sys.executable, "-c", code, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(site)})
    assert Path(printed.strip()) == site / "kinlib_assignments"
