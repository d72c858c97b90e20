"""Fractional factorial designs of two levels: which combinations to play, which factors conditions cross, and effects.

In a design of resolution IV no main effect is mixed with another one, or with an interaction of two factors. Two-factor
interactions are mixed with each other (Box, Hunter and Hunter, *Statistics for Experimenters*, 2005, ch. 6). A main
effect is the mean over trials at the high level of a factor minus the mean over trials at its low level, within each
block of luck; the interval is Student's over blocks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
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
from lockprobe.statistics.proportions import ALPHA
from lockprobe.trial.record import Trial

MEASURES = ("misreading", "success")
"""What is analysed: the share of statements about an attempt that contradict what happened, and the share solved."""

_BASE = 4
"""Factors whose combinations are all played; the others follow from three of them each."""

_FEWEST = 3
"""Fewest factors of a factorial design; two are a crossing."""


def fraction(factors: int) -> list[tuple[int, ...]]:
    """The levels of 4 to 8 factors in 16 combinations of resolution IV, -1 or 1; the first is -1 throughout.

    >>> runs = fraction(8)
    >>> len(runs), runs[0], {sum(column) for column in zip(*runs)}
    (16, (-1, -1, -1, -1, -1, -1, -1, -1), {0})
    """
    thirds = list(combinations(range(_BASE), 3))[: factors - _BASE]
    return [(*base, *(prod(base[i] for i in third) for third in thirds)) for base in product((-1, 1), repeat=_BASE)]


class Factorial(NamedTuple):
    """A balanced design among the conditions of one modality.

    Attributes:
        modality: How the box is shown, without doses.
        factors: Names of the factors.
        levels: Factor -> what its low and its high level are called.
        runs: Label of a condition -> its level of each factor, -1 or 1.
    """

    modality: str
    factors: tuple[str, ...]
    levels: Mapping[str, tuple[str, str]]
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
    return [Factorial(modality, factors, {name: ("", next(iter(values[name]))) for name in factors}, runs)]


def _options(spec: Spec) -> list[tuple[str, str]]:
    """The options of an intervention; one without options is an option itself."""
    return [(f"{spec.full_name}.{name}", value) for name, value in spec.options.items()] or [(spec.full_name, "yes")]


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorEffect:
    """What one factor does to one measure.

    Attributes:
        factor: Its name.
        measure: Of :data:`MEASURES`.
        value: High level minus low level, [-1, 1].
        low, high: Ends of the interval, corrected for the number of factors (Bonferroni); None if all blocks are alike.
            Those of success, and its P value, hold whatever became of broken trials.
        p_value: That there is no effect, corrected for the factors (Holm); None if all blocks are alike.
    """

    factor: str
    measure: str
    value: float
    low: float | None
    high: float | None
    p_value: float | None


class FactorialEffects(NamedTuple):
    """The effects of all factors on one agent, over blocks that have a trial in every condition."""

    agent: str
    design: Factorial
    blocks: int
    effects: Sequence[FactorEffect]


def factorial_effects(cells: Mapping[tuple[str, str], Sequence[Trial]], design: Design) -> Iterator[FactorialEffects]:
    """The effects of the factors that the conditions cross, of each agent with two whole blocks or more.

    ``cells`` are the trials of every agent under every condition.
    """
    for agent in design.agents:
        for made in (one for modality in design.modalities for one in factorials_of(design.arms, modality)):
            begun = [{(one.repetition, one.trial): one for one in cells.get((agent, label), ())} for label in made.runs]
            blocks = sorted(set.intersection(*map(set, begun)))
            every = [[own[block] for own in begun] for block in blocks]
            whole = [row for row in every if len(ended(row)) == len(row)]
            if len(whole) > 1:
                effects = [one for measure in MEASURES for one in _of_measure(every, whole, made, measure)]
                yield FactorialEffects(agent, made, len(whole), effects)


def _of_measure(
    every: Sequence[Sequence[Trial]], whole: Sequence[Sequence[Trial]], design: Factorial, measure: str
) -> list[FactorEffect]:
    """The effects on a measure; ``every`` row of trials by condition is a block, in ``whole`` ones none broke."""
    values = np.array([[_value(trial, measure) for trial in row] for row in whole], dtype=np.float64)
    if np.isnan(values).all():
        return []
    signs = np.array([*design.runs.values()], dtype=np.float64)
    found = main_effects(values, signs, design.factors, measure)
    broke = np.array([[trial.ending == "error" for trial in row] for row in every])
    if found and measure == "success" and broke.any():
        solved = np.array([[trial.solved for trial in row] for row in every])
        for i, high in enumerate(signs.T > 0):
            ends = (np.where(broke, high == soon, solved).astype(np.float64) for soon in (False, True))
            found[i] = bounded(found[i], *(main_effects(end, signs, design.factors, measure)[i] for end in ends))
    corrected = holm([one.p_value for one in found])
    return [replace(one, p_value=p_value) for one, p_value in zip(found, corrected, strict=True)]


def _value(trial: Trial, measure: str) -> float:
    if measure == "success":
        return float(trial.solved)
    said = claims(trial)
    return sum(claim.false_belief for claim in said) / len(said) if said else math.nan


def main_effects(values: Array, signs: Array, factors: Sequence[str], measure: str) -> list[FactorEffect]:
    """The effects of all factors, with P values that are not corrected; none unless two blocks have them.

    Args:
        values: Of each trial, shape (blocks, conditions); NaN where it has none.
        signs: The level of each factor, -1 or 1, shape (conditions, factors).
        factors: Their names.
        measure: What is analysed.
    """

    def mean_of(some: Array) -> Array:
        known = ~np.isnan(some)
        total, sums = known.sum(axis=1), np.where(known, some, 0).sum(axis=1)
        made: Array = np.divide(sums, total, out=np.full(len(some), np.nan), where=total > 0)
        return made

    contrasts = np.stack([mean_of(values[:, of > 0]) - mean_of(values[:, of < 0]) for of in signs.T], axis=-1)
    kept = contrasts[~np.isnan(contrasts).any(axis=1)]
    n = len(kept)
    if n < 2:
        return []
    mean, error = kept.mean(axis=0), kept.std(axis=0, ddof=1) / math.sqrt(n)
    half = student_quantile(1 - ALPHA / len(factors) / 2, n - 1) * error
    found = []
    for name, value, spread, width in zip(factors, mean.tolist(), error.tolist(), half.tolist(), strict=True):
        varies = spread > 0
        low, high = (max(-1.0, value - width), min(1.0, value + width)) if varies else (None, None)
        p_value = float(student_tails(abs(value) / spread, n - 1)) if varies else None
        found.append(
            FactorEffect(factor=name, measure=measure, value=round(value, 12), low=low, high=high, p_value=p_value)
        )
    return found
