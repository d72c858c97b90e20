"""The common odds ratio of several 2 x 2 tables (Mantel and Haenszel 1959), with its standard error."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonOdds:
    """Mantel and Haenszel's common odds ratio.

    Attributes:
        ratio: The odds in the first rows over those in the second, at least 0.
        log_error: Standard error of its logarithm (Robins, Breslow and Greenland 1986); None if the ratio is 0.
    """

    ratio: float
    log_error: float | None


def common_odds(tables: NDArray[np.float64]) -> CommonOdds | None:
    """The common odds ratio of counts; None if it is undefined, as without a table.

    Args:
        tables: Counts of shape (2, 2, strata); no table is empty.
    """
    (a, b), (c, d) = tables
    n = a + b + c + d
    along, across, crossed = (a + d) / n, a * d / n, b * c / n
    up, down = float(np.sum(across)), float(np.sum(crossed))
    if not down:
        return None
    if not up:
        return CommonOdds(ratio=0.0, log_error=None)
    variance = (
        float(np.sum(along * across)) / up**2
        + float(np.sum(along * crossed + (1 - along) * across)) / (up * down)
        + float(np.sum((1 - along) * crossed)) / down**2
    ) / 2
    return CommonOdds(ratio=up / down, log_error=math.sqrt(variance))
