"""Plays trials on the processors of a cluster.

An actor plays trials and returns each with its timing and its pictures. Only this process writes to the journal. Hosted
models are asked from this process, so that every call is in the study's log and budget. Agents, plants and
interventions of other packages also stay in this process: they may cost money, or move a robot.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.foundation.cluster import Cluster, Lost
from lockprobe.foundation.errors import ModelFault, PlantFault
from lockprobe.foundation.plugins import find_plugin
from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import interventions_in
from lockprobe.studies.records.picture_store import Album
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.loop import broken
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Step, Trial

_SIMULATED = ("symbolic", "fast-twin", "twin")
"""Plants that are computed alone; others have a person or a device."""


def can_travel(study: Study, source: AgentSource) -> bool:
    """Whether an agent's trials can run on other machines: agent, plant and interventions must ship with Lockprobe.

    Args:
        study: The study.
        source: The agent.
    """
    changes = [type(change) for one in study.conditions for change in interventions_in(one)]
    return (
        source.engine in ("inline", "process")
        and find_plugin("agent", source.spec) is None
        and Spec.parse(study.plant, "plant").full_name in _SIMULATED
        and all(change.__module__.startswith("lockprobe.interventions.") for change in changes)
    )


def play_on_cluster(
    plans: Sequence[Plan],
    cluster: Cluster,
    on_step: Callable[[str, Step], None],
    finish: Callable[[Trial, Timing], None],
    *,
    pictures: Path,
) -> None:
    """Play plans of one agent on a cluster, in any order.

    When a trial arrives, ``on_step`` is called for all its steps, then ``finish``. The pictures that its record names
    are then in the directory ``pictures``. A trial whose workers were lost three times ends as an ``error``.

    Raises:
        UserMistake: If the agent is not available on a node, or workers keep being lost.
    """
    album = Album(pictures)
    fault = PlantFault if resolve(plans[0].agent).engine == "inline" else ModelFault
    for plan, played in cluster.each(_PlayerFactory(plans[0].agent), plans):
        if isinstance(played, Lost):
            trial = broken(plan, fault(f"the workers of {plan.agent} on the cluster were lost ({played.why})"))
            finish(trial, Timing(key=trial.key, seconds=0.0, steps=0))
            continue
        for picture in played.pictures:
            album.keep(picture)
        for step in played.trial.steps:
            on_step(played.trial.key, step)
        finish(played.trial, played.timing)


@dataclass(frozen=True, slots=True, kw_only=True)
class _TrialResult:
    """A played trial with its timing and pictures, as an actor returns it."""

    trial: Trial
    timing: Timing
    pictures: tuple[Picture, ...]


@dataclass(frozen=True, slots=True)
class _PlayerFactory:
    """A picklable factory: builds an agent on a node and returns the function that plays plans with it."""

    spec: str

    def __call__(self) -> Callable[[Plan], _TrialResult]:
        agent = resolve(self.spec).make()

        def play(plan: Plan) -> _TrialResult:
            taken: dict[str, Picture] = {}

            def keep(picture: Picture) -> None:
                taken[picture.name] = picture

            trial, timing = asyncio.run(play_timed(plan, agent, keep=keep))
            return _TrialResult(trial=trial, timing=timing, pictures=tuple(taken.values()))

        return play
