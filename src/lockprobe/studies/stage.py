"""Sets one trial up, plays it and reads the clock. The same for every runner, process and agent."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import get_args

from lockprobe.agents.catalogue import resolve
from lockprobe.channels.noise import FlipKind, OutcomeFlip
from lockprobe.channels.text import TextChannel
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX
from lockprobe.lockbox.families import box as named_box
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.record import Step, Trial
from lockprobe.seams import Agent, Channel
from lockprobe.trial import Plan, play

__all__ = ["Timing", "channels_for", "play_timed", "run_trial"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """How long one trial took. Kept apart from the record, which is the same whenever it is made.

    Attributes:
        key: The trial.
        seconds: Wall time from its first look at the box to its end.
        steps: Steps played in that time.
    """

    key: str
    seconds: float
    steps: int


def channels_for(plan: Plan) -> tuple[Channel, ...]:
    """What stands between the box and the agent in one trial."""
    kinds: Mapping[str, FlipKind] = {kind: kind for kind in get_args(FlipKind)}
    return OutcomeFlip(p=plan.p, persistence=kinds[plan.flip]), TextChannel()


async def play_timed(plan: Plan, agent: Agent, on_step: Callable[[str, Step], None]) -> tuple[Trial, Timing]:
    """Play one plan and read the clock."""
    began = time.perf_counter()
    trial = await play(
        plan,
        plant=SymbolicPlant(plan.box),
        channels=channels_for(plan),
        agent=agent,
        on_step=lambda step: on_step(plan.key, step),
    )
    return trial, Timing(key=trial.key, seconds=time.perf_counter() - began, steps=len(trial.steps))


def run_trial(
    *,
    agent: str | Agent = "human-inspired",
    box: str | Lockbox = DEFAULT_BOX,
    p: float = 0.0,
    flip: FlipKind = "transient",
    seed: int = 1,
    repetition: int = 1,
    trial: int = 1,
    max_steps: int = 20,
    shuffle: bool = True,
) -> Trial:
    """Play one trial here and now; a study with the same seed plays the same one.

    Args:
        agent: Agent spec, or an object with the :class:`lockprobe.seams.Agent` protocol.
        box: Name of a box, or a box.
        p: Flip probability, [0, 1].
        flip: Kind of outcome flip.
        seed: Seed of the study.
        repetition: Repetition of the study, from 1.
        trial: Trial of the repetition, from 1.
        max_steps: Budget in steps.
        shuffle: Whether labels and their listing are shuffled.

    Raises:
        UserMistake: If a name does not exist or a value is out of range.
    """
    spec = agent if isinstance(agent, str) else type(agent).__name__
    plan = Plan(
        key=f"trial/{spec}/p={p:g}/rep={repetition}/trial={trial}",
        study="trial",
        agent=spec,
        box=named_box(box) if isinstance(box, str) else box,
        modality="symbolic",
        p=p,
        flip=flip,
        repetition=repetition,
        trial=trial,
        seed=seed,
        budget=max_steps,
        shuffle=shuffle,
    )
    player = resolve(agent).make() if isinstance(agent, str) else agent
    return asyncio.run(play_timed(plan, player, lambda key, step: None))[0]
