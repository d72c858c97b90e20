"""Shares of clustered trials, and their differences, with design effects and clustered standard errors."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.proportions import LEVEL, Difference, Proportion, between, proportion, wilson

FEWEST_BOXES = 10
"""The fewest boxes for an interval of a share on boxes like these; with fewer it says nothing."""

_TIE = 1e-9

Array = NDArray[np.float64]


def student(
    found: Difference,
    variance: float,
    clusters: int,
    *,
    more: tuple[float, float] = (0.0, 0.0),
    most: float = math.inf,
    choices: int = 1,
    fewest: int = 2,
) -> Difference:
    """A mean with Student's interval, and with Student's P value if there are clusters enough.

    Args:
        found: The mean, of so many clusters; with fewer than two it stays as it is.
        variance: That of the mean.
        clusters: One more than the degrees of freedom.
        more: What is added to the variance below and above the mean.
        most: The largest mean, at which the interval ends.
        choices: Number of means examined; the interval has the level 1 - 0.05 / choices.
        fewest: The fewest clusters for a test.
    """
    if clusters < 2:
        return found
    below, above = (math.sqrt(variance + one) for one in more)
    reach = student_quantile(1 - (1 - LEVEL) / choices / 2, clusters - 1)
    tested = None
    if clusters >= fewest:
        tested = float(student_tails(found.value / (below if found.value > 0 else above), clusters - 1))
    low, high = max(-most, found.value - reach * below), min(most, found.value + reach * above)
    return replace(found, low=low, high=high, p_value=tested)


def clustered_proportion(counts: ArrayLike, sizes: ArrayLike, *kinds: ArrayLike) -> Proportion:
    """A pooled share with Wilson's interval on the effective number of trials.

    With k clusters of c_i successes in n_i trials and the pooled share s: the variance of s as a ratio is
    ``k / (k - 1) sum (c_i - s n_i)^2 / n^2`` (:func:`clustered_variance`), the design effect is that over
    ``s (1 - s) / n`` and at least 1, and the interval is Wilson's with ``n / design_effect`` trials and Student's t of
    k - 1 degrees of freedom in place of z; with fewer than two clusters [0, 1]. The fewer of two kinds count.

    Near 0 or 1 the data do not show whether the rarer outcome comes by whole clusters. The design effect is therefore
    at least that with half a cluster more, wholly of the rarer outcome: 120 of 120 in 30 clusters have the interval of
    30 of 30.

    If players have unequally many trials, the interval also holds that of the mean over players, each of whom counts
    alike. People who leave after a failure have few trials, so the pooled share is too high, and the mean over players,
    most of whom end with a failure, is too low.

    Coverage of 1500 samples with 10 trials per cluster, true shares of 0.1 to 0.5 and intraclass correlations of 0 to
    0.5: 99.7-100 % with 3 clusters (mean width 0.75 to 0.87), 96.6-99.9 % with 10 and 96.0-99.6 % with 30. Near the
    ceiling it equals Wilson's interval of as many trials as clusters (``benchmarks/ceiling_coverage.py``).

    Args:
        counts: Successes of each trial or cluster.
        sizes: Its attempts, of the same shape; with 0 it does not count.
        kinds: Of what cluster each is: nothing if it is one itself, a label, or a player and a block of luck.
    """
    solved, trials = (np.asarray(of, dtype=np.float64) for of in (counts, sizes))
    there = trials > 0
    solved, trials = solved[there], trials[there]
    places = [_place(np.asarray(kind)[there]) for kind in kinds] or [np.arange(len(trials))]
    count, n, k = round(float(solved.sum())), round(float(trials.sum())), min(len(np.unique(of)) for of in places)
    share = float(solved.sum()) / float(trials.sum()) if n else math.nan
    found, ends = Proportion(count=count, n=n, clusters=k, value=share, low=0.0, high=1.0), []
    if k < 2:
        return found
    least = max(_least_design_effect(np.bincount(of, solved), np.bincount(of, trials)) for of in places)
    weights = [np.ones(len(trials))]
    if len(places) > 1 and np.ptp(alike := alike_weights(places[0], trials)) > _TIE:
        weights.append(alike)
    for weight in weights:
        share = float(np.sum(weight * solved)) / n
        variance, binomial = (
            clustered_variance(weight * (solved - share * trials), *places) / n**2,
            share * (1 - share) / n,
        )
        effect = max(least, variance / binomial) if binomial else least
        low, high = wilson(share, n, student_quantile((1 + LEVEL) / 2, k - 1), design_effect=effect)
        ends.append((low if count else 0.0, high if count < n else 1.0, effect))  # a share may be 1 but for rounding
    lows, highs, effects = zip(*ends, strict=True)
    return replace(found, low=min(lows), high=max(highs), design_effect=effects[0])


def _place(kind: ArrayLike) -> NDArray[np.int64]:
    """The number of each trial's cluster, from 0."""
    return np.unique(np.asarray(kind), return_inverse=True)[1].reshape(-1)


def alike_weights(player: ArrayLike, sizes: ArrayLike | None = None) -> Array:
    """The weights under which all players of trials, shape (trials,), count alike; their mean over ``sizes`` is 1.

    ``sizes`` are the attempts of each trial, > 0; by default 1.
    """
    place = _place(player)
    total = np.bincount(place, None if sizes is None else np.asarray(sizes, dtype=np.float64))
    weights: Array = total.sum() / len(total) / total[place]
    return weights


def clustered_difference(
    happened: ArrayLike, later: ArrayLike, player: ArrayLike, luck: ArrayLike, *, choices: int = 1
) -> Difference:
    """The difference between the shares of two groups of trials in two crossed kinds of clusters, players and luck.

    The variance is that of :func:`clustered_variance`, and at least that of independent trials with one more of each
    outcome (Agresti and Caffo 2000), whose difference is the centre of the interval. Student's t has k - 2 degrees of
    freedom, k the number of clusters of the kind with fewer; with three or fewer the interval is from -1 to 1. If
    players have unequally many trials, the interval also holds that of the difference of means over players, and the P
    value is the larger, as in :func:`clustered_proportion`. It is below 0.05 if the interval leaves out 0.

    Columns have the shape (trials,): whether the event happened, whether the trial belongs to the second group (both
    have one), its player, and its block of luck. ``choices`` is the number of groups that the second was chosen from,
    for which both are corrected: the interval has the level 1 - 0.05 / choices.
    """
    events, group = np.asarray(happened, dtype=np.float64), np.asarray(later).astype(np.int64)
    people, lucks = np.asarray(player), np.asarray(luck)
    value = float(events[group == 1].mean() - events[group == 0].mean())
    freedom = min(len(np.unique(people)), len(np.unique(lucks))) - 2
    if freedom < 1:
        return Difference(value=value, low=-1.0, high=1.0, p_value=1.0)
    alike = np.ones(len(group))
    for side in (0, 1):
        alike[group == side] = alike_weights(people[group == side])
    found = []
    for weight in [np.ones(len(group)), alike][: 1 + bool(np.ptp(alike) > _TIE)]:
        n = np.bincount(group, weights=weight, minlength=2)
        shares = np.bincount(group, weights=weight * events, minlength=2) / n
        smooth = (n * shares + 1) / (n + 2)
        spread = clustered_variance(weight * (events - shares[group]) * (2 * group - 1) / n[group], people, lucks)
        error = math.sqrt(max(spread, float(np.sum(smooth * (1 - smooth) / (n + 2)))))
        found.append((float(smooth[1] - smooth[0]), error))
    middles, errors = np.array(found).T
    half = -student_quantile((1 - LEVEL) / choices / 2, freedom) * errors
    agree, tails = len(set(np.sign(middles))) == 1, [student_tails(one, freedom) for one in (middles / errors).tolist()]
    return Difference(
        value=value,
        low=max(-1.0, float(np.min(middles - half))),
        high=min(1.0, float(np.max(middles + half))),
        p_value=min(1.0, choices * max(tails)) if agree else 1.0,
    )


def share_of(happened: ArrayLike, player: ArrayLike, luck: ArrayLike, box: ArrayLike = ()) -> Proportion:
    """A share of the trials of one condition with Wilson's interval, clustered by player or by box.

    Columns have the shape (trials,): whether the event happened, NaN where that is not known, as of success where the
    trial broke (the interval is then from the low end with none of these to the high end with all); the player, empty
    where trials are independent; the block of luck; the box, empty if all are of one.
    """
    events, people, lucks = np.asarray(happened, dtype=np.float64), np.asarray(player), np.asarray(luck)
    boxes = np.asarray(box)
    if (unknown := np.isnan(events)).any():
        none, every = (share_of(np.where(unknown, end, events), people, lucks, boxes) for end in (0.0, 1.0))
        of = ((one[~unknown] if len(one) == len(events) else one) for one in (people, lucks, boxes))
        return between(share_of(events[~unknown], *of), none, every)
    if len(people):
        return clustered_proportion(events, np.ones(len(events)), people, lucks)
    names, place = np.unique(boxes, return_inverse=True)
    if len(names) > 1:
        return share_over_boxes(np.bincount(place, weights=events), np.bincount(place))
    return proportion(int(events.sum()), len(events))


def share_over_boxes(counts: ArrayLike, sizes: ArrayLike) -> Proportion:
    """A share of which every box counts alike: of boxes like these from :data:`FEWEST_BOXES` boxes on, else these.

    ``counts`` are the successes on each box, ``sizes`` its trials, above 0.
    """
    solved, trials = np.asarray(counts, dtype=np.float64), np.asarray(sizes, dtype=np.float64)
    k, n = len(trials), float(trials.sum())
    weights = n / (k * trials)
    share = float(np.mean(solved / trials))
    if k >= FEWEST_BOXES:
        found = clustered_proportion(weights * solved, weights * trials)
        low, high = found.low, found.high
    else:
        low, high = wilson(share, n, design_effect=float(np.sum(trials * weights**2)) / n)
    return Proportion(count=int(solved.sum()), n=int(n), value=share, low=low, high=high)


def clustered_variance(residuals: ArrayLike, *kinds: ArrayLike) -> float:
    """The variance of a sum of trials in clusters of one kind, or of two that cross.

    Of two kinds it is the sum of both one-way variances minus the variance of single trials, and at least either
    one-way variance (Cameron, Gelbach and Miller 2011). ``residuals`` are each trial less its expectation, shape
    (trials,); there are at least two clusters of each kind.
    """
    rest = np.asarray(residuals, dtype=np.float64)

    def one_way(place: NDArray[np.int64]) -> float:
        sums = np.bincount(place, weights=rest)
        return len(sums) / (len(sums) - 1) * float(np.sum(sums**2))

    ways = [one_way(_place(kind)) for kind in kinds]
    return max(*ways, sum(ways) - one_way(np.arange(len(rest)))) if len(ways) > 1 else ways[0]


def _least_design_effect(counts: ArrayLike, sizes: ArrayLike) -> float:
    """The design effect, >= 1, after adding half a cluster of the rarer outcome; its size is the mean over trials."""
    solved, trials = np.asarray(counts, dtype=np.float64), np.asarray(sizes, dtype=np.float64)
    n = float(trials.sum())
    if not n:
        return 1.0
    rare = min(solved, trials - solved, key=lambda of: float(of.sum()))
    size = float(np.sum(trials**2)) / n
    share = (rare.sum() + size / 2) / (n + size / 2)
    spread = float(np.sum((rare - share * trials) ** 2)) + (size * (1 - share)) ** 2 / 2
    return max(1.0, float(spread / ((n + size / 2) * share * (1 - share))))
