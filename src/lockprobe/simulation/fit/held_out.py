"""Cross-validation: prediction of held-out choices.

Folds keep clusters whole: trials of equal repetition and trial, or all trials of one person, are held out together, so
that nothing leaks from a trial to its twin at another p. The version of a model is chosen on the training folds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lockprobe.simulation.fit.choices import Choices
from lockprobe.simulation.fit.likelihood import Model
from lockprobe.simulation.fit.optimise import Maximum, maximise, students_t
from lockprobe.simulation.fit.result import Predicted

__all__ = ["folds_of", "held_out", "predicted"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def folds_of(clusters: Integers, folds: int) -> Integers:
    """The fold of each choice, from 0, by its cluster; the number of folds is at most the number of clusters."""
    place: Integers = np.unique(clusters, return_inverse=True)[1].reshape(-1)
    return place % folds


def held_out(versions: Mapping[str, Model], fitted: Mapping[str, Maximum], fold: Integers, present: Flags) -> Array:
    """Probabilities of all joints at each choice, from a fit to the other folds, shape (choices, joints).

    With n fitted choices, chance is mixed in with weight 1 / (n + 1), so that no log-likelihood is infinite.

    Args:
        versions: The model's versions.
        fitted: Their maxima over all choices, as starting values.
        fold: The fold of each choice, shape (choices,).
        present: Whether each joint exists, shape (choices, joints).
    """
    chances = np.empty(present.shape)
    for part in range(int(fold.max(initial=-1)) + 1):
        out = fold == part
        refitted = {name: maximise(model.at(~out), fitted[name].values) for name, model in versions.items()}
        best = max(refitted, key=lambda name: refitted[name].log_likelihood)
        model = versions[best].at(out)
        slip = 1 / (int((~out).sum()) + 1)
        chance = present[out] / present[out].sum(axis=1, keepdims=True)
        chances[out] = slip * chance + (1 - slip) * model.probabilities(refitted[best].values)
    return chances


def predicted(choices: Choices, chances: Array) -> Predicted:
    """Score predicted probabilities, shape (choices, joints), at the choices made (at least one).

    The interval is for a ratio of sums over clusters, with Student's t.
    """
    mine = chances[np.arange(len(choices)), choices.chosen]
    terms = np.log(np.maximum(mine, 1e-300))
    gains = (terms + np.log(choices.joints)) / math.log(2)
    likeliest = chances >= chances.max(axis=1, keepdims=True) - 1e-9
    hits = likeliest[np.arange(len(choices)), choices.chosen] / likeliest.sum(axis=1)
    gain, place = float(gains.mean()), np.unique(choices.cluster, return_inverse=True)[1].reshape(-1)
    k, low, high = int(place.max()) + 1, None, None
    if k > 1:
        off = np.bincount(place, weights=gains - gain)
        half = students_t(k) * math.sqrt(k / (k - 1) * float(off @ off)) / len(choices)
        low, high = gain - half, gain + half
    mean = float(terms.mean())
    return Predicted(
        log_likelihood=mean,
        gain=gain,
        low=low,
        high=high,
        probability=math.exp(mean),
        hits=float(hits.mean()),
    )
