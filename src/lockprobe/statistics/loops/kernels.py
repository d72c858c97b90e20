"""Compiled free covers of long sequences and of many trials: the only importer of numba here.

Importing numba and compiling cost seconds the first time and a second later on, so that happens only where the work
pays for it (:func:`compiled`). The functions are plain Python on integer arrays and compute the numbers of
:mod:`lockprobe.statistics.loops.exact_cover`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.loops.alphabet import Codes

__all__ = [
    "WORTH_COMPILING",
    "chosen_pieces",
    "compiled",
    "distinct_words",
    "free_cover",
    "free_measures",
    "longest_loops",
    "name_words",
    "packed_words",
    "period",
]

Given = ParamSpec("Given")
Found = TypeVar("Found")

WORTH_COMPILING = 200_000
"""Actions above which compiling pays: without it they take a second as trials of 20, a quarter second as one trial."""

_COMPILED: dict[str, Callable[..., Any]] = {}


def compiled(function: Callable[Given, Found], actions: int) -> Callable[Given, Found] | None:
    """The compiled function, if it is already compiled or this many actions justify it; None without numba."""
    name = function.__name__
    if name not in _COMPILED and actions >= WORTH_COMPILING:
        try:
            from numba import njit
            from numba.extending import register_jitable
        except ImportError:
            return None
        for part in _PARTS:
            register_jitable(part)
        try:
            _COMPILED[name] = njit(cache=True)(function)
        except RuntimeError:  # nowhere to keep what is compiled
            _COMPILED[name] = njit(function)
    return _COMPILED.get(name)


def free_cover(
    codes: Codes, min_length: int, overlap: bool, longest: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """One cover from loops of at most ``longest`` actions, the actions given as numbers from 0.

    Returns:
        Start and length of each piece, and 1 where it is the first copy of its word, each of shape (pieces,).
    """
    n = len(codes)
    table = np.empty(_places(n), np.int64)
    work = np.empty((5, n + 1), np.int64)
    longest_loops(codes, min_length, overlap, longest, work, table)
    count = chosen_pieces(n, min_length, work)
    distinct_words(codes, count, work, table)
    return work[1, :count].copy(), work[2, :count].copy(), work[3, :count].copy()


def free_measures(
    codes: Codes, ends: NDArray[np.int64], min_length: int, overlap: bool, trial: int
) -> NDArray[np.int64]:
    """Measures of many trials: covered, redundant, onset and longest piece, shape (trials, 4).

    Args:
        codes: Actions as numbers from 0, all trials in one row.
        ends: The end of each trial, ascending.
        min_length: Fewest actions in a loop.
        overlap: Whether the two copies may share actions.
        trial: Up to this many actions loops of any length are pieces, above it only the shortest.
    """
    most = 0
    for k in range(len(ends)):
        most = max(most, ends[k] - (ends[k - 1] if k else 0))
    table = np.empty(_places(most), np.int64)
    work = np.empty((5, most + 1), np.int64)
    found = np.zeros((len(ends), 4), np.int64)
    for k in range(len(ends)):
        one = codes[ends[k - 1] if k else 0 : ends[k]]
        n = len(one)
        longest = n if n <= trial else 2 * min_length - 1
        found[k, 2] = longest_loops(one, min_length, overlap, longest, work, table)
        found[k, 3] = work[0, :n].max() if n else 0
        if not found[k, 3]:
            continue
        count = chosen_pieces(n, min_length, work)
        for piece in range(count):
            found[k, 0] += work[2, piece]
            work[2, piece] = period(one, work[1, piece], work[2, piece], min_length)
        distinct_words(one, count, work, table)
        found[k, 1] = found[k, 0]
        for piece in range(count):
            found[k, 1] -= work[2, piece] * work[3, piece]
    return found


def longest_loops(
    codes: Codes, min_length: int, overlap: bool, longest: int, work: NDArray[np.int64], table: Codes
) -> int:
    """Writes the length of the longest loop at each start, up to ``longest``, into row 0; returns the onset.

    Words grow by one action at a time, and are named by their first copy.
    """
    n, onset = len(codes), 0
    reach, shorter, named, last = work[0], work[1], work[2], work[3]
    reach[: n + 1] = 0
    slots = table[: _places(n)]
    for length in range(packed_words(codes, min_length, shorter) + 1, min(longest, n) + 1):
        name_words(codes, length, min_length, reach, shorter, named, last, slots)
        found, apart = False, 1 if overlap else max(length, min_length)
        for i in range(n - length + 1):
            if _may_loop(reach[i], reach[i + 1], length, min_length) and last[named[i]] - named[i] >= apart:
                found = True
                if length >= min_length:
                    reach[i] = length
                if length == min_length and not onset and i - named[i] >= apart:
                    onset = i + length
        if not found:
            break
        shorter, named = named, shorter
    return onset


def packed_words(codes: Codes, min_length: int, shorter: Codes) -> int:
    """Names the longest words below ``min_length`` whose actions make one number below 2**31; returns their length."""
    base = max(codes.max(), 1) + 1 if len(codes) else 2
    length, names = 0, base
    while length < min_length - 1 and names < 2**31:
        length += 1
        names *= base
    for i in range(len(codes) - length):
        shorter[i] = 0
        for k in range(i, i + length):
            shorter[i] = shorter[i] * base + codes[k]
    return length


def name_words(
    codes: Codes,
    length: int,
    min_length: int,
    reach: Codes,
    shorter: Codes,
    named: Codes,
    last: Codes,
    slots: Codes,
) -> None:
    """Names the words of one length that may be loops by the start of their first copy; notes the last copy's.

    A word is looked up by the name of the word without its last action, and that action.
    """
    slots[:] = -1
    for i in range(len(codes) - length + 1):
        if _may_loop(reach[i], reach[i + 1], length, min_length):
            added = codes[i + length - 1]
            slot = _slot(shorter[i], added, len(slots))
            while slots[slot] >= 0:
                j = slots[slot]
                if shorter[j] == shorter[i] and codes[j + length - 1] == added:
                    break
                slot = (slot + 1) & (len(slots) - 1)
            if slots[slot] < 0:
                slots[slot] = i
            named[i] = slots[slot]
            last[named[i]] = i


def _may_loop(here: int, after: int, length: int, min_length: int) -> bool:
    """Only a word made of two loops, one action apart, can be a loop."""
    return length <= min_length or min(here, after) >= length - 1


def chosen_pieces(n: int, min_length: int, work: NDArray[np.int64]) -> int:
    """Writes starts and lengths of the fewest longest pieces into rows 1 and 2; returns how many there are."""
    reach, starts, lengths, best, chosen = work[0], work[1], work[2], work[3], work[4]
    best[n] = 0
    for start in range(n - 1, -1, -1):
        best[start], chosen[start] = best[start + 1], 0
        for length in range(min_length, reach[start] + 1):
            worth = best[start + length] + length * (n + 1) - 1
            if worth >= best[start]:
                best[start], chosen[start] = worth, length
    count = start = 0
    while start < n:
        if chosen[start]:
            starts[count], lengths[count] = start, chosen[start]
            count += 1
        start += max(chosen[start], 1)
    return count


def period(codes: Codes, start: int, length: int, min_length: int) -> int:
    """Length of the shortest loop that a piece is copies of."""
    for size in range(min_length, length // 2 + 1):
        if length % size == 0:
            same = True
            for i in range(start, start + length - size):
                if codes[i] != codes[i + size]:
                    same = False
                    break
            if same:
                return size
    return length


def distinct_words(codes: Codes, count: int, work: NDArray[np.int64], table: Codes) -> None:
    """Writes into row 3 whether a piece (rows 1 and 2) is the first of its word."""
    starts, lengths, fresh = work[1], work[2], work[3]
    slots = table[: _places(count)]
    slots[:] = -1
    for k in range(count):
        name = lengths[k]
        for i in range(starts[k], starts[k] + lengths[k]):
            name = _slot(name, codes[i], 1 << 30)
        slot = name & (len(slots) - 1)
        fresh[k] = 1
        while fresh[k] and slots[slot] >= 0:
            j = slots[slot]
            if lengths[j] == lengths[k]:
                fresh[k] = 0
                for i in range(lengths[k]):
                    if codes[starts[j] + i] != codes[starts[k] + i]:
                        fresh[k] = 1
                        break
            slot = (slot + 1) & (len(slots) - 1)
        if fresh[k]:
            slots[slot] = k


def _places(n: int) -> int:
    """Places of a hash table for n words: a power of two, at most half of it filled."""
    places = 2
    while places < 2 * n:
        places *= 2
    return places


def _slot(left: int, right: int, slots: int) -> int:
    """A place in a hash table of ``slots`` places (a power of two) for a pair of numbers below 2**31."""
    return (((left * 2654435761 + right * 2246822519) & 0x7FFFFFFFFFFFFFFF) >> 21) & (slots - 1)


_PARTS = (longest_loops, packed_words, name_words, _may_loop, chosen_pieces, period, distinct_words, _places, _slot)
