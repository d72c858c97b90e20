"""The paper's published results, as counts where its text implies them.

23.3 % of 30 trials are 7, and 20 is the only whole number near 2.85 times that. Loop rates are reconstructed as 24 and
16 of 30, which fits "approximately 80 %" and a drop of "more than 26 %" (percentage points).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lockprobe.statistics.proportions import proportion

PEAK = 0.4
"""The flip probability at which the paper has most success and fewest loops (Figs. 4 and 5b)."""

SOLVED_AT_0, SOLVED_AT_40 = proportion(7, 30), proportion(20, 30)
LOOPS_AT_0, LOOPS_AT_40 = proportion(24, 30), proportion(16, 30)
REFERENCE, MODALITY = proportion(10, 10), proportion(8, 10)
CORRELATION, CORRELATION_POINTS = -0.69, 21
"""Fig. 5a, presumably over repetitions of conditions."""

STEPS_TO_80: Mapping[str, int] = {"rgb": 11, "symbolic": 15}
"""Sec. 3.1: steps after which GPT o1 had solved 80 % of the trials, by modality."""

REFERENCE_STEPS = 9
"""The same of the human-inspired strategy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MisreadRate:
    """A row of Table 1: rates per trial over 10 trials.

    Attributes:
        mean: Mean of the rates, [0, 1].
        sd: Standard deviation of the rates.
        total: Number of misinterpretations.
        affected: Trials with at least one misinterpretation.
        trials: Number of trials.
    """

    mean: float
    sd: float
    total: int
    affected: int
    trials: int = 10


TABLE1: Mapping[str, MisreadRate] = {
    "rgb": MisreadRate(mean=0.217, sd=0.122, total=22, affected=10),
    "rgbd": MisreadRate(mean=0.268, sd=0.125, total=35, affected=10),
    "symbolic": MisreadRate(mean=0.049, sd=0.069, total=6, affected=4),
}
"""Table 1 by modality."""
