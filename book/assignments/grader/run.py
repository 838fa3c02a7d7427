"""Marks submissions, each in processes of its own; what the machine did wrong is tried again and never a mark."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import psutil

import kinlib
import kinlib_assignments
from grader import box, masters
from grader.collect import Submission, file_name
from grader.one import end

FAILED = "could not be run on this machine ({why}): no marks yet, give the command again"
GRACE = 60  # seconds for starting a kernel and ending it
PACKAGES = {module.__name__: Path(module.__file__).parent for module in (kinlib, kinlib_assignments)}


@dataclass(frozen=True)
class Limits:
    """What a submission may use: seconds for a cell, seconds in all, megabytes of memory, processes."""

    cell: int = 60
    all: int = 600
    megabytes: int = 4096
    processes: int = 40


@dataclass(frozen=True)
class Result:
    """A submission with its marks: one dictionary a graded cell, as `grader.one.carry_out` gives them.

    Attributes
    ----------
    remark : str
        What went wrong as a whole.
    failed : bool
        Whether the machine failed; then there are no marks, not even zeros.
    doubt : str
        Why it should be run once more with the machine to itself: it was slow, or its kernel died.
    seen : list of str
        What a teacher should look at.
    """

    submission: Submission
    marks: list[dict] = field(default_factory=list)
    remark: str = ""
    failed: bool = False
    doubt: str = ""
    seen: list[str] = field(default_factory=list)


KEPT = ("marks", "remark", "seen")


def graded(submission: Submission, limits: Limits, kept: Path, question: str | None = None) -> Result:
    """The marks of a submission; those of an earlier run if neither it nor the assignment has changed.

    Of a question that is named, the mark is made anew, and those of the others are left as they are.
    """
    if not submission.gradable:
        return Result(submission, none_of(submission.assignment), submission.remark)
    file, digest = kept_at(kept, submission), digest_of(submission, limits)
    old = earlier(file)
    if question in cells_of(submission.assignment) and old.get("file") == digest_of_file(submission):
        return asked_again(submission, limits, old, question)
    if old.get("digest") == digest:
        return Result(submission, **{name: old[name] for name in KEPT})
    return marked(submission, limits)


def asked_again(submission: Submission, limits: Limits, old: dict, question: str) -> Result:
    """An earlier result with the mark of one question made anew."""
    new = marked(submission, limits, question)
    if new.failed:
        return new
    found = {mark["cell"]: mark for mark in new.marks if mark["cell"] == question}
    return replace(new, marks=[found.get(mark["cell"], mark) for mark in old["marks"]], remark=old["remark"])


def keep(result: Result, limits: Limits, kept: Path) -> None:
    """Write a result down for the next time."""
    if not result.submission.gradable or result.failed:
        return
    file = kept_at(kept, result.submission)
    file.parent.mkdir(parents=True, exist_ok=True)
    names = {"digest": digest_of(result.submission, limits), "file": digest_of_file(result.submission)}
    text = json.dumps(names | {name: getattr(result, name) for name in KEPT}, indent=1)
    file.write_text(text, encoding="utf-8")


def kept_at(kept: Path, submission: Submission) -> Path:
    return kept / file_name(submission.student) / f"{submission.assignment}.json"


def earlier(file: Path) -> dict:
    """What an earlier run has written, if it can still be read."""
    try:
        old = json.loads(file.read_text(encoding="utf-8"))
        return old if are_marks(old["marks"]) and {"digest", "file", *KEPT} <= set(old) else {}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def are_marks(found) -> bool:
    """Whether something is a list of marks as `grader.one` makes them."""
    return isinstance(found, list) and all(
        isinstance(mark, dict)
        and {"cell", "points", "mark", "remark", "answer", "untouched"} <= set(mark)
        and isinstance(mark["points"], float | int)
        and (mark["mark"] is None or (isinstance(mark["mark"], float | int) and 0 <= mark["mark"] <= mark["points"]))
        for mark in found
    )


def digest_of(submission: Submission, limits: Limits) -> str:
    """A name for all that the marks depend on."""
    files = [
        submission.path,
        masters.source(submission.assignment),
        masters.release(submission.assignment),
        *programs(),
    ]
    versions = [sys.version, *(version(name) for name in ("numpy", "sympy", "ipykernel"))]
    parts = [*(file.read_bytes() for file in files), repr(asdict(limits)).encode(), repr(versions).encode()]
    return sha256(b"".join(sha256(part).digest() for part in [*parts, submission.student.encode()])).hexdigest()


def digest_of_file(submission: Submission) -> str:
    return sha256(submission.path.read_bytes()).hexdigest()


def programs() -> list[Path]:
    """The files of kinlib and of what the assignments share, as the kernels import them, and of the grader."""
    folders = [*PACKAGES.values(), Path(__file__).parent]
    return sorted(file for folder in folders for file in folder.rglob("*.py"))


def marked(submission: Submission, limits: Limits, question: str | None = None) -> Result:
    """The result of running a submission now."""
    with tempfile.TemporaryDirectory(prefix="grading-") as folder:
        place = Path(folder).resolve()
        order = order_for(submission, limits, place, boxed=bool(box.bubblewrap())) | {"question": question}
        try:
            answer = run(order, limits.all + GRACE)
        finally:
            end_leftovers(place)
        return result_of(submission, answer)


def order_for(submission: Submission, limits: Limits, place: Path, boxed: bool) -> dict:
    """What `grader.one` is told."""
    home, packages = place / "home", {str(place / "packages" / name): str(path) for name, path in PACKAGES.items()}
    home.mkdir()
    packages |= {str(home / ".matplotlib" / path.name): str(path) for path in fonts()}
    if not boxed:
        for seen, path in packages.items():
            Path(seen).parent.mkdir(exist_ok=True)
            shutil.copy(path, seen) if Path(path).is_file() else Path(seen).symlink_to(path)
    return {
        "assignment": submission.assignment,
        "submission": str(submission.path.resolve()),
        "student": submission.student,
        "place": str(place),
        "folder": str(home),
        "packages": packages,
        "surroundings": surroundings(place, submission.student),
        "boxed": boxed,
        "limits": asdict(limits),
    }


def fonts() -> list[Path]:
    """What matplotlib knows of the fonts here, so that not every kernel has to look for itself."""
    import matplotlib.font_manager

    name = f"fontlist-v{matplotlib.font_manager.FontManager.__version__}.json"
    return [path for path in [Path(matplotlib.get_cachedir(), name)] if path.is_file()]


def surroundings(place: Path, student: str) -> dict[str, str]:
    """The environment of a kernel: nothing of the teacher's but the way to Python."""
    return {
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.defpath]),
        "HOME": str(place / "home"),
        "TMPDIR": str(place / "home"),
        "LANG": "C.UTF-8",
        "PYTHONPATH": str(place / "packages"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "PIP_DRY_RUN": "1",  # an installation would change what the others are graded with
        "MPLBACKEND": "agg",
        "MPLCONFIGDIR": str(place / "home" / ".matplotlib"),
        "OPENBLAS_NUM_THREADS": "1",
        "KINLIB_STUDENT": student,
    }


def run(order: dict, seconds: int) -> dict:
    """Let a process of its own carry an order out; how it ended if it did not end well."""
    command = [sys.executable, "-m", "grader.one"]
    environment = {**order["surroundings"], "PYTHONPATH": str(masters.HERE)}
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, env=environment, cwd=order["folder"], text=True, **streams)
    try:
        out, said = process.communicate(json.dumps(order), timeout=seconds)
    except subprocess.TimeoutExpired:
        stop(process)
        return {"failure": f"it did not end within {seconds} s"}
    try:
        return json.loads(out)
    except ValueError:
        lines = said.strip().splitlines() or [f"the grading process ended with {process.returncode}"]
        return {"failure": lines[-1][:200]}


def stop(process: subprocess.Popen) -> None:
    """Kill a process with all that it started."""
    for member in box.family(process.pid):
        end(member)
    process.communicate()


def end_leftovers(place: Path) -> None:
    """Without a box, a process that a submission started and detached is known by its home folder."""
    if box.bubblewrap():
        return
    for process in psutil.process_iter():
        try:
            if process.environ().get("HOME") == str(place / "home"):
                process.kill()
        except psutil.Error:  # it is somebody else's, or has just ended
            continue


def result_of(submission: Submission, answer: dict) -> Result:
    """A result from what `grader.one` has written."""
    if answer.get("failure") or not are_marks(answer.get("marks")):
        why = answer.get("failure") or "its marks could not be read"
        return Result(submission, [], FAILED.format(why=why), failed=True)
    return Result(submission, answer["marks"], answer["remark"], doubt=answer["doubt"], seen=answer["seen"])


def cells_of(assignment: str) -> dict[str, float]:
    """The graded cells of an assignment, with their points."""
    cells = [masters.about(cell) for cell in masters.read(masters.source(assignment)).cells]
    return {cell["grade_id"]: float(cell["points"]) for cell in cells if cell.get("grade")}


def none_of(assignment: str | None) -> list[dict]:
    """No marks for any cell of an assignment."""
    if assignment is None:
        return []
    nothing = {"mark": 0.0, "remark": "", "answer": "", "untouched": True}
    return [{"cell": name, "points": points, **nothing} for name, points in cells_of(assignment).items()]


def graded_all(
    found: list[Submission],
    limits: Limits,
    kept: Path,
    jobs: int,
    say: Callable[[str], None],
    question: str | None = None,
) -> list[Result]:
    """The results of all submissions, in their order, some at a time; one line is said as each ends.

    Those that the machine failed on, that were slow on a busy machine or whose kernel died are run again at the end,
    one after the other.
    """
    results: dict[int, Result] = {}
    progress = Progress(len(found), say)
    with ThreadPoolExecutor(max(1, jobs)) as pool:
        futures = {pool.submit(graded, one, limits, kept, question): number for number, one in enumerate(found)}
        for future in as_completed(futures):
            number = futures[future]
            results[number] = outcome(future, found[number])
            if not is_to_be_repeated(results[number]):
                keep(results[number], limits, kept)
            progress.tell(results[number])
    again = [number for number in sorted(results) if is_to_be_repeated(results[number])]
    progress = Progress(len(again), say)
    for number in again:
        results[number] = believed(outcome(pool_of_one(graded, found[number], limits, kept, question), found[number]))
        keep(results[number], limits, kept)
        progress.tell(results[number])
    return [results[number] for number in sorted(results)]


def is_to_be_repeated(result: Result) -> bool:
    return result.failed or bool(result.doubt)


def believed(result: Result) -> Result:
    """A result of the second run: a kernel that died again has been ended by the notebook, a busy machine is none."""
    if result.doubt and result.doubt != "died":
        return Result(result.submission, [], FAILED.format(why=result.doubt), failed=True)
    return replace(result, doubt="")


def pool_of_one(function: Callable, *given) -> Future:
    """What a function gives or raises."""
    future: Future = Future()
    try:
        future.set_result(function(*given))
    except Exception as error:
        future.set_exception(error)
    return future


def outcome(future: Future, submission: Submission) -> Result:
    """A result, even of a submission that the grader itself fails on."""
    try:
        return future.result()
    except Exception as error:
        return Result(submission, [], FAILED.format(why=f"{type(error).__name__}: {error}"), failed=True)


class Progress:
    """Says what is done and how long the rest may take."""

    def __init__(self, count: int, say: Callable[[str], None]):
        self.count, self.say, self.done, self.began = count, say, 0, time.monotonic()

    def tell(self, result: Result) -> None:
        """One line on a result."""
        self.done += 1
        rest = (time.monotonic() - self.began) / self.done * (self.count - self.done)
        left = f", {in_minutes(rest)} left" if rest > 2 else ""
        self.say(f"[{self.done}/{self.count}{left}] {summary(result)}")


def in_minutes(seconds: float) -> str:
    """A time, as far as it can be foreseen.

    Examples
    --------
    >>> in_minutes(20), in_minutes(200)
    ('20 s', '3 min')
    """
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def summary(result: Result) -> str:
    """One line on a result."""
    who = f"{result.submission.student}  {result.submission.assignment or result.submission.path.name}"
    if result.failed or not result.marks or (result.remark and not result.submission.gradable):
        return f"{who}: {result.remark}"
    given = sum(mark["mark"] or 0 for mark in result.marks)
    points = sum(mark["points"] for mark in result.marks if mark["mark"] is not None)
    waiting = sum(mark["points"] for mark in result.marks if mark["mark"] is None)
    more = f", {waiting:g} to be marked by hand" if waiting else ""
    more += "; to be run again" if result.doubt else ""
    return f"{who}: {given:g} of {points:g}{more}" + (f"; {result.remark}" if result.remark else "")
