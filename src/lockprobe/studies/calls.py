"""The calls of a study on disk: ``calls.jsonl``, one line a call, written the moment its reply comes.

A reply that was paid for is never lost: a trial that was broken off, by a fault, a kill or the end of the money, goes
on where it stood, because the calls that it made before are looked up instead of made again. What a study has cost is
the sum of its calls, those of broken trials among them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from pydantic import TypeAdapter, ValidationError

from lockprobe.call import Call, Usage
from lockprobe.errors import BadFile
from lockprobe.studies.lines import cut_torn_tail, whole_lines

__all__ = ["CALLS", "Calls", "read_calls"]

CALLS = "calls.jsonl"
"""Where in the directory of a study its calls stand."""

_adapter: TypeAdapter[Call] = TypeAdapter(Call)


def read_calls(directory: Path | str) -> Iterator[Call]:
    """The calls of a study, in the order in which they were made; none where no provider was asked.

    Raises:
        BadFile: If a line is damaged.
    """
    path = Path(directory) / CALLS
    if not path.is_file():
        return
    for number, line in whole_lines(path):
        try:
            yield _adapter.validate_json(line, strict=True, extra="forbid")
        except ValidationError as error:
            raise BadFile(path, f"line {number}: {error.errors()[0]['msg']}") from error


class Calls:
    """The open book of calls of a study. Use :meth:`open`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: IO[bytes] | None = None
        self._replied: dict[str, dict[tuple[int, int], Call]] = {}
        for call in read_calls(path.parent):
            self._note(call)

    def _note(self, call: Call) -> None:
        if call.reply is not None:
            self._replied.setdefault(call.key, {})[call.step, call.turn] = call

    @classmethod
    @contextmanager
    def open(cls, directory: Path) -> Iterator[Calls]:
        """Open the book of a directory, which the caller has locked. The file is made with the first call.

        Raises:
            BadFile: If it cannot be read.
        """
        calls = cls(directory / CALLS)
        try:
            yield calls
        finally:
            if calls._file is not None:
                calls._file.close()

    def of(self, key: str) -> _Page:
        """The calls of one trial."""
        return _Page(self, key)

    def recall(self, key: str, step: int, turn: int, request: str) -> Call | None:
        """The call that was made in this place with this request and got a reply; None if there is none."""
        call = self._replied.get(key, {}).get((step, turn))
        return call if call is not None and call.request == request else None

    def reserve(self, key: str, worst: Usage) -> None:
        """Say what the next call may cost at most."""

    def write(self, call: Call) -> None:
        """Put a call on disk.

        Raises:
            BadFile: If it cannot be written.
        """
        line = _adapter.dump_json(call, exclude_defaults=True) + b"\n"
        try:
            if self._file is None:
                self._file = self._path.open("ab")
                cut_torn_tail(self._file, self._path)
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise BadFile(self._path, f"cannot be written ({error.strerror})") from error
        self._note(call)

    def forget(self, key: str) -> None:
        """Let go of the calls of a trial that is finished; they stay on disk."""
        self._replied.pop(key, None)


class _Page:
    """The calls of one trial."""

    def __init__(self, calls: Calls, key: str) -> None:
        self._calls, self._key = calls, key

    def recall(self, step: int, turn: int, request: str) -> Call | None:
        return self._calls.recall(self._key, step, turn, request)

    def reserve(self, worst: Usage) -> None:
        self._calls.reserve(self._key, worst)

    def write(self, call: Call) -> None:
        self._calls.write(call)
