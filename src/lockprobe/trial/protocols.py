"""The protocols of plants, agents and interventions: the seams of the loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from lockprobe.trial.briefing import Briefing
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.record import Decision, Fact, Moment, Percept, Situation, Snapshot, Task, Turn

if TYPE_CHECKING:
    import numpy as np

__all__ = [
    "Actuator",
    "Agent",
    "CallBook",
    "Calling",
    "Channel",
    "Closable",
    "Intervention",
    "Memory",
    "Plant",
    "Prompt",
]


@runtime_checkable
class Plant(Protocol):
    """The box or robot that agents act on: a simulation, a twin, a real arm. Calls may block."""

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of the plant for the record: settings, engine, renderer. Empty if its name says everything."""
        ...

    def observe(self) -> Snapshot:
        """The truth before the first attempt."""
        ...

    def attempt(self, joint: int) -> Snapshot:
        """Attempt a joint, by place in panel order, and report what *really* happened."""
        ...

    def close(self) -> None:
        """Release engines and devices. Nothing is called afterwards."""
        ...


@runtime_checkable
class Channel(Protocol):
    """An intervention on what is *told*: it changes the report or picture of what happened, never the box.

    It is a frozen dataclass, as all interventions are: what acts is what the record names. It keeps nothing between
    calls, and draws from ``rng`` equally often whatever its parameters are, so that conditions share their luck. It
    changes outcome and positions, from which words are made; one with ``after_words = True`` gets the words.

    A class attribute ``shows = True`` says that it puts the report into words or pictures, which may leave facts out:
    later channels know them as ``Moment.reported``. Its method ``shown(percept)``, if it has one, gives what the agent
    gets of a percept: a change of anything else counts as none (:mod:`lockprobe.trial.changes`). Settings that a class
    attribute ``later`` names are left out of the record where they have their defaults.
    """

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """Turn a percept into the percept that is passed on.

        Args:
            percept: The observation so far; the first channel gets the truth in the agent's terms.
            past: The moments before, oldest first, as they were and as they were told; empty at the first look.
            task: What the agent knows.
            rng: This channel's own stream.
        """
        ...


@runtime_checkable
class Prompt(Protocol):
    """An intervention on what is *asked*: the instruction, and remarks with the report. Otherwise like a channel."""

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """Turn a briefing into the briefing that is passed on, before every decision.

        ``past`` holds all moments, oldest first; the last is what the agent has just been told.
        """
        ...


@runtime_checkable
class Memory(Protocol):
    """An intervention on what is *remembered*: the past that the agent still has. Otherwise like a channel."""

    def recall(self, past: tuple[Turn, ...], task: Task, rng: np.random.Generator) -> tuple[Turn, ...]:
        """The exchanges that the agent still has, of those left so far, oldest first; before every decision."""
        ...


@runtime_checkable
class Actuator(Protocol):
    """An intervention on what is *done*: the attempted joint, given the agent's choice. Otherwise like a channel."""

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The label of the joint to attempt in place of ``joint``.

        ``past`` holds all moments up to now, oldest first.
        """
        ...


Intervention = Channel | Prompt | Memory | Actuator
"""Whatever acts at one of the four places of the loop."""


@runtime_checkable
class Agent(Protocol):
    """An agent: it decides. It keeps nothing between calls and uses only the situation and its random stream.

    An attribute ``unseeded = True`` says that it draws its own luck and not from its stream, as a provider does. Forks
    of its trials (``lockprobe branch``) then take its decisions from the record as far as they can, and ask it nothing.
    """

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of the agent for the record: model, file hash, runtime, settings. Never a secret."""
        ...

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Choose the next joint.

        Raises:
            TrialFault: If there is no decision; the trial ends as ``error``.
        """
        ...


@runtime_checkable
class Closable(Protocol):
    """An agent that holds connections."""

    async def aclose(self) -> None:
        """Close the connections after the last trial."""
        ...


class CallBook(Protocol):
    """The calls of one trial: replies from before an interruption, and new ones."""

    def recall(self, step: int, turn: int, request: str) -> Call | None:
        """The earlier call at this step and turn with this request and a reply; None if there is none."""
        ...

    async def turn(self, worst: Usage) -> None:
        """Wait until the trial may make its next call, before a connection is taken for it.

        Args:
            worst: The maximum cost of one attempt.
        """
        ...

    async def reserve(self, call: Call) -> None:
        """Announce a call, with the maximum cost of one attempt; wait for calls on their way if needed.

        If the call is repeated, ``unanswered`` is the number of earlier attempts that may have been charged for.

        Raises:
            BudgetReached: If the budget does not cover it.
        """
        ...

    def write(self, call: Call) -> None:
        """Write a call to disk, with or without a reply, in place of its reservation."""
        ...


@runtime_checkable
class Calling(Protocol):
    """An agent whose decisions are calls that a provider charges for."""

    def with_calls(self, key: str, book: CallBook) -> Agent:
        """The agent for one trial: it looks up every call before it makes it, and records every call."""
        ...
