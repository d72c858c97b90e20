"""``lockprobe branch``: forks recorded trials, plays them on, and says what one report did."""

from __future__ import annotations

import os
from functools import partial
from typing import Annotated, Literal

import typer

from lockprobe.agents.llm.settings import Access
from lockprobe.cli import options
from lockprobe.cli.printing import print_rows
from lockprobe.cli.run_study import Progress
from lockprobe.foundation import plugins
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.format import texts
from lockprobe.report.prose import rules_broken_said
from lockprobe.report.questions.forks import RARE, fork_rows, fork_said, fork_table
from lockprobe.report.section import without_rare
from lockprobe.statistics.branch import branch_effects
from lockprobe.statistics.rules import Rules
from lockprobe.studies import FORKS
from lockprobe.studies.branch import branching, play_forks
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.executor import Limits

_KEYS = "Keys of trials, or beginnings of keys (all)."
_AT = "Fork after the reports of these steps, or at onset, first-lie, every."
_TOLD = "The report in each arm: truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark, withheld."
_THEN = "Later reports: as in the condition of the trial, or the truth."


@options.under_headings({options.AS_RUN: "workers connections timeout retries allow"})
def branch(
    directory: options.Directory,
    keys: Annotated[list[str] | None, typer.Argument(metavar="[KEY]...", help=_KEYS)] = None,
    at: Annotated[str, typer.Option(help=_AT)] = "4,8,12",
    told: Annotated[str, typer.Option(help=_TOLD)] = "truth,lie",
    then: Annotated[Literal["parent", "truth"], typer.Option(help=_THEN)] = "parent",
    times: Annotated[int, typer.Option(min=1, help="Continuations of each arm.")] = 1,
    allow: options.Allow = None,
    workers: options.Workers = None,
    connections: options.Connections = 10,
    timeout: options.Timeout = 120.0,
    retries: options.Retries = 6,
    budget: options.Budget = None,
    json: options.AsJson = False,
) -> None:
    """Measure the effect of one report: fork finished trials after it, change it, and let the agent play on.

    Earlier steps come from the record; the agent is not asked again. Arms share their luck if the agent is seeded.
    Forks are written to DIR/forks and do not count as trials of the study; the same command resumes them. In trials
    under true reports the effect is that of the first lie. --budget counts all forks of the study. Exit status 3: the
    budget ended the run; 1: a fork broke and is owed.
    """
    plugins.allow(*(allow or ()))
    study = read_study(directory)
    places, arms = ([one.strip() for one in words.split(",")] for words in (at, told))
    asked = branching(
        study, load(directory), keys=keys or (), at=places, told=arms, truthful=then == "truth", times=times
    )
    access = Access(connections=connections, timeout=timeout, retries=retries)
    limits = Limits(workers=workers or min(os.cpu_count() or 1, 8), access=access)
    planned = {plan.key for agent in asked.agents for plan in asked.plans(agent)}
    what = (
        f"{count(len(planned), 'fork')} of {count(len(asked.trials), 'trial')} on {study.boxes_in_words}: "
        f"after {', '.join(asked.at)}; arms {', '.join(asked.arms)}; {count(times, 'continuation')} each; "
        f"later reports {'true' if asked.truthful else 'as in the condition'}"
    )
    begin = [what, f"Records: {directory / FORKS} (the same command resumes it)"]
    with Journal.open(directory / FORKS, study) as journal:
        if done := len(planned) - sum(map(journal.owes, planned)):
            begin.append(f"{done} of {count(len(planned), 'fork')} are done already")
        progress = Progress(study, journal, json=json, budget=budget, forks=begin)
        progress.watch(partial(play_forks, asked, journal, limits=limits, observer=progress))
        owed = sum(map(journal.owes, planned))
    forks = [fork for fork in load(directory / FORKS) if fork.key in planned]
    rows = fork_rows(branch_effects(forks, asked.trials, asked.at), study)
    progress.tell("effects", effects=[row.plain() for row in rows])
    if not (json or rows):
        print("No effect can be estimated: that takes at least two trials forked at the same step.")
    elif not json:
        print_rows(texts(without_rare(fork_table(rows), RARE)))
        print()
        for said in filter(None, (fork_said(rows), rules_broken_said(*Rules(*study.boxes).broken(forks)))):
            print(printable(said))
        print("P is corrected for all effects on success of an agent (Holm), P and intervals for the number of agents.")
    if status := progress.end(owed, len(planned)):
        raise typer.Exit(status)
