"""Five scores of an agent over boxes of rising difficulty, each with its 95 % interval.

* ``competence``: success with true reports, on a scale from chance (0, a uniformly random agent, exact) to the optimum
  (1, every box opened within the budget). Success and chance are averaged over levels first.
* ``robustness``: the change of the competence by false reports; 0 is no change, below 0 is a loss.
* ``misreading``: share of claims about the last action that contradict the report (the paper's misinterpretations).
* ``loops``: share of trials with an action loop (true reports) minus the share expected of random actions in trials of
  these lengths; 0 is chance.
* ``rationality``: share of actions (true reports) that are optimal to an ideal observer who was told the same, next
  to the share that random choices in the same situations have; on the boxes that the observer's prior holds.

Levels have equal weight. The intervals of competence and loops are exact (Clopper and Pearson) for the trials of all
levels together. They hold whatever the success of each level: a sum of trials of unequal success varies less than one
of trials of equal success with the same mean (Hoeffding, Annals of Mathematical Statistics 27, 1956). Where levels
differ much they are wider than need be. That of the robustness is Student's over pairs of trials, stratified by level;
that of the rationality combines the clustered ones of the levels by the method of variance estimates recovery (Zou and
Donner, Statistics in Medicine 27, 2008).

Whoever is named as the best of many agents is partly so by luck: its interval at 95 % holds its competence in fewer
than 95 % of suites, and its change under false reports starts from a lucky base. Intervals of competence and robustness
therefore hold for all agents of a suite at once, at a level of 1 - 0.05 / agents, and so for any that is picked out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.left_out import section
from lockprobe.statistics.agent_comparison.paired import half_width
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.loops.null_models import expected_loop_rate
from lockprobe.statistics.misinterpretation import trial_claims
from lockprobe.statistics.outcomes import ended, outcomes, solved_in_pairs
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion
from lockprobe.statistics.rationality import judge, prior_for
from lockprobe.trial.record import Trial

__all__ = [
    "LevelScore",
    "LevelTrials",
    "Rational",
    "Score",
    "SuiteScore",
    "change_of_success",
    "mean_difference",
    "share_over_levels",
    "suite_score",
]


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

    Robustness is None too where the agent opened no box under either kind of reports: success that is at the floor can
    show no loss.

    Attributes:
        trials: Trials that ended as solved or out of budget.
        broken: Trials that ended as an error; no score counts them.
        competence, robustness, misreading, loops, rationality: As this module says.
        levels: Success level by level.
        together: Number of agents for which the intervals of competence and robustness hold at once.
        ranks: The best and the worst possible rank among them (:mod:`lockprobe.statistics.suite.ranks`); None for a
            single agent, and without a competence.
    """

    trials: int
    broken: int
    competence: Score | None
    robustness: Score | None
    misreading: Score | None
    loops: Score | None
    rationality: Rational | None
    levels: tuple[LevelScore, ...]
    together: int = 1
    ranks: tuple[int, int] | None = None


def suite_score(levels: Sequence[LevelTrials], *, together: int = 1) -> SuiteScore:
    """The scores of one agent in one modality, without ranks.

    Args:
        levels: Its trials by level, at least one level.
        together: Number of agents (and modalities) of the suite, for all of which the intervals of competence and
            robustness hold at once.
    """
    every = [trial for level in levels for trial in (*level.told, *level.misled)]
    told = [ended(level.told) for level in levels]
    whole = 1 - fmean(level.chance for level in levels)
    return SuiteScore(
        trials=len(ended(every)),
        broken=len(every) - len(ended(every)),
        competence=section(
            "Competence", lambda: _competence(levels, whole, together) if all(told) else None, lambda: None
        ),
        robustness=section("Robustness", lambda: _robustness(levels, whole, together), lambda: None),
        misreading=section("Misreading", lambda: _misreading(every), lambda: None),
        loops=section("Loops", lambda: _loops(told) if all(told) else None, lambda: None),
        rationality=section(
            "Rationality",
            lambda: _rationality([trials for level, trials in zip(levels, told, strict=True) if level.judged]),
            lambda: None,
        ),
        levels=tuple(
            LevelScore(box=one.box, chance=one.chance, told=_solved(one.told), misled=_solved(one.misled))
            for one in levels
        ),
        together=together,
    )


def _solved(trials: Sequence[Trial]) -> Proportion:
    counted = ended(trials)
    return proportion(sum(trial.solved for trial in counted), len(counted))


def _competence(levels: Sequence[LevelTrials], whole: float, together: int) -> Score:
    found = share_over_levels([_solved(one.told) for one in levels], together)
    value, low, high = ((end - (1 - whole)) / whole for end in (found.value, found.low, found.high))
    return Score(value=value, low=low, high=high)


def share_over_levels(shares: Sequence[Proportion], together: int = 1) -> Score:
    """The mean of shares over levels of equal weight, with Clopper and Pearson's interval of all trials together.

    Levels of unequal size count with as many trials as the smallest has, since all that is uncertain may lie there;
    the count of successes is then no whole number.

    Args:
        shares: The share of each level, each of at least one trial.
        together: Number of agents for which the interval holds at once.
    """
    from scipy.special import betaincinv

    value, trials = fmean(one.value for one in shares), len(shares) * min(one.n for one in shares)
    solved, tail = trials * value, ALPHA / together / 2
    low = float(betaincinv(solved, trials - solved + 1, tail)) if value > 0 else 0.0
    high = float(betaincinv(solved + 1, trials - solved, 1 - tail)) if value < 1 else 1.0
    return Score(value=value, low=low, high=high)


def _robustness(levels: Sequence[LevelTrials], whole: float, together: int) -> Score | None:
    both = [solved_in_pairs(outcomes(level.told), outcomes(level.misled)) for level in levels]
    return change_of_success(both, together, whole)


def change_of_success(both: Sequence[NDArray[np.bool_]], together: int = 1, whole: float = 1.0) -> Score | None:
    """The change of success from true to false reports over levels of equal weight.

    Args:
        both: For each level, whether trials of equal luck were solved with true and with false reports, shape
            (pairs, 2).
        together: Number of agents for which the interval holds at once.
        whole: Success that a competence of 1 has beyond chance.

    Returns:
        None if a level has fewer than two pairs, or no trial at all was solved.
    """
    if not any(pairs.any() for pairs in both) or (found := mean_difference(both, together)) is None:
        return None
    return Score(value=found.value / whole, low=found.low / whole, high=found.high / whole)


def mean_difference(both: Sequence[NDArray[np.bool_]], choices: int = 1) -> Score | None:
    """The mean over levels of the paired difference in success, second minus first.

    The interval is Student's over pairs, stratified by level, widened as if one more pair of each level differed. With
    four levels of 36 pairs of equal agents it excludes 0 in at most 1.0 times the studies that its level allows, down
    to a level of 0.05 / 190, and in no world that we tried held the truth less often than its level. Agresti and Min's
    intervals of the levels, combined by variance estimates recovery, exclude 0 in up to 1.65 times as many there.

    Args:
        both: For each level, whether trials of equal luck were solved by the first and by the second, shape (pairs, 2).
        choices: Number of differences that are judged together; the interval has the level 1 - 0.05 / choices.

    Returns:
        None if a level has fewer than two pairs.
    """
    if min(map(len, both), default=0) < 2:
        return None
    changes = [np.diff(pairs.astype(np.float64)).ravel() for pairs in both]
    value = fmean(float(change.mean()) for change in changes)
    spread = sum((float(np.sum((one - one.mean()) ** 2)) + 1) / ((len(one) - 1) * len(one)) for one in changes)
    freedom = sum(len(one) - 1 for one in changes)
    half = half_width(math.sqrt(spread) / len(changes), freedom + 1, 1 - ALPHA / choices)
    return Score(value=value, low=max(-1.0, value - half), high=min(1.0, value + half))


def _misreading(trials: Sequence[Trial]) -> Score | None:
    found = [claims for trial in ended(trials) if (claims := trial_claims(trial)).claims]
    if not found:
        return None
    return _clustered([one.misinterpreted for one in found], [len(one.claims) for one in found])


def _clustered(counts: Sequence[int], sizes: Sequence[int]) -> Score:
    found = clustered_proportion(counts, sizes)
    return Score(value=found.value, low=found.low, high=found.high)


def _loops(told: Sequence[Sequence[Trial]]) -> Score:
    found = [outcomes(trials).looped for trials in told]
    chance = [
        expected_loop_rate([trial.actions for trial in trials], "uniform", actions=len(trials[0].joints)).probability
        for trials in told
    ]
    share, expected = share_over_levels([proportion(int(one.sum()), len(one)) for one in found]), fmean(chance)
    return Score(value=share.value - expected, low=share.low - expected, high=share.high - expected)


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
        parts.append(_clustered(counts, [len(one) for one in judged]))
        chance.append(fmean(step.by_chance["optimal"] for step in steps))
        actions += len(steps)
    if not parts:
        return None
    value = fmean(part.value for part in parts)
    down = math.hypot(*(part.value - part.low for part in parts)) / len(parts)
    up = math.hypot(*(part.high - part.value for part in parts)) / len(parts)
    return Rational(value=value, low=value - down, high=value + up, chance=fmean(chance), actions=actions)
