"""Withdrawal: deletes all data of a participant and keeps only the number of withdrawals.

A note is written first. The next opening, or the next deletion, finishes one that was interrupted.
"""

from __future__ import annotations

import json
from pathlib import Path

from lockprobe.agents.participant import check_participant, participant_spec
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import parse_json, read_input
from lockprobe.foundation.storage.atomic_file import remove_file, sync_directory, write_private, writing
from lockprobe.foundation.storage.jsonl import whole_lines
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.trial.pictures.picture import PICTURE_NAME

_UNDER_WAY = "withdrawing.json"
_COUNT = "withdrawn.json"


def withdrawn(directory: Path | str) -> int:
    """The number of withdrawals from the study in a directory.

    Raises:
        BadFile: If the count is damaged.
    """
    path = Path(directory) / PEOPLE_DIRECTORY / _COUNT
    found = _read(path)
    return 0 if found is None else int(str(found["withdrawn"]))


def withdrawing(directory: Path | str) -> str | None:
    """The participant whose deletion is noted and not finished; None if there is none.

    Raises:
        BadFile: If the note is damaged.
    """
    path = Path(directory) / PEOPLE_DIRECTORY / _UNDER_WAY
    note = _read(path)
    return None if note is None else str(note.get("participant"))


def note_withdrawal(journal: Journal, identity: str) -> None:
    """Note that all data of a participant are to be deleted. The deletion can be finished at any later time.

    Raises:
        BadFile: If it cannot be written, or an earlier deletion is not finished.
    """
    people = journal.directory / PEOPLE_DIRECTORY
    if (people / _UNDER_WAY).exists():
        raise BadFile(people / _UNDER_WAY, "an unfinished deletion")
    put(people / _UNDER_WAY, {"participant": identity, "withdrawn": withdrawn(journal.directory) + 1})


def finish_withdrawal(journal: Journal) -> str | None:
    """Finish the noted deletion and return its participant; None if none was noted.

    Raises:
        BadFile: If it cannot be written; it stays noted.
    """
    people = journal.directory / PEOPLE_DIRECTORY
    if (note := _read(people / _UNDER_WAY)) is None:
        return None
    agent = participant_spec(str(note.get("participant")))
    try:
        check_participant(agent)
    except BadValue as error:
        raise BadFile(people / _UNDER_WAY, str(error)) from None
    with writing(people):
        remove_file(people / f"{note['participant']}.jsonl")
        sync_directory(people)
        journal.delete_player(agent)
        count_withdrawn(journal.directory, int(str(note["withdrawn"])))
        remove_file(people / _UNDER_WAY)
        sync_directory(people)
    return str(note["participant"])


def delete_unnamed_pictures(directory: Path) -> None:
    """Delete the pictures that no record names any more. Nobody may be playing: unfinished trials are not recorded yet.

    Raises:
        BadFile: If a file cannot be read or deleted.
    """
    album = directory / ALBUM
    if not album.is_dir():
        return
    named: set[str] = set()
    for path in directory.rglob("*.jsonl*"):
        for _, line in whole_lines(path):
            named.update(PICTURE_NAME.findall(line.decode("utf-8", "replace")))
    for picture in album.iterdir():
        if PICTURE_NAME.fullmatch(picture.name) and picture.name not in named:
            remove_file(picture)


def count_withdrawn(directory: Path, number: int) -> None:
    """Write the number of withdrawals from the study in a directory.

    Raises:
        BadFile: If it cannot be written.
    """
    put(directory / PEOPLE_DIRECTORY / _COUNT, {"withdrawn": number})


def put(path: Path, data: object) -> None:
    """Write a small JSON file atomically and flush it to disk.

    Raises:
        BadFile: If it cannot be written.
    """
    write_private(path, f"{json.dumps(data, indent=2)}\n")


def _read(path: Path) -> dict[str, object] | None:
    if not path.exists():
        return None
    found = parse_json(read_input(path), path)
    if not isinstance(found, dict) or type(found.get("withdrawn")) is not int or found["withdrawn"] < 0:
        raise BadFile(path, "not a record of withdrawals")
    return found
