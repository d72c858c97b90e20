"""The one contrast: a mean of differences over blocks of equal luck, with its interval and test.

A *block* is one repetition and trial: its labels, flips and draws are the same at every dose, under every condition and
for every agent. The null hypothesis is that two sides *play exchangeably*: each is as likely to play a block as the
other did. Then the sign of a block's difference is random, whatever its trials have in common, so sides are exchanged
within whole blocks. Sides that are equally good on average need not play exchangeably: one may fail often in few
blocks, the other seldom in many. So a conclusion also needs the interval of the mean, which does not assume it, to
leave out 0.

A person's boxes are correlated too, and lie in several blocks. So beside people neither blocks nor people are
exchangeable, and Student's t uses a variance clustered by both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.broken_trials import bounded, whatever_broke
from lockprobe.statistics.clustered import alike_weights, clustered_variance, student
from lockprobe.statistics.every_look import Numbers, at_every_look
from lockprobe.statistics.outcomes import BlockOrder, Outcomes
from lockprobe.statistics.pairs import FEW, mean_over_boxes, score_interval
from lockprobe.statistics.proportions import ALPHA, Difference
from lockprobe.trial.condition import Contrast

Array = NDArray[np.float64]
Labels = NDArray[Any]

FEWEST = 7
"""The fewest people, and the fewest blocks of luck, for a test: a variance from fewer is too uncertain."""

TIE = 1e-9
"""Sum of squared deviations below which all blocks count as equal, within rounding."""

_RARE_BLOCKS = 3
"""Blocks that are added to the variance of a mean of steps."""

RareBlock = tuple[float, float]
"""How far below and above a mean difference in steps a rare block may lie (:func:`rare_block`)."""

_EXACT = 50_000_000
"""Additions up to which the exchange distribution of a sum is exact; beyond, it is approximated as normal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Blocks:
    """Ended trials by block of luck (rows) and by group, such as a condition or an agent at a dose (columns).

    Attributes:
        solved, steps: Shape (blocks, groups), NaN where no trial has ended.
        person: Who played, of the same shape; no rows if nobody is people.
        box: The box of each block; no rows if all are of one.
        place: The place of each block in the order of the plan.
        order: That order, if what is said must hold at every look; else blocks are by repetition and trial.
    """

    solved: Array
    steps: Array
    person: NDArray[np.str_]
    box: NDArray[np.str_]
    place: NDArray[np.int64]
    order: BlockOrder | None

    def whole(self, groups: Sequence[int]) -> tuple[NDArray[np.bool_], NDArray[np.str_]]:
        """Success under some groups in the blocks that have a trial under all of them, and the boxes of these."""
        solved = self.solved[:, groups]
        both = ~np.isnan(solved).any(axis=1)
        return solved[both] > 0, self.box[both] if len(self.box) else self.box


def blocks_of(groups: Sequence[Outcomes]) -> Blocks:
    """The blocks of groups of ended trials, of which none has two of one luck."""
    width = 1 + max(int(one.trial.max(initial=0)) for one in groups)
    lucks, row = np.unique(np.concatenate([one.repetition * width + one.trial for one in groups]), return_inverse=True)
    n, place, row = len(lucks), np.arange(len(lucks)), row.reshape(-1)
    order = max((one.order for one in groups if one.order), key=lambda one: one.plans[-1], default=None)
    if order is not None:
        rank = order.rank(lucks // width, lucks % width)
        planned = np.argsort(rank)
        row, place = np.argsort(planned)[row], rank[planned]
    solved, steps = np.full((2, n, len(groups)), math.nan)
    box = np.full(n, "", dtype=np.result_type(*(one.box.dtype for one in groups)))
    people = [one.player.dtype for one in groups if one.crossed]
    person = np.full(solved.shape if people else (0, 0), "", dtype=np.result_type(*people, np.str_))
    for column, (one, at) in enumerate(zip(groups, np.split(row, np.cumsum([*map(len, groups)])[:-1]), strict=True)):
        solved[at, column], steps[at, column] = one.solved, one.length
        if len(one.box):
            box[at] = one.box
        if one.crossed:
            person[at, column] = one.player
    one_box = len(np.unique(box)) < 2
    return Blocks(solved=solved, steps=steps, person=person, box=box[:0] if one_box else box, place=place, order=order)


def contrast(groups: Mapping[str, Outcomes], asked: Contrast, *, scale: int = 1, choices: int = 1) -> Difference:
    """The mean success under the conditions of one side less that under those of the other, over blocks.

    It is of nothing if no block has a trial under all of them. The P value is from sign flips of whole blocks, or holds
    at every look. If trials broke, interval and P value hold whatever became of these.

    Args:
        groups: Condition -> its trials.
        asked: What is asked for.
        scale: By what the mean is multiplied: 2 for a difference of two differences.
        choices: So many means are judged together (Bonferroni).
    """
    more, less = asked.of, asked.minus
    column = np.array([len(less)] * len(more) + [-len(more)] * len(less), dtype=np.float64)
    most = len(more) * len(less)

    def mean(of: Sequence[Outcomes]) -> Difference:
        blocks = blocks_of(of)
        return mean_of_blocks(blocks.solved @ column[:, None], blocks, unit=most, factor=scale / most, choices=choices)

    return whatever_broke(mean, [groups[name] for name in (*more, *less)], list(column > 0))


def mean_of_blocks(
    differences: Array,
    blocks: Blocks | None = None,
    *,
    unit: float = 1.0,
    factor: float = 1.0,
    choices: int = 1,
    rare: RareBlock | None = None,
) -> Difference:
    """The mean of whole numbers times a factor, as it holds of blocks and of their boxes, or at every look.

    Interval and P value are corrected for ``choices`` means that are judged together. ``unit`` is the largest of the
    whole numbers, and the rest is as in :func:`block_mean`. At every look a block counts once, whatever it holds: its
    value is the mean of its differences.
    """
    numbers = factor * differences
    played = ~np.isnan(numbers).all(axis=1)
    if blocks is not None and blocks.order:
        values = Numbers(values=np.nanmean(numbers[played], axis=1), block=blocks.place[played], bound=factor * unit)
        (ever,) = at_every_look([values], agents=choices)
        pairs, p_value = int(np.count_nonzero(~np.isnan(numbers))), ever.p_value if ever.n else None
        return Difference(value=ever.value, low=ever.low, high=ever.high, p_value=p_value, n=pairs, clusters=ever.n)
    mean = block_mean(numbers, unit=factor * unit, choices=choices, rare=rare)
    if mean.n:
        mean = replace(mean, p_value=min(1.0, choices * sign_flip(np.nansum(differences, axis=1))))
    if blocks is None or not len(blocks.box):
        return mean
    return mean_over_boxes(mean, np.nanmean(numbers[played], axis=1), blocks.box[played], choices=choices)


def block_mean(differences: Array, *, unit: float = 1.0, choices: int = 1, rare: RareBlock | None = None) -> Difference:
    """The mean of all differences, clustered by block, with Student's P value if there are blocks enough.

    The interval is Student's over blocks, for a ratio of sums. It is widened as if one more pair of each column
    differed, so that it has a width even if few pairs differ (as Agresti and Min 2005 for independent pairs). If all
    blocks differ alike, or none differs, a block counts as a single trial. Of shares with one pair a block, of which
    five or fewer differ, it also holds Tango's score interval. Of steps, it is widened by rare *blocks* instead.

    Args:
        differences: Shape (blocks, pairs of a block), NaN where a pair is missing.
        unit: The largest difference of a single trial, 1 for shares.
        choices: Number of means examined (Bonferroni); the interval has the level 1 - 0.05 / choices.
        rare: Of steps, how far a rare block may lie from the mean.
    """
    present = ~np.isnan(differences)
    sizes = present.sum(axis=1).astype(np.float64)
    sums = np.where(present, differences, 0.0).sum(axis=1)[sizes > 0]
    sizes = sizes[sizes > 0]
    n, pairs = len(sizes), int(sizes.sum())
    if not n:
        return Difference(value=math.nan, n=0, clusters=0)
    value, small = float(sums.sum()) / pairs, n / max(1, n - 1)
    spread = small * float(np.sum((sums - value * sizes) ** 2))
    more = _more(spread, float(sizes.max()), pairs, unit, rare, small)
    found = Difference(value=value, n=pairs, clusters=n)
    found = student(found, spread / pairs**2, n, more=more, most=unit, choices=choices, fewest=FEWEST)
    first, second = int(np.sum(sums < 0)), int(np.sum(sums > 0))
    if found.low is None or found.high is None or unit != 1.0 or pairs != n or first + second > FEW:
        return found
    low, high = score_interval(first, second, n, 1 - ALPHA / choices)  # few pairs differ: not narrower than Tango's
    return replace(found, low=min(found.low, low), high=max(found.high, high))


def _more(
    spread: float, widest: float, pairs: int, unit: float, rare: RareBlock | None, small: float = 1.0
) -> tuple[float, float]:
    """What is added to the variance of a mean of so many pairs, below and above it.

    ``spread`` is the variance of their sum, ``widest`` the pairs of the largest cluster and ``small`` the factor of the
    widening in small samples; the rest is as in :func:`block_mean`.
    """
    if rare is not None:
        below, above = (_RARE_BLOCKS * (widest / pairs * away) ** 2 for away in rare)
        return below, above
    one = small * unit**2 * (widest**2 if spread < TIE else widest) / pairs**2
    return one, one


def rare_block(first: Array, second: Array, budget: float) -> RareBlock:
    """How far below and above the mean of the steps of the second less those of the first a rare block may lie.

    An agent that is mostly a little faster and now and then needs its whole budget is no faster, and a sample without
    such a trial has neither its mean nor its spread. So three more blocks are added to the variance, as Agresti and Min
    (2005) add pairs that differ to shares. In each, one of the two takes the whole budget, or as few steps as the
    shortest trial of both or a fifth of the budget, and the other what it takes on average, whichever is farther.

    Three are enough for every budget. Rare blocks have a Poisson distribution. A decrease is said after k of them if
    more than k + 1.96 sqrt(k + 3) were to be expected, and at most 5 % of samples have so few.
    """
    least = min(float(first.min()), float(second.min()), budget / 5)
    before, after = float(first.mean()), float(second.mean())
    return max(budget - after, before - least, 1.0), max(budget - before, after - least, 1.0)


def two_way(
    value: float,
    residuals: Array,
    luck: Labels,
    person: Labels,
    *,
    pairs: int,
    unit: float,
    most: float,
    rare: RareBlock | None = None,
    choices: int = 1,
) -> Difference:
    """A mean of so many pairs, clustered by luck and by person, with a t-test; no P value with too few of either.

    The residuals are what each trial adds to the sum of the pairs, less its expectation, shape (trials,). ``most`` is
    the largest mean; other arguments are those of :func:`block_mean`.
    """
    sizes = [np.unique(of, return_counts=True)[1] for of in (luck, person)]
    found = Difference(value=value, n=pairs, clusters=len(sizes[0]))
    fewest, widest = min(map(len, sizes)), float(max(of.max() for of in sizes))
    if fewest < 2:
        return found
    spread = clustered_variance(residuals, luck, person)
    more = _more(spread, widest, pairs, unit, rare)
    return student(found, spread / pairs**2, fewest, more=more, most=most, choices=choices, fewest=FEWEST)


def crossed_mean(
    values: Array, luck: Labels, person: Labels, *, unit: float, rare: RareBlock | None = None
) -> Difference:
    """The mean of trials, clustered by luck and by person, with a t-test of mean 0.

    If people have unequally many trials, a conclusion must hold with every trial and with every person counted alike
    (:func:`lockprobe.statistics.clustered.clustered_proportion`).
    """

    def weighted(weight: Array) -> Difference:
        mean = float((weight * values).mean())
        rest = weight * (values - mean)
        return two_way(mean, rest, luck, person, pairs=len(values), unit=unit, most=unit, rare=rare)

    pooled = weighted(np.ones(len(values)))
    return bounded(pooled, pooled, weighted(alike_weights(person)))


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
