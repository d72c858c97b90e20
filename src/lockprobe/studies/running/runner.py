"""Runs a study: plays the trials that its journal still owes, and resumes where an earlier run stopped.

All agents share one path: plans that the journal still owes -> :func:`lockprobe.trial.loop.play` -> journal. Only the
place differs. Trials of hosted models are open at the same time in this process, because they wait for a provider.
Local models and simulated plants need a processor, so they play in worker processes, or on a cluster
(:mod:`lockprobe.studies.running.elsewhere`). Strategies begin in this process, and go on there if it takes longer. If
somebody attends the plant, everything plays in this process, one trial after the other.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, is_strategy, resolve
from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import (
    FINAL,
    AgentsGivenUp,
    BadFile,
    BadValue,
    BudgetReached,
    SettingsChanged,
    UserMistake,
)
from lockprobe.foundation.interrupts import interruptible
from lockprobe.foundation.workers import Cluster, Pool, Processes
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.decisions import GIVE_UP_AFTER, due
from lockprobe.studies.extension import extended
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.known_facts import KnownFacts
from lockprobe.studies.records.picture_store import ALBUM, Album
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing, TrialRow
from lockprobe.studies.running.elsewhere import can_travel, play_elsewhere
from lockprobe.studies.running.observer import Observer
from lockprobe.studies.running.trial_setup import closed_in_one_line, own_thread, play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.loop import Executor
from lockprobe.trial.loop import here as in_this_thread
from lockprobe.trial.model_call import OWED_ANEW, Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Closable
from lockprobe.trial.record import Fact, Step, Trial

_ALONE = 2.0
"""Seconds for which this process plays a strategy alone. Then others go on if as much is left; each takes a second to
start."""

_TOGETHER = 0.05
"""Seconds for which a strategy's finished trials may wait for others to be written with; a kill leaves them owed."""

_UNHEARD = 0.05
"""Seconds after which a run of trials that wait for nothing hears Ctrl-C, when the next trial ends."""

_INTERRUPTIBLE = 0.1
"""Seconds after which a thread that waits for another one notices an interrupt at the latest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits of concurrency; none of them changes a record.

    Attributes:
        workers: Processes for local models, simulated plants, and strategies with many trials.
        access: How hosted models are reached. As many of their trials are open at once as there are connections.
        cluster: Other machines for agents and plants that come with Lockprobe; None for this one alone.
    """

    workers: int = 1
    access: Access = field(default_factory=Access)
    cluster: Cluster | None = None


def next_plans(study: Study, journal: Journal) -> Callable[[str], Iterable[Plan]]:
    """Function from an agent to its plans: all, or those before the next look of a study that may stop there.

    All agents of the directory are judged together, those too that are not run now.
    """
    if study.until is None:
        return study.plans
    whole = replace(read_study(journal.directory), shard=study.shard)
    return lambda agent: due(whole, agent, journal.trials.values())


def _owed_plans(plans: Iterable[Plan], journal: Journal) -> list[Plan]:
    """The plans that a journal owes; those that were begun first, so that a small budget ends them."""
    owed = [plan for plan in plans if journal.owes(plan.key)]
    return sorted(owed, key=lambda plan: not journal.calls.has_replies(plan.key))


def run(
    study: Study,
    journal: Journal,
    *,
    limits: Limits | None = None,
    observer: Observer | None = None,
    plans: Callable[[str], Iterable[Plan]] | None = None,
    known: Iterable[Trial] = (),
) -> None:
    """Play what the journal owes of a study.

    Before a look of a study that stops when it is decided, all trials have to end. So those that broke are played
    again, as long as others end meanwhile.

    Args:
        study: The study.
        journal: Its journal, or another one, for other trials than its own.
        limits: Limits of concurrency.
        observer: Receives the progress.
        plans: Function from an agent to its plans; by default the study's own.
        known: Earlier trials of the same agents; model, prompt and runtime must be the same as in these.

    Raises:
        UserMistake: Before the first trial, if an agent or the plant is not available.
        BudgetReached: If the budget ended the trials of an agent; those of the others were played as far as it went.
        AgentsGivenUp: If agents could not go on, and the others were played.
        BadFile: If the directory cannot be written.
        SettingsChanged: If an agent or the plant is another one than that of the earlier trials.
        KeyboardInterrupt: On Ctrl-C; whatever was finished is on disk.
    """
    limits, observer = limits or Limits(), observer or Observer()
    of = plans or next_plans(study, journal)
    facts = KnownFacts((*known, *journal.kinds()))
    sources = _run_here(study, limits)
    owed = {source.spec: _owed_plans(of(source.spec), journal) for source in sources}
    sources = [source for source in sources if owed[source.spec]]
    for source in sources:
        source.check()
    plants = {study.plant_of(one): None for source in sources for one in study.conditions_of(source.spec)}
    for plant, box in product(plants, study.boxes):
        resolve_plant(plant).check(box)
    observer.begin(study, journal, sum(map(len, owed.values())))
    spent: BudgetReached | None = None
    given_up: dict[str, UserMistake] = {}
    for source in sources:
        now = owed[source.spec]
        observer.agent(source, len(now))
        try:
            while now:
                _play(study, source, now, journal, limits, observer, facts)
                ended = any(not journal.owes(plan.key) for plan in now)
                now = _owed_plans(of(source.spec), journal) if study.until and ended else []
                observer.more(len(now))
        except BudgetReached as reached:
            spent = reached
        except (BadFile, SettingsChanged):
            raise
        except UserMistake as why:
            if study.attended:  # whoever answers at the terminal answers for all agents
                raise
            given_up[source.spec] = why
            observer.given_up(source, len(_owed_plans(owed[source.spec], journal)), why)
    if spent or given_up:
        raise spent or AgentsGivenUp(given_up)


def _run_here(study: Study, limits: Limits) -> list[AgentSource]:
    """The agents to run, strategies first: all except people (who are invited) and clients (which connect).

    Raises:
        BadValue: If no agent remains, or one would have nothing to play.
    """
    sources = [resolve(spec, limits.access) for spec in study.agents]
    study.check_agents()
    if all(source.engine == "client" for source in sources):
        expected = "an agent that can be run; this one connects to the server that `lockprobe mcp` starts"
        raise BadValue("agent", sources[0].spec, expected)
    here = [source for source in sources if source.engine not in ("person", "client")]
    return sorted(here, key=lambda source: source.engine != "inline")


def _play(
    study: Study,
    source: AgentSource,
    plans: list[Plan],
    journal: Journal,
    limits: Limits,
    observer: Observer,
    known: KnownFacts,
) -> None:
    """Play the owed trials of one agent, at least one: here, elsewhere, or first here and then there."""
    album, queue, began = Album(journal.directory / ALBUM), deque(plans), time.monotonic()
    hosted = source.engine == "network" and not study.attended
    lanes = limits.access.connections if hosted else 1
    finish = _TrialWriter(source, journal, observer, lanes, known)
    quick = source.engine == "inline" and not study.simulated  # a trial takes a millisecond
    pool: Pool | None = None
    if not study.attended and source.engine != "network":
        if limits.cluster is not None and can_travel(study, source):
            pool = limits.cluster
        elif source.engine == "process" or (limits.workers > 1 and (not quick or can_travel(study, source))):
            pool = Processes(limits.workers)

    def takes_long() -> bool:
        took, played = time.monotonic() - began, len(plans) - len(queue)
        return pool is not None and took > _ALONE and took * len(queue) > _ALONE * played > 0

    async def here(place: Executor) -> None:
        agent = source.make()
        play = partial(
            play_timed, agent=agent, on_step=observer.step, keep=album.keep, calls=journal.calls, place=place
        )
        try:
            if source.engine == "network":
                finish.expect(agent.facts)
            await _in_lanes(queue, play, finish, lanes, takes_long)
        finally:
            if isinstance(agent, Closable):
                with closed_in_one_line("agent", source.spec):
                    await agent.aclose()

    try:
        if pool is None or (quick and isinstance(pool, Processes)):
            threaded = hosted and (study.simulated or study.has_pictures)
            with own_thread() if threaded else nullcontext(in_this_thread) as place:
                asyncio.run(here(place))
        if pool is not None and queue:
            identities = journal.identities
            play_elsewhere(queue, pool, observer.step, finish, identities=identities, album=album, live=not quick)
    finally:
        finish.write()


async def _in_lanes(
    queue: deque[Plan],
    play: Callable[[Plan], Awaitable[tuple[Trial, Timing]]],
    finish: Callable[[Trial, Timing], None],
    lanes: int,
    leave: Callable[[], bool],
) -> None:
    """Play plans in order, with so many open at once. Once ``leave`` says so, the others stay in the queue.

    An error other than a broken trial ends all trials, and those under way are cancelled. If the budget is reached, no
    trial is opened any more, and each open one goes on until it is refused a call itself.
    """
    spent = list[BudgetReached]()

    async def lane() -> None:
        heard = time.monotonic()
        while queue and not spent and not leave():
            try:
                finish(*await play(queue.popleft()))
            except BudgetReached as reached:
                spent.append(reached)
            if time.monotonic() - heard > _UNHEARD:
                await asyncio.sleep(0)
                heard = time.monotonic()

    opened = [asyncio.ensure_future(lane()) for _ in range(min(lanes, len(queue)))]
    try:
        await asyncio.gather(*opened)
    finally:
        for task in opened:
            task.cancel()
        await asyncio.gather(*opened, return_exceptions=True)
    if spent:
        raise spent[-1]


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


class _TrialWriter:
    """Writes finished trials to the journal, and gives up an agent that yields only errors.

    Strategies finish many trials in a moment, which are then written and told of together.
    """

    def __init__(
        self, source: AgentSource, journal: Journal, observer: Observer, lanes: int, known: KnownFacts
    ) -> None:
        self._spec = source.spec
        self._program, self._free = source.engine == "inline", is_strategy(source.spec)
        self._give_up_after = max(GIVE_UP_AFTER, lanes + 1)  # one outage breaks all that is on its way
        self._journal = journal
        self._observer = observer
        self._broken_in_a_row = 0
        self._known = known
        self._finished: list[tuple[Trial, Timing, TrialRow | None]] = []
        self._written = time.monotonic()

    def __call__(self, trial: Trial, timing: Timing, row: TrialRow | None = None) -> None:
        if different := self._known.differences(trial):
            said = {f"{who}, {name}": pair for (who, name), pair in different.items()}
            raise SettingsChanged(self._journal.directory, said)
        self._known.note(trial)
        self._finished.append((trial, timing, row))
        if not self._free or time.monotonic() - self._written > _TOGETHER:
            self.write()
        broken = trial.owed_again or (self._program and trial.error is not None)  # a model's final errors are findings
        self._broken_in_a_row = self._broken_in_a_row + 1 if broken else 0
        if trial.error is not None and self._broken_in_a_row == self._give_up_after:
            why = f"{trial.error.boundary}: {trial.error.message}"
            again = "" if trial.owed_again else f"; --again {trial.error.boundary} plays these anew"
            raise UserMistake(f"{trial.group} broke {self._broken_in_a_row} trials in a row ({why}){again}")

    def write(self) -> None:
        """Write what is finished, and then tell of it."""
        finished, self._finished = self._finished, []
        if finished:
            self._journal.append_all(finished)
            for trial, timing, _ in finished:
                self._observer.trial(trial, timing)
        self._written = time.monotonic()

    def expect(self, facts: Mapping[str, Fact]) -> None:
        """Refuse a changed agent (model, prompt, runtime) before it is called and paid.

        Raises:
            SettingsChanged: If the agent differs from the one that played before.
        """
        if different := self._known.differences_of(self._spec, facts):
            said = {f"{self._spec}, {name}": pair for name, pair in different.items()}
            raise SettingsChanged(self._journal.directory, said)


def owe_anew(journal: Journal, boundary: str) -> int:
    """Owe again every trial of a study that ended at a final error (``lockprobe run … --again``), and count them.

    An agent that never gave a usable reply, or refused, is a finding, so its trial is final. If the set-up was at
    fault, for example a server that left a field out, the trial can be played again: a copy of its record that says
    "again" follows the old record, and the new record counts the replays. The new trial makes new calls; the old ones
    count as spent. People's trials are left alone.

    Args:
        journal: The open journal of the study.
        boundary: ``reply`` or ``refusal``, whose errors are final.

    Raises:
        BadValue: If there is no such boundary, or its errors are always owed again.
        BadFile: If it cannot be written.
    """
    if boundary not in FINAL:
        raise BadValue("again", boundary, f"{' or '.join(FINAL)}; what broke elsewhere is owed without being asked for")
    asked = {call.key for call in read_calls(journal.directory)}
    found = 0
    for key in [key for key, one in journal.trials.items() if one.ending == "error" and not one.owed_again]:
        trial, timing = journal.read(key)
        error = trial.error
        if error is None or error.boundary != boundary or trial.player:
            continue
        if trial.key in asked:
            nothing = Call(
                key=trial.key,
                agent=trial.agent,
                condition=trial.condition,
                repetition=trial.repetition,
                trial=trial.trial,
                step=0,
                turn=0,
                request="",
                reply=None,
                error=OWED_ANEW,
            )
            journal.calls.write(nothing)
        journal.append(replace(trial, error=replace(error, again=True)), timing)
        found += 1
    return found
