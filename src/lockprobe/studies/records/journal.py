"""The open directory of a study: what it has, and where finished trials are written.

A study directory holds ``study.json`` (the settings), ``study.db`` (the records, :mod:`~.store`) and, where there are
pictures, the directory ``pictures``. With people, the directory ``people`` holds their texts and settings. A trial is
on record whole or not at all, and only one process writes at a time.

Records are only added, except that a participant's withdrawal deletes theirs (:meth:`Journal.delete_participant`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

from lockprobe.agents.catalogue import SAME_IN_ALL_TRIALS
from lockprobe.foundation.errors import SettingsChanged
from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.foundation.storage.database import Database, rescued_files
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.records.directory import claim, locked_store, read_study
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import INSERT, SCHEMA, STORE, OnRecord, row_of, trials_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Fact, Trial

_PLANT_FACTS = ("engine", "renderer")
"""Facts about a plant that its pictures depend on and its spec does not hold."""


Different = dict[tuple[str, str], tuple[Fact, Fact]]
"""Whose fact, and its name -> what it was, and what it is."""

_KINDS = "id in (select max(id) from trial where current group by identity, agent, ending, boundary)"


class KnownFacts:
    """What is known of agents (model, prompt, runtime) and of plants (engine, renderer) from these trials."""

    def __init__(self, trials: Iterable[Trial] = ()) -> None:
        self._known: dict[tuple[str, str], Fact] = {}
        for trial in trials:
            self.note(trial)

    def note(self, trial: Trial) -> Different:
        """Add what a trial says, and return what it says otherwise than before: whose fact, and its name -> both."""
        found, own, plant = Different(), trial.facts, trial.plant
        if trial.player or spec_kind(trial.agent) == MCP:  # people's devices and clients' connections may differ
            own = {name: own[name] for name in SAME_IN_ALL_TRIALS if name in own and not trial.player}
        shown = {name: plant[name] for name in _PLANT_FACTS if name in plant}
        for who, facts in ((trial.agent, own), (f"the plant {plant.get('plant', '')}", shown)):
            found |= self.differences(who.rstrip(), facts) if facts else {}
            for name, value in facts.items():
                if value is not None:  # a renderer, for one, is known only after a picture
                    self._known.setdefault((who.rstrip(), name), value)
        return found

    def differences(self, who: str, facts: Mapping[str, Fact]) -> Different:
        """The facts of an agent, or of a plant, that are known with another value, with both."""
        known = {name: self._known.get((who, name)) for name in sorted(facts)}
        return {
            (who, name): (value, facts[name])
            for name, value in known.items()
            if value is not None and facts[name] is not None and value != facts[name]
        }


class Journal:
    """The open journal of one study. Use :meth:`open`.

    Attributes:
        directory: The directory of the study.
        store: The store in it.
        trials: Finished and broken trials by key.
        calls: The log of provider calls.
    """

    def __init__(self, directory: Path, study: Study, store: Database) -> None:
        self.directory, self.store = directory, store
        self.trials = on_record(store, read_study(directory))
        self.calls = Calls(store)
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}

    @classmethod
    @contextmanager
    def open(cls, directory: Path | str, study: Study) -> Iterator[Journal]:
        """Open a directory for writing, new or to resume. A failed start leaves it unchanged.

        Raises:
            SettingsChanged: If a study with other settings lives there.
            DirectoryBusy: If another process is writing there.
            BadFile: If it holds something that cannot be read.
        """
        directory = Path(directory)
        with locked_store(directory) as store:
            claim(directory, study)
            journal = cls(directory, study, store)
            journal.erase()
            yield journal

    @cached_property
    def known(self) -> KnownFacts:
        """What agents and plants said of themselves on record, so that no other one goes by their name."""
        return KnownFacts(self.kinds())

    def owes(self, key: str) -> bool:
        """Whether a trial is owed: not finished, or broken by something outside the agent."""
        trial = self.trials.get(key)
        return trial is None or trial.owed_again

    def refuse(self, different: Different) -> None:
        """Refuse an agent or a plant that is another one than in the trials on record.

        Raises:
            SettingsChanged: If there is any difference.
        """
        if different:
            raise SettingsChanged(self.directory, {f"{who}, {name}": pair for (who, name), pair in different.items()})

    def append(self, trial: Trial, seconds: float, record: bytes | None = None) -> None:
        """Write a finished trial, in place of an earlier record of one that was owed again.

        Args:
            trial: The trial.
            seconds: How long it took.
            record: The same packed for the store, if another process has done that.

        Raises:
            BadFile: If it cannot be written, or somebody else deleted or replaced the file; see :class:`Database`.
        """
        with self.store.transaction() as writing:
            if trial.key in self.trials:
                writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
            writing.execute(INSERT, row_of(trial, seconds, self._identities[trial.condition], record))
        place = trial.condition, trial.repetition, trial.trial
        ended = trial.ending, trial.owed_again, len(trial.steps)
        self.trials[trial.key] = OnRecord(trial.key, trial.spec, trial.group, trial.player, *place, *ended)
        if not trial.owed_again:
            self.calls.forget(trial.key)

    def read(self, key: str) -> Trial:
        """A trial on record."""
        (trial,) = trials_in(self.store, "current and key = ?", key)
        return trial

    def kinds(self) -> Iterator[Trial]:
        """The last trial of every agent under every condition, and that of every kind of ending."""
        return trials_in(self.store, _KINDS)

    def delete_participant(self, player: str) -> None:
        """Delete what a person did and their records, and count that they withdrew. :meth:`erase` leaves no byte.

        Copies that were rescued lose them first. Where somebody else has played a trial of theirs, that record counts.

        Raises:
            BadFile: If it cannot be written; then nothing is deleted here.
        """
        for rescued in rescued_files(self.directory / STORE):
            with Database.writing(rescued, SCHEMA) as store:
                _delete(store, player)
                store.erase()
        _delete(self.store, player)
        self.trials = on_record(self.store, read_study(self.directory))  # a row of somebody else may count again

    def erase(self) -> None:
        """Leave no byte of people who withdrew. If it is not done, the next opening does it."""
        if self.store.one("select count(*) from note where name = 'erasing'")[0]:
            self.store.erase()
            with self.store.transaction(sync=True) as writing:
                writing.execute("delete from note where name = 'erasing'")


def _delete(store: Database, player: str) -> None:
    with store.transaction(sync=True) as writing:
        done = writing.execute("delete from act where participant = ?", (player.partition(":")[2],)).rowcount
        done += writing.execute("delete from trial where player = ?", (player,)).rowcount
        writing.execute("update trial set current = id in (select max(id) from trial group by key)")
        count = "insert into note values (?, 1) on conflict do update set value = value + 1"
        writing.executemany(count, [("withdrawn",), ("erasing",)] if done else [])
