"""Trials of simulated agents, to which tests fit models."""

import asyncio

from builders import study_of

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.studies.running.trial_setup import play_timed

PAPER = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def flip_trials(agent, seed=1, *, p=PAPER, flip="re-observed", repetitions=3, trials=10, budget=20, lockbox="chain-4"):
    """All trials of a flip study of one agent, or of its spec; the paper's study, unless other sizes are given."""
    spec, player = (agent, resolve(agent).make()) if isinstance(agent, str) else (type(agent).__name__, agent)
    settings = {"repetitions": repetitions, "trials": trials, "max_steps": budget, "seed": seed}
    study = study_of(p, flip, name="flips", agents=(spec,), box=box(lockbox), **settings)

    async def all_of_them():
        return [(await play_timed(plan, player))[0] for plan in study.plans(spec)]

    return asyncio.run(all_of_them())
