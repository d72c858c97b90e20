"""Agents outside of the loop: people at a page (``participant``, ``participant:ID``) and clients with tools.

A client connects to ``lockprobe mcp``, and whoever starts that server chooses its name: ``mcp:NAME``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import BadValue, ChannelFault
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind
from lockprobe.trial.record import Decision, Fact, Outcome, Situation

if TYPE_CHECKING:
    import asyncio

    import numpy as np

SAME_IN_ALL_TRIALS = ("client", "wording")
"""Facts of a client that may not change under its name: records that differ in them are different conditions."""

_FORMS = {
    PEOPLE: (r"(:[a-z0-9]{4,32})?", "participant, or participant:ID with 4 to 32 lower-case letters and digits"),
    MCP: (
        r":[A-Za-z0-9][A-Za-z0-9._-]{0,63}",
        "mcp:NAME with at most 64 letters, digits, dots, hyphens and underscores",
    ),
}
"""How the specs of people and of clients go on after their kind, and the same in words."""


def participant_spec(identity: str) -> str:
    """The agent spec of one person."""
    return f"{PEOPLE}:{identity}"


def check_outside(spec: str, kind: str = "") -> str:
    """A spec that names a person or a client; ``kind`` is that of its own unless it is given.

    Raises:
        BadValue: If it names none.
    """
    kind = kind or spec_kind(spec)
    form, expected = _FORMS[kind]
    if not re.fullmatch(f"{kind}{form}", spec):
        raise BadValue("agent", spec, expected)
    return spec


class OutsideAgent:
    """One trial of an agent that decides outside. The trial waits at each decision until :meth:`say` is called.

    Args:
        facts: How the agent was reached, for the record: a page, a connection. Nothing personal.
        words_alone: Whether remarks and warnings are all that reaches it of what it is asked.
    """

    def __init__(self, facts: Mapping[str, Fact] | None = None, *, words_alone: bool = False) -> None:
        import asyncio  # listing the agents needs none, and it takes long

        self.facts: Mapping[str, Fact] = dict(facts or {})
        self._words_alone = words_alone
        self._asked: asyncio.Queue[Situation] = asyncio.Queue()
        self._said: asyncio.Queue[Decision] = asyncio.Queue()

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Wait for the decision.

        Raises:
            ChannelFault: If an intervention asks for what does not reach the agent.
        """
        if self._words_alone and situation.briefing.instruction:
            raise ChannelFault("an intervention asks for more than a remark or a warning, which is all that is shown")
        self._asked.put_nowait(situation)
        return await self._said.get()

    async def asked(self) -> Situation:
        """The situation of the next decision, as soon as the trial waits for it."""
        return await self._asked.get()

    def say(self, joint: str, claimed: Outcome | None = None, hypothesis: str = "") -> None:
        """Decide: the label of a joint, what the last action did (None if nobody asked), and how the box works."""
        self._said.put_nowait(Decision(joint=joint, claimed=claimed, hypothesis=hypothesis))
