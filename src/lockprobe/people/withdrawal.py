"""Somebody withdraws: all that is kept of them is deleted. A deletion that is killed is finished at the next opening.

What stays is how many have withdrawn.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from lockprobe.agents.participant import check_participant, participant_spec
from lockprobe.errors import BadFile, BadValue
from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.studies.journal import Journal
from lockprobe.studies.lines import sync_directory

__all__ = ["finish_withdrawal", "put", "withdraw", "withdrawn"]

_UNDER_WAY = "withdrawing.json"
_COUNT = "withdrawn.json"


def withdrawn(directory: Path) -> int:
    """How many have withdrawn from the study in a directory.

    Raises:
        BadFile: If the count is damaged.
    """
    found = _read(directory / PEOPLE_DIRECTORY / _COUNT)
    return 0 if found is None else int(str(found["withdrawn"]))


def withdraw(journal: Journal, identity: str) -> None:
    """Delete all that is kept of a participant.

    Raises:
        BadFile: If it cannot be written. Once it is noted that somebody withdraws, it can be finished later.
    """
    people = journal.directory / PEOPLE_DIRECTORY
    note = {"participant": identity, "withdrawn": withdrawn(journal.directory) + 1}
    put(people / _UNDER_WAY, note)
    finish_withdrawal(journal)


def finish_withdrawal(journal: Journal) -> None:
    """Finish what was noted, if anything was.

    Raises:
        BadFile: If it cannot be written.
    """
    people = journal.directory / PEOPLE_DIRECTORY
    if (note := _read(people / _UNDER_WAY)) is None:
        return
    agent = participant_spec(str(note["participant"]))
    try:
        check_participant(agent)
    except BadValue as error:
        raise BadFile(people / _UNDER_WAY, str(error)) from None
    try:
        (people / f"{note['participant']}.jsonl").unlink(missing_ok=True)
        sync_directory(people)
        journal.strike(agent)
        put(people / _COUNT, {"withdrawn": note["withdrawn"]})
        (people / _UNDER_WAY).unlink()
        sync_directory(people)
    except OSError as error:
        raise BadFile(people, f"cannot be written ({error.strerror})") from error


def put(path: Path, data: object) -> None:
    """A small file of JSON in its place, whole or not at all, on the disk itself.

    Raises:
        BadFile: If it cannot be written.
    """
    draft = path.with_suffix(".draft")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with draft.open("w", encoding="utf-8") as file:
            file.write(json.dumps(data, indent=2) + "\n")
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
        sync_directory(path.parent)
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from error


def _read(path: Path) -> dict[str, object] | None:
    try:
        found = json.loads(path.read_text("utf-8"))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read ({error})") from error
    if not isinstance(found, dict) or "withdrawn" not in found:
        raise BadFile(path, "is not what withdrawals are noted in")
    return found
