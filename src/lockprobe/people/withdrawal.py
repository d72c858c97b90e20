"""Withdrawal: all data of a participant are deleted, and only the number of withdrawals stays."""

from __future__ import annotations

import re
from pathlib import Path

from lockprobe.agents.participant import participant_spec
from lockprobe.foundation.inputs import is_there
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.records.trial_rows import unpacked
from lockprobe.trial.pictures.picture import PICTURE_NAME


def withdrawn(directory: Path | str) -> int:
    """The number of withdrawals from the study in a directory.

    Raises:
        BadFile: If the store is damaged.
    """
    if not is_there(Path(directory) / STORE):
        return 0
    with read(directory) as store:
        return int(store.one("select total(value) from note where name = 'withdrawn'")[0])


def withdraw(journal: Journal, identity: str) -> None:
    """Delete all data of a participant but pictures (:func:`delete_unnamed_pictures`). Can be repeated.

    Raises:
        BadFile: If it cannot be written; :meth:`Journal.delete_participant` says what is deleted then.
    """
    journal.delete_participant(participant_spec(identity))
    journal.erase()


def delete_unnamed_pictures(journal: Journal) -> None:
    """Delete the pictures that no record names any more. Nobody may be playing: unfinished trials are not recorded yet.

    Raises:
        BadFile: If a record is damaged.
        OSError: If a file cannot be deleted.
    """
    album = journal.directory / ALBUM
    if not album.is_dir():
        return
    named: set[bytes] = set()
    for key, record in journal.store.rows("select key, record from trial"):
        named.update(re.findall(PICTURE_NAME.pattern.encode(), unpacked(journal.store, key, record)))
    for picture in album.iterdir():
        if PICTURE_NAME.fullmatch(picture.name) and picture.name.encode() not in named:
            picture.unlink()
