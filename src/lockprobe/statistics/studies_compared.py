"""Differences in success between agents of several studies, condition by condition.

Studies of one seed share their luck: trials of equal repetition and number are compared in pairs. Studies of different
seeds are independent samples without pairs. Intervals are at 95 %; P values are corrected (Holm) for the number of
differences of one kind under the conditions of one family.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from lockprobe.statistics.blocks import blocks_of, success_in_pairs
from lockprobe.statistics.broken_trials import bounded, whatever_broke
from lockprobe.statistics.clustered import clustered_difference, share_of
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.distributions import holm_by_family
from lockprobe.statistics.outcomes import Outcomes, joined, outcomes
from lockprobe.statistics.proportions import ALPHA, Difference, Proportion, between, difference, proportion
from lockprobe.trial.record import Trial

_KINDS = ("between", "between-baselines", "within", "within-baselines")
"""Whether two sides belong to different studies or to one, and whether one of them is a baseline."""


class Side(NamedTuple):
    """One side of a comparison; ``prompt`` is the file of the agent's prompt, if any."""

    study: str
    agent: str
    prompt: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """The trials of one side under one condition.

    Attributes:
        condition: Its name, equal in all studies that have it.
        luck: Seed of the study: trials of equal luck, repetition and number share labels, flips and draws.
        trials: All trials played, broken ones too.
        family: The axis on which the condition lies; empty for all conditions on none.
    """

    side: Side
    condition: str
    luck: int
    trials: Sequence[Trial]
    family: str = ""

    @property
    def baseline(self) -> bool:
        """Whether the agent is a baseline."""
        return bool(self.trials) and is_baseline(self.trials[0].spec)

    @property
    def success(self) -> Proportion:
        """The share solved, with an interval that holds whatever became of broken trials."""
        every = outcomes(self.trials)
        return share_of(every.known, every.player, every.luck, every.box)


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyDifference:
    """The difference in success between two sides under one condition, second minus first.

    Attributes:
        paired: Whether trials of equal luck are compared in pairs; otherwise the samples are independent.
        first_success, second_success: Shares of the compared trials that each side solved.
        low, high: Ends of the 95 % interval, not corrected: Agresti & Min's for pairs, Newcombe's for independent
            samples, clustered by person where people are on one side. Where trials broke, it holds whatever became of
            them.
        p_value: McNemar's exact test for pairs, Fisher's for independent samples, two-sided; with people by person.
            Where trials broke, the larger of both ends, and 1 if the signs differ.
        p_adjusted: The P value corrected for the differences of its kind and family (Holm).
        broken: Trials of either side that ended as error.
    """

    condition: str
    family: str = ""
    kind: str
    first: Side
    second: Side
    paired: bool
    first_success: Proportion
    second_success: Proportion
    value: float
    low: float | None
    high: float | None
    p_value: float | None
    p_adjusted: float = 1.0
    broken: int

    @property
    def detected(self) -> bool:
        """Whether one of the two is shown to solve the box more often: corrected test and interval must agree."""
        clear = self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)
        return self.p_adjusted < ALPHA and clear


def study_differences(samples: Sequence[Sample]) -> tuple[StudyDifference, ...]:
    """Pairwise differences of the samples of each condition, corrected within each kind and family (Holm).

    They come by kind (differences between studies first), pair and condition. Pairs without a trial to compare are left
    out. Each side is at most once per condition; the order decides which side of a pair comes first.
    """
    every_baseline = all(one.baseline for one in samples)
    pairs: dict[tuple[Side, Side], list[StudyDifference]] = {}
    for first, second in combinations(samples, 2):
        if first.condition == second.condition:
            beside = not every_baseline and (first.baseline or second.baseline)
            kind = _KINDS[2 * (first.side.study == second.side.study) + beside]
            if found := _difference(first, second, kind):
                pairs.setdefault((first.side, second.side), []).append(found)
    every = [one for rows in pairs.values() for one in rows]
    corrected = holm_by_family([(one.kind, one.family) for one in every], [one.p_value for one in every])
    adjusted = [replace(one, p_adjusted=p) for one, p in zip(every, corrected, strict=True) if p is not None]
    return tuple(sorted(adjusted, key=lambda one: _KINDS.index(one.kind)))


def _difference(first: Sample, second: Sample, kind: str) -> StudyDifference | None:
    """The difference, in pairs of trials that both finished if luck is shared; None without a trial to compare."""
    groups = [outcomes(one.trials) for one in (first, second)]
    broken = sum(len(one.broken) for one in groups)
    ended, same_luck = [one.ended for one in groups], first.luck == second.luck
    paired = same_luck and not all(one.crossed for one in groups)  # no two people play as a pair
    if not all(map(len, ended)) or (paired and not len(blocks_of(ended).whole([0, 1])[0])):
        return None

    def of(groups: Sequence[Outcomes]) -> StudyDifference:
        blocks = blocks_of(groups)
        solved = blocks.whole([0, 1])[0].T if paired else [one.solved for one in groups]
        apart = success_in_pairs(blocks, 0, 1) if paired else _independent(groups, same_luck=same_luck)
        before, after = (proportion(int(one.sum()), len(one)) for one in solved)
        return StudyDifference(
            condition=first.condition, family=first.family, kind=kind, first=first.side, second=second.side,
            paired=paired, first_success=before, second_success=after, value=apart.value, low=apart.low,
            high=apart.high, p_value=apart.p_value, broken=broken,
        )  # fmt: skip

    def held(found: StudyDifference, low: StudyDifference, high: StudyDifference) -> StudyDifference:
        return replace(
            bounded(found, low, high),
            first_success=between(found.first_success, high.first_success, low.first_success),
            second_success=between(found.second_success, low.second_success, high.second_success),
        )

    return whatever_broke(of, groups, (False, True), held)


def _independent(groups: Sequence[Outcomes], *, same_luck: bool) -> Difference:
    """The difference of two samples without pairs, clustered by person where people are on one side."""
    before, after = (proportion(int(one.solved.sum()), len(one)) for one in groups)
    apart = difference(before, after)
    if apart is not None and not any(group.crossed for group in groups):
        return apart
    together = joined(groups)
    later = together.dose == 1
    luck = together.luck + later * (0 if same_luck else len(together))
    alone = np.char.add("/", luck.astype(np.str_))  # an agent's trial is a cluster of its own
    people = np.char.add(later.astype(np.str_), np.where(together.player == "", alone, together.player))
    return clustered_difference(together.solved, later, people, luck)
