"""Merges trials that were played elsewhere, in other directories, into the directory of a study: whole or not at all.

Only trials of the same study are merged: all settings except the agents must be equal. A finished trial of the
directory stays; an owed or broken trial is replaced. For a trial that is finished nowhere the calls are merged, so that
it resumes from paid replies. Of a damaged store what is sound can be saved into another one, which is then merged.
"""

from __future__ import annotations

import json
import shutil
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from sqlite3 import Connection
from typing import Any

from lockprobe.agents.catalogue import check_outside
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.database import Database
from lockprobe.studies import SETTINGS
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal, facts_said, note
from lockprobe.studies.records.read_records import tally
from lockprobe.studies.records.store import (
    ALBUM,
    INSERT,
    SCHEMA,
    STORE,
    checksum,
    keep_picture,
    read,
    row_of,
    trial_in,
    trials_in,
    unpacked,
)
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.trial_json import TrialReader


@dataclass(slots=True, kw_only=True)
class Gathered:
    """The counts of a merge.

    Attributes:
        taken: Trials added to the directory.
        there: Trials that the directory had already finished.
        different: Trials finished on both sides with different records; the directory's records stay.
        unfinished: Trials begun in a source and finished nowhere; they are owed.
        replies: Replies added for unfinished trials, which resume from them.
        agents: Agents that were new to the study.
    """

    taken: int = 0
    there: int = 0
    different: int = 0
    unfinished: int = 0
    replies: int = 0
    agents: tuple[str, ...] = ()


def check_source(directory: Path) -> None:
    """Refuse a directory in which something is damaged, or which is not that of a study."""
    with read(directory) as store:
        tally(store, read_study(directory))
        deque(trials_in(store, "true"), maxlen=0)
    read_calls(directory)
    AttemptLog.read(directory)


def gather(
    directory: Path, sources: Sequence[Path], beside: Callable[[Journal], None] = lambda journal: None
) -> Gathered:
    """Merge other directories into one, which is created if missing: all of them or nothing. Idempotent.

    Args:
        directory: The directory of the study.
        sources: One or more; earlier ones have precedence.
        beside: Called with the journal of the merged directory while it is still open.

    Raises:
        BadFile: If trials belong to another study, two agents have the same name, another agent or plant played one of
            them, or something in a source is damaged.
        DirectoryBusy: If another process is writing there.
    """
    known, theirs = read_study(directory) if (directory / SETTINGS).exists() else None, [*map(read_study, sources)]
    studies = [known, *theirs] if known else theirs
    names = {spec: name for one in reversed(studies) for spec, name in one.names.items()}
    agents = tuple(dict.fromkeys(agent for one in studies for agent in one.agents))
    joined = replace(studies[0], agents=agents, names=names, shard=None)
    for source, study in zip(sources, theirs, strict=True):
        for name, values in joined.differences(study).items():
            there, asked = (repr(one)[:200] for one in values)
            why = f"trials of another study than {directory} ({name} is {there}, not {asked})"
            raise BadFile(source, why)
    joined = replace(joined, earlier=max((one.earlier for one in studies), key=len))  # of the one extended most often
    found = Gathered(agents=joined.labels[len(known.agents) if known else 0 :])
    with Journal.open(directory, joined) as journal, journal.store.transaction(sync=True) as writing:
        begun = [_take(journal, source, writing, found) for source in sources]
        for calls, taken in begun:
            own = _calls(journal.store)
            for key, logged in calls.items():
                mine = Counter(own.get(key, ()))
                if key in taken or (journal.owes(key) and mine <= Counter(logged)):  # else it began otherwise
                    missing = [*(Counter(logged) - mine).elements()]
                    writing.executemany("insert into call (key, call, crc) values (?, ?, ?)", missing)
                    replies = sum(json.loads(call).get("reply") is not None for _, call, _ in missing)
                    found.replies += replies * (key not in taken)
        found.unfinished = sum(map(journal.owes, {key for calls, _ in begun for key in calls}))
        beside(journal)
    return found


def _take(
    journal: Journal, source: Path, writing: Connection, found: Gathered
) -> tuple[dict[str, list[tuple[Any, ...]]], set[str]]:
    """Take the finished trials of a source with their attempts and pictures; its calls, and what was taken.

    Different models, prompts, runtimes or renderers under one name are refused, as by a resumed run.
    """
    reader, log, taken = TrialReader(), AttemptLog(journal.store), set[str]()
    with read(source) as store:
        calls = _calls(store)
        attempts = grouped(store.rows("select * from attempt order by id", nulls=True), lambda row: row[1])
        select = "select key, seconds, record from trial where current and not owed order by id"
        for key, seconds, record in store.rows(select):
            trial = trial_in(store, reader, key, record)
            if trial.player:
                check_outside(trial.player, PEOPLE)
            for (who, name), (here, there) in note(journal.known, facts_said(trial)).items():
                why = f"{who} is not the same there ({name} is {there!r}, {here!r} in {journal.directory})"
                raise BadFile(source, f"0 trials taken: {why}; import it into another directory")
            if not journal.owes(key):
                found.there += 1
                found.different += journal.read(key) != trial
                continue
            if key in log.times_begun:
                log.write(key, "broke")
            rows = ((None, *row[1:]) for row in attempts.get(key, ()))
            writing.executemany("insert into attempt values (?, ?, ?, ?, ?, ?, ?, ?)", rows)
            for path in (source / ALBUM / name for name in trial.picture_names):
                if path.is_file():
                    keep_picture(journal.directory / ALBUM, Picture(kind="rgb", png=read_input(path)))
            journal.append(trial, seconds, record)
            taken.add(key)
        for (key,) in store.rows("select key from trial where current and owed"):
            calls.setdefault(key, [])
    found.taken += len(taken)
    return calls, taken


def _calls(store: Database) -> dict[str, list[tuple[Any, ...]]]:
    """The key of a trial -> the rows of its calls."""
    return grouped(store.rows("select key, call, crc from call order by id"), lambda row: row[0])


_LOGS = {
    "call": "key, call, crc",
    "attempt": "key, kind, joint, claimed, told, hypothesis, crc",
    "act": "participant, number, entry, crc",
}
"""Tables whose rows have a checksum, with their columns."""


def save_sound_rows(directory: Path, into: Path) -> int:
    """Copy the settings and all that is sound into another directory, and return the number of trials there.

    A row is sound that can be read by its number and has its checksum; a trial's is made anew from its record. Of a
    trial that was owed again the last sound record counts. A diary is kept up to its first damaged entry.

    Raises:
        BadFile: If the store is missing, or cannot even be opened.
    """
    study, reader, diaries = read_study(directory), TrialReader(), Counter[str]()
    with read(directory) as damaged, Database.writing(into / STORE, SCHEMA) as store, store.transaction() as writing:
        known = {one.label: study.record_identity(one) for one in study.conditions}
        for _, seconds, identity, record in _rows(damaged, "trial", "seconds, identity, record"):
            with suppress(BadFile, BadValue):
                trial = reader.read(unpacked(damaged, "", record))
                if isinstance(seconds, float) and identity == known.get(trial.condition):
                    writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
                    writing.execute(INSERT, row_of(trial, seconds, identity))
        for table, columns in _LOGS.items():
            for number, *row, crc in _rows(damaged, table, columns):
                if crc == checksum(*row) and (table != "act" or row[1] == diaries[row[0]] + 1):
                    writing.execute(f"insert into {table} values (?, {'?, ' * len(row)} ?)", (number, *row, crc))  # noqa: S608
                    diaries[row[0]] += table == "act"
        with suppress(BadFile):
            writing.executemany("insert into note values (?, ?)", damaged.rows("select name, value from note"))
        (saved,) = store.one("select count(*) from trial where current")
    shutil.copyfile(directory / SETTINGS, into / SETTINGS)
    return int(saved)


def _rows(store: Database, table: str, columns: str) -> Iterator[tuple[Any, ...]]:
    """The rows of a table that can be read, each with its number."""
    last = store.path.stat().st_size // 16  # a bound of its number, as every row takes so many bytes at the least
    with suppress(BadFile):
        last = min(store.one(f"select coalesce(max(id), 0) from {table}")[0], last)  # noqa: S608
    for number in range(1, last + 1):
        with suppress(BadFile):
            yield from store.rows(f"select id, {columns} from {table} where id = ?", number, nulls=True)  # noqa: S608
