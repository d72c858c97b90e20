"""Cells of tables as text and as CSV, and text for TeX."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence

from lockprobe.foundation.formatting import MOST_NAMED, NONE, bracketed, end_of, p_cell, percent
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.rows import Estimate

Entry = str | Estimate | None
"""A cell of a table: a text, or a number, or None where there is none."""

DETECTED = "detected"

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

_P = re.compile(r"flip rate|^P(, corrected for .*)?$")

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


class Finer(Estimate):
    """A difference that has one decimal more than the numbers beside it."""


def beside(row: Estimate | None, first: Estimate | None, second: Estimate | None) -> Estimate | None:
    """A difference as it is written beside the two numbers that it is of: so long as these are, or one decimal longer.

    It is longer where it would not be the difference of what is written.

    >>> shares = Estimate(quantity="success", value=0.2667), Estimate(quantity="success", value=0.5333)
    >>> entry_text(beside(Estimate(quantity="change", unit="points", value=0.2667), *shares))
    '+26.7'
    """
    change, less, more = (float(_number(one, "value") or "nan") if one else math.nan for one in (row, first, second))
    return Finer.model_construct(**dict(row)) if row and abs(more - less - change) > _EQUAL else row


_EQUAL = 1e-9
"""Below it, what is written is equal."""


def _form(row: Estimate) -> tuple[str, float]:
    """How a number is written, and by what it is multiplied before."""
    finer = isinstance(row, Finer)
    if row.unit in ("share", "points"):
        return f"{{:{'+' * (row.unit == 'points')}.{int(finer)}f}}", 100
    if row.unit == "steps":
        return f"{{:{'+' * (not row.quantity.startswith('mean'))}.{1 + finer}f}}", 1
    return "{:.2f}" if row.unit else "{:.3g}", 1


def entry_text(entry: Entry) -> str:
    """A cell as text: a number with its interval in brackets where it has one, a share in per cent.

    >>> entry_text(Estimate(quantity="success", value=0.5, low=0.4, high=0.6)), entry_text("all")
    ('50 % [40, 60]', 'all')
    """
    if entry is None or isinstance(entry, str):
        return NONE if entry is None else entry
    if entry.quantity == "steps_to_solve":
        first, late = (NONE if step is None else f"{step:.0f}" for step in (entry.value, entry.high))
        return first if entry.low is None else f"{first} [{entry.low:.0f}, {late}]"
    if entry.unit == "share":
        said = bracketed(entry.value, entry.low, entry.high, "{:.0f}")
        return percent(entry.value) if entry.low is None else said.replace(" [", " % [")
    return bracketed(entry.value, entry.low, entry.high, *_form(entry))


def each_or_span(each: Sequence[str], span: str, between: str = ", ") -> str:
    """What is said of each agent; of more than a sentence can name, from where to where it is."""
    return between.join(each) if len(each) <= MOST_NAMED else f"{span} for the {len(each)} agents of the answer"


def texts(table: Sequence[Sequence[Entry]]) -> list[list[str]]:
    """The rows of a table as text."""
    return [[entry_text(entry) for entry in row] for row in table]


def tested(row: Estimate | None) -> list[Entry]:
    """Cells of a difference: it, its P value, and what is concluded."""
    return [row, p_cell(row.p_value if row else None), conclusion_of(row) if row else None]


def p_head(rows: Iterable[Estimate]) -> str:
    """The head of a column of P values, which says for how many comparisons they are corrected.

    >>> p_head([Estimate(quantity="success_difference", p_value=0.1, corrected_for=of) for of in (3, 8)])
    'P, corrected for 3 to 8'
    """
    sizes = {row.corrected_for for row in rows if row.p_value is not None} or {1}
    least, most = min(sizes), max(sizes)
    return "P" if most == 1 else f"P, corrected for {f'{least} to ' * (least < most)}{most}"


def conclusion_of(row: Estimate, *, at: float = 0.05) -> str:
    """What a table concludes from a test at some level and the interval, which has to exclude 0 as well."""
    return DETECTED if row.detected and row.p_value is not None and row.p_value < at else f"not {DETECTED}"


def alone(row: Estimate | None) -> Estimate | None:
    """A number without its interval."""
    return row and row.model_copy(update={"low": None, "high": None})


def count_of(row: Estimate | None) -> str:
    """How many of how many."""
    return "0 of 0" if row is None else f"{row.count} of {row.n}"


def as_csv(table: Sequence[Sequence[Entry]]) -> str:
    """The table as CSV, in which numbers are numbers: an interval has two columns of its own.

    Numbers have no sign of per cent and no plus, and what is not there is empty. A text that a spreadsheet would take
    for a formula is led by an apostrophe. Columns keep the names that programs know them by: p for the flip rate, and
    for a P value.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = [numeric for column in zip(*table, strict=True) for numeric in _as_numbers(column)]
    writer.writerows(zip(*columns, strict=True))
    return out.getvalue()


def _as_numbers(column: Sequence[Entry]) -> list[list[str]]:
    """A column, followed by the ends of its intervals where it has any."""
    head, rows = _P.sub("p", entry_text(column[0])), column[1:]
    numbers = [row for row in rows if isinstance(row, Estimate)]
    named = f"{head}, %" if any(row.unit == "share" for row in numbers) and "%" not in head else head
    values = [named, *(_number(row, "value") if isinstance(row, Estimate) else _text(row) for row in rows)]
    if all(re.fullmatch(r"([\d.]+ %)?", value) for value in values[1:]) and any(values[1:]):
        return [[f"{head}, %", *(value.removesuffix(" %") for value in values[1:])]]
    if all(row.low is None for row in numbers):
        return [values]
    ends = [[_number(row, end) if isinstance(row, Estimate) else "" for row in rows] for end in ("low", "high")]
    return [values, [f"{head}, low", *ends[0]], [f"{head}, high", *ends[1]]]


def _number(row: Estimate, of: str) -> str:
    form, scale = _form(row)
    value = getattr(row, of)
    if value is None:
        return ""
    said = form.format(scale * value) if of == "value" else end_of(value, form, scale).replace("\N{MINUS SIGN}", "-")
    return re.sub(r"^[+-]?(?=0(\.0*)?$)|^\+", "", said)


def _text(cell: str | None) -> str:
    said = "" if cell in (None, NONE) else str(cell)
    number = re.fullmatch(r"[-+]?[\d.]+(e-?\d+)?", said)
    return "'" * (said.startswith(_FORMULA) and not number) + printable(said)


def tex_text(cell: str) -> str:
    """Text for LaTeX, in which no character is a command."""
    return "".join(_TEX.get(c, c) for c in printable(cell))
