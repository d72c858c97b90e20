"""Who receives the progress of a run."""

from __future__ import annotations

from typing import Protocol

from lockprobe.agents.catalogue import AgentSource
from lockprobe.foundation.errors import UserMistake
from lockprobe.studies.records.journal import Journal, Timing
from lockprobe.studies.study import Study
from lockprobe.trial.record import Step, Trial

__all__ = ["Observer", "Silent"]


class Observer(Protocol):
    """Receives the progress of a run."""

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Called once, with the number of trials still to be played."""
        ...

    def agent(self, source: AgentSource, owed: int) -> None:
        """Called before an agent's trials begin."""
        ...

    def step(self, key: str, step: Step) -> None:
        """Called after every step of every trial."""
        ...

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Called when a trial is on disk."""
        ...

    def more(self, owed: int) -> None:
        """Called after a look that has not decided all, with the trials to be played before the next."""
        ...

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Called if no further trial of an agent is played, with the number that it still owes."""
        ...


class Silent:
    """An observer that ignores all events."""

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Nothing."""

    def agent(self, source: AgentSource, owed: int) -> None:
        """Nothing."""

    def step(self, key: str, step: Step) -> None:
        """Nothing."""

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Nothing."""

    def more(self, owed: int) -> None:
        """Nothing."""

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Nothing."""
