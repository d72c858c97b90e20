"""The contract of agents holds for ours and finds who breaks it."""

import random
from types import MappingProxyType

import pytest

from lockprobe.agents.strategies import RandomAgent
from lockprobe.testing import ScriptedAgent, check_agent
from lockprobe.trial.record import Decision


@pytest.mark.parametrize("agent", ["random", "human-inspired", "cognitive:perseverant", ScriptedAgent(joints=(0, 2))])
def test_agents_that_keep_it(agent):
    check_agent(agent, boxes=["chain-4"])


class Agent(RandomAgent):
    facts = MappingProxyType({})


class Counts(Agent):
    """Takes another joint whenever it is asked."""

    asked = 0

    async def decide(self, situation, rng):
        self.asked += 1
        return Decision(joint=situation.task.joints[self.asked % 4])


class Forgets(Agent):
    """Keeps the trial in itself, and begins anew with the first look: one by one nobody can tell."""

    async def decide(self, situation, rng):
        if not situation.past:
            self.told = []
        self.told.append(situation.percept.outcome)
        return Decision(joint=situation.task.joints[self.told.count("moved") % 4])


class Elsewhere(Agent):
    """Draws from a stream of its own."""

    async def decide(self, situation, rng):
        return Decision(joint=random.choice(situation.task.joints))


class Unlisted(Agent):
    async def decide(self, situation, rng):
        return Decision(joint="Z")


class Odd(Agent):
    facts = MappingProxyType({"path": {"a": 1}})


class Breaks(Agent):
    async def decide(self, situation, rng):
        raise KeyError("no such thing")


@pytest.mark.parametrize(
    ("agent", "said"),
    [
        (Counts(), "plays the same trial differently again"),
        (Elsewhere(), "plays the same trial differently again"),
        (Forgets(), "keeps something between calls"),
        (Unlisted(), "'Z' is no joint"),
        (Odd(), "a fact of Odd is no text"),
        (Breaks(), r"a trial of Breaks broke: in the agent \(test_agents.py, line \d+\): KeyError: 'no such thing'"),
        (object(), "has no `facts` or no `decide`"),
    ],
)
def test_agents_that_break_it(agent, said):
    with pytest.raises(AssertionError, match=said):
        check_agent(agent, boxes=["chain-4"])
