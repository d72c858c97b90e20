"""Tables as CSV, text for TeX, and the cell of a share."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence

from lockprobe.foundation.formatting import NONE, share
from lockprobe.foundation.terminal_text import printable
from lockprobe.statistics.proportions import Proportion

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


def share_cell(found: Proportion) -> str:
    """A share with its 95 % interval, in per cent."""
    return share(found.value, found.low, found.high)


def as_csv(table: Sequence[Sequence[str]]) -> str:
    """The table as CSV, in which numbers are numbers: an interval has two columns of its own.

    No cell holds a sign of per cent, a plus, or a dash for what is not there. One that a spreadsheet would take for a
    formula is led by an apostrophe. Columns keep the names that programs know them by: p for the flip rate, and for a
    P value.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = [numeric for column in zip(*table, strict=True) for numeric in _as_numbers(column)]
    rows = [list(row) for row in zip(*columns, strict=True)]
    rows[0] = [_P.sub("p", name) for name in rows[0]]
    writer.writerows([_cell(cell) for cell in row] for row in rows)
    return out.getvalue()


_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e-?\d+)?"

_MEASURED = re.compile(rf"({_NUMBER})( %)?(?: \[({_NUMBER}), ({_NUMBER})\])?")
"""A number, per cent or not, with its interval or without."""


def _as_numbers(column: Sequence[str]) -> list[list[str]]:
    """A column of numbers without signs of per cent, followed by the ends of intervals; others as they are."""
    name, *cells = column
    plain = ["" if cell == NONE else cell.replace("\N{MINUS SIGN}", "-") for cell in cells]
    found = [_MEASURED.fullmatch(cell) for cell in plain]
    if not any(found) or not all(one or not cell for one, cell in zip(found, plain, strict=True)):
        return [list(column)]
    parts = [(one[1], one[3], one[4]) if one else ("", "", "") for one in found]
    value, low, high = ([(part or "").removeprefix("+") for part in end] for end in zip(*parts, strict=True))
    ends = [[f"{name}, low", *low], [f"{name}, high", *high]] if any(low) else []
    named = f"{name}, %" if any(one and one[2] for one in found) and "%" not in name else name
    return [[named, *value], *ends]


def _cell(cell: str) -> str:
    if cell == NONE:
        return ""
    number = _MEASURED.fullmatch(cell) is not None
    return "'" * (cell.startswith(_FORMULA) and not number) + printable(cell)


def tex_text(cell: str) -> str:
    """Text for LaTeX, in which no character is a command."""
    return "".join(_TEX.get(c, c) for c in printable(cell))
