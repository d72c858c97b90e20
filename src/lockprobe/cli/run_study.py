"""Plays a study of a command from its estimate to its report, with exit statuses."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

import typer

from lockprobe.cli.display import watch
from lockprobe.cli.format_cost import money
from lockprobe.cli.live_report import LiveReport
from lockprobe.cli.progress import Plain, foreign_in_words
from lockprobe.errors import BadValue, BudgetReached
from lockprobe.plan import Plan
from lockprobe.studies.estimate import most_of_one_call
from lockprobe.studies.journal import Journal
from lockprobe.studies.runner import Limits, owe_anew
from lockprobe.studies.runner import run as play_trials
from lockprobe.studies.shard import Shard
from lockprobe.studies.spending import Budget, hosted
from lockprobe.studies.study import Study
from lockprobe.studies.valid_conditions import invalid_conditions
from lockprobe.terminal_text import printable

__all__ = ["ALL_BROKE", "BUDGET_REACHED", "NO_VALID_TRIAL", "allowed_budget", "play_study"]

ALL_BROKE = 1
"""The exit status where trials were played, and something outside their agents broke every one."""

NO_VALID_TRIAL = 1
"""The exit status where every trial of a condition ended as an error."""

BUDGET_REACHED = 3
"""The exit status where a budget ended a study before its last trial."""


def play_study(
    planned: Study,
    directory: Path,
    limits: Limits,
    budget: Budget | None,
    *,
    shard: Shard | None = None,
    again: str | None = None,
    report: bool | None = True,
    json: bool = False,
) -> int:
    """Play what a study owes, and write its report; its exit status.

    Args:
        planned: The study.
        directory: Where it is, or will be.
        limits: How much is played at once.
        budget: What it may spend.
        shard: The part of the trials that is played; None for all.
        again: Which finished trials are replayed; see ``lockprobe run --again``.
        report: Whether its report is written meanwhile and at its end; None if it is part of something larger.
        json: Whether events are printed as JSON.
    """
    status = 0
    with (
        Journal.open(directory, planned) as journal,
        watch(
            json=json, batch=limits.access.batch, budget=budget, report=report, attended=planned.attended
        ) as observer,
    ):
        if foreign := foreign_in_words(journal.left_out):
            print(printable(foreign), file=sys.stderr)
        if budget is not None:
            journal.calls.limit(budget)
        if again is not None:
            observer.owed_anew(owe_anew(journal, planned, again))
        live = LiveReport(observer, directory if report else None)
        try:
            play_trials(planned, journal, limits=limits, observer=live, plans=_plans(planned, shard))
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
        return status  # people have yet to be invited
    live.end()
    observer.reported(_report(directory, limits) if report and (journal.trials or not status) else None)
    return status


def _plans(planned: Study, shard: Shard | None) -> Callable[[str], Iterable[Plan]] | None:
    if shard is None:
        return None
    return lambda agent: [plan for plan in planned.plans(agent) if shard.has(plan.key)]


def _failure(planned: Study, journal: Journal, observer: Plain) -> int:
    """The exit status of a run that was not cut short: 0 unless trials that were played are of no use."""
    if observer.tally.broken_in_all and not observer.tally.ended_in_all:
        observer.broke()
        return ALL_BROKE
    if found := invalid_conditions(planned, journal.trials):
        observer.invalid(found)
        return NO_VALID_TRIAL
    return 0


def _report(directory: Path, limits: Limits) -> Path:
    from lockprobe.report import write_report  # a second of imports, which the first trials need not wait for

    tell = partial(print, "Report:", file=sys.stderr)
    return write_report(directory, tell=tell, processes=2, elsewhere=limits.cluster)


def allowed_budget(planned: Study, budget: float | None, directory: Path) -> Budget | None:
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
