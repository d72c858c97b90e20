"""An agent outside of the loop: a person at a page, or a client with tools. Each decision arrives when it is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lockprobe.foundation.errors import ChannelFault
from lockprobe.trial.record import Decision, Fact, Outcome, Situation

if TYPE_CHECKING:
    import asyncio

    import numpy as np


class OutsideAgent:
    """One trial of an agent that decides outside. The trial waits at each decision until :meth:`say` is called.

    Args:
        facts: How the agent was reached, for the record: a page, a connection. Nothing personal.
        words_alone: Whether remarks and warnings are all that reaches it of what it is asked.
    """

    def __init__(self, facts: Mapping[str, Fact] | None = None, *, words_alone: bool = False) -> None:
        import asyncio  # listing the agents needs none, and it takes long

        self._facts, self._words_alone = dict(facts or {}), words_alone
        self._asked: asyncio.Queue[Situation] = asyncio.Queue()
        self._said: asyncio.Queue[Decision] = asyncio.Queue()

    @property
    def facts(self) -> Mapping[str, Fact]:
        """How the agent was reached."""
        return self._facts

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
        """Decide.

        Args:
            joint: Label of the joint to attempt.
            claimed: What the previous action did; None if nobody asked.
            hypothesis: How the box works, in words.
        """
        self._said.put_nowait(Decision(joint=joint, claimed=claimed, hypothesis=hypothesis))
