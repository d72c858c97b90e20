"""Who receives the progress of a run."""

from __future__ import annotations

from lockprobe.agents.catalogue import AgentSource
from lockprobe.foundation.errors import UserMistake
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.study import Study
from lockprobe.trial.record import Step, Trial


class Observer:
    """Receives the progress of a run, and ignores what it does not override."""

    def begin(self, study: Study, journal: Journal, owed: int) -> None:
        """Called once, with the number of trials still to be played."""

    def agent(self, source: AgentSource, owed: int) -> None:
        """Called before an agent's trials begin."""

    def step(self, key: str, step: Step) -> None:
        """Called after every step of every trial."""

    def trial(self, trial: Trial, timing: Timing) -> None:
        """Called when a trial is on disk."""

    def more(self, owed: int) -> None:
        """Called after trials of an agent, with those that follow, as those before the next look of a study."""

    def given_up(self, source: AgentSource, owed: int, why: UserMistake) -> None:
        """Called if no further trial of an agent is played, with the number that it still owes."""
