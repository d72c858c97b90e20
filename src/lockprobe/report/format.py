"""How numbers and cells are written: for the page, as CSV and as TeX."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence

from lockprobe.terminal_text import printable

__all__ = ["EVERY", "NONE", "TextTable", "as_csv", "as_tex", "minus", "p_cell", "percent", "points_cell", "share_cell"]

NONE = "\N{EN DASH}"
"""A cell without a value."""

EVERY = "every flip rate"
"""The flip rate of an agent that plays the same at all of them."""

TextTable = list[list[str]]
"""Rows of cells, the first row with the names of the columns."""

_TEX = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "±": r"$\pm$",
    "\N{EN DASH}": "--",
    "\N{MINUS SIGN}": "$-$",
    "≈": r"$\approx$",
}

_P = re.compile(r"flip rate|^P$")

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def percent(value: float | None, digits: int = 1) -> str:
    """A share in per cent, or a dash where there is none."""
    return NONE if value is None or math.isnan(value) else f"{100 * value:.{digits}f} %"


def p_cell(value: float | None) -> str:
    """A p-value, or a dash where there is none."""
    return NONE if value is None or math.isnan(value) else f"{value:.2g}"


def share_cell(value: float | None, low: float | None, high: float | None) -> str:
    """A share in per cent with its interval."""
    if value is None or low is None or high is None or math.isnan(value):
        return NONE
    return f"{percent(value, 0)} [{100 * low:.0f}, {100 * high:.0f}]"


def points_cell(value: float | None, low: float | None, high: float | None) -> str:
    """A difference of shares in percentage points, with its interval where there is one."""
    if value is None or math.isnan(value):
        return NONE
    interval = "" if low is None or high is None else f" [{100 * low:+.0f}, {100 * high:+.0f}]"
    return minus(f"{100 * value:+.0f}{interval}")


def minus(text: str) -> str:
    """The text with minus signs for hyphens, but for those between letters, and none before a nought."""
    text = re.sub(r"-(?=0(?:\.0+)?(?![\d.]))", "", text)
    return re.sub(r"(?<![A-Za-z])-|-(?![A-Za-z])", "\N{MINUS SIGN}", text)


def as_csv(table: Sequence[Sequence[str]]) -> str:
    """The table as CSV. A cell that a spreadsheet would take for a formula is led by an apostrophe.

    Columns keep the names that programs know them by: p for the flip rate, and for a P value.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    table = [[_P.sub("p", name) for name in table[0]], *table[1:]]
    writer.writerows(["'" * cell.startswith(_FORMULA) + printable(cell) for cell in row] for row in table)
    return out.getvalue()


def as_tex(table: Sequence[Sequence[str]]) -> str:
    """The table for LaTeX with booktabs. Rows begin with ``{}``, lest one be read as an argument of the rule above."""
    names = [r"\emph{P}" if name == "P" else _tex(name) for name in table[0]]
    head, *rows = ["{}" + " & ".join(row) + r" \\" for row in (names, *(map(_tex, row) for row in table[1:]))]
    lines = [
        rf"\begin{{tabular}}{{{'l' * len(table[0])}}}",
        r"\toprule",
        head,
        r"\midrule",
        *rows,
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def _tex(cell: str) -> str:
    return "".join(_TEX.get(c, c) for c in printable(cell))
