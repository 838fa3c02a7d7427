"""Marks one notebook; runs in a process of its own: ``python -m grader.one`` reads an order in JSON and writes marks.

The submission's kernel is another process, in a box if there is one.  What it can reach is its own outputs: marks are
made here, from these, and go out by a way that no other process has.
"""

from __future__ import annotations

import json
import math
import os
import resource
import secrets
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path

import nbformat
import psutil
from nbclient.exceptions import CellExecutionComplete, CellTimeoutError, DeadKernelError
from nbformat import NotebookNode
from nbgrader.preprocessors import Execute
from nbgrader.utils import determine_grade, is_grade
from nbgrader.utils import is_solution as is_answer

from grader import box, masters, remarks

ROOM = 256  # megabytes of files
LETTERS = 1_000_000  # of what one cell prints
PATIENCE = 30  # seconds for what a cell printed to come after its answer
PATIENCE_WITH_THE_STUCK = 8  # and the same after a cell was interrupted
INSIDE = Path(__file__).with_name("inside.py")


class OutOfTimeError(Exception):
    """The time for the whole notebook is used up."""


class Runner(Execute):
    """Runs the cells of a notebook in a kernel of `grader.box`, and notes what ended it before its end."""

    def __init__(self, kernel: type, limits: dict):
        super().__init__(kernel_manager_class=kernel, startup_timeout=120)
        self.limits, self.ready, self.ended, self.slow, self.late = limits, False, "", [], False
        self.spent, self.proof, self.complete = 0, "", False
        self.deadline = time.monotonic() + limits["all"]

    def preprocess_cell(self, cell, resources, index):
        """Run a cell within what is left of the time."""
        left = self.deadline - time.monotonic()
        if left <= 0:
            raise OutOfTimeError
        self.timeout, self.spent = math.ceil(min(self.limits["cell"], left)), 0
        self.proof, self.complete = cell.metadata.get("proof", ""), False
        self.iopub_timeout, self.raise_on_iopub_timeout = PATIENCE, False
        before, began = waited(self.pid), time.monotonic()
        try:
            done = super().preprocess_cell(cell, resources, index)
        finally:
            if time.monotonic() - began >= self.timeout:
                self.slow.append(waited(self.pid) - before > 0.2 * self.timeout)
        self.ready = True
        self.late = self.late or (cell.cell_type == "code" and not self.complete and not self.raise_on_iopub_timeout)
        return done

    async def _async_handle_timeout(self, timeout, cell=None):
        """Interrupt a cell; if even that is not answered, the kernel is stuck."""
        self.iopub_timeout, self.raise_on_iopub_timeout = PATIENCE_WITH_THE_STUCK, True
        return await super()._async_handle_timeout(timeout, cell)

    def process_message(self, msg, cell, cell_index):
        """Take a message in; the last one says that the cell is complete."""
        try:
            return super().process_message(msg, cell, cell_index)
        except CellExecutionComplete:
            self.complete = True
            raise

    def output(self, outs, msg, display_id, cell_index):
        """Take an output in, until the cell has said enough; the proof of a check is always heard."""
        self.spent += len(json.dumps(msg["content"], default=str))
        if self.spent >= LETTERS:
            if not (self.proof and self.proof in msg["content"].get("text", "")):
                return None
            msg = {**msg, "content": {**msg["content"], "text": f"\n{self.proof}\n"}}
        return super().output(outs, msg, display_id, cell_index)

    @property
    def pid(self) -> int | None:
        process = getattr(getattr(self.km, "provisioner", None), "process", None)
        return process and process.pid


def waited(pid: int | None) -> float:
    """The seconds for which a kernel's processes were ready to work but had no processor."""
    nanoseconds = 0
    for process in box.family(pid):
        for thread in Path(f"/proc/{process.pid}/task").glob("*/schedstat"):
            try:
                nanoseconds += int(thread.read_text().split()[1])
            except OSError:  # it has just ended
                continue
    return nanoseconds / 1e9


class Watch(threading.Thread):
    """Ends a kernel that uses more memory, processes or room for files than there is."""

    def __init__(self, runner: Runner, folder: Path):
        super().__init__(daemon=True)
        self.runner, self.folder, self.done, self.most = runner, folder, threading.Event(), 0
        self.last = 0

    def run(self) -> None:
        while not self.done.wait(0.25):
            self.look()

    def look(self) -> None:
        members = box.family(self.runner.pid)
        self.most = max(self.most, min(self.last, len(members)))  # what is gone at once is Python's own
        self.last = len(members)
        too_much = self.too_much(members)
        if too_much:
            self.runner.ended = self.runner.ended or too_much
            for member in members:
                end(member)

    def too_much(self, members: list[psutil.Process]) -> str:
        if sum(map(memory, members)) > self.runner.limits["megabytes"] * 2**20:
            return remarks.TOO_LARGE
        if len(members) > self.runner.limits["processes"]:
            return remarks.TOO_MANY
        size = sum(path.lstat().st_size for path in self.folder.rglob("*") if path.is_file())
        return remarks.TOO_FULL if size > ROOM * 2**20 else ""


def memory(process: psutil.Process) -> int:
    try:
        return process.memory_info().rss
    except psutil.Error:
        return 0


def end(process: psutil.Process) -> None:
    try:
        process.kill()
    except psutil.Error:  # it has just ended
        return


def carry_out(order: dict) -> dict:
    """Mark a submission as ordered.

    The answer holds ``marks`` (for each graded cell: name, points, mark (None where a person decides), remark, answer,
    and whether it is untouched), ``remark`` on the notebook as a whole, ``failure`` if the machine failed and not the
    notebook, ``doubt`` if it should be run again with the machine to itself, and ``seen``: what a teacher should see.
    """
    master, blank = (
        masters.read(masters.source(order["assignment"])),
        masters.read(masters.release(order["assignment"])),
    )
    notebook = masters.assembled(master, blank, masters.read(Path(order["submission"])))
    until(notebook, order.get("question"))
    notebook.cells = with_questions(with_proofs(notebook.cells))
    result = {"marks": [], "remark": "", "failure": "", "doubt": "", "seen": []}
    result |= executed(notebook, order)
    if not result["failure"]:
        result["seen"] += unlike(notebook, order["student"])
        result["marks"] = list(marks(notebook, masters.answers(blank), order["limits"]["cell"], result["because"]))
    return result


def until(notebook: NotebookNode, question: str | None) -> None:
    """Leave out what comes after a question."""
    numbers = [n for n, cell in enumerate(notebook.cells) if question and masters.name_of(cell) == question]
    if numbers:
        del notebook.cells[numbers[0] + 1 :]


def with_proofs(cells: list[NotebookNode]) -> list[NotebookNode]:
    """The cells; each check prints at its end what nobody knows before, to prove that it was run."""
    for cell in cells:
        if cell.cell_type == "code" and is_grade(cell) and not is_answer(cell):
            cell.metadata["proof"] = secrets.token_hex(8)
            cell.source += f"\n__import__('builtins').print({cell.metadata['proof']!r})"
    return cells


def with_questions(cells: list[NotebookNode]) -> list[NotebookNode]:
    """The cells, with one that asks before the first, after the last, and where a student's cells come to a check."""
    found, asked = [asking()], True
    for cell in cells:
        if cell.cell_type == "code":
            if is_grade(cell) and not asked:
                found.append(asking())
            asked = is_grade(cell)
        found.append(cell)
    return [*found, asking()]


def asking() -> NotebookNode:
    """A cell that prints what `grader.inside` reports, and leaves nothing behind."""
    token = secrets.token_hex(8)
    text = INSIDE.read_text(encoding="utf-8") + f"\nprint(report({token!r}))\n"
    return nbformat.v4.new_code_cell(f"exec({text!r}, {{}})", metadata={"asking": token})


def executed(notebook: NotebookNode, order: dict) -> dict:
    """Run all cells in place; what raises is recorded in its cell, what never ends is stopped."""
    limits, home = order["limits"], Path(order["folder"])
    sockets = Path(tempfile.mkdtemp(prefix="kernel-", dir=box.SOCKETS if order["boxed"] else order["place"]))
    seen = {Path(path): Path(real) for path, real in order["packages"].items()}
    before = box.around(home, seen, sockets, ROOM) if order["boxed"] else []
    runner = Runner(box.kernel_class(before, order["surroundings"], sockets), limits)
    watch = Watch(runner, sockets if order["boxed"] else home)
    watch.start()
    try:
        ended = run(runner, notebook, home)
    finally:
        watch.done.set()
        said = sockets.with_suffix(".said")
        complaint = said.read_text(errors="replace").strip()[-300:] if said.exists() else ""
        said.unlink(missing_ok=True)
        shutil.rmtree(sockets, ignore_errors=True)
    if not runner.ready:
        return {"failure": remarks.cut(f"{ended}; {complaint}" if complaint else ended)}
    usual = 3 if order["boxed"] else 1
    more = [remarks.STARTED.format(count=watch.most - usual)] if watch.most > usual else []
    # A kernel that was lost without having used up its time or anything else may have been lost by the machine.
    lost = ended not in ("", "stopped") and not runner.ended and not (ended == "stuck" and runner.slow)
    doubt = remarks.LOADED if any(runner.slow) or runner.late else "died" if lost else ""
    remark = remarks.STOPPED.format(seconds=limits["all"]) if ended == "stopped" else ""
    return {"doubt": doubt, "remark": remark, "seen": more, "because": runner.ended}


def run(runner: Runner, notebook: NotebookNode, folder: Path) -> str:
    """Run a notebook, and say what ended it before its end."""
    try:
        runner.preprocess(notebook, {"metadata": {"path": str(folder)}})
    except OutOfTimeError:
        return "stopped"
    except DeadKernelError:
        return "died"
    except CellTimeoutError:
        return "stuck"
    except Exception as error:  # whatever can happen to a kernel that starts
        if runner.ready and not isinstance(error, RuntimeError | OSError):
            raise
        return f"{type(error).__name__}: {error}"
    return "stopped" if time.monotonic() > runner.deadline else ""


def unlike(notebook: NotebookNode, student: str) -> list[str]:
    """What the kernel's answers have to say: the first one, and those after the student's cells."""
    answers = [answer(cell) for cell in notebook.cells if cell.metadata.get("asking") and cell.execution_count]
    if not answers or None in answers:
        return [remarks.SILENT]
    first, *later = answers
    found = [remarks.CHANGED.format(what=name) for one in later for name in changed(first, one)]
    others = [one.get("student") for one in later if one.get("student") != student.strip().casefold()]
    found += [remarks.WHOSE.format(student=name) for name in others]
    found += [remarks.ACCEPTS for one in later if one.get("refuses") is not True]
    return list(dict.fromkeys(found))


def answer(cell: NotebookNode) -> dict | None:
    """What a kernel answered."""
    try:
        found = json.loads(printed(cell).strip().splitlines()[-1])
    except (ValueError, IndexError):
        return None
    return found if isinstance(found, dict) and found.get("token") == cell.metadata["asking"] else None


def printed(cell: NotebookNode) -> str:
    return "".join(output.get("text", "") for output in cell.outputs if output.get("name") == "stdout")


def changed(first: dict, last: dict) -> list[str]:
    """The parts of the machinery that are not as they were."""
    parts = first.get("parts", {}), last.get("parts", {})
    if not all(isinstance(one, dict) for one in parts):
        return ["the answer about it"]
    return [name for name, digest in parts[0].items() if parts[1].get(name) != digest]


def replaced(first: dict, last: dict) -> str:
    """What the checks need and is not as it was, by what the kernel answered before them; nothing if all is well."""
    if last.get("refuses") is False:
        return "the checks"
    return next((name for name in changed(first, last) if name.startswith("kinlib")), "") if first and last else ""


def marks(notebook: NotebookNode, empty: dict[str, str], seconds: int, because: str):
    """The mark of each graded cell that was run, by nbgrader's rule, but a warning costs nothing."""
    answers, asked = [], []
    for number, cell in enumerate(notebook.cells):
        if cell.metadata.get("asking"):
            asked.append(answer(cell) or {})
        if is_answer(cell):
            answers = [cell]
        if is_grade(cell):
            blank = bool(answers) and answers[0].source.strip() == empty[masters.name_of(answers[0])].strip()
            found = judged(cell, blank, notebook.cells[:number], seconds, because)
            if found["mark"] and (what := replaced(asked[0], asked[-1])):
                found |= {"mark": 0.0, "remark": remarks.REPLACED.format(what=what)}
            yield {**found, "answer": answers[0].source if answers else "", "untouched": blank}


def judged(cell: NotebookNode, blank: bool, before: list[NotebookNode], seconds: int, because: str) -> dict:
    result = {
        "cell": masters.name_of(cell),
        "points": float(masters.about(cell)["points"]),
        "mark": 0.0,
        "remark": "",
    }
    if is_answer(cell):
        return {**result, "remark": remarks.NOTHING} if blank else {**result, "mark": None}
    if cell.execution_count is None:
        return {**result, "remark": f"{remarks.NOT_RUN} ({because})" if because else remarks.NOT_RUN}
    cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
    if not remarks.errors_of(cell) and cell.metadata["proof"] not in printed(cell).splitlines():
        return {**result, "remark": remarks.NOT_PROVED}
    return {**result, "mark": determine_grade(cell)[0], "remark": remarks.complaint(cell, before, seconds)}


def main() -> None:
    order = json.load(sys.stdin)
    way_out = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")  # no other process inherits it
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    limit = order["limits"]["megabytes"] * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM * 2**20, ROOM * 2**20))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with way_out:
        json.dump(carry_out(order), way_out)


if __name__ == "__main__":
    main()
