"""The one contrast of agents: a mean of paired differences over blocks of equal luck, with its interval and test.

A *block* is one repetition and trial: its labels, flips and draws are the same at every dose and for every agent. The
null hypothesis is that two agents *play exchangeably*: each is as likely to play a block as the other did. Then the
sign of a block's difference is random, whatever its trials have in common, so agents are exchanged within whole blocks.
Agents that are equally good on average need not play exchangeably: one may fail often in few blocks, the other seldom
in many. So a conclusion also needs the interval of the mean, which does not assume it, to leave out 0.

A person's boxes are correlated too, and lie in several blocks. So beside people neither blocks nor people are
exchangeable, and Student's t uses a variance clustered by both. At a single dose no two people share a luck, so whole
people are exchanged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.boxes import mean_over_boxes
from lockprobe.statistics.clustered import alike_weights, two_way_variance
from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.inference.mean_steps import RareBlock
from lockprobe.statistics.outcomes import Outcomes, boxes_of_all
from lockprobe.statistics.paired_proportions import FEW, difference_over_boxes, paired, pairs_by_box, score_interval
from lockprobe.statistics.proportions import ALPHA, Difference
from lockprobe.statistics.sequential.contrasts import Numbers, at_every_look

Array = NDArray[np.float64]
Labels = NDArray[Any]

FEWEST = 7
"""The fewest people, and the fewest blocks of luck, for a test: a variance from fewer is too uncertain."""

_EXACT = 50_000_000
"""Additions up to which the exchange distribution of a sum is exact; beyond, it is approximated as normal."""

TIE = 1e-9
"""Sum of squared deviations below which all blocks count as equal, within rounding."""


class Sheet(NamedTuple):
    """One agent's trials, shape (blocks of luck, doses); NaN where no trial has ended.

    ``person`` has no rows for an agent that is no people. ``planned`` says that the blocks are in the order of the
    plan, and that what is said must hold at every look; else they are by repetition and trial. ``box`` has the box of
    each block, and no rows if all are of one.
    """

    solved: Array
    steps: Array
    person: NDArray[np.str_]
    planned: bool
    box: NDArray[np.str_]


def sheets(groups: Sequence[Outcomes]) -> tuple[tuple[float, ...], list[Sheet]]:
    """The doses, ascending, and a sheet for each agent, all with the same rows (blocks) and columns (doses)."""
    values = np.unique(np.concatenate([group.dose for group in groups])) if groups else np.empty(0)
    own = [list(zip(group.repetition.tolist(), group.trial.tolist(), strict=True)) for group in groups]
    lucks = sorted({luck for group in own for luck in group})
    known = dict(zip(lucks, boxes_of_all(groups).tolist(), strict=False))  # none where all are of one box
    # by the largest plan of an agent
    order = max((one.order for one in groups if one.order), key=lambda one: one.plans[-1], default=None)
    if order is not None:
        lucks.sort(key=lambda luck: int(order.rank(*luck)))
    row, made = {luck: i for i, luck in enumerate(lucks)}, []
    box = np.array([known[luck] for luck in lucks] if known else [], dtype=np.str_)
    for group, played in zip(groups, own, strict=True):
        place = np.array([row[luck] for luck in played], dtype=np.int64), np.searchsorted(values, group.dose)
        solved, steps = np.full((2, len(lucks), len(values)), math.nan)
        solved[place], steps[place] = group.solved, group.length
        person = np.full(solved.shape if group.crossed else (0, 0), "", dtype=group.player.dtype)
        if group.crossed:
            person[place] = group.player
        made.append(Sheet(solved, steps, person, planned=order is not None, box=box))
    return tuple(values.tolist()), made


def columns(groups: Sequence[Outcomes]) -> list[Sheet]:
    """A sheet of a single column for each group of trials, whatever their doses, all with the same rows (blocks)."""
    return sheets([replace(group, dose=np.zeros(len(group))) for group in groups])[1]


def people_of(*laid: Sheet) -> Labels | None:
    """The person of each trial, shape (blocks, doses); None if no agent is people."""
    return next((sheet.person for sheet in laid if sheet.person.size), None)


def block_mean(
    differences: Array,
    *,
    unit: float | None = None,
    choices: int = 1,
    rare: RareBlock | None = None,
    exchange: bool = True,
) -> Difference:
    """The mean of all differences, clustered by block, with a test that exchanges the two within whole blocks.

    The interval is Student's over blocks, for a ratio of sums. With a unit, it is widened as if one more pair of each
    column differed, so that it has a width even if few pairs differ (as Agresti and Min 2005 for independent pairs). If
    all blocks differ alike, or none differs, a block counts as a single trial. Of shares with one pair a block, of
    which five or fewer differ, it also holds Tango's score interval.

    Of steps, it is widened by rare *blocks* instead (:mod:`lockprobe.statistics.inference.mean_steps`).

    Args:
        differences: Shape (blocks, pairs of a block), NaN where a pair is missing.
        unit: The largest difference of a single trial, 1 for shares; None if it is not known.
        choices: Number of means examined (Bonferroni); the interval has the level 1 - 0.05 / choices.
        rare: Of steps, how far a rare block may lie from the mean.
        exchange: Whether it is tested so; else by Student's t, if there are blocks enough.
    """
    present = ~np.isnan(differences)
    sizes = present.sum(axis=1).astype(np.float64)
    sums = np.where(present, differences, 0.0).sum(axis=1)[sizes > 0]
    sizes = sizes[sizes > 0]
    n, pairs = len(sizes), int(sizes.sum())
    if not n:
        return Difference(value=math.nan, n=0, clusters=0)
    value = float(sums.sum()) / pairs
    found = Difference(value=value, p_value=sign_flip(sums) if exchange else None, n=pairs, clusters=n)
    spread = n / (n - 1) * float(np.sum((sums - value * sizes) ** 2)) if n > 1 else 0.0
    if unit is None and spread < TIE:
        return found
    widest, small = float(sizes.max()), n / max(1, n - 1)
    found = _student(found, spread, widest, n, unit=unit, most=unit, rare=rare, choices=choices, small=small)
    if found.low is None or found.high is None or unit != 1.0 or pairs != n:
        return found
    first, second = int(np.sum(sums < 0)), int(np.sum(sums > 0))
    if first + second > FEW:
        return found
    low, high = score_interval(first, second, n, 1 - ALPHA / choices)  # few pairs differ: not narrower than Tango's
    return replace(found, low=min(found.low, low), high=max(found.high, high))


def mean_of_blocks(
    differences: Array,
    box: NDArray[np.str_],
    *,
    planned: bool,
    unit: float = 1.0,
    factor: float = 1.0,
    choices: int = 1,
    rare: RareBlock | None = None,
) -> Difference:
    """The mean of whole numbers times a factor, as it holds of blocks and of their boxes, or at every look.

    Interval and P value are corrected for ``choices`` means that are judged together. ``unit`` is the largest of the
    whole numbers, ``box`` and ``planned`` are those of :class:`Sheet`, and the rest is as in :func:`block_mean`. At
    every look a block counts once, whatever it holds: its value is the mean of its differences.
    """
    numbers = factor * differences
    if planned:
        (ever,) = at_every_look([numbers_of(numbers, factor * unit)], agents=choices)
        pairs, p_value = int(np.count_nonzero(~np.isnan(numbers))), ever.p_value if ever.n else None
        return Difference(value=ever.value, low=ever.low, high=ever.high, p_value=p_value, n=pairs, clusters=ever.n)
    mean = block_mean(numbers, unit=factor * unit, choices=choices, rare=rare, exchange=False)
    if mean.n:
        mean = replace(mean, p_value=min(1.0, choices * sign_flip(np.nansum(differences, axis=1))))
    return over_boxes(mean, numbers, box, choices)


def over_boxes(mean: Difference, differences: Array, box: NDArray[np.str_], choices: int) -> Difference:
    """The mean of blocks, of which some may lack every pair, as it holds over their boxes."""
    if not len(box):
        return mean
    rows = ~np.isnan(differences).all(axis=1)
    return mean_over_boxes(mean, np.nanmean(differences[rows], axis=1), box[rows], choices=choices)


def _student(
    found: Difference,
    spread: float,
    widest: float,
    clusters: int,
    *,
    unit: float | None,
    most: float | None,
    rare: RareBlock | None,
    choices: int,
    small: float = 1.0,
) -> Difference:
    """The mean with Student's interval, and with Student's P value if it has none and there are clusters enough.

    ``spread`` is the variance of the sum of its pairs, ``widest`` the pairs of the largest cluster, ``most`` the
    largest mean and ``small`` the factor of the widening in small samples; the rest is as in :func:`block_mean`.
    """
    if clusters < 2:
        return found
    value, share, level = found.value, widest / found.n, 1 - ALPHA / choices
    if rare is None:
        more = widest**2 if spread < TIE else widest
        se = math.sqrt(spread + small * (unit or 0.0) ** 2 * more) / found.n
        half = student_quantile((1 + level) / 2, clusters - 1) * se
        low, high, p_value = value - half, value + half, float(student_tails(value / se, clusters - 1))
    else:
        se = math.sqrt(spread) / found.n
        low, high = rare.interval(value, se, clusters, share=share, level=level)
        p_value = rare.p_value(value, se, clusters, share=share)
    tested = p_value if found.p_value is None and clusters >= FEWEST else found.p_value
    return replace(found, low=max(-(most or math.inf), low), high=min(most or math.inf, high), p_value=tested)


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
    spread = two_way_variance(residuals, luck, person) if fewest > 1 else 0.0
    return _student(found, spread, widest, fewest, unit=unit, most=most, rare=rare, choices=choices)


def crossed_mean(
    values: Array, luck: Labels, person: Labels, *, unit: float, rare: RareBlock | None = None
) -> Difference:
    """The mean of trials, clustered by luck and by person, with a t-test of mean 0.

    If people have unequally many trials, a conclusion must hold with every trial and with every person counted alike
    (:func:`lockprobe.statistics.clustered.crossed_proportion`).
    """
    pooled, alike = (
        two_way(mean, weight * (values - mean), luck, person, pairs=len(values), unit=unit, most=unit, rare=rare)
        for weight in (np.ones(len(values)), alike_weights(person))
        for mean in [float((weight * values).mean())]
    )
    return _held_by_both(pooled, alike)


def at_one_dose(values: Array, person: Labels, *, unit: float, rare: RareBlock | None = None) -> Difference:
    """The mean difference at one dose, with an exchange test that swaps the agents within whole people.

    If people have unequally many trials, a conclusion must also hold with every person counted alike.
    """
    place, sizes = np.unique(person, return_inverse=True, return_counts=True)[1:]
    rows = np.full((len(sizes), int(sizes.max())), math.nan)
    for i in range(len(sizes)):
        rows[i, : sizes[i]] = values[place.reshape(-1) == i]
    found = block_mean(rows, unit=unit, rare=rare)
    if np.ptp(sizes) == 0:
        return found
    means = np.nanmean(rows, axis=1)
    alike = block_mean(means[:, None], unit=unit, rare=rare)
    return _held_by_both(found, replace(alike, p_value=sign_flip(means * math.lcm(*sizes.tolist()))))


def _held_by_both(pooled: Difference, alike: Difference) -> Difference:
    """The pooled mean, with an interval that holds both and the larger P value; 1 if the signs differ."""
    if pooled.low is None or pooled.high is None or alike.low is None or alike.high is None:
        return pooled
    tested = pooled.p_value
    if tested is not None and alike.p_value is not None:
        tested = max(tested, alike.p_value) if pooled.value * alike.value > 0 else 1.0
    return replace(pooled, low=min(pooled.low, alike.low), high=max(pooled.high, alike.high), p_value=tested)


def both_played(one: Sheet, two: Sheet) -> NDArray[np.bool_]:
    """Whether both finished their trial, shape (blocks, doses)."""
    return ~np.isnan(two.solved - one.solved)


def paired_success(one: Sheet, two: Sheet, at: int = 0) -> Difference:
    """The second's success minus the first's at one dose, with McNemar's test and Agresti and Min's interval.

    If one of several people has several boxes, agents are exchanged within whole people, and the interval is over them.
    Of several boxes each counts alike (:mod:`lockprobe.statistics.boxes`).
    """
    both, people = both_played(one, two)[:, at], people_of(one, two)
    first, second = (sheet.solved[both, at] > 0 for sheet in (one, two))
    found = paired(first, second)
    value, low, high, p_value = found.value, found.low, found.high, found.p_value
    if len(one.box):
        counted = difference_over_boxes(pairs_by_box(np.column_stack([first, second]), one.box[both]))
        value, low, high, p_value = counted.value, counted.low, counted.high, max(p_value, counted.interval_p)
    if people is not None and len(np.unique(person := people[both, at])) < len(person):
        over = at_one_dose(second * 1.0 - first, person, unit=1.0)
        low, high = (-1.0, 1.0) if over.low is None or over.high is None else (over.low, over.high)
        p_value = 1.0 if over.p_value is None else over.p_value
    return Difference(value=value, low=low, high=high, p_value=p_value, n=found.n, clusters=found.n)


def numbers_of(differences: Array, bound: float = 1.0) -> Numbers:
    """The mean of the differences of each block that has one, each within ``bound``."""
    played = np.flatnonzero(~np.isnan(differences).all(axis=1))
    return Numbers(values=np.nanmean(differences[played], axis=1), block=played, bound=bound)


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
