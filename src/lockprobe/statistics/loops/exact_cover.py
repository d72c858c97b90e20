"""The maximum cover of a trial by disjoint copies of loops, by dynamic programming.

Choosing disjoint pieces of greatest total length is interval scheduling: the best cover of the trial from action i on
follows from the best covers from later actions on. A loop of 2 m actions or more, m the shortest length, is two loops
in a row, so loops of m to 2 m - 1 actions already cover as much as all: the cost is linear in the trial.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.loops import kernels
from lockprobe.statistics.loops.alphabet import Codes, actions_of, letters, numbered, refuse_nan
from lockprobe.statistics.loops.automaton import loops_from
from lockprobe.statistics.loops.words import TRIAL_LENGTH, Interval, any_loop, named

__all__ = ["SEARCHED", "SHORT", "Words", "copies", "free_pieces", "in_order", "trial_pieces"]

Words = tuple[tuple[Hashable, ...], ...]

SHORT = 50
"""Up to here a trial is not worth the arrays of the compiled functions."""

SEARCHED = 150
"""Up to here loops are searched in the text, whose time grows with the square of the trial."""


def free_pieces(
    sequence: Sequence[Hashable] | NDArray[Any], min_length: int, *, overlap: bool
) -> tuple[list[Interval], Words]:
    """The pieces of the maximum cover, and their distinct words in order."""
    n = len(sequence)
    if min_length > n:
        refuse_nan(actions_of(sequence))
        return [], ()
    if n > SHORT and (fast := kernels.compiled(kernels.free_cover, n)):
        starts, lengths, fresh = fast(numbered(sequence), min_length, overlap, TRIAL_LENGTH)
        pieces = list(zip(starts.tolist(), lengths.tolist(), strict=True))
        return pieces, in_order(sequence, [pieces[k] for k in fresh.nonzero()[0]])
    if n <= TRIAL_LENGTH:
        pieces = trial_pieces(letters(sequence), min_length, overlap=overlap)
    else:
        reach = _longest_loops_up_to(2 * min_length - 1, numbered(sequence), min_length, overlap=overlap)
        pieces = _fewest_longest(reach, min_length)
    return pieces, in_order(sequence, pieces)


def trial_pieces(text: str, min_length: int, *, overlap: bool = False) -> list[Interval]:
    """The pieces of a trial's maximum cover, from loops of any length.

    Short trials are searched, longer ones named length by length if no loop is long, else an automaton is grown.
    """
    if len(text) <= SEARCHED:
        reach = _longest_loops(text, min_length, overlap=overlap)
        if not any(reach):
            return []
    elif any_loop(text, min_length=max(kernels.NAMED, min_length), overlap=overlap):
        reach = loops_from(text, overlap=overlap)
    else:
        reach = _longest_loops_up_to(kernels.NAMED, numbered(text), min_length, overlap=overlap)
    return [part for piece in _fewest_longest(reach, min_length) for part in copies(text, piece, min_length)]


def in_order(sequence: Sequence[Hashable] | NDArray[Any], pieces: Sequence[Interval]) -> Words:
    """The distinct words of some pieces, in order of first appearance."""
    actions = actions_of(sequence)
    return tuple(dict.fromkeys([tuple(actions[start : start + length]) for start, length in pieces]))


def copies(text: str, piece: Interval, min_length: int) -> list[Interval]:
    """A piece as the copies of its shortest loop that it repeats; itself if it repeats none."""
    start, length = piece
    if length < 2 * min_length:
        return [piece]
    word = text[start : start + length]
    for size in range(min_length, length // 2 + 1):
        if length % size == 0 and word == word[:size] * (length // size):
            return [(at, size) for at in range(start, start + length, size)]
    return [piece]


def _longest_loops(text: str, min_length: int, *, overlap: bool) -> list[int]:
    """For each start the length of the longest loop there, 0 for none.

    Every part of a loop (of ``min_length`` or more) is a loop. So as the start goes left the end of the longest never
    goes right: at most 2 n searches.
    """
    reach = [0] * (len(text) + 1)
    end = len(text)
    for start in range(len(text) - min_length, -1, -1):
        while end - start >= min_length:
            word = text[start:end]
            if text.rfind(word) > text.find(word) if overlap else text.count(word) > 1:
                reach[start] = len(word)
                break
            end -= 1
    return reach


def _longest_loops_up_to(longest: int, codes: Codes, min_length: int, *, overlap: bool) -> list[int]:
    """The same for loops of at most ``longest`` actions, by naming the words of 1, 2, 3, ... actions."""
    reach = np.zeros(len(codes) + 1, dtype=np.int64)
    names = np.zeros_like(codes)
    for length in range(1, longest + 1):
        names = named(names, codes[length - 1 :])
        last = np.zeros_like(names)
        last[names] = np.arange(len(names))
        looping = last[names] - names >= (1 if overlap else max(length, min_length))
        if not looping.any():
            break
        if length >= min_length:
            reach[: len(names)][looping] = length
    lengths: list[int] = reach.tolist()
    return lengths


def _fewest_longest(reach: list[int], min_length: int) -> list[Interval]:
    """The greatest cover of fewest pieces; of those, the first piece starts earliest, is longest, and so on.

    From the right: ``worth[i]`` is the number of actions before action i, and of those that are covered from there on,
    one action counting more than all pieces together. A piece from i may end anywhere in a window whose right edge
    only moves left, so a queue of candidate ends with falling worth gives its best end, in linear time over all i.
    """
    n = len(reach) - 1
    one = n + 1
    worth, length = list(range(0, one * one, one)), [0] * one
    ends: deque[int] = deque()
    best = worth[max(n - min_length + 1, 0)]
    for start in range(n - min_length, -1, -1):
        nearest = start + min_length
        while ends and worth[ends[-1]] < worth[nearest]:
            ends.pop()
        ends.append(nearest)
        best -= one
        longest = reach[start]
        if longest >= min_length:
            while ends[0] > start + longest:
                ends.popleft()
            end = ends[0]
            if worth[end] > best:
                best, length[start] = worth[end] - 1, end - start
        worth[start] = best
    pieces, start = [], 0
    while start < n:
        if length[start]:
            pieces.append((start, length[start]))
        start += length[start] or 1
    return pieces
