"""Builders of trials: scripted or played through the real loop, with records like those of a study."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.protocols import Agent, Intervention
from lockprobe.trial.record import Decision, Fact, Moment, Outcome, Percept, Situation, Task, Trial

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, kw_only=True)
class ScriptedAgent:
    """An agent that repeats a list of joints, whatever the reports say.

    It counts the exchanges that it remembers, so ``history`` confuses it.

    Attributes:
        joints: Positions in the listing, from 0; without shuffling that is the panel order.
        claims: Its claims about the step before, step by step; the first has no meaning. Afterwards it makes none.
        breaks: Whether it raises an error at the end of its list.

    Raises:
        BadValue: If there is no joint.
    """

    joints: tuple[int, ...]
    claims: tuple[Outcome | None, ...] = ()
    breaks: bool = False

    def __post_init__(self) -> None:
        if not self.joints and not self.breaks:
            raise BadValue("joints", self.joints, "at least one place in the listing")

    @property
    def facts(self) -> Mapping[str, Fact]:
        """Its list."""
        return {"joints": " ".join(map(str, self.joints))}

    async def decide(self, situation: Situation, rng: np.random.Generator) -> Decision:
        """The next joint of its list.

        Raises:
            RuntimeError: At the end of its list, if it breaks there.
        """
        done = len(situation.past)
        if self.breaks and done >= len(self.joints):
            raise RuntimeError("the script ends here")
        joint = situation.task.joints[self.joints[done % len(self.joints)]]
        return Decision(joint=joint, claimed=self.claims[done] if done < len(self.claims) else None)


@dataclass(frozen=True, kw_only=True)
class _FalseAt:
    """Inverts the reports of some steps, from 1."""

    steps: tuple[int, ...]

    def perceive(self, percept: Percept, past: tuple[Moment, ...], task: Task, rng: np.random.Generator) -> Percept:
        return OutcomeFlip(p=float(len(past) in self.steps)).perceive(percept, past, task, rng)


def make_trial(
    joints: Sequence[int],
    *,
    box: str | Path | Lockbox = DEFAULT_BOX,
    false_at: Collection[int] = (),
    claims: Sequence[Outcome | None] = (),
    broken: bool = False,
    condition: Sequence[Intervention] = (),
    **options: Any,
) -> Trial:
    """A trial that attempts these joints, with the box's true reactions. It ends with the list or with the target.

    Args:
        joints: Positions in panel order, from 0.
        box: The box: a name, a path, or a box.
        false_at: Steps, from 1, whose report is inverted.
        claims: The agent's claims about the step before; the first has no meaning.
        broken: Whether it breaks after these joints; it then ends as ``error``.
        condition: Further interventions.
        **options: Other options of :func:`lockprobe.run_trial`: ``seed``, ``repetition``, ``trial``, ``plant`` …
    """
    last = len(find_box(box).joints) - 1
    for joint in joints:
        check_whole("joint", joint, 0, last)
    agent = ScriptedAgent(joints=tuple(joints), claims=tuple(claims), breaks=broken)
    false = (_FalseAt(steps=tuple(false_at)),) if false_at else ()
    options = {"shuffle": "never", "max_steps": len(agent.joints) + broken, **options}
    return run_trial(agent=agent, box=box, condition=(*false, *condition), **options)


def play_trials(agent: str | Agent = "random", trials: int = 10, **options: Any) -> list[Trial]:
    """Play the first trials of one agent under one condition through the real loop.

    Args:
        agent: Agent spec, or an agent.
        trials: Number of trials, from 1; each has its own random streams.
        **options: Other options of :func:`lockprobe.run_trial`: ``box``, ``condition``, ``seed``, ``max_steps`` …
    """
    return [run_trial(agent=agent, trial=number, **options) for number in range(1, trials + 1)]
