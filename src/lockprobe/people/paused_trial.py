"""A participant's trial, paused at each decision until the participant chooses.

A resumed trial first replays the steps in the diary. The same seed gives the same reports.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from contextlib import AsyncExitStack, suppress
from pathlib import Path

from lockprobe.agents.participant import Participant
from lockprobe.errors import BadValue
from lockprobe.people.diary import Did
from lockprobe.people.responses import Attempt
from lockprobe.plan import Plan
from lockprobe.record import Fact, Outcome, Situation, Step, Trial
from lockprobe.studies.play import play_timed
from lockprobe.trial import Executor, here

__all__ = ["PausedTrial"]


class PausedTrial:
    """A trial that waits at each decision. Start it with :meth:`begin`; :meth:`close` releases its plant.

    Attributes:
        situation: What the page may show now; None once the trial is over.
        trial: Its record once it is over, else None.
    """

    def __init__(self, plan: Plan, facts: Mapping[str, Fact], pictures: Path | None, place: Executor) -> None:
        self.plan = plan
        self.situation: Situation | None = None
        self.trial: Trial | None = None
        self._told: list[str] = []
        self._person = Participant(facts)
        self._loop = asyncio.create_task(play_timed(plan, self._person, self._note, pictures, place=place))

    @classmethod
    async def begin(
        cls,
        plan: Plan,
        played: Iterable[Did] = (),
        *,
        facts: Mapping[str, Fact] | None = None,
        pictures: Path | None = None,
        place: Executor = here,
    ) -> PausedTrial:
        """Begin a trial, replay its steps so far, and wait at the next decision.

        Args:
            plan: The trial.
            played: Its steps so far, from the diary.
            facts: The settings of the page, for the record.
            pictures: Directory for pictures; None stores none.
            place: Where the plant runs.

        Raises:
            BadValue: If a report differs from the one that was shown, or the steps do not fit the trial.
            LockprobeError: If a file cannot be written.
        """
        paused = cls(plan, facts or {}, pictures, place)
        async with AsyncExitStack() as undo:
            undo.push_async_callback(paused.close)
            await paused._wait()
            for number, did in enumerate(played, 1):
                if isinstance(did.act, Attempt):
                    await paused._replay(number, did.act, did.told)
            undo.pop_all()
        return paused

    @property
    def sound(self) -> bool:
        """Whether neither the plant nor a channel has broken it so far."""
        return self.trial is None or self.trial.error is None

    async def attempt(self, joint: str, claimed: Outcome | None = None) -> str:
        """Attempt a joint and wait for the next decision or the end.

        ``claimed`` is what the participant says of the step before. Returns the report of the attempt; empty with
        pictures and where the trial broke.
        """
        before = len(self._told)
        self.situation = None
        self._person.say(joint, claimed)
        await self._wait()
        return self._told[-1] if len(self._told) > before else ""

    async def close(self) -> None:
        """End the trial and release its plant."""
        if self._loop.done():
            return
        self._loop.cancel()
        with suppress(asyncio.CancelledError):
            await self._loop

    async def _replay(self, number: int, act: Attempt, shown: str) -> None:
        """Replay a step and compare the report with the one that was shown. A broken trial reports nothing."""
        what = f"step {number} of {self.plan.key}"
        if self.situation is None or act.joint not in self.situation.task.joints:
            if self.sound:
                raise BadValue(what, act.joint, "a step of this trial")
            return
        told = await self.attempt(act.joint, act.claimed)
        if told != shown and self.sound:
            raise BadValue(what, told, f"{shown!r}, as it was shown before")

    async def _wait(self) -> None:
        """Wait until the loop asks or is over; pass on its exceptions."""
        asked = asyncio.create_task(self._person.asked())
        try:
            await asyncio.wait({asked, self._loop}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            asked.cancel()
        if self._loop.done():
            self.trial = self._loop.result()[0]
        else:
            self.situation = asked.result()

    def _note(self, key: str, step: Step) -> None:
        self._told.append("" if step.pictures else step.told)
