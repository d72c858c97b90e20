"""Runs a study: plays the trials that its journal still owes, and resumes where an earlier run stopped.

Which trials are owed, and in which order agents play, is decided here; where they are played, in
:mod:`lockprobe.studies.running.executor`.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.foundation.child_processes import interruptible
from lockprobe.foundation.errors import AgentsGivenUp, BadFile, BadValue, BudgetReached, SettingsChanged, UserMistake
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.decisions import due
from lockprobe.studies.records.directory import extended
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.executor import Limits, Observer, Turn
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Step, Trial

_INTERRUPTIBLE = 0.1
"""Seconds after which a thread that waits for another one notices an interrupt at the latest."""


def next_plans(study: Study, journal: Journal) -> Callable[[str], Iterable[Plan]]:
    """Function from an agent to its plans: all, or those before the next look of a study that may stop there.

    All agents of the directory are judged together, those too that are not run now.
    """
    if study.until is None:
        return study.plans
    whole = replace(journal.study, shard=study.shard)
    return lambda agent: due(whole, agent, journal.trials.values())


def run(
    study: Study,
    journal: Journal,
    *,
    limits: Limits | None = None,
    observer: Observer | None = None,
    plans: Callable[[str], Iterable[Plan]] | None = None,
) -> None:
    """Play what the journal owes of a study.

    Before a look of a study that stops when it is decided, all trials have to end. So those that broke are played
    again, as long as others end meanwhile. ``plans`` is a function from an agent to others than the study's own.

    Raises:
        UserMistake: Before the first trial, if an agent or the plant is not available.
        BudgetReached: If the budget ended the trials of an agent; those of the others were played as far as it went.
        AgentsGivenUp: If agents could not go on, and the others were played.
        BadFile: If the directory cannot be written.
        SettingsChanged: If an agent or the plant is another one than that of the earlier trials.
        KeyboardInterrupt: On Ctrl-C; whatever was finished is on disk.
    """
    limits, observer, of = limits or Limits(), observer or Observer(), plans or next_plans(study, journal)

    def owed_by(source: AgentSource) -> Iterable[Plan]:
        """Of a hosted agent trials that were begun come first, so that a small budget ends them."""
        found = (plan for plan in of(source.spec) if journal.owes(plan.key))
        if source.engine != "network":  # a strategy can owe a million
            return found
        return sorted(found, key=lambda plan: not journal.calls.has_replies(plan.key))

    owed = _owed_here(study, limits, owed_by)
    observer.begin(study, journal, sum(owed.values()))
    spent: BudgetReached | None = None
    given_up: dict[str, UserMistake] = {}
    for source, now in owed.items():
        observer.agent(source, now)
        left = now
        try:
            while left:
                turn = Turn(study, source, journal, limits, observer)
                turn.play(partial(owed_by, source), left)
                left = sum(1 for _ in owed_by(source)) if study.until and turn.ended else 0
                observer.more(left)
        except BudgetReached as reached:
            spent = reached
        except (BadFile, SettingsChanged):
            raise
        except UserMistake as why:
            if study.attended:  # whoever answers at the terminal answers for all agents
                raise
            given_up[source.spec] = why
            observer.given_up(source, sum(1 for _ in owed_by(source)), why)
    if spent or given_up:
        raise spent or AgentsGivenUp(given_up)


def _owed_here(
    study: Study, limits: Limits, owed_by: Callable[[AgentSource], Iterable[Plan]]
) -> dict[AgentSource, int]:
    """What agents owe that can be run, strategies first: all but people (who are invited) and clients (which connect).

    Agents that are not available here are refused, and so are the plants that they play on.
    """
    sources = [resolve(spec, limits.access) for spec in study.agents]
    study.check_agents()
    if all(source.engine == "client" for source in sources):
        expected = "an agent that can be run; this one connects to the server that `lockprobe mcp` starts"
        raise BadValue("agent", sources[0].spec, expected)
    here = sorted(sources, key=lambda source: source.engine != "inline")
    owed = {source: sum(1 for _ in owed_by(source)) for source in here if source.engine not in ("person", "client")}
    owed = {source: left for source, left in owed.items() if left}
    for source in owed:
        source.check()
    plants = {study.plant_of(one): None for source in owed for one in study.conditions_of(source.spec)}
    for plant, box in product(plants, study.boxes):
        resolve_plant(plant).check(box)
    return owed


def run_study(study: Study, directory: Path | str, *, limits: Limits | None = None) -> list[Trial]:
    """Play a study, or resume it, in a directory, and return all its trials.

    A directory of a smaller study of the same settings is extended, as by ``lockprobe run``.

    It also works in a notebook, whose thread already runs an event loop: the study is then played in another thread,
    which an interrupt here ends at its next step.

    Raises:
        UserMistake: As :func:`run`, and if the directory holds another study.
        KeyboardInterrupt: On Ctrl-C or an interrupted notebook cell; whatever was finished is on disk.
    """
    if not isinstance(study, Study):
        raise BadValue("study", study, "a study, as lockprobe.study makes one")
    study = extended(study, Path(directory))
    with Journal.open(directory, study) as journal:
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            run(study, journal, limits=limits)
            return load(directory)
        stoppable = _Stoppable()
        with interruptible(), ThreadPoolExecutor(max_workers=1, thread_name_prefix="study") as thread:
            played = thread.submit(run, study, journal, limits=limits, observer=stoppable)
            try:
                while not played.done():
                    wait((played,), timeout=_INTERRUPTIBLE)
            finally:
                stoppable.stopped = True
            played.result()
    return load(directory)


class _Stoppable(Observer):
    """An observer through which another thread ends a run."""

    stopped = False

    def step(self, key: str, step: Step) -> None:
        if self.stopped:
            raise KeyboardInterrupt
