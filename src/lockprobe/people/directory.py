"""The directory of people in that of a study: a start that fails before they are invited leaves it as it was.

A failed start deletes the files that it made and puts settings and texts back. Diaries and notes of withdrawals are
none of these files, and once somebody has joined, all stays.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from lockprobe.errors import BadFile
from lockprobe.inputs import read_input
from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.people.experiment import EXPERIMENT
from lockprobe.people.texts import TEXTS
from lockprobe.storage.atomic_file import remove_file, write_private

__all__ = ["LOG", "TOKENS", "PeopleDirectory"]

TOKENS = "secret"
"""By what the tokens of this study are told from others."""

LOG = "server.log"
"""What the server refused."""

_SETTINGS = (EXPERIMENT, TEXTS)
"""Files that a start writes anew."""

_MADE = (*_SETTINGS, TOKENS, LOG)
"""Files that a start makes."""


class PeopleDirectory:
    """The directory of people while they are about to be invited. The directory of the study is locked meanwhile.

    Args:
        directory: Of the study.

    Attributes:
        used: Set it when people are invited; then all stays as it is.

    Raises:
        BadFile: On entering, if settings that are there cannot be read.
    """

    def __init__(self, directory: Path) -> None:
        self.used = False
        self._path = directory / PEOPLE_DIRECTORY

    def __enter__(self) -> Self:
        self._new = not self._path.exists()
        self._made = [path for name in _MADE if not (path := self._path / name).exists()]
        self._settings = {path: read_input(path) for name in _SETTINGS if (path := self._path / name).is_file()}
        self._diaries = self._count_diaries()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        failed = kind is not None and not issubclass(kind, KeyboardInterrupt)
        if failed and not (self.used or self._count_diaries() > self._diaries):
            self._undo()

    def _undo(self) -> None:
        with suppress(OSError, BadFile):
            for path in self._made:
                remove_file(path)
            for path, content in self._settings.items():
                if path.read_bytes() != content:
                    write_private(path, content)
            if self._new:
                self._path.rmdir()

    def _count_diaries(self) -> int:
        return sum(1 for _ in self._path.glob("*.jsonl"))
