"""A learned policy as an agent for studies. Needs no Gymnasium."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lockprobe.environment.observation import Vector, so_far
from lockprobe.record import Decision, Fact, Situation

__all__ = ["LearnedAgent"]


class LearnedAgent:
    """Plays a study by what it learned in the environment: subclass it and write :meth:`act`.

    It keeps nothing between calls, as every agent: :meth:`act` gets all observations of the trial so far. Of its last
    action it says what it was told.

    Attributes:
        facts: What it is, for the record: algorithm, training seed, file hash.
        steps_left: Whether its observations hold the steps left.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}
    steps_left: ClassVar[bool] = False

    def act(self, observations: Vector, rng: np.random.Generator) -> int:
        """The joint to attempt next, by its place in the listing.

        Args:
            observations: All of the trial so far, shape (1 + steps played, entries), the newest last.
            rng: The agent's stream; nothing else may be random.
        """
        raise NotImplementedError

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Attempt the joint that :meth:`act` chooses."""
        joint = self.act(so_far(situation, steps_left=self.steps_left), rng)
        return Decision(joint=situation.task.joints[int(joint)], claimed=situation.percept.outcome)
