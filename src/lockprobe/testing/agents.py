"""The contract of an agent. A hosted model cannot keep it, as it does not give the same answer twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lockprobe.agents.catalogue import resolve
from lockprobe.lockbox.box import Lockbox
from lockprobe.protocols import Agent
from lockprobe.record import Decision, Fact, Situation, Trial
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.single import run_trial
from lockprobe.testing.records import check_facts, check_record

if TYPE_CHECKING:
    import numpy as np

__all__ = ["check_agent"]

_SEEDS = (1, 2, 3)


def check_agent(
    agent: str | Agent,
    *,
    boxes: Sequence[str | Path | Lockbox] = ("chain-4", "gray-code"),
    plant: str = "symbolic",
    modality: str = "symbolic",
) -> None:
    """Hold an agent against its contract.

    It chooses joints that are listed. The same trial is played alike again: all that it draws it draws from the stream
    that it is given. It keeps nothing between calls: two trials side by side are played as one after the other. Its
    facts and its decisions survive the record.

    Args:
        agent: Its spec, or an agent.
        boxes: What it plays, told the truth and with false reports.
        plant: What is acted on, as its spec.
        modality: How the box is shown, as its spec; with pictures no report is false.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    player = resolve(agent).make() if isinstance(agent, str) else agent
    name = agent if isinstance(agent, str) else type(agent).__name__
    assert isinstance(player, Agent), f"{name} has no `facts` or no `decide`"
    check_facts(player.facts, name)
    rates = (0.0,) if is_pictured(modality) else (0.0, 0.4)
    before: tuple[_Call, ...] = ()
    for box in boxes:
        for seed in _SEEDS:
            for p in rates:
                listening = _Listening(agent=player)
                alone, again, beside = (
                    run_trial(agent=one, box=box, seed=seed, p=p, plant=plant, modality=modality)
                    for one in (listening, player, _Beside(agent=player, calls=before))
                )
                check_record(alone, name)
                assert _played(alone) == _played(again), (
                    f"{name} plays the same trial differently again: it keeps something, or draws elsewhere"
                )
                assert _played(alone) == _played(beside), (
                    f"{name} keeps something between calls: trials side by side are not as one by one"
                )
                before = tuple(listening.calls)


def _played(trial: Trial) -> tuple[object, ...]:
    """What came of a trial, whoever's name stands on it."""
    return trial.steps, trial.ending


@dataclass(frozen=True)
class _Call:
    """What an agent was asked once, with its stream as it was, and what it answered."""

    situation: Situation
    rng: np.random.Generator
    decision: Decision


@dataclass
class _Listening:
    """An agent, with a note of all that it is asked."""

    agent: Agent
    calls: list[_Call] = field(default_factory=list)

    @property
    def facts(self) -> Mapping[str, Fact]:
        return self.agent.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        stream = deepcopy(rng)
        decision = await self.agent.decide(situation, rng)
        self.calls.append(_Call(situation, stream, decision))
        return decision


@dataclass
class _Beside:
    """An agent that is asked of another trial before every step of its own."""

    agent: Agent
    calls: Sequence[_Call]
    asked: int = 0

    @property
    def facts(self) -> Mapping[str, Fact]:
        return self.agent.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        if self.asked < len(self.calls):
            other = self.calls[self.asked]
            answered = await self.agent.decide(other.situation, deepcopy(other.rng))
            if answered != other.decision:
                raise AssertionError("it answers otherwise beside another trial")
            self.asked += 1
        return await self.agent.decide(situation, rng)
