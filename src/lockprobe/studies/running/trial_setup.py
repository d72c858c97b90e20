"""Sets up one trial, plays it and measures its duration; all runners use this module."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from hashlib import sha256
from inspect import getsource
from typing import TypeVar, cast

from lockprobe.foundation.spec import spec_kind
from lockprobe.interventions.modality import places_in
from lockprobe.plants.catalogue import plant_of
from lockprobe.studies.costs.call_log import Calls
from lockprobe.trial.loop import Executor, here, play
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent, Calling
from lockprobe.trial.record import Fact, Step, Trial

_T = TypeVar("_T")


@contextmanager
def plants_place(apart: bool) -> Iterator[Executor]:
    """Where all plants of a run work: in this thread or ``apart``, in one of their own.

    There simulations hold up neither calls of providers nor clients. OpenGL contexts belong to the thread that created
    them, so all work on all plants runs in one thread.
    """
    if not apart:
        yield here
        return
    with ThreadPoolExecutor(max_workers=1, thread_name_prefix="plants") as thread:

        async def there(work: Callable[[], _T], /) -> _T:
            return await asyncio.get_running_loop().run_in_executor(thread, work)

        yield there


async def play_timed(
    plan: Plan,
    agent: Agent,
    on_step: Callable[[str, Step], None] = lambda key, step: None,
    keep: Callable[[Picture], None] | None = None,
    calls: Calls | None = None,
    place: Executor = here,
    recorded: Trial | None = None,
) -> tuple[Trial, float]:
    """Play one plan, and measure how long it took in seconds.

    Args:
        plan: The plan.
        agent: The agent.
        on_step: Called with the plan's key and every step.
        keep: Stores the pictures that the record names; without it they are lost.
        calls: Log of the agent's calls, if it makes any.
        place: The executor that runs the plant.
        recorded: A record of the trial, from which the camera's readings are taken instead of new pictures.
    """
    began, key = time.perf_counter(), plan.key
    if calls is not None and issubclass(type(agent), Calling):  # to ask for the instance takes much longer
        agent = cast(Calling, agent).with_calls(key, calls.of(plan))
    trial = await play(
        plan,
        plant=partial(plant_of, plan),
        interventions=places_in(plan.condition),
        agent=agent,
        on_step=partial(on_step, key),
        keep=keep,
        place=place,
        recorded=recorded,
    )
    if calls is not None:
        await calls.committed()
    if spec_kind(plan.agent) == "python" and recorded is None:
        trial = replace(trial, facts={**trial.facts, **_source(type(agent))})
    return trial, time.perf_counter() - began


@cache
def _source(kind: type) -> Mapping[str, Fact]:
    """The hash of the source of a class of one's own, so that none goes on where another one of its name began."""
    try:
        return {"source": sha256(getsource(kind).encode()).hexdigest()[:12]}
    except (OSError, TypeError):  # there is none
        return {}
