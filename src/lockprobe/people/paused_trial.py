"""One trial of a person, held at each decision until somebody says which; what was done before is played again first.

The same seed tells the same, so a trial that was let go of, or whose server was killed, goes on where it stood.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from lockprobe.agents.participant import Participant
from lockprobe.errors import BadValue
from lockprobe.plan import Plan
from lockprobe.record import Fact, Outcome, Situation, Step, Trial
from lockprobe.studies.play import play_timed
from lockprobe.trial import Executor, here

__all__ = ["Held", "Played"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """One step as it was played and shown before.

    Attributes:
        joint: Label of the joint.
        claimed: What was said of the step before; None where nobody asked.
        told: The report that was shown; empty with pictures.
    """

    joint: str
    claimed: Outcome | None = None
    told: str = ""


class Held:
    """A trial that waits at each decision. Use :meth:`begin`; :meth:`close` lets go of it.

    Attributes:
        plan: What is played.
        situation: All that may be shown now; None once the trial is over.
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
        played: Sequence[Played] = (),
        *,
        facts: Mapping[str, Fact] | None = None,
        pictures: Path | None = None,
        place: Executor = here,
    ) -> Held:
        """Begin a trial, play what was played of it before, and wait at the next decision.

        Args:
            plan: What is played.
            played: Its steps so far.
            facts: What the person plays on, for the record.
            pictures: Directory in which pictures are kept; without it they are not.
            place: Where its plant does its work.

        Raises:
            BadValue: If now something else is told than what was shown, or the steps do not fit.
            LockprobeError: If a file cannot be written.
        """
        held = cls(plan, facts or {}, pictures, place)
        async with AsyncExitStack() as undo:
            undo.push_async_callback(held.close)
            await held._wait()
            for number, step in enumerate(played, 1):
                await held._again(number, step)
            undo.pop_all()
        return held

    @property
    def sound(self) -> bool:
        """Whether nothing of the plant or a channel has broken it so far."""
        return self.trial is None or self.trial.error is None

    async def attempt(self, joint: str, claimed: Outcome | None = None) -> str:
        """Attempt a joint and wait for the next decision or the end.

        Args:
            joint: Its label.
            claimed: What is said of the step before; None where nobody asked.

        Returns:
            The report that is told of it; empty with pictures, and where it broke.
        """
        before = len(self._told)
        self.situation = None
        self._person.say(joint, claimed)
        await self._wait()
        return self._told[-1] if len(self._told) > before else ""

    async def close(self) -> None:
        """Let go of it and of its plant."""
        if self._loop.done():
            return
        self._loop.cancel()
        with suppress(asyncio.CancelledError):
            await self._loop

    async def _again(self, number: int, step: Played) -> None:
        """Play a step that was played before. What has broken tells nothing."""
        what = f"step {number} of {self.plan.key}"
        if self.situation is None or step.joint not in self.situation.task.joints:
            if self.sound:
                raise BadValue(what, step.joint, "a step of this trial")
            return
        told = await self.attempt(step.joint, step.claimed)
        if told != step.told and self.sound:
            raise BadValue(what, told, f"{step.told!r}, as it was shown before")

    async def _wait(self) -> None:
        """Until the loop asks or is over; what it raises is raised."""
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
