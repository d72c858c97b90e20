"""A study of flips as the numbers of ``results.json``; equal records give equal numbers."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

from lockprobe.analysis.response_times import response_times
from lockprobe.analysis.summary import StudySummary
from lockprobe.people.progress import flow_of
from lockprobe.people.step_times import times_of_steps
from lockprobe.prose.agent_comparison import comparison_said, ranking_said
from lockprobe.prose.hypothesis_tests import conclusions
from lockprobe.prose.loops import loop_finding
from lockprobe.prose.modalities import modality_finding
from lockprobe.prose.panel import panel_said
from lockprobe.prose.robot import verdicts_said
from lockprobe.prose.section_answers import section_answers
from lockprobe.prose.subject import subject_of
from lockprobe.prose.success import baselines_said, courses_said, finding
from lockprobe.report.claims import claim_rows
from lockprobe.report.examples import examples
from lockprobe.report.excursions import LieResult, lie_rows, lies_answer
from lockprobe.report.installed_measures import measure_rows
from lockprobe.report.leaderboard import comparison_rows, interaction_rows, leaderboard_rows
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.overview import flip_overview
from lockprobe.report.people import PeopleResult, people_row
from lockprobe.report.rows import (
    claim_row,
    condition_row,
    contrast_row,
    course_row,
    detector_row,
    fit_row,
    judged,
    modality_row,
    pace_row,
    rationality_rows,
    test_rows,
)
from lockprobe.report.sample_pictures import seen
from lockprobe.report.schema import RESULTS_VERSION, Results
from lockprobe.report.study_rows import (
    agent_facts,
    audit_result,
    broken_rows,
    left_out_row,
    plant_facts,
    rules_said_of,
    study_progress,
    tidied_rows,
)
from lockprobe.studies.results_hash import results_hash
from lockprobe.studies.study import Study

__all__ = ["flip_results"]


def flip_results(opened: OpenedStudy, summary: StudySummary) -> Results:
    """The results of a study of flips, and all that its pages are made from.

    Args:
        opened: The study.
        summary: The numbers of its trials.
    """
    study, trials, agents = opened.study, opened.trials, summary.agents
    names = {(agent.agent, agent.modality): agent.name for agent in agents}
    lies = lie_rows(trials, [(a.agent, a.modality, subject_of(a)) for a in summary.subjects if not a.blind])
    return Results(
        schema_version=RESULTS_VERSION,
        lockprobe=version("lockprobe"),
        study=dict(opened.settings),
        settings_hash=opened.study.settings_hash,
        results_hash=results_hash(opened.study, opened.trials),
        joints=len(opened.settings.get("box", {}).get("joints", [])),
        overview=flip_overview(summary, opened.settings),
        progress=study_progress(opened),
        left_out=left_out_row(trials, opened.journal, opened.foreign),
        panel_said=_panel(study),
        **_sentences(summary, lies),
        box=summary.reference,
        conditions=[condition_row(c, a.name, blind=a.blind) for a in agents for c in a.conditions],
        leaderboard=leaderboard_rows(summary, trials),
        comparisons=comparison_rows(summary.comparisons, names),
        interactions=interaction_rows(summary.comparisons, names),
        rationality=[row for a in agents for c in a.conditions for row in rationality_rows(c, a.name, blind=a.blind)],
        judged=judged(summary),
        lies=lies,
        paces=[pace_row(compared, names) for compared in summary.paces],
        modalities=[modality_row(effect) for effect in summary.modalities],
        people=_people(opened, summary),
        rules_said=rules_said_of(summary.conditions),
        verdicts=summary.verdicts,
        verdicts_said=verdicts_said(summary.verdicts) if summary.verdicts else "",
        fits=[fit_row(agent) for agent in agents],
        tests=[row for agent in agents if not agent.blind for row in test_rows(agent)],
        contrasts=[contrast_row(agent, agent.contrast) for agent in agents if agent.contrast],
        courses=[row for agent in agents if (row := course_row(agent))],
        claims=[claim_row(row) for row in claim_rows(summary)],
        detectors=[
            detector_row(condition, trials, agent.name)
            for agent in summary.subjects
            for condition in agent.conditions
            if condition.success.n
        ],
        examples=examples(summary, trials),
        measures=measure_rows(opened),
        errors=broken_rows(trials),
        tidied=tidied_rows(trials),
        agents=agent_facts(trials),
        plants=plant_facts(trials, opened.settings),
        seen=seen(trials),
        subjects=list(dict.fromkeys(agent.agent for agent in summary.subjects)),
        audit=audit_result(),
    )


def _people(opened: OpenedStudy, summary: StudySummary) -> PeopleResult | None:
    """What people did."""
    flow = flow_of(opened.diaries, opened.withdrawn)
    times = times_of_steps(opened.study, opened.trials, opened.diaries, opened.directory)
    return people_row(
        summary, opened.study.invited, opened.finished_by_people, flow, response_times(opened.trials, times)
    )


def _sentences(summary: StudySummary, lies: Sequence[LieResult]) -> dict[str, Any]:
    """What the results say in words."""
    return {
        "answers": section_answers(summary) | ({"lies": said} if (said := lies_answer(lies)) else {}),
        "modality_findings": [modality_finding(effect, summary) for effect in summary.modalities],
        "findings": [finding(agent) for agent in summary.subjects],
        "loop_findings": [loop_finding(agent) for agent in summary.subjects],
        "conclusions": [conclusions(agent) for agent in summary.subjects],
        "ranking_said": ranking_said(summary),
        "comparisons_said": [comparison_said(one, summary) for one in summary.comparisons],
        "beside": baselines_said(summary),
        "courses_said": courses_said(summary),
    }


def _panel(study: Study) -> str:
    """What pictures show of the panel, in words; empty without pictures."""
    if not study.has_pictures:
        return ""
    return panel_said(study.box, dealt=study.layout == "shuffled", listed_anew=study.shuffle)
