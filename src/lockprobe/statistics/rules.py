"""Attempts against the rules of the box: the interlock let a joint move and it did not, or the reverse.

A simulation of the rules has none. A hand misses, slips or pushes another joint; a person who moves a box by hand errs.
Such an attempt says nothing of the agent that chose it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import zip_longest
from typing import NamedTuple

from lockprobe.boxes.box import Lockbox
from lockprobe.trial.record import Step, Trial


class Judged(NamedTuple):
    """One attempt before the rules: whether the joint was free, whether it moved, and whether another one changed."""

    free: bool
    moved: bool
    other: bool

    @property
    def against(self) -> bool:
        """Whether it broke the rules: it missed a free joint, forced a locked one, or moved another one."""
        return self.free != self.moved or self.other


class Rules:
    """The rules of one or several boxes, before which the attempts of trials are judged.

    Args:
        boxes: The boxes; of several the one of a trial is that of the name on record.
    """

    def __init__(self, *boxes: Lockbox) -> None:
        self._boxes = boxes
        self._known = dict[tuple[str, tuple[str, ...], str, str, bool, str], Judged]()  # attempts recur

    def judged(self, trial: Trial) -> list[Judged]:
        """Every attempt of a trial; none if the trial is of other joints.

        Whether another joint changed is known from the state before the next attempt.
        """
        box = self._boxes[0] if len(self._boxes) == 1 else next(one for one in self._boxes if one.name == trial.box)
        if sorted(trial.joints) != sorted(box.names):
            return []
        found = []
        for step, after in zip_longest(trial.steps, trial.steps[1:]):
            attempt = (box.name, trial.joints, step.state, step.joint, step.moved, after.state if after else "")
            if (one := self._known.get(attempt)) is None:
                at = dict(zip(trial.joints, step.state, strict=True))
                free = box.may_move(tuple(at[name] == "1" for name in box.names), box.names.index(step.joint))
                then = dict(zip(trial.joints, after.state, strict=True)) if after else at
                other = any(at[name] != then[name] for name in at if name != step.joint)
                one = self._known[attempt] = Judged(free, step.moved, other)
            found.append(one)
        return found

    def broken(self, trials: Iterable[Trial]) -> tuple[int, int]:
        """How many attempts of trials broke them, and of how many; also in trials that broke later."""
        against = [one.against for trial in trials for one in self.judged(trial)]
        return sum(against), len(against)


def unbroken(trial: Trial, judged: Sequence[Judged]) -> int:
    """The number of attempts of a trial before the first one that broke the rules; all if none did."""
    return next((i for i, one in enumerate(judged) if one.against), len(trial.steps))


def state_after(trial: Trial, step: Step) -> str:
    """The configuration after a step if it moved no other joint, a bit string in panel order."""
    return _turned(step.state, trial.joints.index(step.joint)) if step.moved else step.state


@lru_cache(maxsize=1 << 16)
def _turned(state: str, place: int) -> str:
    return f"{state[:place]}{1 - int(state[place])}{state[place + 1 :]}"
