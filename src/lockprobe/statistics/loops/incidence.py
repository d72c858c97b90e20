"""Cumulative incidence by step (one minus Kaplan-Meier) for censored trials, with a confidence band."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.proportions import wilson


@dataclass(frozen=True, slots=True, kw_only=True)
class Incidence:
    """The share of trials with the event by step 0, 1, ... up to the horizon, one minus Kaplan-Meier, and its band.

    The band is Wilson's interval for as many trials as carry the same Greenwood variance (Rothman 1978). Without early
    censoring it is exactly Wilson's interval of a plain share. Unlike the log-log band it exists at shares of 0 and 1.
    """

    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


def incidence(
    steps: NDArray[np.integer[Any]], happened: NDArray[np.bool_], horizon: int, design_effect: float = 1.0
) -> Incidence:
    """One minus Kaplan-Meier on a grid of steps, computed in whole numbers, so that plain shares are exact.

    Args:
        steps: The step of the event, or the last step played without it, shape (trials,).
        happened: Whether the event happened at that step, of the same shape.
        horizon: Last step of the curve.
        design_effect: Variance relative to that of independent trials, >= 1.
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
    return Incidence(share=tuple(share), low=tuple(low), high=tuple(high))
