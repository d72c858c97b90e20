"""Plays trials in other processes, of this machine or of a cluster, with the same records as here.

A worker plays trials and returns each as a row of the store, with its pictures. Only this process writes. Hosted models
are asked from this process, so that every call is in the study's log and budget; what a person or another package wrote
stays on this machine, since it may cost money or move a robot. If a worker dies, its trial ends as an ``error`` at the
boundary ``model`` or ``plant``, whichever needs the processor. One in which an agent hangs ends itself, and says where.
"""

from __future__ import annotations

import asyncio
import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing import parent_process

from lockprobe.agents.catalogue import AgentSource, resolve
from lockprobe.foundation.errors import ModelFault, PlantFault
from lockprobe.foundation.plugins import allow, allowed, find_plugin
from lockprobe.foundation.spec import Spec
from lockprobe.foundation.workers import Lost, Pool, lose, tell
from lockprobe.interventions.conditions import interventions_in
from lockprobe.studies.records.picture_store import Album
from lockprobe.studies.records.trial_rows import Timing, TrialRow, row_of
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.loop import broken
from lockprobe.trial.patience import PATIENCE
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.trial_reader import TrialReader

_SIMULATED = ("symbolic", "fast-twin", "twin")
"""Plants that are computed alone; others have a person or a device."""


def can_travel(study: Study, source: AgentSource) -> bool:
    """Whether an agent's trials can run on other machines: agent, plant and interventions must ship with Lockprobe."""
    changes = [type(change) for one in study.conditions for change in interventions_in(one)]
    return (
        source.engine in ("inline", "process")
        and find_plugin("agent", source.spec) is None
        and Spec.parse(study.plant, "plant").full_name in _SIMULATED
        and all(change.__module__.startswith("lockprobe.interventions.") for change in changes)
    )


def play_elsewhere(
    plans: Sequence[Plan],
    pool: Pool,
    on_step: Callable[[str, Step], None],
    finish: Callable[[Trial, Timing, TrialRow | None], None],
    *,
    identities: Mapping[str, str],
    album: Album,
    live: bool = True,
) -> None:
    """Play plans of one agent, in any order.

    ``on_step`` and ``finish`` are called in this process, for every step of a trial before its end.

    Args:
        plans: At least one.
        pool: Where they are played.
        on_step: Called with the key of a trial and each of its steps.
        finish: Called with every finished trial, how long it took, and its row of the store, if that is made already;
            the pictures that its record names are in the album by then.
        identities: Label of a condition -> the identity of its records.
        album: The pictures of the study.
        live: Whether a worker tells each step when it is played, if the pool can hear it; else all come at the end.

    Raises:
        UserMistake: If the agent is not available, or workers keep being lost.
    """
    fault = PlantFault if resolve(plans[0].agent).engine == "inline" else ModelFault
    told, reader = Counter[str](), TrialReader()

    def hear(said: tuple[str, Step]) -> None:
        told[said[0]] += 1
        on_step(*said)

    player = _Player(plans[0].agent, dict(identities), allowed(), live)
    for plan, played in pool.each(player, plans, hear, together=not live):
        seen = told.pop(plan.key, 0)
        if isinstance(played, Lost):
            error = ModelFault(played.why) if played.explained else fault(f"{plan.agent} lost its worker: {played.why}")
            trial = broken(plan, error)
            finish(trial, Timing(key=trial.key, seconds=0.0, steps=0), None)
            continue
        row, pictures = played
        for picture in pictures:
            album.keep(picture)
        trial = reader.read(zlib.decompress(row.record))
        for step in trial.steps[seen:]:
            on_step(trial.key, step)
        finish(trial, row.timing, row)


@dataclass(frozen=True, slots=True)
class _Player:
    """Builds an agent in a worker and returns the function that plays plans with it."""

    spec: str
    identities: Mapping[str, str]
    code: tuple[str, ...]
    live: bool

    def __call__(self) -> Callable[[Plan], tuple[TrialRow, tuple[Picture, ...]]]:
        allow(*self.code)
        if parent_process() is not None:  # a process of this machine; a node of a cluster says where it hangs itself
            PATIENCE.stuck = lose
        agent = resolve(self.spec).make()

        def on_step(key: str, step: Step) -> None:
            if self.live:
                tell((key, step))

        def play(plan: Plan) -> tuple[TrialRow, tuple[Picture, ...]]:
            taken: dict[str, Picture] = {}

            def keep(picture: Picture) -> None:
                taken[picture.name] = picture

            trial, timing = asyncio.run(play_timed(plan, agent, on_step, keep))
            return row_of(trial, timing, self.identities[trial.condition]), tuple(taken.values())

        return play
