"""Fractional factorial designs of two levels: which factors conditions cross, and effects.

In a design of resolution IV no main effect is mixed with another one, or with an interaction of two factors. Two-factor
interactions are mixed with each other (Box, Hunter and Hunter, *Statistics for Experimenters*, 2005, ch. 6). A main
effect is the mean over trials at the high level of a factor minus the mean over trials at its low level, within each
block of luck; the interval is Student's over blocks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from math import prod
from typing import NamedTuple

import numpy as np

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.agent_comparison.paired import Array
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.conditions.axis import SeriesArm
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.distributions import holm, student_quantile, student_tails
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import ALPHA, Difference
from lockprobe.trial.record import Trial

MEASURES = ("misreading", "success")
"""What is analysed: the share of statements about an attempt that contradict what happened, and the share solved."""

_FEWEST = 3
"""Fewest factors of a factorial design; two are a crossing."""


class Factorial(NamedTuple):
    """A balanced design among the conditions of one modality.

    Attributes:
        levels: Factor -> what its high level is called; the low one is without it.
        runs: Label of a condition -> its level of each factor, -1 or 1.
    """

    modality: str
    levels: Mapping[str, str]
    runs: Mapping[str, tuple[int, ...]]


def factorials_of(arms: Sequence[SeriesArm], modality: str) -> list[Factorial]:
    """The factorial designs among conditions: none or one, of options that are left out or have one other value.

    Every two factors have to be orthogonal: their four combinations occur equally often.
    """
    shown = [arm for arm in arms if arm.modality == modality]
    said = {arm.label: dict(option for i in arm.acting for option in _options(arm.specs[i])) for arm in shown}
    values: dict[str, set[str]] = {}
    for options in said.values():
        for name, value in options.items():
            values.setdefault(name, set()).add(value)
    factors = tuple(name for name, found in values.items() if len(found) == 1)
    if len(factors) < _FEWEST or len(factors) < len(values):
        return []
    runs = {label: tuple(1 if name in options else -1 for name in factors) for label, options in said.items()}
    columns = list(zip(*runs.values(), strict=True))
    balanced = all(sum(column) == 0 for column in columns)
    if not balanced or any(sum(map(prod, zip(*two, strict=True))) for two in combinations(columns, 2)):
        return []
    return [Factorial(modality, {name: next(iter(values[name])) for name in factors}, runs)]


def _options(spec: Spec) -> list[tuple[str, str]]:
    """The options of an intervention; one without options is an option itself."""
    return [(f"{spec.full_name}.{name}", value) for name, value in spec.options.items()] or [(spec.full_name, "yes")]


class FactorEffect(NamedTuple):
    """What one factor does to one measure of an agent, over blocks that have a trial in every condition.

    Attributes:
        measure: Of :data:`MEASURES`.
        change: High level minus low level. Interval and P value are corrected for the factors (Bonferroni, Holm); there
            are none if all blocks are alike. Those of success hold whatever became of broken trials.
    """

    agent: str
    design: Factorial
    factor: str
    measure: str
    change: Difference


def factorial_effects(cells: Mapping[tuple[str, str], Sequence[Trial]], design: Design) -> Iterator[FactorEffect]:
    """The effects of the factors that the conditions cross, of each agent with two whole blocks or more.

    ``cells`` are the trials of every agent under every condition.
    """
    for agent in design.agents:
        for made in (one for modality in design.modalities for one in factorials_of(design.arms, modality)):
            begun = [{(one.repetition, one.trial): one for one in cells.get((agent, label), ())} for label in made.runs]
            blocks = sorted(set.intersection(*map(set, begun)))
            every = [[own[block] for own in begun] for block in blocks]
            whole = [row for row in every if len(ended(row)) == len(row)]
            counted = {"clusters": len(whole), "n": len(whole) * len(made.runs)}
            for measure in MEASURES if len(whole) > 1 else ():
                found = _of_measure(every, whole, np.array([*made.runs.values()], dtype=np.float64), measure)
                for factor, change in zip(made.levels, found, strict=False):
                    yield FactorEffect(agent, made, factor, measure, replace(change, **counted))


def _of_measure(
    every: Sequence[Sequence[Trial]], whole: Sequence[Sequence[Trial]], signs: Array, measure: str
) -> list[Difference]:
    """The effects on a measure; ``every`` row of trials by condition is a block, in ``whole`` ones none broke."""
    values = np.array([[_value(trial, measure) for trial in row] for row in whole], dtype=np.float64)
    found = main_effects(values, signs)
    broke = np.array([[trial.ending == "error" for trial in row] for row in every])
    if found and measure == "success" and broke.any():
        solved = np.array([[trial.solved for trial in row] for row in every])
        for i, high in enumerate(signs.T > 0):
            ends = (np.where(broke, high == soon, solved).astype(np.float64) for soon in (False, True))
            found[i] = bounded(found[i], *(main_effects(end, signs)[i] for end in ends))
    corrected = holm([one.p_value for one in found])
    return [replace(one, p_value=p_value) for one, p_value in zip(found, corrected, strict=True)]


def _value(trial: Trial, measure: str) -> float:
    if measure == "success":
        return float(trial.solved)
    said = claims(trial)
    return sum(claim.false_belief for claim in said) / len(said) if said else math.nan


def main_effects(values: Array, signs: Array) -> list[Difference]:
    """The effects of all factors, with P values that are not corrected; none unless two blocks have them.

    Values are of each trial, shape (blocks, conditions), NaN where it has none; signs are the level of each factor, -1
    or 1, shape (conditions, factors).
    """

    def mean_of(some: Array) -> Array:
        known = ~np.isnan(some)
        total, sums = known.sum(axis=1), np.where(known, some, 0).sum(axis=1)
        made: Array = np.divide(sums, total, out=np.full(len(some), np.nan), where=total > 0)
        return made

    contrasts = np.stack([mean_of(values[:, of > 0]) - mean_of(values[:, of < 0]) for of in signs.T], axis=-1)
    kept = contrasts[~np.isnan(contrasts).any(axis=1)]
    n, found = len(kept), list[Difference]()
    if n < 2:
        return found
    errors = kept.std(axis=0, ddof=1) / math.sqrt(n)
    reach = student_quantile(1 - ALPHA / signs.shape[1] / 2, n - 1)
    for value, error in zip(kept.mean(axis=0).tolist(), errors.tolist(), strict=True):
        mean, half = Difference(value=round(value, 12), n=n, clusters=n), reach * error
        if error > 0:
            p_value = float(student_tails(abs(value) / error, n - 1))
            mean = replace(mean, low=max(-1.0, value - half), high=min(1.0, value + half), p_value=p_value)
        found.append(mean)
    return found
