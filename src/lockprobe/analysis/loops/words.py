"""What an action loop is: a run of consecutive actions that stands at least twice in one trial (paper, Sec. 3.3)."""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.errors import BadValue

__all__ = ["any_loop", "any_loop_batch", "least_distance", "onset_batch", "parse_sequence"]


def parse_sequence(line: str) -> tuple[str, ...]:
    """Reads one trial from a line of text.

    Actions are separated by blanks or commas. A line without any separator is read one action per character:
    ``ABCABC`` is six actions (and ``slider1`` seven: write ``slider1,`` for a trial of that one action).

    >>> parse_sequence("left, right up")
    ('left', 'right', 'up')
    """
    text = line.strip()
    if not re.search(r"[\s,]", text):
        return tuple(text)
    return tuple(re.findall(r"[^\s,]+", text))


def any_loop(sequence: Sequence[Hashable], *, min_length: int = 3, overlap: bool = False) -> bool:
    """Whether a trial holds a loop; settings as in :func:`cover`. Words of ``min_length`` decide."""
    apart = least_distance(min_length, overlap=overlap)
    first: dict[tuple[Hashable, ...], int] = {}
    for start in range(len(sequence) - min_length + 1):
        word = tuple(sequence[start : start + min_length])
        if start - first.setdefault(word, start) >= apart:
            return True
    return False


def any_loop_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.bool_]:
    """As :func:`any_loop` for many trials: integers of shape (trials, n) in, shape (trials,) out."""
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    steps, undecided = np.ascontiguousarray(sequences.T), np.arange(len(sequences))
    found = np.zeros(len(sequences), dtype=np.bool_)
    for distance in range(least_distance(min_length, overlap=overlap), len(steps) - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        starts = len(same) - min_length + 1
        run = same[:starts].copy()
        for offset in range(1, min_length):
            run &= same[offset : offset + starts]
        looping = run.any(axis=0)
        found[undecided[looping]] = True
        undecided, steps = undecided[~looping], steps[:, ~looping]
    return found


def onset_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.int64]:
    """The step at which the first loop of each trial is complete.

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length.

    Args:
        sequences: Actions as integers, shape (trials, n).
        min_length: Fewest actions in a loop.
        overlap: Whether the two copies may share actions.

    Returns:
        Steps from 1, shape (trials,); 0 where a trial holds no loop.
    """
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    steps = np.ascontiguousarray(sequences.T)
    n = len(steps)
    first = np.full(len(sequences), n + 1)
    for distance in range(least_distance(min_length, overlap=overlap), n - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        starts = len(same) - min_length + 1
        run = same[:starts].copy()
        for offset in range(1, min_length):
            run &= same[offset : offset + starts]
        found = np.where(run.any(axis=0), run.argmax(axis=0) + distance + min_length, n + 1)
        np.minimum(first, found, out=first)
    return np.where(first > n, 0, first)


def least_distance(min_length: int, *, overlap: bool) -> int:
    """Least distance between the starts of two copies of a word of ``min_length``."""
    if min_length < 1:
        raise BadValue("shortest loop", min_length, "at least 1 action")
    return 1 if overlap else min_length
