"""The effect of one false report: its rows of ``results.json`` and its table."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from lockprobe.analysis.excursion import Excursion, decision_points, excursions
from lockprobe.formatting import bracketed, first_three, p_cell
from lockprobe.prose.excursion import among_said, excursion_said, outcome_said
from lockprobe.prose.subject import Subject
from lockprobe.record import Trial
from lockprobe.report.described import Change, Counted, DescribedResult, Share, filled
from lockprobe.report.format import TextTable

__all__ = ["ExcursionResult", "LieResult", "NotEstimatedResult", "excursion_table", "lie_rows", "lies_answer"]


class ExcursionResult(DescribedResult):
    """The effect of one false report on one outcome."""

    outcome: str = Field(description="repeats, new, leaves, optimal, soon or solved.")
    among: str = Field(description="all, false moved, false blocked, in a loop or elsewhere.")
    what: str
    where: str
    effect: Change = Field(description="Change of the probability of the outcome.")
    low: Change = Field(description="Lower end of its 95 % interval, corrected for agents.")
    high: Change = Field(description="Upper end.")
    p_value: Share = Field(description="Student's t over clusters of luck, corrected for agents alone.")
    points: Counted = Field(description="Decision points: reports after which the trial went on.")
    clusters: Counted = Field(description="Clusters of luck.")
    smallest: float = Field(description="The effect that is detected with a power of 80 %.")


class NotEstimatedResult(DescribedResult):
    """An effect of one false report that cannot be estimated."""

    outcome: str = Field(description="repeats, new, leaves, optimal, soon or solved.")
    among: str = Field(description="all, false moved, false blocked, in a loop or elsewhere.")
    what: str
    where: str
    reason: str = Field(description="Why there is no estimate.")


class LieResult(DescribedResult):
    """The effects of one false report on one agent."""

    agent: str = Field(description="Agent spec.")
    modality: str = Field(description="How the box was shown.")
    said: str = Field(description="The effect on success, in a sentence.")
    effects: list[ExcursionResult] = Field(description="Every effect that can be estimated.")
    left_out: list[NotEstimatedResult] = Field(description="The others, each with its reason.")
    agents: Counted = Field(description="Agents that are judged together.")


def lie_rows(trials: Sequence[Trial], subjects: Sequence[tuple[str, str, Subject]]) -> list[LieResult]:
    """The effects of one false report, for every agent with trials at a flip rate above 0 and below 1.

    Agents are one family: their P values and intervals are corrected for the number of those with an estimate.

    Args:
        trials: Trials of a flip study.
        subjects: Agent, modality and the subject of the sentence.
    """
    there = {
        (agent, modality): decision_points(t for t in trials if (t.group, t.modality) == (agent, modality))
        for agent, modality, _ in subjects
    }
    alone = {who: excursions(points) for who, points in there.items() if len(points)}
    agents = max(1, sum(bool(effects.estimates) for effects in alone.values()))
    found = {who: effects if agents == 1 else excursions(there[who], agents) for who, effects in alone.items()}
    return [
        LieResult(
            agent=agent,
            modality=modality,
            said=excursion_said(effects, subject),
            effects=[_row(one) for one in effects.estimates],
            left_out=[
                filled(NotEstimatedResult, one, what=outcome_said(one.outcome), where=among_said(one.among))
                for one in effects.left_out
            ],
            agents=effects.agents,
        )
        for agent, modality, subject in subjects
        if (effects := found.get((agent, modality)))
    ]


def lies_answer(rows: Sequence[LieResult]) -> str:
    """The effect of one more false report on the success of the first agents; empty without estimates."""
    parts = [
        f"{bracketed(one.effect, one.low, one.high)} {row.agent}"
        for row in rows
        for one in row.effects
        if (one.outcome, one.among) == ("solved", "all")
    ]
    return f"Success after one more false report, in points: {first_three(parts, '; ')}." if parts else ""


def _row(one: Excursion) -> ExcursionResult:
    return filled(ExcursionResult, one, what=outcome_said(one.outcome), where=among_said(one.among))


def excursion_table(rows: Sequence[LieResult]) -> TextTable:
    """Every effect of one false report."""
    head = ["agent", "outcome", "among", "effect, points", "P", "reports", "detectable effect (80 % power), points"]
    return [head] + [
        [
            row.agent,
            one.what,
            one.where,
            bracketed(one.effect, one.low, one.high),
            p_cell(one.p_value),
            str(one.points),
            f"{100 * one.smallest:.0f}",
        ]
        for row in rows
        for one in row.effects
    ]
