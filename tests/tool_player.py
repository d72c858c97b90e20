"""A policy that decides from the words alone: as an agent of a run, and as a client with tools that plays the same."""

import json
import re
from types import MappingProxyType

from stored import records

from lockprobe.interfaces.mcp import CallRefused
from lockprobe.trial.record import Decision

SPEC = "python:tool_player:Scripted"
AGENT = "mcp:scripted"
FACTS = {"client": "test", "client_version": "1", "protocol": "MCP tools"}


def at_one(text):
    """The joints that a report says are at position 1."""
    return set(re.search(r"At 1: (.*?)\.", text)[1].replace("none", "").replace(",", "").split())


def choice(joints, target, told, chosen):
    """The next joint, what the last one did, and a hypothesis: the target after every change, else the next joint."""
    if not chosen:
        return joints[0], None, "nothing yet"
    moved = at_one(told[-1]) != at_one(told[-2])
    joint = target if moved and chosen[-1] != target else joints[(joints.index(chosen[-1]) + len(told)) % len(joints)]
    return joint, "moved" if moved else "blocked", f"{len(told)}: {chosen[-1]} {'did' if moved else 'did not'}"


class Scripted:
    """The policy in the loop."""

    facts = MappingProxyType({})

    async def decide(self, situation, rng):
        task = situation.task
        told = [*(turn.percept.text for turn in situation.past), situation.percept.text]
        chosen = [turn.decision.joint for turn in situation.past]
        joint, claimed, hypothesis = choice(task.joints, task.target, told, chosen)
        return Decision(joint=joint, claimed=claimed if task.assessment else None, hypothesis=hypothesis)


class Player:
    """The policy behind tools: it keeps what it was told, and picks it up again from what ``observe`` says.

    ``call(tool, arguments)`` returns the words of a result, or None for one that is marked as an error.
    """

    def __init__(self, call, assessment=True):
        self.call, self.assessment = call, assessment
        self.joints = self.target = self.told = self.chosen = None

    async def begin(self):
        """Read a trial from its beginning, or from where it stood; False if none is left."""
        text = await self.call("observe", {})
        if text is None:
            return False
        named = re.search(r"The panel's joints: (.*?)\. The target joint: (.)\.", text)
        self.joints, self.target = named[1].split(", "), named[2]
        self.chosen = re.findall(r"^\d+\. .*You attempted (.)\.", text, re.MULTILINE)
        rest = text[named.end() :]
        self.told = [found[0] for found in re.finditer(r"(You attempted .\. )?At 1: .*?\.", rest)]
        assert len(self.told) == len(self.chosen) + 1
        return True

    async def step(self):
        """Attempt a joint; False at the end of the trial."""
        joint, claimed, hypothesis = choice(self.joints, self.target, self.told, self.chosen)
        given = {"joint": joint, "hypothesis": hypothesis}
        if self.assessment and claimed is not None:
            given["last_action"] = {"moved": "moved", "blocked": "did not move"}[claimed]
        text = await self.call("attempt", given)
        assert text is not None
        if text.startswith("The trial is over."):
            return False
        self.told.append(text)
        self.chosen.append(joint)
        return True

    async def play(self, most=10**6):
        """Play trials until none is left, at most so many; how many were played to their end."""
        for played in range(most):
            if not await self.begin():
                return played
            while await self.step():
                pass
        return most


def calls(session):
    """A session as :class:`Player` calls it."""

    async def call(tool, given):
        try:
            return (await session.call(tool, given, FACTS))[0].text
        except CallRefused:
            return None

    return call


def plain_records(directory):
    """The text of every record without the agent's name and its facts, by key."""
    found = {}
    for record in records(directory):
        text = json.dumps({**record, "facts": None}).replace(SPEC, "AGENT").replace(AGENT, "AGENT")
        assert found.setdefault(json.loads(text)["key"], text) is text
    return found
