"""A study of any conditions as the numbers of ``results.json``: each against the control, crossed ones, and doses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from operator import call

from lockprobe.analysis.condition import ConditionSummary, condition_summary
from lockprobe.analysis.dose_grid import grids
from lockprobe.analysis.effects import Effects, effects
from lockprobe.analysis.reference import Reference, reference_of
from lockprobe.analysis.series import Series, SeriesArm, control_of, crossings, series_of, series_of_agents
from lockprobe.analysis.summary import StudySummary, is_reference, summarise
from lockprobe.analysis.why import Why, why
from lockprobe.interventions.condition import Condition, modality_doses
from lockprobe.parallel import Each
from lockprobe.prose.effects import effects_said
from lockprobe.prose.hypothesis_tests import conclusions
from lockprobe.prose.loops import loop_finding
from lockprobe.prose.success import courses_said, finding
from lockprobe.record import Trial
from lockprobe.report.described import filled
from lockprobe.report.dose_grids import grid_rows
from lockprobe.report.examples import ExampleTrial, example, told_twice
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.overview import condition_overview
from lockprobe.report.results import (
    RESULTS_VERSION,
    agent_facts,
    audit_result,
    broken_rows,
    left_out_row,
    plant_facts,
)
from lockprobe.report.rows import condition_row, contrast_row, course_row, fit_row, test_rows
from lockprobe.report.sample_pictures import seen
from lockprobe.report.schema import (
    ConditionResult,
    CrossingResult,
    EffectResult,
    Results,
    SeriesResult,
    StudyProgress,
)
from lockprobe.report.why import WhyResult, why_row
from lockprobe.spec import Spec, spec_name
from lockprobe.studies.study import Study

__all__ = ["ConditionStudy", "condition_results", "condition_study"]

_EXAMPLES = 6
"""Trials that are told step by step, of different conditions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionStudy:
    """A study of conditions and its numbers.

    Attributes:
        opened: What its directory holds.
        arms: Its conditions as their specs tell them.
        conditions: Every agent under every condition -> its numbers, under (agent, condition).
        effects: Every agent's conditions against their control.
        series: Conditions that differ in one dose alone, each with the numbers over that dose.
        whys: Of a study of controls: why false reports change each agent's success.
        reference: What blind agents and the shortest plan reach on the box.
    """

    opened: OpenedStudy
    arms: tuple[SeriesArm, ...]
    conditions: Mapping[tuple[str, str], ConditionSummary]
    effects: tuple[Effects, ...]
    series: tuple[tuple[Series, StudySummary], ...]
    whys: tuple[Why, ...]
    reference: Reference

    @property
    def subjects(self) -> tuple[str, ...]:
        """The agents that the study is about: those that are no reference, or all if all are."""
        agents = self.opened.study.agents
        return tuple(agent for agent in agents if not is_reference(agent)) or agents


def condition_study(opened: OpenedStudy, *, each: Each = map) -> ConditionStudy:
    """Summarise a study of conditions.

    Args:
        opened: The study.
        each: Works on one agent after the other, or on several at once.
    """
    study, trials = opened.study, opened.trials
    arms = tuple(map(_arm, study.conditions))
    reference = reference_of(study.box, study.max_steps)
    cells = _cells(trials)
    jobs = [partial(condition_summary, members, reference) for members in cells.values()]
    return ConditionStudy(
        opened=opened,
        arms=arms,
        conditions=dict(zip(cells, each(call, jobs), strict=True)),
        effects=_effects(cells, arms, study),
        series=_series(trials, arms, study, each),
        whys=_whys(cells, arms, study),
        reference=reference,
    )


def _arm(condition: Condition) -> SeriesArm:
    """A condition as its specs tell it; the doses of pictures stand among those of interventions."""
    shown, doses = modality_doses(condition.modality)
    pictured = tuple(str(Spec(spec_name(shown), options={option: value})) for option, value in doses.items())
    return SeriesArm(
        label=condition.label,
        specs=(*condition.specs, *pictured),
        doses=(*condition.doses, *doses),
        modality=shown,
    )


def _cells(trials: Sequence[Trial]) -> dict[tuple[str, str], list[Trial]]:
    """The trials of every agent under every condition, without a place on an axis."""
    cells: dict[tuple[str, str], list[Trial]] = {}
    for trial in trials:
        cells.setdefault((trial.group, trial.condition), []).append(replace(trial, placed=0.0))
    return cells


def _effects(
    cells: Mapping[tuple[str, str], list[Trial]], arms: Sequence[SeriesArm], study: Study
) -> tuple[Effects, ...]:
    """Each modality's conditions against its control; the first modality is also compared with the others' controls."""
    found = []
    modalities = list(dict.fromkeys(arm.modality for arm in arms))
    others = [control_of(arms, modality) for modality in modalities[1:]]
    for agent in study.agents:
        for modality in modalities:
            beside = others if modality == modalities[0] else []
            own = {
                arm.label: cells[agent, arm.label]
                for arm in arms
                if (arm.modality == modality or arm in beside) and (agent, arm.label) in cells
            }
            control = control_of(arms, modality)
            shown = [arm for arm in arms if arm.modality == modality]
            if control is not None and (one := effects(own, control.label, crossings(shown), grids(shown))):
                found.append(one)
    return tuple(found)


def _whys(cells: Mapping[tuple[str, str], list[Trial]], arms: Sequence[SeriesArm], study: Study) -> tuple[Why, ...]:
    """Why false reports change each agent's success, in each modality that has the arms for it."""
    found = []
    for agent in study.agents:
        for modality in dict.fromkeys(arm.modality for arm in arms):
            shown = [arm for arm in arms if arm.modality == modality]
            own = {arm.label: cells[agent, arm.label] for arm in shown if (agent, arm.label) in cells}
            if one := why(own, shown):
                found.append(one)
    return tuple(found)


def _why_rows(study: ConditionStudy) -> list[WhyResult]:
    rows = []
    for one in study.whys:
        own: dict[str, list[Trial]] = {arm.arm: [] for arm in one.arms}
        names = {arm.condition: arm.arm for arm in one.arms}
        for trial in study.opened.trials:
            if (trial.group, trial.modality) == (one.agent, one.modality) and trial.condition in names:
                own[names[trial.condition]].append(trial)
        rows.append(why_row(one, told_twice(own["truth"], own["lie"], rises=one.change.value > 0)))
    return rows


def _series(
    trials: Sequence[Trial], arms: Sequence[SeriesArm], study: Study, each: Each
) -> tuple[tuple[Series, StudySummary], ...]:
    found = []
    for series in series_of(arms):
        placed = [
            replace(trial, placed=series.doses[trial.condition], modality=series.modality)
            for trial in trials
            if trial.condition in series.doses
        ]
        if placed:
            found.append((series, summarise(placed, study.box, each=each, axis=series.axis)))
    control = control_of(arms, arms[0].modality)
    for series in series_of_agents(study.agents):
        placed = [
            replace(trial, agent=series.agent, placed=series.doses[trial.agent])
            for trial in trials
            if trial.agent in series.doses and control is not None and trial.condition == control.label
        ]
        if placed:
            found.append((series, summarise(placed, study.box, each=each, axis=series.axis)))
    return tuple(found)


def condition_results(study: ConditionStudy) -> Results:
    """The results of a study of conditions, and all that its page is made from."""
    opened, asked = study.opened, study.opened.study
    said = {arm.label: " + ".join(arm.specs) for arm in study.arms}
    return Results(
        schema_version=RESULTS_VERSION,
        lockprobe=version("lockprobe"),
        study=dict(opened.settings),
        joints=len(asked.box.joints),
        overview=condition_overview(
            [one for one in study.effects if one.agent in study.subjects], study.whys, opened.settings, study.reference
        ),
        progress=StudyProgress(
            planned=asked.size,
            finished=opened.finished,
            partial=opened.finished < asked.size,
        ),
        left_out=left_out_row(opened.trials, opened.journal, opened.foreign),
        subjects=list(study.subjects),
        findings=[
            sentence
            for one in study.effects
            if one.agent in study.subjects
            for sentence in effects_said(one, study.conditions)
        ],
        conditions=[
            _condition_row(asked, agent, label, summary, said[label])
            for (agent, label), summary in study.conditions.items()
        ],
        effects=[row for one in study.effects for row in _effect_rows(one)],
        crossings=[row for one in study.effects for row in _interplay_rows(one)],
        grids=[row for one in study.effects for row in grid_rows(one)],
        series=[_series_row(series, summary) for series, summary in study.series],
        why=_why_rows(study),
        box=study.reference,
        measures=measure_rows(opened.trials),
        errors=broken_rows(opened.trials),
        agents=agent_facts(opened.trials),
        plants=plant_facts(opened.trials, opened.settings),
        seen=seen(opened.trials),
        examples=_examples(study),
        audit=audit_result(),
    )


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


def _examples(study: ConditionStudy) -> list[ExampleTrial]:
    """The first ended trial of the first subject under each of the first conditions."""
    agent = study.subjects[0]
    found: dict[str, Trial] = {}
    for trial in study.opened.trials:
        if trial.group == agent and trial.ending != "error":
            found.setdefault(trial.condition, trial)
    return [example(label, trial) for label, trial in list(found.items())[:_EXAMPLES]]
