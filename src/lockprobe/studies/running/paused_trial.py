"""A trial that pauses at each decision for an outside agent: a participant, or a client with tools.

A resumed trial first replays the steps that are on disk. The same seed gives the same reports.

An environment of Gymnasium has its own form, because its ``step`` has no event loop to wait in: it sends each decision
straight into the coroutine :func:`lockprobe.trial.loop.play`. Its episodes are neither resumed nor recorded.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from contextlib import AsyncExitStack, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

from lockprobe.foundation.errors import BadValue, ChannelFault
from lockprobe.studies.records.store import keep_picture
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.loop import Executor, here
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Decision, Fact, Outcome, Situation, Step, Trial

if TYPE_CHECKING:
    import numpy as np


class RecordedAttempt(NamedTuple):
    """An attempt of a paused trial, as stored on disk.

    Attributes:
        joint: Label of the joint chosen.
        claimed: The claim about the action before.
        told: The report that followed; empty with pictures.
        hypothesis: How the box works, in the agent's words.
    """

    joint: str
    claimed: Outcome | None = None
    told: str = ""
    hypothesis: str = ""


class PausedTrial:
    """A trial that waits at each decision, and is its own agent. :meth:`close` releases its plant.

    Args:
        plan: The plan of the trial.
        facts: Facts about the agent's connection, for the record.
        words_alone: Whether remarks and warnings are all that the agent is shown of what it is asked.
        pictures: Directory for pictures; None stores none.
        place: The executor that runs the plant.

    Attributes:
        situation: The information that may be shown now; None once the trial is over.
        trial: The record once the trial is over, else None.
        seconds: How long it took from :meth:`begin`, once the trial is over.
    """

    def __init__(
        self,
        plan: Plan,
        *,
        facts: Mapping[str, Fact] | None = None,
        words_alone: bool = False,
        pictures: Path | None = None,
        place: Executor = here,
    ) -> None:
        self.plan, self.facts, self._words_alone, self._told = plan, facts or {}, words_alone, ""
        self.situation: Situation | None = None
        self.trial: Trial | None = None
        self.seconds = 0.0
        self._asked: asyncio.Queue[Situation | None] = asyncio.Queue()  # None at the end
        self._said: asyncio.Queue[Decision] = asyncio.Queue()
        keep = None if pictures is None else partial(keep_picture, pictures)
        self._loop = asyncio.create_task(play_timed(plan, self, self._note, keep, place=place))
        self._loop.add_done_callback(lambda _: self._asked.put_nowait(None))

    async def begin(self, played: Iterable[RecordedAttempt] = ()) -> Self:
        """Begin, replay the attempts so far, and wait at the next decision.

        Raises:
            BadValue: If a report differs from the one that was shown, or the steps do not fit the trial.
            LockprobeError: If a file cannot be written.
        """
        async with AsyncExitStack() as undo:
            undo.push_async_callback(self.close)
            await self._wait()
            for number, step in enumerate(played, 1):
                what, there = f"step {number} of {self.plan.key}", self.situation
                if there is not None and step.joint in there.task.joints:
                    told = await self.attempt(step.joint, step.claimed, step.hypothesis)
                    if told != step.told and self.sound:  # a broken trial reports nothing
                        raise BadValue(what, told, f"{step.told!r}, as it was shown before")
                elif self.sound:
                    raise BadValue(what, step.joint, "a step of this trial")
            undo.pop_all()
        return self

    @property
    def sound(self) -> bool:
        """Whether neither the plant nor a channel has broken the trial so far."""
        return self.trial is None or self.trial.error is None

    async def attempt(self, joint: str, claimed: Outcome | None = None, hypothesis: str = "") -> str:
        """Attempt a joint and wait for the next decision or the end.

        ``claimed`` is the agent's claim about the step before, ``hypothesis`` its statement about the box. Returns the
        report of the attempt; empty with pictures and if the trial broke.
        """
        self.situation, self._told = None, ""
        self._said.put_nowait(Decision(joint=joint, claimed=claimed, hypothesis=hypothesis))
        await self._wait()
        return self._told

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Wait for the decision, which :meth:`attempt` makes.

        Raises:
            ChannelFault: If an intervention asks for what does not reach the agent.
        """
        if self._words_alone and situation.briefing.instruction:
            raise ChannelFault("an intervention asks for more than a remark or a warning, which is all that is shown")
        self._asked.put_nowait(situation)
        return await self._said.get()

    async def close(self) -> None:
        """End the trial and release its plant."""
        if not self._loop.done():
            self._loop.cancel()
            with suppress(asyncio.CancelledError):
                await self._loop

    async def _wait(self) -> None:
        """Wait until the trial loop asks for a decision or ends; re-raise its exceptions."""
        self.situation = await self._asked.get()
        if self.situation is None:
            self.trial, self.seconds = self._loop.result()

    def _note(self, key: str, step: Step) -> None:
        self._told = "" if step.pictures else step.told
