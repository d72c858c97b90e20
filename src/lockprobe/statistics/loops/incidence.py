"""Cumulative incidence by step (one minus Kaplan-Meier) for censored trials, with a confidence band and its area."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.proportions import Z, wilson


@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """Mean incidence over steps 1 to the horizon: 1 if all trials have the event at step 1, 0 if none has it.

    Attributes:
        value: [0, 1].
        low, high: Ends of the 95 % interval.
        se: Standard error (Greenwood's).
    """

    value: float
    low: float
    high: float
    se: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Incidence:
    """Cumulative incidence: the share of trials with the event by each step, one minus Kaplan-Meier.

    The band is Wilson's interval for as many trials as carry the same Greenwood variance (Rothman 1978). Without early
    censoring it is exactly Wilson's interval of a plain share. Unlike the log-log band it exists at shares of 0 and 1.

    Attributes:
        share: By step 0, 1, ... up to the horizon, [0, 1].
        low, high: Ends of the pointwise 95 % band.
        area: Mean share over steps 1 to the horizon; None without a trial or a step.
    """

    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    area: Area | None


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
    share, low, high, greenwood = [], [], [], [0.0] * (horizon + 1)
    remaining, whole, hazard, size = 1, 1, 0.0, 0.0
    for step, (n, d) in enumerate(zip(running, events, strict=True)):
        before = remaining / whole
        if d:
            remaining, whole = remaining * (n - d), whole * n
            greenwood[step] = d / (n * (n - d)) if d < n else 0.0
            hazard += greenwood[step]
        reached = (whole - remaining) / whole
        if 0 < remaining < whole:
            size = reached / (remaining / whole * hazard)
        elif n:
            size = n / before  # Peto's: as many trials as would leave n running
        down, up = wilson(reached, size, design_effect=design_effect)
        share.append(reached if len(steps) else math.nan)
        low.append(down)
        high.append(up if n or not remaining else 1.0)
    carried = design_effect * np.array(greenwood)
    area = _area(np.array(share), carried, len(steps) / design_effect) if horizon and len(steps) else None
    return Incidence(share=tuple(share), low=tuple(low), high=tuple(high), area=area)


def _area(share: NDArray[np.float64], greenwood: NDArray[np.float64], n: float) -> Area:
    """Agresti and Coull's interval for a mean of scores in [0, 1]: adds ``Z**2`` trials, half of score 1, half of 0."""
    value = float(np.mean(share[1:]))
    beyond = np.cumsum((1 - share)[::-1])[::-1] / (len(share) - 1)
    variance = float(np.sum(beyond**2 * greenwood))
    total = n + Z**2
    centre = (n * value + Z**2 / 2) / total
    spread = n * (n * variance + (value - centre) ** 2) + Z**2 * ((1 - centre) ** 2 + centre**2) / 2
    half = Z * math.sqrt(spread) / total
    return Area(value=value, low=max(0.0, centre - half), high=min(1.0, centre + half), se=math.sqrt(variance))
