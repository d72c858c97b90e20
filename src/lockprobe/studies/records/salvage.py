"""Saves what is sound of a damaged store: each row that can be read by its number and says something that can be true.

A record has a checksum and says what its row does; that is made anew from it.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.storage.database import Damaged, Database
from lockprobe.studies.costs.call_log import logged_call
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.attempt_log import attempt_entry
from lockprobe.studies.records.store import checksum, read, write_acts, written
from lockprobe.studies.records.trial_rows import INSERT, Timing, row_of, unpacked
from lockprobe.trial.trial_json import TrialReader

_LEAST = 16
"""Bytes that a row takes at the least."""

_DELETED = 1_000_000
"""So many more rows may have been there before."""

_COLUMNS = {
    "trial": "real seconds, text cpu, text identity, blob record",
    "call": "text key, text? asked, text? answer, integer crc",
    "attempt": "text key, text entry, integer crc",
    "act": "text participant, integer number, text entry, integer crc",
}
"""Columns with their types."""


def save_sound_rows(directory: Path, into: Path) -> int:
    """Copy the settings and all that is sound into another directory, and return the number of trials there.

    Of a trial that was owed again the last sound record counts. A diary is kept up to its first damaged entry.

    Raises:
        BadFile: If the store is missing, or cannot even be opened.
    """
    reader, diaries = TrialReader(), dict[str, list[str]]()
    with read(directory) as damaged, written(into) as store, store.transaction() as writing:
        for _, seconds, cpu, identity, record in _rows(damaged, "trial"):
            with suppress(BadFile, BadValue):
                trial = reader.read(unpacked(damaged, "", record))
                timing = Timing(key=trial.key, seconds=seconds, steps=len(trial.steps), cpu=cpu)
                writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
                writing.execute(INSERT, row_of(trial, timing, identity))
        for row in _rows(damaged, "call"):
            with suppress(Damaged):
                logged_call(damaged, *row)
                writing.execute("insert into call values (?, ?, ?, ?, ?)", row)
        for row in _rows(damaged, "attempt"):
            with suppress(Damaged):
                attempt_entry(damaged, *row)
                writing.execute("insert into attempt values (?, ?, ?, ?)", row)
        for _, participant, number, entry, crc in _rows(damaged, "act"):
            there = diaries.setdefault(participant, [])
            if number == len(there) + 1 and crc == checksum(participant, number, entry):
                there.append(entry)
        for participant, entries in diaries.items():
            write_acts(writing, participant, 1, entries)
        with suppress(BadFile):
            writing.executemany("insert into note values (?, ?)", damaged.rows("select name, value from note"))
        (saved,) = store.one("select count(*) from trial where current")
    shutil.copyfile(directory / SETTINGS, into / SETTINGS)
    return int(saved)


def _rows(store: Database, table: str) -> Iterator[tuple[Any, ...]]:
    """The rows of a table that can be read and have values of these types, each with its number."""
    kinds, names = zip(*(one.split() for one in _COLUMNS[table].split(", ")), strict=True)
    typed = " and ".join(
        f"({name} is null or typeof({name}) = '{kind[:-1]}')" if kind.endswith("?") else f"typeof({name}) = '{kind}'"
        for kind, name in zip(kinds, names, strict=True)
    )
    select = f"select id, {', '.join(names)} from {table} where id = ? and {typed}"  # noqa: S608 - our own tables
    last = store.path.stat().st_size // _LEAST
    with suppress(BadFile):  # or else a bound of the number of the last row
        last = min(store.one(f"select coalesce(max(id), 0) from {table}")[0], last + _DELETED)  # noqa: S608
    for number in range(1, last + 1):
        with suppress(BadFile):
            yield from store.rows(select, number, nulls=True)
