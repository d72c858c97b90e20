"""Paired differences between two agents on trials of equal luck: mean, confidence interval and exchange test.

A *block* is one repetition and trial: its labels, flips and draws are the same at every p and for every agent. The
null hypothesis is that two agents *play exchangeably*: each is as likely to play a block as the other did. Then the
sign of a block's difference is random, whatever its trials have in common, so agents are exchanged within whole blocks.
Agents that are equally good on average need not play exchangeably: one may fail often in few blocks, the other seldom
in many. So a conclusion also needs the interval of the mean, which does not assume it, to leave out 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_quantile
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.paired_proportions import FEW, score_interval
from lockprobe.statistics.proportions import ALPHA, LEVEL
from lockprobe.statistics.rare_long_trials import RareBlock
from lockprobe.statistics.sequential.contrasts import Numbers, at_every_look

Array = NDArray[np.float64]

_EXACT = 50_000_000
"""Additions up to which the exchange distribution of a sum is exact; beyond, it is approximated as normal."""

_TIE = 1e-9
"""Sum of squared deviations of blocks below which all blocks count as equal, within rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """One agent's trials, a row for each block of luck and a column for each p; NaN where no trial has ended.

    Attributes:
        solved: 1 where the box was solved, else 0, shape (blocks, p).
        steps: Steps played, of the same shape; an unsolved trial has its whole budget.
        person: The person of each trial, empty text where there is no trial; no rows for an agent.
        order: The rows in the order in which blocks were planned, if what is said must hold at every look; else empty.
    """

    solved: Array
    steps: Array
    person: NDArray[np.str_] = field(default_factory=lambda: np.empty((0, 0), dtype=np.str_))
    order: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, dtype=np.int64))


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockMean:
    """A mean over pairs of trials with its clustered interval; clusters are blocks of luck.

    Attributes:
        value: The mean; NaN without pairs.
        low, high: Ends of the 95 % interval, wider where several means are looked at; None where it cannot be
            estimated.
        p_value: Exchange test that the two play exchangeably, two-sided; 1 if no block differs; None without pairs, and
            where the test would not keep its level.
        pairs: Pairs of trials.
        blocks: Blocks with at least one.
    """

    value: float
    low: float | None
    high: float | None
    p_value: float | None
    pairs: int
    blocks: int

    @property
    def clear(self) -> bool:
        """Whether there is an interval and it excludes 0."""
        return self.low is not None and self.high is not None and (self.low > 0 or self.high < 0)


def sheets(groups: list[Outcomes]) -> tuple[tuple[float, ...], list[Sheet]]:
    """The values of p, ascending, and a sheet for each agent, all with the same rows (blocks) and columns (p)."""
    values = np.unique(np.concatenate([group.dose for group in groups])) if groups else np.empty(0)
    lucks = sorted({luck for group in groups for luck in _lucks(group)})
    row = {luck: i for i, luck in enumerate(lucks)}
    # by the largest plan of an agent
    planned = max((one.order for one in groups if one.order), key=lambda one: one.plans[-1], default=None)
    made, order = [], np.empty(0, dtype=np.int64)
    if planned is not None and lucks:
        order = np.argsort(planned.rank(*zip(*lucks, strict=True)))
    for group in groups:
        place = np.array([row[luck] for luck in _lucks(group)], dtype=np.int64), np.searchsorted(values, group.dose)
        solved, steps = np.full((2, len(lucks), len(values)), math.nan)
        solved[place], steps[place] = group.solved, group.length
        person = np.full(solved.shape if group.crossed else (0, 0), "", dtype=group.player.dtype)
        if group.crossed:
            person[place] = group.player
        made.append(Sheet(solved=solved, steps=steps, person=person, order=order))
    return tuple(values.tolist()), made


def _lucks(group: Outcomes) -> list[tuple[int, int]]:
    return list(zip(group.repetition.tolist(), group.trial.tolist(), strict=True))


def block_mean(
    differences: Array, *, unit: float | None = None, choices: int = 1, rare: RareBlock | None = None
) -> BlockMean:
    """The mean of all differences, clustered by block.

    The interval is Student's over blocks, for a ratio of sums. With a unit, it is widened as if one more pair of each
    column differed, so that it has a width even if few pairs differ (as Agresti and Min 2005 for independent pairs). If
    all blocks differ alike, or none differs, a block counts as a single trial. Of shares with one pair a block, of
    which five or fewer differ, it also holds Tango's score interval.

    Of steps, it is widened by rare *blocks* instead (:mod:`lockprobe.statistics.rare_long_trials`).

    Args:
        differences: Shape (blocks, pairs of a block), NaN where a pair is missing.
        unit: The largest difference of a single trial, 1 for shares; None if it is not known.
        choices: Number of means examined (Bonferroni); the interval has the level 1 - 0.05 / choices.
        rare: Of steps, how far a rare block may lie from the mean.
    """
    present = ~np.isnan(differences)
    kept = present.any(axis=1)
    sizes = present.sum(axis=1)[kept].astype(np.float64)
    sums = np.where(present, differences, 0.0).sum(axis=1)[kept]
    n, pairs = len(sizes), int(sizes.sum())
    if not n:
        return BlockMean(value=math.nan, low=None, high=None, p_value=None, pairs=0, blocks=0)
    low, high = _interval(sums, sizes, unit, 1 - ALPHA / choices, rare)
    if low is not None and high is not None and unit == 1.0 and pairs == n:
        first, second = int(np.sum(sums < 0)), int(np.sum(sums > 0))
        if first + second <= FEW:  # few pairs differ: not narrower than Tango's
            ends = score_interval(first, second, len(sums), 1 - ALPHA / choices)
            low, high = min(low, ends[0]), max(high, ends[1])
    return BlockMean(
        value=float(sums.sum()) / pairs, low=low, high=high, p_value=sign_flip(sums), pairs=pairs, blocks=n
    )


def _interval(
    sums: Array, sizes: Array, unit: float | None, level: float, rare: RareBlock | None
) -> tuple[float, float] | tuple[None, None]:
    n, total = len(sizes), float(sizes.sum())
    if n < 2:
        return None, None
    value, widest = float(sums.sum()) / total, float(sizes.max())
    spread = float(np.sum((sums - value * sizes) ** 2))
    alike = spread < _TIE
    if alike and unit is None:
        return None, None
    if unit is not None and rare is None:
        spread += unit**2 * (widest**2 if alike else widest)
    se, most = math.sqrt(n / (n - 1) * spread) / total, math.inf if unit is None else unit
    if rare is None:
        half = half_width(se, n, level)
        return max(-most, value - half), min(most, value + half)
    low, high = rare.interval(value, se, n, share=widest / total, level=level)
    return max(-most, low), min(most, high)


def mean_at_every_look(differences: Array, *, bound: float = 1.0, agents: int = 1) -> BlockMean:
    """The mean of blocks, with an interval and a P value that hold at every look.

    A block counts once, whatever it holds: its value is the mean of its differences.

    Args:
        differences: One row for each block, in the order in which blocks were planned, NaN where there is none; shape
            (blocks, columns). Each lies within ``bound``.
        bound: The largest size that a difference can have.
        agents: Number of means that are judged together (Bonferroni).
    """
    (found,) = at_every_look([numbers_of(differences, bound)], agents=agents)
    return BlockMean(
        value=found.value,
        low=found.low,
        high=found.high,
        p_value=found.p_value if found.n else None,
        pairs=int(np.count_nonzero(~np.isnan(differences))),
        blocks=found.n,
    )


def numbers_of(differences: Array, bound: float = 1.0) -> Numbers:
    """The mean of each block that has a difference; see :func:`mean_at_every_look`."""
    played = np.flatnonzero(~np.isnan(differences).all(axis=1))
    return Numbers(values=np.nanmean(differences[played], axis=1), block=played, bound=bound)


def half_width(se: float, clusters: int, level: float = LEVEL) -> float:
    """Half the width of Student's interval for a standard error from at least two clusters; level in (0, 1)."""
    return student_quantile((1 + level) / 2, clusters - 1) * se


def by_cluster(values: Array, cluster: NDArray[np.int64]) -> Array:
    """Values of shape (trials,) as one row for each cluster (from 0), padded with NaN."""
    place = np.zeros(len(cluster), dtype=np.int64)
    order = np.argsort(cluster, kind="stable")
    sizes = np.bincount(cluster)
    place[order] = np.arange(len(cluster)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    rows = np.full((len(sizes), int(sizes.max(initial=0))), math.nan)
    rows[cluster, place] = values
    return rows


def sign_flip(sums: Array) -> float:
    """Exact two-sided P value of a sign-flip test that the sums have mean 0; one whole number per block.

    >>> sign_flip(np.array([1.0, 2.0, 3.0, 1.0, 1.0]))
    0.0625
    """
    sums = np.rint(sums)
    sizes = np.abs(sums[sums != 0]).astype(np.int64)
    if not len(sizes):
        return 1.0
    sizes //= np.gcd.reduce(sizes)
    total, observed = int(sizes.sum()), abs(float(sums.sum())) / float(np.abs(sums).sum())
    if total * len(sizes) > _EXACT:
        return math.erfc(observed * total / math.sqrt(2 * float(np.sum(sizes**2))))
    chance = np.zeros(total + 1)
    chance[0] = 1.0
    for size in sizes:  # of the sum of those with a plus
        chance[size:], chance[:size] = (chance[size:] + chance[:-size]) / 2, chance[:size] / 2
    away = np.abs(2 * np.arange(total + 1) - total)
    return min(1.0, float(chance[away >= observed * total - 0.5].sum()))
