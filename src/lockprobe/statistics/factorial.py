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
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.arms import SeriesArm
from lockprobe.statistics.blocks import Array
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.design import Design
from lockprobe.statistics.distributions import holm, student_quantile, student_tails
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.proportions import ALPHA, Difference
from lockprobe.trial.record import Trial

_FEWEST = 3
"""Fewest factors of a factorial design; two are a crossing."""


class Factorial(NamedTuple):
    """A balanced design among the conditions of one modality.

    Attributes:
        levels: Factor -> what its high level is called; the low one is without it.
        runs: Label of a condition -> its level of each factor, -1 or 1.
    """

    levels: Mapping[str, str]
    runs: Mapping[str, tuple[int, ...]]


def factorial_of(arms: Sequence[SeriesArm]) -> Factorial | None:
    """The factorial design among the conditions of one modality, of options that are left out or have one other value.

    Every two factors have to be orthogonal: their four combinations occur equally often.
    """
    said = {arm.label: dict(option for i in arm.acting for option in _options(arm.specs[i])) for arm in arms}
    values: dict[str, set[str]] = {}
    for options in said.values():
        for name, value in options.items():
            values.setdefault(name, set()).add(value)
    if len(values) < _FEWEST or any(len(found) > 1 for found in values.values()):
        return None
    runs = {label: tuple(1 if name in options else -1 for name in values) for label, options in said.items()}
    signs = np.array([*runs.values()])
    if signs.sum(axis=0).any() or any(signs[:, i] @ signs[:, j] for i, j in combinations(range(len(values)), 2)):
        return None
    return Factorial({name: next(iter(found)) for name, found in values.items()}, runs)


def _options(spec: Spec) -> list[tuple[str, str]]:
    """The options of an intervention; one without options is an option itself."""
    return [(f"{spec.full_name}.{name}", value) for name, value in spec.options.items()] or [(spec.full_name, "yes")]


class FactorEffect(NamedTuple):
    """What one factor does to one measure of an agent, over blocks that have a trial in every condition.

    Attributes:
        measure: ``misreading``, the share of statements about an attempt that contradict what happened, or ``success``.
        change: High level minus low level. Interval and P value are corrected for the factors (Bonferroni, Holm); there
            are none if all blocks are alike. Those of success hold whatever became of broken trials.
    """

    agent: str
    modality: str
    factor: str
    level: str
    factors: int
    measure: str
    change: Difference


def factorial_effects(cells: Mapping[tuple[str, str], Sequence[Trial]], design: Design) -> Iterator[FactorEffect]:
    """The effects of the factors that the conditions cross, of each agent with two whole blocks or more.

    ``cells`` are the trials of every agent under every condition.
    """
    for agent, modality in product(design.agents, design.modalities):
        if (made := factorial_of(design.shown(modality))) is None:
            continue
        begun = [{(one.repetition, one.trial): one for one in cells.get((agent, label), ())} for label in made.runs]
        every = [[own[block] for own in begun] for block in sorted(set.intersection(*map(set, begun)))]
        broke = np.array([[trial.ending == "error" for trial in row] for row in every]).reshape(-1, len(begun))
        whole = ~broke.any(axis=1)
        if whole.sum() < 2:
            continue
        signs, n = np.array([*made.runs.values()]), int(whole.sum())
        misread, solved = (np.array([[of(trial) for trial in row] for row in every]) for of in (_misread, _solved))
        for measure, table in (("misreading", misread), ("success", solved)):
            found = main_effects(table[whole], signs)
            for i in range(len(found)) if measure == "success" and broke.any() else ():
                ends = (np.where(broke, (signs[:, i] > 0) == soon, solved) for soon in (False, True))
                found[i] = bounded(found[i], *(main_effects(end, signs)[i] for end in ends))
            corrected = holm([one.p_value for one in found])
            for (factor, level), change, p_value in zip(made.levels.items(), found, corrected, strict=False):
                tested = replace(change, p_value=p_value, n=n * len(begun), clusters=n)
                yield FactorEffect(agent, modality, factor, level, len(made.levels), measure, tested)


def _solved(trial: Trial) -> float:
    return float(trial.solved)


def _misread(trial: Trial) -> float:
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
