"""Withdrawal: all data of a participant are deleted.

What stays is the number of withdrawals and, of a person whom a recruitment platform sent, a keyed digest of their ID
(:func:`keyed_digest`): they know what was changed on purpose, and cannot begin again.
"""

from __future__ import annotations

import hmac
import re
import secrets
from pathlib import Path

from lockprobe.foundation.inputs import is_there, read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import write_private
from lockprobe.studies import PEOPLE_DIRECTORY
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.store import ALBUM, STORE, read, unpacked
from lockprobe.trial.pictures.picture import PICTURE_NAME


def keyed_digest(directory: Path, text: str) -> str:
    """A digest of a text under the secret of the study in a directory, which is made if it is missing.

    Only the owner of the directory can read the secret.

    Raises:
        BadFile: If the secret cannot be read or made.
    """
    path = directory / PEOPLE_DIRECTORY / "secret"
    if not is_there(path):
        write_private(path, secrets.token_bytes(32), mode=0o600)
    return hmac.digest(read_input(path), text.encode(), "sha256").hex()


def withdrawn(directory: Path | str) -> int:
    """The number of withdrawals from the study in a directory."""
    if not is_there(Path(directory) / STORE):
        return 0
    with read(directory) as store:
        return int(store.one("select total(value) from note where name = 'withdrawn'")[0])


def withdraw(journal: Journal, identity: str, person: str = "") -> None:
    """Delete all data of a participant but pictures (:func:`delete_unnamed_pictures`). Can be repeated.

    ``person`` is their ID on the recruitment platform; empty without one.

    Raises:
        BadFile: If it cannot be written; :meth:`Journal.delete_participant` says what is deleted then.
    """
    if person:
        name = _note(journal, person)
        with journal.store.transaction(sync=True) as writing:
            writing.execute("insert or ignore into note values (?, 1)", (name,))
    journal.delete_participant(f"{PEOPLE}:{identity}")
    journal.erase()


def has_withdrawn(journal: Journal, person: str) -> bool:
    """Whether the person with this ID on the recruitment platform has withdrawn."""
    return bool(journal.store.one("select count(*) from note where name = ?", _note(journal, person))[0])


def _note(journal: Journal, person: str) -> str:
    """What stays of a person: a keyed digest of their ID, which tells nobody the ID."""
    return f"withdrew {keyed_digest(journal.directory, f'withdrew {person}')}"


def delete_unnamed_pictures(journal: Journal) -> None:
    """Delete the pictures that no record names any more. Nobody may be playing: their trials are not on record yet."""
    named: set[bytes] = set()
    for key, record in journal.store.rows("select key, record from trial"):
        named.update(re.findall(PICTURE_NAME.pattern.encode(), unpacked(journal.store, key, record)))
    for picture in (journal.directory / ALBUM).glob("*"):
        if PICTURE_NAME.fullmatch(picture.name) and picture.name.encode() not in named:
            picture.unlink()
