"""The front doors: what a user imports comes through them, and the reference has each of their names once."""

import ast
import json
import re
import subprocess
import sys
from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest

import kinlib

DOORS = ("kinlib", "kinlib.export", "kinlib.task", "kinlib.pictures", "kinlib.gallery", "kinlib.testing")
ROOT = Path(__file__).resolve().parents[1]
BOOK = ROOT / "book"
# The assignments are a project of their own, beside the book.
PAGES = [ROOT / "README.md", *(page for page in sorted(BOOK.rglob("*")) if page.suffix in (".md", ".ipynb"))]
PAGES = [page for page in PAGES if "assignments" not in page.relative_to(ROOT).parts]
TESTS = sorted(Path(__file__).parent.rglob("*.py"))
IMPORT = re.compile(r"^(?:>>> )?(from|import) +(kinlib[\w.]*)(?: +import +(\([^)]*\)|[^\n#]*))?", re.MULTILINE)


def offered(door: str) -> set[str]:
    return set(import_module(door).__all__)


def text_of(page: Path) -> str:
    """The text of a page, or of all cells of a notebook."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        text = "\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"])
    return text


@pytest.mark.parametrize("door", DOORS)
def test_a_door_offers_what_it_lists(door):
    module = import_module(door)
    assert len(set(module.__all__)) == len(module.__all__)
    assert [name for name in module.__all__ if not hasattr(module, name)] == []


def test_the_door_opens_when_it_is_asked():
    code = "import sys, kinlib; print('numpy' in sys.modules); kinlib.one; print('kinlib.linkage' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "False"]


def test_editors_read_of_the_names_that_there_are():
    tree = ast.parse(Path(kinlib.__file__).read_text(encoding="utf-8"))
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module.startswith("kinlib")]
    found = {alias.name: node.module for node in nodes for alias in node.names}
    assert sorted(found) == sorted(kinlib.__all__) == sorted(set(dir(kinlib)) & set(kinlib.__all__))
    for name, module in found.items():
        assert getattr(kinlib, name) is getattr(import_module(module), name)


def test_what_the_door_does_not_have():
    with pytest.raises(AttributeError, match="module 'kinlib' has no attribute 'no_such_name'"):
        kinlib.no_such_name  # noqa: B018


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_import_through_the_doors(page):
    for kind, module, names in IMPORT.findall(text_of(page)):
        assert module in DOORS, f"{module} is behind the doors"
        if kind == "from":
            asked = {name.strip().split(" as ")[0] for name in names.strip("() \n").split(",") if name.strip()}
            assert asked <= offered(module)


@pytest.mark.parametrize("path", TESTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_tests_import_what_is_public_through_the_doors(path):
    public = set().union(*(offered(door) for door in DOORS))
    behind = [
        f"{node.module}.{alias.name}"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("kinlib.") and node.module not in DOORS
        for alias in node.names
        if alias.name in public
    ]
    assert behind == []


@pytest.mark.parametrize("door", DOORS)
def test_the_reference_has_every_name_once(door):
    found = Counter(re.findall(rf"(?<!module::) {re.escape(door)}\.(\w+)$", reference(), re.MULTILINE))
    assert set(found) == {name for name in offered(door) if f"kinlib.{name}" not in DOORS}
    assert set(found.values()) == {1}


def reference() -> str:
    return "".join((BOOK / page).read_text(encoding="utf-8") for page in ("api.md", "api_pictures.md"))


@pytest.mark.parametrize("library", ["matplotlib", "meshcat"])
def test_pictures_say_what_they_need(library):
    code = f"import sys; sys.modules[{library!r}] = None; import kinlib; import kinlib.pictures"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    last = run.stderr.splitlines()[-1]
    assert last == f'ImportError: kinlib.pictures needs {library}: pip install "kinlib[pictures]"'
