"""Several e-values judged together: closed testing by averages.

The mean of e-values is an e-value of the hypothesis that all of their hypotheses hold, however they depend on each
other. So a hypothesis is rejected if every set of hypotheses that it is in has a mean e-value of 20 or more (closed
testing; Vovk and Wang, Annals of Statistics 2021, Sec. 6). One that is true is then rejected in at most 5 % of studies,
whichever of the others are true, at any look. The sets that decide hold the smallest other e-values.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LARGEST = 600.0
"""Logarithm of the largest e-value that is told apart from larger ones."""


def adjusted(log_e: Array, others: Array | None = None) -> Array:
    """The e-values adjusted for each other: the smallest mean of a set with the hypothesis, as logarithms.

    Args:
        log_e: Logarithms of e-values at each look, shape (looks, hypotheses).
        others: The e-values that each hypothesis is judged beside, of the same shape; the same if None. Of several
            hypotheses of one parameter that exclude each other it is the smallest.

    Returns:
        The same shape; never above ``log_e``.

    >>> np.exp(adjusted(np.log([[40.0, 10.0]]))).round(1).tolist()
    [[25.0, 10.0]]
    """
    found = np.empty_like(log_e)
    for i, (own, sums) in enumerate(_each(log_e, others)):
        sizes = np.arange(1, sums.shape[1] + 1)
        found[:, i] = np.log(((own[:, None] + sums) / sizes).min(axis=1))
    return found


def log_thresholds(log_e: Array, level: float, others: Array | None = None) -> Array:
    """The e-value that each hypothesis needs to be rejected beside the others, as a logarithm.

    It takes the place of 1 / level in the interval of one parameter among several: the interval then excludes the
    hypothesis if and only if closed testing rejects it, and it still covers its own parameter with 1 - level.

    Args:
        log_e: Logarithms of e-values at each look, shape (looks, hypotheses).
        level: Level of the test, (0, 1).
        others: As in :func:`adjusted`.

    Returns:
        Shape (looks, hypotheses); at least log(1 / level).

    >>> np.exp(log_thresholds(np.log([[40.0, 10.0]]), 0.05)).round(6).tolist()
    [[30.0, 20.0]]
    """
    found = np.empty_like(log_e)
    for i, (_, sums) in enumerate(_each(log_e, others)):
        sizes = np.arange(1, sums.shape[1] + 1)
        found[:, i] = np.log((sizes / level - sums).max(axis=1))
    return found


def _each(log_e: Array, others: Array | None) -> list[tuple[Array, Array]]:
    """Each e-value, and the sums of the 0, 1, 2, … smallest others, shape (looks, hypotheses)."""
    e, beside = (np.exp(np.minimum(one, _LARGEST)) for one in (log_e, log_e if others is None else others))
    found = []
    for i in range(e.shape[1]):
        sums = np.sort(np.delete(beside, i, axis=1), axis=1).cumsum(axis=1)
        found.append((e[:, i], np.concatenate([np.zeros((len(e), 1)), sums], axis=1)))
    return found
