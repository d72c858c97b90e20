"""From an opened study to its numbers, and from these to its results: what ``results.json`` and all pages hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lockprobe.analysis.branch import BranchEffect, branch_effects
from lockprobe.analysis.condition_study import ConditionStudySummary, summarise_conditions
from lockprobe.analysis.rules import rule_breaks
from lockprobe.analysis.summary import StudySummary, check_trials, summarise
from lockprobe.errors import BadFile, BadValue
from lockprobe.parallel import Each
from lockprobe.prose.branch import found_said
from lockprobe.record import Trial
from lockprobe.report.condition_results import arms_of, condition_results
from lockprobe.report.flip_results import flip_results
from lockprobe.report.forks import ForkResult, fork_rows
from lockprobe.report.judging_nobody import judging_nobody
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.schema import Results, SectionLeftOut
from lockprobe.sections import LeftOutSection, collecting, leaving_out, section
from lockprobe.studies.directory import RECORDS

__all__ = ["StudyNumbers", "results", "results_of", "study_numbers", "with_left_out"]


_NUMBERS = ("All numbers", "Every condition against the control")
"""How the names of sections begin without which there is no answer."""


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
    forks = section(
        "Effect of one report",
        lambda: branch_effects(opened.forks, {trial.key: trial for trial in opened.trials}, chances=opened.choices),
        list[BranchEffect],
    )
    return StudyNumbers(trials, tuple(forks))


def _of_trials(opened: OpenedStudy, each: Each) -> StudySummary | ConditionStudySummary:
    """The numbers of the trials; those of no trial if none can be computed."""
    study, noted = opened.study, collecting(each)

    def of(trials: Sequence[Trial]) -> StudySummary | ConditionStudySummary:
        if study.of_flips:
            return summarise(trials, study.box, each=noted)
        arms = arms_of(study.conditions)
        return summarise_conditions(
            trials, arms, agents=study.agents, box=study.box, budget=study.max_steps, each=noted
        )

    if study.of_flips:
        try:
            check_trials(opened.trials, study.box)
        except BadValue as error:
            raise BadFile(opened.directory / RECORDS, str(error)) from error
    return section("All numbers of trials", lambda: of(opened.trials), lambda: of(()))


def results_of(opened: OpenedStudy, numbers: StudyNumbers) -> Results:
    """The results of a study: its numbers with their sentences, which judge nobody where attempts broke the rules."""
    found = numbers.trials
    content = flip_results(opened, found) if isinstance(found, StudySummary) else condition_results(opened, found)
    if not numbers.forks:
        return judging_nobody(content)
    forks = {
        "forks": section("Effect of one report", lambda: fork_rows(numbers.forks), list[ForkResult]),
        "forks_said": section(
            "Effect of one report",
            lambda: found_said(
                [one for one in numbers.forks if one.outcome == "solved"], rule_breaks(opened.forks, opened.study.box)
            ),
            list[str],
        ),
    }
    return judging_nobody(content.model_copy(update=forks))


def with_left_out(content: Results, left_out: Sequence[LeftOutSection]) -> Results:
    """The results with the sections that could not be made; no answer stands where its numbers are among them."""
    if not left_out:
        return content
    rows = [SectionLeftOut(section=one.section, reason=one.reason) for one in left_out]
    overview = content.overview
    numberless = any(one.section.startswith(_NUMBERS) for one in left_out)
    if overview is not None and content.progress.finished and numberless and not overview.numbers:
        answer = "The answer could not be computed; the sections below that are left out say why."
        overview = overview.model_copy(update={"answer": answer})
    return content.model_copy(update={"sections_left_out": rows, "overview": overview})


def results(directory: Path | str) -> Results:
    """The numbers of a study, from its records; equal records give equal results.

    Args:
        directory: The directory of a study.

    Raises:
        BadFile: If it is none.
    """
    with one_thread(), leaving_out() as left_out:
        opened = open_study(Path(directory))
        content = results_of(opened, study_numbers(opened))
        return with_left_out(content, left_out)
