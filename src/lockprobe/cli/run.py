"""``lockprobe run``: play the trials that a study still owes, then write its report."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import typer

from lockprobe.agents.model_access import Access
from lockprobe.cli import options
from lockprobe.cli.display import watch
from lockprobe.cli.format_cost import money, print_estimates
from lockprobe.cli.live_report import LiveReport
from lockprobe.cli.progress import Plain, foreign_in_words
from lockprobe.errors import BadValue, BudgetReached
from lockprobe.interventions.condition import flips
from lockprobe.record import STATES
from lockprobe.studies.directory import SETTINGS
from lockprobe.studies.estimate import most_of_one_call
from lockprobe.studies.journal import Journal
from lockprobe.studies.runner import Limits, owe_anew
from lockprobe.studies.runner import run as play_study
from lockprobe.studies.settings import read_study
from lockprobe.studies.spending import Budget, hosted
from lockprobe.studies.study import Study
from lockprobe.studies.study_options import StudyOptions, read_options_file
from lockprobe.studies.studyfile import STUDIES, study
from lockprobe.studies.valid_conditions import invalid_conditions
from lockprobe.terminal_text import printable

__all__ = ["ALL_BROKE", "BUDGET_REACHED", "NO_VALID_TRIAL", "run"]

ALL_BROKE = 1
"""The exit status where trials were played, and something outside their agents broke every one."""

NO_VALID_TRIAL = 1
"""The exit status where every trial of a condition ended as an error."""

BUDGET_REACHED = 3
"""The exit status where a budget ended a study before its last trial."""


@options.with_study_options()
def run(
    what: options.Name,
    asked: Mapping[str, object],
    out: options.Out = None,
    workers: options.Workers = None,
    connections: options.Connections = 10,
    timeout: options.Timeout = 120.0,
    retries: options.Retries = 6,
    batch: options.Batch = False,
    budget: options.Budget = None,
    again: options.Again = None,
    estimate: options.EstimateOnly = False,
    report: options.WriteReport = True,
    json: options.AsJson = False,
) -> None:
    """Play a study, or resume it, and write its report. The same command again resumes it; what people did there stays.

    flips: what false reports do. Without options a short study of the embedded model with random, round-robin and
    the human-inspired strategy, in a few minutes on two cores. modalities: what pictures do. RGB, RGB-D and reports,
    10 trials each, on a simulated box with a camera; without options a scripted agent, human-inspired and random. why:
    whether lies change success because of what they say or because they disturb; without options three strategies.

    --condition and --sweep vary anything else that lockprobe interventions lists, with the truth as control.

    Another --agent with --out and settings of a study is added to it, with the same luck. Exit status 3: a budget ended
    it; 1: every trial broke, or a condition has no valid trial.
    """
    planned, directory = _planned(what, asked, out)
    access = Access(connections=connections, timeout=timeout, retries=retries, batch=batch)
    if estimate:
        return _estimate(planned, directory, again, batch=batch, json=json)
    limits = Limits(workers=workers or min(os.cpu_count() or 1, 8), access=access)
    allowed = _allowed(planned, budget, directory)
    return _play(planned, directory, limits, allowed, again=again, report=report, json=json)


def _estimate(planned: Study, directory: Path, again: str | None, *, batch: bool, json: bool) -> None:
    if again is not None:
        raise BadValue("again", again, "no --estimate beside it: that plays nothing and writes nothing")
    print_estimates(planned, directory, batch=batch, json=json)


def _play(
    planned: Study,
    directory: Path,
    limits: Limits,
    budget: Budget | None,
    *,
    again: str | None,
    report: bool,
    json: bool,
) -> None:
    status = 0
    with (
        Journal.open(directory, planned) as journal,
        watch(json=json, batch=limits.access.batch, budget=budget, report=report) as observer,
    ):
        if foreign := foreign_in_words(journal.left_out):
            print(printable(foreign), file=sys.stderr)
        if budget is not None:
            journal.calls.limit(budget)
        if again is not None:
            observer.owed_anew(owe_anew(journal, planned, again))
        live = LiveReport(observer, directory if report else None)
        try:
            play_study(planned, journal, limits=limits, observer=live)
        except KeyboardInterrupt:
            observer.interrupted(directory)
            raise
        except BudgetReached as reached:
            observer.stopped(reached, _owed(planned, journal), planned.size - planned.invited)
            status = BUDGET_REACHED
            if not journal.trials:
                observer.reported(None)
                raise typer.Exit(status) from None  # so that a directory in which nothing was kept is not left behind
    status = status or _failure(planned, journal, observer)
    if planned.size == planned.invited and not journal.trials:
        return  # people have yet to be invited
    live.end()
    observer.reported(_report(directory) if report and (journal.trials or not status) else None)
    if status:
        raise typer.Exit(status)


def _failure(planned: Study, journal: Journal, observer: Plain) -> int:
    """The exit status of a run that was not cut short: 0 unless trials that were played are of no use."""
    if observer.tally.broken_in_all and not observer.tally.ended_in_all:
        observer.broke()
        return ALL_BROKE
    if found := invalid_conditions(planned, journal.trials):
        observer.invalid(found)
        return NO_VALID_TRIAL
    return 0


def _report(directory: Path) -> Path:
    from lockprobe.report import write_report  # a second of imports, which the first trials need not wait for

    return write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr), processes=2)


def _allowed(planned: Study, budget: float | None, directory: Path) -> Budget | None:
    """The budget of a study, which has to suffice for one call where it begins."""
    if budget is None:
        return None
    allowed = Budget(planned, budget)
    most, agent = min(((most_of_one_call(planned, agent), agent) for agent in hosted(planned)), default=(0.0, ""))
    if most > budget and not (directory / "study.json").exists():
        raise BadValue("budget", money(budget), f"more: one call of {agent} can cost up to {money(most)}")
    return allowed


def _owed(planned: Study, journal: Journal) -> int:
    """Trials that are still to be played, but for those of people."""
    return sum(journal.owes(plan.key) for agent in planned.run_agents for plan in planned.plans(agent))


def _planned(name: str, asked: Mapping[str, object], out: Path | None) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play. A directory from an earlier release keeps its reports, unless a
    modality is given.
    """
    if name not in STUDIES and Path(name).is_dir():
        expected = f"one of {', '.join(STUDIES)}, or FILE.toml; to go on, the same command with --out {name}"
        raise BadValue("study", name, expected)
    request = read_options_file(Path(name)) if name.endswith(".toml") else StudyOptions(study=name)
    planned = study(request, **asked)
    if out is not None and request.modality is None and "modality" not in asked and (out / SETTINGS).exists():
        planned = _shown_as_before(planned, read_study(out))
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if request.agent is None and "agent" not in asked and (directory / SETTINGS).exists():
        planned = replace(planned, agents=read_study(directory).run_agents or planned.agents)
    return planned, directory


def _shown_as_before(planned: Study, there: Study) -> Study:
    """The study with the reports of an earlier release, which told outcomes as well by default."""
    told = tuple(STATES if one == "symbolic" else one for one in there.modalities)
    if not (planned.of_flips and there.of_flips) or told != planned.modalities:
        return planned
    return replace(planned, conditions=flips(planned.p, planned.flip, there.modalities))
