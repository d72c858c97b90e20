"""What a run counts while it goes on."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence

from lockprobe.agents.catalogue import AgentSource
from lockprobe.cli.format_cost import spent_in_words
from lockprobe.record import Trial
from lockprobe.studies.call_log import Calls
from lockprobe.studies.records import LeftOut
from lockprobe.studies.spending import Ledger
from lockprobe.studies.study import Study
from lockprobe.studies.valid import Invalid

__all__ = ["Tally", "count", "foreign_in_words", "in_boundaries", "invalid_in_words"]

_RATE = "flip rate "
"""How the name of a condition begins that is a flip rate."""

_LONG = 5.0
"""Seconds after which a call that has not come back is spoken of."""


class Tally:
    """The state of a run: what was played, solved and broken, how fast, and what it cost.

    Args:
        study: What is played; None as long as nothing is.

    Attributes:
        ended_in_all: Trials of this run that ended, all agents together.
        broken_in_all: Trials of it that something outside their agent broke.
        first_error: Where the first of those broke, and what was said.
        ledger: What the study has cost; None where nobody is asked.
        calls: Its calls, as above.
    """

    def __init__(self, study: Study | None = None) -> None:
        self._shows = study is not None and study.names_modalities
        self.owed = self.played = self.steps = self.ended_in_all = self.broken_in_all = 0
        self.first_error = ""
        self.errors: Counter[str] = Counter()
        self.solved: Counter[str] = Counter()
        self.ended: Counter[str] = Counter()
        self.ledger: Ledger | None = None
        self.calls: Calls | None = None
        self.agent = ""
        self.slow = False
        self._began = time.monotonic()
        self.agent_owed = 0

    def turn(self, source: AgentSource, owed: int, done: list[Trial], *, slow: bool) -> None:
        """Another agent begins; its trials of an earlier run count as solved or not, but not as played.

        Args:
            source: The agent.
            owed: Trials that it is to play.
            done: Trials that it has played before.
            slow: Whether a step takes so long that one wants to see it.
        """
        self.agent, self.slow, self.agent_owed = source.spec, slow, owed
        self.played = self.steps = 0
        self.errors.clear()
        self.solved.clear()
        self.ended.clear()
        self._began = time.monotonic()
        for trial in done:
            self._count(trial)

    def _count(self, trial: Trial) -> None:
        flipped = "" if trial.p is None else f"{_RATE}{trial.p:g}"
        condition = trial.condition or (trial.modality if self._shows and not trial.p else flipped)
        self.ended[condition] += trial.ending != "error"
        self.solved[condition] += trial.solved

    def trial(self, trial: Trial) -> None:
        """A trial is on disk."""
        self.played += 1
        self.broken_in_all += trial.owed_again
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
            return "…"
        seconds = (time.monotonic() - self._began) / self.played * (self.agent_owed - self.played)
        return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"

    @property
    def waiting(self) -> str:
        """How long a provider has been making us wait, in words; empty where it answers soon."""
        if self.calls is None or (longest := self.calls.longest_wait) < _LONG:
            return ""
        return f"{count(self.calls.on_their_way, 'call')} on the way, the oldest for {longest:.0f} s"

    def line(self, *, solved: bool = True) -> str:
        """The state in one line, with or without what is solved under which condition."""
        ended = sorted(shown for shown, number in self.ended.items() if number)
        shares = ", ".join(f"{shown}: {self.solved[shown]}/{self.ended[shown]}" for shown in ended)
        if ended and all(shown.startswith(_RATE) for shown in ended):
            shares = f"at {_RATE}{shares.replace(_RATE, '')}"
        parts = [
            f"{self.agent}  {self.played}/{self.agent_owed} trials",
            f"solved {shares}" if solved and shares else "",
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


def count(number: int, one: str, several: str | None = None) -> str:
    """A number of things: ``1 trial``, ``2 trials``, ``3 replies``."""
    return f"{number} {one if number == 1 else several or f'{one}s'}"


def foreign_in_words(left_out: LeftOut) -> str:
    """That records of other studies stand in a journal, how many, and which is the first; empty where none does."""
    if not left_out.foreign:
        return ""
    records = count(left_out.foreign, "record")
    return f"{records} of another study in trials.jsonl are not counted; the first is {left_out.first_foreign}"


def invalid_in_words(found: Sequence[Invalid]) -> str:
    """Conditions without a valid trial in one line: which, why, and what plays their trials again; at least one."""
    errors, owed = sum(one.errors for one in found), sum(one.owed for one in found)
    others = f" and {count(len(found) - 1, 'more condition')}" if len(found) > 1 else ""
    ended = "the only trial" if errors == 1 else f"all {errors} trials"
    first = f"{found[0].first.boundary}: {' '.join(found[0].first.message.split())[:200]}"
    remedy = {errors: "the same command plays them again", 0: "the same command with --again reply plays them anew"}
    mixed = f"the same command plays {owed} of them again, with --again reply all"
    return (
        f"No valid trial of {found[0].condition}{others}: {ended} ended as an error, the first at {first}; "
        f"{remedy.get(owed, mixed)}"
    )
