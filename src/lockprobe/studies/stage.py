"""Sets one trial up, plays it and reads the clock. The same for every runner, process and agent."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.channels.noise import FlipKind
from lockprobe.errors import BadValue
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX
from lockprobe.lockbox.families import box as named_box
from lockprobe.plan import Names, Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Fact, Snapshot, Step, Trial
from lockprobe.seams import Agent, Closable, Plant
from lockprobe.studies.album import Album
from lockprobe.studies.journal import Timing
from lockprobe.studies.modality import channels_for, taken_in
from lockprobe.studies.study import LayoutKind, Study
from lockprobe.trial import play

__all__ = ["play_timed", "run_trial"]


class _Fresh:
    """The plant of a plan, built when it is first looked at: what breaks in building it breaks that trial."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._plant: Plant | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        return {} if self._plant is None else self._plant.facts

    def observe(self) -> Snapshot:
        plan = self._plan
        self._plant = resolve_plant(plan.plant).make(plan.box, Names(plan).labels, plan.stream("plant"))
        return self._plant.observe()

    def attempt(self, joint: int) -> Snapshot:
        assert self._plant is not None
        return self._plant.attempt(joint)

    def close(self) -> None:
        if self._plant is not None:
            self._plant.close()


async def play_timed(
    plan: Plan, agent: Agent, on_step: Callable[[str, Step], None], pictures: Path | None = None
) -> tuple[Trial, Timing]:
    """Play one plan and read the clock.

    Args:
        plan: What is to be played.
        agent: Who decides.
        on_step: Called with the plan's key and every step.
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.
    """
    began = time.perf_counter()
    plant = _Fresh(plan)
    try:
        trial = await play(
            plan,
            plant=plant,
            channels=channels_for(plan),
            agent=agent,
            on_step=lambda step: on_step(plan.key, step),
            keep=None if pictures is None else Album(pictures).keep,
        )
    finally:
        plant.close()
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
    plant: str = "symbolic",
    modality: str = "symbolic",
    pictures: Path | str | None = None,
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
        plant: What is acted on, as its spec.
        modality: How the box is shown, as its spec.
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or something is missing that is needed.
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
        plant=plant,
        layout=layout,
        modalities=(modality,),
    )
    if isinstance(agent, str) and not taken_in(agent, (modality,)):
        raise BadValue("modality", modality, f"symbolic for {agent}, which reads reports and looks at no pictures")
    plan = study.plan(spec, p, repetition, trial, modality)
    resolve_plant(plant).check(plan.box)
    once = _alone(plan, agent, None if pictures is None else Path(pictures))
    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook runs a loop of its own in this thread
        return elsewhere.submit(asyncio.run, once).result()


async def _alone(plan: Plan, agent: str | Agent, pictures: Path | None) -> Trial:
    player: Agent = resolve(agent).make() if isinstance(agent, str) else agent
    try:
        return (await play_timed(plan, player, lambda key, step: None, pictures))[0]
    finally:
        if isinstance(agent, str) and isinstance(player, Closable):
            await player.aclose()
