"""Interpreters that are started here import nothing from the working directory, which may be an unpacked archive."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_VARIABLE = "PYTHONSAFEPATH"


class _Starting:
    """How many threads start an interpreter now, and the variable as it was before the first of them began."""

    lock = Lock()
    threads = 0
    before: str | None = None


@contextmanager
def safe_path() -> Iterator[None]:
    """Start interpreters within it: they, and those that they start, have no working directory on their import path.

    Python puts it first for ``-c`` and ``-m``, so that a ``signal.py`` that lies there runs in its place. Outside of it
    the environment of the user's own programs is as it was.
    """
    with _Starting.lock:
        if not _Starting.threads:
            _Starting.before = os.environ.get(_VARIABLE)
            os.environ[_VARIABLE] = "1"
        _Starting.threads += 1
    try:
        yield
    finally:
        with _Starting.lock:
            _Starting.threads -= 1
            if not _Starting.threads:
                if _Starting.before is None:
                    del os.environ[_VARIABLE]
                else:
                    os.environ[_VARIABLE] = _Starting.before


def interpreter(*arguments: str) -> list[str]:
    """The command that runs this Python with these arguments, to be started within :func:`safe_path`."""
    return [sys.executable, "-P", *arguments]
