"""The server's log: one line per refused request or error, without who asked or what was sent."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import Any

from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.storage.atomic_file import writing
from lockprobe.foundation.storage.links import refuse_links
from lockprobe.foundation.terminal_text import printable

LOG = "server.log"
"""The log, in the directory of people."""

LARGEST = 10_000_000
"""Bytes after which the log begins anew, beside the one before: whoever floods the server cannot fill the disk."""

LOGGED = "written to the server's log"
"""The note on an exception that is in the log already; uvicorn reports it once more."""

_LONGEST_PATH = 100

_log = logging.getLogger(__name__)


class _Line(logging.Formatter):
    """One line with the time; of a library's error the first line without arguments, which could say who asked."""

    converter = staticmethod(time.gmtime)

    def format(self, record: logging.LogRecord) -> str:
        said, raised = str(record.msg), record.exc_info[1] if record.exc_info else None
        if record.name != _log.name:
            first = said.strip().partition("\n")[0][:_LONGEST_PATH]
            said = f"error {record.name} {first} {type(raised).__name__ if raised else ''}".rstrip()
        return f"{self.formatTime(record, '%Y-%m-%dT%H:%M:%SZ')} {printable(said)}"


@contextmanager
def opened_log(directory: Path) -> Iterator[None]:
    """The log in a directory and on standard error, with the errors of uvicorn and asyncio as well.

    Raises:
        BadFile: If it cannot be written.
    """
    path = directory / LOG
    refuse_links(path)
    check_regular(path)
    with writing(path):
        file = RotatingFileHandler(path, maxBytes=LARGEST, backupCount=1, encoding="utf-8", errors="replace")
        path.chmod(0o600)
    handlers: list[logging.Handler] = [file, logging.StreamHandler(sys.stderr)]
    for handler in handlers:
        handler.setLevel(logging.ERROR)
        handler.setFormatter(_Line())
        handler.addFilter(lambda record: LOGGED not in getattr((record.exc_info or ("", None))[1], "__notes__", ()))
    loggers = [_log, logging.getLogger("uvicorn.error"), logging.getLogger("asyncio")]
    before = [(logger.handlers, logger.propagate) for logger in loggers]
    for logger in loggers:
        logger.handlers, logger.propagate = handlers, False
    try:
        yield
    finally:
        file.close()
        for logger, (handlers_before, propagate) in zip(loggers, before, strict=True):
            logger.handlers, logger.propagate = handlers_before, propagate


def log_refused(scope: MutableMapping[str, Any], status: int, code: str, more: str = "") -> None:
    """Log a refused request: ``code`` is the reason, ``more`` where an unexpected error was raised."""
    path = scope.get("raw_path", b"").decode("ascii", "replace")
    cut = path[:_LONGEST_PATH] + ("…" if len(path) > _LONGEST_PATH else "")
    say(" ".join(filter(None, (str(status), code, scope["method"][:10], cut, more))))


def say(text: str) -> None:
    """Log one line."""
    _log.error(text)
