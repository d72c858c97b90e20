"""What each factor of a factorial design does to misreading and to success.

A main effect is the mean over trials at the high level of a factor minus the mean over trials at its low level, within
each block of luck. Blocks are independent: the interval is Student's over them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.statistics.agent_comparison.paired import Array
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.distributions import student_quantile, student_tails
from lockprobe.statistics.factorial.design import Factorial
from lockprobe.statistics.inference.logrank import holm
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import ALPHA
from lockprobe.trial.record import Trial

MEASURES = ("misreading", "success")
"""What is analysed: the share of statements about an attempt that contradict what happened, and the share solved."""

_DIGITS = 12
"""Digits of an effect, which is a difference of means."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorEffect:
    """One factor and one measure.

    Attributes:
        factor: Its name.
        measure: Of :data:`MEASURES`.
        value: High level minus low level, [-1, 1].
        low, high: Ends of the interval, corrected for the number of factors (Bonferroni); None if all blocks are alike.
            Those of success, and its P value, hold whatever became of broken trials.
        p_value: That there is no effect, Student's test over blocks, corrected for the factors (Holm); None if no
            block differs from another.
    """

    factor: str
    measure: str
    value: float
    low: float | None
    high: float | None
    p_value: float | None

    @property
    def detected(self) -> bool:
        """Whether the test rejects and the interval leaves out 0."""
        if self.p_value is None or self.low is None or self.high is None:
            return False
        return self.p_value < ALPHA and (self.low > 0 or self.high < 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorialEffects:
    """The effects of all factors on one agent.

    Attributes:
        agent: Its name, or its spec if it has none.
        design: The design.
        blocks: Blocks with a trial in every condition.
        means: Measure -> its mean over all conditions.
        effects: Every factor under every measure.
    """

    agent: str
    design: Factorial
    blocks: int
    means: Mapping[str, float]
    effects: tuple[FactorEffect, ...]

    def of(self, measure: str) -> list[FactorEffect]:
        """The effects on one measure, the largest first."""
        return sorted((one for one in self.effects if one.measure == measure), key=lambda one: -abs(one.value))


def factorial_effects(trials: Mapping[str, Sequence[Trial]], design: Factorial) -> FactorialEffects | None:
    """Analyse one agent.

    Args:
        trials: Condition -> the agent's trials.
        design: The design among its conditions.

    Returns:
        None unless two blocks have a trial in every condition.
    """
    labels = list(design.runs)
    begun = {label: {(one.repetition, one.trial): one for one in trials.get(label, ())} for label in labels}
    every = [[begun[label][block] for label in labels] for block in sorted(set.intersection(*map(set, begun.values())))]
    sheet = [row for row in every if len(ended(row)) == len(row)]
    if len(sheet) < 2:
        return None
    signs = np.array([design.runs[label] for label in labels], dtype=np.float64)
    broke = np.array([[trial.ending == "error" for trial in row] for row in every])
    solved = np.array([[trial.solved for trial in row] for row in every])
    found: list[FactorEffect] = []
    means = dict[str, float]()
    for measure in MEASURES:
        # shape (blocks, conditions); NaN where an agent said nothing
        values = np.array([[_value(trial, measure) for trial in row] for row in sheet], dtype=np.float64)
        if np.isnan(values).all():
            continue
        means[measure] = float(np.nanmean(values))
        ends = [np.where(broke, (signs.T[:, None] > 0) == soon, solved).astype(np.float64) for soon in (False, True)]
        bounds = ends if measure == "success" and broke.any() else []
        found += _of_measure(values, signs, design.factors, measure, bounds)
    first = sheet[0][0]
    return FactorialEffects(agent=first.group, design=design, blocks=len(sheet), means=means, effects=tuple(found))


def _value(trial: Trial, measure: str) -> float:
    if measure == "success":
        return float(trial.solved)
    said = claims(trial)
    return sum(claim.false_belief for claim in said) / len(said) if said else math.nan


def _of_measure(
    values: Array, signs: Array, factors: Sequence[str], measure: str, ends: Sequence[Array] = ()
) -> list[FactorEffect]:
    """The effects of all factors on a measure.

    ``ends`` are the values at the low and the high end of every factor if trials broke, shape (factors, blocks,
    conditions).
    """
    found = _uncorrected(values, signs, factors, measure)
    if ends:
        at_ends = [[_uncorrected(end[i], signs, factors, measure)[i] for end in ends] for i in range(len(found))]
        found = [bounded(one, *both) for one, both in zip(found, at_ends, strict=True)]
    corrected = holm([one.p_value for one in found])
    return [replace(one, p_value=p_value) for one, p_value in zip(found, corrected, strict=True)]


def _uncorrected(values: Array, signs: Array, factors: Sequence[str], measure: str) -> list[FactorEffect]:
    with np.errstate(invalid="ignore"):
        means = [_mean(values[:, column > 0]) - _mean(values[:, column < 0]) for column in signs.T]
    contrasts = np.stack(means, axis=-1)
    kept = contrasts[~np.isnan(contrasts).any(axis=1)]
    n = len(kept)
    if n < 2:
        return []
    mean, error = kept.mean(axis=0), kept.std(axis=0, ddof=1) / math.sqrt(n)
    half = student_quantile(1 - ALPHA / len(factors) / 2, n - 1) * error
    known = np.divide(np.abs(mean), error, out=np.full_like(mean, np.nan), where=error > 0)
    raw = [None if math.isnan(one) else float(student_tails(one, n - 1)) for one in known]
    return [
        FactorEffect(
            factor=factor,
            measure=measure,
            value=round(float(mean[i]), _DIGITS),
            low=None if raw[i] is None else max(-1.0, float(mean[i] - half[i])),
            high=None if raw[i] is None else min(1.0, float(mean[i] + half[i])),
            p_value=raw[i],
        )
        for i, factor in enumerate(factors)
    ]


def _mean(values: Array) -> Array:
    known = ~np.isnan(values)
    total = known.sum(axis=1)
    made: Array = np.divide(
        np.where(known, values, 0).sum(axis=1), total, out=np.full(len(values), np.nan), where=total > 0
    )
    return made
