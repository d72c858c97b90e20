"""A study of any conditions as the numbers of ``results.json``: each against the control, crossed ones, and doses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib.metadata import version

from lockprobe.analysis.condition import ConditionSummary
from lockprobe.analysis.condition_study import ConditionStudySummary
from lockprobe.analysis.effects import Effects
from lockprobe.analysis.series import Series, SeriesArm
from lockprobe.analysis.summary import StudySummary
from lockprobe.interventions.condition import Condition, modality_doses
from lockprobe.prose.effects import effects_said
from lockprobe.prose.hypothesis_tests import conclusions
from lockprobe.prose.idle import idle_said, unheeded_said
from lockprobe.prose.loops import loop_finding
from lockprobe.prose.success import courses_said, finding
from lockprobe.record import Trial
from lockprobe.report.assembled import Part, assembled
from lockprobe.report.described import filled
from lockprobe.report.dose_grids import grid_rows
from lockprobe.report.examples import ExampleTrial, example, told_twice
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.overview import condition_overview
from lockprobe.report.rows import condition_row, contrast_row, course_row, fit_row, test_rows
from lockprobe.report.sample_pictures import seen
from lockprobe.report.schema import (
    RESULTS_VERSION,
    ConditionResult,
    CrossingResult,
    EffectResult,
    Results,
    SeriesResult,
)
from lockprobe.report.study_rows import (
    agent_facts,
    audit_result,
    broken_rows,
    left_out_row,
    not_judged_of,
    plant_facts,
    rules_said_of,
    study_progress,
    tidied_rows,
)
from lockprobe.report.why import WhyResult, why_row
from lockprobe.spec import Spec, spec_name
from lockprobe.studies.results_hash import results_hash
from lockprobe.studies.study import Study

__all__ = ["arms_of", "condition_results"]

_EXAMPLES = 6
"""Trials that are told step by step, of different conditions."""


def arms_of(conditions: Iterable[Condition]) -> tuple[SeriesArm, ...]:
    """Conditions as their specs tell them."""
    return tuple(map(_arm, conditions))


def _arm(condition: Condition) -> SeriesArm:
    """A condition as its specs tell it; the doses of pictures stand among those of interventions."""
    shown, doses = modality_doses(condition.modality)
    pictured = (Spec(spec_name(shown), options={option: value}) for option, value in doses.items())
    return SeriesArm(
        label=condition.label,
        specs=(*map(Spec.parse, condition.specs), *pictured),
        doses=(*condition.doses, *doses),
        modality=shown,
    )


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


def condition_results(opened: OpenedStudy, found: ConditionStudySummary) -> Results:
    """The results of a study of conditions, and all that its page is made from.

    Args:
        opened: The study.
        found: The numbers of its trials.
    """
    study = opened.study
    said = {arm.label: " + ".join(map(str, arm.specs)) for arm in found.arms}
    everything: dict[str, Part] = {
        "overview": ("First screen", lambda: condition_overview(found, opened.settings)),
        "left_out": ("Trials left out", lambda: left_out_row(opened.trials, opened.journal, opened.foreign)),
        "findings": ("Findings", lambda: _findings(found)),
        "conditions": (
            "All conditions",
            lambda: [
                _condition_row(study, agent, label, summary, said[label])
                for (agent, label), summary in found.conditions.items()
            ],
        ),
        "effects": (
            "Every condition against the control",
            lambda: [row for one in found.effects for row in _effect_rows(one)],
        ),
        "crossings": (
            "Interactions of interventions",
            lambda: [row for one in found.effects for row in _interplay_rows(one)],
        ),
        "grids": ("Interactions of doses", lambda: [row for one in found.effects for row in grid_rows(one)]),
        "series": ("Doses", lambda: [_series_row(series, summary) for series, summary in found.series]),
        "why": ("Why false reports change success", lambda: _why_rows(found, opened.trials)),
        "rules_said": ("Attempts against the rules", lambda: rules_said_of(found.conditions.values())),
        "not_judged": ("Attempts against the rules", lambda: not_judged_of(found.conditions.values())),
        "measures": ("Measures of installed packages", lambda: measure_rows(opened)),
        "errors": ("Trials that broke", lambda: broken_rows(opened.trials)),
        "tidied": ("Tidied replies", lambda: tidied_rows(opened.trials)),
        "agents": ("Agents", lambda: agent_facts(opened.trials)),
        "plants": ("Plant", lambda: plant_facts(opened.trials, opened.settings)),
        "seen": ("What agents saw", lambda: seen(opened.trials)),
        "examples": ("Examples", lambda: _examples(found.subjects[0], opened.trials)),
        "audit": ("Error rates of the tests", audit_result),
    }
    return assembled(
        everything,
        schema_version=RESULTS_VERSION,
        lockprobe=version("lockprobe"),
        study=dict(opened.settings),
        settings_hash=opened.study.settings_hash,
        results_hash=results_hash(opened.study, opened.trials),
        joints=len(study.box.joints),
        progress=study_progress(opened),
        subjects=list(found.subjects),
        box=found.reference,
    )


def _findings(found: ConditionStudySummary) -> list[str]:
    """What changed nothing, for baselines too, and the effects of what did on the agents that the study is about."""
    effects = [one for one in found.effects if one.agent in found.subjects]
    return [
        *idle_said(found.idle, found.agents),
        *unheeded_said(found.unheeded, found.subjects),
        *(sentence for one in effects for sentence in effects_said(one, found.conditions)),
    ]


def _condition_row(study: Study, agent: str, label: str, summary: ConditionSummary, acts: str) -> ConditionResult:
    """The numbers of one agent under one condition; a flip rate stands only where nothing but flips acted."""
    p = next(one.p for one in study.conditions if one.label == label)
    row = condition_row(summary, agent)
    repetitions = [replace(point, p=p) for point in row.repetitions]
    return row.model_copy(update={"p": p, "repetitions": repetitions, "acts": acts})


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


def _examples(agent: str, trials: Sequence[Trial]) -> list[ExampleTrial]:
    """The first ended trial of an agent under each of the first conditions."""
    found: dict[str, Trial] = {}
    for trial in trials:
        if trial.group == agent and trial.ending != "error":
            found.setdefault(trial.condition, trial)
    return [example(label, trial) for label, trial in list(found.items())[:_EXAMPLES]]
