"""The first loop of a trial: a run of consecutive actions that stands twice (paper, Sec. 3.3)."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue

Trial = Sequence[Hashable] | NDArray[Any]
"""The actions of a trial in order; of an array, shape (n,)."""


def letters(trial: Trial, min_length: int = 1) -> tuple[Sequence[Hashable], str]:
    """The actions as plain Python values, and as a string of one letter per action, whose searches run in C."""
    if min_length < 1:
        raise BadValue("shortest loop", min_length, "at least 1 action")
    if isinstance(trial, np.ndarray) and trial.ndim != 1:
        raise BadValue("sequence", trial.shape, "an array of shape (n,)")
    actions: Sequence[Hashable] = trial.tolist() if isinstance(trial, np.ndarray) else trial
    names: dict[Hashable, str] = {}
    text = "".join([names.setdefault(action, chr(len(names))) for action in actions])
    if any(action != action for action in names):  # noqa: PLR0124
        raise BadValue("sequence", "NaN", "one action per step; give trials of different length as a list of sequences")
    return actions, text


def any_loop(trial: Trial, *, min_length: int = 3, overlap: bool = False) -> bool:
    """Whether a trial holds a loop; settings as in :func:`cover`."""
    return onset(trial, min_length=min_length, overlap=overlap) > 0


def onset(trial: Trial, *, min_length: int = 3, overlap: bool = False) -> int:
    """The step at which the first loop of a trial is complete, from 1; 0 if it holds none.

    >>> onset("ABCDABC")
    7
    """
    _, text = letters(trial, min_length)
    apart = 1 if overlap else min_length
    first: dict[str, int] = {}
    for start in range(len(text) - min_length + 1):
        if start - first.setdefault(text[start : start + min_length], start) >= apart:
            return start + min_length
    return 0


def onset_batch(trials: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False) -> NDArray[np.int64]:
    """:func:`onset` of many trials, integers of shape (trials, n); shape (trials,).

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length.
    """
    if trials.ndim != 2:
        raise BadValue("sequences", trials.shape, "an array of shape (trials, n)")
    steps = np.ascontiguousarray(trials.T)
    n = len(steps)
    first = np.full(len(trials), n + 1)
    for distance in range(1 if overlap else min_length, n - min_length + 1):
        run, size = steps[:-distance] == steps[distance:], 1
        while size < min_length:  # runs of equal steps, each made of two shorter ones
            more = min(size, min_length - size)
            run = run[:-more] & run[more:]
            size += more
        np.minimum(first, np.where(run.any(axis=0), run.argmax(axis=0) + distance + min_length, n + 1), out=first)
    return np.where(first > n, 0, first)
