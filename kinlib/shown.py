"""How values are shown: numbers and sums of units as text and in LaTeX, tables in HTML.

The letters i, j and k are quaternions, so the imaginary unit of the complex numbers is written as a root.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import accumulate
from typing import Any

import numpy as np

__all__: list[str] = []

ROOT = "√−1"
LINE = 48  # characters: a longer formula takes a second line


def as_text(x: Any) -> str:
    """A number as it is printed: floats to six digits, exact numbers whole.

    Examples
    --------
    >>> as_text(1 / 3), as_text(Fraction(1, 3)), as_text(np.float64(0.5)), as_text(1 / 3 + 2j)
    ('0.333333', '1/3', '0.5', '0.333333 + 2 √−1')
    """
    if isinstance(x, (float, np.floating)):
        return f"{float(x):.6g}"
    parts = _real_and_imaginary(x)
    if parts is None:
        return str(_told_from_i(x))
    real, imaginary = map(as_text, parts)
    times = {"1": ROOT, "-1": f"-{ROOT}"}.get(imaginary, f"{imaginary} {ROOT}")
    return as_sum([real, times] if parts[0] else [times])


def in_words(x: Any, least: float) -> str:
    """Six digits of a number; what is no larger than rounding has left is 0.

    Examples
    --------
    >>> in_words(1 / 3, 1e-9), in_words(-2e-17, 1e-9)
    ('0.333333', '0')
    """
    return f"{x if not abs(x) <= least else 0:.6g}"


def as_latex(x: Any) -> str:
    r"""A number in LaTeX: floats to six digits, exact numbers whole.

    Examples
    --------
    >>> print(as_latex(-2e-7), as_latex(Fraction(-1, 3)), as_latex(1 - 2j), sep=",  ")
    -2 \cdot 10^{-7},  - \frac{1}{3},  1 - 2 \sqrt{-1}
    """
    from sympy import latex, sympify

    if isinstance(x, (float, np.floating, complex, np.complexfloating)):
        short = as_text(x).replace(ROOT, r"\sqrt{-1}").replace("inf", r"\infty").replace("nan", r"\text{nan}")
        return re.sub(r"e([+-]\d+)", lambda power: rf" \cdot 10^{{{int(power[1])}}}", short)
    return str(latex(sympify(x) if isinstance(x, (int, Fraction)) else x, imaginary_unit=r"\sqrt{-1}"))


def as_sum(terms: Iterable[str]) -> str:
    """Terms with plus and minus between them; 0 if there are none.

    Examples
    --------
    >>> as_sum(["1", "-2 i"]), as_sum([])
    ('1 - 2 i', '0')
    """
    return " + ".join(terms).replace("+ -", "- ") or "0"


def in_lines(pieces: Sequence[str], width: int) -> str:
    r"""The pieces of a formula, which are so many characters in all, on one line or below each other.

    Examples
    --------
    >>> in_lines(["1", "+ 2"], 3)
    '1 + 2'
    """
    if width <= LINE or len(pieces) < 2:
        return " ".join(pieces)
    return rf"\begin{{aligned}}& {(chr(92) * 2 + ' & ').join(pieces)}\end{{aligned}}"


def times_unit(number: str, unit: str) -> str:
    """A number, in words of either kind, times a unit: sums in brackets, no factor 1.

    Examples
    --------
    >>> times_unit("-1", "i"), times_unit("1 + a", "i"), times_unit("2", "")
    ('-i', '(1 + a) i', '2')
    """
    if not unit:
        return number
    if number in ("1", "-1"):
        return number.replace("1", unit)
    return f"({number}) {unit}" if _is_sum(number) else f"{number} {unit}"


def _is_sum(text: str) -> bool:
    """Whether there is a plus or a minus, with spaces, outside all brackets and behind the first term."""
    depths = list(accumulate((c in "({") - (c in ")}") for c in text))
    return any(text[n - 1 : n + 2] in (" + ", " - ") and depths[n] == 0 for n in range(2, len(text)))


def _real_and_imaginary(x: Any) -> tuple[Any, Any] | None:
    """Both parts of a number that is not real; None for all that has no such parts, or none that are rational."""
    if isinstance(x, (complex, np.complexfloating)):
        return float(x.real), float(x.imag)
    if getattr(x, "is_number", False) and not x.is_real:
        real, imaginary = x.as_real_imag()
        return (real, imaginary) if imaginary and real.is_Rational and imaginary.is_Rational else None
    return None


def _told_from_i(x: Any) -> Any:
    """An expression of SymPy with a root in the place of its letter I."""
    if not hasattr(x, "xreplace"):
        return x
    from sympy import I, Symbol

    return x.xreplace({I: Symbol(ROOT)})


# ---- tables ------------------------------------------------------------------------------------------


def html_table(caption: str, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in HTML."""
    lines = [_html_row("th", head), *(_html_row("td", row) for row in rows)]
    return f"<table><caption>{caption}</caption><thead>{lines[0]}</thead><tbody>{''.join(lines[1:])}</tbody></table>"


def _html_row(kind: str, cells: Sequence[Any]) -> str:
    return "<tr>" + "".join(f"<{kind}>{cell}</{kind}>" for cell in cells) + "</tr>"
