"""Shares and means of clustered trials, with design effects and clustered standard errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.proportions import LEVEL, Proportion, between, proportion, wilson

RESAMPLES = 2000

FEWEST_BOXES = 10
"""The fewest boxes for an interval of a share on boxes like these; with fewer it says nothing."""

_TIE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class ClusteredProportion:
    """A pooled share with its clustered 95 % interval.

    Attributes:
        count: Successes.
        n: Trials.
        clusters: Clusters with a trial.
        value: ``count / n``, [0, 1]; NaN if ``n`` is 0.
        design_effect: Variance over that of ``n`` independent trials, >= 1.
        low, high: Ends of the interval; 0 and 1 with fewer than two clusters, whose spread is unknown.
    """

    count: int
    n: int
    clusters: int
    value: float
    design_effect: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ClusteredDifference:
    """The difference of two shares of trials in clusters of two kinds.

    Attributes:
        value: Second less first, [-1, 1].
        low, high: Ends of the interval; -1 and 1 with too few clusters.
        interval_p: The P value of the interval: below 0.05 if one at 95 % leaves out 0.
    """

    value: float
    low: float
    high: float
    interval_p: float


def clustered_proportion(counts: ArrayLike, sizes: ArrayLike) -> ClusteredProportion:
    """A pooled share with Wilson's interval on the effective number of trials.

    With k clusters of c_i successes in n_i trials and the pooled share s: the variance of s as a ratio is
    ``k / (k - 1) sum (c_i - s n_i)^2 / n^2``, the design effect is that over ``s (1 - s) / n`` and at least 1, and the
    interval is Wilson's with ``n / design_effect`` trials and Student's t of k - 1 degrees of freedom in place of z.
    Near 0 or 1 the data do not show whether the rarer outcome comes by whole clusters. The design effect is therefore
    at least that with half a cluster more, wholly of the rarer outcome: 120 of 120 in 30 clusters have the interval of
    30 of 30.

    Coverage of 1500 samples with 10 trials per cluster, true shares of 0.1 to 0.5 and intraclass correlations of 0 to
    0.5: 99.7-100 % with 3 clusters (mean width 0.75 to 0.87), 96.6-99.9 % with 10 and 96.0-99.6 % with 30. Near the
    ceiling it equals Wilson's interval of as many trials as clusters (``benchmarks/ceiling_coverage.py``).

    Args:
        counts: Successes per cluster, shape (clusters,).
        sizes: Trials per cluster, of the same shape; empty clusters do not count.
    """
    solved, trials = np.asarray(counts, dtype=np.float64), np.asarray(sizes, dtype=np.float64)
    solved, trials = solved[trials > 0], trials[trials > 0]
    count, n, k = round(float(solved.sum())), round(float(trials.sum())), len(trials)
    share = float(solved.sum() / trials.sum()) if n else math.nan
    variance = k / (k - 1) * float(np.sum((solved - share * trials) ** 2)) / n**2 if k > 1 else 0.0
    return _effective(count, n, k, variance, _least_design_effect(solved, trials), share=share)


def crossed_proportion(counts: ArrayLike, sizes: ArrayLike, player: ArrayLike, luck: ArrayLike) -> ClusteredProportion:
    """A pooled share of trials in two crossed kinds of clusters, players and luck.

    The interval is that of :func:`clustered_proportion` with the variance of :func:`two_way_variance`. Student's t has
    k - 1 degrees of freedom, k the number of clusters of the kind with fewer. The design effect is at least that of
    half a cluster more of either kind.

    If players have unequally many trials, the interval also holds that of the mean over players, each of whom counts
    alike. People who leave after a failure have few trials, so the pooled share is too high, and the mean over players,
    most of whom end with a failure, is too low.

    Args:
        counts: Successes of each trial, shape (trials,).
        sizes: Attempts of each trial, of the same shape; a trial with 0 does not count.
        player: Its player, of the same shape.
        luck: Its block of luck, of the same shape.
    """
    solved, trials = np.asarray(counts, dtype=np.float64), np.asarray(sizes, dtype=np.float64)
    one, two = np.asarray(player)[trials > 0], np.asarray(luck)[trials > 0]
    solved, trials = solved[trials > 0], trials[trials > 0]
    count, n, k = int(solved.sum()), int(trials.sum()), min(len(np.unique(one)), len(np.unique(two)))
    if k < 2:
        return _effective(count, n, k, 0.0, 1.0)
    kinds = (np.unique(kind, return_inverse=True)[1].reshape(-1) for kind in (one, two))
    least = max(_least_design_effect(np.bincount(kind, solved), np.bincount(kind, trials)) for kind in kinds)
    found = _effective(count, n, k, two_way_variance(solved - count / n * trials, one, two) / n**2, least)
    weight = alike_weights(one, trials)
    if np.ptp(weight) < _TIE:
        return found
    share = float(np.sum(weight * solved)) / n
    variance = two_way_variance(weight * (solved - share * trials), one, two) / n**2
    alike = _effective(count, n, k, variance, least, share=share)
    return replace(found, low=min(found.low, alike.low), high=max(found.high, alike.high))


def alike_weights(player: ArrayLike, sizes: ArrayLike | None = None) -> NDArray[np.float64]:
    """The weights of trials under which all players count alike; their mean over ``sizes`` is 1.

    Args:
        player: The player of each trial, shape (trials,).
        sizes: Attempts of each trial, > 0, of the same shape; by default 1.
    """
    place = np.unique(np.asarray(player), return_inverse=True)[1].reshape(-1)
    total = np.bincount(place, None if sizes is None else np.asarray(sizes, dtype=np.float64))
    weights: NDArray[np.float64] = total.sum() / len(total) / total[place]
    return weights


def clustered_difference(
    happened: ArrayLike, later: ArrayLike, player: ArrayLike, luck: ArrayLike, *, choices: int = 1
) -> ClusteredDifference:
    """The difference between the shares of two groups of trials in two crossed kinds of clusters, players and luck.

    The variance is that of :func:`two_way_variance`, and at least that of independent trials with one more of each
    outcome (Agresti and Caffo 2000), whose difference is the centre of the interval. Student's t has k - 2 degrees of
    freedom, k the number of clusters of the kind with fewer. If players have unequally many trials, the interval also
    holds that of the difference of means over players, and the P value is the larger, as in
    :func:`crossed_proportion`.

    Args:
        happened: Whether the event happened, shape (trials,); both groups have at least one trial.
        later: Whether the trial belongs to the second group, of the same shape.
        player: Its player, of the same shape.
        luck: Its block of luck, of the same shape.
        choices: Number of groups that the second was chosen from; the interval has the level 1 - 0.05 / choices.
    """
    events, group = np.asarray(happened, dtype=np.float64), np.asarray(later).astype(np.int64)
    people, lucks = np.asarray(player), np.asarray(luck)
    value = float(events[group == 1].mean() - events[group == 0].mean())
    freedom = min(len(np.unique(people)), len(np.unique(lucks))) - 2
    if freedom < 1:
        return ClusteredDifference(value=value, low=-1.0, high=1.0, interval_p=1.0)
    alike = np.ones(len(group))
    for side in (0, 1):
        alike[group == side] = alike_weights(people[group == side])
    weights = [np.ones(len(group)), alike][: 1 + bool(np.ptp(alike) > _TIE)]
    middles, errors = np.array([_smoothed(events, group, weight, people, lucks) for weight in weights]).T
    half = -student_quantile((1 - LEVEL) / choices / 2, freedom) * errors
    agree = len(set(np.sign(middles))) == 1
    return ClusteredDifference(
        value=value,
        low=max(-1.0, float(np.min(middles - half))),
        high=min(1.0, float(np.max(middles + half))),
        interval_p=min(1.0, float(np.max(student_tails(middles / errors, freedom)))) if agree else 1.0,
    )


def _smoothed(
    events: NDArray[np.float64],
    group: NDArray[np.int64],
    weight: NDArray[np.float64],
    player: NDArray[np.generic],
    luck: NDArray[np.generic],
) -> tuple[float, float]:
    """The difference of two weighted shares with one more trial of each outcome, and its standard error."""
    n = np.bincount(group, weights=weight, minlength=2)
    shares = np.bincount(group, weights=weight * events, minlength=2) / n
    smooth = (n * shares + 1) / (n + 2)
    spread = two_way_variance(weight * (events - shares[group]) * (2 * group - 1) / n[group], player, luck)
    error = math.sqrt(max(spread, float(np.sum(smooth * (1 - smooth) / (n + 2)))))
    return float(smooth[1] - smooth[0]), error


def share_of(happened: ArrayLike, player: ArrayLike, luck: ArrayLike, box: ArrayLike = ()) -> Proportion:
    """A share of the trials of one condition with Wilson's interval, clustered by player or by box.

    Args:
        happened: Whether the event happened, shape (trials,); NaN where that is not known, as of success where the
            trial broke. The interval is then from the low end with none of these to the high end with all.
        player: The player of each trial, of the same shape; empty where trials of one condition are independent.
        luck: The block of luck of each trial, of the same shape.
        box: The box of each trial, of the same shape; empty if all are of one.
    """
    events, people, lucks = np.asarray(happened, dtype=np.float64), np.asarray(player), np.asarray(luck)
    boxes = np.asarray(box)
    if (unknown := np.isnan(events)).any():
        none, every = (share_of(np.where(unknown, end, events), people, lucks, boxes) for end in (0.0, 1.0))
        of = ((one[~unknown] if len(one) == len(events) else one) for one in (people, lucks, boxes))
        known = share_of(events[~unknown], *of)
        return between(known, none, every)
    if not len(people):
        names, place = np.unique(boxes, return_inverse=True)
        if len(names) > 1:
            return share_over_boxes(np.bincount(place, weights=events), np.bincount(place))
        return proportion(int(events.sum()), len(events))
    found = crossed_proportion(events, np.ones(len(events)), people, lucks)
    return Proportion(count=found.count, n=found.n, value=found.value, low=found.low, high=found.high)


def share_over_boxes(counts: ArrayLike, sizes: ArrayLike) -> Proportion:
    """A share of which every box counts alike: of boxes like these from :data:`FEWEST_BOXES` boxes on, else these.

    Args:
        counts: Successes on each box, shape (boxes,).
        sizes: Trials on each, of the same shape, above 0.
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


def two_way_variance(residuals: ArrayLike, first: ArrayLike, second: ArrayLike) -> float:
    """Two-way clustered variance of a sum of trials (Cameron, Gelbach and Miller 2011).

    It is the sum of both one-way variances minus the variance of single trials, and at least either one-way variance.

    Args:
        residuals: Each trial less its expectation, shape (trials,).
        first: Its cluster of one kind, of the same shape; at least two clusters.
        second: Its cluster of the other kind, of the same shape; at least two clusters.
    """
    rest = np.asarray(residuals, dtype=np.float64)
    one, two = (
        _one_way_variance(rest, np.unique(kind, return_inverse=True)[1].reshape(-1)) for kind in (first, second)
    )
    return max(one, two, one + two - _one_way_variance(rest, np.arange(len(rest))))


def _one_way_variance(residuals: NDArray[np.float64], place: NDArray[np.int64]) -> float:
    sums = np.bincount(place, weights=residuals)
    return len(sums) / (len(sums) - 1) * float(np.sum(sums**2))


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


def _effective(
    count: int, n: int, k: int, variance: float, least: float, *, share: float | None = None
) -> ClusteredProportion:
    """Wilson's interval of a share for the effective number of trials; the design effect is at least ``least``."""
    if share is None:
        share = count / n if n else math.nan
    if k < 2:
        return ClusteredProportion(count=count, n=n, clusters=k, value=share, design_effect=1.0, low=0.0, high=1.0)
    binomial = share * (1 - share) / n
    effect = max(least, variance / binomial) if binomial else least
    low, high = wilson(share, n, student_quantile((1 + LEVEL) / 2, k - 1), design_effect=effect)
    low, high = low if count else 0.0, high if count < n else 1.0  # a share may be 1 but for rounding
    return ClusteredProportion(count=count, n=n, clusters=k, value=share, design_effect=effect, low=low, high=high)
