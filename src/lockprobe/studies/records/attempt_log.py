"""The log of clients' attempts: each is written to disk before its report leaves, so a killed server loses none.

``attempts.jsonl`` lies next to the records. It has a line for every time a trial is begun or taken up again, one for
every attempt, and one where a box broke. A finished trial is an ordinary record; its lines stay here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from lockprobe.foundation.storage.atomic_file import sync_directory
from lockprobe.foundation.storage.jsonl import LineFile, read_values, with_checksum
from lockprobe.studies.file_names import ATTEMPTS
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.trial.record import Outcome


class _Line(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)
    key: str


class _Begun(_Line):
    """A client began or resumed the trial."""

    kind: Literal["begun"] = "begun"


class _Did(_Line):
    """One attempt, and the report that followed."""

    kind: Literal["attempt"] = "attempt"
    joint: str
    claimed: Outcome | None = None
    told: str = ""
    hypothesis: str = ""


class _Broke(_Line):
    """The box broke: the trial is played again from its first step."""

    kind: Literal["broke"] = "broke"


_adapter: TypeAdapter[_Begun | _Did | _Broke] = TypeAdapter(
    Annotated[_Begun | _Did | _Broke, Field(discriminator="kind")]
)


class AttemptLog:
    """The open log of one study. Use :meth:`open` while holding the lock of the study."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: LineFile | None = None
        self._begun: dict[str, int] = {}
        self._attempts: dict[str, list[RecordedAttempt]] = {}

    @classmethod
    @contextmanager
    def open(cls, directory: Path) -> Iterator[AttemptLog]:
        """Open the log of a study directory, which is created with its first line; a torn line is cut off.

        Raises:
            BadFile: If a line within it is damaged, or it cannot be written.
        """
        log = cls(directory / ATTEMPTS)
        with closing(log):
            if log._path.exists():
                log._opened().cut_torn_tail()
                log._read()
            yield log

    def _read(self) -> None:
        for line in read_values(self._path, _adapter):
            self._follow(line)

    @classmethod
    def read(cls, directory: Path) -> Mapping[str, Sequence[RecordedAttempt]]:
        """The attempts in a study directory by key of their trial, since its first step; empty without a log.

        Raises:
            BadFile: If a line is damaged.
        """
        log = cls(directory / ATTEMPTS)
        if log._path.is_file():
            log._read()
        return log._attempts

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def attempts(self, key: str) -> tuple[RecordedAttempt, ...]:
        """The steps of a trial so far."""
        return tuple(self._attempts.get(key, ()))

    def times_begun(self, key: str) -> int:
        """How often a trial was begun or resumed since its first step."""
        return self._begun.get(key, 0)

    def under_way(self, key: str) -> bool:
        """Whether a trial was begun."""
        return key in self._begun

    def begin(self, key: str) -> None:
        """Write that a client begins or resumes a trial.

        Raises:
            BadFile: If it cannot be written, here and below.
        """
        self._write(_Begun(key=key))

    def attempt(self, key: str, step: RecordedAttempt) -> None:
        """Write one attempt."""
        self._write(_Did(key=key, **step._asdict()))

    def broke(self, key: str) -> None:
        """Write that the box broke."""
        self._write(_Broke(key=key))

    def replace(self, key: str, attempts: Sequence[RecordedAttempt]) -> None:
        """Write the attempts of a trial that was finished elsewhere, in place of those that it has here."""
        if list(attempts) == self._attempts.get(key, []):
            return
        if self.under_way(key):
            self.broke(key)
        self.begin(key)
        for attempt in attempts:
            self.attempt(key, attempt)

    def _write(self, line: _Begun | _Did | _Broke) -> None:
        self._opened().append(with_checksum(_adapter.dump_json(line, exclude_defaults=False)), sync=True)
        self._follow(line)

    def _opened(self) -> LineFile:
        """The open file, created if missing."""
        if self._file is None:
            new = not self._path.exists()
            self._file = LineFile(self._path)
            if new:
                sync_directory(self._path.parent)
        return self._file

    def _follow(self, line: _Begun | _Did | _Broke) -> None:
        if isinstance(line, _Begun):
            self._begun[line.key] = self._begun.get(line.key, 0) + 1
        elif isinstance(line, _Did):
            step = RecordedAttempt(line.joint, line.claimed, line.told, line.hypothesis)
            self._attempts.setdefault(line.key, []).append(step)
        else:
            self._begun.pop(line.key, None)
            self._attempts.pop(line.key, None)
