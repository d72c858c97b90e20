"""A share of solved trials with an interval that holds at every look."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.statistics.sequential.betting import SHARES, confidence_sequence


def share_at_every_look(solved: ArrayLike, level: float = 1 - ALPHA) -> Proportion:
    """A share with its confidence sequence, from a mixture of binomial likelihood ratios (Robbins 1970).

    Args:
        solved: Whether each trial was solved, in the order of blocks, shape (trials,); NaN where it broke. The interval
            is then from the low end with all of these unsolved to the high end with all solved.
        level: Confidence level of the interval over all looks, (0, 1).

    >>> found = share_at_every_look([i % 4 == 3 for i in range(30)])
    >>> round(found.low, 2), round(found.high, 2)
    (0.06, 0.51)
    """
    values = np.asarray(solved, dtype=np.float64)
    known = values[~np.isnan(values)]
    ends = (known,) if len(known) == len(values) else (np.nan_to_num(values, nan=0.0), np.nan_to_num(values, nan=1.0))
    courses = [confidence_sequence(one, math.log(1 / (1 - level)), bets=SHARES) for one in ends]
    lows, highs = courses[0][0], courses[-1][1]
    return Proportion(
        count=int(known.sum()),
        n=len(known),
        value=float(known.mean()) if len(known) else math.nan,
        low=float(lows[-1]) if len(lows) else 0.0,
        high=float(highs[-1]) if len(highs) else 1.0,
        broken=len(values) - len(known),
    )
