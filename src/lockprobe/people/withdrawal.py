"""Withdrawal: all data of a participant are deleted.

What stays is the number of withdrawals and, of a person whom a recruitment platform sent, a keyed digest of their ID
(:meth:`lockprobe.people.tokens.Tokens.digest`): they know what was changed on purpose, and cannot begin again.
"""

from __future__ import annotations

import re
from pathlib import Path

from lockprobe.agents.outside import participant_spec
from lockprobe.foundation.inputs import is_there
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.records.trial_rows import unpacked
from lockprobe.trial.pictures.picture import PICTURE_NAME


def withdrawn(directory: Path | str) -> int:
    """The number of withdrawals from the study in a directory."""
    if not is_there(Path(directory) / STORE):
        return 0
    with read(directory) as store:
        return int(store.one("select total(value) from note where name = 'withdrawn'")[0])


def withdraw(journal: Journal, identity: str, digest: str = "") -> None:
    """Delete all data of a participant but pictures (:func:`delete_unnamed_pictures`). Can be repeated.

    ``digest`` is that of their ID on the recruitment platform; empty without one.

    Raises:
        BadFile: If it cannot be written; :meth:`Journal.delete_participant` says what is deleted then.
    """
    if digest:
        with journal.store.transaction(sync=True) as writing:
            writing.execute("insert or ignore into note values (?, 1)", (f"withdrew {digest}",))
    journal.delete_participant(participant_spec(identity))
    journal.erase()


def has_withdrawn(journal: Journal, digest: str) -> bool:
    """Whether the person with this digest has withdrawn."""
    return bool(journal.store.one("select count(*) from note where name = ?", f"withdrew {digest}")[0])


def delete_unnamed_pictures(journal: Journal) -> None:
    """Delete the pictures that no record names any more. Nobody may be playing: their trials are not on record yet."""
    named: set[bytes] = set()
    for key, record in journal.store.rows("select key, record from trial"):
        named.update(re.findall(PICTURE_NAME.pattern.encode(), unpacked(journal.store, key, record)))
    for picture in (journal.directory / ALBUM).glob("*"):
        if PICTURE_NAME.fullmatch(picture.name) and picture.name.encode() not in named:
            picture.unlink()
