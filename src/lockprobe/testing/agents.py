"""What every agent has to keep that answers by itself; models behind a provider do not answer twice alike."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from lockprobe.agents.catalogue import resolve
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import find_box
from lockprobe.plan import Plan
from lockprobe.record import Trial
from lockprobe.seams import Agent
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.stage import play_timed
from lockprobe.studies.study import Study
from lockprobe.testing.records import check_facts, check_record

__all__ = ["check_agent"]

_T = TypeVar("_T")
_SEEDS = (1, 2, 3)


def check_agent(
    agent: str | Agent,
    *,
    boxes: Sequence[str | Path | Lockbox] = ("chain-4", "gray-code"),
    plant: str = "symbolic",
    modality: str = "symbolic",
) -> None:
    """Hold an agent against its contract.

    It chooses joints that are listed. The same trial is played alike again: all that it draws it draws from the stream
    that it is given. It keeps nothing between calls: two trials side by side are played as one after the other. Its
    facts and its decisions survive the record.

    Args:
        agent: Its spec, or an agent.
        boxes: What it plays, told the truth and with false reports.
        plant: What is acted on, as its spec.
        modality: How the box is shown, as its spec; with pictures no report is false.

    Raises:
        AssertionError: If it breaks one of these; the message says which.
    """
    player = resolve(agent).make() if isinstance(agent, str) else agent
    name = agent if isinstance(agent, str) else type(agent).__name__
    assert isinstance(player, Agent), f"{name} has no `facts` or no `decide`"
    check_facts(player.facts, name)
    rates = (0.0,) if is_pictured(modality) else (0.0, 0.4)
    plans = [plan for box in boxes for plan in _plans(name, find_box(box), plant, modality, rates)]
    alone = [_played([plan], player)[0] for plan in plans]
    for trial in alone:
        check_record(trial, name)
    again = [_played([plan], player)[0] for plan in plans]
    assert alone == again, f"{name} plays the same trial differently again: it keeps something, or draws elsewhere"
    together = _played(plans, player)
    assert alone == together, f"{name} keeps something between calls: trials side by side are not as one by one"


def _plans(agent: str, box: Lockbox, plant: str, modality: str, rates: Sequence[float]) -> list[Plan]:
    plans = []
    for seed in _SEEDS:
        study = Study(
            name="check", agents=(agent,), box=box, p=tuple(rates), seed=seed, plant=plant, modalities=(modality,)
        )
        plans += [study.plan(agent, p, 1, 1, modality) for p in rates]
    return plans


async def _in_turns(work: Callable[[], _T], /) -> _T:
    """Where plants act: before each of them does, every other trial goes on."""
    await asyncio.sleep(0)
    return work()


def _played(plans: Sequence[Plan], agent: Agent) -> list[Trial]:
    """These trials side by side, step by step in turns."""

    async def play() -> list[Trial]:
        every = (play_timed(plan, agent, lambda key, step: None, place=_in_turns) for plan in plans)
        return [trial for trial, _ in await asyncio.gather(*every)]

    with ThreadPoolExecutor(max_workers=1) as elsewhere:  # a test may run in a loop of its own
        return elsewhere.submit(asyncio.run, play()).result()
