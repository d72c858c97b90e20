"""Plays many trials of a strategy on all processors, with the same records as one after the other.

A trial of a strategy takes less than a millisecond. So processes get many plans at once and return rows of the
store, which are written in the order of the plans. A short study is played in this process, before another one would
have started. What a process had taken when it died is played by this one.
"""

from __future__ import annotations

import asyncio
import math
import signal
import sys
import time
import zlib
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Protocol

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.parallel import Spawned, end_with_parent
from lockprobe.studies.records.trial_rows import Timing, TrialRow, row_of
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.trial_reader import TrialReader

OnStep = Callable[[str, Step], None]

_ALONE = 2.0
"""Seconds for which this process plays alone. Others start if as much is left, since each takes a second to start."""

_BATCH = 100
"""Plans that a process gets at once."""

_AHEAD = 3
"""Batches for each process that wait to be played or written."""


class Finish(Protocol):
    """Takes a finished trial."""

    def __call__(self, trial: Trial, timing: Timing, row: TrialRow | None = None) -> None:
        """Write it; ``row`` is the same as it is stored, if that is made already."""
        ...


def play_in_batches(
    plans: Sequence[Plan], workers: int, on_step: OnStep, finish: Finish, identities: Mapping[str, str]
) -> None:
    """Play plans of one strategy that ships with Lockprobe, in their order.

    ``on_step`` and ``finish`` are called in this process.

    Args:
        plans: At least one, on the symbolic plant.
        workers: Processes that may play.
        on_step: Called with the key of a trial and each of its steps.
        finish: Called with every finished trial.
        identities: Label of a condition -> the identity of its records.
    """
    waiting, agent, began = deque(plans), resolve(plans[0].agent).make(), time.monotonic()
    asyncio.run(_play_here(waiting, agent, on_step, finish, seconds=_ALONE))
    each = (time.monotonic() - began) / (len(plans) - len(waiting))
    if each * len(waiting) > _ALONE:
        with suppress(BrokenProcessPool):
            _play_elsewhere(waiting, workers, on_step, finish, identities)
    asyncio.run(_play_here(waiting, agent, on_step, finish))


async def _play_here(
    waiting: deque[Plan], agent: Agent, on_step: OnStep, finish: Finish, *, seconds: float = math.inf
) -> None:
    """Play plans in this process for so many seconds, at least one."""
    end = time.monotonic() + seconds
    while waiting:
        finish(*await play_timed(waiting[0], agent, on_step))
        waiting.popleft()
        await asyncio.sleep(0)  # here Ctrl-C ends it
        if time.monotonic() >= end:
            return


def _play_elsewhere(
    waiting: deque[Plan], workers: int, on_step: OnStep, finish: Finish, identities: Mapping[str, str]
) -> None:
    """Play plans in other processes. Those that are not finished stay in ``waiting`` if a process dies.

    Raises:
        BrokenProcessPool: If it does.
    """
    begin = (waiting[0].agent, dict(identities))
    pool = Spawned(workers, _begin, *begin)
    try:
        reader = TrialReader()
        for rows in _in_order(pool, list(waiting), ahead=_AHEAD * workers):
            for row in rows:
                trial = reader.read(zlib.decompress(row.record))
                for step in trial.steps:
                    on_step(trial.key, step)
                finish(trial, row.timing, row)
                waiting.popleft()
    finally:
        pool.shutdown(cancel_futures=True)


def _in_order(pool: Spawned, plans: Sequence[Plan], *, ahead: int) -> Iterator[list[TrialRow]]:
    """The rows of batches in the order of the plans; no more batches are under way than ``ahead``."""
    under_way: deque[Future[list[TrialRow]]] = deque()
    for first in range(0, len(plans), _BATCH):
        under_way.append(pool.submit(_play_batch, plans[first : first + _BATCH]))
        if len(under_way) >= ahead:
            yield under_way.popleft().result()
    while under_way:
        yield under_way.popleft().result()


_playing: dict[str, tuple[Agent, Mapping[str, str]]] = {}
"""In another process: what it plays with."""


def _begin(spec: str, identities: Mapping[str, str]) -> None:
    """What another process does first. It leaves Ctrl-C to the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what agents print is no result
    end_with_parent()
    _playing["agent"] = resolve(spec).make(), identities


def _play_batch(plans: Sequence[Plan]) -> list[TrialRow]:
    """Play plans in another process, and return their rows."""
    return asyncio.run(_played(plans, *_playing["agent"]))


async def _played(plans: Sequence[Plan], agent: Agent, identities: Mapping[str, str]) -> list[TrialRow]:
    rows = []
    for plan in plans:
        trial, timing = await play_timed(plan, agent)
        rows.append(row_of(trial, timing, identities[trial.condition]))
    return rows
