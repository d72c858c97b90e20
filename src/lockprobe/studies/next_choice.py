"""The exact probabilities of the next choice at a fork, for agents that are policies.

They are written next to the forks, because a report plays no agent.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Container, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import FiniteFloat, TypeAdapter, ValidationError

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.policy import Policy
from lockprobe.foundation.errors import BadFile, ModelFault
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.plants.catalogue import plant_of
from lockprobe.studies.branch import FORKS, Branching
from lockprobe.studies.modality import interventions_for
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Names, Plan
from lockprobe.trial.record import Decision, Fact, Situation

if TYPE_CHECKING:
    import numpy as np

_FILE = "next_choices.json"
_CHOICES = TypeAdapter(dict[str, tuple[FiniteFloat, ...]])


def read_choices(directory: Path | str) -> dict[str, tuple[float, ...]]:
    """Read the file of next choices: key of a fork -> probability of each joint, as listed; empty without a file.

    Raises:
        BadFile: If the file is damaged.
    """
    path = Path(directory) / FORKS / _FILE
    if not path.exists():
        return {}
    try:
        return _CHOICES.validate_json(read_input(path))
    except ValidationError:
        raise BadFile(path, "not the probabilities of next choices; delete it and run the same branch again") from None


def write_choices(directory: Path, asked: Branching, keys: Container[str]) -> dict[str, tuple[float, ...]]:
    """Add the next choices after these forks to the file in a study's directory, and return the file's contents."""
    found = read_choices(directory) | next_choices(asked, keys)
    write_file(directory / FORKS / _FILE, json.dumps(found))
    return found


def next_choices(asked: Branching, keys: Container[str]) -> dict[str, tuple[float, ...]]:
    """The probability of each joint, as listed, after the first continuation of these forks, for policies alone.

    Other agents are left out: local models have recorded probabilities, and hosted models have unknown ones.
    """
    found: dict[str, tuple[float, ...]] = {}
    for spec in () if asked.study.simulated else asked.agents:
        source = resolve(spec)
        agent = source.make() if source.engine == "inline" else None
        if isinstance(agent, Policy):
            found |= asyncio.run(_of_agent(asked, spec, agent, keys))
    return found


async def _of_agent(
    asked: Branching, spec: str, policy: Policy[Any], keys: Container[str]
) -> dict[str, tuple[float, ...]]:
    found = {}
    for plan in asked.plans(spec):
        if plan.fork is not None and plan.fork.name.time > 1:
            break
        if plan.fork is not None and plan.key in keys:
            found[plan.key] = await next_choice(plan, policy, plan.fork.name.at)
    return found


async def next_choice(plan: Plan, policy: Policy[Any], at: int) -> tuple[float, ...]:
    """The choice probabilities at a fork, found by replaying it up to the choice after the changed report."""
    asked = _ChoiceProbe(policy, at)
    plant = plant_of(plan, Names(plan).labels)
    await play(plan, plant=plant, interventions=interventions_for(plan.condition), agent=asked)
    return asked.chances


class _ChoiceProbe:
    """A policy that plays up to a step, then stores its choice probabilities and stops."""

    def __init__(self, policy: Policy[Any], at: int) -> None:
        self._policy, self._left = policy, at
        self.chances: tuple[float, ...] = ()

    @property
    def facts(self) -> Mapping[str, Fact]:
        return {}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        if self._left:
            self._left -= 1
            return await self._policy.decide(situation, rng)
        known = self._policy.recall(situation)
        self.chances = tuple(self._policy.probabilities(known.view, known.memory))
        raise ModelFault("its chances are known: the trial ends here")
