"""Interpreters that are started here import nothing from the working directory, which may be an unpacked archive."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_VARIABLE = "PYTHONSAFEPATH"


_lock = Lock()
_before: list[str | None] = []
"""The variable as each one who starts an interpreter now found it; the first found the user's."""


@contextmanager
def safe_path() -> Iterator[None]:
    """Start interpreters within it: they, and those that they start, have no working directory on their import path.

    Python puts it first for ``-c`` and ``-m``, so that a ``signal.py`` that lies there runs in its place. Outside of it
    the environment of the user's own programs is as it was.
    """
    with _lock:
        _before.append(os.environ.get(_VARIABLE))
        os.environ[_VARIABLE] = "1"
    try:
        yield
    finally:
        with _lock:
            before = _before.pop()
            if not _before and before is None:
                del os.environ[_VARIABLE]
            elif not _before and before is not None:
                os.environ[_VARIABLE] = before
