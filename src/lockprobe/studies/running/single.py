"""Plays one trial without a study directory."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.plugins import guarded
from lockprobe.interventions.flip import FlipKind
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.records.store import keep_picture
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.condition import Condition
from lockprobe.trial.protocols import Agent, Closable, Intervention
from lockprobe.trial.record import Ask, Trial


def run_trial(
    *,
    agent: str | Agent | None = None,
    box: str | Path | Lockbox | None = None,
    p: float | None = None,
    flip: FlipKind | None = None,
    condition: str | Condition | Sequence[Intervention] | None = None,
    modality: str | None = None,
    plant: str | None = None,
    layout: LayoutKind | None = None,
    shuffle: Shuffle | None = None,
    max_steps: int | None = None,
    assessment: bool | None = None,
    hypothesis: Ask | None = None,
    seed: int | None = None,
    repetition: int | None = None,
    trial: int | None = None,
    pictures: Path | str | None = None,
) -> Trial:
    """Play one trial here and now; a study with the same settings plays the same one.

    >>> run_trial(agent="human-inspired", p=0.4, seed=3).key
    'trial/human-inspired/flip?p=0.4/rep=1/trial=1'

    The options are those of a study, each with one value
    (:class:`lockprobe.studies.options.study_options.StudyOptions`); what is left out is as in a study of flips.

    Args:
        agent: Agent spec, or an object with the :class:`lockprobe.trial.protocols.Agent` protocol (human-inspired).
        box: Name of a box, path of its file, or the box (chain-4).
        p: Flip rate, [0, 1] (0).
        flip: What a false report is.
        condition: What acts in the trial: specs with plus signs between (``tremble?p=0.1 + nudge``), interventions, or
            a condition; ``lockprobe list interventions`` lists them. A flip rate is put in front of it.
        modality: How the box is shown, as its spec, where the condition does not say it.
        plant: What is acted on, as its spec (symbolic).
        layout: Where joints lie on the panel (fixed).
        shuffle: How often labels and their order are drawn (trial).
        max_steps: Budget in steps (20).
        assessment: Whether the agent is asked what its last action did (True).
        hypothesis: When a hosted model says how the box works (before).
        seed: Seed of everything (1).
        repetition: Repetition of the study, from 1 (1).
        trial: Trial of the repetition, from 1 (1).
        pictures: Directory in which the pictures that the record names are kept; without it they are lost.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or something is missing.
    """
    given = {name: value for name, value in locals().items() if name not in ("agent", "pictures")}
    player = "human-inspired" if agent is None else agent() if isinstance(agent, type) else agent
    if not isinstance(player, str | Agent):
        raise BadValue("agent", player, "an agent spec, or an object with facts and decide()")
    spec = player if isinstance(player, str) else type(player).__name__
    study = trial_study(spec, **given)
    plan = study.plan(spec, study.conditions[0], study.repetitions, study.trials)
    if isinstance(player, str):
        study.check_agents()
    resolve_plant(plan.plant).check(plan.box)
    keep = None if pictures is None else partial(keep_picture, Path(pictures))

    async def once() -> Trial:
        playing = resolve(player).make() if isinstance(player, str) else player
        try:
            return (await play_timed(plan, playing, keep=keep))[0]
        finally:
            if isinstance(player, str) and isinstance(playing, Closable):
                with guarded("agent", player):
                    await playing.aclose()

    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook already runs a loop in this thread
        return elsewhere.submit(lambda: asyncio.run(once())).result()
