"""The numbers over a study's flip rates, in the parts of ``results.json``; equal records give equal numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.analysis.outcomes import ended
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
from lockprobe.record import Trial
from lockprobe.report.assembled import Part
from lockprobe.report.claims import claim_rows
from lockprobe.report.details import DetectorResult, RationalityResult
from lockprobe.report.examples import ExampleTrial, examples
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
from lockprobe.report.schema import FlipDesign
from lockprobe.report.study_rows import (
    agent_facts,
    audit_result,
    broken_rows,
    left_out_row,
    not_judged_of,
    plant_facts,
    rules_said_of,
    tidied_rows,
)
from lockprobe.sections import section
from lockprobe.studies.study import Study

__all__ = ["detectors_of", "flip_design", "flip_examples", "flip_parts", "rationality_of"]


def flip_parts(opened: OpenedStudy, summary: StudySummary) -> dict[str, Part]:
    """What the results of every study hold: the numbers over its flip rates, with their sentences.

    Args:
        opened: The study.
        summary: The numbers of its flip axis.
    """
    study, trials, agents = opened.study, opened.trials, summary.agents
    names = {(agent.agent, agent.modality): agent.name for agent in agents}
    flips = opened.flip_trials
    lies = section("Effect of one false report", lambda: _lies(summary, flips), list[LieResult])
    return {
        "overview": ("First screen", lambda: flip_overview(summary, opened.study)),
        "left_out": ("Trials left out", lambda: left_out_row(trials, opened.journal, opened.foreign)),
        "panel_said": ("Panel", lambda: _panel(study)),
        **_sentences(summary, lies),
        **_success(summary, opened, names),
        **_behaviour(summary, flips),
        "people": ("People", lambda: _people(opened, summary)),
        "verdicts_said": (
            "Verdicts of the robot",
            lambda: verdicts_said(summary.verdicts) if summary.verdicts else "",
        ),
        "lies": ("Effect of one false report", lambda: lies),
        "examples": ("Examples", lambda: flip_examples(opened, summary)),
        "rules_said": ("Attempts against the rules", lambda: rules_said_of(summary.conditions)),
        "not_judged": ("Attempts against the rules", lambda: not_judged_of(summary.conditions)),
        "measures": ("Measures of installed packages", lambda: measure_rows(opened)),
        "errors": ("Trials that broke", lambda: broken_rows(trials)),
        "tidied": ("Tidied replies", lambda: tidied_rows(trials)),
        "agents": ("Agents", lambda: agent_facts(trials)),
        "plants": ("Plant", lambda: plant_facts(trials, opened.settings)),
        "seen": ("What agents saw", lambda: seen(trials)),
        "audit": ("Error rates of the tests", audit_result),
    }


def _success(summary: StudySummary, opened: OpenedStudy, names: Mapping[tuple[str, str], str]) -> dict[str, Part]:
    """What the results say of success, by agent and condition, and how agents compare."""
    agents = summary.agents
    return {
        "conditions": (
            "All conditions",
            lambda: [condition_row(c, a.name, blind=a.blind) for a in agents for c in a.conditions],
        ),
        "leaderboard": ("Leaderboard", lambda: leaderboard_rows(summary, opened.flip_trials, opened.prices)),
        "comparisons": ("Agents compared", lambda: comparison_rows(summary.comparisons, names)),
        "interactions": ("Interactions", lambda: interaction_rows(summary.comparisons, names)),
        "paces": ("Speed of every two agents", lambda: [pace_row(compared, names) for compared in summary.paces]),
        "modalities": ("Modalities", lambda: [modality_row(effect) for effect in summary.modalities]),
        "fits": ("Fits", lambda: [fit_row(agent) for agent in agents]),
        "tests": (
            "Hypothesis tests",
            lambda: [row for agent in agents if not agent.blind for row in test_rows(agent)],
        ),
        "contrasts": (
            "Success and false reports",
            lambda: [contrast_row(agent, agent.contrast) for agent in agents if agent.contrast],
        ),
        "courses": ("Courses of success", lambda: [row for agent in agents if (row := course_row(agent))]),
        "claims": ("The paper's claims", lambda: [claim_row(row) for row in claim_rows(summary)]),
    }


def _behaviour(summary: StudySummary, trials: Sequence[Trial]) -> dict[str, Part]:
    """What the results say of how agents act."""
    return {
        "rationality": ("Rationality", lambda: rationality_of(summary)),
        "judged": ("Rationality", lambda: judged(summary)),
        "detectors": ("Other loop detectors", lambda: detectors_of(summary, trials)),
    }


def flip_examples(opened: OpenedStudy, summary: StudySummary) -> list[ExampleTrial]:
    """Examples under flip rates."""
    return examples(summary, opened.flip_trials)


def rationality_of(summary: StudySummary) -> list[RationalityResult]:
    """The actions of all agents under all flip rates before each ideal observer."""
    return [
        row
        for agent in summary.agents
        for condition in agent.conditions
        for row in rationality_rows(condition, agent.name, blind=agent.blind)
    ]


def detectors_of(summary: StudySummary, trials: Sequence[Trial]) -> list[DetectorResult]:
    """The trials that each loop detector flags, of the agents that the study is about."""
    return [
        detector_row(condition, trials, agent.name)
        for agent in summary.subjects
        for condition in agent.conditions
        if condition.success.n
    ]


def _lies(summary: StudySummary, trials: Sequence[Trial]) -> list[LieResult]:
    """The effects of one false report on the agents that heed reports."""
    return lie_rows(trials, [(a.agent, a.modality, subject_of(a)) for a in summary.subjects if not a.blind])


def flip_design(study: Study) -> FlipDesign:
    """What the conditions of a flip study vary."""
    return FlipDesign(p=list(study.p), kind=study.flip_kind, modalities=list(study.modalities))


def _people(opened: OpenedStudy, summary: StudySummary) -> PeopleResult | None:
    """What people did."""
    flow = flow_of(opened.study, opened.diaries, opened.withdrawn)
    times = times_of_steps(opened.study, opened.trials, opened.diaries, opened.directory)
    on_axis = opened.flip_trials
    theirs = [sum(bool(trial.player) for trial in ended(trials)) for trials in (opened.trials, on_axis)]
    return people_row(
        summary,
        opened.study.invited,
        opened.finished_by_people,
        flow,
        response_times(on_axis, times),
        theirs[0] - theirs[1],
    )


def _sentences(summary: StudySummary, lies: Sequence[LieResult]) -> dict[str, Part]:
    """What the results say in words."""
    return {
        "answers": ("Answers of the sections", lambda: _answers(summary, lies)),
        "modality_findings": (
            "Findings on modalities",
            lambda: [modality_finding(effect, summary) for effect in summary.modalities],
        ),
        "findings": ("Findings", lambda: [finding(agent) for agent in summary.subjects]),
        "loop_findings": ("Findings on loops", lambda: [loop_finding(agent) for agent in summary.subjects]),
        "conclusions": ("Conclusions of the tests", lambda: [conclusions(agent) for agent in summary.subjects]),
        "ranking_said": ("Ranking", lambda: ranking_said(summary)),
        "comparisons_said": (
            "Agents compared",
            lambda: [comparison_said(one, summary) for one in summary.comparisons],
        ),
        "beside": ("Baselines", lambda: baselines_said(summary)),
        "courses_said": ("Courses of success", lambda: courses_said(summary)),
    }


def _answers(summary: StudySummary, lies: Sequence[LieResult]) -> dict[str, str]:
    return section_answers(summary) | ({"lies": said} if (said := lies_answer(lies)) else {})


def _panel(study: Study) -> str:
    """What pictures show of the panel, in words; empty without pictures."""
    if not study.has_pictures:
        return ""
    return panel_said(study.box, dealt=study.layout == "shuffled", listed_anew=study.shuffle)
