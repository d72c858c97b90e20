"""Planning under a belief: the expected steps and the expected information gain of each attempt.

If every report is true, the expected steps are exact (:mod:`lockprobe.boxes.beliefs.exact`). If reports may be false,
they are QMDP's (Littman, Cassandra and Kaelbling 1995): one step plus the distance averaged over the posterior, which
assumes full knowledge after this attempt. That is a lower bound and gives no credit for information.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.boxes.beliefs.exact import SAME, can_plan, planner
from lockprobe.boxes.beliefs.posterior import OF_OUTCOMES, Belief, compared, entropy

__all__ = ["PlanGoal", "best_joints", "expected_steps", "information", "least", "next_false", "qmdp"]

_KNOWN = 0.95
"""Posterior probability from which an interlock counts as known."""

PlanGoal = Literal["steps", "information"]
"""The aim of an attempt: fewest expected steps, or most expected information about the interlock."""

Floats = NDArray[np.float64]


def expected_steps(belief: Belief) -> Floats:
    """Expected steps to solve the box for each joint if it is attempted next, shape (n,).

    Exact for a naive observer; QMDP's lower bound for others.

    Raises:
        BadValue: If the observer is naive and its prior too large to plan exactly.
    """
    if belief.noise.naive:
        return np.array(planner(belief.interlocks).values(belief.alive, belief.likeliest))
    return qmdp(belief)


def qmdp(belief: Belief) -> Floats:
    """QMDP's expected steps: as if the state were known after the next attempt, shape (n,)."""
    known = belief.interlocks
    every = np.arange(known.joints)
    moves = known.may_move(belief.configuration)
    after = belief.configuration[:, None] ^ (moves.astype(np.int64) << every)
    left = np.take_along_axis(known.distance, after & ~1, axis=1)
    left[:, 0] *= ~moves[:, 0]
    values: Floats = 1.0 + belief.weights @ left
    return values


def information(belief: Belief) -> Floats:
    """Expected information gain about the interlock from attempting each joint next, bits, shape (n,), >= 0.

    An attempt shows whether the box opens; else the outcome told, or the position of the attempted joint where no
    outcome is told, and new positions.
    """
    held = belief.possible.any(axis=0)
    weights, moves = belief.weights[held], belief.interlocks.may_move(belief.configuration)[held]
    if belief.noise.naive:
        share: Floats = np.minimum(weights @ moves, 1.0)
        return _bits(share) + _bits(1.0 - share)
    n = belief.interlocks.joints
    goes_on = np.ones(moves.shape)
    goes_on[:, 0] = ~moves[:, 0]
    false = next_false(belief)[held, None]
    told = np.empty((len(moves), 2 * n))  # the probabilities of "moved", then of "blocked"
    told[:, :n] = np.where(moves, 1.0 - false, false) * goes_on
    told[:, n:] = goes_on - told[:, :n]
    if belief.states_only:
        told = _by_position(told, compared(belief)[held])
    kinds = np.ascontiguousarray(belief.possible[:, held])
    both = _gained((kinds / kinds.sum(axis=0) * weights)[:, :, None] * told, _news(belief)[:, held])
    gained = both[:n] + both[n:]
    ends = weights * moves[:, 0]
    gained[0] += _bits(ends.sum()) - _bits(ends).sum()
    return np.maximum(entropy(belief) + gained, 0.0)


def next_false(belief: Belief) -> Floats:
    """Probability under each interlock that the next report is false, shape (interlocks,)."""
    if belief.noise.p is None:
        return (belief.false + 1) / (belief.told + 2)
    return np.full(len(belief.interlocks), belief.noise.p)


def _by_position(told: Floats, before: NDArray[np.int64]) -> Floats:
    """Probabilities of the reported position of the attempted joint, from those of the reported outcome.

    Args:
        told: Probabilities of the report "moved" for each joint, then of "blocked", shape (interlocks, 2n).
        before: The configuration with which a report is compared, under each interlock, shape (interlocks,).
    """
    n = told.shape[1] // 2
    away = (before[:, None] >> np.arange(n) & 1).astype(bool)
    moved, blocked = told[:, :n], told[:, n:]
    return np.hstack((np.where(away, blocked, moved), np.where(away, moved, blocked)))


def _news(belief: Belief) -> NDArray[np.int64]:
    """The positions before each attempt that a report would show, shape (readings, interlocks, n).

    The attempted joint's reported position follows from its position and the reported outcome.
    """
    where, bit = belief.configuration[:, None], 1 << np.arange(belief.interlocks.joints)
    found = np.zeros((len(belief.noise.kinds), len(where), len(bit)), dtype=np.int64)
    if belief.positions is not None:
        for kind, shown in zip(belief.noise.kinds, found, strict=True):
            others = where if kind in ("memoryless", "re-observed") else belief.positions
            shown[:] = others & ~bit | (belief.positions if kind in OF_OUTCOMES else where) & bit
    return found & ~bit if belief.states_only else found


def _gained(mass: Floats, news: NDArray[np.int64]) -> Floats:
    """Mutual information terms: entropy of the observation minus joint entropy, unnormalised, shape (2n,).

    Args:
        mass: Probability of each kind, interlock and outcome told, shape (kinds, interlocks, 2n).
        news: The positions shown, shape (kinds, interlocks, n).
    """
    columns = mass.shape[-1]
    news = np.concatenate((news, news), axis=-1)
    if len(mass) > 1:  # equal under both kinds: one observation
        alike = news[0] == news[1]
        mass[0] += mass[1] * alike
        mass[1] *= ~alike
    place = (news * columns + np.arange(columns)).ravel()
    shown = np.bincount(place, mass.ravel(), columns << columns // 2).astype(np.float64, copy=False)
    gained: Floats = np.sum(_bits(shown.reshape(-1, columns)), axis=0) - np.sum(_bits(mass), axis=(0, 1))
    return gained


def _bits(share: Floats) -> Floats:
    """-x log2 x, with 0 at 0."""
    found: Floats = share * -np.log2(np.where(share > 0.0, share, 1.0))
    return found + 0.0


def best_joints(belief: Belief, plan: PlanGoal) -> NDArray[np.bool_]:
    """The joints that are optimal under a planning criterion, shape (n,).

    With ``information``, once an interlock has a posterior probability of 0.95, the criterion is the fewest steps.

    Raises:
        BadValue: If the plan is ``steps``, the observer naive and its prior too large to plan exactly.
    """
    if plan == "information":
        bits = information(belief)
        if belief.weights.max() < _KNOWN and bits.max() > SAME:
            return least(-bits)
        if not can_plan(belief.interlocks):
            return least(qmdp(belief))
    return least(expected_steps(belief))


def least(values: Floats) -> NDArray[np.bool_]:
    """Whether each value is the minimum, within rounding, shape (n,)."""
    chosen: NDArray[np.bool_] = values <= values.min() + SAME
    return chosen
