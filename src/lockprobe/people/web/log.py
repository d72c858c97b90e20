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

LOG = "server.log"
"""The log, in the directory of people."""

LARGEST = 10_000_000
"""Bytes after which only standard error has new lines: whoever floods the server cannot fill the disk."""

LOGGED = "written to the server's log"
"""The note on an exception that is in the log already; uvicorn reports it once more."""

_LONGEST_PATH = 100


class ServerLog(logging.Handler):
    """Writes the log to a file and to standard error. Use :meth:`open`."""

    def __init__(self, file: IO[bytes], clock: Callable[[], float] = time.time) -> None:
        super().__init__(logging.ERROR)
        self._file, self._clock = file, clock

    @classmethod
    @contextmanager
    def open(cls, directory: Path) -> Iterator[ServerLog]:
        """Open the log in a directory, and take the errors of uvicorn and asyncio as well.

        It is created if missing, and only its owner can read it.

        Raises:
            BadFile: If it cannot be written.
        """
        path = directory / LOG
        refuse_links(path)
        check_regular(path)
        with writing(path):
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o600)
        loggers = [logging.getLogger(name) for name in ("uvicorn.error", "asyncio")]
        before = [(logger.handlers, logger.propagate) for logger in loggers]
        with os.fdopen(descriptor, "ab", buffering=0) as file:
            log = cls(file)
            for logger in loggers:
                logger.handlers, logger.propagate = [log], False
            try:
                yield log
            finally:
                for logger, (handlers, propagate) in zip(loggers, before, strict=True):
                    logger.handlers, logger.propagate = handlers, propagate

    def refused(self, scope: MutableMapping[str, Any], status: int, code: str, more: str = "") -> None:
        """Log a refused request: ``code`` is the reason, ``more`` where an unexpected error was raised."""
        path = scope.get("raw_path", b"").decode("ascii", "replace")
        cut = path[:_LONGEST_PATH] + ("…" if len(path) > _LONGEST_PATH else "")
        self.say(" ".join(filter(None, (str(status), code, scope["method"][:10], cut, more))))

    def say(self, text: str) -> None:
        """Write one line with the time in front."""
        line = f"{time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime(self._clock()))} {printable(text)}\n"
        with suppress(OSError):  # a full disk; the log is not what matters most on it
            if self._file.tell() < LARGEST:
                self._file.write(line.encode("utf-8", "replace"))
        with suppress(OSError, ValueError):
            sys.stderr.write(line)
            sys.stderr.flush()

    def emit(self, record: logging.LogRecord) -> None:
        """Log an error of a library: its logger, the first line without arguments, and the exception type."""
        raised = record.exc_info[1] if record.exc_info else None
        if LOGGED not in getattr(raised, "__notes__", ()):
            first = str(record.msg).strip().partition("\n")[0][:_LONGEST_PATH]  # arguments could say who asked
            self.say(f"error {record.name} {first} {type(raised).__name__ if raised else ''}".rstrip())
