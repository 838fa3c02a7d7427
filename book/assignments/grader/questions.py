"""Pages for the teacher: how each question went, and all answers to it on one page."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from grader import report
from grader.run import Result, cells_of

KINDS = ("full", "part", "none", "waiting")


@dataclass
class Question:
    """A graded cell, with what each student got for it."""

    assignment: str
    cell: str
    points: float
    answers: list[tuple[str, dict]] = field(default_factory=list)

    @property
    def page(self) -> str:
        return f"questions/{self.assignment}-{report.file_name(self.cell)}.html"

    @property
    def mean(self) -> float | None:
        """The part of the points that was given, of those that are marked already."""
        marks = [mark["mark"] for _, mark in self.answers if mark["mark"] is not None]
        return sum(marks) / len(marks) / self.points if marks and self.points else None

    @property
    def shares(self) -> list[tuple[str, int, float, float]]:
        """How many have full, some and no marks, or wait: name, count, where its bar begins, and its length in %."""
        counts, start, found = Counter(kind(mark) for _, mark in self.answers), 0.0, []
        for name in KINDS:
            length = 100 * counts[name] / max(1, len(self.answers))
            found.append((name, counts[name], round(start, 2), round(length, 2)))
            start += length
        return found

    @property
    def remarks(self) -> list[tuple[str, int]]:
        """What was said most often."""
        return Counter(mark["remark"] for _, mark in self.answers if mark["remark"]).most_common(5)


def kind(mark: dict) -> str:
    """Whether a mark is full, a part, nothing, or waits."""
    if mark["mark"] is None:
        return "waiting"
    return "full" if mark["mark"] == mark["points"] else "part" if mark["mark"] else "none"


def questions(results: list[Result]) -> dict[str, list[Question]]:
    """The questions of each assignment that was handed in, the hardest first."""
    found: dict[str, dict[str, Question]] = defaultdict(dict)
    for result in results:
        one = result.submission
        if one.gradable and result.marks:
            for cell, points in cells_of(one.assignment).items():
                found[one.assignment].setdefault(cell, Question(one.assignment, cell, points))
            for mark in result.marks:
                found[one.assignment][mark["cell"]].answers.append((one.student, mark))
    return {name: sorted(found[name].values(), key=hardness) for name in sorted(found)}


def hardness(question: Question) -> float:
    return 2.0 if question.mean is None else question.mean


def write_pages(results: list[Result], found: list, said: list[str], folder: Path, box: str) -> None:
    """The teacher's page and one for each question.

    Parameters
    ----------
    results : list of Result
    found : list of Finding
        What to look at.
    said : list of str
        What there was to say about the run.
    folder : Path
    box : str
        Whether the notebooks ran in a box.
    """
    of_all = questions(results)
    problems = [result for result in results if result.remark]
    report.put(
        folder / "index.html", "teacher.html", assignments=of_all, found=found, said=said, problems=problems, box=box
    )
    for question in (question for group in of_all.values() for question in group):
        answers = sorted(
            question.answers, key=lambda pair: (pair[1]["mark"] is not None, pair[1]["mark"] or 0, pair[0])
        )
        report.put(folder / question.page, "question.html", question=question, answers=answers)
