"""Tables as text for other programs: CSV with all digits, Markdown and LaTeX to be read."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias

__all__ = ["TableForm", "as_table"]

TableForm: TypeAlias = Literal["csv", "markdown", "latex"]
"""What a table may be written as."""


def as_table(form: TableForm, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table as text.

    Parameters
    ----------
    form : {"csv", "markdown", "latex"}
    head : sequence of str
        The names of the columns.
    rows : sequence of sequences
        Numbers or words; floats are written with all their digits.

    Examples
    --------
    >>> print(as_table("markdown", ("n", "a"), [(1, 0.1)]))
    | n | a |
    | --: | --: |
    | 1 | 0.1 |
    <BLANKLINE>
    """
    writers: dict[str, Callable[..., str]] = {"csv": _csv, "markdown": _markdown, "latex": _latex}
    if form not in writers:
        raise ValueError(f"expected one of {', '.join(writers)}, got {form!r}")
    return writers[form](head, [[repr(float(x)) if isinstance(x, float) else str(x) for x in row] for row in rows])


def _csv(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([head, *rows])
    return text.getvalue()


def _markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["--:"] * len(head), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def _latex(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    body = "".join(" & ".join(row).replace("°", r"$^\circ$") + " \\\\\n" for row in rows)
    columns = "r" * len(head)
    return f"\\begin{{tabular}}{{{columns}}}\n{' & '.join(head)} \\\\\n\\hline\n{body}\\end{{tabular}}\n"
