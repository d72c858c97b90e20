"""From an opened study to its numbers, and from these to its results: what ``results.json`` and all pages hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from lockprobe.analysis.branch import BranchEffect, branch_effects
from lockprobe.analysis.condition_study import ConditionStudySummary, summarise_conditions
from lockprobe.analysis.rules import rule_breaks
from lockprobe.analysis.summary import StudySummary, check_trials, summarise
from lockprobe.errors import BadFile, BadValue
from lockprobe.parallel import Each
from lockprobe.prose.branch import found_said
from lockprobe.record import Trial
from lockprobe.report.assembled import assembled
from lockprobe.report.condition_results import condition_parts
from lockprobe.report.flip_results import flip_design, flip_parts
from lockprobe.report.forks import ForkResult, fork_rows
from lockprobe.report.judging_nobody import judging_nobody
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.schema import RESULTS_VERSION, Results, SectionLeftOut
from lockprobe.report.study_rows import study_progress
from lockprobe.sections import LeftOutSection, collecting, leaving_out, section
from lockprobe.studies.directory import RECORDS
from lockprobe.studies.results_hash import results_hash
from lockprobe.studies.study_design import design_of

__all__ = ["StudyNumbers", "results", "results_of", "study_numbers", "with_left_out"]


_NUMBERS = ("All numbers", "Every condition against the control")
"""How the names of sections begin without which there is no answer."""


@dataclass(frozen=True, slots=True)
class StudyNumbers:
    """All numbers of a study, without sentences.

    Attributes:
        flips: Those over its flip rates, the truth among them.
        others: Those of its other conditions; None without any.
        forks: What one report did, by its forks; empty without forks.
    """

    flips: StudySummary
    others: ConditionStudySummary | None
    forks: tuple[BranchEffect, ...]


def study_numbers(opened: OpenedStudy, *, each: Each = map) -> StudyNumbers:
    """Compute all numbers of a study.

    Args:
        opened: The study.
        each: Works on one job after the other, or on several at once.

    Raises:
        BadFile: If its records cannot be analysed together.
    """
    flips = _of_flips(opened, collecting(each))
    forks = section(
        "Effect of one report",
        lambda: branch_effects(opened.forks, {trial.key: trial for trial in opened.trials}, chances=opened.choices),
        list[BranchEffect],
    )
    return StudyNumbers(flips, _of_others(opened, flips, collecting(each)), tuple(forks))


def _of_flips(opened: OpenedStudy, each: Each) -> StudySummary:
    """The numbers over the flip rates; those of no trial if none can be computed."""
    study, trials = opened.study, opened.flip_trials
    try:
        check_trials(trials, study.box)
    except BadValue as error:
        raise BadFile(opened.directory / RECORDS, str(error)) from error
    return section(
        "All numbers of trials",
        lambda: summarise(trials, study.box, each=each),
        lambda: summarise((), study.box, each=each),
    )


def _of_others(opened: OpenedStudy, flips: StudySummary, each: Each) -> ConditionStudySummary | None:
    """The numbers of conditions that are no flip rates; those of no trial if none can be computed."""
    study = opened.study
    if study.of_flips:
        return None

    def of(trials: Sequence[Trial]) -> ConditionStudySummary:
        return summarise_conditions(trials, design_of(study), flips, box=study.box, budget=study.max_steps, each=each)

    return section("All numbers of conditions", lambda: of(opened.trials), lambda: of(()))


def results_of(opened: OpenedStudy, numbers: StudyNumbers) -> Results:
    """The results of a study: its numbers with their sentences, which judge nobody where attempts broke the rules."""
    study, flips = opened.study, numbers.flips
    beside = condition_parts(opened, flips, numbers.others) if numbers.others is not None else {}
    content = assembled(
        flip_parts(opened, flips) | beside,
        schema_version=RESULTS_VERSION,
        lockprobe=version("lockprobe"),
        study=dict(opened.settings),
        flips=flip_design(study),
        settings_hash=study.settings_hash,
        results_hash=results_hash(study, opened.trials),
        joints=len(study.box.joints),
        progress=study_progress(opened),
        box=flips.reference,
        verdicts=flips.verdicts,
        subjects=list(dict.fromkeys(agent.agent for agent in flips.subjects))
        or list(numbers.others.subjects if numbers.others else ()),
    )
    return judging_nobody(content.model_copy(update=_of_forks(opened, numbers.forks)))


def _of_forks(opened: OpenedStudy, forks: Sequence[BranchEffect]) -> dict[str, object]:
    if not forks:
        return {}
    return {
        "forks": section("Effect of one report", lambda: fork_rows(forks), list[ForkResult]),
        "forks_said": section(
            "Effect of one report",
            lambda: found_said(
                [one for one in forks if one.outcome == "solved"], rule_breaks(opened.forks, opened.study.box)
            ),
            list[str],
        ),
    }


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
