"""A learned policy as an agent for studies. Needs no Gymnasium."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from lockprobe.agents.modalities import refuse_pictures
from lockprobe.agents.policy import told_outcome
from lockprobe.environment.observation import Images, Vector, so_far, stacked
from lockprobe.record import STATES, Decision, Fact, Percept, Situation
from lockprobe.spec import spec_name

__all__ = ["LearnedAgent"]


class LearnedAgent:
    """Plays a study by what it learned in the environment: subclass it and write :meth:`act`.

    It keeps nothing between calls, as every agent: :meth:`act` gets all observations of the trial so far. Of its last
    action it says what it was told.

    Attributes:
        facts: What it is, for the record: algorithm, training seed, file hash.
        observation: What it learned from: ``symbolic``, where outcomes are told and, in studies that tell states
            alone, found by comparing reports, as strategies do; ``symbolic?tell=state``, which leaves them untold; or
            ``rgb`` or ``rgbd`` for studies of that modality.
        steps_left: Whether its observations hold the steps left.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}
    observation: ClassVar[str] = "symbolic"
    steps_left: ClassVar[bool] = False

    def act(self, observations: Any, rng: np.random.Generator) -> int:
        """The joint to attempt next, by its place in the listing.

        Args:
            observations: All of the trial so far on a first axis of their own, the newest last: vectors, shape
                (1 + steps played, entries), or colours, or a mapping of colours and depth.
            rng: The agent's stream; nothing else may be random.
        """
        raise NotImplementedError

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Attempt the joint that :meth:`act` chooses.

        Raises:
            BadValue: If it learned from reports and is shown pictures.
        """
        joint = self.act(self._observations(situation), rng)
        return Decision(joint=situation.task.joints[int(joint)], claimed=told_outcome(situation))

    def _observations(self, situation: Situation) -> Vector | Images:
        if spec_name(self.observation) == "symbolic":
            refuse_pictures(situation.percept, type(self).__name__)
            heard = situation if self.observation == STATES else _compared(situation)
            return so_far(heard, steps_left=self.steps_left)
        return stacked([*(turn.percept for turn in situation.past), situation.percept], self.observation)


def _compared(situation: Situation) -> Situation:
    """The situation with the outcomes that comparing its reports says, where none are told."""
    past = tuple(
        replace(turn, percept=_with_outcome(replace(situation, past=situation.past[:done], percept=turn.percept)))
        for done, turn in enumerate(situation.past)
    )
    return replace(situation, past=past, percept=_with_outcome(situation))


def _with_outcome(situation: Situation) -> Percept:
    return replace(situation.percept, outcome=told_outcome(situation))
