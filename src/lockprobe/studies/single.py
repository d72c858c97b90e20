"""One trial, here and now."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.errors import BadValue
from lockprobe.interventions.catalogue import condition as read_condition
from lockprobe.interventions.catalogue import spec_of
from lockprobe.interventions.flip import FlipKind
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX, find_box
from lockprobe.plan import Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import Trial
from lockprobe.seams import Agent, Closable, Intervention
from lockprobe.studies.modality import interventions_for, taken_in
from lockprobe.studies.stage import play_timed
from lockprobe.studies.study import LayoutKind, Study

__all__ = ["run_trial"]


def run_trial(
    *,
    agent: str | Agent = "human-inspired",
    box: str | Path | Lockbox = DEFAULT_BOX,
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
    assessment: bool = True,
    condition: str | Sequence[Intervention] = "",
    pictures: Path | str | None = None,
) -> Trial:
    """Play one trial here and now; a study with the same settings plays the same one.

    Args:
        agent: Agent spec, or an object with the :class:`lockprobe.seams.Agent` protocol.
        box: Name of a box, path of a TOML file, or a box.
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
        assessment: Whether the agent is asked what its last action did.
        condition: What else acts in the trial: specs with plus signs between (``tremble?p=0.1 + nudge``), or
            interventions; ``lockprobe interventions`` lists them.
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or something is missing that is needed.
    """
    spec = agent if isinstance(agent, str) else type(agent).__name__
    study = Study(
        name="trial", agents=(spec,), box=find_box(box), p=(p,), flip=flip, repetitions=repetition, trials=trial,
        max_steps=max_steps, seed=seed, shuffle=shuffle, plant=plant, layout=layout, modalities=(modality,),
        assessment=assessment,
    )  # fmt: skip
    plan = study.plan(spec, p, repetition, trial, modality)
    plan = _under(plan, condition)
    _check(plan, agent)
    once = _alone(plan, agent, None if pictures is None else Path(pictures))
    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook runs a loop of its own in this thread
        return elsewhere.submit(asyncio.run, once).result()


def _under(plan: Plan, condition: str | Sequence[Intervention]) -> Plan:
    """The plan under a condition, which its key names."""
    acting = read_condition(condition) if isinstance(condition, str) else tuple(condition)
    if not acting:
        return plan
    named, flips = " + ".join(map(spec_of, acting)), f"/p={plan.p:g}/"
    return replace(plan, condition=acting, key=plan.key.replace(flips, f"{flips}{named}/"))


def _check(plan: Plan, agent: str | Agent) -> None:
    if isinstance(agent, str) and not taken_in(agent, (plan.modality,)):
        raise BadValue("modality", plan.modality, f"symbolic for {agent}, which reads reports and looks at no pictures")
    interventions_for(plan)
    resolve_plant(plan.plant).check(plan.box)


async def _alone(plan: Plan, agent: str | Agent, pictures: Path | None) -> Trial:
    player: Agent = resolve(agent).make() if isinstance(agent, str) else agent
    try:
        return (await play_timed(plan, player, lambda key, step: None, pictures))[0]
    finally:
        if isinstance(agent, str) and isinstance(player, Closable):
            await player.aclose()
