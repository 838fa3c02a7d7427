"""Marks submissions, each in a process of its own with limits of time and memory."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path

import psutil

import kinlib
import kinlib_assignments
from grader import masters
from grader.collect import Submission

STOPPED = "stopped after {seconds} s in all"
FAILED = "could not be graded: {why}"


@dataclass(frozen=True)
class Limits:
    """What a submission may use: seconds for a cell, seconds in all, megabytes of memory."""

    cell: int = 60
    all: int = 600
    megabytes: int = 4096


@dataclass(frozen=True)
class Result:
    """A submission with its marks: one dictionary a graded cell, as `grader.one.marks` gives them."""

    submission: Submission
    marks: list[dict] = field(default_factory=list)
    remark: str = ""


def graded(submission: Submission, limits: Limits, kept: Path) -> Result:
    """The marks of a submission; those of an earlier run if neither it nor the assignment has changed."""
    if not submission.gradable:
        return Result(submission, none_of(submission.assignment), submission.remark)
    file, digest = kept / submission.student / f"{submission.assignment}.json", digest_of(submission, limits)
    if file.exists() and (old := json.loads(file.read_text(encoding="utf-8")))["digest"] == digest:
        return Result(submission, old["marks"], old["remark"])
    marks, remark = marked(submission, limits)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps({"digest": digest, "marks": marks, "remark": remark}, indent=1), encoding="utf-8")
    return Result(submission, marks, remark)


def digest_of(submission: Submission, limits: Limits) -> str:
    """A name for all that the marks depend on."""
    files = [
        submission.path,
        masters.source(submission.assignment),
        masters.release(submission.assignment),
        *programs(),
    ]
    parts = [*(file.read_bytes() for file in files), repr(asdict(limits)).encode()]
    return sha256(b"".join(sha256(part).digest() for part in parts)).hexdigest()


def programs() -> list[Path]:
    """The files of kinlib, of what the assignments share, and of the grader."""
    folders = [Path(file).parent for file in (kinlib.__file__, kinlib_assignments.__file__, __file__)]
    return sorted(file for folder in folders for file in folder.rglob("*.py"))


def marked(submission: Submission, limits: Limits) -> tuple[list[dict], str]:
    """The marks of a submission, and what went wrong as a whole."""
    with tempfile.TemporaryDirectory(prefix="grading-") as place:
        home, result = Path(place, "home"), Path(place, "marks.json")
        home.mkdir()
        order = {
            "assignment": submission.assignment,
            "submission": str(submission.path.resolve()),
            "folder": str(home),
            "result": str(result),
            "seconds": limits.cell,
            "megabytes": limits.megabytes,
        }
        said = run(order, surroundings(home, submission.student), limits.all)
        if result.exists():
            return json.loads(result.read_text(encoding="utf-8")), ""
        return none_of(submission.assignment), said


def surroundings(home: Path, student: str) -> dict[str, str]:
    """The environment of a grading process: nothing of the teacher's but the way to Python."""
    return {
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.defpath]),
        "HOME": str(home),
        "TMPDIR": str(home),
        "LANG": "C.UTF-8",
        "PYTHONPATH": str(masters.HERE),
        "PYTHONDONTWRITEBYTECODE": "1",
        "MPLBACKEND": "agg",
        "MPLCONFIGDIR": str(Path(tempfile.gettempdir(), "kinlib-matplotlib")),
        "OPENBLAS_NUM_THREADS": "1",
        "KINLIB_STUDENT": student,
    }


def run(order: dict, environment: dict[str, str], seconds: int) -> str:
    """Run the grading process to its end or its limit, and say how it ended if it did not end well."""
    command = [sys.executable, "-m", "grader.one"]
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, env=environment, cwd=order["folder"], text=True, **streams)
    try:
        _, said = process.communicate(json.dumps(order), timeout=seconds)
    except subprocess.TimeoutExpired:
        stop(process)
        return STOPPED.format(seconds=seconds)
    lines = said.strip().splitlines() or [f"the grading process ended with {process.returncode}"]
    return FAILED.format(why=lines[-1][:200])


def stop(process: subprocess.Popen) -> None:
    """Kill a process with all that it started."""
    family = [*psutil.Process(process.pid).children(recursive=True), psutil.Process(process.pid)]
    for member in family:
        with contextlib.suppress(psutil.NoSuchProcess):  # it has just ended
            member.kill()
    process.communicate()


def none_of(assignment: str | None) -> list[dict]:
    """No marks for any cell of an assignment."""
    if assignment is None:
        return []
    cells = [masters.about(cell) for cell in masters.read(masters.source(assignment)).cells]
    graded = [(cell["grade_id"], float(cell["points"])) for cell in cells if cell.get("grade")]
    return [{"cell": name, "points": points, "mark": 0.0, "remark": "", "answer": ""} for name, points in graded]


def graded_all(
    found: list[Submission], limits: Limits, kept: Path, jobs: int, say: Callable[[str], None]
) -> list[Result]:
    """The results of all submissions, in their order, some at a time; one line is said as each ends."""
    with ThreadPoolExecutor(jobs) as pool:
        futures = {pool.submit(graded, one, limits, kept): number for number, one in enumerate(found)}
        results: dict[int, Result] = {}
        for done, future in enumerate(as_completed(futures), 1):
            number = futures[future]
            results[number] = outcome(future, found[number])
            say(f"[{done}/{len(found)}] {summary(results[number])}")
    return [results[number] for number in sorted(results)]


def outcome(future, submission: Submission) -> Result:
    """A result, even of a submission that the grader itself fails on."""
    try:
        return future.result()
    except Exception as error:
        return Result(submission, none_of(submission.assignment), FAILED.format(why=f"{type(error).__name__}: {error}"))


def summary(result: Result) -> str:
    """One line on a result."""
    who = f"{result.submission.student}  {result.submission.assignment or result.submission.path.name}"
    if result.remark:
        return f"{who}: {result.remark}"
    given = sum(mark["mark"] or 0 for mark in result.marks)
    points = sum(mark["points"] for mark in result.marks if mark["mark"] is not None)
    waiting = sum(mark["points"] for mark in result.marks if mark["mark"] is None)
    return f"{who}: {given:g} of {points:g}" + (f", {waiting:g} to be marked by hand" if waiting else "")
