"""The contract test of an agent. Hosted models cannot pass it, because their answers vary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.plugins import allow
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.running.single import run_trial
from lockprobe.testing.records import check_facts, check_record
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Decision, Fact, Situation, Trial

if TYPE_CHECKING:
    import numpy as np

_SEEDS = (1, 2, 3)


def check_agent(
    agent: str | Agent,
    *,
    boxes: Sequence[str | Path | Lockbox] = ("chain-4", "gray-code"),
    plant: str = "symbolic",
    modality: str = "symbolic",
) -> None:
    """Check that an agent fulfils its contract.

    It chooses listed joints. It plays the same trial identically again, drawing only from the given stream. It keeps
    nothing between calls: two interleaved trials equal two separate ones. Its facts and decisions survive the record.

    Args:
        agent: Its spec, or an agent.
        boxes: The boxes it plays, with true and with false reports.
        plant: The plant, as its spec.
        modality: How the box is shown, as its spec; with pictures no report is false.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    if isinstance(agent, str):
        allow(agent)
    player = resolve(agent).make() if isinstance(agent, str) else agent
    name = agent if isinstance(agent, str) else type(agent).__name__
    assert isinstance(player, Agent), f"{name} has no `facts` or no `decide`"
    check_facts(player.facts, name)
    rates = (0.0,) if is_pictured(modality) else (0.0, 0.4)
    before: tuple[_RecordedCall, ...] = ()
    for box in boxes:
        for seed in _SEEDS:
            for p in rates:
                noted = _RecordingAgent(agent=player)
                alone, again, beside = (
                    run_trial(agent=one, box=box, seed=seed, p=p, plant=plant, modality=modality)
                    for one in (noted, player, _RecordingAgent(agent=player, others=before))
                )
                check_record(alone, name)
                assert _played(alone) == _played(again), (
                    f"{name} plays the same trial differently again: it keeps something, or draws elsewhere"
                )
                assert _played(alone) == _played(beside), (
                    f"{name} keeps something between calls: trials side by side are not as one by one"
                )
                before = tuple(noted.calls)


def _played(trial: Trial) -> tuple[object, ...]:
    """The steps and the ending of a trial, without the agent."""
    return trial.steps, trial.ending


@dataclass(frozen=True)
class _RecordedCall:
    """A recorded call of an agent: the situation, the random stream before the call, and the decision."""

    situation: Situation
    rng: np.random.Generator
    decision: Decision


@dataclass
class _RecordingAgent:
    """An agent that records its calls. Before each call it repeats a call of another trial."""

    agent: Agent
    others: Sequence[_RecordedCall] = ()
    calls: list[_RecordedCall] = field(default_factory=list)

    @property
    def facts(self) -> Mapping[str, Fact]:
        return self.agent.facts

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        if len(self.calls) < len(self.others):
            other = self.others[len(self.calls)]
            if await self.agent.decide(other.situation, deepcopy(other.rng)) != other.decision:
                raise AssertionError("it answers otherwise beside another trial")
        stream = deepcopy(rng)
        decision = await self.agent.decide(situation, rng)
        self.calls.append(_RecordedCall(situation, stream, decision))
        return decision
