"""Plays the study that a command line asks for, from its estimate to its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import typer

from lockprobe.cli.progress import BROKE, Progress, done_of
from lockprobe.cli.result import decided, write
from lockprobe.studies import SETTINGS
from lockprobe.studies.costs.spending import Budget
from lockprobe.studies.decisions import planned_now
from lockprobe.studies.options.study_options import read_options
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import extended, read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load, results_hash, stored_records
from lockprobe.studies.running.executor import Limits
from lockprobe.studies.running.runner import next_plans
from lockprobe.studies.running.runner import run as play_trials
from lockprobe.studies.study import SIZES, Study


def planned_study(name: str, asked: Mapping[str, object], out: Path | None) -> tuple[Study, Path]:
    """The study of a name or file with the options of the command line, and its directory.

    Without an agent, those of an existing study play; if nothing is said of its size, it stays as large as it is.
    """
    request = read_options(name, asked)
    planned = study(request)
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    if not (directory / SETTINGS).exists():
        return planned, directory
    there = read_study(directory)
    if not {"trials", "repetitions", "strategy_trials", "full", "until", "most"} & request.model_fields_set:
        planned = replace(planned, **{name: getattr(there, name) for name in SIZES})
    if request.agent is None and there.run_agents:
        planned = replace(planned, agents=there.run_agents, names=there.names)
    return extended(planned.ordered_as(there), directory), directory


def play_study(
    planned: Study,
    directory: Path,
    limits: Limits,
    budget: Budget | None,
    *,
    report: bool = True,
    json: bool = False,
) -> None:
    """Play the trials that a study owes, and write its report.

    Args:
        planned: The study.
        directory: The directory of the study, existing or new.
        limits: How much is played at once.
        budget: The budget of the study.
        report: Whether to write the report after the run.
        json: Whether to print events as JSON.

    Raises:
        Exit: With the exit status, if that is not 0. Of a run of which nothing was kept no directory is left behind.
    """
    with Journal.open(directory, planned) as journal:
        progress = Progress(planned, journal, json=json, budget=budget)
        if budget is not None:
            journal.calls.limit(budget)
        reached = progress.watch(partial(play_trials, planned, journal, limits=limits, observer=progress))
        if planned.until and journal.trials:
            lines, answers = decided(planned, load(directory))
            progress.tell("decided", *lines, message=lines[0], answers=answers)
        if planned.size == planned.invited and not journal.trials:
            return  # people have yet to be invited
        _tell_results(journal, progress, report=report, ended=reached is None)
        valid = not journal.trials or any(trial.ending != "error" for trial in journal.trials.values())
        if not (valid or progress.broken):
            error = journal.read(next(iter(journal.trials))).error
            assert error is not None
            said = f"No valid trial: all ended as an error, the first at {error.boundary}: {error.message}"
            progress.tell("no-valid-trial", f"{said}; when that is mended, another --out plays them anew")
        owed = 0
        if reached is not None or progress.broken or progress.abandoned:
            plans = next_plans(planned, journal)
            owed = sum(journal.owes(plan.key) for agent in planned.run_agents for plan in plans(agent))
        status = progress.end(reached, owed, planned.size - planned.invited) or (0 if valid else BROKE)
        if status and not journal.trials:
            raise typer.Exit(status)
    if status:
        raise typer.Exit(status)


def _tell_results(journal: Journal, progress: Progress, *, report: bool, ended: bool) -> None:
    """Tell the hash of the records, write the report, and tell what it has cost and found."""
    directory, facts, path = journal.directory, dict[str, object](), None
    if journal.trials:
        there, finished = read_study(directory), done_of(journal)
        records = results_hash(there, stored_records(journal.store))
        planned = planned_now(there, load(directory) if there.until else ())
        so_far = "" if finished == planned else f" so far, {finished} of {planned} trials"
        progress.say(f"Results: {records} (for a paper{so_far}; lockprobe verify DIR --results HASH checks it)")
        facts = {"settings_hash": there.settings_hash, "results_hash": records}
    if not report:
        lines = [f"No report, as asked; lockprobe report {directory} writes it"]
    elif not (journal.trials or ended):
        lines = ["No report: no trial has ended"]
    else:
        page, (lines, found) = write(directory)
        facts, path = facts | found, str(page)
    progress.tell("report", *progress.spent(), *lines, path=path, **facts, **progress.cost())
