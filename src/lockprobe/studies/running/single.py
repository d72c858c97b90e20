"""Plays one trial without a study directory."""

from __future__ import annotations

import asyncio
import inspect
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Unpack, get_type_hints

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import MCP, PEOPLE, spec_kind
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import refuse_blind, taken_in
from lockprobe.studies.options import paper
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.options.trial_options import TrialOptions
from lockprobe.studies.records.picture_store import Album
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent, Closable
from lockprobe.trial.record import Trial


def run_trial(**options: Unpack[TrialOptions]) -> Trial:
    """Play one trial here and now; a study with the same settings plays the same one.

    >>> run_trial(agent="human-inspired", p=0.4, seed=3).key
    'trial/human-inspired/flip?p=0.4/rep=1/trial=1'

    Args:
        options: Any of :class:`lockprobe.studies.options.trial_options.TrialOptions`.

    Raises:
        UserMistake: If a name does not exist, a value is out of range, or something is missing.
    """
    asked, pictures = options.get("agent"), options.get("pictures")
    agent = paper.REFERENCES[-1] if asked is None else asked
    spec = agent if isinstance(agent, str) else type(agent).__name__
    study = trial_study(options, agent=spec)
    plan = study.plan(spec, study.conditions[0], study.repetitions, study.trials)
    if isinstance(agent, str) and spec_kind(agent) in (PEOPLE, MCP):
        raise BadValue("agent", agent, "one that is called: people join lockprobe serve, and clients lockprobe mcp")
    if isinstance(agent, str) and not taken_in(agent, (plan.modality,)):
        refuse_blind(agent, plan.modality, "symbolic")
    resolve_plant(plan.plant).check(plan.box)
    once = _alone(plan, agent, None if pictures is None else Path(pictures))
    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a notebook already runs a loop in this thread
        return elsewhere.submit(asyncio.run, once).result()


run_trial.__signature__ = inspect.Signature(  # type: ignore[attr-defined] # for notebooks, which do not unpack it
    [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in get_type_hints(TrialOptions).items()
    ],
    return_annotation=Trial,
)


async def _alone(plan: Plan, agent: str | Agent, pictures: Path | None) -> Trial:
    player: Agent = resolve(agent).make() if isinstance(agent, str) else agent
    try:
        keep = None if pictures is None else Album(pictures).keep
        return (await play_timed(plan, player, keep=keep))[0]
    finally:
        if isinstance(agent, str) and isinstance(player, Closable):
            await player.aclose()
