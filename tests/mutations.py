"""Breaks the algebra in seven ways, one at a time, and lists the asserts of the chapters that never notice.

python -m tests.mutations                        all chapters, about a quarter of an hour
python -m tests.mutations bennett factorization  some of them
python -m tests.mutations --workers 2            on two cores

Each break is tried twice: on the whole chapter, and (since what comes before an assert may stop at a break already) on
each cell alone, with what sound cells have made before it.

An assert that no break makes false is empty, or about something that kinlib has no part in: SymPy's polynomials,
counts, a drawing, that an example is what it is said to be.  Which of these, a reader must say.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import io
import json
import multiprocessing
import os
import signal
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl

import kinlib.pictures
from kinlib import NULL_CONE, STUDY_QUADRIC, Quadric, dual_quaternion, factorization, line

BOOK = Path(__file__).resolve().parents[1] / "book"
PARTS = ("preliminaries", "dyads", "synthesis")
SCENES = (  # slow, and no assert looks at them
    "dyad_scene",
    "explorable_scene",
    "goldberg_scene",
    "linkage_scene",
    "linkages_side_by_side",
    "map_scene",
    "sampled_linkages_scene",
)
PATIENCE = 60  # seconds for one cell


@dataclass(frozen=True)
class Break:
    """Changes in the source of some functions, (function, old, new), and signs in the matrix of a quadric."""

    name: str
    edits: tuple[tuple[Callable, str, str], ...]
    signs: tuple[tuple[Quadric, int, int], ...] = ()

    def __call__(self) -> Callable[[], None]:
        """Let the functions, wherever they were imported, do the wrong thing, until what is returned is called."""
        sound = [(function, function.__code__) for function, _, _ in self.edits]
        matrices = [(quadric, quadric.matrix) for quadric, _, _ in self.signs]
        for function in {edit[0] for edit in self.edits}:
            source = textwrap.dedent(inspect.getsource(function))
            for _, old, new in (edit for edit in self.edits if edit[0] is function):
                assert old in source, f"{function.__qualname__} no longer reads {old!r}"
                source = source.replace(old, new)
            scope: dict = {}
            exec(source, sys.modules[function.__module__].__dict__, scope)
            function.__code__ = scope[function.__name__].__code__
        for quadric, row, column in self.signs:
            matrix = quadric.matrix.copy()
            matrix[row, column] *= -1
            object.__setattr__(quadric, "matrix", matrix)

        def mend() -> None:
            for function, code in sound:
                function.__code__ = code
            for quadric, matrix in reversed(matrices):
                object.__setattr__(quadric, "matrix", matrix)

        return mend


PRODUCT = dual_quaternion._product_formula
NORM, CONJUGATE = dual_quaternion.DualQuaternion.norm, dual_quaternion.DualQuaternion.conjugate
STUDY_FORM, NULL_FORM = dual_quaternion.study_form, dual_quaternion.null_form

BREAKS = (
    Break("a·b for b·a", ((PRODUCT, "d3 = a\n    r0, r1, r2, r3, e0, e1, e2, e3 = b",
                           "d3 = b\n    r0, r1, r2, r3, e0, e1, e2, e3 = a"),)),
    Break("a sign of ε: pr + ε(pe − dr)",
          ((PRODUCT, "e3 = b\n", "e3 = b\n    d0, d1, d2, d3 = -d0, -d1, -d2, -d3\n"),)),
    Break("a lost conjugate: p̄ + εd, and q q for q q̄",
          ((CONJUGATE, "1, -1, -1, -1)", "1, 1, 1, 1)"),
           (NORM, "(p * p).sum(axis=0), 2 * (p * d).sum(axis=0)",
            "2 * p[0] * p[0] - (p * p).sum(axis=0), 4 * p[0] * d[0] - 2 * (p * d).sum(axis=0)"))),
    Break("a sign of the Study form",
          ((STUDY_FORM, "+ p1 * e1", "- p1 * e1"), (STUDY_FORM, "+ d1 * r1", "- d1 * r1")),
          ((STUDY_QUADRIC, 1, 5), (STUDY_QUADRIC, 5, 1))),
    Break("a sign of the null form", ((NULL_FORM, "+ p3 * r3", "- p3 * r3"),), ((NULL_CONE, 3, 3),)),
    Break("the moment l × a", ((line._line_at, "np.cross(point, direction)", "np.cross(direction, point)"),)),
    Break("an exchange by h1 − h2", ((factorization.bennett_flip, "h1.conjugate() - h2", "h1 - h2"),)),
)  # fmt: skip

WHOLE = Break("nothing", ())
"""Breaks nothing: in this run every assert must hold."""


class Noted(ast.NodeTransformer):
    """Asserts, and calls of ``assert_…``, become calls that write down what came of them."""

    def __init__(self, cell: int):
        self.cell = cell
        self.checks: dict[str, str] = {}

    def visit_Assert(self, node: ast.Assert) -> ast.stmt:
        return self._noted(node, node.test)

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        call = node.value
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id.startswith("assert_"):
            return self._noted(node, ast.BoolOp(ast.Or(), [call, ast.Constant(True)]))
        return node

    def _noted(self, node: ast.stmt, test: ast.expr) -> ast.stmt:
        name = f"{self.cell}:{node.lineno}"
        self.checks[name] = ast.unparse(node)
        question = ast.Lambda(ast.arguments([], [], None, [], [], None, []), test)
        call = ast.Call(ast.Name("note", ast.Load()), [ast.Constant(name), question], [])
        return ast.fix_missing_locations(ast.copy_location(ast.Expr(call), node))


class Notes(dict):
    """For each assert whether it held, every time it was reached; where it was not reached, nothing."""

    def __call__(self, name: str, question: Callable) -> None:
        try:
            held = bool(question())
        except (NameError, TimeoutError):
            return  # something before it is missing, or there is no end
        except Exception:
            held = False
        self[name] = self.get(name, True) and held


def chapters(words: list[str]) -> list[str]:
    """The notebooks of the book's three parts whose names hold one of the words."""
    found = [path for part in PARTS for path in sorted((BOOK / part).glob("*.ipynb"))]
    return [path.relative_to(BOOK).as_posix() for path in found if not words or any(w in path.name for w in words)]


def code_of(chapter: str) -> Iterator[tuple[list[ast.stmt], dict[str, str]]]:
    """For each code cell its statements, with asserts that take notes, and the text of these asserts."""
    cells = json.loads((BOOK / chapter).read_text(encoding="utf-8"))["cells"]
    for number, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            noted = Noted(number)
            yield noted.visit(ast.parse("".join(cell["source"]))).body, noted.checks


def run(task: tuple[str, Break]) -> tuple[str, str, list[Notes]]:
    """One chapter with one break, in its own process, and its notes; with none, those of each cell broken alone."""
    chapter, broken = task
    broken()
    for name in SCENES:
        setattr(kinlib.pictures, name, lambda *_, **__: None)
    signal.signal(signal.SIGALRM, _too_long)
    sys.stdout = sys.stderr = io.StringIO()
    notes, alone = Notes(), [Notes() for _ in BREAKS]
    scope: dict = {"__name__": "__main__"}
    for statements, checks in code_of(chapter):
        for one, seen in zip(BREAKS, alone, strict=True):
            if checks and not broken.edits:
                mend = one()
                execute(statements, chapter, scope | {"note": seen})
                mend()
        scope["note"] = notes
        execute(statements, chapter, scope)
    return chapter, broken.name, [notes, *alone]


def execute(statements: list[ast.stmt], chapter: str, scope: dict) -> None:
    """The statements of a cell; one that stops does not stop the next one."""
    signal.alarm(PATIENCE)
    for statement in statements:
        try:
            exec(compile(ast.Module([statement], []), chapter, "exec"), scope)
        except TimeoutError:
            break
        except Exception:
            continue
    signal.alarm(0)


def _too_long(*_) -> None:
    raise TimeoutError


def run_all(names: list[str], workers: int) -> dict[tuple[str, str], list[Notes]]:
    """All chapters with all breaks, and what came of it; says how long it will take."""
    tasks = [(chapter, broken) for chapter in names for broken in (WHOLE, *BREAKS)]
    begun, found = time.monotonic(), {}
    with multiprocessing.get_context("fork").Pool(workers, maxtasksperchild=1) as pool:
        for done, (chapter, name, notes) in enumerate(pool.imap_unordered(run, tasks, chunksize=1), 1):
            found[chapter, name] = notes
            left = (time.monotonic() - begun) / done * (len(tasks) - done)
            said = f"{sum(not held for held in notes[0].values())} of {len(notes[0])} asserts fail"
            print(f"{done}/{len(tasks)}  {chapter}, {name}: {said}; {left / 60:.1f} min left", flush=True)
    return found


def report(chapter: str, found: dict[tuple[str, str], list[Notes]]) -> tuple[list[str], int, int]:
    """What is to be said of a chapter; how many of its asserts are never false, and how many there are."""
    texts = {name: text for _, checks in code_of(chapter) for name, text in checks.items()}
    whole, *alone = found[chapter, WHOLE.name]
    lines = [f"  WRONG UNBROKEN  cell {name}  {text}" for name, text in texts.items() if not whole.get(name)]
    silent = 0
    for name, text in texts.items():
        broken = [found[chapter, one.name][0] for one in BREAKS] + alone
        answers = [notes.get(name) for notes in broken]
        if False not in answers:
            silent += 1
            lines.append(f"  cell {name:7} asked {sum(a is not None for a in answers)} times  {text[:110]}")
    return [f"{chapter}: {silent} of {len(texts)} asserts are never false", *lines], silent, len(texts)


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutations", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("chapters", nargs="*", metavar="WORD", help="chapters whose names hold the word")
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ["MPLBACKEND"] = "Agg"  # for the workers
    mpl.use("Agg")
    names = chapters(options.chapters)
    found = run_all(names, options.workers)
    reports = [report(chapter, found) for chapter in names]
    print()
    for lines, _, _ in reports:
        print("\n".join(lines))
    print(f"In all {sum(r[1] for r in reports)} of {sum(r[2] for r in reports)} asserts are never false.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
