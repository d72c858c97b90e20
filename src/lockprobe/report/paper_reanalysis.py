"""Reanalysis of the counts behind the paper's claims, with intervals and tests, in words."""

from __future__ import annotations

import math

from lockprobe.analysis.proportions import Proportion, Z, difference, ratio
from lockprobe.analysis.published import CORRELATION, SOLVED_AT_0, SOLVED_AT_40, TABLE1
from lockprobe.formatting import minus

__all__ = [
    "EFFECT",
    "correlation_over",
    "fisher",
    "fisher_z",
    "in_between",
    "ratio_of_peak",
    "share",
    "steps_behind",
    "table1_row",
]


def fisher_z(r: float, n: int) -> tuple[float, float]:
    """The 95 % interval of a correlation over n independent points (Fisher's z)."""
    half = Z / math.sqrt(n - 3)
    return math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half)


def share(found: Proportion) -> str:
    """A share with its count and interval."""
    return f"{found.count}/{found.n}, {found.value:.3f} [{found.low:.3f}, {found.high:.3f}]"


def table1_row(modality: str) -> str:
    """A row of Table 1."""
    row = TABLE1[modality]
    where = "all 10" if row.affected == 10 else f"{row.affected} of 10"
    return f"{100 * row.mean:.1f} % ± {100 * row.sd:.1f} %, {row.total} in all, in {where} trials"


def steps_behind(modality: str) -> str:
    """How many steps a row of Table 1 implies."""
    row = TABLE1[modality]
    return f"{row.total} in about {row.steps} steps, if the mean rate per trial is the pooled rate"


def in_between() -> str:
    """What Table 1 implies of RGB-D falling in between."""
    rgb, rgbd, truth = (TABLE1[modality] for modality in ("rgb", "rgbd", "symbolic"))
    return (
        f"Table 1 implies about {rgb.steps} steps with RGB, {rgbd.steps} with RGB-D and {truth.steps} with ground "
        f"truth, as total over mean rate. {rgbd.steps} and {truth.steps} do not fit an order with RGB-D in between. "
        f"But the mean rate per trial need not be the pooled rate: {rgbd.total} in {truth.steps} steps are "
        f"{100 * rgbd.total / truth.steps:.1f} %, the mean is {100 * rgbd.mean:.1f} %. With 10 trials each, the power "
        "to detect a trend over modalities that solve 80 % by steps 11, 13 and 15 is 13 % (95 % interval 12 to 14 %, "
        "simulated by benchmarks/modality_rates.py)"
    )


def fisher(first: Proportion, second: Proportion) -> float:
    """Fisher's two-sided p-value; not a number without trials."""
    found = difference(first, second)
    return found.p_value if found else math.nan


def ratio_of_peak() -> str:
    """Success at 0.4 over success at 0."""
    found = ratio(SOLVED_AT_0, SOLVED_AT_40)
    return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]" if found and found.value else ""


def correlation_over(n: int) -> str:
    """The interval of the paper's r, if it is over so many points."""
    low, high = fisher_z(CORRELATION, n)
    return minus(f"over {n} points [{low:.2f}, {high:.2f}]")


EFFECT = fisher(SOLVED_AT_0, SOLVED_AT_40)
"""Fisher's p-value of the success at 0 and at 0.4."""
