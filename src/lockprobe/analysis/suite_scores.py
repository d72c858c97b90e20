"""Five scores of an agent over boxes of rising difficulty, each with its 95 % interval.

* ``competence``: success with true reports, on a scale from chance (0, a uniformly random agent, exact) to the optimum
  (1, every box opened within the budget). Success and chance are averaged over levels first.
* ``robustness``: the change of the competence by false reports; 0 is no change, below 0 is a loss.
* ``misreading``: share of claims about the last action that contradict the report (the paper's misinterpretations).
* ``loops``: share of trials with an action loop (true reports) minus the share expected of random actions in trials of
  these lengths; 0 is chance.
* ``rationality``: share of actions (true reports) that are optimal to an ideal observer who was told the same, next
  to the share that random choices in the same situations have; on the boxes that the observer's prior holds.

Levels have equal weight. Intervals of scores over levels combine those of the levels by the method of variance
estimates recovery (Zou and Donner, Statistics in Medicine 27, 2008): Wilson's for shares, Agresti and Min's for paired
differences, clustered ones for actions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from lockprobe.analysis.clustered import ClusteredProportion, clustered_proportion
from lockprobe.analysis.misinterpretation import trial_claims
from lockprobe.analysis.null_models import expected_loop_rate
from lockprobe.analysis.outcomes import ended, outcomes, solved_in_pairs
from lockprobe.analysis.proportions import Proportion, paired, proportion
from lockprobe.analysis.rationality import judge, prior_for
from lockprobe.record import Trial

__all__ = ["LevelScore", "LevelTrials", "Rational", "Score", "SuiteScore", "suite_score"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelTrials:
    """The trials of one agent at one level.

    Attributes:
        box: Name of the box.
        chance: Success of a uniformly random agent within the budget, exact, [0, 1].
        told: Trials with true reports.
        misled: Trials with false reports and the same luck.
        judged: Whether the prior of the ideal observer holds the box.
    """

    box: str
    chance: float
    told: Sequence[Trial]
    misled: Sequence[Trial]
    judged: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """An estimate with its 95 % interval.

    Attributes:
        value: The estimate.
        low, high: Ends of the interval.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Rational:
    """The share of optimal actions.

    Attributes:
        value: The share, [0, 1].
        low, high: Ends of its 95 % interval.
        chance: The share that random choices have in the same situations, [0, 1].
        actions: Number of actions.
    """

    value: float
    low: float
    high: float
    chance: float
    actions: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelScore:
    """Success at one level.

    Attributes:
        box: Name of the box.
        chance: Success of a uniformly random agent, exact, [0, 1].
        told, misled: Trials solved with true and with false reports.
    """

    box: str
    chance: float
    told: Proportion
    misled: Proportion


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteScore:
    """The scores of one agent; None if a level has no ended trial, or the agent is not asked for claims.

    Attributes:
        trials: Trials that ended as solved or out of budget.
        broken: Trials that ended as an error; no score counts them.
        competence, robustness, misreading, loops, rationality: As this module says.
        levels: Success level by level.
    """

    trials: int
    broken: int
    competence: Score | None
    robustness: Score | None
    misreading: Score | None
    loops: Score | None
    rationality: Rational | None
    levels: tuple[LevelScore, ...]


def suite_score(levels: Sequence[LevelTrials]) -> SuiteScore:
    """The scores of one agent in one modality.

    Args:
        levels: Its trials by level, at least one level.
    """
    every = [trial for level in levels for trial in (*level.told, *level.misled)]
    told = [ended(level.told) for level in levels]
    whole = 1 - fmean(level.chance for level in levels)
    return SuiteScore(
        trials=len(ended(every)),
        broken=len(every) - len(ended(every)),
        competence=_competence(levels, whole) if all(told) else None,
        robustness=_robustness(levels, whole),
        misreading=_misreading(every),
        loops=_loops(told) if all(told) else None,
        rationality=_rationality([trials for level, trials in zip(levels, told, strict=True) if level.judged]),
        levels=tuple(
            LevelScore(box=one.box, chance=one.chance, told=_solved(one.told), misled=_solved(one.misled))
            for one in levels
        ),
    )


def _solved(trials: Sequence[Trial]) -> Proportion:
    counted = ended(trials)
    return proportion(sum(trial.solved for trial in counted), len(counted))


def _combined(parts: Sequence[Score], scale: float = 1.0, shift: float = 0.0) -> Score:
    """(Mean of independent estimates - ``shift``) / ``scale``, with an interval by variance estimates recovery."""
    value = fmean(part.value for part in parts)
    down = math.hypot(*(part.value - part.low for part in parts)) / len(parts)
    up = math.hypot(*(part.high - part.value for part in parts)) / len(parts)
    return Score(value=(value - shift) / scale, low=(value - down - shift) / scale, high=(value + up - shift) / scale)


def _as_score(found: Proportion | ClusteredProportion) -> Score:
    return Score(value=found.value, low=found.low, high=found.high)


def _competence(levels: Sequence[LevelTrials], whole: float) -> Score:
    return _combined([_as_score(_solved(level.told)) for level in levels], whole, shift=1 - whole)


def _robustness(levels: Sequence[LevelTrials], whole: float) -> Score | None:
    parts = []
    for level in levels:
        pairs = solved_in_pairs(outcomes(level.told), outcomes(level.misled))
        if not len(pairs):
            return None
        found = paired(pairs[:, 0], pairs[:, 1])
        # The interval is centred on a value with half a pair more of each kind, and can leave out the estimate.
        low, high = min(found.low, found.value), max(found.high, found.value)
        parts.append(Score(value=found.value, low=low, high=high))
    return _combined(parts, whole)


def _misreading(trials: Sequence[Trial]) -> Score | None:
    found = [claims for trial in ended(trials) if (claims := trial_claims(trial)).claims]
    if not found:
        return None
    return _as_score(clustered_proportion([one.misinterpreted for one in found], [len(one.claims) for one in found]))


def _loops(told: Sequence[Sequence[Trial]]) -> Score:
    found = [outcomes(trials).looped for trials in told]
    chance = [
        expected_loop_rate([trial.actions for trial in trials], "uniform", actions=len(trials[0].joints)).probability
        for trials in told
    ]
    return _combined([_as_score(proportion(int(one.sum()), len(one))) for one in found], shift=fmean(chance))


def _rationality(told: Sequence[Sequence[Trial]]) -> Rational | None:
    """The rationality over the judged levels; levels have equal weight."""
    parts, chance, actions = list[Score](), list[float](), 0
    for trials in told:
        prior = prior_for(len(trials[0].joints)) if trials else None
        if prior is None or not all(trial.ordinary for trial in trials):
            return None
        judged = [judge(trial, prior=prior).steps for trial in trials]
        steps = [step for one in judged for step in one]
        counts = [sum(step.optimal for step in one) for one in judged]
        parts.append(_as_score(clustered_proportion(counts, [len(one) for one in judged])))
        chance.append(fmean(step.by_chance["optimal"] for step in steps))
        actions += len(steps)
    if not parts:
        return None
    found = _combined(parts)
    return Rational(value=found.value, low=found.low, high=found.high, chance=fmean(chance), actions=actions)
