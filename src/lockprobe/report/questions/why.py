"""Why false reports change success: through what they say, or as any odd report does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import listed, p_cell
from lockprobe.report.format import conclusion_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.questions.contrasts import ARROW, BY_BLOCKS, CONTRAST
from lockprobe.report.rows import Fact, Results, Row, measured_row, who
from lockprobe.report.section import Lines, Note, Part, Section, Table, note_at
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.modalities import spoken
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.why import CONTENT, CONTRASTS, MARGIN, PART, TOTAL, Decision, Verdict, whys
from lockprobe.trial.record import PLAIN_WORDS

_EFFECT, _CONTRAST, _SUCCESS, _SAID = "false_report_effect", "arm_contrast", "success_in_arm", "why"

_CLAUSES = {
    "last": "a false last statement {ways} it, whatever the first one says",
    "first": "a false first statement {ways} it, whatever the last one says",
    "agreed": "two false statements {way} it, and no change by a single one was detected",
    "contradiction": "one false statement is enough to {way} it",
    "falsity": "two false statements {way} it, and which of them counts is not decided",
    "form": "a true correction and an irrelevant remark {way} it too",
}
"""Claim -> what it says of reports in two statements, of which the last is called a correction."""

_VERDICTS: Mapping[Verdict, str] = {
    "says": "Through what they say.",
    "form": "As any odd report does.",
    "both": "Through what they say, and as any odd report does.",
    "blurred": "Not decided: a true correction changes success too.",
    "not decided": "Not decided: more blocks may tell.",
    "no change": f"They change it by less than {100 * MARGIN:.0f} points.",
    "inconclusive": "No effect of false reports was detected.",
}
"""What was decided on one agent, in a few words."""


def _rows(numbers: OpenedStudy) -> Iterator[Row]:
    cells, found = numbers.by_name, list(whys(numbers.by_name, numbers.design))
    for agent, modality, p, conditions, agents, decision in found:
        of: dict[str, Any] = {"agent": agent, "modality": modality, "family": "agents", "unit": "points"}
        of |= {"corrected_for": agents, "doses": {"flip.p": p}}
        of |= {"test": E_PROCESS if cells[agent, conditions["truth"]].order else "sign flips of blocks"}
        yield measured_row(_EFFECT, decision.total, **of, of="total")
        for name, mean in decision.contrasts.items():
            yield measured_row(_CONTRAST, mean, **of, of=name)
        for arm, name in conditions.items():
            yield from cells[agent, name].share(_SUCCESS, cells[agent, name].success, of=arm)
    named = sum(bool(decision.claims) for *_, decision in found)
    several = f"A cause is named for {named} of {len(found)} agents."
    said = several if len(found) > 1 else "".join(_VERDICTS[decision.verdict] for *_, decision in found)
    facts = {"verdict": said} if found else {}
    for i, one in enumerate(sorted(found, key=lambda one: one[0] not in numbers.subjects)):
        facts[f"{i}"] = why_said(one[0], one[1], one[-1])
    yield from (Fact(about=_SAID, name=name, text=text) for name, text in facts.items())


def answers(found: Results) -> list[str]:
    """What false reports do to the success of each agent, and why; none if that is not asked."""
    return [text for name, text in found.facts_about(_SAID).items() if name.isdecimal()]


def why_said(agent: str, modality: str, decision: Decision) -> str:
    """What happened to the success of one agent; then the cause, or what is not decided."""
    margin = f"{100 * MARGIN:.0f} points"
    of = f"the success of {who(agent, '' if modality in PLAIN_WORDS else spoken(modality))}"
    if decision.verdict == "no change":
        return f"False reports change {of} by less than {margin}."
    if decision.verdict == "inconclusive":
        said = f"No effect of false reports on {of} was detected"
        return f"{said}, and a change of {margin} or more is not excluded."
    way = "raise" if decision.way > 0 else "lower"
    return f"False reports {way} {of} by {100 * abs(decision.total.value):.0f} points. {_cause(decision, way)}."


def _cause(decision: Decision, way: str) -> str:
    if decision.verdict == "blurred":
        return f"Why is not decided: a true correction {way}s it too, so corrections cannot tell"
    if decision.verdict == "not decided":
        return "Why is not decided: through what they say, or as any odd report does; more blocks may tell"
    clauses = {claim: _CLAUSES[claim].format(way=way, ways=f"{way}s") for claim in decision.claims}
    if decision.verdict == "form":
        return f"They do so as any odd report does: {clauses['form']}, so nothing false is needed"
    says = listed([said for claim, said in clauses.items() if claim in CONTENT])
    also = f"; and as any odd report does: {clauses['form']}" if "form" in clauses else ""
    return f"They do so through what they say: of reports that are given and then corrected, {says}{also}"


def _table(found: Results) -> Lines:
    yield CONTRAST
    for total in found.where(_EFFECT, of="total"):
        own = {"agent": total.agent, "modality": total.modality}
        solved = {row.of: 100 * (row.value or 0.0) for row in found.where(_SUCCESS, **own)}
        for row in (total, *found.where(_CONTRAST, **own)):
            one = TOTAL if row is total else CONTRASTS[row.of]
            arms = ", ".join(f"{less}{ARROW}{more}" for more, less in zip(one.of, one.minus, strict=True))
            shares = f"{solved[one.minus[0]]:.0f}{ARROW}{solved[one.of[0]]:.0f} %" if len(one.of) == 1 else None
            concluded = conclusion_of(row, at=ALPHA if row is total else PART)
            name = "false reports" if row is total else row.of
            yield [row.agent, name, arms, shares, row, p_cell(row.p_value), concluded, str(row.clusters)]


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
    if said := answers(found):
        verdict = found.fact(_SAID, "verdict")
        heading = "Why do false reports change success?"
        yield Part(heading, verdict, [said, TABLE, note_at(found, _NOTE), _LIMITS])


SECTIONS = (Section("why", "Why false reports change success", _rows, _show, (TABLE,)),)
