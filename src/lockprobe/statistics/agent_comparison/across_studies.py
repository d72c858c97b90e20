"""Differences in success between agents of several studies, condition by condition.

Studies of one seed share their luck: trials of equal repetition and number are compared in pairs. Studies of different
seeds are independent samples without pairs. Intervals are at 95 %; P values are corrected (Holm) for the number of
differences of one kind under the conditions of one family.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import paired_success, people_of, sheets
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.clustered import clustered_difference
from lockprobe.statistics.inference.holm import holm_by_family
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA, Proportion, between, difference, proportion
from lockprobe.trial.record import Trial

Kind = Literal["between", "between-baselines", "within", "within-baselines"]
"""Whether two sides belong to different studies or to one, and whether one of them is a baseline."""

_KINDS: tuple[Kind, ...] = ("between", "between-baselines", "within", "within-baselines")


class Side(NamedTuple):
    """One side of a comparison: an agent of one study (by its number, from 0), with the file of its prompt, if any."""

    study: int
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
    baseline: bool
    trials: Sequence[Trial]
    family: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyDifference:
    """The difference in success between two sides under one condition, second minus first.

    Attributes:
        kind: P values are corrected within a kind and a family.
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
    kind: Kind
    first: Side
    second: Side
    paired: bool
    first_success: Proportion
    second_success: Proportion
    value: float
    low: float
    high: float
    p_value: float
    p_adjusted: float = 1.0
    broken: int

    @property
    def verdict(self) -> int:
        """1 if the second side is shown to solve the box more often, -1 if less often, else 0.

        The corrected test must reject, and the interval must exclude 0.
        """
        return int(np.sign(self.value)) if self.p_adjusted < ALPHA and (self.low > 0 or self.high < 0) else 0


def study_differences(samples: Sequence[Sample]) -> tuple[StudyDifference, ...]:
    """Pairwise differences of the samples of each condition, corrected within each kind and family (Holm).

    Args:
        samples: Each side at most once per condition; the order decides which side of a pair comes first.

    Returns:
        By kind (differences between studies first), pair and condition. Pairs without a trial to compare are left out.
    """
    every_baseline = all(one.baseline for one in samples)
    pairs: dict[tuple[Side, Side], list[StudyDifference]] = {}
    for first, second in combinations(samples, 2):
        if first.condition == second.condition:
            beside = not every_baseline and (first.baseline or second.baseline)
            kind = _KINDS[2 * (first.side.study == second.side.study) + beside]
            pairs.setdefault((first.side, second.side), []).extend(filter(None, [_difference(first, second, kind)]))
    found = [one for rows in pairs.values() for one in rows]
    corrected = holm_by_family([(one.kind, one.family) for one in found], [one.p_value for one in found])
    adjusted = [replace(one, p_adjusted=p) for one, p in zip(found, corrected, strict=True) if p is not None]
    return tuple(sorted(adjusted, key=lambda one: _KINDS.index(one.kind)))


@dataclass(frozen=True, slots=True)
class _Estimate:
    first: Proportion
    second: Proportion
    value: float
    low: float
    high: float
    p_value: float


def _difference(first: Sample, second: Sample, kind: Kind) -> StudyDifference | None:
    ended = [outcomes(one.trials) for one in (first, second)]
    broken = [broken_off(one.trials) for one in (first, second)]
    same_luck = first.luck == second.luck
    shared = same_luck and not all(one.crossed for one in ended)  # no two people play as a pair
    estimate = partial(_estimate, shared=shared, same_luck=same_luck)
    found = estimate(ended)
    if found is None:
        return None
    if any(map(len, broken)):
        low, high = opposed(estimate, ended, broken, (False, True))
        assert low is not None
        assert high is not None
        found = replace(
            bounded(found, low, high),
            first=between(found.first, high.first, low.first),
            second=between(found.second, low.second, high.second),
        )
    return StudyDifference(
        condition=first.condition,
        family=first.family,
        kind=kind,
        first=first.side,
        second=second.side,
        paired=shared,
        first_success=found.first,
        second_success=found.second,
        value=found.value,
        low=found.low,
        high=found.high,
        p_value=found.p_value,
        broken=sum(map(len, broken)),
    )


def _estimate(groups: Sequence[Outcomes], *, shared: bool, same_luck: bool) -> _Estimate | None:
    """The difference, in pairs of trials that both finished if luck is shared; None without a trial to compare."""
    first, second = groups
    if not (len(first) and len(second)):
        return None
    shares = _share(first.solved), _share(second.solved)
    if shared:
        _, (one, two) = sheets([replace(group, dose=np.zeros(len(group))) for group in groups])
        both = ~np.isnan(one.solved[:, 0] - two.solved[:, 0])
        if not both.any():
            return None
        person, before, after = people_of(one, two), one.solved[both, 0], two.solved[both, 0]
        apart = paired_success(before, after, None if person is None else person[both, 0])
        shares = _share(before > 0), _share(after > 0)
        assert apart.low is not None
        assert apart.high is not None
        assert apart.p_value is not None
        return _Estimate(*shares, apart.value, apart.low, apart.high, apart.p_value)
    if not (first.crossed or second.crossed):
        plain = difference(*shares)
        return None if plain is None else _Estimate(*shares, plain.value, plain.low, plain.high, plain.p_value)
    names = [[f"{r}/{t}" for r, t in zip(one.repetition.tolist(), one.trial.tolist(), strict=True)] for one in groups]
    people = [
        f"{side}/{player or name}"  # an agent's trial is a cluster of its own
        for side, (one, own) in enumerate(zip(groups, names, strict=True))
        for player, name in zip(one.player.tolist() if one.crossed else [""] * len(one), own, strict=True)
    ]
    lucks = [f"{0 if same_luck else side}/{name}" for side, own in enumerate(names) for name in own]
    later = np.repeat([False, True], [len(first), len(second)])
    found = clustered_difference(
        np.concatenate([first.solved, second.solved]), later, np.array(people), np.array(lucks)
    )
    return _Estimate(*shares, found.value, found.low, found.high, found.interval_p)


def _share(solved: NDArray[np.bool_]) -> Proportion:
    return proportion(int(solved.sum()), len(solved))
