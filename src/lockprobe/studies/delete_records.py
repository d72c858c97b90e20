"""Records of one agent are struck from a journal: the only time that its files are written anew.

A file is written anew beside the old one and then takes its place, so that it is whole at every moment. Clock readings
go first: as long as the records are there, it can be done again, though a reading of somebody else that stands beside a
deleted one of the same trial is then lost.
"""

from __future__ import annotations

import fcntl
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path

from lockprobe.errors import BadFile
from lockprobe.storage.atomic_file import Replacement, remove_file, write_file
from lockprobe.storage.jsonl import LineFile, whole_lines

__all__ = ["rewritten", "without", "without_agent"]


def without(directory: Path, agent: str) -> tuple[set[str], Iterator[bytes], Iterator[bytes]]:
    """What a journal is without an agent.

    Args:
        directory: Of the study.
        agent: Its spec.

    Returns:
        The keys of its trials; the lines of clock readings that stay; the lines of records that stay. A trial that
        somebody else has played too has a reading for each record, in the same order, and the reading of theirs stays;
        where there are not as many, it cannot be told whose they are, and none stays.
    """
    records, timings = directory / "trials.jsonl", directory / "timings.jsonl"
    owners: dict[str, list[str]] = {}
    for line in _lines(records):
        key, owner = _owner(line)
        owners.setdefault(key, []).append(owner)
    return (
        {key for key, played in owners.items() if agent in played},
        _readings(timings, owners, agent),
        (line for line in _lines(records) if _owner(line)[1] != agent),
    )


def without_agent(path: Path, agent: str) -> None:
    """Strike the records of an agent from a file that nobody has open; where none stays the file is deleted.

    Raises:
        BadFile: If it cannot be written.
    """
    stay = [line for line in _lines(path) if _owner(line)[1] != agent]
    if stay:
        write_file(path, b"".join(stay), alone=True)
    else:
        remove_file(path)


def _readings(timings: Path, owners: Mapping[str, Sequence[str]], agent: str) -> Iterator[bytes]:
    """The lines of clock readings that are not an agent's."""
    readings = Counter(_key(line) for line in _lines(timings))
    met: Counter[str] = Counter()
    for line in _lines(timings):
        key = _key(line)
        played = owners.get(key, ())
        if agent not in played or (readings[key] == len(played) and played[met[key]] != agent):
            yield line
        met[key] += 1


def rewritten(old: LineFile, lines: Iterable[bytes]) -> LineFile:
    """A file with other lines, in its place and open for appending.

    Not :func:`write_file`, because it has to be open and locked before it is in its place.

    Args:
        old: The file as it is open; it is closed.
        lines: Whole lines.

    Raises:
        BadFile: If it cannot be written, or somebody else has changed it; then the old one stays.
    """
    old.check()
    replacement = Replacement(old.path, alone=True)
    try:
        with ExitStack() as undo:
            undo.callback(replacement.drop)
            replacement.create()
            new = undo.enter_context(closing(LineFile(replacement.draft)))
            fcntl.flock(new, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for line in lines:
                new.append(line.rstrip(b"\n"))
            replacement.sync()
            replacement.rename()
            undo.pop_all()
    except OSError as error:
        raise BadFile(old.path, f"cannot be written ({error.strerror})") from error
    new.path = old.path
    old.close()
    return new


def _lines(path: Path) -> Iterator[bytes]:
    return (line for _, line in whole_lines(path))


def _owner(line: bytes) -> tuple[str, str]:
    """Key and agent of a record."""
    record = json.loads(line)
    return str(record["key"]), str(record["agent"])


def _key(reading: bytes) -> str:
    """Of a clock reading; empty where it is damaged."""
    with suppress(ValueError, TypeError, KeyError, RecursionError):
        return str(json.loads(reading)["key"])
    return ""
