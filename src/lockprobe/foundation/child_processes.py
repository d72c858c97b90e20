"""Ctrl-C, which interrupts a wait at once, and processes that start here.

They say nothing when it ends them, and import nothing from the working directory, which may be an unpacked archive.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_VARIABLE = "PYTHONSAFEPATH"


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C raise ``KeyboardInterrupt`` here at once; in other threads than the main one nothing changes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def safe_path() -> Iterator[None]:
    """Start interpreters within it: they, and those that they start, have no working directory on their import path.

    Python puts it first for ``-c`` and ``-m``, so that a ``signal.py`` that lies there runs in its place. Outside of it
    the environment of the user's own programs is as it was.
    """
    before = os.environ.get(_VARIABLE)
    os.environ[_VARIABLE] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_VARIABLE, None)
        else:
            os.environ[_VARIABLE] = before


@contextmanager
def held_back() -> Iterator[None]:
    """Hold Ctrl-C back while processes start here; they import nothing from the working directory.

    A terminal sends it to them too, and one that still imports modules would print a traceback. They hold it back from
    their first moment on, until they decide what it does to them.
    """
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # started with the first process, it would let Ctrl-C through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with safe_path():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
