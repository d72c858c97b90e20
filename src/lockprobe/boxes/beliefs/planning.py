"""Planning under a belief: the expected steps and the expected information gain of each attempt.

If every report is true, the expected steps are exact (:mod:`lockprobe.boxes.beliefs.exact`). If reports may be false,
they are QMDP's (Littman, Cassandra and Kaelbling 1995): one step plus the distance averaged over the posterior, which
assumes full knowledge after this attempt. That is a lower bound and gives no credit for information.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.beliefs.exact import SAME, can_plan, planner
from lockprobe.boxes.beliefs.posterior import OF_OUTCOMES, TRUE_ELSEWHERE, Belief, compared, entropy

_KNOWN = 0.95
"""Posterior probability from which an interlock counts as known."""

PlanGoal = Literal["steps", "information"]
"""The aim of an attempt: fewest expected steps, or most expected information about the interlock."""

Floats = NDArray[np.float64]


def expected_steps(belief: Belief) -> Floats:
    """Expected steps to solve the box for each joint if it is attempted next, shape (n,).

    Exact for a naive observer; QMDP's lower bound for others.
    """
    if belief.noise.naive:
        return np.array(planner(belief.interlocks).values(belief.alive, belief.likeliest))
    return qmdp(belief)


def all_expected_steps(beliefs: Sequence[Belief]) -> Floats:
    """The same of several beliefs over equally many joints, shape (beliefs, n)."""
    return np.array([expected_steps(belief) for belief in beliefs])


def qmdp(belief: Belief) -> Floats:
    """QMDP's expected steps: as if the state were known after the next attempt, shape (n,)."""
    known, configuration = belief.interlocks, belief.configuration
    moves = known.may_move(configuration)
    after = configuration[:, None] ^ (moves << np.arange(known.joints))
    left = known.distance[np.arange(len(known))[:, None], after & ~1]
    left[:, 0] *= ~moves[:, 0]
    values: Floats = 1.0 + belief.weights @ left
    return values


def information(belief: Belief) -> Floats:
    """Expected information gain about the interlock from attempting each joint next, bits, shape (n,), >= 0.

    An attempt shows whether the box opens; else the outcome told, or the position of the attempted joint where no
    outcome is told, and new positions.
    """
    held, noise, n = belief.possible.any(axis=0), belief.noise, belief.interlocks.joints
    moves, weights = belief.interlocks.may_move(belief.configuration)[held], belief.weights[held]
    if noise.naive:  # a report says whether the joint moved, and no more
        share: Floats = np.minimum(weights @ moves, 1.0)
        return _bits(share) + _bits(1.0 - share)
    before, configuration = compared(belief)[held, None], belief.configuration[held, None]
    counted = (belief.false[held, None] + 1) / (belief.told + 2)  # the probability that the next report is false
    false = counted if noise.p is None else np.full(counted.shape, noise.p)
    goes_on = np.ones(moves.shape)
    goes_on[:, 0] = ~moves[:, 0]
    moved = np.where(moves, 1.0 - false, false) * goes_on
    blocked = goes_on - moved
    bit = 1 << np.arange(n)
    if belief.states_only:  # what is told is the position of the attempted joint, not the outcome
        away = (before & bit) != 0
        moved, blocked = np.where(away, blocked, moved), np.where(away, moved, blocked)
    possible = belief.possible[:, held]
    mass = (possible / possible.sum(axis=0) * weights)[:, :, None] * np.hstack((moved, blocked))
    # the positions before each attempt that a report would show under each reading; that of the attempted joint
    # follows from its position and the reported outcome
    own, told = (0 if belief.states_only else bit), belief.positions or 0
    news = np.zeros((len(noise.kinds), *moves.shape), dtype=np.int64)
    for kind, shown in zip(noise.kinds, news, strict=True):
        others = configuration if kind in TRUE_ELSEWHERE else told
        attempted = told if kind in OF_OUTCOMES else configuration
        shown[:] = 0 if belief.positions is None else others & ~bit | attempted & own
    both = _gained(mass, np.concatenate((news, news), axis=2), n)
    gained = both[:n] + both[n:]
    ends = weights * moves[:, 0]
    gained[0] += _bits(ends.sum()) - _bits(ends).sum()
    found: Floats = np.maximum(entropy(belief) + gained, 0.0)
    return found


def _gained(mass: Floats, news: NDArray[np.int64], n: int) -> Floats:
    """Mutual information terms: entropy of the observation minus joint entropy, unnormalised, shape (2n,).

    ``mass`` is the probability of each reading, interlock and report ("moved" of each joint, then "blocked"), shape
    (readings, interlocks, 2n), and ``news`` are the positions shown, of the same shape.
    """
    columns = np.arange(2 * n)
    if len(mass) > 1:  # equal under both readings: one observation
        alike = news[0] == news[1]
        mass[0] += mass[1] * alike
        mass[1] *= ~alike
    seen = news * len(columns) + columns
    shown = np.bincount(seen.ravel(), mass.ravel(), len(columns) << n).astype(np.float64, copy=False)
    place = np.broadcast_to(columns, mass.shape)
    gained: Floats = _bits(shown.reshape(1 << n, -1)).sum(axis=0) - np.bincount(
        place.ravel(), _bits(mass).ravel(), len(columns)
    )
    return gained


def _bits(share: Floats) -> Floats:
    """-x log2 x, with 0 at 0."""
    found: Floats = share * -np.log2(np.where(share > 0.0, share, 1.0))
    return found + 0.0


def best_joints(belief: Belief, plan: PlanGoal) -> NDArray[np.bool_]:
    """The joints that are optimal under a planning criterion, shape (n,).

    With ``information``, once an interlock has a posterior probability of 0.95, the criterion is the fewest steps.
    """
    if plan == "information":
        bits = information(belief)
        if belief.weights.max() < _KNOWN and bits.max() > SAME:
            return least(-bits)
        if not can_plan(belief.interlocks):
            return least(qmdp(belief))
    return least(expected_steps(belief))


def least(values: Floats) -> NDArray[np.bool_]:
    """Whether each value is the minimum along the last axis, within rounding, of the same shape."""
    chosen: NDArray[np.bool_] = values <= values.min(axis=-1, keepdims=True) + SAME
    return chosen
