"""Plays a study from its estimate to its report, and returns the exit status."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

from lockprobe.cli.live_report import LiveReport
from lockprobe.cli.progress import Progress, watch
from lockprobe.cli.result import read_result
from lockprobe.cli.study_lines import foreign_in_words
from lockprobe.foundation.errors import AgentsGivenUp, BudgetReached, UserMistake
from lockprobe.foundation.left_out import LeftOutSection
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.records.counted import invalid_conditions
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.record_index import RecordIndex
from lockprobe.studies.records.results_hash import StudyHashes, note_hash
from lockprobe.studies.records.trial_rows import OnRecord
from lockprobe.studies.running.rounds import next_plans
from lockprobe.studies.running.runner import Limits, owe_anew
from lockprobe.studies.running.runner import run as play_trials
from lockprobe.studies.study import Study
from lockprobe.trial.record import TrialError

_Broken = Mapping[str, tuple[OnRecord, TrialError | None]]
"""Key of a trial that has broken -> as the journal had it, and its error."""

BROKE = 1
"""The exit status if something outside the agents broke trials, which are owed again, or no trial ended validly."""

BUDGET_REACHED = 3
"""The exit status if the budget ended a study before its last trial."""


class _NothingKept(Exception):
    """Ends a run of which nothing was kept, so that its directory is not left behind."""


def play_study(
    planned: Study,
    directory: Path,
    limits: Limits,
    budget: Budget | None,
    *,
    again: str | None = None,
    report: bool = True,
    json: bool = False,
) -> int:
    """Play the trials that a study owes, write its report, and return the exit status.

    Args:
        planned: The study.
        directory: The directory of the study, existing or new.
        limits: How much is played at once.
        budget: The budget of the study.
        again: Which finished trials are replayed; see ``lockprobe run --again``.
        report: Whether to write the report during and after the run.
        json: Whether to print events as JSON.
    """
    status = 0
    with suppress(_NothingKept), Journal.open(directory, planned) as journal:
        observer = watch(json=json, budget=budget, report=report, attended=planned.attended)
        if foreign := foreign_in_words(journal.left_out):
            print(printable(foreign), file=sys.stderr)
        if budget is not None:
            journal.calls.limit(budget)
        broken = {key: (one, journal.read(key)[0].error) for key, one in journal.trials.items() if one.owed_again}
        if again is not None:
            observer.owed_anew(owe_anew(journal, planned, again), again)
        live = LiveReport(observer, directory if report else None, tell=observer.first_report)
        reached = _play_trials(planned, journal, limits, live, observer)
        if planned.until and journal.trials:
            from lockprobe.cli.decisions import decided

            observer.decided(*decided(planned, planned.own_trials(load(directory))))
        if planned.size == planned.invited and not journal.trials:
            return status  # people have yet to be invited
        live.end()
        if journal.trials:
            hashes = StudyHashes.of(directory)
            note_hash(journal.store, hashes)
            observer.recorded(hashes)
        left_out: list[LeftOutSection] = []
        something = journal.trials or reached is None
        page = _report(directory, left_out) if report and something else None
        observer.reported(page, left_out, None if page is None else read_result(directory))
        _tell_failures(planned, journal, observer, broken)
        owed, given_up = 0, bool(observer.tally.given_up)
        if reached is not None or observer.tally.broken_of or given_up:
            plans = next_plans(planned, journal)
            owed = sum(journal.owes(plan.key) for agent in planned.run_agents for plan in plans(agent))
        valid = not journal.trials or any(trial.ending != "error" for trial in journal.trials.values())
        status = BROKE if owed or given_up or not valid else 0
        if reached is not None:
            observer.stopped(reached, owed, planned.size - planned.invited)
            if not journal.trials:
                raise _NothingKept
    return BUDGET_REACHED if reached is not None else status


def _play_trials(
    planned: Study, journal: Journal, limits: Limits, live: LiveReport, observer: Progress
) -> BudgetReached | None:
    """Play the owed trials, and return what ended them early if the budget did."""
    try:
        with observer.played():
            play_trials(planned, journal, limits=limits, observer=live)
    except KeyboardInterrupt:
        finished = sum(not trial.owed_again for trial in journal.trials.values())
        observer.interrupted(journal.directory, read_result(journal.directory), finished)
        raise
    except BudgetReached as reached:
        return reached
    except AgentsGivenUp:
        if not journal.trials:  # nothing was played: the command cannot be carried out
            raise
    except UserMistake:
        live.stop()
        raise
    return None


def _tell_failures(planned: Study, journal: Journal, observer: Progress, before: _Broken) -> None:
    """Tell which conditions have errors alone, and what broke. ``before`` are the trials that had broken at first."""
    tally = observer.tally
    of_all = tally.ended_in_all or not tally.broken_of
    if of_all and (found := invalid_conditions(planned, RecordIndex(journal.store, planned).counted())):
        observer.invalid(found)
    if tally.broken_of or tally.given_up:
        replays = [
            (why.step, journal.read(key)[0].error)
            for key, (was, why) in before.items()
            if why is not None and journal.trials[key] is not was
        ]
        observer.broke(in_vain=bool(replays) and all(now and now.step >= step for step, now in replays))


def _report(directory: Path, left_out: list[LeftOutSection]) -> Path:
    from lockprobe.report.write import write_report  # a second of imports, which the first trials need not wait for

    return write_report(directory, tell=partial(print, "Report:", file=sys.stderr), left_out=left_out.append)
