"""Writes and updates the report of a study during its run."""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource
from lockprobe.foundation.safe_path import interpreter, safe_path
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.observer import Observer, PassedOn
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

PAUSE = 120.0
"""Seconds from the turn of a slow agent to the first report, and from that to the next: a study that ends before has
its report at its end. Each further pause is twice as long: a study of hours is not slowed."""


class LiveReport(PassedOn):
    """Passes events on to another observer, and writes the report in a process of its own.

    Reports are written while slow agents play, after pauses that double, all but the first with low priority. At most
    one process writes. Its output is discarded: the run writes the last report itself. Without a directory there are no
    reports.

    Args:
        observer: Gets the events.
        directory: The directory of the study.
        tell: Told once where a first report can be read.
    """

    def __init__(
        self, observer: Observer, directory: Path | None, *, tell: Callable[[Path], None] = lambda path: None
    ) -> None:
        super().__init__(observer)
        self._tell, self._directory = tell, directory
        self._simulated = False
        self._pause = PAUSE
        self._next: float | None = None  # None: no slow agent's turn has come
        self._writing: subprocess.Popen[bytes] | None = None
        self._told = False

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Note whether every agent is slow, since its box is simulated."""
        self._simulated = study.simulated
        self._observer.begin(study, journal, owed)

    def agent(self, source: AgentSource, owed: int) -> None:
        """Begin to count the time where the agent is slow."""
        if self._next is None and (self._simulated or source.engine != "inline"):
            self._next = time.monotonic() + PAUSE
        self._observer.agent(source, owed)

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Pass a trial on, update the report if it is due, and tell of the first one that is there."""
        self._observer.trial(trial, timing)
        if self._directory is None or self._next is None:
            return
        if not self._told and self._writing is not None and self._writing.poll() == 0:
            self._told = True
            self._tell(self._directory / "report.html")
        if time.monotonic() >= self._next and (self._writing is None or self._writing.poll() is not None):
            self._renew(self._directory)

    def end(self) -> None:
        """Wait for the report that is being written."""
        if self._writing is not None:
            self._writing.wait()

    def stop(self) -> None:
        """End the report that is being written, of a run that was refused: its settings do not stay."""
        if self._writing is not None and self._writing.poll() is None:
            self._writing.terminate()
            self._writing.wait()

    def _renew(self, directory: Path) -> None:
        command = interpreter("-m", "lockprobe", "report", str(directory))
        first, quiet = self._writing is None, subprocess.DEVNULL
        with safe_path(), contextlib.suppress(OSError):  # a machine that can start no process has its report at the end
            self._writing = subprocess.Popen(  # noqa: S603 - ourselves
                command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
            )
            if not first:
                os.setpriority(os.PRIO_PROCESS, self._writing.pid, 10)
        self._next = time.monotonic() + self._pause
        self._pause *= 2
