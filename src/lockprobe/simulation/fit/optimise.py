"""Maximum likelihood, with profile-likelihood intervals that allow for shared luck."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.fit.choices import Choices
from lockprobe.simulation.fit.likelihood import Model
from lockprobe.simulation.fit.result import Parameter
from lockprobe.statistics.distributions import normal_quantile, student_quantile
from lockprobe.statistics.proportions import LEVEL

__all__ = ["DesignEffects", "Maximum", "design_effects", "ends", "maximise", "maximum", "parameters", "students_t"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_ITERATIONS = 200
_LEAST_DAMPING = 1e-7
_SMALL = 3
"""Steps without a relevant gain after which the search stops."""
ENOUGH = 1e-6
"""Gain in log-likelihood below which a step is the last."""


@dataclass(frozen=True, slots=True)
class Maximum:
    """The maximum of a log-likelihood.

    Attributes:
        values: The parameters, shape (parameters,).
        log_likelihood: The log-likelihood there, natural logarithm.
    """

    values: Array
    log_likelihood: float


def maximum(model: Model) -> Maximum:
    """The largest of the maxima reached from the model's starting values."""
    found = [maximise(model, np.array(start, dtype=np.float64)) for start in model.starts]
    return max(found, key=lambda one: one.log_likelihood)


def maximise(model: Model, start: Array, held: Mapping[int, float] | None = None, *, enough: float = ENOUGH) -> Maximum:
    """Maximise within the bounds by Fisher scoring with Levenberg-Marquardt damping.

    Args:
        model: The model.
        start: Starting values, shape (parameters,).
        held: Fixed parameters: place -> value.
        enough: Convergence tolerance: the gain in log-likelihood below which a step is the last.
    """
    low, high = np.array(list(model.bounds.values()), dtype=np.float64).reshape(-1, 2).T
    free = np.array([k not in (held or {}) for k in range(len(low))], dtype=np.bool_)
    values = np.clip(start, low, high)
    for place, value in (held or {}).items():
        values[place] = value
    now, damping, small = model.slope(values), 1e-3, 0
    for _ in range(_ITERATIONS):
        moving = free & ~((values <= low) & (now.uphill <= 0)) & ~((values >= high) & (now.uphill >= 0))
        if small == _SMALL or damping > 1e9 or not moving.any():
            break
        bend = now.information[np.ix_(moving, moving)]
        bend = bend + damping * np.diag(np.diag(bend) + 1e-6)
        there = values.copy()
        there[moving] += np.linalg.solve(bend, now.uphill[moving])
        there = np.clip(there, low, high)
        then = model.slope(there)
        gain = then.log_likelihood - now.log_likelihood
        small += abs(gain) < enough
        if gain < 0:
            damping *= 10
        else:
            values, now, damping = there, then, max(damping / 10, _LEAST_DAMPING)
    return Maximum(values, now.log_likelihood)


@dataclass(frozen=True, slots=True)
class DesignEffects:
    """Design effects of choices that share luck.

    Attributes:
        parameters: Variance inflation of each parameter, >= 1, shape (parameters,).
        overall: Inflation of differences in log-likelihood, >= 1.
    """

    parameters: Array
    overall: float


def design_effects(model: Model, values: Array, clusters: Integers) -> DesignEffects:
    """Design effects from the scores summed by cluster (Liang and Zeger 1986).

    With H the information and J the variance of the summed scores, a parameter's variance is from the sandwich
    ``H^-1 J H^-1`` instead of ``H^-1``. A difference in log-likelihood is ``trace(J H^-1) / rank(H)`` times as large as
    for independent choices (Varin and Vidoni 2005). All are 1 with a single cluster, or without information.
    ``values`` is the model's maximum, ``clusters`` the cluster of each choice.
    """
    labels, place = np.unique(clusters, return_inverse=True)
    effects = np.ones(len(values))
    if len(labels) < 2 or not len(values):
        return DesignEffects(effects, 1.0)
    information = model.slope(values).information
    sums = np.zeros((len(labels), len(values)))
    np.add.at(sums, place.reshape(-1), model.scores(values))
    sums -= sums.mean(axis=0)
    squares = sums.T @ sums * len(labels) / (len(labels) - 1)
    variance = _inverse(information)
    alone = np.diag(variance)
    np.divide(np.diag(variance @ squares @ variance), alone, out=effects, where=alone > 0)
    rank = round(float(np.trace(variance @ information)))
    overall = float(np.trace(squares @ variance)) / rank if rank else 1.0
    return DesignEffects(np.maximum(effects, 1.0), max(overall, 1.0))


def _inverse(information: Array) -> Array:
    """The pseudo-inverse, over the directions with information."""
    return np.asarray(np.linalg.pinv(information, rcond=1e-8, hermitian=True), dtype=np.float64)


def students_t(clusters: int) -> float:
    """Student's quantile for 95 % intervals, given the number of clusters.

    With a single cluster it is the normal quantile: choices then count as independent, given the reports.
    """
    tail = (1 + LEVEL) / 2
    return student_quantile(tail, clusters - 1) if clusters > 1 else normal_quantile(tail)


def parameters(model: Model, best: Maximum, choices: Choices) -> tuple[Parameter, ...]:
    """Each parameter with its 95 % profile-likelihood interval, from the model's maximum.

    The interval holds all values at which twice the log-likelihood, maximised over the other parameters, lies below its
    maximum by no more than the squared quantile times the parameter's design effect (adjusted likelihood: Chandler and
    Bate 2007). A normal interval would reach beyond bounds, and be symmetric even if two pulls trade off.
    """
    quantile = students_t(len(np.unique(choices.cluster)))
    effects = design_effects(model, best.values, choices.cluster).parameters
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


def ends(model: Model, best: Maximum, place: int, cut: float) -> tuple[float | None, float | None]:
    """The ends of a parameter's profile-likelihood interval; None for an end that does not exist.

    At an end, twice the log-likelihood, maximised over all other parameters, has fallen by ``cut``. The search starts
    along the ridge of the likelihood, unless there is no information on the parameter: its direction would be rounding
    error.

    Args:
        model: The model.
        best: Its maximum.
        place: The place of the parameter.
        cut: Decrease of twice the log-likelihood at the ends, > 0.
    """
    information = model.slope(best.values).information
    variance = _inverse(information)
    known = float(variance[place] @ information[:, place]) > 0.5
    own = max(0.0, float(variance[place, place])) if known else 0.0
    along = variance[:, place] / own if own else np.zeros(len(variance))
    low, high = list(model.bounds.values())[place]
    step = float(np.sqrt(cut * own)) or (high - low) / 4
    profile = _ProfileLikelihood(model, best, place, along)
    return profile.end(cut, low, step), profile.end(cut, high, step)


class _ProfileLikelihood:
    """The profile log-likelihood of one parameter: maximised over all others."""

    def __init__(self, model: Model, best: Maximum, place: int, along: Array) -> None:
        self._model = model
        self._best = best
        self._place = place
        self._along = along
        self._centre = float(best.values[place])

    def end(self, cut: float, bound: float, step: float) -> float | None:
        """The value towards a bound at which it has fallen by half of ``cut``; None if that is not reached."""
        from scipy.optimize import brentq

        start, known = self._best.values, {self._centre: -float(np.sqrt(cut))}

        def beyond(value: float) -> float:
            """Nearly straight where the log-likelihood is nearly quadratic; the same if asked again."""
            nonlocal start
            if value not in known:
                guess = start + self._along * (value - start[self._place])
                found = maximise(self._model, guess, {self._place: value}, enough=1e-5)
                start, fallen = found.values, 2 * (self._best.log_likelihood - found.log_likelihood)
                known[value] = float(np.sqrt(max(0.0, fallen)) - np.sqrt(cut))
            return known[value]

        inside, value = self._centre, self._centre
        while value != bound:
            value = min(value + step, bound) if bound > self._centre else max(value - step, bound)
            if beyond(value) > 0:
                return float(brentq(beyond, inside, value, xtol=0.01 * step))
            inside, step = value, 2 * step
        return None
