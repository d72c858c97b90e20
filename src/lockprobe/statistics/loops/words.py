"""Action loops: runs of consecutive actions that stand at least twice in one trial (paper, Sec. 3.3)."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.loops.alphabet import Codes, actions_of, letters, numbered, refuse_nan

__all__ = [
    "TRIAL_LENGTH",
    "Interval",
    "all_loops",
    "any_loop",
    "any_loop_batch",
    "least_distance",
    "longest_loop",
    "named",
    "onset",
    "onset_batch",
    "whole_copies",
]

Interval = tuple[int, int]
"""A piece of a trial: its first action (from 0) and its length."""

TRIAL_LENGTH = 5000
"""Up to here a sequence is a trial, and loops of any length are its pieces; above it only the shortest ones."""


def any_loop(sequence: Sequence[Hashable] | NDArray[Any], *, min_length: int = 3, overlap: bool = False) -> bool:
    """Whether a trial holds a loop; settings as in :func:`cover`. Words of ``min_length`` decide."""
    return onset(sequence, min_length=min_length, overlap=overlap) > 0


def onset(sequence: Sequence[Hashable] | NDArray[Any], *, min_length: int = 3, overlap: bool = False) -> int:
    """The step at which the first loop of a trial is complete, from 1; 0 if it holds none.

    >>> onset("ABCDABC")
    7
    """
    apart = least_distance(min_length, overlap=overlap)
    actions = actions_of(sequence)
    refuse_nan(set(actions))
    actions = actions if isinstance(actions, str) else tuple(actions)
    first: dict[Sequence[Hashable], int] = {}
    for start in range(len(actions) - min_length + 1):
        if start - first.setdefault(actions[start : start + min_length], start) >= apart:
            return start + min_length
    return 0


def any_loop_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.bool_]:
    """As :func:`any_loop` for many trials: integers of shape (trials, n) in, shape (trials,) out."""
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    refuse_nan(sequences)
    steps, undecided = np.ascontiguousarray(sequences.T), np.arange(len(sequences))
    found = np.zeros(len(sequences), dtype=np.bool_)
    for distance in range(least_distance(min_length, overlap=overlap), len(steps) - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        run = _runs(same, min_length)
        looping = run.any(axis=0)
        found[undecided[looping]] = True
        undecided, steps = undecided[~looping], steps[:, ~looping]
    return found


def onset_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.int64]:
    """The step at which the first loop of each trial is complete, from 1, shape (trials,); 0 without a loop.

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length. Sequences are
    integers of shape (trials, n); settings as in :func:`cover`.
    """
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    refuse_nan(sequences)
    steps = np.ascontiguousarray(sequences.T)
    n = len(steps)
    first = np.full(len(sequences), n + 1)
    for distance in range(least_distance(min_length, overlap=overlap), n - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        run = _runs(same, min_length)
        found = np.where(run.any(axis=0), run.argmax(axis=0) + distance + min_length, n + 1)
        np.minimum(first, found, out=first)
    return np.where(first > n, 0, first)


def _runs(same: NDArray[np.bool_], length: int) -> NDArray[np.bool_]:
    """Where runs of ``length`` steps begin, from where single ones are; each is made of two shorter runs."""
    size = 1
    while size < length:
        more = min(size, length - size)
        same = same[:-more] & same[more:]
        size += more
    return same


def longest_loop(sequence: Sequence[Hashable] | NDArray[Any], *, min_length: int = 3, overlap: bool = False) -> int:
    """Actions in the longest loop of a trial; 0 if it holds none.

    A part of a loop repeats as the loop does, so lengths are tried upwards: some 2 n searches of the text up to
    ``TRIAL_LENGTH``, above it a number of sorts that grows with the logarithm of the result.

    >>> longest_loop("ABCDABCD")
    4
    """
    least_distance(min_length, overlap=overlap)
    actions = actions_of(sequence)
    if len(actions) > TRIAL_LENGTH:
        length = _longest_by_doubling(numbered(sequence), overlap=overlap)
        return length if length >= min_length else 0
    text, start, length = letters(actions), 0, min_length
    while start + length <= len(text):
        if text.rfind(text[start : start + length]) - start >= (1 if overlap else length):
            length += 1
        else:
            start += 1
    return length - 1 if length > min_length else 0


def _longest_by_doubling(codes: Codes, *, overlap: bool) -> int:
    """Words of 1, 2, 4, ... actions while some repeats; then the longest again, lengthened by those that fit."""

    def repeats(names: Codes, length: int) -> bool:
        return bool((np.arange(len(names)) - names).max(initial=0) >= (1 if overlap else length))

    doubled = [named(np.zeros_like(codes), codes)]
    while repeats(doubled[-1], length := 1 << (len(doubled) - 1)):
        doubled.append(named(doubled[-1][:-length], doubled[-1][length:]))
    words, longest = doubled[0], 0
    for power in reversed(range(len(doubled) - 1)):
        more = doubled[power]
        longer = named(words[: len(more) - longest], more[longest:]) if longest else more
        if repeats(longer, longest + (1 << power)):
            words, longest = longer, longest + (1 << power)
    return longest


def named(left: Codes, right: Codes) -> Codes:
    """Names pairs of numbers, aligned and as long as the shorter: by the place where the same pair first stands."""
    size = min(len(left), len(right))
    pairs = left[:size] * (right.max(initial=0) + 1) + right[:size]
    most = int(pairs.max(initial=0))
    if most > 16 * size:
        _, first, same = np.unique(pairs, return_index=True, return_inverse=True)
        return np.asarray(first[same], dtype=np.int64)
    place = np.empty(most + 1, dtype=np.int64)
    place[pairs[::-1]] = np.arange(size - 1, -1, -1)  # of equal pairs the last one written stays, the first of all
    return np.asarray(place[pairs], dtype=np.int64)


def all_loops(text: str, min_length: int, *, overlap: bool = False, below: int | None = None) -> dict[str, list[int]]:
    """All loops of a trial (of less than ``below`` actions) with the starts of all their copies, short ones first."""
    loops: dict[str, list[int]] = {}
    for length in range(min_length, min(below or len(text), len(text))):
        starts: dict[str, list[int]] = {}
        for start in range(len(text) - length + 1):
            starts.setdefault(text[start : start + length], []).append(start)
        apart = 1 if overlap else length
        found = {word: at for word, at in starts.items() if at[-1] - at[0] >= apart}
        if not found:
            break
        loops.update(found)
    return loops


def whole_copies(loops: dict[str, list[int]]) -> list[list[Interval]]:
    """Under ``whole`` a loop comes with all its copies, taken one after another from the left, or not at all."""
    choices = []
    for word, starts in loops.items():
        taken: list[Interval] = []
        for start in starts:
            if not taken or start >= sum(taken[-1]):
                taken.append((start, len(word)))
        if len(taken) > 1:
            choices.append(taken)
    return choices


def least_distance(min_length: int, *, overlap: bool) -> int:
    """Least distance between the starts of two copies of a word of ``min_length``."""
    if min_length < 1:
        raise BadValue("shortest loop", min_length, "at least 1 action")
    return 1 if overlap else min_length
