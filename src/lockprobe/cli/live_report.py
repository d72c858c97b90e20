"""Writes and updates the report of a study during its run."""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.foundation.safe_path import interpreter, safe_path
from lockprobe.statistics.course import is_baseline
from lockprobe.studies.records.journal import Journal, Timing
from lockprobe.studies.running.observer import Observer, PassedOn
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

FIRST_PAUSE = 60.0
"""Seconds until the first report where a slow agent begins before anything has been played."""

PAUSE = 120.0
"""Seconds from the first report to the next. Each further pause is twice as long: a study of hours is not slowed."""

WAITED = 30.0
"""The most seconds that an agent waits for a first report."""


class LiveReport(PassedOn):
    """Passes events on to another observer, and writes the report in a process of its own.

    The first report starts when a slow agent begins, or a minute later if nothing has been played yet. If a language
    model is to compute on this machine, the report starts before, when the first agent that is no baseline has been
    played: the study is then seen while the others play. Who plays on this machine waits for the report, as both would
    wait for the same processors. The pauses between later reports double, and they are written with low priority. At
    most one process writes. Its output is discarded: the run writes the last report itself. Without a directory there
    are no reports.

    Args:
        observer: Gets the events.
        directory: The directory of the study.
        begins: Told how many trials a first report has, where an agent waits for it.
        tell: Told once where a first report can be read.
    """

    def __init__(
        self,
        observer: Observer,
        directory: Path | None,
        *,
        begins: Callable[[int], None] = lambda trials: None,
        tell: Callable[[Path], None] = lambda path: None,
    ) -> None:
        super().__init__(observer)
        self._begins, self._tell = begins, tell
        self._directory = directory
        self._simulated = False
        self._embedded = False  # whether a model computes on this machine
        self._turn = ""  # the agent that plays
        self._played = 0
        self._pause = PAUSE
        self._next: float | None = None  # None: no slow agent's turn has come
        self._writing: subprocess.Popen[bytes] | None = None
        self._first: subprocess.Popen[bytes] | None = None  # of which nothing has been told yet

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Note how much was played before."""
        self._simulated = study.simulated
        self._embedded = any(resolve(agent).engine == "process" for agent in study.run_agents)
        self._played = len(journal.trials)
        self._observer.begin(study, journal, owed)

    def agent(self, source: AgentSource, owed: int) -> None:
        """Report the trials of the others before a slow agent begins, or the first ones before an embedded model."""
        is_slow = self._simulated or source.engine != "inline"
        if self._next is None and (is_slow or (self._embedded and self._shows_something())):
            self._next = time.monotonic() + (0 if self._played else FIRST_PAUSE)
            self._renew()
            if self._first is not None and (source.engine == "process" or not is_slow):
                self._begins(self._played)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._first.wait(WAITED)
                self._tell_of_first()
        self._turn = source.spec
        self._observer.agent(source, owed)

    def _shows_something(self) -> bool:
        """Whether the agent that has just played is none of those that others are compared with."""
        return bool(self._played and self._turn) and not is_baseline(self._turn)

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Pass a trial on, and update the report if it is due."""
        self._observer.trial(trial, timing)
        self._played += 1
        self._renew()
        self._tell_of_first()

    def end(self) -> None:
        """Wait for the report that is being written."""
        if self._writing is not None:
            self._writing.wait()

    def stop(self) -> None:
        """End the report that is being written, of a run that was refused: its settings do not stay."""
        if self._writing is not None and self._writing.poll() is None:
            self._writing.terminate()
            self._writing.wait()

    def _tell_of_first(self) -> None:
        if self._first is not None and self._first.poll() is not None and self._directory is not None:
            if not self._first.poll():
                self._tell(self._directory / "report.html")
            self._first = None

    def _renew(self) -> None:
        if self._directory is None or self._next is None or time.monotonic() < self._next:
            return
        if self._writing is not None and self._writing.poll() is None:
            return
        command = interpreter("-m", "lockprobe", "report", str(self._directory))
        quiet = subprocess.DEVNULL
        with safe_path(), contextlib.suppress(OSError):  # a machine that can start no process has its report at the end
            self._writing = subprocess.Popen(  # noqa: S603 - ourselves
                command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
            )
            if self._pause == PAUSE:
                self._first = self._writing
            else:
                os.setpriority(os.PRIO_PROCESS, self._writing.pid, 10)
        self._next = time.monotonic() + self._pause
        self._pause *= 2
