"""The longest loop at each start of a trial, in linear time, by the suffix automaton (Blumer et al. 1985).

Words that end at the same places of the trial share a *state*. The words of a state are the ends of its longest one,
down to a length; shorter ends are in the state ``shorter``. State 0 is the empty word, and state i, up to the length
of the trial, has the first i actions as its longest word. The next one stands before the empty word, to which each
action leads from there. Those after it are parts of others that were split off.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

__all__ = ["Automaton", "automaton", "loops_from"]


class Automaton(NamedTuple):
    """The states of a trial's words, each a place in these lists.

    Attributes:
        after: The state of its words with one more action, by that action.
        shorter: The state of the longest end that is not in it.
        size: Actions in its longest word.
        first: The end of the first copy of its words.
    """

    after: list[dict[Hashable, int]]
    shorter: list[int]
    size: list[int]
    first: list[int]


def automaton(actions: Sequence[Hashable]) -> Automaton:
    """The suffix automaton of a trial, grown by one action at a time."""
    n = len(actions)
    after: list[dict[Hashable, int]] = [{} for _ in range(n + 1)]
    shorter, size, first = [n + 1] + [0] * n, list(range(n + 1)), list(range(n + 1))
    after.append(dict.fromkeys(actions, 0))
    shorter.append(0)
    size.append(-1)
    first.append(0)
    state = 0
    for new, action in enumerate(actions, 1):
        edges = after[state]
        while action not in edges:
            edges[action] = new
            state = shorter[state]
            edges = after[state]
        there = shorter[new] = edges[action]
        if size[there] > size[state] + 1:
            split = shorter[new] = len(size)
            after.append(after[there].copy())
            shorter.append(shorter[there])
            size.append(size[state] + 1)
            first.append(first[there])
            shorter[there] = split
            while edges.get(action) == there:
                edges[action] = split
                state = shorter[state]
                edges = after[state]
        state = new
    return Automaton(after, shorter, size, first)


def loops_from(actions: Sequence[Hashable], *, overlap: bool) -> list[int]:
    """For each start, and the end of the trial, the length of the longest loop there, from loops of any length.

    The longest loop that ends with an action is at most one action longer than that of the action before. Where it
    begins, and at starts that it passes, no loop reaches further.
    """
    n = len(actions)
    after, shorter, size, first = automaton(actions)
    last = first.copy()
    last[0] = n
    for end in range(n, 0, -1):
        state = shorter[end]
        while last[state] < end:
            last[state] = end
            state = shorter[state]
    room = [b - a for a, b in zip(first, last, strict=True)]
    if overlap:
        room = [n if apart else 0 for apart in room]
    reach = [0] * (n + 1)
    state = length = start = 0
    for end, action in enumerate(actions):
        state, length = after[state][action], length + 1
        while room[state] < length:
            if room[state] > size[shorter[state]]:
                length = room[state]
            else:
                state = shorter[state]
                length = size[state]
        while start <= end - length:
            reach[start] = end - start
            start += 1
    reach[start:n] = range(n - start, 0, -1)
    return reach
