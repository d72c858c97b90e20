"""One trial, here and now."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.errors import BadValue
from lockprobe.interventions.condition import Condition, default_modality, flips, read_condition
from lockprobe.interventions.flip import FlipKind, OutcomeFlip
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import DEFAULT_BOX, find_box
from lockprobe.options import spec_name
from lockprobe.plan import Plan
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.record import STATES, Trial
from lockprobe.seams import Agent, Closable, Intervention
from lockprobe.studies.modality import taken_in
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
    modality: str | None = None,
    assessment: bool = True,
    condition: str | Condition | Sequence[Intervention] = "",
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
        modality: How the box is shown, as its spec; ``symbolic?tell=state`` if not given, as in studies.
        assessment: Whether the agent is asked what its last action did.
        condition: What acts in the trial, in place of ``p``, ``flip`` and ``modality``: specs with plus signs between
            (``tremble?p=0.1 + nudge``), interventions, or a condition; ``lockprobe interventions`` lists them. A flip
            rate is put in front of it.
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or something is missing that is needed.
    """
    spec = agent if isinstance(agent, str) else type(agent).__name__
    study = Study(
        name="trial", agents=(spec,), box=find_box(box), conditions=(_condition(condition, p, flip, modality),),
        repetitions=repetition, trials=trial, max_steps=max_steps, seed=seed, shuffle=shuffle, plant=plant,
        layout=layout, assessment=assessment,
    )  # fmt: skip
    plan = study.plan(spec, study.conditions[0], repetition, trial)
    _check(plan, agent)
    once = _alone(plan, agent, None if pictures is None else Path(pictures))
    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook runs a loop of its own in this thread
        return elsewhere.submit(asyncio.run, once).result()


def _condition(
    asked: str | Condition | Sequence[Intervention], p: float, flip: FlipKind, modality: str | None
) -> Condition:
    """The condition that is asked for; a flip rate and a modality alone make one too."""
    if not asked:
        return flips((p,), flip, (modality,) if modality else None)[0]
    if isinstance(asked, str):
        asked = read_condition(asked)
    found = asked if isinstance(asked, Condition) else Condition(interventions=tuple(asked))
    if p == 0 and modality is None:
        return found
    if p and any(spec_name(spec) == OutcomeFlip.name for spec in found.specs):
        raise BadValue("p", p, "0 with a condition that flips reports itself")
    return replace(
        found,
        interventions=((OutcomeFlip(p=p, persistence=flip),) if p else ()) + found.interventions,
        modality=modality or (default_modality(flip) if p and found.modality == STATES else found.modality),
    )


def _check(plan: Plan, agent: str | Agent) -> None:
    if isinstance(agent, str) and not taken_in(agent, (plan.modality,)):
        raise BadValue("modality", plan.modality, f"symbolic for {agent}, which reads reports and looks at no pictures")
    resolve_plant(plan.plant).check(plan.box)


async def _alone(plan: Plan, agent: str | Agent, pictures: Path | None) -> Trial:
    player: Agent = resolve(agent).make() if isinstance(agent, str) else agent
    try:
        return (await play_timed(plan, player, lambda key, step: None, pictures))[0]
    finally:
        if isinstance(agent, str) and isinstance(player, Closable):
            await player.aclose()
