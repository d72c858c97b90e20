"""The hash of what a study recorded: the same records give the same hash, whenever and in which order they were played.

It covers every record and the settings, and no clock reading. Put it under a paper, and the hash of the settings
(:attr:`lockprobe.studies.study.Study.settings_hash`) under a preregistration: ``lockprobe verify DIR --settings HASH
--results HASH`` holds a directory against both.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.records.trial_rows import unpacked
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_to_json

_DIGITS = 32


def check_hash(what: str, given: str | None) -> None:
    """Refuse what is no hash of a study."""
    if given is not None and not re.fullmatch(f"[0-9a-fA-F]{{{_DIGITS}}}", given.strip()):
        raise BadValue(what, given, f"the {_DIGITS} hexadecimal digits that lockprobe run prints")


def stored_records(store: Database) -> Iterator[bytes]:
    """The records of a store that count as JSON, in the order of their keys: what the hash covers."""
    for key, record in store.rows("select key, record from trial where current and fork is null order by key"):
        yield unpacked(store, key, record)


def stored_hash(store: Database, study: Study) -> str:
    """:func:`results_hash` of a store."""
    return _hash(study, stored_records(store))


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
