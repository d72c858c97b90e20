"""A person as an agent: each decision arrives from outside, whenever the person acts."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from lockprobe.errors import BadValue
from lockprobe.record import Decision, Fact, Outcome, Situation
from lockprobe.spec import PEOPLE

if TYPE_CHECKING:
    import asyncio

    import numpy as np

__all__ = ["Participant", "check_participant", "participant_spec"]

_ID = re.compile(r"[a-z0-9]{4,32}")


def participant_spec(identity: str) -> str:
    """The agent spec of one person.

    >>> participant_spec("3f9a01bc")
    'participant:3f9a01bc'
    """
    return f"{PEOPLE}:{identity}"


def check_participant(spec: str) -> None:
    """Refuse a spec that is no participant.

    Raises:
        BadValue: If it is neither ``participant`` nor ``participant:ID``.
    """
    if spec != PEOPLE and not _ID.fullmatch(spec.removeprefix(f"{PEOPLE}:")):
        raise BadValue("agent", spec, "participant, or participant:ID with 4 to 32 small letters and digits")


class Participant:
    """One trial of a person. The trial waits at each decision until :meth:`say` is called.

    Args:
        facts: The device and page that the person played on, for the record; nothing personal.
    """

    def __init__(self, facts: Mapping[str, Fact] | None = None) -> None:
        import asyncio  # listing the agents needs none, and it takes long

        self._facts = dict(facts or {})
        self._asked: asyncio.Queue[Situation] = asyncio.Queue()
        self._said: asyncio.Queue[Decision] = asyncio.Queue()

    @property
    def facts(self) -> Mapping[str, Fact]:
        """What the person played on."""
        return self._facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Wait for the person's decision."""
        self._asked.put_nowait(situation)
        return await self._said.get()

    async def asked(self) -> Situation:
        """The situation of the next decision, as soon as the trial waits for it."""
        return await self._asked.get()

    def say(self, joint: str, claimed: Outcome | None = None) -> None:
        """Decide: the label of the joint to attempt, and what the previous action did; None if nobody asked."""
        self._said.put_nowait(Decision(joint=joint, claimed=claimed))
