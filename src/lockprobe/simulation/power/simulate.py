"""Simulated trials of an agent with known truth, as columns.

The agent acts without immediate repeats. From the fourth step on, the box opens with equal probability at every step,
whatever the joint: loops do nothing, and solved trials are shorter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.power.worlds import Design, World
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes

BUDGET = 20
JOINTS = 4
FIRST = 4
"""The earliest step at which the box opens: the optimum of chain-4."""

ESCAPE = 0.1
"""Chance per step to leave a cycle."""

PERIODS = (3, 4)

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


def simulate_outcomes(truth: World, design: Design, rng: np.random.Generator) -> Outcomes:
    """One study of a simulated agent, one row per trial, by p, repetition and trial."""
    luck = rng.random((len(design.p) * design.clusters, BUDGET, 3))
    onset = onset_batch(actions_of(np.repeat(truth.trap, design.clusters), luck))
    solved = solved_at(np.repeat(truth.success, design.clusters), luck[:, :, 2])
    length = np.where(solved > 0, solved, BUDGET)
    cluster = np.tile(np.arange(design.clusters), len(design.p))
    return Outcomes(
        dose=np.repeat(np.array(design.p, dtype=np.float64), design.clusters),
        repetition=cluster // design.trials + 1,
        trial=cluster % design.trials + 1,
        length=length,
        solved=solved > 0,
        onset=np.where(onset <= length, onset, 0),
    )


def actions_of(trap: Floats, luck: Floats) -> Integers:
    """The joints attempted, even after the box has opened, shape (trials, BUDGET).

    Args:
        trap: Probability per step of falling into a cycle, shape (trials,).
        luck: Uniform random numbers for choices, cycles and solutions, shape (trials, BUDGET, 3).
    """
    n = len(trap)
    actions = np.empty((n, BUDGET), dtype=np.int64)
    actions[:, 0] = luck[:, 0, 0] * JOINTS
    period = np.zeros(n, dtype=np.int64)
    everyone = np.arange(n)
    for t in range(1, BUDGET):
        other = (luck[:, t, 0] * (JOINTS - 1)).astype(np.int64)
        fresh = other + (other >= actions[:, t - 1])
        # One number decides both ways: whether a cycle begins (and its period), or whether it ends.
        chance = luck[:, t, 1]
        begun = np.where(chance < trap / 2, PERIODS[0], PERIODS[1])
        period = np.where(period > 0, np.where(chance < ESCAPE, 0, period), np.where(chance < trap, begun, 0))
        period = np.where(period > t, 0, period)
        actions[:, t] = np.where(period > 0, actions[everyone, np.maximum(t - period, 0)], fresh)
    return actions


def solved_at(success: Floats, luck: Floats) -> Integers:
    """The step at which each trial is solved, 0 if it is not."""
    steps = np.arange(1, BUDGET + 1)
    hazard = (1 - (1 - success) ** (1 / (BUDGET - FIRST + 1)))[:, None] * (steps >= FIRST)
    opened = luck < hazard
    return np.where(opened.any(axis=1), opened.argmax(axis=1) + 1, 0)
