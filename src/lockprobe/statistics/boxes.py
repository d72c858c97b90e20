"""Several boxes: means of blocks that hold of boxes like these, and whether an effect differs between boxes.

Every box counts alike; :mod:`lockprobe.statistics.paired_proportions` has the difference of success over boxes, and
:func:`lockprobe.statistics.clustered.share_over_boxes` the share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.distributions import student_mean, student_quantile, student_tails
from lockprobe.statistics.paired_proportions import FEWEST, Pairs
from lockprobe.statistics.proportions import LEVEL

FEWEST_THAT_DIFFER, FEWEST_PAIRS = 3, 5
"""The fewest boxes, and pairs of trials on each, for a test of whether the effect differs between boxes."""

Array = NDArray[np.float64]
_Found = TypeVar("_Found", bound=Any)


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


def mean_over_boxes(found: _Found, sums: Array, box: NDArray[np.str_], *, choices: int = 1) -> _Found:
    """A mean of blocks of luck that holds of boxes like these too, from :data:`FEWEST` boxes on; else unchanged.

    The interval is at least as wide as Student's over the means of boxes and holds the mean over boxes, and the P value
    is the larger one.

    ``found`` is a data class with interval and corrected P value; ``sums`` and ``box`` are value and box of each block,
    shape (blocks,); ``choices`` means are judged together.
    """
    means = _means(sums, box)
    if len(means) < FEWEST or found.low is None or found.high is None:
        return found
    low, high, p_value = student_mean(means, 1 - (1 - LEVEL) / choices)
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


def _means(values: Array, box: NDArray[np.str_]) -> Array:
    if not len(box):
        return np.empty(0)
    place = np.unique(box, return_inverse=True)[1].reshape(-1)
    return np.bincount(place, weights=values) / np.bincount(place)


def between_boxes(pairs: Pairs) -> BetweenBoxes | None:
    """Whether an effect differs between boxes; None with too few of them, or of pairs on one."""
    first, second, n, k = pairs.first, pairs.second, pairs.n, len(pairs.n)
    if k < FEWEST_THAT_DIFFER or n.min() < FEWEST_PAIRS:
        return None
    from scipy.special import chdtrc, fdtrc

    d, many = pairs.differences, float(n.sum())
    within = float(np.sum(first + second - n * d**2)) / (many - k)
    among = float(np.sum(n * (d - n @ d / many) ** 2)) / (k - 1)
    smooth = (second - first) / (n + 2)
    variance = ((first + second + 1) / (n + 2) - smooth**2) / (n + 2)
    pooled = float(np.sum(d / variance) / np.sum(1 / variance))
    q_test = float(chdtrc(k - 1, np.sum((d - pooled) ** 2 / variance)))
    f_test = float(fdtrc(k - 1, many - k, among / within)) if within else float(among == 0)
    noise = float(np.mean(((first + second) / n - d**2) / (n - 1)))
    half = student_quantile((1 + LEVEL) / 2, k - 1) * float(d.std(ddof=1)) * math.sqrt(1 + 1 / k)
    return BetweenBoxes(
        p_value=max(f_test, q_test),
        deviation=math.sqrt(max(0.0, float(d.var(ddof=1)) - noise)),
        low=max(-1.0, float(d.mean()) - half),
        high=min(1.0, float(d.mean()) + half),
    )
