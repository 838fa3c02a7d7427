"""What a teacher should look at: marks that may not be what they seem, each with the reason."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from dataclasses import dataclass
from itertools import combinations

from nbformat import NotebookNode

from grader import masters
from grader.matching import squeezed
from grader.run import Result

LONG = 100  # letters from which on equal answers say something
ALIKE = 3  # equal long answers

# What an answer has no need of: a word, and what it can be used for.
MACHINERY = {
    "reaches into IPython": r"get_ipython|\w*_transformers?(?:_\w+)?|run_cell|IPython|ipykernel|^\s*[%!].*",
    "reaches into Python's own machinery": (
        r"__(?:code|globals|closure|builtins|dict|subclasses|import|mro|bases|loader|spec|main|func|wrapped|class)__"
        r"|sys|importlib|inspect|ctypes|gc|builtins|runpy|traceback|currentframe|f_back|f_globals|f_locals|tb_frame|gi_frame"
        r"|CodeType|FunctionType"
    ),
    "makes objects that say what they are equal to": r"__(?:eq|ne|bool|array|getattribute|instancecheck)__",
    "runs text as a program": r"exec|eval|compile",
    "gets at names as texts": r"getattr|setattr|delattr|globals|locals|vars",
    "reads files, the environment or the network": (
        r"os|open|pathlib|shutil|glob|environ|getenv|socket|urllib|requests|KINLIB_STUDENT|pickle|tempfile"
    ),
    "starts other programs": r"subprocess|multiprocessing|threading|signal|pty|fork|kill|Popen|atexit",
    "uses the checks' own code": r"kinlib_assignments|withheld|defined_beside|student_id|exercise\._\w+|unittest|mock",
}
HARMLESS = re.compile(r"^\s*%(?:matplotlib|timeit|time|config)\b.*$", re.MULTILINE)


@dataclass(frozen=True)
class Finding:
    """Something to look at: whose, where, what."""

    student: str
    assignment: str
    cell: str
    what: str


def findings(results: list[Result]) -> list[Finding]:
    """All that is to be looked at, by student."""
    found = [finding for result in results if result.submission.gradable for finding in of_one(result)]
    return sorted(found + alike(results), key=lambda one: (one.student, one.assignment))


def of_one(result: Result) -> list[Finding]:
    """What one submission shows by itself."""
    one = result.submission
    found = [(mark["cell"], "full mark, but the answer is untouched") for mark in result.marks if is_for_nothing(mark)]
    found += [("", said) for said in result.seen]
    try:
        found += of_text(one)
    except Exception as error:  # whatever a file can hold
        found.append(("", f"its text could not be looked through ({type(error).__name__})"))
    return [Finding(one.student, one.assignment, cell, what) for cell, what in found]


def is_for_nothing(mark: dict) -> bool:
    return mark["untouched"] and mark["points"] > 0 and mark["mark"] == mark["points"] and mark.get("marked") != "hand"


def of_text(one) -> list[tuple[str, str]]:
    """What the text of a notebook shows: another id, and words that an answer has no need of."""
    master, blank = masters.read(masters.source(one.assignment)), masters.read(masters.release(one.assignment))
    notebook = masters.assembled(master, blank, masters.read(one.path))
    stubs = masters.answers(blank)
    found = [("student", f"the id that is written is {name!r}") for name in other_ids(notebook, one.student)]
    for cell in notebook.cells:
        if cell.metadata.get("own") or (masters.is_answer(cell) and cell.cell_type == "code"):
            where = masters.name_of(cell) or "own cell"
            found += [(where, f"{what}: {line}") for what, line in reaches(cell.source, stubs.get(where, ""))]
    return found


def other_ids(notebook: NotebookNode, student: str) -> list[str]:
    """The ids written in the cell for the id that are not the graded one."""
    text = "\n".join(cell.source for cell in notebook.cells if masters.is_answer(cell))
    written = {name.strip() for _, name in re.findall(r"""^student\s*=\s*(["'])(.*?)\1""", text, re.MULTILINE)} - {""}
    return sorted(name for name in written if name.casefold() != student.strip().casefold())


def reaches(text: str, stub: str = "") -> list[tuple[str, str]]:
    """The lines of a program that reach for what an answer has no need of, and why they are listed.

    Examples
    --------
    >>> reaches("import sys\\nx = 1")
    [("reaches into Python's own machinery", 'import sys')]
    >>> reaches("kinlib.act = lambda *given: True")
    [('puts something in place of a function', 'kinlib.act = lambda *given: True')]
    >>> reaches("# import sys\\ndef cosine(angle):\\n    return 1")
    []
    """
    lines = [re.sub(r"(^|\s)#.*", "", line) for line in HARMLESS.sub("", text).splitlines()]
    found = []
    for what, words in MACHINERY.items():
        pattern = re.compile(
            rf"(?<![\w.])(?:{words})(?![\w])" if "os" in words.split("|") else rf"(?<!\w)(?:{words})(?!\w)"
        )
        found += [(what, line.strip()[:120]) for line in lines if pattern.search(line) and line.strip() not in stub][:3]
    return found + [("puts something in place of a function", line) for line in replacements(text)]


def replacements(text: str) -> list[str]:
    """The lines in which something is set on what the student has not made: a module, a class of kinlib."""
    try:
        tree = ast.parse(text)
    except SyntaxError:
        return []
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)} | {"self", "cls"}
    targets = [target for node in ast.walk(tree) if isinstance(node, ast.Assign) for target in node.targets]
    lines = text.splitlines()
    return [
        lines[target.lineno - 1].strip()[:120]
        for target in targets
        if isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name) and target.value.id not in own
    ]


def alike(results: list[Result]) -> list[Finding]:
    """Pairs of students with several long answers that are equal, and who has those of the solved notebook."""
    found = []
    by_assignment: dict[str, list[Result]] = defaultdict(list)
    for result in results:
        if result.submission.gradable and result.marks:
            by_assignment[result.submission.assignment].append(result)
    for assignment, group in by_assignment.items():
        texts = {result.submission.student: long_answers(result.marks) for result in group}
        solved = {essence(text) for text in masters.answers(masters.read(masters.source(assignment))).values()}
        for student, own in texts.items():
            if len(own & solved) >= ALIKE:
                what = f"{len(own & solved)} long answers are those of the solved notebook"
                found.append(Finding(student, assignment, "", what))
        for (first, one), (second, other) in combinations(sorted(texts.items()), 2):
            same = (one & other) - solved
            if len(same) >= ALIKE and 2 * len(same) >= min(len(one), len(other)):
                found.append(Finding(first, assignment, "", f"{len(same)} long answers are equal to those of {second}"))
    return found


def long_answers(marks: list[dict]) -> set[str]:
    """The answers that are long enough to be one's own, as far as they matter to Python."""
    found = {essence(mark["answer"]) for mark in marks if not mark["untouched"]}
    return {text for text in found if len(text) >= LONG}


def essence(text: str) -> str:
    """An answer without comments, blanks and docstrings; words are compared without their blanks."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return squeezed(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and ast.get_docstring(node) is not None:
            node.body = node.body[1:]
    return squeezed(ast.unparse(ast.fix_missing_locations(tree)))
