"""Writes and updates the report of a study during its run."""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from pathlib import Path

from lockprobe.foundation.safe_path import interpreter, safe_path

PAUSE = 120.0
"""Seconds from the turn of a slow agent to the first report, and from that to the next: a study that ends before has
its report at its end. Each further pause is twice as long: a study of hours is not slowed."""


class LiveReport:
    """Writes the report of a directory in a process of its own, after pauses that double, all but the first quietly.

    At most one process writes. Its output is discarded: the run writes the last report itself.
    """

    def __init__(self, directory: Path) -> None:
        self._directory, self._pause, self._next = directory, PAUSE, float("inf")
        self._writing: subprocess.Popen[bytes] | None = None
        self._told = False

    def begin(self) -> None:
        """Begin to count the time: the turn of a slow agent has come."""
        self._next = min(self._next, time.monotonic() + PAUSE)

    def renew(self) -> Path | None:
        """Begin to write the report if it is due; the page once the first one is there."""
        ended = self._writing is None or self._writing.poll() is not None
        if time.monotonic() >= self._next and ended:
            command = interpreter("-m", "lockprobe", "report", str(self._directory))
            first, quiet = self._writing is None, subprocess.DEVNULL
            with safe_path(), contextlib.suppress(OSError):  # without a further process the report comes at the end
                self._writing = subprocess.Popen(  # noqa: S603 - ourselves
                    command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
                )
                if not first:
                    os.setpriority(os.PRIO_PROCESS, self._writing.pid, 10)
            self._next = time.monotonic() + self._pause
            self._pause *= 2
        elif self._writing is not None and self._writing.poll() == 0 and not self._told:
            self._told = True
            return self._directory / "report.html"
        return None

    def end(self) -> None:
        """Wait for the report that is being written."""
        if self._writing is not None:
            self._writing.wait()

    def stop(self) -> None:
        """End the report that is being written, of a run that was refused: its settings do not stay."""
        if self._writing is not None and self._writing.poll() is None:
            self._writing.terminate()
            self._writing.wait()
