"""The server's log: one line per refused request or error, without who asked or what was sent."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.open_study import LOG

A_MINUTE = 120
"""The most lines written in one minute; further ones are counted. Whoever floods the server cannot fill the disk."""

LOGGED = "written to the server's log"
"""The note on an exception that is in the log already; uvicorn reports it once more."""

_LONGEST_PATH = 100


class ServerLog(logging.Handler):
    """Writes the log to a file and to standard error. Use :meth:`open`."""

    def __init__(self, file: IO[bytes], clock: Callable[[], float] = time.time) -> None:
        super().__init__(logging.ERROR)
        self._file, self._clock = file, clock
        self._minute, self._written, self._left_out = 0, 0, 0

    @classmethod
    @contextmanager
    def open(cls, directory: Path, clock: Callable[[], float] = time.time) -> Iterator[ServerLog]:
        """Open the log in a directory. It is created if missing, and only its owner can read it.

        Raises:
            BadFile: If it cannot be written.
        """
        path = directory / LOG
        refuse_links(path)
        check_regular(path)
        with writing(path):
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o600)
        with os.fdopen(descriptor, "ab", buffering=0) as file:
            yield cls(file, clock)

    def refused(self, scope: MutableMapping[str, Any], status: int, code: str, more: str = "") -> None:
        """Log a refused request: ``code`` is the reason, ``more`` where an unexpected error was raised."""
        path = scope.get("raw_path", b"").decode("ascii", "replace")
        cut = path[:_LONGEST_PATH] + ("…" if len(path) > _LONGEST_PATH else "")
        self.say(" ".join(filter(None, (str(status), code, scope["method"][:10], cut, more))))

    def say(self, text: str) -> None:
        """Write one line with the time in front."""
        now = self._clock()
        if (minute := int(now // 60)) != self._minute:
            left_out, self._minute, self._written, self._left_out = self._left_out, minute, 0, 0
            if left_out:
                self._write(now, f"and {left_out} more in the minute before the last line")
        if self._written >= A_MINUTE:
            self._left_out += 1
            return
        self._written += 1
        self._write(now, text)

    def emit(self, record: logging.LogRecord) -> None:
        """Log an error of a library: its logger, the first line without arguments, and the exception type."""
        raised = record.exc_info[1] if record.exc_info else None
        if LOGGED not in getattr(raised, "__notes__", ()):
            first = str(record.msg).strip().partition("\n")[0][:_LONGEST_PATH]  # arguments could say who asked
            kind = record.exc_info[0].__name__ if record.exc_info and record.exc_info[0] else ""
            self.say(f"error {record.name} {first} {kind}".rstrip())

    @contextmanager
    def hears(self, *names: str) -> Iterator[None]:
        """Take over the errors of other loggers, and nothing below errors."""
        loggers = [logging.getLogger(name) for name in names]
        before = [(logger.handlers, logger.propagate) for logger in loggers]
        for logger in loggers:
            logger.handlers, logger.propagate = [self], False
        try:
            yield
        finally:
            for logger, (handlers, propagate) in zip(loggers, before, strict=True):
                logger.handlers, logger.propagate = handlers, propagate

    def _write(self, now: float, text: str) -> None:
        line = f"{time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime(now))} {printable(text)}\n"
        with suppress(OSError):  # a full disk; the log is not what matters most on it
            self._file.write(line.encode("utf-8", "replace"))
        with suppress(OSError, ValueError):
            sys.stderr.write(line)
            sys.stderr.flush()
