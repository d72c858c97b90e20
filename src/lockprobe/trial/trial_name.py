"""The name of a trial: the key of its record. It is written here and taken apart nowhere."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TrialName:
    """A trial of a study, as its record and its calls name it: five parts between slashes, whatever the names hold.

    >>> str(TrialName("flips", "llm:openai/gpt-4o", "flip?p=0.4", repetition=2, trial=7))
    'flips/llm:openai%2Fgpt-4o/flip?p=0.4/rep=2/trial=7'

    ``agent`` is its name, or its spec if it has none; ``participant`` for people, who share its trials.
    """

    study: str
    agent: str
    condition: str
    repetition: int
    trial: int

    @property
    def cell(self) -> str:
        """The agent under the condition: the first three parts."""
        return "/".join(map(_written, (self.study, self.agent, self.condition)))

    @property
    def place(self) -> str:
        """Its place among the trials of its agent: the last three parts."""
        return f"{_written(self.condition)}/rep={self.repetition}/trial={self.trial}"

    def __str__(self) -> str:
        return f"{_written(self.study)}/{_written(self.agent)}/{self.place}"


def _written(part: str) -> str:
    return part.replace("/", "%2F")


@dataclass(frozen=True, slots=True, kw_only=True)
class ForkName:
    """A fork of a recorded trial, as its record names it.

    >>> str(ForkName(parent="flips/random/truth/rep=1/trial=7", at=8, arm="lie", time=2))
    'flips/random/truth/rep=1/trial=7/at=8/lie/time=2'

    ``parent`` is the key of the recorded trial, ``at`` the step whose report is changed, from 1, and ``time`` the
    number of this continuation, from 1. If it is ``truthful`` all later reports are true; else they are as in the
    trial's condition.
    """

    parent: str
    at: int
    arm: str
    truthful: bool = False
    time: int = 1

    def __str__(self) -> str:
        then = "/then=truth" if self.truthful else ""
        return f"{self.parent}/at={self.at}/{self.arm}{then}/time={self.time}"
