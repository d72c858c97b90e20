"""Sets one trial up, plays it and reads the clock. The same for every runner, process and agent."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from lockprobe.agents.catalogue import resolve
from lockprobe.channels.noise import FlipKind, OutcomeFlip
from lockprobe.channels.text import TextChannel
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX
from lockprobe.lockbox.families import box as named_box
from lockprobe.plan import Plan
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.record import Step, Trial
from lockprobe.seams import Agent, Channel, Closable
from lockprobe.studies.journal import Timing
from lockprobe.studies.study import LayoutKind, Study
from lockprobe.trial import play

__all__ = ["channels_for", "play_timed", "run_trial"]


def channels_for(plan: Plan) -> tuple[Channel, ...]:
    """What stands between the box and the agent in one trial."""
    return OutcomeFlip(p=plan.p, persistence=plan.flip), TextChannel()


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
    layout: LayoutKind = "fixed",
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
        layout: Whether the joints are dealt anew to the places of the panel.

    Raises:
        UserMistake: If a name does not exist or a value is out of range.
    """
    spec = agent if isinstance(agent, str) else type(agent).__name__
    study = Study(
        name="trial",
        agents=(spec,),
        box=named_box(box) if isinstance(box, str) else box,
        p=(p,),
        flip=flip,
        repetitions=repetition,
        trials=trial,
        max_steps=max_steps,
        seed=seed,
        shuffle=shuffle,
        layout=layout,
    )
    player: Agent = resolve(agent).make() if isinstance(agent, str) else agent

    async def once() -> Trial:
        try:
            return (await play_timed(study.plan(spec, p, repetition, trial), player, lambda key, step: None))[0]
        finally:
            if isinstance(agent, str) and isinstance(player, Closable):
                await player.aclose()

    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook runs a loop of its own in this thread
        return elsewhere.submit(asyncio.run, once()).result()
