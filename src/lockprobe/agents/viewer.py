"""The agent ``viewer``: it reads joint positions from pictures and lets a strategy decide.

It turns its readings of every picture (:mod:`lockprobe.trial.pictures.picture_reader`) into the reports of a symbolic
observation, and claims of its last action what it saw. Misreadings come from the pictures alone; it draws no random
numbers. Without pictures it acts as the strategy and claims what it was told.

It knows where in a picture each handle can be, so it does not test *finding* joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import Checked, Within
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Decision, Fact, Outcome, Percept, Situation, Task

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Viewer(Checked):
    """Reads the joints' positions from pictures and plays a strategy by them.

    Attributes:
        name: Spec of the strategy.
        acuity: Pixels that it resolves across a picture, at least 4. None: 10, or more where the first picture of a
            trial needs more.
    """

    strategy: Agent
    name: str
    acuity: Annotated[int, Within(4)] | None = None

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its eyesight and its strategy."""
        return {"acuity": self.acuity, "strategy": self.name} | dict(self.strategy.facts)

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """Read the picture, then choose as the strategy does with this reading as its report."""
        reports = self.reports(situation.task, [percept for percept, _ in situation.told])
        past = tuple(replace(turn, percept=report) for turn, report in zip(situation.past, reports[:-1], strict=True))
        told = replace(situation, past=past, percept=reports[-1])
        return replace(await self.strategy.decide(told, rng), claimed=told.outcome)

    def reports(self, task: Task, percepts: Iterable[Percept]) -> list[Percept]:
        """All its observations as reports. A percept without pictures already is a report."""
        from lockprobe.trial.pictures.picture_reader import evidence, needed_acuity

        reports, acuity = list[Percept](), self.acuity or 0
        before: tuple[bool, ...] | None = None  # where joints were read, or told, last
        for percept in percepts:
            report = percept
            if percept.pictures:
                if not percept.handles or not percept.shown:
                    raise BadValue("observation of viewer", percept.text, "pictures with the places of handles")
                acuity = acuity or needed_acuity(percept.shown, percept.handles, 10)
                found = evidence(percept.shown, percept.handles, acuity=acuity)  # above 0 away from the start
                last = before or tuple(sign > 0 for sign in found)
                # in doubt a joint keeps its last reading
                now = tuple(sign > 0 if abs(sign) > 0.05 else at for sign, at in zip(found, last, strict=True))
                outcome: Outcome | None = None
                if percept.joint is not None:
                    joint = task.joints.index(percept.joint)
                    outcome = "moved" if now[joint] != last[joint] else "blocked"
                report = replace(percept, positions=now, outcome=outcome, pictures=())
            reports.append(report)
            before = report.positions or before
        return reports
