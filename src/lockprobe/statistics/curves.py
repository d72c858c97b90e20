"""Cumulative incidence by step, one minus Kaplan-Meier: of success (paper, Fig. 3), of a first loop.

A trial that ends without the event is *censored*. With equal budgets the curve of success is the plain share solved. A
trial that broke in a step was not solved before it, and may have been solved in it or never: the curve has bounds and
is their middle. One minus Kaplan-Meier would be no estimate there, because long trials break.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import wilson


@dataclass(frozen=True, slots=True, kw_only=True)
class Incidence:
    """The share of trials with the event by step 0, 1, ... up to the horizon, and its band.

    The band is Wilson's interval for as many trials as carry the same Greenwood variance (Rothman 1978). Without early
    censoring it is exactly Wilson's interval of a plain share. Unlike the log-log band it exists at shares of 0 and 1.

    Attributes:
        n: Trials: all that were begun, or none if none ended.
        share: [0, 1]; the middle of the bounds where trials broke.
        low, high: Ends of the pointwise 95 % band, which holds whatever became of broken trials.
    """

    n: int
    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def steps_to(self, share: float = 0.8) -> int | None:
        """The first step by which at least this share of the trials is solved; None if none is."""
        return _first(self.share, share)

    def steps_to_interval(self, share: float = 0.8) -> tuple[int | None, int | None]:
        """The 95 % interval of :meth:`steps_to`, from the ends of the band; None means beyond the budget."""
        return _first(self.high, share), _first(self.low, share)

    @property
    def restricted_mean_steps(self) -> float | None:
        """Mean steps over *all* trials, unsolved ones counted with the whole budget; None without trials."""
        return sum(1 - share for share in self.share[:-1]) if self.n else None


def _first(values: Sequence[float], share: float) -> int | None:
    return next((step for step, value in enumerate(values) if value >= share - 1e-12), None)


def success_curve(outcomes: Outcomes) -> Incidence:
    """Cumulative success over the trials of one condition, with a band clustered by player."""
    counted, begun, ends = len(outcomes.ended), len(outcomes), list[Incidence]()
    for of in [outcomes.completed(soon) for soon in (False, True)] if 0 < counted < begun else [outcomes.ended]:
        effect = 1.0
        if of.crossed:  # else all trials are independent
            effect = clustered_proportion(of.solved, np.ones(len(of)), of.player, of.luck).design_effect
        ends.append(incidence(of.length, of.solved, outcomes.budget, effect))
    share = np.array([one.share for one in ends]).mean(axis=0)
    return Incidence(n=counted and begun, share=tuple(share.tolist()), low=ends[0].low, high=ends[-1].high)


def incidence(
    steps: NDArray[np.integer[Any]], happened: NDArray[np.bool_], horizon: int, design_effect: float = 1.0
) -> Incidence:
    """One minus Kaplan-Meier up to the horizon, computed in whole numbers, so that plain shares are exact.

    Columns have the shape (trials,): the step of the event, or the last one without it, and whether it happened there.
    The design effect is the variance relative to that of independent trials, >= 1.
    """
    left = np.bincount(steps, minlength=horizon + 1)[: horizon + 1]
    running = (len(steps) - np.cumsum(left) + left).tolist()
    events = np.bincount(steps[happened], minlength=horizon + 1)[: horizon + 1].tolist()
    share, low, high = [], [], []
    remaining, whole, hazard, size = 1, 1, 0.0, 0.0
    for n, d in zip(running, events, strict=True):
        before = remaining / whole
        if d:
            remaining, whole = remaining * (n - d), whole * n
            hazard += d / (n * (n - d)) if d < n else 0.0
        reached = (whole - remaining) / whole
        if 0 < remaining < whole:
            size = reached / (remaining / whole * hazard)
        elif n:
            size = n / before  # Peto's: as many trials as would leave n running
        down, up = wilson(reached, size, design_effect=design_effect)
        share.append(reached if len(steps) else math.nan)
        low.append(down)
        high.append(up if n or not remaining else 1.0)
    return Incidence(n=len(steps), share=tuple(share), low=tuple(low), high=tuple(high))
