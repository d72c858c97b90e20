"""The effect of one report, from forks of recorded trials; ``lockprobe branch`` prints the same rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import p_cell
from lockprobe.report.format import alone
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import rules_broken_said
from lockprobe.report.rows import Estimate, Fact, Results, Row, detected_said, measured
from lockprobe.report.section import Lines, Note, Part, Section, Table
from lockprobe.statistics.branch import OUTCOMES, ForkEffect, branch_effects
from lockprobe.studies.study import Study

_CHANGE, _AFTER_TRUTH, _SUCCESS = "fork_change", "after_true_report", "success"

_TRUE = "later reports true"


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    if not numbers.forks:
        return
    parents = {trial.key: trial for trial in numbers.trials}
    rows = fork_rows(branch_effects(numbers.forks, parents), numbers.study)
    yield from rows
    if rows and (rules := rules_broken_said(*numbers.rules.broken(numbers.forks))):
        yield Fact(about="forks", name="rules", text=rules)


def fork_rows(effects: Iterable[ForkEffect], study: Study) -> list[Estimate]:
    """The change by each arm at each place, and the outcome after a true report there."""
    rows = []
    for one in effects:
        condition, unit = study.labelled(one.condition), OUTCOMES[one.outcome]
        later = _TRUE if one.truthful else "later reports as in the condition"
        of: dict[str, Any] = {"agent": one.agent, "modality": condition.modality, "condition": one.condition}
        of |= {"of": f"{one.outcome}, {one.arm}, {one.where}, {later}", "doses": dict(condition.doses)}
        tested = measured(one.change) | {"corrected_for": one.agents, "test": "sign flips of trials"}
        family = "agents; P values of success also all forks of one agent (Holm)"
        rows.append(Estimate(quantity=_CHANGE, **of, **tested, unit=unit, family=family))
        of |= {"unit": "steps" if unit == "steps" else "share", "n": one.change.n}
        rows.append(Estimate(quantity=_AFTER_TRUTH, **of, value=one.after_truth))
    return rows


def _of_success(rows: Iterable[Estimate]) -> list[Estimate]:
    return [row for row in rows if row.quantity == _CHANGE and row.of.startswith(f"{_SUCCESS}, ")]


def fork_table(rows: Sequence[Estimate]) -> Lines:
    """One row for each agent, condition, place and arm; how later reports are where they are true."""
    known = {(row.quantity, row.agent, row.condition, row.of): row for row in rows}
    others = [outcome for outcome in OUTCOMES if outcome != _SUCCESS]
    head = ["agent", "condition", "forked at", "arm", "later reports", "solved after truth", "change, points", "P"]
    yield [*head, *others, "trials"]
    for row in _of_success(rows):
        own, (arm, where, later) = (row.agent, row.condition), row.of.partition(", ")[2].rsplit(", ", 2)
        names = [row.agent, row.condition, where, arm, later.removeprefix("later reports ")]
        more = [alone(known.get((_CHANGE, *own, row.of.replace(_SUCCESS, outcome, 1)))) for outcome in others]
        told = alone(known[_AFTER_TRUTH, *own, row.of])
        yield [*names, told, row, p_cell(row.p_value), *more, str(row.clusters)]


def fork_said(rows: Sequence[Estimate]) -> str:
    """How many effects on success were detected; empty without forks."""
    return detected_said(_of_success(rows), "effects of one report on success")


RARE = ("later reports",)

_TABLE = Table("forks", lambda found: fork_table(found.rows), 5, drawn="change, points", rare=RARE)

_NOTE = Note(
    "Success after a true report, and its change in points (filled: detected). The other columns are changes, too. "
    "What is not detected is not shown to be nothing.",
    Markup(
        "Brackets are 95 % intervals over trials. <i>P</i> is corrected for all effects of one agent on success "
        "(Holm); both are corrected for the number of agents, baselines apart."
    ),
    Markup(
        "<p>A fork continues a finished trial from the report of one step. The steps before it are taken from the "
        "record. That report, or the action after it, is changed, and the agent continues, with the same random "
        "numbers in every arm if it is seeded. Each trial counts once, with all its continuations. <i>steps</i>: "
        "number of steps, with the budget for unsolved trials. <i>repeats</i>: the next action repeats the "
        "last one.</p>"
    ),
)

_LIMITS = (
    "Effects at different steps are of different trials: those that are still running there.",
    "Trials that loop were often lost long before, so a difference from forks elsewhere is no effect of the loop.",
    "If later reports follow the condition, the effect is that of one more false report among others.",
    "Hosted models cannot be seeded: their arms share the past but no random numbers, so their differences vary more.",
)


def _show(found: Results) -> Iterator[Part]:
    if said := fork_said(found.rows):
        rules = filter(None, [found.fact("forks", "rules")])
        yield Part("Effect of one report", said, [*rules, _TABLE, _NOTE, _LIMITS])


SECTIONS = (Section("forks", "Effect of one report", _rows, _show, (_TABLE,)),)
