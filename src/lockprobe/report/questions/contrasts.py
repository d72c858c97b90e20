"""What a study asks by itself: the contrasts of conditions that its file declares."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from markupsafe import Markup

from lockprobe.foundation.formatting import listed, p_cell
from lockprobe.report.every_look import note_at
from lockprobe.report.format import DETECTED, TextTable
from lockprobe.report.questions.conditions import cells_of, detected_said
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.rows.primary import DECLARED, SIDES
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, measured_row
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics.contrast import declared
from lockprobe.statistics.sequential.contrasts import E_PROCESS


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    cells, asked = cells_of(numbers), numbers.study.contrasts
    test = E_PROCESS if numbers.opened.every_look else "sign flips of blocks"
    for agent, name, choices, (change, of, minus) in declared(cells, asked, numbers.design):
        own = {"agent": agent, "modality": cells[agent, asked[name].of[0]].modality}
        judged = {"family": DECLARED, "corrected_for": choices, "test": test, "unit": "points"}
        yield measured_row("success_difference", change, **own, **judged, of=name)
        for side, share in zip(SIDES, (minus, of), strict=True):
            yield measured_row("success_in_pairs", share, **own, of=f"{name}, {side}")


class Compared(NamedTuple):
    """A contrast as its table shows it: its number, its name, its conditions, success without and with, the verdict."""

    row: Estimate
    name: str
    conditions: str
    success: str
    detected: bool


def contrasts_table(compared: Sequence[Compared]) -> TextTable:
    """Contrasts of conditions, one row each; agents stand there if they are several. No table without any row."""
    head = ["agent", "contrast", "conditions", "success", "change, points", "P", "result", "blocks"]
    table = [head] * bool(compared)
    for one in compared:
        tested = [points_cell(one.row), p_cell(one.row.p_value), DETECTED[one.detected], str(one.row.clusters)]
        table.append([one.row.agent, one.name, one.conditions, one.success, *tested])
    return table if len({one.row.agent for one in compared}) > 1 else [row[1:] for row in table]


def _declared(found: Results) -> list[Estimate]:
    return found.where("success_difference", family=DECLARED)


def _table(found: Results) -> TextTable:
    known = {one.name: one for one in found.design.contrasts}
    compared = []
    for row in _declared(found):
        shares = (found.get("success_in_pairs", agent=row.agent, of=f"{row.of}, {side}") for side in SIDES)
        less, more = (100 * (share.value or 0.0) if share else math.nan for share in shares)
        one = known[row.of]
        conditions = f"{listed(one.minus)} \N{RIGHTWARDS ARROW} {listed(one.of)}"
        success = f"{less:.0f} \N{RIGHTWARDS ARROW} {more:.0f} %"
        compared.append(Compared(row, row.of, conditions, success, row.detected))
    return contrasts_table(compared)


CONTRASTS = Table("contrasts", _table, numeric_from=3, drawn=_declared)

_NOTE = Note(
    "Mean success under the conditions of one side minus that under those of the other, in points, as the study file "
    "declares it. Contrasts that were chosen after the results were seen prove nothing.",
    Markup(
        "Each block of equal luck that has a trial under all conditions of a contrast gives one value. The interval is "
        "Student\N{RIGHT SINGLE QUOTATION MARK}s over blocks, widened as if one more block differed; <i>P</i> is that "
        "of a sign-flip permutation test over blocks. Both are corrected for the number of contrasts and of agents "
        "(baselines apart)."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    if rows := _declared(found):
        yield Part(
            "What the study asks",
            f"{detected_said(rows, 'contrasts')} detected.",
            [CONTRASTS, note_at(found, _NOTE)],
        )


SECTIONS = (Section(name="contrasts", title="Declared contrasts", rows=_rows, show=_show, tables=(CONTRASTS,)),)
