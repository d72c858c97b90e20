"""The protocols of plants, agents and interventions: the seams of the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Protocol, Self, runtime_checkable

from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Briefing, Decision, Fact, Moment, Percept, Situation, Snapshot, Task, Turn

if TYPE_CHECKING:
    import numpy as np


@runtime_checkable
class Plant(Protocol):
    """The box or robot that agents act on: a simulation, a twin, a real arm. Calls may block.

    With ``attended = True`` a class says that somebody answers its questions at the terminal: its trials then run one
    at a time, in the process that was started.
    """

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
    calls. ``rng`` begins anew at every step (:mod:`lockprobe.trial.luck`), so that conditions share their luck, and is
    its own until it returns. It changes outcome and positions, from which words are made; more is declared in
    :class:`InterventionTraits`.
    """

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        """Turn a percept into the percept that is passed on; the first channel gets the truth in the agent's terms.

        ``past`` holds the moments before, oldest first, as they were and as they were told; it is empty at first.
        """
        ...


@runtime_checkable
class Prompt(Protocol):
    """An intervention on what is *asked*: the instruction, and remarks with the report. Otherwise like a channel."""

    def brief(self, briefing: Briefing, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Briefing:
        """Turn a briefing into the briefing that is passed on, before every decision.

        ``past`` holds all moments, oldest first; the last is what the agent has just been told. ``rng`` is the stream
        at the step of that report.
        """
        ...


@runtime_checkable
class Memory(Protocol):
    """An intervention on what is *remembered*: the past that the agent still has. Otherwise like a channel."""

    def recall(
        self, turns: tuple[Turn, ...], past: tuple[Moment, ...], task: Task, rng: np.random.Generator
    ) -> tuple[Turn, ...]:
        """The exchanges that the agent still has, of those left so far, oldest first; before every decision."""
        ...


@runtime_checkable
class Actuator(Protocol):
    """An intervention on what is *done*: the attempted joint, given the agent's choice. Otherwise like a channel."""

    def act(self, joint: str, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> str:
        """The label of the joint to attempt in place of ``joint``; ``past`` holds all moments up to now."""
        ...


Intervention = Channel | Prompt | Memory | Actuator
"""Whatever acts at one of the four places of the loop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InterventionTraits:
    """What a class of interventions may declare by attributes, without inheriting from anything; each has a default.

    Attributes:
        name: Its name in specs, if it is one of Lockprobe's own; an entry point names those of packages.
        variant: An option that chooses it among several classes of its name: ``flip?like=…``.
        doses: The names of its fields that are doses. At 0 of the first one it does nothing.
        implied: The names of its fields that its spec leaves out, because others say them.
        stream: The name of its random stream, by default that of its class. Classes of one ``stream`` share their luck.
        always_tells: Whether no report is missing because of it. Others may leave reports out.
        shown: Of what puts reports into words or pictures, which may leave facts out: what the agent gets of a percept.
            A change of anything else counts as none, and later channels know the facts as ``Moment.reported``.
    """

    name: str = ""
    variant: str = ""
    doses: tuple[str, ...] = ()
    implied: tuple[str, ...] = ()
    stream: str = ""
    always_tells: bool = False
    shown: Callable[[Percept], object] | None = None

    @classmethod
    def of(cls, one: object) -> Self:
        """What an intervention or its class declares."""
        return cls(**{part.name: getattr(one, part.name, part.default) for part in fields(cls)})  # type: ignore[arg-type]


@runtime_checkable
class Agent(Protocol):
    """An agent: it decides. It keeps nothing between calls and uses only the situation and its random stream.

    A class may declare, by attributes:

    * ``unseeded = True``: it draws its own luck and not from its stream, as a provider does. Forks of its trials
      (``lockprobe branch``) then take its decisions from the record as far as they can, and ask it nothing.
    * ``step_seconds``: the most seconds that it may take for a decision, 60 if it says nothing; Lockprobe's own agents
      have limits of their own.
    """

    @property
    def facts(self) -> Mapping[str, Fact]:
        """The facts of the agent for the record: model, file hash, runtime, settings. Never a secret."""
        ...

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Choose the next joint, or raise a ``TrialFault``, which ends the trial as ``error``."""
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

    async def reserve(self, call: Call) -> None:
        """Announce a call, with the maximum cost of one attempt; wait for calls on their way if needed.

        If the call is repeated, ``retries``, ``unanswered`` and ``usage`` are the account of its earlier attempts.
        Raises ``BudgetReached`` if the budget does not cover it.
        """
        ...

    async def write(self, call: Call) -> None:
        """Write a call to disk, with or without a reply, in place of its reservation."""
        ...


@runtime_checkable
class Calling(Protocol):
    """An agent whose decisions are calls that a provider charges for."""

    def with_calls(self, key: str, book: CallBook) -> Agent:
        """The agent for one trial: it looks up every call before it makes it, and records every call."""
        ...
