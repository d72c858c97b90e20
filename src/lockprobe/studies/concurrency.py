"""Trials of one agent in this process: one after the other, or side by side where the agent waits for a provider.

A run opens as many trials as requests may be on their way, so that finished ones come early; but the last ones all at
once, so that they end together and no connection stands idle while a few go through their steps one by one. A request
waits for its turn, so open trials are no requests; they are memory.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Sequence

from lockprobe.errors import BudgetReached
from lockprobe.plan import Plan
from lockprobe.record import Trial
from lockprobe.studies.journal import Timing

__all__ = ["play_in_lanes"]


async def play_in_lanes(
    plans: Sequence[Plan],
    play: Callable[[Plan], Awaitable[tuple[Trial, Timing]]],
    finish: Callable[[Trial, Timing], None],
    *,
    lanes: int = 1,
    at_the_end: int = 0,
) -> None:
    """Play trials in this process.

    What ends one of them otherwise than as a finished or broken trial ends all, and what is on its way is cancelled.
    Only where the money is spent does every trial go on until it is refused a call itself, and none is opened.

    Args:
        plans: What is to be played, in order.
        play: Plays one of them.
        finish: Called with every finished trial.
        lanes: Trials open at once, at least 1.
        at_the_end: The last trials, that many, are all opened at once.

    Raises:
        BudgetReached: If the money is spent; once, when nothing is on its way any more.
        UserMistake: As ``play`` and ``finish`` raise it.
    """
    queue, spent = deque(plans), list[BudgetReached]()

    async def trial(plan: Plan) -> None:
        try:
            finish(*await play(plan))
        except BudgetReached as reached:
            spent.append(reached)

    opened: set[asyncio.Task[None]] = set()
    try:
        while True:
            while queue and not spent and (len(opened) < lanes or len(queue) <= at_the_end):
                opened.add(asyncio.ensure_future(trial(queue.popleft())))
            if not opened:
                break
            done, opened = await asyncio.wait(opened, return_when=asyncio.FIRST_COMPLETED)
            for error in [task.exception() for task in done]:
                if error is not None:
                    raise error
    finally:
        for task in opened:
            task.cancel()
        await asyncio.gather(*opened, return_exceptions=True)
    if spent:
        raise spent[-1]
