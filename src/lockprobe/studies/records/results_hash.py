"""The hash of what a study recorded: the same records give the same hash, whenever and in which order they were played.

It covers every record and the settings, and no clock reading. Put it under a paper, and the hash of the settings
(:attr:`lockprobe.studies.study.Study.settings_hash`) under a preregistration: ``lockprobe verify DIR --settings HASH
--results HASH`` holds a directory against both.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.decisions import planned_now
from lockprobe.studies.records.counted import Counted, count_records
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import read
from lockprobe.studies.records.trial_rows import unpacked
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_to_json

_DIGITS = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyHashes:
    """The hashes of what a directory holds now.

    Attributes:
        settings: Of the settings.
        results: Of the records.
        finished: Trials that are not owed.
        planned: Trials that are planned, those of people included; of a study that stops when it is decided, those that
            it has to play before its next look.
    """

    settings: str
    results: str
    finished: int
    planned: int

    @classmethod
    def of(cls, directory: Path) -> Self:
        """Compute them from the directory of a study.

        Raises:
            BadFile: If it is none, or a record is damaged.
        """
        study = read_study(directory)
        with read(directory) as store:
            results, found = stored_hash(store, study), count_records(store, study)
        return cls(
            settings=study.settings_hash,
            results=results,
            finished=finished_of(found),
            planned=planned_now(study, load(directory, study) if study.until else ()),
        )


def finished_of(records: Iterable[Counted]) -> int:
    """How many trials are not owed."""
    return sum(one.number for one in records if not one.trial.owed_again)


def check_hash(what: str, given: str | None) -> None:
    """Refuse what is no hash of a study.

    Raises:
        BadValue: If it is none.
    """
    if given is not None and not re.fullmatch(f"[0-9a-fA-F]{{{_DIGITS}}}", given.strip()):
        raise BadValue(what, given, f"the {_DIGITS} hexadecimal digits that lockprobe run and status print")


def stored_records(store: Database) -> Iterator[bytes]:
    """The records of a store that count as JSON, in the order of their keys: what the hash covers."""
    for key, record in store.rows("select key, record from trial where current and fork is null order by key"):
        yield unpacked(store, key, record)


def stored_hash(store: Database, study: Study) -> str:
    """:func:`results_hash` of a store; where nothing was recorded since a run has noted it, as it was noted.

    Raises:
        BadFile: If a record is damaged.
    """
    noted = store.first("select value from note where name = 'results'")
    state = _state(store, study.settings_hash)
    if noted is not None and str(noted[0]).startswith(state):
        return str(noted[0]).removeprefix(state)
    return _hash(study, stored_records(store))


def note_hash(store: Database, found: StudyHashes) -> None:
    """Note the hash of the results, so that nobody has to read all records for it again.

    Raises:
        BadFile: If it cannot be written.
    """
    with store.transaction() as writing:
        noted = _state(store, found.settings) + found.results
        writing.execute("insert or replace into note values ('results', ?)", (noted,))


def _state(store: Database, settings: str) -> str:
    """What the hash depends on: records are only added, and a withdrawal forgets the note."""
    last, number = store.one("select coalesce(max(id), 0), count(*) from trial where current")
    return f"{settings} {last} {number} "


def results_hash(study: Study, trials: Iterable[Trial]) -> str:
    """Thirty-two hexadecimal digits that change with any setting and any record.

    Args:
        study: The study.
        trials: Its trials on record, in any order.
    """
    return _hash(study, map(trial_to_json, sorted(trials, key=lambda trial: trial.key)))


def _hash(study: Study, records: Iterable[bytes]) -> str:
    """The hash of the settings and of the records, a line each: of ``export --table records``."""
    found = hashlib.sha256()
    for record in records:
        found.update(record + b"\n")
    return hashlib.sha256(f"{study.settings_hash} {found.hexdigest()}".encode()).hexdigest()[:_DIGITS]
