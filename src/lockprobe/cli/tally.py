"""What a run has come to: what was played, solved and broken, how fast, and what it cost."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import spent_in_words
from lockprobe.foundation.formatting import count
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.records.trial_rows import OnRecord
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

_LONG = 5.0
"""Seconds after which a call that has not come back is spoken of."""


class Tally:
    """The state of a run, and of its present agent.

    Attributes:
        ended_in_all: Trials of this run that ended, over all agents.
        broken_of: Agents of which trials broke outside them in this run, each with their number.
        first_error: Boundary and message of the first of these.
        given_up: Agents that could not go on -> why, and how many trials they owe.
        ledger: The cost of the study; None where no provider is asked.
        calls: Its calls; None likewise.
        agent: The present agent, as the study calls it.
        slow: Whether it takes so long that its steps are worth telling.
        solved, ended: Its trials by condition, those of earlier runs included.
        guess: The first guess of the time that it takes, in words, until a trial says more; "…" without one.
        tells_solved: Whether a line says how many trials are solved.
    """

    def __init__(self, study: Study | None = None) -> None:
        self._study = study
        self.ended_in_all = 0
        self.broken_of: Counter[str] = Counter()
        self.first_error = ""
        self.given_up: dict[str, tuple[str, int]] = {}
        self.ledger: Ledger | None = None
        self.calls: Calls | None = None
        self.agent, self.slow, self.guess = "", False, "…"
        self.agent_owed = self.before = self.played = self.steps = 0
        self.errors: Counter[str] = Counter()
        self.solved: Counter[str] = Counter()
        self.ended: Counter[str] = Counter()
        self.tells_solved = True
        self._began = time.monotonic()

    def turn(self, source: AgentSource, owed: int, done: list[OnRecord]) -> None:
        """Start counting another agent, with ``owed`` trials to play.

        Trials of an earlier run (``done``) count as trials of the study, but not for the time that is left.
        """
        study = self._study
        self.agent = source.spec if study is None else study.label_of(source.spec)
        self.slow = source.engine != "inline" or (study is not None and study.simulated)
        self.agent_owed, self.before, self.played, self.steps = owed, len(done), 0, 0
        for counted in (self.errors, self.solved, self.ended):
            counted.clear()
        self._began = time.monotonic()
        for trial in done:
            self._count(trial)

    def _count(self, trial: Trial | OnRecord) -> None:
        self.ended[trial.condition] += trial.ending != "error"
        self.solved[trial.condition] += trial.solved

    def trial(self, trial: Trial) -> None:
        """A trial is on disk."""
        self.played += 1
        if trial.owed_again:
            assert trial.error is not None
            self.broken_of[trial.group] += 1
            self.first_error = self.first_error or f"{trial.error.boundary}: {trial.error.message}"
        else:
            self.ended_in_all += 1
        if trial.error is not None:
            self.errors[trial.error.boundary] += 1
        self._count(trial)

    def line(self, *, solved: bool = True) -> str:
        """The state in one short line, with or without how many trials are solved, under all conditions together."""
        ended, seconds = self.ended.total(), max(time.monotonic() - self._began, 1e-9)
        left = self.guess
        if self.played:
            needed = seconds / self.played * (self.agent_owed - self.played)
            left = f"{needed / 60:.0f} min" if needed > 90 else f"{needed:.0f} s"
        waiting = ""
        if self.calls is not None and (longest := self.calls.longest_wait) >= _LONG:
            waiting = f"{count(self.calls.on_their_way, 'call')} on the way, the oldest for {longest:.0f} s"
        parts = [
            f"{self.agent}  {self.before + self.played}/{self.before + self.agent_owed} trials",
            f"{self.solved.total()} of {ended} solved" if solved and ended and self.tells_solved else "",
            f"{self.steps / seconds:.1f} steps/s",
            f"{left} left",
            spent_in_words(self.ledger.total) if self.ledger is not None else "",
            waiting,
            in_boundaries(self.errors),
        ]
        return " · ".join(filter(None, parts))


def in_boundaries(errors: Mapping[str, int]) -> str:
    """Errors by boundary: ``3 errors: model 2, reply 1``; empty where there are none."""
    if not (number := sum(errors.values())):
        return ""
    return f"{count(number, 'error')}: {', '.join(f'{name} {errors[name]}' for name in sorted(errors))}"
