"""Plays the trials of one agent in this process, several at once, until the budget is reached."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable

from lockprobe.foundation.errors import BudgetReached
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial

_UNHEARD = 0.05
"""Seconds after which a run of one trial after the other hears Ctrl-C, when the next trial ends."""


async def play_in_lanes(
    queue: deque[Plan],
    play: Callable[[Plan], Awaitable[tuple[Trial, Timing]]],
    finish: Callable[[Trial, Timing], None],
    *,
    lanes: int = 1,
    at_the_end: int = 0,
    leave: Callable[[], bool] = lambda: False,
) -> None:
    """Play plans in this process, in order, with ``lanes`` at once; the last ``at_the_end`` all at once.

    Once ``leave`` says so, no trial is opened any more; the others stay in the queue.
    An error other than a broken trial ends all trials, and those under way are cancelled. If the budget is reached, no
    trial is opened any more, and each open one goes on until it is refused a call itself. ``finish`` gets every
    finished trial.

    Raises:
        BudgetReached: If the budget is reached; once, when no trial is open any more.
        UserMistake: As ``play`` and ``finish`` raise it.
    """
    spent = list[BudgetReached]()

    async def trial(plan: Plan) -> None:
        try:
            finish(*await play(plan))
        except BudgetReached as reached:
            spent.append(reached)

    def admits() -> bool:
        """Whether another trial can be opened."""
        return bool(queue) and not spent and not leave()

    heard = time.monotonic()
    while lanes == 1 and not at_the_end and admits():
        await trial(queue.popleft())
        heard = await _hear(heard)
    opened: set[asyncio.Task[None]] = set()
    try:
        while True:
            while (len(opened) < lanes or len(queue) <= at_the_end) and admits():
                opened.add(asyncio.ensure_future(trial(queue.popleft())))
            if not opened:
                break
            done, opened = await asyncio.wait(opened, return_when=asyncio.FIRST_COMPLETED)
            await asyncio.gather(*done)
    finally:
        for task in opened:
            task.cancel()
        await asyncio.gather(*opened, return_exceptions=True)
    if spent:
        raise spent[-1]


async def _hear(heard: float) -> float:
    """Let Ctrl-C be heard, if it was long ago that it could be; when it could be last."""
    if time.monotonic() - heard < _UNHEARD:
        return heard
    await asyncio.sleep(0)
    return time.monotonic()
