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
from lockprobe.boxes.beliefs.held import Held, held_by
from lockprobe.boxes.beliefs.posterior import OF_OUTCOMES, TRUE_ELSEWHERE, Belief, Noise, entropy

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
    found: Floats = all_expected_steps([belief])[0]
    return found


def all_expected_steps(beliefs: Sequence[Belief]) -> Floats:
    """The same of several beliefs under one prior and one model of reports, shape (beliefs, n)."""
    known, noise = beliefs[0].interlocks, beliefs[0].noise
    if noise.naive:
        return np.array([planner(known).values(belief.alive, belief.likeliest) for belief in beliefs])
    return _qmdp(beliefs)


def qmdp(belief: Belief) -> Floats:
    """QMDP's expected steps: as if the state were known after the next attempt, shape (n,)."""
    found: Floats = _qmdp([belief])[0]
    return found


def _qmdp(beliefs: Sequence[Belief]) -> Floats:
    known = beliefs[0].interlocks
    configuration = np.array([belief.configuration for belief in beliefs])
    weights = np.array([belief.weights for belief in beliefs])
    moves = known.may_move(configuration)
    after = configuration[:, :, None] ^ (moves << np.arange(known.joints))
    left = known.distance[np.arange(len(known))[:, None], after & ~1]
    left[:, :, 0] *= ~moves[:, :, 0]
    values: Floats = 1.0 + (weights[:, None] @ left)[:, 0]
    return values


def information(belief: Belief) -> Floats:
    """Expected information gain about the interlock from attempting each joint next, bits, shape (n,), >= 0.

    An attempt shows whether the box opens; else the outcome told, or the position of the attempted joint where no
    outcome is told, and new positions.
    """
    found: Floats = all_information([belief])[0]
    return found


def all_information(beliefs: Sequence[Belief]) -> Floats:
    """The same of several beliefs under one prior and one model of reports, shape (beliefs, n)."""
    noise = beliefs[0].noise
    if noise.naive:
        return np.array([_information_of_truth(belief) for belief in beliefs])
    held = held_by(beliefs)
    n, moves, false = held.joints, held.moves, held.false
    goes_on = np.ones(moves.shape)
    goes_on[:, 0] = ~moves[:, 0]
    told = np.empty((len(moves), 2 * n))  # the probabilities of "moved", then of "blocked"
    told[:, :n] = np.where(moves, 1.0 - false, false) * goes_on
    told[:, n:] = goes_on - told[:, :n]
    if held.states_only.any():
        told = np.where(held.states_only, _by_position(told, held.compared), told)
    kinds = held.possible / held.possible.sum(axis=0) * held.weights
    both = _gained(kinds[:, :, None] * told, _news(held, noise), held)
    gained = both[:, :n] + both[:, n:]
    ends = held.weights * moves[:, 0]
    gained[:, 0] += _bits(held.sums(ends)) - held.sums(_bits(ends))
    before = np.array([entropy(belief) for belief in beliefs])
    return np.maximum(before[:, None] + gained, 0.0)


def _information_of_truth(belief: Belief) -> Floats:
    """The expected information where every report is true: it says whether the joint moved, and no more."""
    held = belief.possible.any(axis=0)
    moves = belief.interlocks.may_move(belief.configuration)[held]
    share: Floats = np.minimum(belief.weights[held] @ moves, 1.0)
    return _bits(share) + _bits(1.0 - share)


def _by_position(told: Floats, before: NDArray[np.int64]) -> Floats:
    """Probabilities of the reported position of the attempted joint, from those of the reported outcome.

    Args:
        told: Probabilities of the report "moved" for each joint, then of "blocked", shape (rows, 2n).
        before: The configuration with which a report is compared, shape (rows, 1).
    """
    n = told.shape[1] // 2
    away = (before >> np.arange(n) & 1).astype(bool)
    moved, blocked = told[:, :n], told[:, n:]
    return np.hstack((np.where(away, blocked, moved), np.where(away, moved, blocked)))


def _news(held: Held, noise: Noise) -> NDArray[np.int64]:
    """The positions before each attempt that a report would show, shape (readings, rows, n).

    The attempted joint's reported position follows from its position and the reported outcome.
    """
    bit = 1 << np.arange(held.joints)
    own = bit * ~held.states_only
    found = np.empty((len(noise.kinds), *held.moves.shape), dtype=np.int64)
    for kind, shown in zip(noise.kinds, found, strict=True):
        others = held.configuration if kind in TRUE_ELSEWHERE else held.positions
        attempted = held.positions if kind in OF_OUTCOMES else held.configuration
        shown[:] = (others & ~bit | attempted & own) * held.shown
    return found


def _gained(mass: Floats, news: NDArray[np.int64], held: Held) -> Floats:
    """Mutual information terms: entropy of the observation minus joint entropy, unnormalised, shape (beliefs, 2n).

    Args:
        mass: Probability of each kind, row and outcome told, shape (kinds, rows, 2n).
        news: The positions shown, shape (kinds, rows, n).
        held: The rows.
    """
    n, columns = held.joints, np.arange(2 * held.joints)
    news = np.concatenate((news, news), axis=2)
    if len(mass) > 1:  # equal under both kinds: one observation
        alike = news[0] == news[1]
        mass[0] += mass[1] * alike
        mass[1] *= ~alike
    place = held.belief[:, None] * len(columns) + columns
    seen = news * (held.beliefs * len(columns)) + place
    shown = _sums(seen, mass, held.beliefs * len(columns) << n).reshape(1 << n, held.beliefs, -1)
    joint = _sums(np.broadcast_to(place, mass.shape), _bits(mass), held.beliefs * len(columns))
    gained: Floats = np.sum(_bits(shown), axis=0) - joint.reshape(held.beliefs, -1)
    return gained


def _sums(place: NDArray[np.int64], values: Floats, places: int) -> Floats:
    """The sum of the values at each place, shape (places,)."""
    return np.bincount(place.ravel(), values.ravel(), places).astype(np.float64, copy=False)


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
    """Whether each value is the minimum along the last axis, within rounding, of the same shape."""
    chosen: NDArray[np.bool_] = values <= values.min(axis=-1, keepdims=True) + SAME
    return chosen
