"""Persistence: whether agents leave loops, and repeat joints that were reported blocked.

The paper says that the agent "eventually breaks out" of loops, and that an unchanged state gives no signal "to drive
exploration toward alternative actions" (Sec. 3.3). Both counts are compared with uniformly random choices at the same
steps.

- *A loop is left* if, after the first loop of a trial is complete, some action differs from the action d steps before,
  where d is the distance of the loop's copies. A loop with no step after it is not counted.
- *An action is repeated* if its joint was reported blocked since the last report of a move. Only actions that follow
  such a report count, and only while another joint is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from lockprobe.analysis.clustered import ClusteredProportion, clustered_proportion
from lockprobe.analysis.outcomes import ended, onset
from lockprobe.record import Trial

__all__ = ["Persistence", "loop_left", "persistence", "repeats"]

_LOOP = 3
"""Fewest actions in a loop (Sec. 3.3)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Persistence:
    """Persistence in the trials of one condition. Clusters are trials, or all trials of one player.

    Attributes:
        left: Trials in which the first loop was left, of those that went on after it.
        left_by_chance: The share expected of uniformly random actions in as many steps, [0, 1]; None without a loop.
        repeated: Actions that repeat a joint just reported blocked, of those with an alternative.
        repeated_by_chance: The share expected of uniformly random actions at the same steps, [0, 1].
        repeated_p_value: Student's t test of their difference over clusters, two-sided; None with fewer than seven
            clusters.
        repeated_direction: 1 if more is repeated than by chance, -1 if less, 0 if equally much.
    """

    left: ClusteredProportion
    left_by_chance: float | None
    repeated: ClusteredProportion
    repeated_by_chance: float | None
    repeated_p_value: float | None
    repeated_direction: int


def persistence(trials: Sequence[Trial]) -> Persistence:
    """Measure the trials of one condition; error trials are left out."""
    counted = ended(trials)
    owner = np.unique([trial.player or trial.key for trial in counted], return_inverse=True)[1].reshape(-1)
    went_on = [(i, found) for i, trial in enumerate(counted) if (found := loop_left(trial)) is not None]
    places = [(i, again, share) for i, trial in enumerate(counted) for again, share in repeats(trial)]
    who = owner[[i for i, _, _ in places]] if places else np.empty(0, np.int64)
    again = np.array([repeated for _, repeated, _ in places], dtype=np.float64)
    expected = np.array([share for _, _, share in places], dtype=np.float64)
    beyond = np.array([(again - expected)[who == one].sum() for one in np.unique(who)], dtype=np.float64)
    return Persistence(
        left=_share(owner[[i for i, _ in went_on]] if went_on else owner[:0], [left for _, (left, _) in went_on]),
        left_by_chance=fmean(chance for _, (_, chance) in went_on) if went_on else None,
        repeated=_share(who, again.tolist()),
        repeated_by_chance=float(expected.mean()) if places else None,
        repeated_p_value=_p_value(beyond),
        repeated_direction=int(np.sign(np.round(beyond.sum(), 9))),
    )


def loop_left(trial: Trial) -> tuple[bool, float] | None:
    """Whether the first loop was left, and how likely random actions would leave it; None if it did not go on."""
    complete, actions = onset(trial), trial.actions
    if not complete or complete == len(actions):
        return None
    start = complete - _LOOP
    word = actions[start:complete]
    first = next(s for s in range(start - _LOOP, -1, -1) if actions[s : s + _LOOP] == word)
    apart, after = start - first, range(complete, len(actions))
    return any(actions[i] != actions[i - apart] for i in after), 1 - (1 / len(trial.joints)) ** len(after)


def repeats(trial: Trial) -> list[tuple[bool, float]]:
    """For every action that counts: whether it repeats a joint just reported blocked, and the chance of that."""
    found, tried = [], set[str]()
    for step in trial.steps:
        if 0 < len(tried) < len(trial.joints):
            found.append((step.joint in tried, len(tried) / len(trial.joints)))
        if step.told_moved is not None:  # a step without a report tells nothing
            tried = set() if step.told_moved else tried | {step.joint}
    return found


def _share(owner: NDArray[np.int64], happened: Sequence[float]) -> ClusteredProportion:
    return clustered_proportion(np.bincount(owner, weights=np.array(happened, dtype=float)), np.bincount(owner))


def _p_value(beyond: NDArray[np.float64]) -> float | None:
    """Student's t test that sums over clusters have mean 0; a sign test where all are equal."""
    if len(beyond) < 7:
        return None
    if np.ptp(beyond) < 1e-9:
        return 1.0 if abs(beyond[0]) < 1e-9 else 2.0 ** (1 - len(beyond))
    from scipy.stats import ttest_1samp

    return float(ttest_1samp(beyond, 0.0).pvalue)
