"""Null models of loop rates: the chance levels of a condition's own trials.

A null model keeps one property of the agent and leaves the rest to chance. A loop rate above its level is more than
that property explains. All null models keep the length of every trial, and also:

* ``uniform``, ``no-repeat``: nothing else; any action, or any action except the one before (:mod:`.chance`).
* ``permutation``: the number of times that each trial took each action; their order is random.
* ``markov``: the transition probabilities between actions, pooled over trials. A loop rate at this level needs no
  memory beyond the last action. Orders that differ from trial to trial are mixed, and not explained.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from functools import lru_cache
from math import factorial, prod, sqrt
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.loops import any_loop_batch
from lockprobe.statistics.loops.chance import Chance, chance_level, decisive_length, first_loops, simulated_chance
from lockprobe.statistics.loops.words import least_distance

__all__ = ["TrialNull", "chain_walks", "expected_loop_rate", "markov_chain"]

TrialNull = Literal["uniform", "no-repeat", "markov", "permutation"]
"""The null models, by name."""

CHAINS = 4_000
"""Trials simulated from a fitted chain."""

MOST_ACTIONS = 2_000
"""Distinct actions in the trials for ``markov``, whose chain is their number squared, and for ``permutation``."""

SHUFFLES = 400
"""Shuffles of a trial."""

ENUMERABLE = 2_520
"""The largest number of orders of a trial that are enumerated: every trial of 8 steps over 4 actions."""

LONGEST = 20
"""The most steps of a trial whose orders are enumerated."""

Shape = tuple[int, ...]
"""The number of times that a trial took each of its actions, descending."""

CELLS = 10**8
"""Bounds the simulation of long trials, whose work grows with the square of the length."""


def expected_loop_rate(
    sequences: Sequence[Sequence[Hashable]],
    null: TrialNull,
    *,
    actions: int,
    overlap: bool = False,
    min_length: int = 3,
    seed: int = 0,
) -> Chance:
    """The loop rate expected under a null model, in trials of exactly these lengths.

    Args:
        sequences: The actions of each trial (at least one trial).
        null: The null model.
        actions: Number of actions; ``markov`` and ``permutation`` use the trials' own, at most ``MOST_ACTIONS``.
        overlap: Whether the two copies of a loop may share actions.
        min_length: Fewest actions in a loop.
        seed: Seed of the simulations for ``markov`` and ``permutation``; the other null models have fixed seeds.

    Returns:
        The mean over trials. Its error is an upper bound where levels of several lengths were simulated together.

    >>> expected_loop_rate(["ABCABC", "ABC"], "permutation", actions=3).probability == (6 / 90 + 0) / 2
    True
    """
    if null not in get_args(TrialNull):
        raise BadValue("null", null, ", ".join(get_args(TrialNull)))
    if not sequences:
        raise BadValue("trials", 0, "at least 1")
    seen = len({action for sequence in sequences for action in sequence})
    fitted = null in {"markov", "permutation"}
    if fitted and seen > MOST_ACTIONS:
        raise BadValue(f"distinct actions for the null {null}", seen, f"at most {MOST_ACTIONS}")
    if not fitted and actions < seen:
        raise BadValue("actions", actions, f"at least the {seen} that the trials hold")
    apart = least_distance(min_length, overlap=overlap)
    if max(map(len, sequences)) < apart + min_length:
        return Chance(probability=0.0, method="exact", error=0.0)
    if null == "markov":
        return _markov(sequences, overlap=overlap, min_length=min_length, seed=seed)
    if null == "permutation":
        return _permutation(sequences, overlap=overlap, min_length=min_length, seed=seed)
    lengths = Counter(map(len, sequences))
    levels = {
        length: chance_level(length, actions, null=null, overlap=overlap, min_length=min_length) for length in lengths
    }
    return _mean([(count, levels[length]) for length, count in lengths.items()], independent=False)


def markov_chain(sequences: Sequence[Sequence[Hashable]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The maximum-likelihood first-order Markov chain over the K actions of the trials.

    Counts are pooled over trials and not smoothed. An action that only ends trials is followed by the actions in their
    overall shares.

    Returns:
        Probabilities of the first action, shape (K,), and of each action after each, shape (K, K), in order of
        first appearance.
    """
    names: dict[Hashable, int] = {}
    trials = [[names.setdefault(action, len(names)) for action in sequence] for sequence in sequences if sequence]
    first, after = np.zeros(len(names)), np.zeros((len(names), len(names)))
    for trial in trials:
        first[trial[0]] += 1
        np.add.at(after, (trial[:-1], trial[1:]), 1)
    shares = np.bincount(np.concatenate(trials)) if trials else first
    after[after.sum(axis=1) == 0] = shares
    return first / max(first.sum(), 1), after / after.sum(axis=1, keepdims=True)


def chain_walks(
    first: NDArray[np.float64], after: NDArray[np.float64], luck: NDArray[np.float64]
) -> NDArray[np.integer[Any]]:
    """Walks of a Markov chain.

    Args:
        first: Probabilities of the first action, shape (K,).
        after: Probabilities of each action after each, shape (K, K).
        luck: Independent draws from [0, 1), shape (steps, trials), at least one step.

    Returns:
        Actions from 0 to K - 1, shape (steps, trials).
    """
    walk = np.empty(luck.shape, dtype=np.min_scalar_type(len(first)))
    follows = after.cumsum(axis=1).T[:-1]
    walk[0] = np.searchsorted(first.cumsum()[:-1], luck[0], side="right")
    for step in range(1, len(luck)):
        walk[step] = (follows[:, walk[step - 1]] <= luck[step]).sum(axis=0)
    return walk


def _markov(sequences: Sequence[Sequence[Hashable]], *, overlap: bool, min_length: int, seed: int) -> Chance:
    """One simulation for all lengths: each simulated trial counts as the share of lengths that it loops within."""
    lengths = np.array([len(sequence) for sequence in sequences])
    first, after = markov_chain(sequences)
    steps = min(int(lengths.max()), decisive_length(len(first), min_length))
    trials = min(CHAINS, max(100, CELLS // steps**2))
    walk = chain_walks(first, after, generator(seed, "chance", "markov").random((steps, trials)))
    onsets = first_loops(walk.T, min_length=min_length, overlap=overlap)
    return simulated_chance((onsets > 0) * (lengths >= onsets[:, None]).mean(axis=1))


def _permutation(sequences: Sequence[Sequence[Hashable]], *, overlap: bool, min_length: int, seed: int) -> Chance:
    """The permutation level. Trials with equal action counts share their shuffles; names of actions do not matter."""
    shapes = Counter(tuple(sorted(Counter(sequence).values(), reverse=True)) for sequence in sequences)
    levels = {shape: _every_order(shape, min_length, overlap=overlap) for shape in shapes if _enumerable(shape)}
    if long := sorted(shape for shape in shapes if shape not in levels):
        walks = _shuffled(long, min_length, seed=seed)
        onsets = first_loops(walks.reshape(-1, walks.shape[2]), min_length=min_length, overlap=overlap)
        looping = onsets.reshape(len(long), -1) > 0
        levels |= {shape: simulated_chance(found) for shape, found in zip(long, looping, strict=True)}
    return _mean([(shapes[shape], levels[shape]) for shape in shapes], independent=True)


def _shuffled(shapes: Sequence[Shape], min_length: int, *, seed: int) -> NDArray[np.integer[Any]]:
    """Shuffled trials of each shape, drawn without replacement, shape (shapes, shuffles, steps).

    Only the beginning of long trials is drawn. After its end a trial is padded with unique actions, which make no loop.
    """
    steps = max(min(sum(shape), decisive_length(len(shape), min_length)) for shape in shapes)
    shuffles = min(SHUFFLES, max(20, CELLS // steps**2))
    kinds = max(map(len, shapes))
    counts = np.array([(*shape, *[0] * (kinds + 1 - len(shape))) for shape in shapes], dtype=np.float64)
    left = np.repeat(counts.T, shuffles, axis=1)
    each = np.arange(left.shape[1])
    luck = generator(seed, "chance", "permutation").random((steps, len(each)))
    walks = np.empty((steps, len(each)), dtype=np.min_scalar_type(kinds + steps))
    for step in range(steps):
        below = left[:-1].cumsum(axis=0)
        action = (below <= luck[step] * below[-1]).sum(axis=0)
        walks[step] = action + step * (action == kinds)
        left[action, each] -= 1
    return walks.T.reshape(len(shapes), shuffles, steps)


def _enumerable(shape: Shape) -> bool:
    """Whether all orders of a trial's actions are few enough to enumerate."""
    length = sum(shape)
    return length <= LONGEST and factorial(length) // prod(map(factorial, shape)) <= ENUMERABLE


@lru_cache(maxsize=4096)
def _every_order(shape: Shape, min_length: int, *, overlap: bool) -> Chance:
    """The exact level, from all orders."""
    orders, left = np.zeros((1, 0), dtype=np.int64), np.array([shape])
    for _ in range(sum(shape)):
        which, action = np.nonzero(left)
        orders = np.column_stack((orders[which], action))
        left = left[which]
        left[np.arange(len(left)), action] -= 1
    looping = any_loop_batch(orders, min_length=min_length, overlap=overlap)
    return Chance(probability=float(looping.mean()), method="exact", error=0.0)


def _mean(levels: Sequence[tuple[int, Chance]], *, independent: bool) -> Chance:
    """The mean of levels, weighted by trials. Dependent errors add up, independent ones by squares."""
    trials = sum(count for count, _ in levels)
    errors = [count * level.error / trials for count, level in levels]
    return Chance(
        probability=sum(count * level.probability for count, level in levels) / trials,
        method="exact" if not any(errors) else "simulation",
        error=sqrt(sum(error**2 for error in errors)) if independent else sum(errors),
    )
