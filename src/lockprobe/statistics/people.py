"""Human participants: shares of their boxes, and the steps that they need.

People count as one agent. A person plays several boxes and may learn from box to box, which agents cannot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.clustered import crossed_proportion
from lockprobe.statistics.outcomes import ended
from lockprobe.statistics.proportions import Proportion
from lockprobe.trial.record import Trial

RESAMPLES = 2000

Array = NDArray[np.float64]


def success_of_people(begun: Sequence[Trial]) -> Proportion:
    """The share of ended trials that were solved, with an interval that holds whatever became of broken ones."""

    def share(trials: Sequence[Trial], broken: bool) -> Proportion:
        solved = [broken if trial.ending == "error" else trial.solved for trial in trials]
        return crossed_proportion(solved, np.ones(len(trials)), *_labels(trials))

    return replace(share(ended(begun), False), low=share(begun, False).low, high=share(begun, True).high)


def steps_of_people(
    trials: Sequence[Trial], modality: str, condition: str = ""
) -> tuple[int | None, int | None, int | None, float]:
    """Steps that people needed to open a box: the Kaplan-Meier median with its 95 % interval, and the mean.

    Of ended trials, at least one, of a modality and a condition (empty for several), which name the stream of the
    draws. An unsolved trial is censored at its budget, with which it counts in the mean. What lies beyond the budget is
    None, as both ends are with a single person or luck.
    """
    budget = max(trial.budget for trial in trials)
    steps = np.array([len(trial.steps) if trial.solved else budget + 1 for trial in trials])
    reached = (steps[:, None] <= np.arange(budget + 1)).astype(np.float64)  # solved by step 0, 1, ..., the budget
    first, shares = trials[0], reached.mean(axis=0)
    # that of a condition of flips alone is named after its rate, whatever its label is
    place = (condition if first.p is None else str(first.p)) if condition else "None"
    rng = generator(first.seed, "analysis", first.spec, modality, place, "people")
    low = high = math.inf
    if medians := [_median(one) for one in _drawn(trials, rng, reached)]:
        low = min(float(np.percentile(one, 2.5, method="lower")) for one in medians)
        high = max(float(np.percentile(one, 97.5, method="higher")) for one in medians)
    median, first_low, last_high = (int(step) if step <= budget else None for step in (int(_median(shares)), low, high))
    return median, first_low, last_high, float(np.sum(1 - shares[:-1]))


def _labels(trials: Sequence[Trial]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The player and the luck of each trial, numbered from 0."""
    names = [trial.agent for trial in trials], [f"{trial.repetition}/{trial.trial}" for trial in trials]
    person, luck = (np.unique(of, return_inverse=True)[1].reshape(-1).astype(np.int64) for of in names)
    return person, luck


def _drawn(trials: Sequence[Trial], rng: np.random.Generator, reached: Array) -> list[Array]:
    """Shares solved by each step, shape (resamples, steps), in two cluster bootstraps: over people, and over luck.

    No bootstrap keeps two crossed kinds of clusters, so each kind is resampled alone, and the wider interval is used.
    If people have unequally many trials, they are resampled once more with every person counted alike, since those who
    left early may differ from those who stayed. There is none with a single person or luck.
    """
    kinds = _labels(trials)
    if min(len(np.unique(kind)) for kind in kinds) < 2:
        return []
    boxes = np.bincount(kinds[0])
    ways = [(kind, np.ones(len(kind))) for kind in kinds]
    if np.ptp(boxes):
        ways.append((kinds[0], 1 / boxes[kinds[0]]))
    found = []
    for kind, weight in ways:
        k = int(kind.max()) + 1
        times = rng.multinomial(k, np.full(k, 1 / k), size=RESAMPLES).astype(np.float64)
        sums = np.zeros((k, reached.shape[1]))
        np.add.at(sums, kind, weight[:, None] * reached)
        found.append(times @ sums / (times @ np.bincount(kind, weight))[:, None])
    return found


def _median(shares: Array) -> NDArray[np.int64]:
    """The first step by which half are solved; the budget plus 1 if that never happens."""
    found: NDArray[np.int64] = np.sum(shares < 0.5 - 1e-12, axis=-1)
    return found
