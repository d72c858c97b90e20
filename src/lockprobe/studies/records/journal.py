"""The open directory of a study: what it has, and where finished trials are written.

A study directory holds ``study.json`` (the settings), ``study.db`` (the records, :mod:`~.store`) and, where there are
pictures, the directory ``pictures``. With people, the directory ``people`` holds their texts and settings. A trial is
on record whole or not at all, and only one process writes at a time.

Records are only added, except that a participant's withdrawal deletes theirs (:meth:`Journal.delete_participant`).
Agents can be added to a study that has been played, it can be extended, and it can ask something else; no other setting
can change after the first trial.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from lockprobe.agents.catalogue import SAME_IN_ALL_TRIALS
from lockprobe.foundation.errors import BadFile, DirectoryBusy, SettingsChanged
from lockprobe.foundation.spec import MCP, spec_kind
from lockprobe.foundation.storage.atomic_file import refuse_links, write_file, writing
from lockprobe.foundation.storage.database import Database, rescued_files
from lockprobe.studies import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import on_record
from lockprobe.studies.records.store import INSERT, SCHEMA, STORE, OnRecord, last_rows, row_of, trials_in
from lockprobe.studies.study import SIZES, Study, settings_of
from lockprobe.trial.record import Fact, Trial

_LOCK = ".lock"
"""The file that is locked where directories are not."""

_PLANT_FACTS = ("engine", "renderer")
"""Facts about a plant that its pictures depend on and its spec does not hold."""

_KINDS = "id in (select max(id) from trial where current group by identity, agent, ending, boundary)"
"""The last trial of every agent under every condition, and that of every kind of ending."""

Facts = dict[tuple[str, str], Fact]
"""Whose fact, and its name -> its value."""


def facts_said(trial: Trial) -> Facts:
    """What a trial says of its agent (model, prompt, runtime) and of its plant (engine, renderer).

    People's devices and clients' connections may differ from trial to trial.
    """
    own, plant = {} if trial.player else trial.facts, f"the plant {trial.plant.get('plant', '')}".rstrip()
    same = SAME_IN_ALL_TRIALS if spec_kind(trial.agent) == MCP else own
    of_agent = {(trial.agent, name): own[name] for name in same if name in own}
    return of_agent | {(plant, name): trial.plant[name] for name in _PLANT_FACTS if name in trial.plant}


def note(known: Facts, said: Mapping[tuple[str, str], Fact]) -> dict[tuple[str, str], tuple[Fact, Fact]]:
    """Add facts to those that are known, and return those that were known with another value, with both.

    One that is None is not known: a renderer, for one, is so only after a picture.
    """
    new = {what: value for what, value in said.items() if value is not None}
    return {
        what: (before, new[what]) for what in sorted(new) if (before := known.setdefault(what, new[what])) != new[what]
    }


class Journal:
    """The open journal of one study. Use :meth:`open`.

    Attributes:
        directory: The directory of the study.
        study: The study there, with all its agents.
        store: The store in it.
        trials: Finished and broken trials by key.
        calls: The log of provider calls.
    """

    def __init__(self, directory: Path, study: Study, store: Database) -> None:
        self.directory, self.study, self.store = directory, study, store
        self.trials = on_record(store, study)
        self.calls = Calls(store)
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}

    @classmethod
    @contextmanager
    def open(cls, directory: Path | str, study: Study) -> Iterator[Journal]:
        """Open a directory for writing, new or to resume.

        If an error occurs before anything was recorded, it is as it was before, unless people were invited.

        Raises:
            SettingsChanged: If a study with other settings lives there.
            DirectoryBusy: If another process is writing there.
            BadFile: If it cannot be made, a link inside it leads elsewhere, or it holds something that cannot be read.
        """
        path = Path(directory)
        new = [one for one in (path, *path.parents) if not one.exists()]
        settings, people, ended = path / SETTINGS, path / PEOPLE_DIRECTORY, False
        refuse_links(path)
        for one in (settings, path / STORE, people):  # it may have no settings yet by which it is known
            refuse_links(one, within=path)
        with ExitStack() as held:
            with writing(path):
                path.mkdir(parents=True, exist_ok=True)
                _lock(path, held)
            missing = [path / _LOCK, *(one for one in (settings, path / STORE) if not one.exists())]
            before, invited = settings.read_bytes() if settings.is_file() else None, people.exists()
            recorded = last_rows(path)
            try:
                with Database.writing(path / STORE, SCHEMA) as store:
                    journal = cls(path, _claimed(path, study, recorded), store)
                    journal.erase()
                    yield journal
                ended = True
            finally:
                with suppress(OSError, BadFile):
                    if not ended and people.exists() == invited and last_rows(path) == recorded:
                        for one in missing:
                            one.unlink(missing_ok=True)
                        if before is not None and settings.read_bytes() != before:
                            write_file(settings, before)
                        for one in new:
                            one.rmdir()

    @cached_property
    def known(self) -> Facts:
        """What agents and plants said of themselves on record, so that no other one goes by their name."""
        known = Facts()
        for trial in trials_in(self.store, _KINDS):
            note(known, facts_said(trial))
        return known

    def owes(self, key: str) -> bool:
        """Whether a trial is owed: not finished, or broken by something outside the agent."""
        trial = self.trials.get(key)
        return trial is None or trial.owed_again

    def refuse_others(self, said: Mapping[tuple[str, str], Fact]) -> None:
        """Refuse an agent or a plant that says something else of itself than in the trials on record.

        Raises:
            SettingsChanged: If there is any difference.
        """
        if different := note(self.known, said):
            raise SettingsChanged(self.directory, {f"{who}, {name}": pair for (who, name), pair in different.items()})

    def append(self, trial: Trial, seconds: float, record: bytes | None = None) -> None:
        """Write a finished trial, as :meth:`append_all` does several."""
        self.append_all([(trial, seconds, record)])

    def append_all(self, finished: Sequence[tuple[Trial, float, bytes | None]]) -> None:
        """Write finished trials whole or not at all, in place of earlier records of those that were owed again.

        Args:
            finished: Each trial, how long it took, and the same packed for the store, if another process has done that.

        Raises:
            BadFile: If it cannot be written, or somebody else deleted or replaced the file; see :class:`Database`.
        """
        known = {trial.key: OnRecord.of(trial) for trial, _, _ in finished}
        with self.store.transaction() as writing:
            for trial, seconds, record in finished:
                if trial.key in self.trials:
                    writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
                writing.execute(INSERT, row_of(trial, seconds, self._identities[trial.condition], record))
        self.trials |= known
        for trial, _, _ in finished:
            if not trial.owed_again:
                self.calls.forget(trial.key)

    def read(self, key: str) -> Trial:
        """A trial on record."""
        (trial,) = trials_in(self.store, "current and key = ?", key)
        return trial

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
        self.trials = on_record(self.store, self.study)  # a row of somebody else may count again

    def erase(self) -> None:
        """Leave no byte of people who withdrew. If it is not done, the next opening does it."""
        if self.store.one("select count(*) from note where name = 'erasing'")[0]:
            self.store.erase()
            with self.store.transaction(sync=True) as writing:
                writing.execute("delete from note where name = 'erasing'")


def _lock(directory: Path, held: ExitStack) -> None:
    """Lock a directory against other writers, or a file in it where the file system locks no directories."""
    for path, flags in ((directory, os.O_RDONLY), (directory / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)):
        held.callback(os.close, handle := os.open(path, flags, 0o600))
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DirectoryBusy(directory) from None
        except OSError:  # a file system without any locks writes without them
            continue
        return


def is_being_written(directory: Path) -> bool:
    """Whether a process has a journal of the directory open; False where the file system has no locks."""
    handle = os.open(directory, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(handle)
    return False


def _claimed(directory: Path, study: Study, recorded: Mapping[str, int]) -> Study:
    """The study that is played in a directory, after its settings were checked there, or written.

    Agents are added to those that are there. What the settings say of earlier sizes is never forgotten, nor are
    contrasts, unless the study has others. A study that was extended (:func:`extended`) may have another size.
    """
    path, played = directory / SETTINGS, any(recorded[table] for table in ("trial", "call", "attempt"))
    if played and not path.exists():
        raise BadFile(directory, f"holds {STORE} but no {SETTINGS}: put it back, or give another --out")
    if played or (path.exists() and recorded["act"]):  # who has joined plays this study
        there = read_study(directory)
        if different := study.differences(there, but=SIZES if len(there.earlier) < len(study.earlier) else ()):
            for name in ("trials", "strategy_trials") if (boxes := len(study.boxes)) == len(there.boxes) > 1 else ():
                if different.pop(name, None):  # as they are typed
                    own, asked = getattr(there, name), getattr(study, name)
                    different[f"{name} on each of {boxes} boxes"] = own and own // boxes, asked and asked // boxes
            raise SettingsChanged(directory, different)
        study = replace(
            study.ordered_as(there),
            agents=there.joined(study.agents),
            names={**there.names, **study.names},
            shard=study.shard if study.shard == there.shard else None,  # of several parts it holds the whole
            earlier=max(there.earlier, study.earlier, key=len),
            contrasts=study.contrasts or there.contrasts,
        )
    write_file(path, f"{json.dumps(settings_of(study), indent=2)}\n")
    return study


def _delete(store: Database, player: str) -> None:
    with store.transaction(sync=True) as writing:
        done = writing.execute("delete from act where participant = ?", (player.partition(":")[2],)).rowcount
        done += writing.execute("delete from trial where player = ?", (player,)).rowcount
        writing.execute("update trial set current = id in (select max(id) from trial group by key)")
        count = "insert into note values (?, 1) on conflict do update set value = value + 1"
        writing.executemany(count, [("withdrawn",), ("erasing",)] if done else [])
