"""The trials of one agent as columns, broken ones too, with the order of their blocks; its repetitions as points.

Last, trials that can show no effect: an agent that plays alike whatever it is told, and interventions that changed
nothing. Neither is a null result.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.foundation.spec import spec_name
from lockprobe.statistics import loops
from lockprobe.trial.condition import PLANT
from lockprobe.trial.record import Trial

REPORTS = 10
"""Fewest differing reports, each with an action after it, for an agent that plays alike to be called blind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockOrder:
    """That what is said of an agent's trials must hold at every look, and in which order its blocks were planned.

    The order of *arrival* would not do: of trials that are played at once, those that are solved soon end first. So
    blocks are taken as planned, up to the first one with a trial that is still open. Whether a block is played at all
    may depend on those before it: a condition that is decided is no longer played.

    Attributes:
        plans: Repetitions, and trials per repetition, of the study as it was first planned and after each extension,
            every one at least as large as those before. Blocks of an earlier plan come before all added to it.
        margin: The largest difference in success that counts as none, (0, 1), if such statements are made too.
    """

    plans: tuple[tuple[int, int], ...]
    margin: float | None = None

    def rank(self, repetition: ArrayLike, trial: ArrayLike) -> NDArray[np.int64]:
        """The places of blocks in the order, from 0.

        >>> BlockOrder(plans=((1, 2), (2, 3))).rank([1, 1, 1, 2], [1, 2, 3, 1]).tolist()
        [0, 1, 2, 3]
        """
        place = np.full(np.max(self.plans, axis=0), -1, dtype=np.int64)
        for repetitions, trials in self.plans:
            part = place[:repetitions, :trials]
            new = part < 0
            part[new] = np.arange(new.sum()) + place.max() + 1
        found: NDArray[np.int64] = place[np.asarray(repetition, int) - 1, np.asarray(trial, int) - 1]
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcomes:
    """Trials, one row each. Every column has the shape (trials,).

    Attributes:
        dose: The dose on the axis of the analysis: flip probability, [0, 1], or another.
        repetition: From 1.
        trial: From 1. Trials of equal repetition and trial share their luck (labels, flips, draws) over all p.
        length: Steps played.
        solved: Whether the target moved.
        onset: The step at which the first action loop was complete, from 1; 0 if the trial holds none.
        broke: Whether the trial broke, so that nobody knows how it would have ended; no rows if none did.
        box: The name of its box; no rows where it is not known.
        player: :attr:`lockprobe.trial.record.Trial.player` of each; no rows where every trial stands alone.
        order: The order of the blocks, if what is said of the trials must hold at every look; None if at one alone.
        budget: Most steps of a trial; 0 where it is of no use.
    """

    dose: NDArray[np.float64]
    repetition: NDArray[np.int64]
    trial: NDArray[np.int64]
    length: NDArray[np.int64]
    solved: NDArray[np.bool_]
    onset: NDArray[np.int64]
    broke: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=np.bool_))
    box: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, dtype=np.str_))
    player: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, dtype=np.str_))
    order: BlockOrder | None = None
    budget: int = 0

    def __len__(self) -> int:
        return len(self.dose)

    @property
    def ended(self) -> Outcomes:
        """Those that ended as solved or out of budget. An error is not a failure to solve."""
        return self.at(~self.broke) if self.broke.any() else self

    @property
    def broken(self) -> Outcomes:
        """Those that broke."""
        return self.at(self.broke if len(self.broke) else np.zeros(len(self), dtype=np.bool_))

    @property
    def at_ended_doses(self) -> Outcomes:
        """Those at doses at which one ended."""
        return self.at(np.isin(self.dose, self.ended.dose)) if self.broke.any() else self

    @property
    def known(self) -> NDArray[np.float64]:
        """1 where a trial was solved, 0 where it was not, NaN where it broke."""
        return np.where(self.broke, np.nan, self.solved) if self.broke.any() else self.solved.astype(np.float64)

    @property
    def looped(self) -> NDArray[np.bool_]:
        """Whether the trial holds an action loop."""
        return self.onset > 0

    @property
    def until_loop(self) -> NDArray[np.int64]:
        """The step that completes the first loop, or the last step of a trial without one."""
        return np.where(self.looped, self.onset, self.length)

    @property
    def luck(self) -> NDArray[np.int64]:
        """The block of luck of each trial, from 0: equal repetition and trial, whatever p is."""
        keys = self.repetition * (self.trial.max(initial=0) + 1) + self.trial
        return np.unique(keys, return_inverse=True)[1].reshape(-1)

    @property
    def crossed(self) -> bool:
        """Whether trials come in clusters of two kinds: by player and by luck."""
        return len(self.player) > 0

    @property
    def cluster(self) -> NDArray[np.int64]:
        """The main cluster of each trial, from 0: its player, as trials of one are alike in skill, or else its luck."""
        if not self.crossed:
            return self.luck
        names = np.where(self.player == "", np.char.add("/", self.luck.astype(np.str_)), self.player)
        return np.unique(names, return_inverse=True)[1].reshape(-1)

    def at(self, chosen: NDArray[np.bool_]) -> Outcomes:
        """The chosen trials, a boolean array of shape (trials,)."""
        return replace(self, **{name: of[chosen] for name in _COLUMNS if len(of := getattr(self, name))})

    def completed(self, soon: ArrayLike) -> Outcomes:
        """All trials, as if those that broke had gone on from their break.

        ``soon`` says which of them solved the box in the step in which they broke, and completed a loop if they had
        none; all others did neither in all of their budget. Shape (trials,), or one for all.
        """
        if not self.broke.any():
            return self
        at_once, last = self.broke & np.asarray(soon, dtype=np.bool_), self.length + 1
        return replace(
            self,
            solved=np.where(self.broke, at_once, self.solved),
            length=np.where(at_once, last, np.where(self.broke, np.maximum(last, self.budget), self.length)),
            onset=np.where(at_once & (self.onset == 0), last, self.onset),
            broke=self.broke[:0],
        )


_COLUMNS = tuple(name for name in Outcomes.__slots__ if name not in ("order", "budget"))


class Point(NamedTuple):
    """One repetition of one condition: a dose, its ended trials, and their shares solved and with an action loop."""

    dose: float
    repetition: int
    n: int
    success: float
    loop_rate: float


def ended(trials: Iterable[Trial]) -> list[Trial]:
    """The trials that ended as solved or out of budget. An error is not a failure to solve."""
    return [trial for trial in trials if trial.ending != "error"]


_onset = lru_cache(maxsize=1 << 17)(loops.onset)


def outcomes(trials: Sequence[Trial], *, order: BlockOrder | None = None) -> Outcomes:
    """The columns of one agent's trials; those that broke up to the error. Doses are flip rates, 0 without one."""
    numbers = [
        (trial.repetition, trial.trial, len(trial.steps), trial.solved, _onset(trial.actions), trial.ending == "error")
        for trial in trials
    ]
    repetition, number, length, solved, onset, broke = np.array(numbers, dtype=np.int64).reshape(len(trials), 6).T
    box, player = np.array([(one.box, one.player) for one in trials], dtype=np.str_).reshape(len(trials), 2).T
    return Outcomes(
        dose=np.array([trial.p or 0.0 for trial in trials], dtype=np.float64),
        repetition=repetition,
        trial=number,
        length=length,
        solved=solved > 0,
        onset=onset,
        broke=broke > 0,
        box=box,
        player=player if (player != "").any() else player[:0],
        order=order,
        budget=max((trial.budget for trial in trials), default=0),
    )


def joined(groups: Sequence[Outcomes], doses: Sequence[float] | None = None) -> Outcomes:
    """Several groups of trials, concatenated, with the dose of each; the number of the group (from 0) without doses."""
    crossed = any(group.crossed for group in groups)
    made = [
        replace(
            group,
            dose=np.full(len(group), float(dose)),
            player=group.player if group.crossed or not crossed else np.full(len(group), ""),
            broke=group.broke if len(group.broke) else np.zeros(len(group), dtype=np.bool_),
        )
        for dose, group in zip(range(len(groups)) if doses is None else doses, groups, strict=True)
    ]
    columns = {name: np.concatenate([getattr(one, name) for one in made]) for name in _COLUMNS}
    return Outcomes(**columns, order=groups[0].order, budget=max(one.budget for one in groups))


def points(counted: Outcomes) -> list[Point]:
    """The points of the paper's fits and correlation: shares of ended trials by dose and repetition."""
    found = []
    for dose, number in sorted(set(zip(counted.dose.tolist(), counted.repetition.tolist(), strict=True))):
        here = (counted.dose == dose) & (counted.repetition == number)
        n = int(here.sum())
        shares = (float(of[here].sum() / n) for of in (counted.solved, counted.looped))
        found.append(Point(dose, number, n, *shares))
    return found


def plays_alike(trials: Sequence[Trial]) -> bool:
    """Whether an agent is *blind*: it played each repetition and trial identically at every p though reports differed.

    Only reports that are followed by an action count, and at least :data:`REPORTS` of them are needed. People are never
    blind, because different people play each p.
    """
    if trials[0].player:
        return False
    first, differing = dict[tuple[int, int], Trial](), set[tuple[int, int, int]]()
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        if (other := first.setdefault(luck, trial)).actions != trial.actions:
            return False
        reports = enumerate(zip(other.steps[:-1], trial.steps, strict=False))
        differing |= {
            (*luck, i)
            for i, (one, two) in reports
            if (one.told_moved, one.told_state) != (two.told_moved, two.told_state)
        }
    return len(differing) >= REPORTS


def steps_changed(trials: Sequence[Trial]) -> Counter[str] | None:
    """Spec of every intervention -> the steps of ended trials that it changed; "" -> those that any of them changed.

    At such a step the agent was told, asked or remembered something else than without it, or another joint than the
    chosen one was attempted. None if some record does not say, or no trial has ended.
    """
    counted = ended(trials)
    if len({tuple(trial.changed) for trial in counted}) != 1:
        return None
    found = Counter({"": sum(trial.changed_steps for trial in counted)})
    for trial in counted:
        found.update(trial.changed)
    return found


def never_acted(trials: Sequence[Trial]) -> bool:
    """Whether interventions of a condition changed nothing, or it has a flip rate above 0 and no report was false."""
    found, steps = steps_changed(trials), [step for trial in ended(trials) for step in trial.steps]
    if not found or len(found) == 1 or not steps:
        return False
    return not found[""] or (bool(trials[0].p) and not any(step.told_falsely for step in steps))


def idle_interventions(trials: Sequence[Trial], acting: Sequence[str]) -> list[str]:
    """What changed nothing: "" for the condition as a whole, or some of its interventions that should act."""
    found = steps_changed(trials)
    if not found or len(found) == 1 or not any(trial.steps for trial in ended(trials)):
        return []
    if not found[""] and not any(spec_name(spec) == PLANT for spec in acting):
        return [""]
    return [spec for spec in acting if found.get(spec) == 0]
