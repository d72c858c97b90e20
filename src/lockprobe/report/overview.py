"""The first screen of a report: its question, the answer in one sentence, one figure, and key numbers."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from lockprobe.agents.catalogue import description
from lockprobe.analysis.condition_study import ConditionStudySummary
from lockprobe.analysis.effects import Effects
from lockprobe.analysis.reference import Reference
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.analysis.why import Why
from lockprobe.formatting import NONE, bracketed, percent, share
from lockprobe.interventions.catalogue import TRUTH
from lockprobe.prose.both_answers import both_answers
from lockprobe.prose.doses import at_dose
from lockprobe.prose.idle import idle_doses_said, idle_said, unheeded_said
from lockprobe.prose.overview import (
    effects_answer,
    effects_needed,
    flips_answer,
    flips_needed,
    interaction_said,
    modality_answer,
    no_advantage_said,
    not_above_chance,
    smaller_budget_said,
    trial_said,
)
from lockprobe.prose.subject import Subject
from lockprobe.prose.why import mechanism_said
from lockprobe.report.described import DescribedResult
from lockprobe.studies.study import Study

__all__ = ["KeyNumbers", "Overview", "condition_overview", "flip_overview"]

_ROWS = 4
"""Agents whose numbers stand on the first screen."""


class KeyNumbers(DescribedResult):
    """The three numbers of one agent, as text with 95 % intervals."""

    agent: str
    what: str
    success: str
    where: str
    change: str
    against: str
    chance: str
    agents: int = 1


class Overview(DescribedResult):
    """The first screen of a report."""

    question: str = Field(description="What the study asks.")
    trial: str = Field(description="What happens in a trial, and what is varied.")
    answer: str = Field(description="What it found, in one sentence.")
    changed_nothing: str = Field(
        default="",
        description="Interventions that changed nothing in a whole condition, unless that is the answer, and "
        "conditions under which the only agent chose as under the control; empty if there are none.",
    )
    chance: str = Field(
        default="", description="Agents without a detected advantage over random agents; empty if there are none."
    )
    interaction: str = Field(
        default="",
        description="Whether a detected effect reverses within fewer steps, and whether it differs from one that "
        "was not detected; empty if neither applies.",
    )
    needed: str = Field(
        description="How many trials narrow the widest interval of an undetected effect to 10 points either way; empty "
        "if there is none."
    )
    figure: str = Field(description="Name of the figure that shows it; empty if there is none.")
    numbers: list[KeyNumbers]
    more: int = 0


def flip_overview(summary: StudySummary, study: Study) -> Overview:
    """The first screen of a study of flips or modalities."""
    box, several = study.box.name, len({one.p for one in summary.conditions}) > 1
    modal = bool(summary.modalities) and not several
    subjects = [agent for agent in summary.subjects if any(one.success.n for one in agent.conditions)]
    budget = study.max_steps
    if modal:
        question = f"Does what agents see change how they open {box}?"
        seeing = [one for one in summary.modalities if one.agent in {agent.agent for agent in subjects}]
        answer = " ".join(modality_answer(one, summary) for one in seeing[:1])
    elif several:
        question = f"Do false reports change how agents open {box}?"
        answer = ""
    else:
        question = f"How well do agents open {box}?"
        answer = ""
    return Overview(
        question=question,
        trial=trial_said(budget, "modalities" if modal else "flips", study.flip_kind),
        answer=answer or flips_answer(summary),
        changed_nothing=" ".join(filter(None, map(idle_doses_said, subjects))),
        chance=not_above_chance(summary),
        interaction=" ".join(filter(None, (smaller_budget_said(summary), interaction_said(summary)))),
        needed=flips_needed(summary),
        figure="overview" if subjects else "",
        numbers=[_numbers(agent, summary.reference) for agent in subjects[:_ROWS]],
        more=len(subjects) - len(subjects[:_ROWS]),
    )


def _numbers(agent: AgentSummary, reference: Reference | None) -> KeyNumbers:
    first, contrast = next(one for one in agent.conditions if one.success.n), agent.contrast
    found = first.success
    change, against = NONE, ""
    if agent.blind:
        change, against = "0", "plays alike"
    elif contrast is not None:
        gap = contrast.difference
        change = f"{bracketed(gap.value, gap.low, gap.high)} points"
        start = "change " if contrast.choices == 1 else ""
        which = "" if contrast.choices == 1 else f", {'largest' if contrast.farthest else 'clearest'} change"
        against = f"{start}from {agent.axis.name} {contrast.baseline.p:g} to {contrast.other.p:g}{which}"
        against += "" if contrast.whole else f", of {gap.first.n} trials finished under both"
    return KeyNumbers(
        agent=agent.name,
        what=description(agent.agent),
        success=share(found.value, found.low, found.high),
        where=f"of {found.n} trials solved {at_dose(first.p, agent.axis)}",
        change=change,
        against=against,
        chance=_chance(reference),
        agents=contrast.agents if contrast else 1,
    )


def _chance(reference: Reference | None) -> str:
    """What random agents solve of the box with and without immediate repeats, exact."""
    if reference is None:
        return NONE
    return f"{100 * reference.random[-1]:.0f} / {percent(reference.no_repeat[-1])}"


def condition_overview(flips: StudySummary, found: ConditionStudySummary, study: Study) -> Overview:
    """The first screen of a study with conditions beside flip rates, whose own first screen it adds to."""
    box, several = study.box.name, len({one.p for one in flips.conditions}) > 1
    effects = [one for one in found.effects if one.agent in found.subjects and one.effects]
    rows = [_condition_numbers(one, found.reference) for one in effects]
    first = flip_overview(flips, study) if several and not found.whys else None
    if found.whys:
        rows = [_why_numbers(one, found.reference) for one in found.whys]
        why = next((one for one in found.whys if one.agent in found.subjects), found.whys[0])
        question, answer = f"Why do false reports change how agents open {box}?", mechanism_said(why)
    elif first is not None:
        number = len(study.conditions) - len(study.flip_axis)
        question = f"Do false reports and {number} other condition{'s' * (number > 1)} change how agents open {box}?"
        answer = both_answers(flips, effects) if effects else first.answer
    else:
        question, answer = f"How do {len(study.conditions)} conditions affect success on {box}?", ""
    named = [one for one in found.idle if one.agent in found.subjects]
    idle = idle_said(named, found.subjects)
    if not effects and not answer and idle:
        answer, idle = idle[0], idle[1:]
    if len(found.subjects) == 1:
        idle += unheeded_said(found.unheeded, found.subjects)
    said = Overview(
        question=question,
        trial=trial_said(study.max_steps, "conditions"),
        answer=answer or effects_answer(effects, other=any(not one.intervention for one in named)),
        changed_nothing=" ".join(idle),
        chance=_no_advantage(found, effects),
        needed="" if found.whys else effects_needed(effects),
        figure="why" if found.whys else "effects" if rows else "",
        numbers=rows[:_ROWS],
        more=len(rows) - len(rows[:_ROWS]),
    )
    return said if first is None else _joined(first, said)


def _joined(flips: Overview, conditions: Overview) -> Overview:
    """One first screen: the question and the answer of both, the figure and the numbers of flip rates first."""
    texts = {
        name: " ".join(filter(None, (getattr(flips, name), getattr(conditions, name))))
        for name in ("changed_nothing", "needed")
    }
    return conditions.model_copy(
        update={
            **texts,
            "trial": f"{flips.trial} {conditions.trial.rpartition('. ')[2]}",
            "chance": flips.chance or conditions.chance,
            "interaction": flips.interaction,
            "figure": flips.figure or conditions.figure,
            "numbers": [*flips.numbers, *conditions.numbers],
            "more": flips.more + conditions.more,
        }
    )


def _no_advantage(found: ConditionStudySummary, effects: Sequence[Effects]) -> str:
    """Agents without a detected advantage over random agents under the first control."""
    if not effects:
        return ""
    control = effects[0].control
    agents = [one.agent for one in effects if one.control == control]
    shares = {Subject.of(agent).name: found.conditions[agent, control].success for agent in agents}
    return no_advantage_said(
        shares, at_dose(0) if control == TRUTH else f"under {control}", found.reference.no_repeat[-1]
    )


def _why_numbers(found: Why, reference: Reference) -> KeyNumbers:
    """Success under true reports, and the planned comparison with lies."""
    truth, change = next(one.success for one in found.arms if one.arm == "truth"), found.change
    return KeyNumbers(
        agent=found.agent,
        what=description(found.agent),
        success=share(truth.value, truth.low, truth.high),
        where=f"of {truth.n} trials solved under true reports",
        change=f"{bracketed(change.value, change.low, change.high)} points",
        against="change under false reports",
        chance=_chance(reference),
        agents=found.agents,
    )


def _condition_numbers(found: Effects, reference: Reference) -> KeyNumbers:
    """Success under the control, and the clearest effect: of equal P values, the largest."""
    clearest = min(found.effects, key=lambda one: (one.difference.p_value, -abs(one.difference.value)))
    gap = clearest.difference
    return KeyNumbers(
        agent=found.agent,
        what=description(found.agent),
        success=share(gap.first.value, gap.first.low, gap.first.high),
        where=f"of {gap.first.n} trials solved under {found.control}",
        change=f"{bracketed(gap.value, gap.low, gap.high)} points",
        against=f"{'clearest ' * (len(found.effects) > 1)}change under {clearest.condition}",
        chance=_chance(reference),
        agents=found.agents,
    )
