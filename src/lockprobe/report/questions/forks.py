"""The effect of one report, from forks of recorded trials."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import NONE, p_cell, percent
from lockprobe.report.format import TextTable
from lockprobe.report.prose.branch import found_said, value_said
from lockprobe.report.prose.robot import broken_said
from lockprobe.report.rows import Estimate, Finding, Results, Row
from lockprobe.report.section import Block, Caption, Detail, Figure, Listed, Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, of_blocks
from lockprobe.report.table_rows import points_cell
from lockprobe.statistics.branch import BranchEffect

_OUTCOMES = {
    "solved": ("success", "points"),
    "steps": ("steps", "steps"),
    "leaves": ("leaves_loop", "points"),
    "repeats": ("repeats", "points"),
    "choice": ("next_choice", "total variation"),
}
"""Outcome -> how its quantities begin, and the unit of its change."""

_OTHERS = {"steps": "steps", "leaves": "leaves loop", "repeats": "repeats", "choice": "next choice"}
"""Outcomes besides success -> the heads of their columns."""

_LATER = ", later reports "


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    effects = numbers.forks
    for one in effects:
        yield from _of_effect(one, numbers)
    if effects:
        rules = broken_said(numbers.opened.forks, numbers.study.box)
        for said in (*found_said([one for one in effects if one.outcome == "solved"]), *filter(None, [rules])):
            yield Finding(section="forks", kind="finding", text=said, rests_on=("success_change_by_fork",))


def _of_effect(one: BranchEffect, numbers: StudyNumbers) -> Iterator[Estimate]:
    """The change by an arm at one place, and the outcome after a true report there."""
    condition, (quantity, unit) = numbers.study.labelled(one.condition), _OUTCOMES[one.outcome]
    later = "true" if one.truthful else "as in the condition"
    of: dict[str, Any] = {
        "agent": one.agent,
        "modality": condition.modality,
        "condition": one.condition,
        "of": f"{one.arm}, {one.where}{_LATER}{later}",
        "doses": dict(condition.doses),
    }
    tested = of_blocks(one.change) | {"n": one.forks, "corrected_for": one.agents, "test": "sign flips of trials"}
    family = "agents; P values of success also all forks of one agent (Holm)"
    yield Estimate(quantity=f"{quantity}_change_by_fork", **of, **tested, unit=unit, family=family)
    level = "steps" if unit == "steps" else "share"
    yield Estimate(quantity=f"{quantity}_after_true_report", **of, unit=level, n=one.forks, value=one.after_truth)


def _table(found: Results) -> TextTable:
    """One row for each agent, condition, place and arm."""
    head = ["agent", "condition", "forked at", "arm", "later reports", "solved after truth", "change, points", "P"]
    table = [[*head, *_OTHERS.values(), "trials"]]
    for row in found.where("success_change_by_fork"):
        of = {"agent": row.agent, "condition": row.condition, "of": row.of}
        place, _, later = row.of.rpartition(_LATER)
        arm, _, where = place.rpartition(", ")
        told = percent(found.one("success_after_true_report", **of).value)
        others = [_value(outcome, found.get(f"{_OUTCOMES[outcome][0]}_change_by_fork", **of)) for outcome in _OTHERS]
        size = [points_cell(row), p_cell(row.p_value)]
        table.append([row.agent, row.condition, where, arm, later, told, *size, *others, str(row.clusters)])
    return table if len(table) > 1 else []


def _value(outcome: str, row: Estimate | None) -> str:
    return NONE if row is None or row.value is None else value_said(outcome, row.value)


_TABLE = Table("forks", _table, numeric_from=5)

FIGURE = Figure(
    "forks",
    "Change of success by one report, by the step at which it was given",
    Caption(
        "Change of success by one report or action, by the step at which trials were forked. The line at 0 is a true "
        "report.",
        "Bars are 95 % intervals over trials, corrected for the number of agents alone.",
    ),
    draw="lockprobe.report.figures.forks:forks",
    applies=lambda found: bool(found.where("success_change_by_fork")),
)

_HOW = Markup(
    "<p>A fork continues a finished trial from the report of one step. The steps before it are taken from the record "
    "without new calls to a provider. That report, or the action after it, is changed, and the agent continues. If the "
    "agent is seeded, arms use common random numbers after the fork, so they differ only by the change. Each trial "
    "counts once, with all its continuations. <i>steps</i>: number of steps, with the budget for unsolved trials. "
    "<i>leaves loop</i>: the next action does not continue the current loop, in points. <i>repeats</i>: the next "
    "action repeats the last one, in points. <i>next choice</i>: total variation distance between the probabilities of "
    "the next choice, from 0 to 1; it is exact, and available for policies and local models.</p>"
)

_LIMITS = (
    (
        "Only trials that are still running at a step are forked there. Effects at different steps come from different "
        "trials."
    ),
    (
        "Forks at a detected loop come from trials that were often lost long before. A difference between forks in "
        "loops and elsewhere is not an effect of the loop."
    ),
    (
        "If later reports follow the condition, the effect is that of one more false report among others. Forks of "
        "trials at a flip rate of 0 show the effect of a first false report."
    ),
    "Hosted models cannot be seeded: their arms share the past but no random numbers, so their differences vary more.",
)


def _show(found: Results) -> Iterator[Part]:
    """The parts of the page; its template has the findings above the first."""
    rows = found.where("success_change_by_fork")
    if not rows:
        return
    agents = max(row.corrected_for for row in rows) > 1
    note = Note(
        "Success after a true report, and its change in points. The other columns are also changes.",
        Markup(
            "Brackets are 95 % intervals over trials. <i>P</i> is corrected for all effects of one agent on success "
            "(Holm){}."
        ).format("; both are corrected for the number of agents, baselines apart" if agents else ""),
        _HOW,
    )
    said = found.said("forks", "finding")
    blocks: list[Block] = [FIGURE, Listed(said[1:]), _TABLE, note, Detail("What forks do not show", [Listed(_LIMITS)])]
    yield Part("Effect of one report", said[0] if said else f"{len(rows)} effects, by step and arm.", blocks)


SECTIONS = (
    Section(
        name="forks",
        title="Effect of one report",
        rows=_rows,
        show=_show,
        tables=(_TABLE,),
        figures=(FIGURE,),
    ),
)
