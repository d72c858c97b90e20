"""What conditions beside flip rates add to ``results.json``: each against the control, crossed ones, and doses."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import product

from lockprobe.analysis.condition_study import ConditionStudySummary
from lockprobe.analysis.effects import Effects
from lockprobe.analysis.series import Series
from lockprobe.analysis.summary import StudySummary
from lockprobe.prose.effects import effects_said
from lockprobe.prose.hypothesis_tests import conclusions
from lockprobe.prose.idle import idle_said, unheeded_said
from lockprobe.prose.loops import loop_finding
from lockprobe.prose.success import courses_said, finding
from lockprobe.record import Trial
from lockprobe.report.assembled import Part
from lockprobe.report.described import filled
from lockprobe.report.dose_grids import grid_rows
from lockprobe.report.examples import ExampleTrial, example, told_twice
from lockprobe.report.flip_results import detectors_of, flip_examples, rationality_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.overview import condition_overview
from lockprobe.report.rows import (
    condition_row,
    contrast_row,
    course_row,
    detector_row,
    fit_row,
    rationality_rows,
    test_rows,
)
from lockprobe.report.schema import ConditionResult, CrossingResult, EffectResult, SeriesResult
from lockprobe.report.study_rows import not_judged_of, rules_said_of
from lockprobe.report.why import WhyResult, why_row
from lockprobe.studies.study import Study

__all__ = ["condition_parts"]

_ON_FLIPS = ("findings", "loop_findings", "conclusions")
"""Sentences on the flip rates, of which a study with the truth alone has none."""

_EXAMPLES = 6
"""Trials that are told step by step, of different conditions."""


def _why_rows(found: ConditionStudySummary, trials: Sequence[Trial]) -> list[WhyResult]:
    rows = []
    for one in found.whys:
        own: dict[str, list[Trial]] = {arm.arm: [] for arm in one.arms}
        names = {arm.condition: arm.arm for arm in one.arms}
        for trial in trials:
            if (trial.group, trial.modality) == (one.agent, one.modality) and trial.condition in names:
                own[names[trial.condition]].append(trial)
        rows.append(why_row(one, told_twice(own["truth"], own["lie"], rises=one.change.value > 0)))
    return rows


def condition_parts(opened: OpenedStudy, flips: StudySummary, found: ConditionStudySummary) -> dict[str, Part]:
    """What conditions beside flip rates add to the results, under the names of the results' fields.

    Args:
        opened: The study.
        flips: The numbers of its flip axis.
        found: The numbers of its other conditions.
    """
    study, trials = opened.study, opened.trials
    rates = study.flip_labels
    others = [one for (_, label), one in found.conditions.items() if label not in rates]
    alone = {} if len({one.p for one in flips.conditions}) > 1 else dict.fromkeys(_ON_FLIPS, ("Findings", list[str]))
    return alone | {
        "overview": ("First screen", lambda: condition_overview(flips, found, study)),
        "condition_findings": ("Findings on conditions", lambda: _findings(found)),
        "conditions": ("All conditions", lambda: _condition_rows(study, flips, found)),
        "effects": (
            "Every condition against the control",
            lambda: [
                row
                for one in sorted((*found.axis, *found.effects), key=lambda one: study.agents.index(one.agent))
                for row in _effect_rows(one)
            ],
        ),
        "crossings": (
            "Interactions of interventions",
            lambda: [row for one in found.effects for row in _interplay_rows(one)],
        ),
        "grids": ("Interactions of doses", lambda: [row for one in found.effects for row in grid_rows(one)]),
        "series": ("Doses", lambda: [_series_row(series, summary) for series, summary in found.series]),
        "why": ("Why false reports change success", lambda: _why_rows(found, trials)),
        "rules_said": ("Attempts against the rules", lambda: rules_said_of(found.conditions.values())),
        "not_judged": ("Attempts against the rules", lambda: not_judged_of(found.conditions.values())),
        "rationality": (
            "Rationality",
            lambda: [*rationality_of(flips), *(row for one in others for row in rationality_rows(one, one.agent))],
        ),
        "detectors": (
            "Other loop detectors",
            lambda: [
                *detectors_of(flips, trials),
                *(
                    detector_row(one, trials, one.agent)
                    for one in others
                    if one.agent in found.subjects and one.success.n
                ),
            ],
        ),
        "examples": (
            "Examples",
            lambda: [*flip_examples(opened, flips), *_examples(found.subjects[0], trials, rates)],
        ),
    }


def _condition_rows(study: Study, flips: StudySummary, found: ConditionStudySummary) -> list[ConditionResult]:
    """Every agent under every condition, in the order of the study; those of the flip axis as it has them."""
    said = {arm.label: " + ".join(map(str, arm.specs)) for arm in found.design.arms}
    axis = {
        (one.agent, one.name): condition_row(one, of.name, blind=of.blind)
        for of in flips.agents
        for one in of.conditions
    }
    rows = []
    for agent, label in product(study.agents, [one.label for one in study.conditions]):
        if (summary := found.conditions.get((agent, label))) is not None:
            row = axis.get((agent, label)) or _without_place(condition_row(summary, agent), study.labelled(label).p)
            rows.append(row.model_copy(update={"acts": said[label]}))
    return rows


def _without_place(row: ConditionResult, p: float | None) -> ConditionResult:
    """The numbers of a condition beside the axis; it has a flip rate only if nothing but flips acted."""
    repetitions = [replace(point, p=p) for point in row.repetitions]
    return row.model_copy(update={"p": p, "repetitions": repetitions})


def _findings(found: ConditionStudySummary) -> list[str]:
    """What changed nothing, for baselines too, and the effects of what did on the agents that the study is about."""
    effects = [one for one in found.effects if one.agent in found.subjects]
    return [
        *idle_said(found.idle, found.agents),
        *unheeded_said(found.unheeded, found.subjects),
        *(sentence for one in effects for sentence in effects_said(one, found.conditions)),
    ]


def _effect_rows(found: Effects) -> list[EffectResult]:
    return [
        filled(
            EffectResult,
            found,
            one,
            one.difference,
            trials=one.difference.first.n,
            control_solved=one.difference.first.count,
            solved=one.difference.second.count,
            difference=one.difference.value,
            difference_low=one.difference.low,
            difference_high=one.difference.high,
            corrected_for=len(found.effects),
            agents=found.agents,
        )
        for one in found.effects
    ]


def _interplay_rows(found: Effects) -> list[CrossingResult]:
    return [
        filled(
            CrossingResult,
            found,
            one.crossing,
            one,
            one.change,
            trials=one.change.pairs,
            corrected_for=one.choices,
            difference=one.change.value,
            difference_low=one.change.low,
            difference_high=one.change.high,
        )
        for one in found.interplays
    ]


def _series_row(series: Series, summary: StudySummary) -> SeriesResult:
    """The numbers over one dose; sentences name it."""
    agents = summary.agents
    return filled(
        SeriesResult,
        series.axis,
        series,
        intervention=series.axis.kind,
        conditions=dict(series.doses),
        findings=[finding(agent) for agent in summary.subjects],
        loop_findings=[loop_finding(agent) for agent in summary.subjects],
        conclusions=[conclusions(agent) for agent in summary.subjects],
        courses_said=courses_said(summary),
        fits=[fit_row(agent) for agent in agents],
        tests=[row for agent in agents if not agent.blind for row in test_rows(agent)],
        contrasts=[contrast_row(agent, agent.contrast) for agent in agents if agent.contrast],
        courses=[row for agent in agents if (row := course_row(agent))],
    )


def _examples(agent: str, trials: Sequence[Trial], known: Collection[str]) -> list[ExampleTrial]:
    """The first ended trial of an agent under each of the first conditions, except those that are known."""
    found: dict[str, Trial] = {}
    for trial in trials:
        if trial.group == agent and trial.ending != "error" and trial.condition not in known:
            found.setdefault(trial.condition, trial)
    return [example(label, trial) for label, trial in list(found.items())[:_EXAMPLES]]
