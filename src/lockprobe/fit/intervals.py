"""Fitted parameters with intervals that know of shared luck."""

from __future__ import annotations

import numpy as np

from lockprobe.analysis.proportions import LEVEL
from lockprobe.fit.choices import Choices
from lockprobe.fit.likelihood import Model
from lockprobe.fit.optimise import Maximum, ends, shared_luck
from lockprobe.fit.result import Parameter

__all__ = ["parameters", "students_t"]


def students_t(clusters: int) -> float:
    """Student's quantile for 95 % intervals from so many clusters.

    It is the normal one with a single cluster: choices then count as independent, given what had been told.
    """
    from scipy.special import ndtri, stdtrit

    tail = (1 + LEVEL) / 2
    return float(stdtrit(clusters - 1, tail) if clusters > 1 else ndtri(tail))


def parameters(model: Model, best: Maximum, choices: Choices) -> tuple[Parameter, ...]:
    """Each parameter with its 95 % interval.

    It holds all values at which twice the log-likelihood, with the other parameters at their best, lies below its
    maximum by no more than the squared quantile times the parameter's design effect (the adjusted likelihood of
    Chandler and Bate 2007). The estimate plus or minus so many errors would reach beyond bounds, and be as long on
    either side, which it is not where two pulls trade off.

    Args:
        model: What was fitted.
        best: Its maximum.
        choices: The choices.
    """
    quantile = students_t(len(np.unique(choices.cluster)))
    effects = shared_luck(model, best.values, choices.cluster).parameters
    found = []
    for place, (name, (least, most)) in enumerate(model.bounds.items()):
        low, high = ends(model, best, place, quantile**2 * float(effects[place]))
        share, value = most == 1.0, float(best.values[place])
        near = 1e-6 if share else 0.01
        found.append(
            Parameter(
                name=name,
                value=value,
                low=0.0 if low is None and share else low,
                high=1.0 if high is None and share else high,
                at_bound=value - least < near or most - value < near,
            )
        )
    return tuple(found)
