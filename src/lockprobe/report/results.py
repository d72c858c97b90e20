"""From an opened study to its numbers, and from these to its results: what ``results.json`` and all pages hold."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lockprobe.analysis.branch import BranchEffect, branch_effects
from lockprobe.analysis.condition_study import ConditionStudySummary, summarise_conditions
from lockprobe.analysis.summary import StudySummary, summarise
from lockprobe.errors import BadFile, BadValue
from lockprobe.parallel import Each
from lockprobe.prose.branch import found_said
from lockprobe.report.condition_results import arms_of, condition_results
from lockprobe.report.flip_results import flip_results
from lockprobe.report.forks import fork_rows
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.schema import Results
from lockprobe.studies.directory import RECORDS

__all__ = ["StudyNumbers", "results", "results_of", "study_numbers"]


@dataclass(frozen=True, slots=True)
class StudyNumbers:
    """All numbers of a study, without sentences.

    Attributes:
        trials: Those of its trials: of flip rates, or of any other conditions.
        forks: What one report did, by its forks; empty without forks.
    """

    trials: StudySummary | ConditionStudySummary
    forks: tuple[BranchEffect, ...]


def study_numbers(opened: OpenedStudy, *, each: Each = map) -> StudyNumbers:
    """Compute all numbers of a study.

    Args:
        opened: The study.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    trials = _of_trials(opened, each)
    forks = branch_effects(opened.forks, {trial.key: trial for trial in opened.trials}, chances=opened.choices)
    return StudyNumbers(trials, tuple(forks))


def _of_trials(opened: OpenedStudy, each: Each) -> StudySummary | ConditionStudySummary:
    study = opened.study
    if not study.of_flips:
        arms = arms_of(study.conditions)
        return summarise_conditions(
            opened.trials, arms, agents=study.agents, box=study.box, budget=study.max_steps, each=each
        )
    try:
        return summarise(opened.trials, study.box, each=each)
    except BadValue as error:
        raise BadFile(opened.directory / RECORDS, str(error)) from error


def results_of(opened: OpenedStudy, numbers: StudyNumbers) -> Results:
    """The results of a study: its numbers with their sentences."""
    found = numbers.trials
    content = flip_results(opened, found) if isinstance(found, StudySummary) else condition_results(opened, found)
    if not numbers.forks:
        return content
    said = found_said([one for one in numbers.forks if one.outcome == "solved"])
    return content.model_copy(update={"forks": fork_rows(numbers.forks), "forks_said": said})


def results(directory: Path | str) -> Results:
    """The numbers of a study, from its records; equal records give equal results.

    Args:
        directory: The directory of a study.

    Raises:
        BadFile: If it is none.
    """
    with one_thread():
        opened = open_study(Path(directory))
        return results_of(opened, study_numbers(opened))
