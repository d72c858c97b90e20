"""Reads the records of a study (``study.db``), all of which are of the study in ``study.json``.

The hash of what a study recorded covers every record and the settings, and no clock reading: the same records give the
same hash, whenever and in which order they were played. Put it under a paper, and the hash of the settings
(:attr:`lockprobe.studies.study.Study.settings_hash`) under a preregistration: ``lockprobe verify DIR --settings HASH
--results HASH`` holds a directory against both.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from functools import partial
from operator import itemgetter
from pathlib import Path
from sys import intern
from typing import NamedTuple

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.database import Database
from lockprobe.studies import SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.shorthand import ShorthandReader
from lockprobe.studies.records.store import COLUMNS, OnRecord, check_row, read, row_of, trial_in, trials_in, unpacked
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial, TrialName
from lockprobe.trial.trial_json import TrialReader


def load(directory: Path | str) -> list[Trial]:
    """Load the trials of a study directory, in the order in which they were finished.

    Where a trial was played again after an error, the last record counts.

    Raises:
        BadFile: If there is no study, or a record is damaged or of another study.
    """
    study = read_study(directory)
    with read(directory) as store:
        tally(store, study)
        return [*trials_in(store, "current")]


def played(directory: Path | str, study: Study) -> tuple[list[Trial], str]:
    """The trials of :func:`load` as numbers are made of them, without their words, and the hash of all records.

    They are in the order in which they were finished. One record after the other is read and dropped.

    Raises:
        BadFile: If there is no study, or a record is damaged or of another study.
    """
    shorthand, reader, found = ShorthandReader(), TrialReader(), list[tuple[int, Trial]]()
    columns = "id, record, crc, key, repetition, trial, ending, kind, shorthand"

    def records(store: Database) -> Iterator[bytes]:
        select = f"select {columns} from trial where current order by key"  # noqa: S608 - our own columns
        for row, record, crc, *short in store.rows(select):
            key, repetition, number, ending, kind, written = short
            check_row(store, f"{key}, in shorthand", crc, *short)
            place = {"key": key, "repetition": repetition, "trial": number, "ending": ending}
            whole = partial(trial_in, store, reader, key, record)
            found.append((row, shorthand.read(kind, written, whole, **place)))
            yield unpacked(store, key, record)

    with read(directory) as store:
        tally(store, study)
        hashed = results_hash(study, records(store))
    return [trial for _, trial in sorted(found, key=itemgetter(0))], hashed


def replaced_records(directory: Path | str) -> list[Trial]:
    """The records of trials that were owed again, in the order in which they were written."""
    with read(directory) as store:
        return [*trials_in(store, "not current")]


def on_record(store: Database, study: Study) -> dict[str, OnRecord]:
    """The trials of :func:`load` by key, from their rows alone: whether a record is damaged, who reads it finds."""
    tally(store, study)
    found = dict[str, OnRecord]()
    select = (
        "select key, agent, player, condition, repetition, trial, ending, owed from trial where current order by id"
    )
    for key, agent, player, condition, repetition, trial, ending, owed in store.rows(select):
        spec, label, end = map(intern, (agent, condition, ending))
        place = label, repetition, trial
        found[key] = OnRecord(key, spec, study.label_of(spec), player, *place, end, bool(owed))
    return found


class Tally(NamedTuple):
    """Trials on record that were played by the same agent, or person, under one condition and ended alike.

    Attributes:
        first: The number of the row of the first of them.
        boundary: That of their errors; empty without one.
        seconds: How long all of them took.
    """

    first: int
    agent: str
    player: str
    ending: str
    boundary: str
    owed_again: bool
    number: int
    steps: int
    seconds: float


def tally(store: Database, study: Study) -> list[Tally]:
    """The trials of a study that count, counted in the store.

    Raises:
        BadFile: If some are of another study: somebody has changed its settings by hand, or put another store there.
            Records of one name and one seed can differ in what acted in them, so that none of them is left out or
            taken for another one.
    """
    known, found = {one.label: study.record_identity(one) for one in study.conditions}, list[Tally]()
    for first, identity, fewest, most, earliest, last, *counted in store.rows(
        "select min(id), identity, min(trial), max(trial), min(repetition), max(repetition), agent, player, ending, "
        "boundary, owed, count(*), sum(steps), sum(seconds) from trial where current "
        "group by identity, agent, ending, boundary, owed, player order by min(id)"
    ):
        one = Tally(first, *counted)
        select = "select key, condition, repetition, trial from trial where id = ?"
        key, condition, repetition, trial = store.one(select, first)
        name = str(TrialName(study.name, study.label_of(one.agent), condition, repetition, trial))
        if (
            identity != known.get(condition)
            or one.agent not in study.agents
            or not 1 <= fewest <= most <= study.trials_of(one.agent)
            or not 1 <= earliest <= last <= study.repetitions
            or not (key == name or key.startswith(f"{name}/"))  # a fork has the name of its trial first
        ):
            why = f"holds {key}, which is no trial of the study in {SETTINGS}: put back the one that belongs to it"
            raise BadFile(store.path, why)
        found.append(one)
    return found


def rows_and_records(store: Database) -> Iterator[tuple[Trial, bool, str]]:
    """Every trial as on record, whether that record counts, and what its row says otherwise, if anything."""
    reader, select = TrialReader(), f"select current, {', '.join(COLUMNS)} from trial order by id"  # noqa: S608 - ours
    for current, *columns in store.rows(select, nulls=True):
        row = dict(zip(COLUMNS, columns, strict=True))
        trial = trial_in(store, reader, row["key"], row["record"])
        made = row_of(trial, row["seconds"], row["identity"], row["record"])
        different = ", ".join(name for name, one in zip(COLUMNS, made, strict=True) if one != row[name])
        yield trial, bool(current), f"{trial.key}: its {different} are not those of its record" if different else ""


def miscounted(store: Database) -> Iterator[str]:
    """Trials of which a record counts that is not the last one, or follows a finished one."""
    found = "group by key having max(id) > max(id * current) or total(not current and not owed)"
    for (key,) in store.rows(f"select key from trial {found}"):  # noqa: S608 - ours
        yield f"{key}: its last record does not count, or an earlier one is finished"


def stored_records(store: Database) -> Iterator[bytes]:
    """The records of a store that count as JSON, in the order of their keys: what the hash covers."""
    for key, record in store.rows("select key, record from trial where current and fork is null order by key"):
        yield unpacked(store, key, record)


def results_hash(study: Study, records: Iterable[bytes]) -> str:
    """Thirty-two hexadecimal digits that change with any setting and any record.

    Args:
        study: The study.
        records: Its records in the order of their keys, a line each of ``export --table records``.
    """
    found = hashlib.sha256()
    for record in records:
        found.update(record + b"\n")
    return hashlib.sha256(f"{study.settings_hash} {found.hexdigest()}".encode()).hexdigest()[:32]
