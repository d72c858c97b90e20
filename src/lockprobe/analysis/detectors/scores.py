"""Scores of how repetitive a trial is, higher for more; alone they say nothing, and a threshold belongs to each.

All take the actions in order and need no outcomes. None depends on what the actions are called. A trial without
actions scores 0.
"""

from __future__ import annotations

import zlib
from collections.abc import Hashable, Sequence
from operator import eq

from lockprobe.analysis.loops import cover
from lockprobe.analysis.loops.alphabet import letters

__all__ = ["autocorrelation", "compression", "coverage", "determinism", "phrase_length"]


def coverage(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The share of the trial in its best cover by loops, [0, 1] (paper, Sec. 3.3)."""
    return cover(actions).share


def autocorrelation(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The greatest share of actions that equal the one some steps before, over lags up to half the trial, [0, 1].

    A lag of k steps compares n - k pairs.
    """
    text, n = letters(actions), len(actions)
    return max((sum(map(eq, text, text[lag:])) / (n - lag) for lag in range(1, n // 2 + 1)), default=0.0)


def determinism(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The share of recurrences that are followed or preceded by another one, [0, 1].

    A recurrence is a pair of steps with the same action: a point of the recurrence plot. It counts where it lies on
    a diagonal of two points or more.
    """
    text = letters(actions)
    points = on_diagonals = 0
    for lag in range(1, len(text)):
        diagonal = bytes(map(eq, text, text[lag:]))
        points += sum(diagonal)
        on_diagonals += sum(len(run) for run in diagonal.split(b"\0") if len(run) >= 2)
    return on_diagonals / points if points else 0.0


def phrase_length(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """The mean length of the phrases of Lempel and Ziv (1976), 1 or more: the trial's length over its complexity.

    Each phrase is the shortest run that is not a copy of an earlier one (which may reach into the phrase itself);
    the last may be cut short by the end.
    """
    text, n = letters(actions), len(actions)
    start = phrases = 0
    while start < n:
        end = start + 1
        while end < n and text.find(text[start:end], 0, end - 1) >= 0:
            end += 1
        start, phrases = end, phrases + 1
    return n / phrases if phrases else 0.0


def compression(actions: Sequence[Hashable], moved: Sequence[bool] = ()) -> float:
    """Actions per byte of the trial compressed as a raw deflate stream."""
    packer = zlib.compressobj(9, wbits=-15)
    packed = packer.compress(letters(actions).encode("utf-8", "surrogatepass")) + packer.flush()
    return len(actions) / len(packed)
