"""Compiled free covers of long trials and of many: the only importer of numba here.

Importing numba and compiling cost seconds the first time and about a second later on, so that happens only where the
work of a process pays for it (:func:`compiled`). The functions are plain Python on integer arrays and compute the
numbers of :mod:`lockprobe.statistics.loops.exact_cover`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.loops.alphabet import Codes

__all__ = [
    "NAMED",
    "WORTH_COMPILING",
    "chosen_pieces",
    "compiled",
    "distinct_words",
    "find_loops",
    "free_cover",
    "free_measures",
    "grow",
    "longest_loops",
    "loops_from",
    "name_words",
    "packed_words",
    "period",
    "split_pieces",
]

Given = ParamSpec("Given")
Found = TypeVar("Found")

WORTH_COMPILING = 200_000
"""Actions in one process above which compiling pays: they take 0.2 s without it, 0.3 s as trials of 20."""

NAMED = 16
"""Actions in the longest loops for which a trial's words are named, length by length; longer ones take an automaton."""

_COMPILED: dict[str, Callable[..., Any] | None] = {}
_ASKED = Counter[str]()


def compiled(function: Callable[Given, Found], actions: int) -> Callable[Given, Found] | None:
    """The compiled function, if these and all earlier actions justify it; None without numba."""
    name = function.__name__
    _ASKED["actions"] += actions
    if name not in _COMPILED and _ASKED["actions"] >= WORTH_COMPILING:
        try:
            from numba import njit
            from numba.extending import register_jitable
        except ImportError:
            _COMPILED[name] = None
            return None
        for part in _PARTS:
            register_jitable(part)
        try:
            _COMPILED[name] = njit(cache=True)(function)
        except RuntimeError:  # nowhere to keep what is compiled
            _COMPILED[name] = njit(function)
    return _COMPILED.get(name)


def free_cover(
    codes: Codes, min_length: int, overlap: bool, trial: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The cover of one trial, the actions given as numbers from 0.

    Args:
        codes: Actions as numbers from 0.
        min_length: Fewest actions in a loop.
        overlap: Whether the two copies may share actions.
        trial: Up to this many actions loops of any length are pieces, above it only the shortest.

    Returns:
        Start and length of each piece, and 1 where it is the first copy of its word, each of shape (pieces,).
    """
    n = len(codes)
    table = np.empty(_places(n), np.int64)
    work = np.empty((5, n + 1), np.int64)
    find_loops(codes, min_length, overlap, trial, work, table)
    count = split_pieces(codes, chosen_pieces(n, min_length, work), min_length, work)
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
        found[k, 2] = find_loops(one, min_length, overlap, trial, work, table)
        if not found[k, 2]:
            continue
        found[k, 3] = work[0, :n].max()
        count = chosen_pieces(n, min_length, work)
        for piece in range(count):
            found[k, 0] += work[2, piece]
            work[2, piece] = period(one, work[1, piece], work[2, piece], min_length)
        distinct_words(one, count, work, table)
        found[k, 1] = found[k, 0]
        for piece in range(count):
            found[k, 1] -= work[2, piece] * work[3, piece]
    return found


def find_loops(codes: Codes, min_length: int, overlap: bool, trial: int, work: NDArray[np.int64], table: Codes) -> int:
    """Writes the length of the longest loop at each start into row 0, of the lengths that may be pieces.

    Words of few actions are named, length by length. Where loops are longer, the automaton finds all at once.

    Returns:
        The onset.
    """
    n = len(codes)
    longest = max(NAMED, min_length) if n <= trial else 2 * min_length - 1
    onset = longest_loops(codes, min_length, overlap, longest, work, table)
    if n <= trial and work[0, : n + 1].max() == longest:
        loops_from(codes, overlap, work[0])
    return onset


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


def loops_from(codes: Codes, overlap: bool, reach: Codes) -> None:
    """Writes the length of the longest loop at each start into ``reach``, as far as the end of the trial.

    As :func:`lockprobe.statistics.loops.automaton.loops_from`.
    """
    n = len(codes)
    states, edges = np.empty((5, 2 * n + 1), np.int64), np.empty((4, _places(2 * n)), np.int64)
    count = grow(codes, states, edges)
    shorter, size, room, last = states[0], states[1], states[2], states[3]
    last[0] = n
    for end in range(n, 0, -1):
        state = shorter[end]
        while last[state] < end:
            last[state] = end
            state = shorter[state]
    for state in range(count):
        apart = last[state] - room[state]
        room[state] = n if overlap and apart else apart
    state = length = start = 0
    for end in range(n):
        state, length = edges[2, _edge(state, codes[end], edges)], length + 1
        while room[state] < length:
            if room[state] > size[shorter[state]]:
                length = room[state]
            else:
                state = shorter[state]
                length = size[state]
        while start <= end - length:
            reach[start] = end - start
            start += 1
    for rest in range(start, n + 1):
        reach[rest] = n - rest


def grow(codes: Codes, states: NDArray[np.int64], edges: NDArray[np.int64]) -> int:
    """Writes the suffix automaton (:func:`lockprobe.statistics.loops.automaton.automaton`); returns how many states.

    A column of ``states`` is a state: ``shorter``, ``size``, the ends of its first and last copy, and its newest edge.
    A column of ``edges``, a hash table, is an edge: its state (-1 where there is none), action, the state after it, and
    the next older edge of its state (-1 for none).
    """
    shorter, size, first, last, newest = states[0], states[1], states[2], states[3], states[4]
    n = len(codes)
    edges[0, :] = -1
    newest[: n + 1] = -1
    for state in range(n + 1):
        size[state] = first[state] = last[state] = state
    shorter[0], count, state = -1, n + 1, 0
    for new in range(1, n + 1):
        action, there = codes[new - 1], 0
        while state >= 0:
            edge = _edge(state, action, edges)
            if edges[0, edge] >= 0:
                there = edges[2, edge]
                break
            _add_edge(edge, state, action, new, newest, edges)
            state = shorter[state]
        shorter[new] = there
        if state >= 0 and size[there] > size[state] + 1:
            split, count = count, count + 1
            shorter[split], size[split], newest[split] = shorter[there], size[state] + 1, -1
            first[split] = last[split] = first[there]
            shorter[there] = shorter[new] = split
            old = newest[there]
            while old >= 0:
                _add_edge(_edge(split, edges[1, old], edges), split, edges[1, old], edges[2, old], newest, edges)
                old = edges[3, old]
            while state >= 0:
                edge = _edge(state, action, edges)
                if edges[2, edge] != there:
                    break
                edges[2, edge] = split
                state = shorter[state]
        state = new
    return count


def _add_edge(edge: int, state: int, action: int, there: int, newest: Codes, edges: NDArray[np.int64]) -> None:
    edges[0, edge], edges[1, edge], edges[2, edge], edges[3, edge] = state, action, there, newest[state]
    newest[state] = edge


def _edge(state: int, action: int, edges: NDArray[np.int64]) -> int:
    """The place of the edge of a state for an action, or the empty place where it would stand."""
    edge = _slot(state, action, edges.shape[1])
    while edges[0, edge] >= 0 and (edges[0, edge] != state or edges[1, edge] != action):
        edge = (edge + 1) & (edges.shape[1] - 1)
    return edge


def chosen_pieces(n: int, min_length: int, work: NDArray[np.int64]) -> int:
    """Writes starts and lengths of the fewest longest pieces into rows 1 and 2; returns how many there are.

    As the dynamic programme of :mod:`lockprobe.statistics.loops.exact_cover`, with row 1 as its queue.
    """
    reach, starts, lengths, worth, ends = work[0], work[1], work[2], work[3], work[1]
    for end in range(max(n - min_length + 1, 0), n + 1):
        worth[end], lengths[end] = end * (n + 1), 0
    head = tail = 0
    for start in range(n - min_length, -1, -1):
        nearest = start + min_length
        while tail > head and worth[ends[tail - 1]] < worth[nearest]:
            tail -= 1
        ends[tail], tail = nearest, tail + 1
        worth[start], lengths[start] = worth[start + 1] - n - 1, 0
        if reach[start] >= min_length:
            while ends[head] > start + reach[start]:
                head += 1
            if worth[ends[head]] > worth[start]:
                worth[start], lengths[start] = worth[ends[head]] - 1, ends[head] - start
    count = start = 0
    while start < n:
        length = lengths[start]
        if length:
            starts[count], lengths[count] = start, length
            count += 1
        start += max(length, 1)
    return count


def split_pieces(codes: Codes, count: int, min_length: int, work: NDArray[np.int64]) -> int:
    """Splits pieces that repeat a loop into its copies, from the last piece on; returns how many pieces there are."""
    starts, lengths, sizes = work[1], work[2], work[3]
    parts = 0
    for piece in range(count):
        sizes[piece] = period(codes, starts[piece], lengths[piece], min_length)
        parts += lengths[piece] // sizes[piece]
    place = parts
    for piece in range(count - 1, -1, -1):
        start, size, copies = starts[piece], sizes[piece], lengths[piece] // sizes[piece]
        for copy in range(copies - 1, -1, -1):
            place -= 1
            starts[place], lengths[place] = start + copy * size, size
    return parts


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


_PARTS = (
    find_loops,
    loops_from,
    grow,
    _add_edge,
    _edge,
    longest_loops,
    packed_words,
    name_words,
    _may_loop,
    chosen_pieces,
    split_pieces,
    period,
    distinct_words,
    _places,
    _slot,
)
