"""The ended trials of one agent as columns with clusters, and its repetitions as points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import repeat
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics import loops
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.trial.record import Trial

REPORTS = 10
"""Fewest differing reports, each with an action after it, for an agent that plays alike to be called blind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcomes:
    """Trials that ended as solved or out of budget, one row each. Every column has the shape (trials,).

    Attributes:
        dose: The dose on the axis of the analysis: flip probability, [0, 1], or another.
        repetition: From 1.
        trial: From 1. Trials of equal repetition and trial share their luck (labels, flips, draws) over all p.
        length: Steps played.
        solved: Whether the target moved.
        onset: The step at which the first action loop was complete, from 1; 0 if the trial holds none.
        box: The name of its box; no rows where it is not known.
        player: :attr:`lockprobe.trial.record.Trial.player` of each; no rows where every trial stands alone.
        order: The order of the blocks, if what is said of the trials must hold at every look; None if at one alone.
    """

    dose: NDArray[np.float64]
    repetition: NDArray[np.int64]
    trial: NDArray[np.int64]
    length: NDArray[np.int64]
    solved: NDArray[np.bool_]
    onset: NDArray[np.int64]
    box: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, dtype=np.str_))
    player: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, dtype=np.str_))
    order: BlockOrder | None = None

    def __len__(self) -> int:
        return len(self.dose)

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
        """The block of luck of each trial, from 0: equal repetition and trial, whatever p is, shape (trials,)."""
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
        columns = {name: getattr(self, name) for name in _COLUMNS}
        kept = {name: column[chosen] if len(column) else column for name, column in columns.items()}
        return Outcomes(**kept, order=self.order)


_COLUMNS = tuple(name for name in Outcomes.__slots__ if name != "order")


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


def onset(trial: Trial) -> int:
    """The step at which the trial's first action loop was complete, from 1; 0 if it holds none."""
    return _onset(trial.actions)


def numbered(trial: Trial) -> tuple[int, ...]:
    """The actions numbered in order of first use: loops do not depend on names, so equal shapes share a cache entry."""
    first: dict[str, int] = {}
    return tuple(first.setdefault(joint, len(first)) for joint in trial.actions)


_onset = lru_cache(maxsize=1 << 17)(loops.onset)


def outcomes(
    trials: Iterable[Trial],
    doses: Iterable[float] | None = None,
    order: BlockOrder | None = None,
    *,
    broken: bool = False,
) -> Outcomes:
    """The columns of one agent's ended trials, or of those that ended as error, up to the error.

    ``doses`` are their doses on an axis; their flip rates if not given, 0 where other interventions acted.
    """
    numbers, names = list[tuple[float, ...]](), list[tuple[str, str]]()
    for trial, dose in zip(trials, repeat(None) if doses is None else doses, strict=doses is not None):
        if (trial.ending == "error") == broken:
            at = (trial.p or 0.0) if dose is None else dose
            numbers.append((at, trial.repetition, trial.trial, len(trial.steps), trial.solved, onset(trial)))
            names.append((trial.box, trial.player))
    dose_, repetition, number, length, solved, first = np.array(numbers, dtype=np.float64).reshape(-1, 6).T
    box, player = np.array(names, dtype=np.str_).reshape(-1, 2).T
    return Outcomes(
        dose=dose_,
        repetition=repetition.astype(np.int64),
        trial=number.astype(np.int64),
        length=length.astype(np.int64),
        solved=solved > 0,
        onset=first.astype(np.int64),
        box=box,
        player=player if (player != "").any() else player[:0],
        order=order,
    )


broken_off = partial(outcomes, broken=True)
"""The columns of the trials that ended as error."""


def appended(first: Outcomes, second: Outcomes) -> Outcomes:
    """Two groups of trials of one agent, concatenated."""
    if not len(first) or not len(second):
        return first if len(first) else second
    return _stacked([first, second])


def joined(groups: Sequence[Outcomes]) -> Outcomes:
    """Several groups of trials, concatenated, with the number of the group (from 0) as their dose."""
    crossed = any(group.crossed for group in groups)
    return _stacked(
        [
            replace(
                group,
                dose=np.full(len(group), float(i)),
                player=np.full(len(group), "") if crossed and not group.crossed else group.player,
            )
            for i, group in enumerate(groups)
        ]
    )


def _stacked(groups: Sequence[Outcomes]) -> Outcomes:
    columns = {name: np.concatenate([getattr(one, name) for one in groups]) for name in _COLUMNS}
    return Outcomes(**columns, order=groups[0].order)


def with_players_of(other: Outcomes, group: Outcomes) -> Outcomes:
    """An agent's trials at one dose, each in the cluster of the person, if any, who met the same luck there.

    They are returned unchanged if they have players, or ``other``, the trials of people, has none.
    """
    if group.crossed or not other.crossed:
        return group
    played = dict(zip(_lucks(other), other.player.tolist(), strict=True))
    return replace(group, player=np.array([played.get(luck, "") for luck in _lucks(group)], dtype=np.str_))


def solved_in_pairs(first: Outcomes, second: Outcomes) -> NDArray[np.bool_]:
    """Whether trials of equal luck were solved under each of two conditions, shape (pairs, 2), by luck."""
    one, two = (dict(zip(_lucks(group), group.solved.tolist(), strict=True)) for group in (first, second))
    both = sorted(one.keys() & two.keys())
    return np.array([[one[luck], two[luck]] for luck in both], dtype=np.bool_).reshape(-1, 2)


def boxes_of_all(groups: Sequence[Outcomes]) -> NDArray[np.str_]:
    """The box of each block of luck that any group has, by repetition and trial; no rows if all trials are of one."""
    known = {luck: box for group in groups for luck, box in zip(_lucks(group), group.box.tolist(), strict=False)}
    names = [known[luck] for luck in sorted(known)]
    return np.array(names if len({*names}) > 1 else [], dtype=np.str_)


def boxes_of_blocks(first: Outcomes, *others: Outcomes) -> NDArray[np.str_]:
    """The box of each block of luck that all groups have, by repetition and trial; no rows if all trials are of one."""
    if len(np.unique(first.box)) < 2:
        return np.empty(0, dtype=np.str_)
    known = dict(zip(_lucks(first), first.box.tolist(), strict=True))
    both = set(known).intersection(*map(_lucks, others))
    return np.array([known[luck] for luck in sorted(both)], dtype=np.str_)


def _lucks(group: Outcomes) -> list[tuple[int, int]]:
    return list(zip(group.repetition.tolist(), group.trial.tolist(), strict=True))


def points(counted: Outcomes) -> list[Point]:
    """The points of the paper's fits and correlation: shares by dose and repetition."""
    found = []
    for dose, number in sorted(set(zip(counted.dose.tolist(), counted.repetition.tolist(), strict=True))):
        here = (counted.dose == dose) & (counted.repetition == number)
        n = int(here.sum())
        found.append(
            Point(dose, number, n, float(counted.solved[here].sum() / n), float(counted.looped[here].sum() / n))
        )
    return found


def heeded_at_most(trials: Sequence[Trial]) -> float | None:
    """Upper 95 % bound of the share of reports that a blind agent acts on, (0, 1); None if it is not blind.

    An agent is *blind* if it played each repetition and trial identically at every p though reports differed. Only
    reports that are followed by an action count, and at least :data:`REPORTS` of them are needed. People are never
    blind, because different people play each p.

    The bound is that of Clopper and Pearson for none of n blocks, those in which reports differed. It also holds if the
    agent heeds all reports of some trials and none of the others.
    """
    if trials[0].player:
        return None
    first, differing = dict[tuple[int, int], Trial](), dict[tuple[int, int], set[int]]()
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        if (other := first.setdefault(luck, trial)).actions != trial.actions:
            return None
        reports = enumerate(zip(other.steps[:-1], trial.steps, strict=False))
        differing.setdefault(luck, set()).update(
            i for i, (one, two) in reports if (one.told_moved, one.told_state) != (two.told_moved, two.told_state)
        )
    if sum(map(len, differing.values())) < REPORTS:
        return None
    return float(1 - ALPHA ** (1 / sum(map(bool, differing.values()))))
