"""Loops, redundant steps, policy entropy, and how many reports are heeded (paper, Sec. 3.3, Fig. 5)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import fmean
from typing import get_args

from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.loops import cover
from lockprobe.statistics.loops.chance import Chance, Null, expected_loop_rate
from lockprobe.statistics.outcomes import ended, numbered, onset, outcomes
from lockprobe.statistics.proportions import ALPHA, Proportion
from lockprobe.trial.record import Trial

REPORTS = 10
"""Fewest differing reports, each with an action after it, for an agent that plays alike to be called blind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Behaviour:
    """The behaviour in the trials of one condition. Error trials are left out.

    Attributes:
        loops: Share of trials that hold an action loop.
        chance: The share expected in trials of exactly these lengths under each null; empty without trials.
        coverage: Mean over trials of :func:`loop_coverage`, [0, 1].
        redundant_share: Mean over trials of :func:`redundant_share`, [0, 1].
        entropy: Mean of :func:`policy_entropy` in bits; None where no step carries choice probabilities.
        entropy_steps: Number of steps that carry choice probabilities.
    """

    loops: Proportion
    chance: Mapping[Null, Chance]
    coverage: float | None
    redundant_share: float | None
    entropy: float | None
    entropy_steps: int

    @property
    def chance_uniform(self) -> float | None:
        """The share expected of uniformly random actions, [0, 1]."""
        return self._chance("uniform")

    @property
    def chance_no_repeat(self) -> float | None:
        """The share expected of random actions without immediate repeats, [0, 1]."""
        return self._chance("no-repeat")

    def _chance(self, null: Null) -> float | None:
        return self.chance[null].probability if self.chance else None


def behaviour(trials: Sequence[Trial]) -> Behaviour:
    """Measure the trials of one condition."""
    counted, found = ended(trials), outcomes(trials)
    entropies = [bits for trial in counted for bits in policy_entropy(trial)]
    return Behaviour(
        loops=share_of(found.looped, found.player, found.luck),
        chance={null: _chance(counted, null) for null in get_args(Null)} if counted else {},
        coverage=fmean(map(loop_coverage, counted)) if counted else None,
        redundant_share=fmean(map(redundant_share, counted)) if counted else None,
        entropy=fmean(entropies) if entropies else None,
        entropy_steps=len(entropies),
    )


def has_loop(trial: Trial) -> bool:
    """Whether some run of three or more actions appears at least twice without overlap (Sec. 3.3)."""
    return onset(trial) > 0


def loop_coverage(trial: Trial) -> float:
    """Share of the trial's steps in the best cover by loops, [0, 1]."""
    return _share(numbered(trial))


def redundant_share(trial: Trial) -> float:
    """Share of steps that retry a joint in a true configuration in which it was already tried, [0, 1].

    With true reports such a step is uninformative; with false reports it can be a check.
    """
    pairs = {(step.state, step.joint) for step in trial.steps}
    return 1.0 - len(pairs) / len(trial.steps) if trial.steps else 0.0


def policy_entropy(trial: Trial) -> list[float]:
    """Entropy in bits of the choice probabilities at each step that carries them."""
    return [
        -sum(p * math.log2(p) for p in step.decision.probabilities if p > 0.0) + 0.0
        for step in trial.steps
        if step.decision.probabilities is not None
    ]


def heeded_at_most(trials: Sequence[Trial]) -> float | None:
    """Upper 95 % bound of the share of reports that a blind agent acts on, (0, 1); None if it is not blind.

    An agent is *blind* if it played each repetition and trial identically at every p though reports differed. Only
    reports that are followed by an action count, and at least :data:`REPORTS` of them are needed. People who play as
    one agent are never blind, because different people play each p.

    The bound is that of Clopper and Pearson for none of n blocks, those in which reports differed. It also holds if the
    agent heeds all reports of some trials and none of the others.
    """
    if trials[0].player:
        return None
    acted: dict[tuple[int, int], set[tuple[str, ...]]] = {}
    told: dict[tuple[int, int], list[tuple[object, ...]]] = {}
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        acted.setdefault(luck, set()).add(trial.actions)
        told.setdefault(luck, []).append(tuple((step.told_moved, step.told_state) for step in trial.steps[:-1]))
    if any(len(ways) > 1 for ways in acted.values()):
        return None
    differing = [sum(len(set(reports)) > 1 for reports in zip(*ways, strict=False)) for ways in told.values()]
    if sum(differing) < REPORTS:
        return None
    return float(1 - ALPHA ** (1 / sum(many > 0 for many in differing)))


@lru_cache(maxsize=1 << 17)
def _share(actions: tuple[int, ...]) -> float:
    return cover(actions).share


def _chance(trials: Sequence[Trial], null: Null) -> Chance:
    """The share of looping trials expected under a null."""
    return expected_loop_rate([trial.actions for trial in trials], null, actions=len(trials[0].joints))
