"""Tables as CSV and as TeX, and the cell of a share."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence

from lockprobe.foundation.formatting import share
from lockprobe.foundation.terminal_text import printable
from lockprobe.statistics.clustered import ClusteredProportion
from lockprobe.statistics.proportions import Proportion

__all__ = ["DETECTED", "EVERY", "TextTable", "as_csv", "as_tex", "share_cell"]

DETECTED = {True: "detected", False: "not detected"}
"""What a table concludes from a test; the interval has to exclude 0 as well."""

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


def share_cell(found: Proportion | ClusteredProportion) -> str:
    """A share with its 95 % interval, in per cent."""
    return share(found.value, found.low, found.high)


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
