"""The directory of a study: its lock and its settings file. A failed start leaves it unchanged.

Agents can be added to a study that has been played, it can be extended, and it can ask something else; no other setting
can change after the first trial.
"""

from __future__ import annotations

import fcntl
import json
import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

from lockprobe.foundation.errors import BadFile, DirectoryBusy, SettingsChanged
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.studies.file_names import PEOPLE_DIRECTORY, SETTINGS
from lockprobe.studies.options.agent_names import joined_agents
from lockprobe.studies.records.store import STORE, has_joined, holds_records
from lockprobe.studies.study import SIZES, WHO, Study, settings_of, study_from

_MADE = (SETTINGS, STORE)
"""Files that a start creates."""

_LOCK = ".lock"
"""The file that is locked where directories are not."""


class StudyDirectory:
    """A study directory locked for writing by this process; created if missing.

    The lock is on the directory itself, so it is independent of the files. If an error occurs before anything was
    recorded, new files and directories are removed and the settings are restored.

    Attributes:
        used: Whether something was recorded; set it to True, and an error removes nothing.

    Raises:
        BadFile: On entering, if it cannot be made, or a link inside it leads elsewhere.
        DirectoryBusy: On entering, if another process writes there.
    """

    def __init__(self, path: Path) -> None:
        self.used = False
        self._path, self._locked = path, list[int]()
        self._new = [one for one in (path, *path.parents) if not one.exists()]

    def __enter__(self) -> Self:
        refuse_links(self._path)
        for name in (*_MADE, PEOPLE_DIRECTORY):  # it may have no settings yet by which it is known
            refuse_links(self._path / name, within=self._path)
        try:
            self._path.mkdir(parents=True, exist_ok=True)
            self._lock(self._path, os.O_RDONLY)
        except BlockingIOError:
            self._close()
            raise DirectoryBusy(self._path) from None
        except OSError as error:
            self._remove_new()
            raise BadFile(self._path, f"cannot be written ({error.strerror})") from error
        self._there = {name for name in (*_MADE, PEOPLE_DIRECTORY) if (self._path / name).exists()}
        settings = self._path / SETTINGS
        self._settings = settings.read_bytes() if settings.is_file() else None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None and not self.used:
            with suppress(OSError, BadFile):
                self._undo()
        self._close()

    def _lock(self, path: Path, flags: int) -> None:
        """Lock the directory against other writers, or a file in it where the file system locks no directories."""
        self._locked.append(os.open(path, flags, 0o600))
        try:
            fcntl.flock(self._locked[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:  # a file system without any locks writes without them
            if path == self._path:
                self._lock(path / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW)

    def _close(self) -> None:
        for handle in self._locked:
            os.close(handle)

    def _undo(self) -> None:
        """Restore the directory, unless people were invited."""
        if PEOPLE_DIRECTORY not in self._there and (self._path / PEOPLE_DIRECTORY).exists():
            return
        for name in (*_MADE, _LOCK):
            if name not in self._there:
                (self._path / name).unlink(missing_ok=True)
        settings = self._path / SETTINGS
        if self._settings is not None and settings.read_bytes() != self._settings:
            write_file(settings, self._settings)
        self._remove_new()

    def _remove_new(self) -> None:
        for path in self._new:
            with suppress(OSError):
                path.rmdir()


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

    Raises:
        BadFile: If they cannot be written.
    """
    if holds_records(directory) and (directory / SETTINGS).exists():
        there = read_study(directory)
        earlier = max(there.earlier, study.earlier, key=len)
        study = replace(study, earlier=earlier, contrasts=study.contrasts or there.contrasts)
    write_file(directory / SETTINGS, f"{json.dumps(settings_of(study), indent=2)}\n")


def claim(directory: Path, study: Study) -> None:
    """Write the settings of a new study, or check them against the settings on disk. New agents are added.

    A study that was extended (:func:`lockprobe.studies.extension.extended`) may have another size than there.

    Raises:
        SettingsChanged: If any other setting differs.
        BadFile: If there are records without settings, or settings that cannot be read or written.
    """
    path, played = directory / SETTINGS, holds_records(directory)
    if not path.exists() and played:
        raise BadFile(directory, f"holds {STORE} but no {SETTINGS}: put it back, or give another --out")
    somebody = path.exists() and has_joined(directory)  # who has joined plays this study
    if not (played or somebody):
        write_settings(directory, study)
        return
    there = read_study(directory)
    extended = len(there.earlier) < len(study.earlier)
    different = study.differences(there, but=(*WHO, *(SIZES if extended else ()))) | study.renamed(there)
    if different:
        raise SettingsChanged(directory, different)
    agents = joined_agents(there.agents, study.agents)
    part = study.shard if study.shard == there.shard else None  # of several parts it holds the whole
    asks = study.contrasts and study.contrasts != there.contrasts
    if extended or asks or agents != there.agents or part != there.shard:
        joined = replace(study, agents=agents, names={**there.names, **study.names}, shard=part)
        write_settings(directory, joined.ordered_as(there))
