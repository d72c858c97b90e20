"""Agents that an unfinished study is about and that have too few trials for an answer: the first screen names them."""

from __future__ import annotations

from collections.abc import Container, Mapping

from lockprobe.report.prose.several_answers import Question, of_axis
from lockprobe.report.prose.too_few_trials import finished_said, of_baselines, too_few_said
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.summary import StudySummary


def unfinished_agents(numbers: StudyNumbers) -> dict[str, tuple[int, int]]:
    """The agents that an unfinished study is about: their finished trials, and those that are planned."""
    study = numbers.study
    found = {}
    for agent in [one for one in study.run_agents if not is_baseline(one)] or study.run_agents:
        own = [trial for trial in numbers.opened.trials if trial.group == study.label_of(agent)]
        done, planned = study.places_filled(own), study.size_of(agent)
        if done < planned:
            found[study.label_of(agent)] = done, planned
    return found


def lacking_agents(numbers: StudyNumbers) -> dict[str, tuple[int, int]]:
    """Those of them on which nothing could be tested yet."""
    tested = _tested(numbers)
    return {agent: trials for agent, trials in unfinished_agents(numbers).items() if agent not in tested}


def _tested(numbers: StudyNumbers) -> set[str]:
    """The agents of which something is said: of a study of one condition, those with an ended trial."""
    others = numbers.others
    if len(numbers.study.conditions) < 2:
        return {trial.group for trial in numbers.trials if trial.error is None}
    axes = [numbers.flips, *(one for _, one in numbers.doses)]
    found = {one.agent for axis in axes for one in axis.agents if one.contrast or one.blind}
    found |= {one.agent for one in numbers.flips.modalities}
    if others is not None:
        found |= {one.agent for one in others.effects if one.effects}
        found |= {one.agent for kind in (others.whys, others.factorials) for one in kind}
    return found


def answered_questions(summary: StudySummary, lacking: Container[str]) -> list[Question]:
    """The questions of an axis: those on baselines alone, where no agent that it is about has the trials to answer it.

    Args:
        summary: The numbers over the axis.
        lacking: Agents with too few trials.
    """
    several = len({one.dose for one in summary.conditions}) > 1
    open_ = [one.agent in lacking or (several and len(one.conditions) < 2) for one in summary.subjects]
    return [one for one in of_axis(summary) if one.baselines or not open_ or not all(open_)]


def with_lacking(answer: str, numbers: StudyNumbers, lacking: Mapping[str, tuple[int, int]]) -> str:
    """The answer of a study, after how many trials it rests on; marked where baselines stand for all other agents.

    Where there is an answer for some of the agents that the study is about, it comes before what is still to come.
    Nothing is added where no trial has ended.
    """
    if all(trial.error is not None for trial in numbers.trials):
        return answer
    rest = {agent: trials for agent, trials in unfinished_agents(numbers).items() if agent not in lacking}
    going_on = finished_said(rest) if numbers.opened.every_look == "unfinished" else ""
    own = [numbers.study.label_of(agent) for agent in numbers.study.run_agents if not is_baseline(agent)]
    instead = own and all(trial.group not in own for trial in numbers.trials)
    if not _tested(numbers).isdisjoint(own):
        return " ".join(filter(None, (going_on, answer, too_few_said(lacking, others=True))))
    return " ".join(filter(None, (too_few_said(lacking), going_on, of_baselines(answer) if instead else answer)))
