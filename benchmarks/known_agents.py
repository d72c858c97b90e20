"""The agents of known truth in ``recovery.py``: of known parameters, of known models, and with known rules.

No candidate model describes most of the rules. They ignore reports, so any claim about reports is false. One rule is
an exception: it avoids the joint that just failed and also prefers some labels.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lockprobe.agents.policy import draw
from lockprobe.trial.record import Decision, Fact, Situation

PARAMETERS: Mapping[str, Mapping[str, float]] = {
    name: dict(
        zip(("target", "closed", "failure", "recent", "stay", "position", "decay", "reset"), values, strict=True)
    )
    for name, values in {
        "forgetful": (0.5, 0.5, 2.0, -0.5, -1.0, 0.5, 0.7, 0.5),
        "careful": (1.5, 1.0, 4.0, 0.0, -1.0, 0.0, 1.0, 1.0),
        "stubborn": (0.0, 0.0, -1.0, 1.0, 0.5, 1.0, 0.9, 0.1),
        "faint": (0.3, 0.2, 0.7, -0.3, -0.2, 0.2, 0.9, 0.3),
    }.items()
}
"""Agent -> its parameters of ``softmax-memory``, by name."""


def softmax_memory(parameters: Mapping[str, float]) -> str:
    """The spec of the agent with these parameters of ``softmax-memory``."""
    return "cognitive:softmax-memory?" + "&".join(f"{name}={value:g}" for name, value in parameters.items())


MODELS: Mapping[str, str] = {
    "random": "random",
    "round-robin": "round-robin",
    "no-repeat": "cognitive:softmax-memory?recent=-2",
    "win-stay-lose-shift": "cognitive:softmax-memory?recent=-1.5&stay=2.5",
    "failure-memory": "cognitive:softmax-memory?failure=2&decay=0.8&reset=0.8",
    "goal-and-failures": "cognitive:softmax-memory?target=1&closed=0.7&failure=2&decay=0.8&reset=0.8",
    "softmax-memory": softmax_memory({**PARAMETERS["forgetful"], "position": 0.7}),
    "human-inspired": "human-inspired:target-first?lapse=0.15",
    "random-map": "cognitive:random-map?window=1&avoid=last&lapse=0.15",
}
"""Model -> the spec of an agent that acts by it."""


class RuleAgent:
    """An agent that draws joints by the weights of a rule and keeps nothing between steps."""

    @property
    def facts(self) -> Mapping[str, Fact]:
        """No facts for the record: its trials are fitted and discarded."""
        return {}

    def weights(self, situation: Situation) -> Sequence[float]:
        """The weight of each joint in the order of the listing, >= 0, not all 0."""
        raise NotImplementedError

    def probabilities(self, situation: Situation) -> tuple[float, ...]:
        """The probability of each joint in the order of the listing."""
        weights = self.weights(situation)
        return tuple(weight / math.fsum(weights) for weight in weights)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Draw a joint, without a claim about the last action."""
        return Decision(joint=situation.task.joints[draw(self.probabilities(situation), rng)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Favourites(RuleAgent):
    """A rule that prefers joints by label, or by place in the listing.

    Attributes:
        by: ``label``, in alphabetical order, or ``place``, in the order of the listing.
        pull: Log odds of each joint against the next; 0 has no preference.
        repeats: Whether it may attempt the same joint twice in a row.
        failure: Decrease in the log weight of the joint attempted last, if it was reported to have failed.
    """

    by: Literal["label", "place"] = "label"
    pull: float = 0.0
    repeats: bool = True
    failure: float = 0.0

    def weights(self, situation: Situation) -> list[float]:
        """Weights that decrease from the first joint to the last."""
        joints = situation.task.joints
        order = sorted(joints) if self.by == "label" else joints
        last, failed = situation.percept.joint, situation.percept.outcome == "blocked"
        return [
            (self.repeats or joint != last)
            * math.exp(-self.pull * order.index(joint) - self.failure * (failed and joint == last))
            for joint in joints
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstFour(RuleAgent):
    """A rule that attempts every joint once, in any order.

    Attributes:
        then: Its later choices: ``any`` joint at every step, or it ``stays`` with the last one.
    """

    then: Literal["any", "stays"] = "any"

    def weights(self, situation: Situation) -> list[float]:
        """Equal weights for the remaining joints; afterwards for all joints, or for the last one alone."""
        joints, tried = situation.task.joints, [turn.decision.joint for turn in situation.past]
        if left := set(joints).difference(tried):
            return [float(joint in left) for joint in joints]
        return [float(self.then == "any" or joint == tried[-1]) for joint in joints]


@dataclass(frozen=True, slots=True, kw_only=True)
class Switching(RuleAgent):
    """A rule that switches between two rules.

    Attributes:
        first: The first rule.
        second: The second rule.
        when: ``midway``: at half of the budget. ``any``: a coin chooses the rule at every step.
    """

    first: RuleAgent
    second: RuleAgent
    when: Literal["midway", "any"] = "midway"

    def weights(self, situation: Situation) -> Sequence[float]:
        """The weights of the current rule."""
        rules = self.first, self.second
        if self.when == "midway":
            return rules[2 * len(situation.past) >= situation.task.budget].probabilities(situation)
        first, second = (rule.probabilities(situation) for rule in rules)
        return [(one + other) / 2 for one, other in zip(first, second, strict=True)]


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownAgent:
    """An agent and the truth about it.

    Attributes:
        agent: The agent, or its spec.
        pulls: True effects by the names of :class:`lockprobe.simulation.fit.result.FitClaim`: 1 if a joint becomes more
            likely, -1 if less likely, None if undetermined. Effects that are not named are absent.
    """

    agent: str | RuleAgent
    pulls: Mapping[str, int | None]


_ANY = Favourites()
_NO_REPEAT = Favourites(repeats=False)

WORLDS: Mapping[str, KnownAgent] = {
    "prefers labels": KnownAgent(agent=Favourites(by="label", pull=1.0), pulls={}),
    "prefers labels, never repeats": KnownAgent(
        agent=Favourites(by="label", pull=1.0, repeats=False), pulls={"recent": -1}
    ),
    "prefers labels, leaves what just failed": KnownAgent(
        agent=Favourites(by="label", pull=1.5, failure=1.0),
        pulls={"reports": 1, "failure": -1, "recent": None, "stay": 1},
    ),
    "prefers places": KnownAgent(agent=Favourites(by="place", pull=1.0), pulls={"position": 1}),
    "prefers places, never repeats": KnownAgent(
        agent=Favourites(by="place", pull=1.0, repeats=False), pulls={"position": 1, "recent": -1}
    ),
    "all joints once, then any": KnownAgent(agent=FirstFour(then="any"), pulls={"recent": None}),
    "all joints once, then stays": KnownAgent(agent=FirstFour(then="stays"), pulls={"recent": None}),
    "any joint, midway no repeats": KnownAgent(agent=Switching(first=_ANY, second=_NO_REPEAT), pulls={"recent": -1}),
    "no repeats, midway prefers labels": KnownAgent(
        agent=Switching(first=_NO_REPEAT, second=Favourites(by="label", pull=1.5)), pulls={"recent": None}
    ),
    "all joints once, or prefers places, by a coin": KnownAgent(
        agent=Switching(first=FirstFour(then="any"), second=Favourites(by="place", pull=1.5), when="any"),
        pulls={"position": 1, "recent": None},
    ),
    "failure memory": KnownAgent(
        agent="cognitive:softmax-memory?failure=2&decay=0.8&reset=0.8",
        pulls={"reports": 1, "failure": -1, "recent": None, "stay": None},
    ),
    "human-inspired": KnownAgent(
        agent="human-inspired:target-first?lapse=0.15",
        pulls=dict.fromkeys(("target", "closed", "failure", "recent", "stay", "position"), None) | {"reports": 1},
    ),
}
"""The known agents by their behaviour. The last two heed reports, to check that true claims are still made."""
