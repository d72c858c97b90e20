"""Several boxes: what holds of these boxes, and what of boxes like these.

Every box counts alike. Boxes differ in difficulty and in effect, so an interval that takes their trials as independent
holds the mean over boxes in as little as .36 of studies, and random-effects methods, whose weights depend on a box's
own outcome, in .04 to .10 near 0 and 1. The one here holds it in .94 or more with 3 to 50 boxes of 5 to 60 trials
each: Student's over the differences of boxes, *joined* with that of these boxes (the lower of both lows, the higher of
both highs) and, where few boxes differ at all, with Tango's over boxes. With one box it is the interval of one box.

It needs luck that differs between boxes: with equal luck in all of them it would hold .13 to .94.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import normal_quantile, student_quantile, student_tails
from lockprobe.statistics.paired_proportions import FEW, score, score_interval
from lockprobe.statistics.proportions import LEVEL

FEWEST = 5
"""The fewest boxes for a sentence on boxes like these."""

FEWEST_THAT_DIFFER, FEWEST_PAIRS = 3, 5
"""The fewest boxes, and pairs of trials on each, for a test of whether the effect differs between boxes."""

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """Pairs of trials of equal luck by box, each column of shape (boxes,).

    Attributes:
        first, second: Pairs solved under the first condition alone, and under the second alone.
        n: Pairs, at least one on each box.
    """

    first: Array
    second: Array
    n: Array

    @property
    def differences(self) -> Array:
        """Success under the second condition minus that under the first, of each box."""
        return (self.second - self.first) / self.n


@dataclass(frozen=True, slots=True, kw_only=True)
class OverBoxes:
    """A mean difference over boxes; ``interval_p`` is below 0.05 only if an interval at 95 % leaves out 0."""

    value: float
    low: float
    high: float
    interval_p: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BetweenBoxes:
    """Whether an effect differs between boxes, and how much.

    Attributes:
        p_value: The larger of those of an F test and of Cochran's Q: each alone finds differences that are not there,
            in up to .27 and .62 of studies, and the larger in at most .057.
        deviation: Standard deviation of the effect between boxes, points. It has no interval that holds near 0 and 1.
        low, high: Range in which the effect on a further box lies.
    """

    p_value: float
    deviation: float
    low: float
    high: float


def pairs_by_box(solved: NDArray[np.bool_], box: NDArray[np.str_]) -> Pairs:
    """Pairs of trials by box, boxes in the order of their names.

    Args:
        solved: Whether the trials of a pair were solved under each of two conditions, shape (pairs, 2).
        box: The box of each pair, shape (pairs,).
    """
    place = np.unique(box, return_inverse=True)[1].reshape(-1)
    first, second = solved.T
    return Pairs(
        first=np.bincount(place, weights=first & ~second).astype(np.float64),
        second=np.bincount(place, weights=second & ~first).astype(np.float64),
        n=np.bincount(place).astype(np.float64),
    )


def difference_over_boxes(pairs: Pairs, *, choices: int = 1) -> OverBoxes:
    """The mean difference of boxes: of boxes like these from :data:`FEWEST` boxes on, else of these.

    Args:
        pairs: The pairs of each box.
        choices: How many differences are judged together; the interval has the level 1 - 0.05 / choices.
    """
    k, n, level = len(pairs.n), float(pairs.n.sum()), 1 - (1 - LEVEL) / choices
    weights = n / (k * pairs.n)
    effect = float(np.sum(pairs.n * weights**2)) / n
    only = float(weights @ pairs.first), float(weights @ pairs.second)
    value = (only[1] - only[0]) / n
    middle = (only[1] - only[0]) / (n + 2)
    error = math.sqrt(effect * ((sum(only) + 1) / (n + 2) - middle**2) / (n + 2))
    half = -normal_quantile((1 - level) / 2) * error
    ends, tests = [(middle - half, middle + half)], [2 * NormalDist().cdf(-abs(middle) / error)]

    def few_differ(first: int, second: int, all_: int) -> None:
        ends.append(score_interval(first, second, all_, level))
        tests.append(2 * NormalDist().cdf(-abs(float(score(first, second, all_, 0.0)))))

    if pairs.first.sum() + pairs.second.sum() <= FEW:
        few_differ(int(pairs.first.sum()), int(pairs.second.sum()), int(n))
    if k >= FEWEST:
        low, high, p_value = _student(pairs.differences, level)
        ends.append((low, high))
        tests.append(p_value)
        if np.sum(pairs.first + pairs.second > 0) <= min(FEW, k / 2):
            few_differ(int(np.sum(pairs.differences < 0)), int(np.sum(pairs.differences > 0)), k)
    lows, highs = zip(*ends, strict=True)
    low, high = max(-1.0, min(lows)), min(1.0, max(highs))
    return OverBoxes(value=value, low=low, high=high, interval_p=min(1.0, max(tests)))


def _student(values: Array, level: float) -> tuple[float, float, float]:
    """Student's interval of a mean, and its P value."""
    k, mean = len(values), float(values.mean())
    error = float(values.std(ddof=1)) / math.sqrt(k)
    half = student_quantile((1 + level) / 2, k - 1) * error
    p_value = float(student_tails(mean / error, k - 1)) if error else float(mean == 0)
    return mean - half, mean + half, p_value


_Found = TypeVar("_Found", bound=Any)


def _means(values: Array, box: NDArray[np.str_]) -> Array:
    place = np.unique(box, return_inverse=True)[1].reshape(-1)
    return np.bincount(place, weights=values) / np.bincount(place)


def mean_over_boxes(found: _Found, sums: Array, box: NDArray[np.str_], *, choices: int = 1) -> _Found:
    """A mean of blocks of luck that holds of boxes like these too, from :data:`FEWEST` boxes on; else unchanged.

    The interval is at least as wide as Student's over the means of boxes and holds the mean over boxes, and the P value
    is the larger one.

    Args:
        found: The mean with its interval and corrected P value, a data class.
        sums: The value of each block, shape (blocks,).
        box: Its box, of the same shape.
        choices: How many means are judged together.
    """
    means = _means(sums, box) if len(box) else np.empty(0)
    if len(means) < FEWEST or found.low is None or found.high is None:
        return found
    low, high, p_value = _student(means, 1 - (1 - LEVEL) / choices)
    tested = None if found.p_value is None else max(found.p_value, min(1.0, choices * p_value))
    return replace(found, low=min(found.low, low), high=max(found.high, high), p_value=tested)


def small_over_boxes(values: Array, box: NDArray[np.str_], margin: float) -> float:
    """P value of two one-sided tests that the mean over boxes is the margin or more; 0 with fewer than enough boxes."""
    means = _means(values, box)
    if len(means) < FEWEST:
        return 0.0
    error, away = float(means.std(ddof=1)) / math.sqrt(len(means)), margin - abs(float(means.mean()))
    if not error:
        return float(away <= 0)
    tail = float(student_tails(away / error, len(means) - 1)) / 2
    return tail if away > 0 else 1 - tail


def between_boxes(pairs: Pairs) -> BetweenBoxes | None:
    """Whether an effect differs between boxes; None with too few of them, or of pairs on one."""
    first, second, n, k = pairs.first, pairs.second, pairs.n, len(pairs.n)
    if k < FEWEST_THAT_DIFFER or n.min() < FEWEST_PAIRS:
        return None
    from scipy.stats import chi2, f

    d, many = pairs.differences, float(n.sum())
    within = float(np.sum(first + second - n * d**2)) / (many - k)
    among = float(np.sum(n * (d - n @ d / many) ** 2)) / (k - 1)
    smooth = (second - first) / (n + 2)
    variance = ((first + second + 1) / (n + 2) - smooth**2) / (n + 2)
    pooled = float(np.sum(d / variance) / np.sum(1 / variance))
    q_test = float(chi2.sf(np.sum((d - pooled) ** 2 / variance), k - 1))
    f_test = float(f.sf(among / within, k - 1, many - k)) if within else float(among == 0)
    noise = float(np.mean(((first + second) / n - d**2) / (n - 1)))
    half = student_quantile((1 + LEVEL) / 2, k - 1) * float(d.std(ddof=1)) * math.sqrt(1 + 1 / k)
    return BetweenBoxes(
        p_value=max(f_test, q_test),
        deviation=math.sqrt(max(0.0, float(d.var(ddof=1)) - noise)),
        low=max(-1.0, float(d.mean()) - half),
        high=min(1.0, float(d.mean()) + half),
    )
