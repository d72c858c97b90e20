"""The table of an article: ``paper.tex``, every agent under every condition, in parts that fit a page each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lockprobe.foundation.formatting import p_cell
from lockprobe.foundation.grouping import grouped
from lockprobe.report.format import tex_text
from lockprobe.report.rows import Cell, Estimate, Results

_CAPTION = (
    "Success with 95 % intervals, and its change from the control. P values are corrected within their families; a "
    "change is detected if P is below 0.05 and its interval excludes 0."
)

_COMMON = " Changes are of the trials that were finished under both conditions."
"""What the caption of an unfinished study adds, in which a change is not the difference of two shares of the table."""

_CONTINUED = "Success and its change from the control (continued)."

_LINES = 33.0
"""Lines of a part at most, which leaves room for its head and its caption on a page of an article."""

_GAP = 0.5
"""Lines between two agents, rounded up."""

_NO_CHANGE = " & & "

_Changes = Mapping[tuple[str, str], Sequence[Estimate]]


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of the table: the agent, which only the first of its rows in a part names, and its other cells."""

    agent: str
    label: str
    cells: str


def table_tex(found: Results) -> str:
    """Six columns: who, where, trials, solved, the change, and its P value. Every part is a float of its own."""
    where = "condition" if found.beside_flips else "flip rate"
    head = (
        rf"agent & {where} & trials & \multicolumn{{2}}{{l}}{{solved, \%}} & \multicolumn{{2}}{{l}}{{change, points}} "
        r"& \emph{P} \\"
    )
    columns = rf"l{'l' if found.beside_flips else 'r'}rr@{{ }}lr@{{ }}lr"
    parts = list(_parts(list(_rows(found)))) or [[]]
    first = f"{_CAPTION}{_COMMON * _of_fewer(found)}"
    return "\n".join(_float(part, columns, head, "" if i else first) for i, part in enumerate(parts))


def _of_fewer(found: Results) -> bool:
    """Whether a change is of fewer trials than the shares of its condition and its control."""
    trials = {(cell.agent, cell.condition): row.n or 0 for cell in found.cells if (row := cell.get("success"))}
    control = {one.name: one.control for one in found.design.conditions}
    return any(
        (row.n or 0) < max(trials.get((row.agent, name), 0) for name in (row.condition, control.get(row.condition, "")))
        for row in found.against_control()
    )


def _rows(found: Results) -> Iterator[_Row]:
    changes = grouped(found.against_control(), lambda row: (row.agent, row.condition))
    for cell in found.cells:
        success = cell.get("success")
        if success is None or success.value is None:
            continue
        at = f"{cell.p:g}" if cell.p is not None and not found.beside_flips else tex_text(cell.condition)
        cells = f"{at} & {success.n} & {100 * success.value:.0f} & {_interval(success)} & {_change(changes, cell)}"
        yield _Row(cell.agent, tex_text(cell.label), cells)


def _parts(rows: Sequence[_Row]) -> Iterator[list[_Row]]:
    """Rows by page: an agent whose rows do not fit begins on the next page, and is divided where no page holds it."""
    own = grouped(rows, lambda row: row.agent)
    most, part, left = int(_LINES), list[_Row](), _LINES
    for of in own.values():
        for block in (of[i : i + most] for i in range(0, len(of), most)):
            if part and len(block) + _GAP > left:
                yield part
                part, left = [], _LINES
            left -= len(block) + _GAP * bool(part)
            part = [*part, *block]
    if part:
        yield part


def _float(rows: Sequence[_Row], columns: str, head: str, first: str) -> str:
    """A part of the table; ``first`` is the caption of the first one, and empty in the others."""
    lines = [r"\begin{table*}"] if first else [r"\begin{table*}", r"\addtocounter{table}{-1}"]
    lines += [r"\centering", rf"\begin{{tabular}}{{{columns}}}", r"\toprule", head]
    last = ""
    for row in rows:
        if row.agent != last:
            lines.append(r"\addlinespace" if last else r"\midrule")
        lines.append(f"{{}}{row.label if row.agent != last else ''} & {row.cells} \\\\")
        last = row.agent
    caption = tex_text(first or _CONTINUED)
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", rf"\caption{{{caption}}}", r"\end{table*}", ""])


def _change(changes: _Changes, cell: Cell) -> str:
    """The change from the control, its interval and its P value; empty for the control, and where none was tested."""
    for row in changes.get((cell.agent, cell.condition), ()):
        if row.modality in ("", cell.modality) and row.value is not None:
            return f"${_points(row.value)}$ & {_interval(row, '+')} & {tex_text(p_cell(row.p_value))}"
    return _NO_CHANGE


def _interval(row: Estimate, sign: str = "") -> str:
    if row.low is None or row.high is None:
        return ""
    low, high = (_points(end) if sign else f"{100 * end:.0f}" for end in (row.low, row.high))
    return f"$[{low}, {high}]$"


def _points(value: float) -> str:
    """A difference in points with its sign; 0 has none."""
    said = f"{100 * value:+.0f}"
    return "0" if said in ("+0", "-0") else said
