"""A policy learned in the environment as an agent for studies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from lockprobe.agents.modalities import refuse_pictures
from lockprobe.agents.policy import told_outcome
from lockprobe.foundation.spec import spec_name
from lockprobe.interfaces.gymnasium.observation import Images, Vector, so_far, stacked
from lockprobe.trial.record import STATES, Decision, Fact, Percept, Situation

__all__ = ["LearnedAgent"]


class LearnedAgent:
    """An agent that plays studies with a learned policy: subclass it and write :meth:`act`.

    As every agent, it keeps nothing between calls: :meth:`act` gets all observations of the trial so far. It claims
    the outcome that it was told. It needs no Gymnasium.

    Attributes:
        facts: For the record: algorithm, training seed, file hash.
        observation: The observation in training. ``symbolic`` holds outcomes; in studies that tell only states, it
            infers them by comparing reports, as strategies do. ``symbolic?tell=state`` holds no outcomes. ``rgb`` and
            ``rgbd`` are for studies of that modality.
        steps_left: Whether its observations hold the steps left.
    """

    facts: ClassVar[Mapping[str, Fact]] = {}
    observation: ClassVar[str] = "symbolic"
    steps_left: ClassVar[bool] = False

    def act(self, observations: Any, rng: np.random.Generator) -> int:
        """The joint to attempt next, by its index in the listing.

        Args:
            observations: All observations of the trial, stacked along a first axis, the newest last: vectors, shape
                (1 + steps played, entries), or colours, or a mapping of colours and depth.
            rng: The agent's stream, the only source of randomness.
        """
        raise NotImplementedError

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Attempt the joint that :meth:`act` chooses.

        Raises:
            BadValue: If it learned from reports and the study shows pictures.
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
    """The situation with outcomes inferred by comparing reports where none are told."""
    past = tuple(
        replace(turn, percept=_with_outcome(replace(situation, past=situation.past[:done], percept=turn.percept)))
        for done, turn in enumerate(situation.past)
    )
    return replace(situation, past=past, percept=_with_outcome(situation))


def _with_outcome(situation: Situation) -> Percept:
    return replace(situation.percept, outcome=told_outcome(situation))
