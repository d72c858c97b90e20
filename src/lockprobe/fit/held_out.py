"""Prediction of held-out choices.

Clusters of luck stay whole: trials of equal repetition and trial are left out together, so that nothing leaks from a
trial to its twin at another p; so are all trials of one person. Of a model's versions the one is used that fits best
without the trials left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lockprobe.fit.choices import Choices
from lockprobe.fit.likelihood import Model
from lockprobe.fit.optimise import Maximum, maximise, students_t
from lockprobe.fit.result import Predicted

__all__ = ["folds_of", "held_out", "predicted"]

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def folds_of(clusters: Integers, folds: int) -> Integers:
    """The part of each choice, from 0, by its cluster; as many parts as ``folds``, or as there are clusters."""
    place: Integers = np.unique(clusters, return_inverse=True)[1].reshape(-1)
    return place % folds


def held_out(versions: Mapping[str, Model], fitted: Mapping[str, Maximum], fold: Integers, present: Flags) -> Array:
    """Probabilities of all joints, at each choice from a fit to the other parts, shape (choices, joints).

    With n choices fitted, 1 in n + 1 parts of chance is mixed in, so that no surprise counts as infinitely bad.

    Args:
        versions: The model's versions.
        fitted: Their maxima over all choices, where the search begins.
        fold: The part of each choice, shape (choices,).
        present: Which joints there are, shape (choices, joints).
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
    """The value of predictions, probabilities of shape (choices, joints), for at least one choice.

    The interval is that of a ratio of sums over clusters, with Student's t.
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
