"""How the package is laid out: the order of its files, what an import loads, what is public."""

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path
from typing import get_type_hints

import pytest

import kinlib

PACKAGE = Path(kinlib.__file__).parent

# Each file imports only from files before it: the pictures stand at the end, so that no theory needs them.
ORDER = [
    "errors",
    "shown",
    "scalar",
    "number_field",
    "dual_quaternion",
    "typing",
    "saving",
    "tables",
    "rows",
    "projective",
    "quadric",
    "study",
    "line",
    "displacement",
    "poses",
    "motion_polynomial",
    "quadratics",
    "polishing",
    "factorization",
    "cubics",
    "interpolation",
    "dyad",
    "chain",
    "loop",
    "closure",
    "relative_motion",
    "mobility",
    "drive",
    "circle",
    "moving_bars",
    "collision",
    "exact_collision",
    "loop_collisions",
    "phase",
    "reach",
    "timetable",
    "closing",
    "joint_rates",
    "several_turns",
    "loop_motion",
    "bonds",
    "linkage",
    "pose_faults",
    "dyad_routes",
    "surface",
    "three_poses",
    "bennett",
    "six_r",
    "z_plane",
    "goldberg",
    "measures",
    "blocks",
    "brief",
    "stages",
    "linkage_search",
    "tolerance",
    "task",
    "task_count",
    "task_search",
    "task_wishes",
    "task_problem",
    "task_linkages",
    "task_follow",
    "gallery",
    "testing",
    "export.xml",
    "export.bodies",
    "export.mjcf",
    "export.urdf",
    "export.rational",
    "export.printing",
    "pictures.formula",
    "pictures.colours",
    "pictures.floats",
    "pictures.bars",
    "pictures.turn",
    "pictures.shapes",
    "pictures.parts",
    "pictures.linkage_parts",
    "pictures.meshes",
    "pictures.canvas",
    "pictures.bond_diagram",
    "pictures.draw",
    "pictures.joint_angles",
    "pictures.recording",
    "pictures.still",
    "pictures.page",
    "pictures.scene",
    "pictures.moving",
    "pictures.controls",
    "pictures.tasks",
    "pictures.explorable",
    "pictures.explorable_5r",
    "pictures.explorable_samples",
]

PUBLIC = [
    "DualQuaternion", "one", "i", "j", "k", "eps", "same_point", "join", "meet", "Quadric",
    "Subspace", "STUDY_QUADRIC", "NULL_CONE", "EXCEPTIONAL_SPACE", "is_null_line", "Line",
    "translation", "rotation", "half_turn", "act", "from_matrix", "as_matrix", "MotionPolynomial",
    "factorizations", "factorize", "conic_through", "cubics_through", "Dyad", "TwoRSpace",
    "recognise", "dyads_through_poses", "Chain", "Linkage", "bennett_linkage", "goldberg_linkages",
    "six_r_linkages", "DegenerateError",
]  # fmt: skip

PACKAGES = ("kinlib", "kinlib.export", "kinlib.pictures")
FILES = (path for path in PACKAGE.rglob("*.py") if path.stem != "__init__")
MODULES = sorted(".".join(path.relative_to(PACKAGE).with_suffix("").parts) for path in FILES)


def imported_modules(name: str) -> set[str]:
    """The modules of kinlib that a module imports, anywhere in its text."""
    found = set()
    for node in ast.walk(ast.parse(PACKAGE.joinpath(*name.split(".")).with_suffix(".py").read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("kinlib."):
            found.add(node.module.removeprefix("kinlib."))
        elif isinstance(node, ast.ImportFrom) and node.module == "kinlib":
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.Import):
            names = (alias.name for alias in node.names)
            found.update(name.removeprefix("kinlib.") for name in names if name.startswith("kinlib"))
    return found


def public_objects(name: str) -> list:
    module = importlib.import_module(name)
    return [getattr(module, public) for public in module.__all__]


def functions_of(thing) -> list:
    """A function of kinlib itself; of a class its public methods, its operators and what its properties call."""
    members = [thing]
    if inspect.isclass(thing):
        items = (item for base in thing.__mro__ for item in vars(base).items())
        members = [member for name, member in items if not name.startswith("_") or name.endswith("__")]
    plain = (getattr(x, "fget", None) or getattr(x, "func", None) or getattr(x, "__func__", x) for x in members)
    functions = map(inspect.unwrap, filter(inspect.isfunction, plain))
    return [f for f in functions if Path(f.__code__.co_filename).is_relative_to(PACKAGE)]


def without_hint(function) -> list[str]:
    """The parameters of a function that have no hint, and "return" if its value has none."""
    names = [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]
    names += [] if function.__name__ == "__init__" else ["return"]
    hints = get_type_hints(function)
    return [name for name in names if name not in hints]


def test_the_order_names_every_file():
    assert set(MODULES) == set(ORDER)


@pytest.mark.parametrize("name", MODULES)
def test_a_file_imports_only_from_files_above_it(name):
    above = set(ORDER[: ORDER.index(name)])
    assert imported_modules(name) <= above


def test_no_theory_needs_the_pictures():
    theory = [name for name in MODULES if not name.startswith("pictures.")]
    assert ORDER[: len(theory)] == [name for name in ORDER if name in theory]
    assert not any(name.startswith("pictures") for module in theory for name in imported_modules(module))


def test_import_kinlib_is_light():
    heavy = ("sympy", "matplotlib", "meshcat", "scipy", "IPython", "trimesh", "kinlib.export", "kinlib.pictures")
    names = "[getattr(kinlib, name) for name in kinlib.__all__]"
    code = f"import sys, kinlib; {names}; print([name for name in {heavy!r} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


@pytest.mark.parametrize("name", PUBLIC)
def test_public_names(name):
    assert hasattr(kinlib, name)


@pytest.mark.parametrize("name", MODULES)
def test_public_objects_are_documented(name):
    objects = [x for x in public_objects(f"kinlib.{name}") if inspect.isroutine(x) or inspect.isclass(x)]
    assert [x.__name__ for x in objects if not (x.__doc__ or "").strip()] == []


@pytest.mark.parametrize("name", [*PACKAGES, *(f"kinlib.{name}" for name in MODULES)])
def test_all_that_is_public_has_hints(name):
    missing = {f.__qualname__: without_hint(f) for thing in public_objects(name) for f in functions_of(thing)}
    assert {function: names for function, names in missing.items() if names} == {}


@pytest.mark.parametrize("name", MODULES)
def test_the_fields_of_public_classes_have_hints_that_are_known(name):
    for thing in filter(inspect.isclass, public_objects(f"kinlib.{name}")):
        known = get_type_hints(thing)
        assert set(inspect.get_annotations(thing)) <= set(known)
