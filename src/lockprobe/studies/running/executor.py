"""Plays plans of one agent: in this process, in others of this machine, or on a cluster, with the same records.

Only this process writes. Hosted models are asked from it, so that every call is in the study's log and budget; as many
of their trials are open at once as there are connections. What needs a processor, a local model or a simulated plant,
is played by workers, which return each trial packed for the store, with its pictures. Strategies are played here, many
trials at once on the kernel, or one by one where something acts that it does not know. What a person or another package
wrote stays on this machine, since it may cost money or move a robot. If somebody attends the plant, one trial after the
other is played here. If a worker dies, its trial ends as an ``error`` at the boundary ``model`` or ``plant``, whichever
needs the processor.
"""

from __future__ import annotations

import asyncio
import time
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from multiprocessing import parent_process

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import BudgetReached, ModelFault, PlantFault, UserMistake
from lockprobe.foundation.plugins import allow, allowed, find_plugin, guarded
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.workers import Cluster, Lost, Pool, Processes, lose
from lockprobe.interventions.conditions import interventions_in
from lockprobe.simulation.kernel import Minds
from lockprobe.simulation.many_trials import minds_of, play_many
from lockprobe.studies.decisions import GIVE_UP_AFTER
from lockprobe.studies.records.journal import Journal, facts_said
from lockprobe.studies.records.store import ALBUM, keep_picture, packed
from lockprobe.studies.running.trial_setup import plants_place, play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.loop import Executor, broken
from lockprobe.trial.patience import PATIENCE
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Closable
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.trial_json import TrialReader

_TOGETHER = 0.2
"""Seconds of strategies' trials that are written together: a commit of its own takes as long as a trial."""

_FIRST = 64
"""Trials that the kernel plays at once at first; then twice as many, as long as they take half of that time."""

_SIMULATED = ("symbolic", "fast-twin", "twin")
"""Plants that are computed alone; others have a person or a device."""


class Observer:
    """Receives the progress of a run, and ignores what it does not override."""

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Called once, with the number of trials still to be played."""

    def agent(self, source: AgentSource, owed: int) -> None:
        """Called before an agent's trials begin."""

    def step(self, key: str, step: Step) -> None:
        """Called after every step of every trial."""

    def trial(self, trial: Trial, seconds: float) -> None:
        """Called when a trial is on disk, with how long it took."""

    def more(self, owed: int) -> None:
        """Called after trials of an agent, with those that follow, as those before the next look of a study."""

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Called if no further trial of an agent is played, with the number that it still owes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits of concurrency; none of them changes a record.

    Attributes:
        workers: Processes for local models and simulated plants.
        access: How hosted models are reached. As many of their trials are open at once as there are connections.
        cluster: Other machines for agents and plants that come with Lockprobe; None for this one alone.
    """

    workers: int = 1
    access: Access = field(default_factory=Access)
    cluster: Cluster | None = None


def can_travel(study: Study, source: AgentSource) -> bool:
    """Whether an agent's trials can run on other machines: agent, plant and interventions must ship with Lockprobe."""
    changes = [type(change) for one in study.conditions for change in interventions_in(one)]
    return (
        source.engine in ("inline", "process")
        and find_plugin("agent", source.spec) is None
        and Spec.parse(study.plant, "plant").full_name in _SIMULATED
        and all(change.__module__.startswith("lockprobe.interventions.") for change in changes)
    )


class Turn:
    """The turn of an agent: plays the trials that it still owes, and says whether any of them ended for good.

    Attributes:
        ended: How many did.
    """

    def __init__(self, study: Study, source: AgentSource, journal: Journal, limits: Limits, observer: Observer) -> None:
        self._study, self._source, self._journal, self._observer = study, source, journal, observer
        self._keep = partial(keep_picture, journal.directory / ALBUM)
        hosted = source.engine == "network" and not study.attended
        self._quick = source.engine == "inline" and not study.simulated  # a trial takes a millisecond
        self._threaded = hosted and study.simulated
        self._lanes = limits.access.connections if hosted else 1
        self._broken_in_a_row = self.ended = 0
        self._finished, self._wrote = list[tuple[Trial, float, bytes | None]](), 0.0
        self._pool: Pool | None = None
        if study.attended or source.engine == "network":
            return
        if limits.cluster is not None and can_travel(study, source):
            self._pool = limits.cluster
        elif source.engine == "process" or (limits.workers > 1 and not self._quick):
            self._pool = Processes(limits.workers)

    def play(self, owing: Callable[[], Iterable[Plan]], owed: int) -> None:
        """Play so many trials; ``owing`` gives those that are owed now.

        Raises:
            BudgetReached: If the budget refused a call; every open trial went on until it was refused one itself.
            SettingsChanged: If the agent or the plant is another one than in the trials before.
            UserMistake: If the agent is not available, yields only errors, or its workers keep being lost.
        """
        try:
            if self._quick and self._study.layout != "shuffled":  # with which each trial has a panel of its own
                owed -= self._many_at_once(owing())
                self._write()
            if owed and self._pool is not None:
                self._elsewhere(self._pool, owing())
            elif owed:
                with plants_place(self._threaded) as place:
                    asyncio.run(self._here(iter(owing()), owed, place))
        finally:
            self._write()

    def _many_at_once(self, plans: Iterable[Plan]) -> int:
        """Play the trials that the kernel plays, and return how many."""
        agent, known, played, together = self._source.make(), dict[tuple[str, str], Minds | None](), 0, _FIRST

        def minds(plan: Plan) -> Minds | None:
            about = plan.label, plan.box.name
            if about not in known:
                known[about] = minds_of(agent, plan)
            return known[about]

        able = (plan for plan in plans if minds(plan) is not None)
        while batch := [*islice(able, together)]:
            began, alike, trials = time.perf_counter(), defaultdict[Minds, list[Plan]](list), dict[str, Trial]()
            for plan in batch:
                if (of := minds(plan)) is not None:
                    alike[of].append(plan)
            for of, plans_of in alike.items():
                trials |= {trial.key: trial for trial in play_many(plans_of, of)}
            took = time.perf_counter() - began
            for plan in batch:
                for step in (trial := trials[plan.key]).steps:
                    self._observer.step(trial.key, step)
                self._finish(trial, took / len(batch))
            played += len(batch)
            together *= 2 if took < _TOGETHER / 2 else 1
        return played

    async def _here(self, plans: Iterator[Plan], owed: int, place: Executor) -> None:
        """Play plans in order.

        An error other than a broken trial ends all trials, and those under way are cancelled. If the budget is reached,
        no trial is opened any more, and each open one goes on until it is refused a call itself.
        """
        agent, spent, opened = self._source.make(), list[BudgetReached](), list[asyncio.Task[None]]()

        async def lane() -> None:
            while not spent and (plan := next(plans, None)) is not None:
                try:
                    played = play_timed(
                        plan, agent, self._observer.step, keep=self._keep, calls=self._journal.calls, place=place
                    )
                    self._finish(*await played)
                except BudgetReached as reached:
                    spent.append(reached)
                if not self._finished:  # they were written
                    await asyncio.sleep(0)  # here Ctrl-C is heard where trials wait for nothing

        try:
            if self._source.engine == "network":  # a changed model is refused before it is called and paid
                self._journal.refuse_others({(self._source.spec, name): one for name, one in agent.facts.items()})
            opened += [asyncio.create_task(lane()) for _ in range(min(self._lanes, owed))]
            await asyncio.gather(*opened)
        finally:
            for task in opened:
                task.cancel()
            await asyncio.gather(*opened, return_exceptions=True)
            if isinstance(agent, Closable):
                with guarded("agent", self._source.spec):
                    await agent.aclose()
        if spent:
            raise spent[-1]

    def _elsewhere(self, pool: Pool, plans: Iterable[Plan]) -> None:
        """Play plans by workers, in any order."""
        begin, reader = partial(_player, self._source.spec, allowed()), TrialReader()
        for plan, played in pool.each(begin, plans):
            if isinstance(played, Lost):
                fault = PlantFault if self._source.engine == "inline" else ModelFault
                why = f"{plan.agent} lost its worker: {played.why}"
                self._finish(broken(plan, ModelFault(played.why) if played.explained else fault(why)), 0.0)
                continue
            record, seconds, pictures = played
            for picture in pictures:
                self._keep(picture)
            trial = reader.read(zlib.decompress(record))
            for step in trial.steps:
                self._observer.step(trial.key, step)
            self._finish(trial, seconds, record)

    def _finish(self, trial: Trial, seconds: float, record: bytes | None = None) -> None:
        """Write a trial, now or with those that follow it at once."""
        self._journal.refuse_others(facts_said(trial))
        self._finished.append((trial, seconds, record))
        if not self._quick or trial.error is not None or time.monotonic() - self._wrote > _TOGETHER:
            self._write()

    def _write(self) -> None:
        """Write trials to the journal and tell of them; give up an agent that yields only errors."""
        finished, self._finished = self._finished, []
        if finished:
            self._journal.append_all(finished)
            self._wrote = time.monotonic()
        for trial, seconds, _ in finished:
            self._observer.trial(trial, seconds)
            self.ended += not trial.owed_again
            program = self._source.engine == "inline"
            counts = trial.owed_again or (program and trial.error is not None)  # a model's final errors are findings
            self._broken_in_a_row = self._broken_in_a_row + 1 if counts else 0
            most = max(GIVE_UP_AFTER, self._lanes + 1)  # one outage breaks all that is on its way
            if trial.error is not None and self._broken_in_a_row == most:
                why = f"{trial.error.boundary}: {trial.error.message}"
                raise UserMistake(f"{trial.group} broke {most} trials in a row ({why})")


def _player(spec: str, code: Iterable[str]) -> Callable[[Plan], tuple[bytes, float, Sequence[Picture]]]:
    """Build an agent in a worker, and return the function that plays plans with it."""
    allow(*code)
    if parent_process() is not None:  # a process of this machine; a node of a cluster says where it hangs itself
        PATIENCE.stuck = lose
    agent = resolve(spec).make()

    def play_one(plan: Plan) -> tuple[bytes, float, Sequence[Picture]]:
        taken = dict[str, Picture]()
        trial, seconds = asyncio.run(play_timed(plan, agent, keep=lambda one: taken.update({one.name: one})))
        return packed(trial), seconds, [*taken.values()]

    return play_one
