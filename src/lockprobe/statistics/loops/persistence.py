"""Persistence: whether agents leave loops, and repeat joints that were reported blocked.

The paper says that the agent "eventually breaks out" of loops, and that an unchanged state gives no signal "to drive
exploration toward alternative actions" (Sec. 3.3). Actions are compared with random choices at the same steps, uniform
and without immediate repeats. Given the past, each such choice has a known chance. So the sum over a trial of what
happened minus its chance has mean 0, whatever the length of trials, and Student's t over trials (or players) tests it.
An agent is said to differ from chance where it differs from both, in the same direction.

- *A loop is left* if, after the first loop of a trial is complete, some action differs from the action d steps before,
  where d is the distance of the loop's copies. A loop with no step after it is not counted.
- *An action leaves a loop* if the three actions before it have stood in this order before, without overlap, and it is
  not the action that followed the latest such copy. The share of actions in a loop that leave it is the hazard of
  escape.
- *An action is repeated* if its joint was reported blocked since the last report of a move. Only actions that follow
  such a report count, and only while another joint is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.clustered import ClusteredProportion, clustered_proportion
from lockprobe.statistics.distributions import student_test
from lockprobe.statistics.outcomes import ended, onset
from lockprobe.trial.record import Trial

__all__ = ["Persistence", "VersusChance", "escapes", "loop_left", "persistence", "repeats"]

_LOOP = 3
"""Fewest actions in a loop (Sec. 3.3)."""


Choice = tuple[bool, float, float]
"""Whether an action is of a kind; its probability for uniformly random actions; and without immediate repeats."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VersusChance:
    """The share of actions of one kind, compared with chance. Clusters are trials, or all trials of one player.

    Attributes:
        share: Share of actions of this kind, among the actions that could be.
        uniform: The share expected of uniformly random actions at the same steps, [0, 1]; None without such steps.
        no_repeat: The share expected of random actions without immediate repeats.
        p_value: The larger of Student's t tests against both, two-sided; 1 if they point in different directions; None
            with fewer than seven clusters.
        direction: 1 if more than both, -1 if less than both, else 0.
    """

    share: ClusteredProportion
    uniform: float | None
    no_repeat: float | None
    p_value: float | None
    direction: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Persistence:
    """Persistence in the trials of one condition.

    Attributes:
        left: Share of trials that left their first loop, of those that went on after it.
        left_by_chance: The share expected of uniformly random actions in as many steps, [0, 1]; None without a loop.
        escaped: Share of actions that leave a loop, among actions in a loop (the hazard of escape).
        repeated: Share of actions that retry a joint just reported blocked, among actions with an alternative.
    """

    left: ClusteredProportion
    left_by_chance: float | None
    escaped: VersusChance
    repeated: VersusChance


def persistence(trials: Sequence[Trial]) -> Persistence:
    """The persistence in the trials of one condition; error trials are left out."""
    counted = ended(trials)
    owner = np.unique([trial.player or trial.key for trial in counted], return_inverse=True)[1].reshape(-1)
    went_on = [(i, found) for i, trial in enumerate(counted) if (found := loop_left(trial)) is not None]
    return Persistence(
        left=_share(owner[[i for i, _ in went_on]] if went_on else owner[:0], [left for _, (left, _) in went_on]),
        left_by_chance=fmean(chance for _, (_, chance) in went_on) if went_on else None,
        escaped=_compared_with_chance(owner, [escapes(trial) for trial in counted]),
        repeated=_compared_with_chance(owner, [repeats(trial) for trial in counted]),
    )


def _compared_with_chance(owner: NDArray[np.int64], choices: Sequence[list[Choice]]) -> VersusChance:
    """Compare the choices of all trials with chance."""
    who = np.repeat(owner, [len(one) for one in choices])
    happened, *chances = np.array([choice for one in choices for choice in one], dtype=np.float64).reshape(-1, 3).T
    clusters, place = np.unique(who, return_inverse=True)
    p_values, directions = [], set[int]()
    for chance in chances:
        beyond = np.bincount(place, weights=happened - chance, minlength=len(clusters)).astype(np.float64)
        p_values.append(_p_value(beyond))
        directions.add(int(np.sign(np.round(beyond.sum(), 9))))
    direction = directions.pop() if len(directions) == 1 else 0
    known = [p for p in p_values if p is not None]
    return VersusChance(
        share=_share(who, happened.tolist()),
        uniform=float(chances[0].mean()) if len(who) else None,
        no_repeat=float(chances[1].mean()) if len(who) else None,
        p_value=None if len(known) < 2 else max(known) if direction else 1.0,
        direction=direction,
    )


def loop_left(trial: Trial) -> tuple[bool, float] | None:
    """Whether the first loop was left, and the chance of that under random actions; None if the trial ended with it."""
    complete, actions = onset(trial), trial.actions
    if not complete or complete == len(actions):
        return None
    start = complete - _LOOP
    word = actions[start:complete]
    first = next(s for s in range(start - _LOOP, -1, -1) if actions[s : s + _LOOP] == word)
    apart, after = start - first, range(complete, len(actions))
    return any(actions[i] != actions[i - apart] for i in after), 1 - (1 / len(trial.joints)) ** len(after)


def escapes(trial: Trial) -> list[Choice]:
    """For every action in a loop: whether it leaves the loop, and its probability under both kinds of chance."""
    from lockprobe.statistics.branch import continuation  # it imports the summary of an agent, which imports this

    found, actions, n = list[Choice](), trial.actions, len(trial.joints)
    for i in range(1, len(actions)):
        on = continuation(actions[:i])
        if on is not None:
            found.append((actions[i] != on, 1 - 1 / n, 1.0 if on == actions[i - 1] else 1 - 1 / max(n - 1, 1)))
    return found


def repeats(trial: Trial) -> list[Choice]:
    """For every action that counts: whether it retries a joint just reported blocked, and the probability of that."""
    found, tried, last, n = list[Choice](), set[str](), "", len(trial.joints)
    for step in trial.steps:
        if 0 < len(tried) < n:
            found.append((step.joint in tried, len(tried) / n, (len(tried) - (last in tried)) / (n - 1)))
        if step.told_moved is not None:  # a step without a report tells nothing
            tried = set() if step.told_moved else tried | {step.joint}
        last = step.joint
    return found


def _share(owner: NDArray[np.int64], happened: Sequence[float]) -> ClusteredProportion:
    return clustered_proportion(np.bincount(owner, weights=np.array(happened, dtype=float)), np.bincount(owner))


def _p_value(beyond: NDArray[np.float64]) -> float | None:
    """Student's t-test that sums over clusters have mean 0; a sign test if all sums are equal."""
    if len(beyond) < 7:
        return None
    if np.ptp(beyond) < 1e-9:
        return 1.0 if abs(beyond[0]) < 1e-9 else 2.0 ** (1 - len(beyond))
    return student_test(beyond)
