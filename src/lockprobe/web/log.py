"""What was refused, one line each: time, status, code, method, path. Never who asked, nor anything that was sent."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from lockprobe.errors import BadFile
from lockprobe.people.directory import LOG
from lockprobe.terminal_text import printable

__all__ = ["Log"]

A_MINUTE = 120
"""Lines written in one minute; the rest is counted. Whoever floods the server cannot fill the disk."""

_SAID_ALREADY = "Exception in ASGI application\n"
"""Of what broke in the application, which says so itself, and where."""

_LONGEST_PATH = 100
_LONGEST_METHOD = 10


class Log:
    """The open log. Use :meth:`open`.

    Args:
        file: Where lines are appended.
        clock: Seconds since 1970.
    """

    def __init__(self, file: IO[bytes], clock: Callable[[], float] = time.time) -> None:
        self._file, self._clock = file, clock
        self._minute, self._written, self._left_out = 0, 0, 0

    @classmethod
    @contextmanager
    def open(cls, directory: Path, clock: Callable[[], float] = time.time) -> Iterator[Log]:
        """The log in a directory, made if it is not there, for its owner only.

        Raises:
            BadFile: If it cannot be written.
        """
        path = directory / LOG
        try:
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o600)
        except OSError as error:
            raise BadFile(path, f"cannot be written ({error.strerror})") from error
        with os.fdopen(descriptor, "ab", buffering=0) as file:
            yield cls(file, clock)

    def refused(self, scope: MutableMapping[str, Any], status: int, code: str, more: str = "") -> None:
        """Write down what a request came to.

        Args:
            scope: The request, as ASGI has it.
            status: Of the answer.
            code: Why.
            more: Where it broke, of what should not have happened.
        """
        path = scope.get("raw_path", b"").decode("ascii", "replace")
        cut = path[:_LONGEST_PATH] + ("…" if len(path) > _LONGEST_PATH else "")
        self.say(" ".join(filter(None, (str(status), code, scope["method"][:_LONGEST_METHOD], cut, more))))

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

    def _write(self, now: float, text: str) -> None:
        line = f"{time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime(now))} {printable(text)}\n"
        with suppress(OSError):  # a full disk; the log is not what matters most on it
            self._file.write(line.encode("utf-8", "replace"))
        with suppress(OSError, ValueError):
            sys.stderr.write(line)
            sys.stderr.flush()

    @contextmanager
    def hears(self, name: str) -> Iterator[None]:
        """What the server below tells its own logger is written down here: one line each, and limited as all others.

        Of errors that is where they come from, their kind, and nothing of what was sent.
        """
        logger, ear = logging.getLogger(name), _Ear(self)
        before = logger.handlers, logger.propagate, logger.level
        logger.handlers, logger.propagate = [ear], False
        logger.setLevel(logging.WARNING)
        try:
            yield
        finally:
            logger.handlers, logger.propagate = before[0], before[1]
            logger.setLevel(before[2])


class _Ear(logging.Handler):
    def __init__(self, log: Log) -> None:
        super().__init__(logging.WARNING)
        self._log = log

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno == logging.WARNING and record.msg == "Invalid HTTP request received.":
            self._log.say("400 malformed no HTTP")
        elif record.levelno >= logging.ERROR and record.msg != _SAID_ALREADY:
            raised = record.exc_info[0] if record.exc_info else None
            first = str(record.msg).strip().partition("\n")[0][:_LONGEST_PATH]  # more could say who asked
            self._log.say(f"error {record.name} {first} {raised.__name__ if raised else ''}".rstrip())
