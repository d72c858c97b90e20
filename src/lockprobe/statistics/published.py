"""The paper's published results, as counts where its text implies them, and tests of what was measured against them.

23.3 % of 30 trials are 7, and 20 is the only whole number near 2.85 times that. Loop rates are reconstructed as 24 and
16 of 30, which fits "approximately 80 %" and a drop of "more than 26 %" (percentage points).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import NormalDist
from typing import Literal

from lockprobe.statistics.proportions import Proportion, opposed_shares, proportion

PEAK = 0.4
"""The flip probability at which the paper has most success and fewest loops (Figs. 4 and 5b)."""

Shares = tuple[Proportion, Proportion]
"""Shares of trials at a flip rate of 0 and at :data:`PEAK`."""

SOLVED: Shares = (proportion(7, 30), proportion(20, 30))
LOOPED: Shares = (proportion(24, 30), proportion(16, 30))
CORRELATION, CORRELATION_POINTS = -0.69, 21
"""Fig. 5a, presumably over repetitions of conditions."""

STEPS_TO_80: Mapping[str, int] = {"rgb": 11, "symbolic": 15}
"""Sec. 3.1: steps after which GPT o1 had solved 80 % of the trials, by modality."""

REFERENCE_STEPS = 9
"""The same of the human-inspired strategy."""


TABLE1 = {"rgb": (0.217, 0.122, 10), "rgbd": (0.268, 0.125, 10), "symbolic": (0.049, 0.069, 10)}
"""Table 1 by modality: mean and standard deviation of the rates of misinterpretation per trial, [0, 1], and trials."""


def change_p(kind: Literal["difference", "ratio"], here: Shares, paper: Shares = SOLVED) -> float:
    """P value, two-sided, of a change from 0 to the peak being the paper's: a z test of two independent estimates.

    A difference has an error with two more trials of each kind (Agresti and Coull), the logarithm of a ratio one with
    half a trial more of each (Walter 1975). If trials broke it is the larger P value of both ends, and 1 if the
    paper's number lies between these.
    """

    def of(first: Proportion, second: Proportion) -> tuple[float, float]:
        if kind == "difference":
            smooth = [((one.count + 2) / (one.n + 4), one.n + 4) for one in (first, second)]
            return second.value - first.value, math.sqrt(sum(value * (1 - value) / n for value, n in smooth))
        (a, n), (b, m) = ((one.count + 0.5, one.n + 0.5) for one in (second, first))
        return math.log(a / n) - math.log(b / m), math.sqrt(1 / a - 1 / n + 1 / b - 1 / m)

    published, ends = of(*paper), [of(*end) for end in opposed_shares(*here)]
    between = len({value > published[0] for value, _ in ends}) > 1
    return 1.0 if between else max(_apart(end, published) for end in ends)


def correlation_p(r: float, points: int) -> float:
    """P value, two-sided, of a correlation over so many points being the paper's, by Fisher's z; -1 < r < 1."""
    here, paper = ((math.atanh(r), 1 / math.sqrt(n - 3)) for r, n in ((r, points), (CORRELATION, CORRELATION_POINTS)))
    return _apart(here, paper)


def _apart(here: tuple[float, float], paper: tuple[float, float]) -> float:
    """P value of two independent estimates, each with its standard error, being of one truth."""
    return 2 * NormalDist().cdf(-abs(here[0] - paper[0]) / math.hypot(here[1], paper[1]))
