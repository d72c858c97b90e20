"""What a study asks by itself: the contrasts of conditions that its file declares."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, listed, percent
from lockprobe.report.every_look import note_at
from lockprobe.report.format import Entry, tested, without_empty
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.questions.conditions import detected_said
from lockprobe.report.rows import Estimate, Results, Row, measured_row
from lockprobe.report.rows.primary import DECLARED, SIDES
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.statistics.contrast import declared
from lockprobe.statistics.every_look import E_PROCESS

_STUDENT = "Student over blocks"

CONTRAST = ["agent", "contrast", "conditions", "success", "change, points", "P", "result", "blocks"]
"""Columns of a table of contrasts; agents stand there if they are several."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    cells, asked = numbers.by_name, numbers.study.contrasts
    test = E_PROCESS if numbers.every_look else "sign flips of blocks"
    for agent, name, choices, (change, *sides) in declared(cells, asked, numbers.design):
        own = {"agent": agent, "modality": cells[agent, asked[name].of[0]].modality}
        quantity = f"{asked[name].measure}_difference"
        judged = {"family": DECLARED, "corrected_for": choices, "test": test if sides else _STUDENT, "unit": "points"}
        yield measured_row(quantity, change, **own, **judged, of=name)
        for side, share in zip(SIDES[::-1], sides, strict=False):
            yield measured_row("success_in_pairs", share, **own, of=f"{name}, {side}")


def _declared(found: Results) -> list[Estimate]:
    return [row for of in ("success", "misreading") for row in found.where(f"{of}_difference", family=DECLARED)]


def misreading_said(rows: Sequence[Estimate]) -> str:
    """Which contrasts change what is misread, for any agent, the largest change first."""
    clear = sorted((row for row in rows if row.detected), key=lambda row: -abs(row.value or 0.0))
    names, agents = [*dict.fromkeys(row.of for row in clear)], len({row.agent for row in rows})
    said = f"misreading changes with {listed(names)}" if names else "no change of misreading was detected"
    return f"{capital(f'for at least one of {agents} agents, ' * (agents > 1) + said)}."


def _table(found: Results) -> Sequence[Sequence[Entry]]:
    known = {one.name: one for one in found.design.contrasts}
    table: list[list[Entry]] = [[*CONTRAST]]
    for row in _declared(found):
        shares = (found.get("success_in_pairs", agent=row.agent, of=f"{row.of}, {side}") for side in SIDES)
        solved = " \N{RIGHTWARDS ARROW} ".join(percent(share.value if share else None) for share in shares)
        conditions = f"{listed(known[row.of].minus)} \N{RIGHTWARDS ARROW} {listed(known[row.of].of)}"
        table.append([row.agent, row.of, conditions, solved, *tested(row), str(row.clusters)])
    return without_empty(table, ["agent"])


CONTRASTS = Table("contrasts", _table, numeric_from=3, drawn="change, points")

_NOTE = Note(
    "Mean success, or misreading, under the conditions of one side minus that under those of the other, in points, as "
    "the study file declares it. Contrasts that were chosen after the results were seen prove nothing.",
    Markup(
        "Each block of equal luck that has a trial under all conditions of a contrast gives one value. The interval is "
        "Student\N{RIGHT SINGLE QUOTATION MARK}s over blocks, widened as if one more block differed; <i>P</i> is that "
        "of a sign-flip permutation test over blocks. Both are corrected for the number of contrasts and of agents "
        "(baselines apart). Misreading: the share of statements about an attempt that contradict what happened, with "
        "Student's test."
    ),
)


def _show(found: Results) -> Iterator[Part]:
    if rows := _declared(found):
        yield Part("What the study asks", detected_said(rows, "contrasts"), [CONTRASTS, note_at(found, _NOTE)])


SECTIONS = (Section(name="contrasts", title="Declared contrasts", rows=_rows, show=_show, tables=(CONTRASTS,)),)
