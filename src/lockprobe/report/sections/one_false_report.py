"""The effect of one false report: a small experiment at every report that was inverted at random."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast

from markupsafe import Markup

from lockprobe.foundation.formatting import bracketed, first_three, p_cell
from lockprobe.report.format import TextTable
from lockprobe.report.prose.excursion import AMONG, OUTCOMES, excursion_said
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.report.rows import Estimate, Fact, Finding, Results, Row
from lockprobe.report.section import Block, Detail, Note, Part, Section, Table, Template, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.report.table_rows import name_of
from lockprobe.statistics.conditions.axis import FLIPS
from lockprobe.statistics.excursion import Among, Excursion, Excursions, Outcome

__all__ = ["SECTIONS", "effects_on"]

_NAME = "one_false_report"
_EFFECT, _DETECTABLE = "effect_of_one_false_report", "detectable_effect_of_one_false_report"
_REPORTS = "reports_false_at_random"

Who = tuple[str, str]
"""An agent and its modality."""


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    estimated = [(one, one.one_false_report) for one in numbers.flips.subjects]
    yield from effects_on({(of.agent, of.modality): (subject_of(of), found) for of, found in estimated if found})


def effects_on(agents_of_study: Mapping[Who, tuple[Subject, Excursions]]) -> Iterator[Row]:
    """The effects of one false report on every agent with trials at a flip rate above 0 and below 1.

    Agents are one family: their P values and intervals are corrected for the number of those with an estimate.

    Args:
        agents_of_study: The agents, with the subjects of sentences about them and the effects on each.
    """
    heeding = {who: subject for who, (subject, _) in agents_of_study.items()}
    found = {who: effects for who, (_, effects) in agents_of_study.items()}
    if (agents := sum(bool(effects.estimates) for effects in found.values())) > 1:
        found = {who: effects.corrected(agents) for who, effects in found.items()}
    for who, effects in found.items():
        own: dict[str, Any] = {"agent": who[0], "modality": who[1], "axis": FLIPS.name}
        yield Estimate(quantity=_REPORTS, **own, unit="reports", value=effects.points)
        for one in effects.estimates:
            yield from _effect(one, effects.agents, own)
        for left_out in effects.left_out:
            yield Fact(about=_about(*who), name=f"{left_out.outcome}, {left_out.among}", text=left_out.reason)
        yield _said("effect", excursion_said(effects, heeding[who]), who, judges=_on_success(effects) is not None)
    parts = [
        f"{bracketed(solved.effect, solved.low, solved.high)} {heeding[who].name}"
        for who, effects in found.items()
        if (solved := _on_success(effects))
    ]
    if parts:
        yield _said("answer", f"Success after one more false report, in points: {first_three(parts, '; ')}.")


def _on_success(effects: Excursions) -> Excursion | None:
    """The effect of all reports on success; None if it is not estimated."""
    return next((one for one in effects.estimates if (one.outcome, one.among) == ("solved", "all")), None)


def _said(kind: str, text: str, who: Who = ("", ""), *, judges: bool = True) -> Finding:
    agent, modality = who
    rests_on = (_EFFECT, _REPORTS)
    return Finding(
        section=_NAME, kind=kind, agent=agent, modality=modality, text=text, rests_on=rests_on, judges=judges
    )


def _about(agent: str, modality: str) -> str:
    """What the reasons are a property of why effects on an agent are not estimated."""
    return f"effects of one false report on {agent}, {modality}"


def _effect(one: Excursion, agents: int, own: dict[str, Any]) -> Iterator[Estimate]:
    own = own | {"of": f"{one.outcome}, {one.among}", "unit": "points", "n": one.points, "clusters": one.clusters}
    yield Estimate(
        quantity=_EFFECT,
        **own,
        value=one.effect,
        low=one.low,
        high=one.high,
        p_value=one.p_value,
        family="agents",
        corrected_for=agents,
        test="Student's t over blocks",
    )
    yield Estimate(quantity=_DETECTABLE, **own, value=one.smallest, note="power 80 %")


def _words(of: str) -> tuple[str, str]:
    """An outcome and the reports that are meant, in words."""
    outcome, among = of.split(", ")
    return OUTCOMES[cast("Outcome", outcome)], AMONG[cast("Among", among)]


def _table(found: Results) -> TextTable:
    """Every effect of one false report."""
    if not found.where(_EFFECT):
        return []
    head = ["agent", "outcome", "among", "effect, points", "P", "reports", "detectable effect (80 % power), points"]
    return [head] + [
        [
            found.label(row.agent, row.modality),
            *_words(row.of),
            bracketed(row.value, row.low, row.high),
            p_cell(row.p_value),
            str(row.n),
            f"{100 * (found.one(_DETECTABLE, agent=row.agent, modality=row.modality, of=row.of).value or 0.0):.0f}",
        ]
        for row in found.where(_EFFECT)
    ]


_TABLE = Table("lies", _table, numeric_from=3)


def _show(found: Results) -> Iterator[Part]:
    if found.where(_REPORTS):
        answer = found.answer_of(_NAME) or "Not estimated: too few trials."
        yield Part("Effect of one false report", answer, list(_blocks(found)))


def _blocks(found: Results) -> Iterator[Block]:
    for row in found.where(_REPORTS):
        yield Text(found.said(_NAME, "effect", agent=row.agent, modality=row.modality)[0])
    several = any(row.corrected_for > 1 for row in found.where(_EFFECT))
    note = Note(
        Markup(
            "Different effects inside and outside loops are no evidence for a mechanism: loops occur late, when few "
            "steps are left, and false reports can also break loops through what they say alone. <code>lockprobe run "
            "why</code> separates the mechanisms."
        ),
        Markup(
            "Effects are differences of probabilities in points, with the other reports at the flip rate of the study. "
            "<i>P</i> values are not corrected for the number of rows{}."
        ).format(", but like intervals for that of agents" if several else ""),
        "Each report was inverted at random with a known probability, so every report after which a trial continues is "
        "a small randomised experiment (causal excursion effect). Effects are least-squares estimates on the centred "
        "treatment, clustered by block.",
    )
    left_out = Template("effects_left_out", {"agents": list(_left_out(found))})
    if found.where(_EFFECT):
        yield Detail("All effects of one false report", [_TABLE, left_out, note])
    else:
        yield left_out


def _left_out(found: Results) -> Iterator[tuple[str, dict[str, dict[str, list[str]]]]]:
    """Every agent with effects that are not estimated: by the reason, then by the outcome, among which reports."""
    for row in found.where(_REPORTS):
        reasons: dict[str, dict[str, list[str]]] = {}
        for name, reason in found.facts_about(_about(row.agent, row.modality)).items():
            what, where = _words(name)
            reasons.setdefault(reason, {}).setdefault(what, []).append(where)
        if reasons:
            yield name_of(found, row.agent, row.modality), dict(sorted(reasons.items()))


SECTIONS = (Section(name=_NAME, title="Effect of one false report", rows=_rows, show=_show, tables=(_TABLE,)),)
