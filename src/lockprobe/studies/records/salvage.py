"""Saves what is sound of a damaged store: each row that can be read by its number, with a record that can be read."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.store import STORE, read, written
from lockprobe.studies.records.trial_rows import trial_in
from lockprobe.trial.trial_reader import TrialReader

_LEAST = 16
"""Bytes that a row takes at the least, where not even the number of the last one can be read."""


def save_sound_rows(directory: Path, into: Path) -> int:
    """Copy the settings and all that is sound into another directory, and return the number of trials there.

    Of a trial that was owed again the last sound record counts. A diary is kept up to its first damaged entry.

    Raises:
        BadFile: If the store is missing, or cannot even be opened.
    """
    reader, diaries = TrialReader(), Counter[str]()
    with read(directory) as damaged, written(into) as store, store.transaction() as writing:
        for table in ("trial", "call", "attempt", "act"):
            columns = [name for _, name, *_ in damaged.rows(f"pragma table_info({table})")]
            names, marks = ", ".join(columns), ", ".join("?" * len(columns))
            select = f"select {names} from {table} where id = ?"  # noqa: S608 - our own tables, here and below
            for number in range(1, _last(damaged, table) + 1):
                row = dict(zip(columns, _row(damaged, select, number), strict=False))
                if not row or (table == "act" and row["number"] != diaries[row["participant"]] + 1):
                    continue
                if table == "trial":
                    if not _is_sound(damaged, reader, row):
                        continue
                    writing.execute("update trial set current = 0 where current and key = ?", (row["key"],))
                    row["current"] = 1
                diaries.update([row["participant"]] if table == "act" else [])
                writing.execute(f"insert into {table} ({names}) values ({marks})", tuple(row.values()))  # noqa: S608
        with suppress(BadFile):
            writing.executemany(
                "insert into note values (?, ?)", damaged.rows("select * from note where name <> 'results'")
            )
        (saved,) = store.one("select count(*) from trial where current")
    shutil.copyfile(directory / SETTINGS, into / SETTINGS)
    return int(saved)


def _row(store: Database, sql: str, number: int) -> tuple[Any, ...]:
    """A row; empty if it is missing or damaged."""
    with suppress(BadFile):
        return next(store.rows(sql, number), ())
    return ()


def _is_sound(store: Database, reader: TrialReader, row: Mapping[str, Any]) -> bool:
    try:
        trial_in(store, reader, row["key"], row["record"])
    except BadFile:
        return False
    return True


def _last(store: Database, table: str) -> int:
    """The number of the last row of a table, or a bound of it."""
    try:
        (found,) = store.one(f"select max(id) from {table}")  # noqa: S608
    except BadFile:
        return (store.path.parent / STORE).stat().st_size // _LEAST
    return found or 0
