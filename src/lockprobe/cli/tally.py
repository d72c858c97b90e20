"""The state of a run in numbers: what was played, solved and broken, how fast, and what it cost."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import spent_in_words
from lockprobe.foundation.formatting import count
from lockprobe.studies.costs.call_log import Calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

_LONG = 5.0
"""Seconds after which a call that has not come back is spoken of."""


class Tally:
    """The state of a run: what was played, solved and broken, how fast, and what it cost.

    Attributes:
        ended_in_all: Trials of this run that ended, over all agents.
        broken_in_all: Trials of this run that broke outside their agent.
        broken_of: The agents of these, each with their number.
        tells_solved: Whether a line says how many trials are solved.
        guess: The first guess of the time that the agent takes, in words, until a trial says more; "…" without one.
        first_error: Boundary and message of the first of those.
        given_up: Agents that could not go on -> why, and how many trials they owe.
        ledger: The cost of the study; None where no provider is asked.
        calls: Its calls; None likewise.
    """

    def __init__(self, study: Study | None = None) -> None:
        self._called = (lambda agent: agent) if study is None else study.label_of
        self.owed = self.played = self.steps = self.ended_in_all = self.broken_in_all = 0
        self.tells_solved = True
        self.first_error = ""
        self.broken_of: Counter[str] = Counter()
        self.given_up: dict[str, tuple[str, int]] = {}
        self.errors: Counter[str] = Counter()
        self.solved: Counter[str] = Counter()
        self.ended: Counter[str] = Counter()
        self.ledger: Ledger | None = None
        self.calls: Calls | None = None
        self.agent, self.guess = "", "…"
        self.slow = False
        self._began = time.monotonic()
        self.agent_owed = self.before = 0

    def turn(self, source: AgentSource, owed: int, done: list[Trial], *, slow: bool) -> None:
        """Start counting another agent, with ``owed`` trials to play.

        Lines call it as the study does. Trials of an earlier run (``done``) count as trials of the study, but not for
        the time that is left. ``slow`` agents show their steps.
        """
        self.agent, self.slow, self.agent_owed = self._called(source.spec), slow, owed
        self.played, self.steps, self.before = 0, 0, len(done)
        self.errors.clear()
        self.solved.clear()
        self.ended.clear()
        self._began = time.monotonic()
        for trial in done:
            self._count(trial)

    def _count(self, trial: Trial) -> None:
        self.ended[trial.condition] += trial.ending != "error"
        self.solved[trial.condition] += trial.solved

    def trial(self, trial: Trial) -> None:
        """A trial is on disk."""
        self.played += 1
        self.broken_in_all += trial.owed_again
        self.broken_of.update([trial.group] if trial.owed_again else [])
        self.ended_in_all += not trial.owed_again
        if trial.error is not None and trial.owed_again and not self.first_error:
            self.first_error = f"{trial.error.boundary}: {trial.error.message}"
        self.errors.update([] if trial.error is None else [trial.error.boundary])
        self._count(trial)

    @property
    def speed(self) -> float:
        """Steps per second of this agent in this run."""
        return self.steps / max(time.monotonic() - self._began, 1e-9)

    @property
    def left(self) -> str:
        """Time left for this agent, in words."""
        if not self.played:
            return self.guess
        seconds = (time.monotonic() - self._began) / self.played * (self.agent_owed - self.played)
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"

    @property
    def waiting(self) -> str:
        """How long a provider has been making us wait, in words; empty where it answers soon."""
        if self.calls is None or (longest := self.calls.longest_wait) < _LONG:
            return ""
        return f"{count(self.calls.on_their_way, 'call')} on the way, the oldest for {longest:.0f} s"

    def line(self, *, solved: bool = True) -> str:
        """The state in one short line, with or without how many trials are solved, under all conditions together."""
        ended = self.ended.total()
        parts = [
            f"{self.agent}  {self.before + self.played}/{self.before + self.agent_owed} trials",
            f"{self.solved.total()} of {ended} solved" if solved and ended and self.tells_solved else "",
            f"{self.speed:.1f} steps/s",
            f"{self.left} left",
            spent_in_words(self.ledger.total) if self.ledger is not None else "",
            self.waiting,
            in_boundaries(self.errors),
        ]
        return " · ".join(part for part in parts if part)


def in_boundaries(errors: Mapping[str, int]) -> str:
    """Errors by boundary: ``3 errors: model 2, reply 1``; empty where there are none."""
    if not (number := sum(errors.values())):
        return ""
    return f"{count(number, 'error')}: {', '.join(f'{name} {errors[name]}' for name in sorted(errors))}"
