"""The directory of a study: its lock and its settings file. A failed start leaves it unchanged.

Agents can be added to a study that has been played, it can be extended, and it can ask something else; no other setting
can change after the first trial.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.spec import PEOPLE
from lockprobe.foundation.storage.atomic_file import refuse_links, write_file, writing
from lockprobe.foundation.storage.database import Database
from lockprobe.studies import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.records.store import SCHEMA, STORE, holds, last_rows
from lockprobe.studies.study import SIZES, EarlierSize, Study, settings_of, study_from

_LOCK = ".lock"
"""The file that is locked where directories are not."""


@contextmanager
def locked_store(path: Path) -> Iterator[Database]:
    """The store of a study directory that this process alone writes; both are created if missing.

    If an error occurs before anything was recorded, new files and directories are removed and the settings are
    restored, unless people were invited.

    Raises:
        BadFile: If it cannot be made, or a link inside it leads elsewhere.
        DirectoryBusy: If another process writes there.
    """
    new = [one for one in (path, *path.parents) if not one.exists()]
    settings, people = path / SETTINGS, path / PEOPLE_DIRECTORY
    refuse_links(path)
    for one in (settings, path / STORE, people):  # it may have no settings yet by which it is known
        refuse_links(one, within=path)
    with ExitStack() as held:
        held.callback(_remove_empty, new)
        with writing(path):
            path.mkdir(parents=True, exist_ok=True)
            _lock(path, held)
        missing = [path / _LOCK, *(one for one in (settings, path / STORE) if not one.exists())]
        before, invited = settings.read_bytes() if settings.is_file() else None, people.exists()
        kept = False
        try:
            with Database.writing(path / STORE, SCHEMA) as store:
                rows = last_rows(store)
                try:
                    yield store
                    kept = True
                finally:
                    kept = kept or last_rows(store) != rows
        finally:
            if not kept and invited == people.exists():
                with suppress(OSError, BadFile):
                    for one in missing:
                        one.unlink(missing_ok=True)
                    if before is not None and settings.read_bytes() != before:
                        write_file(settings, before)


def _remove_empty(directories: Iterable[Path]) -> None:
    for directory in directories:
        with suppress(OSError):
            directory.rmdir()


def _lock(directory: Path, held: ExitStack) -> None:
    """Lock a directory against other writers, or a file in it where the file system locks no directories."""
    for path, flags in ((directory, os.O_RDONLY), (directory / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)):
        held.callback(os.close, handle := os.open(path, flags, 0o600))
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DirectoryBusy(directory) from None
        except OSError:  # a file system without any locks writes without them
            continue
        return


def read_study(directory: Path | str) -> Study:
    """The study whose settings lie in a directory.

    Raises:
        BadFile: If there are none, or they describe no study.
    """
    path = Path(directory) / SETTINGS
    if not path.exists():
        raise BadFile(directory, f"no {SETTINGS} here; is it the directory of a study?")
    return study_from(read_input(path), path)


def write_settings(directory: Path, study: Study) -> None:
    """Write the settings of a study atomically.

    What they say of earlier sizes is never forgotten, nor are contrasts, unless the study has others.
    """
    if holds(directory, "trial", "call", "attempt", "act") and (directory / SETTINGS).exists():
        there = read_study(directory)
        earlier = max(there.earlier, study.earlier, key=len)
        study = replace(study, earlier=earlier, contrasts=study.contrasts or there.contrasts)
    write_file(directory / SETTINGS, f"{json.dumps(settings_of(study), indent=2)}\n")


def claim(directory: Path, study: Study) -> None:
    """Write the settings of a new study, or check them against the settings on disk. New agents are added.

    A study that was extended (:func:`extended`) may have another size than there.

    Raises:
        SettingsChanged: If any other setting differs.
        BadFile: If there are records without settings, or settings that cannot be read or written.
    """
    has_settings, played = (directory / SETTINGS).exists(), holds(directory, "trial", "call", "attempt")
    if played and not has_settings:
        raise BadFile(directory, f"holds {STORE} but no {SETTINGS}: put it back, or give another --out")
    if played or (has_settings and holds(directory, "act")):  # who has joined plays this study
        there = read_study(directory)
        extended = len(there.earlier) < len(study.earlier)
        if different := study.differences(there, but=SIZES if extended else ()):
            raise SettingsChanged(directory, different)
        part = study.shard if study.shard == there.shard else None  # of several parts it holds the whole
        joined = replace(study, agents=there.joined(study.agents), names={**there.names, **study.names}, shard=part)
        study = joined.ordered_as(there)
    write_settings(directory, study)


def extended(planned: Study, directory: Path) -> Study:
    """A study with the sizes that its directory had before, the present one too if the new one is larger.

    Trials that are added after a look are valid if everything is then tested at every look. The sizes say in which
    order blocks were planned.

    Where it is no larger, or no trial was begun, it is as it was. One that stops when it is decided keeps the
    repetitions of its directory, within which its trials are numbered.

    Raises:
        BadValue: If people take part, who are compared at one look.
    """
    if not (directory / SETTINGS).exists():
        return planned
    there = read_study(directory)
    if planned.until and planned.repetitions == 1 < there.repetitions:
        each = max(1, planned.trials // there.repetitions)
        more = there.strategy_trials if there.strategy_trials and there.strategy_trials > each else None
        planned = replace(planned, repetitions=there.repetitions, trials=each, strategy_trials=more)
    old, new = ([one.repetitions, one.trials, *map(one.trials_of, there.agents)] for one in (there, planned))
    if any(more < less for more, less in zip(new, old, strict=True)):
        return planned
    planned = replace(planned, earlier=there.earlier)
    same = all(getattr(there, name) == getattr(planned, name) for name in SIZES)
    if same or not holds(directory, "trial", "call", "attempt"):
        return planned
    if PEOPLE in {*there.agents, *planned.agents}:
        raise BadValue("trials", planned.trials, f"{there.trials}: people are compared at one look, at a fixed number")
    before = EarlierSize(there.repetitions, there.trials, there.strategy_trials)
    return replace(planned, earlier=(*there.earlier, before))
