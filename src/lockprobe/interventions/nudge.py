"""The intervention ``nudge``: a sentence tells the agent that it repeats an action loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops import onset
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Moment, Task

NUDGE = "Note: you are repeating the same series of actions; consider trying another one."


@dataclass(frozen=True, slots=True, kw_only=True)
class Nudge:
    """A sentence tells the agent that it repeats itself, when it has just completed a copy of an action loop.

    With ``after=2`` that is the first loop of a trial, so it is said once at most; with more, it is said whenever the
    last choices are that many consecutive copies.

    The report stays as it is, and is true. Agents that read no words ignore it. Nothing is drawn.

    Attributes:
        after: Copies of a loop after which it is said, from 2.

    Raises:
        BadValue: If it is none of these.
    """

    name: ClassVar[str] = "nudge"
    after: int = 2

    def __post_init__(self) -> None:
        if self.after < 2:
            raise BadValue("after", self.after, "a number of copies from 2")

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """The briefing with the sentence, where it is due."""
        if not loops_completed(past, self.after):
            return briefing
        return briefing.remarking(NUDGE)


def loops_completed(past: tuple[Moment, ...], copies: int) -> bool:
    """Whether the last choice completed this many disjoint copies of an action loop.

    A loop is a run of three or more choices, as in the paper (Sec. 3.3). Two copies are those of the first loop of the
    trial, and there may be other choices between them; more copies are consecutive.
    """
    chosen = tuple(moment.chosen for moment in past[1:])
    if copies == 2:
        return len(chosen) > 0 and onset(chosen) == len(chosen)
    longest = len(chosen) // copies
    return any(chosen[-length:] * copies == chosen[-length * copies :] for length in range(3, longest + 1))
