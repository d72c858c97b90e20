"""The effect of one report, from forks of recorded trials; ``lockprobe branch`` prints the same rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import capital, change, p_cell, p_value, percent, points
from lockprobe.foundation.grouping import grouped
from lockprobe.report.format import alone
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.prose import rules_broken_said
from lockprobe.report.rows import Estimate, Fact, Results, Row, clearness, measured
from lockprobe.report.section import Figure, Lines, Note, Part, Section, Table
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


def _place(row: Estimate) -> tuple[str, str, str]:
    """The arm, the fork point, and what later reports are."""
    arm, where, later = row.of.partition(", ")[2].rsplit(", ", 2)
    return arm, where, later


def _of_success(rows: Iterable[Estimate], quantity: str = _CHANGE) -> list[Estimate]:
    return [row for row in rows if row.quantity == quantity and row.of.startswith(f"{_SUCCESS}, ")]


def fork_table(rows: Sequence[Estimate]) -> Lines:
    """One row for each agent, condition, place and arm; how later reports are where they are true."""
    known = {(row.quantity, row.agent, row.condition, row.of): row for row in rows}
    others = [outcome for outcome in OUTCOMES if outcome != _SUCCESS]
    head = ["agent", "condition", "forked at", "arm", "later reports", "solved after truth", "change, points", "P"]
    yield [*head, *others, "trials"]
    for row in _of_success(rows):
        own, (arm, where, later) = (row.agent, row.condition), _place(row)
        names = [row.agent, row.condition, where, arm, later.removeprefix("later reports ")]
        more = [alone(known.get((_CHANGE, *own, row.of.replace(_SUCCESS, outcome, 1)))) for outcome in others]
        told = alone(known[_AFTER_TRUTH, *own, row.of])
        yield [*names, told, row, p_cell(row.p_value), *more, str(row.clusters)]


def fork_said(rows: Sequence[Estimate]) -> str:
    """How many effects on success were detected, and the clearest of them; empty without forks."""
    found = _of_success(rows)
    after = {(row.agent, row.condition, row.of): row for row in _of_success(rows, _AFTER_TRUTH)}
    clear = [row for row in found if row.detected]
    if not found:
        return ""
    if len(found) > 1 and not clear:
        return f"No effect of one report on success was detected in {len(found)} comparisons."
    row = min(clear or found, key=clearness)
    arm, where, later = _place(row)
    on, at = f"the success of {row.agent} ({row.condition})", f"step {where}" if where.isdecimal() else where
    said = f"No effect of {arm} at {at} on {on} was detected"
    if row.detected:
        said = f"{capital(arm)} at {at} {'raises' if (row.value or 0.0) > 0 else 'lowers'} {on}"
    size = f"{change(row.value or 0.0, row.low, row.high)}; {p_value(row.p_value)}"
    told = percent(after[row.agent, row.condition, row.of].value)
    said = f"{said}: {told} after a true report, {size}, {row.clusters} trials, {row.n} forks, {later}."
    return said if len(found) == 1 else f"{len(clear)} of {len(found)} effects of one report were detected. {said}"


_TABLE = Table("forks", lambda found: fork_table(found.rows), 5, rare=("later reports",))

_PANELS = 6
"""Panels that are drawn; later ones are the table's."""


def draw(found: Results) -> Any:
    """The changes of success by place, a panel for each agent, condition and way to go on.

    Steps come in their order, then the places that a rule names.
    """
    from lockprobe.report.figures import drawing as figures

    def on(axes: Any, rows: Sequence[Estimate]) -> None:
        arms = grouped(rows, lambda row: _place(row)[0])
        places = sorted({_place(row)[1] for row in rows}, key=lambda at: (not at.isdecimal(), at.zfill(4)))
        axes.axhline(0, color=figures.INK, linewidth=0.8)
        for i, (arm, own) in enumerate(arms.items()):
            colour = figures.TARGET if "lie" in arm else figures.FAINT
            style = figures.Style(colour=colour, marker=figures.MARKERS[i % len(figures.MARKERS)])
            across = [places.index(_place(row)[1]) + 0.6 * ((i + 0.5) / len(arms) - 0.5) for row in own]
            figures.estimates(axes, across, own, style, label=figures.safe_name(arm))
        reach = 1.1 * max(0.2, *(abs(end or 0.0) for row in rows for end in (row.low, row.high, row.value)))
        step = 0.5 if reach > 0.6 else 0.2 if reach > 0.3 else 0.1
        ticks = [i * step for i in range(-int(reach / step), int(reach / step) + 1)]
        axes.set(ylim=(-reach, reach), xlim=(-0.6, len(places) - 0.4))
        figures.axis(axes, "y", ticks, [points(tick) for tick in ticks], "change of success, points", grid=True)
        names = [f"step {at}" if at.isdecimal() else at.replace("-", "\n") for at in places]
        figures.axis(axes, "x", range(len(places)), names)
        first, later = rows[0], f", {_TRUE}" * (_place(rows[0])[2] == _TRUE)
        said = f"{first.condition}{later}; {figures.counts(row.clusters for row in rows)}"
        figures.title(axes, figures.safe_name(first.agent, 38), figures.safe_name(said))

    panels = grouped(_of_success(found.rows), lambda row: (row.agent, row.condition, _place(row)[2]))
    return figures.sheet(list(panels.values())[:_PANELS], on)


_FIGURE = Figure(
    "forks",
    "Change of success by one report, by the place at which it was given",
    Note(
        "Change of success by one report or action, by where trials were forked. The line at 0 is a true report.",
        "Bars are 95 % intervals over trials, corrected for the number of agents alone.",
    ),
    draw,
    applies=lambda found: bool(_of_success(found.rows)),
)

_NOTE = Note(
    "Success after a true report, and its change in points. The other columns are also changes.",
    Markup(
        "Brackets are 95 % intervals over trials. <i>P</i> is corrected for all effects of one agent on success "
        "(Holm); both are corrected for the number of agents, baselines apart."
    ),
    Markup(
        "<p>A fork continues a finished trial from the report of one step. The steps before it are taken from the "
        "record. That report, or the action after it, is changed, and the agent continues, with the same random "
        "numbers in every arm if it is seeded. Each trial counts once, with all its continuations. <i>steps</i>: "
        "number of steps, with the budget for unsolved trials. <i>leaves loop</i>, <i>repeats</i>: the next action "
        "does not continue the current loop, or repeats the last one.</p>"
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
        yield Part("Effect of one report", said, [*rules, _FIGURE, _TABLE, _NOTE, _LIMITS])


SECTIONS = (Section("forks", "Effect of one report", _rows, _show, (_TABLE,), (_FIGURE,)),)
