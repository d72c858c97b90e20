"""Differences in success between agents of several studies, condition by condition.

Studies of one seed share their luck: trials of equal repetition and number are compared in pairs. Studies of different
seeds are independent samples without pairs. Intervals are at 95 %; P values are corrected (Holm) for the number of
differences of one kind under the conditions of one family.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.crossed_clusters import people_of
from lockprobe.statistics.agent_comparison.pair import paired_difference
from lockprobe.statistics.agent_comparison.paired import sheets
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
    """One side of a comparison: an agent of one study, with its prompt.

    Attributes:
        study: Number of the study, from 0.
        agent: Its name, or its spec if it has none.
        prompt: File of its prompt; empty for the default prompt.
    """

    study: int
    agent: str
    prompt: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """The trials of one side under one condition.

    Attributes:
        side: The agent that played them.
        condition: Name of the condition, equal in all studies that have it.
        luck: Seed of the study: trials of equal luck, repetition and number share labels, flips and draws.
        baseline: Whether the agent is a baseline.
        trials: All trials played. Trials that ended as error are counted in ``broken``.
        family: Family of the condition: the axis on which it lies; empty for all conditions on none.
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
        condition: Name of the condition.
        kind: P values are corrected within a kind and a family.
        first: The reference side.
        second: The other side.
        paired: Whether trials of equal luck are compared in pairs; otherwise the samples are independent.
        first_success: Share of the compared trials that the first side solved.
        second_success: Share of the compared trials that the second side solved.
        value: Second share minus first share, [-1, 1].
        low, high: Ends of the 95 % interval, not corrected: Agresti & Min's for pairs, Newcombe's for independent
            samples, clustered by person where people are on one side. Where trials broke, it holds whatever became of
            them.
        p_value: McNemar's exact test for pairs, Fisher's for independent samples, two-sided; with people by person.
            Where trials broke, the larger of both ends, and 1 if the signs differ.
        broken: Trials of either side that ended as error.
        family: Family of the condition.
        p_adjusted: The P value corrected for the differences of its kind and family (Holm).
    """

    condition: str
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
    broken: int
    family: str = ""
    p_adjusted: float = 1.0

    @property
    def verdict(self) -> int:
        """1 if the second side is shown to solve the box more often, -1 if less often, else 0.

        The corrected test must reject, and the interval must exclude 0.
        """
        return int(np.sign(self.value)) if self.p_adjusted < ALPHA and (self.low > 0 or self.high < 0) else 0


@dataclass(frozen=True, slots=True)
class _PairEstimate:
    first: Proportion
    second: Proportion
    value: float
    low: float
    high: float
    p_value: float


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
            made = _difference(first, second, _kind(first, second, every_baseline=every_baseline))
            pairs.setdefault((first.side, second.side), []).extend(filter(None, [made]))
    found = [one for rows in pairs.values() for one in rows]
    corrected = holm_by_family([(one.kind, one.family) for one in found], [one.p_value for one in found])
    adjusted = [replace(one, p_adjusted=p) for one, p in zip(found, corrected, strict=True) if p is not None]
    return tuple(sorted(adjusted, key=lambda one: _KINDS.index(one.kind)))


def _kind(first: Sample, second: Sample, *, every_baseline: bool) -> Kind:
    plain = every_baseline or not (first.baseline or second.baseline)
    if first.side.study != second.side.study:
        return "between" if plain else "between-baselines"
    return "within" if plain else "within-baselines"


def _difference(first: Sample, second: Sample, kind: Kind) -> StudyDifference | None:
    one, two = outcomes(first.trials), outcomes(second.trials)
    shared = first.luck == second.luck and not (one.crossed and two.crossed)  # no two people play as a pair
    found = _estimate(one, two, shared=shared, same_luck=first.luck == second.luck)
    if found is None:
        return None
    broken = broken_off(first.trials), broken_off(second.trials)
    if any(map(len, broken)):
        low, high = opposed(
            lambda both: _estimate(*both, shared=shared, same_luck=first.luck == second.luck),
            (one, two),
            broken,
            (False, True),
        )
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


def _estimate(first: Outcomes, second: Outcomes, *, shared: bool, same_luck: bool) -> _PairEstimate | None:
    if not (len(first) and len(second)):
        return None
    if shared:
        return _paired(first, second)
    if first.crossed or second.crossed:
        return _clustered(first, second, same_luck=same_luck)
    shares = _share(first.solved), _share(second.solved)
    apart = difference(*shares)
    return None if apart is None else _PairEstimate(*shares, apart.value, apart.low, apart.high, apart.p_value)


def _paired(first: Outcomes, second: Outcomes) -> _PairEstimate | None:
    """The paired estimate, from trials of equal luck that both sides finished."""
    _, laid = sheets([replace(one, dose=np.zeros(len(one))) for one in (first, second)])
    one, two = laid
    both = ~np.isnan(one.solved[:, 0] - two.solved[:, 0])
    if not both.any():
        return None
    person = people_of((one, two))
    solved = one.solved[both, 0], two.solved[both, 0]
    found = paired_difference(*solved, None if person is None else person[both, 0])
    return _PairEstimate(
        _share(solved[0] > 0), _share(solved[1] > 0), found.value, found.low, found.high, found.p_value
    )


def _clustered(first: Outcomes, second: Outcomes, *, same_luck: bool) -> _PairEstimate:
    """The estimate from independent samples with people on at least one side, clustered by person and by luck."""
    people = [_person_clusters(one, side) for side, one in enumerate((first, second))]
    lucks = [
        [f"{0 if same_luck else side}/{place}" for place in _trial_names(one)]
        for side, one in enumerate((first, second))
    ]
    found = clustered_difference(
        np.concatenate([first.solved, second.solved]),
        np.repeat([False, True], [len(first), len(second)]),
        np.array(people[0] + people[1]),
        np.array(lucks[0] + lucks[1]),
    )
    return _PairEstimate(
        _share(first.solved), _share(second.solved), found.value, found.low, found.high, found.interval_p
    )


def _person_clusters(one: Outcomes, side: int) -> list[str]:
    """The cluster of each trial: its person, or for an agent the trial itself."""
    players = one.player.tolist() if one.crossed else [""] * len(one)
    return [f"{side}/{player or place}" for player, place in zip(players, _trial_names(one), strict=True)]


def _trial_names(one: Outcomes) -> list[str]:
    return [f"{r}/{t}" for r, t in zip(one.repetition.tolist(), one.trial.tolist(), strict=True)]


def _share(solved: NDArray[np.bool_]) -> Proportion:
    return proportion(int(solved.sum()), len(solved))
