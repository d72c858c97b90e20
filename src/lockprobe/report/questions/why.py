"""Why false reports change success: through what they say, or as any odd report does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import listed, p_cell, percent
from lockprobe.foundation.grouping import grouped
from lockprobe.report.answer import headline
from lockprobe.report.format import beside, conclusion_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.primary import Line, primary_lines
from lockprobe.report.questions.contrasts import ARROW, BY_BLOCKS, contrast_head
from lockprobe.report.rows import Fact, Results, Row, measured_row
from lockprobe.report.section import Block, Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why import CONTRASTS, MARGIN, PART, TOTAL, Claim, whys

_EFFECT, _CONTRAST, _SUCCESS = "false_report_effect", "arm_contrast", "success_in_arm"

_VERDICT, _EVIDENCE = "why", "why, evidence"
"""What facts are about whose names are an agent and its modality: the verdict, and what shows it in words."""

_SAYS: Mapping[Claim, str] = {
    "last": "a false last statement {ways} it, whatever the first one says",
    "first": "a false first statement {ways} it, whatever the last one says",
    "agreed": "two false statements {way} it, and no change by a single one was detected",
    "contradiction": "one false statement is enough to {way} it",
    "falsity": "two false statements {way} it, and which of them counts is not decided",
}
"""Claim -> what it says of reports in two statements, of which the last is called a correction."""

_BECAUSE: Mapping[str, str] = {
    "says": ", because of what they say",
    "form": ", and so do true reports that come with a correction or a remark: nothing need be false",
    "both": ", partly because of what they say: true reports that come with a correction or a remark do so too",
    "blurred": "; why is not decided, since true reports that come with a correction do so too",
    "not decided": "; why is not decided, and more blocks may tell",
    "inconclusive": "",
    "no change": f", and a change of {100 * MARGIN:.0f} points or more is excluded",
}
"""Verdict on agents -> the end of the sentence on them."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    cells = numbers.by_name
    for agent, modality, p, conditions, agents, decision in whys(cells, numbers.design):
        of: dict[str, Any] = {"agent": agent, "modality": modality, "family": "agents", "unit": "points"}
        of |= {"corrected_for": agents, "doses": {"flip.p": p}}
        of |= {"test": E_PROCESS if cells[agent, conditions["truth"]].order else "sign flips of blocks"}
        yield measured_row(_EFFECT, decision.total, **of, of="total")
        for name, mean in decision.contrasts.items():
            yield measured_row(_CONTRAST, mean, **of, of=name)
        for arm, name in conditions.items():
            yield from cells[agent, name].share(_SUCCESS, cells[agent, name].success, of=arm)
        yield Fact(about=_VERDICT, name=f"{agent}, {modality}", text=decision.verdict)
        way = "raise" if decision.way > 0 else "lower"
        if says := [_SAYS[one].format(way=way, ways=f"{way}s") for one in decision.claims if one in _SAYS]:
            yield Fact(about=_EVIDENCE, name=f"{agent}, {modality}", text=listed(says))


def answer(lines: Sequence[Line], found: Results) -> str:
    """What false reports do to the success of these agents and why, a sentence for each cause; empty if not asked."""
    known = grouped(lines, lambda line: found.fact(_VERDICT, f"{line.agent}, {line.modality}"))
    whole = [
        (headline(known[verdict], "false reports")[:-1], why) for verdict, why in _BECAUSE.items() if verdict in known
    ]
    return " ".join(f"{said}{why}." for said, why in whole)


def _table(found: Results) -> Lines:
    yield contrast_head([*found.where(_EFFECT), *found.where(_CONTRAST)])
    for total in found.where(_EFFECT, of="total"):
        own = {"agent": total.agent, "modality": total.modality}
        solved = {row.of: row for row in found.where(_SUCCESS, **own)}
        for row in (total, *found.where(_CONTRAST, **own)):
            one = TOTAL if row is total else CONTRASTS[row.of]
            arms = ", ".join(f"{less}{ARROW}{more}" for more, less in zip(one.of, one.minus, strict=True))
            less, more = solved[one.minus[0]], solved[one.of[0]]
            single = len(one.of) == 1
            shares = ARROW.join((percent(less.value), percent(more.value))) if single else None
            change = beside(row, less, more) if single else row
            concluded = conclusion_of(row, at=ALPHA if row is total else PART)
            name = "false reports" if row is total else row.of
            yield [row.agent, name, arms, shares, change, p_cell(row.p_value), concluded, str(row.clusters)]


TABLE = Table("why", _table, 3, drawn="change, points", rare=("agent",))
"""What false reports change, and which reports of two statements change as much."""

_NOTE = Note(
    "Success under false reports minus success under true ones, and differences between the other arms, in points. "
    "Arms of two statements are named by them: in lie-truth a false statement is corrected by a true one.",
    BY_BLOCKS,
    Markup(
        "<p>Every arm intervenes at the same steps of the same trials, with common random numbers: a block. The effect "
        "of false reports is detected if <i>P</i> is below 0.05 and the interval excludes 0. Only then are other arms "
        "compared; these differences are detected if <i>P</i> is below {} and the interval excludes 0. A cause is "
        "named if all differences that it needs are detected in the direction of the effect.</p>"
    ).format(PART),
)

_LIMITS = Note(
    "What is shown is how reports of two statements act; that a plain false report acts as they do is assumed. The "
    "cause describes the arms, not what the agent does within.",
    "In simulated worlds in which plain reports act as those of two statements, at most 5 % of causes were wrong.",
    "An agent that any odd form changes, and a plain false report by what it says, is said to react to form. A false "
    "report that contradicts an earlier one is a statement and a surprise at once: no arm tells these apart. After "
    "actions differ, arms intervene in different situations: whole trials are compared, not steps. Arms of an agent "
    "that cannot be seeded share only the steps of the interventions, so its differences vary more.",
)
"""What these comparisons do not show."""


def _show(found: Results) -> Iterator[Part]:
    if not (verdicts := found.facts_about(_VERDICT)):
        return
    named = sum(verdict in ("says", "form", "both") for verdict in verdicts.values())
    several = f" for {named} of {len(verdicts)} agents" * (len(verdicts) > 1)
    said = f"{'A' if named else 'No'} cause is named{several}."
    shown = {line.label: found.fact(_EVIDENCE, f"{line.agent}, {line.modality}") for line in primary_lines(found)}
    two = "of reports that are given and then corrected"
    evidence: list[Block] = [[f"{label}: {two}, {of}." for label, of in shown.items() if of]] * any(shown.values())
    yield Part("Why do false reports change success?", said, [*evidence, TABLE, note_at(found, _NOTE), _LIMITS])


SECTIONS = (Section("why", "Why false reports change success", _rows, _show, (TABLE,)),)
