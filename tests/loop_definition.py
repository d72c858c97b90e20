"""The definitions, word for word, and brute force over them: slow, plain, and independent of the package."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple


class Truth(NamedTuple):
    """What brute force finds. ``pieces`` are the fewest of a greatest cover."""

    covered: int
    pieces: int
    onset: int


def patterns(actions: int, longest: int) -> Iterator[tuple[int, ...]]:
    """Every trial up to ``longest`` steps, up to the names of its actions."""
    layer: list[tuple[int, ...]] = [()]
    for _ in range(longest + 1):
        yield from layer
        layer = [(*p, a) for p in layer for a in range(min(len(set(p)) + 1, actions))]


def copies(trial: Sequence[int]) -> dict[tuple[int, ...], list[int]]:
    """Every run that stands twice, and all places where it stands."""
    places: dict[tuple[int, ...], list[int]] = {}
    for start, end in combinations(range(len(trial) + 1), 2):
        if end - start >= 3:
            places.setdefault(tuple(trial[start:end]), []).append(start)
    return {word: at for word, at in places.items() if at[-1] - at[0] >= len(word)}


def truth(trial: tuple[int, ...]) -> Truth:
    """Tries every set of disjoint pieces."""
    words = copies(trial)
    if not words:
        return Truth(0, 0, 0)
    pieces = sorted((start, start + len(word)) for word, at in words.items() for start in at)
    best, fewest = 0, 0

    def choose(begin: int, end: int, covered: int, chosen: int) -> None:
        nonlocal best, fewest
        if (covered, -chosen) > (best, -fewest):
            best, fewest = covered, chosen
        for k in range(begin, len(pieces)):
            start, stop = pieces[k]
            if start >= end:
                choose(k + 1, stop, covered + stop - start, chosen + 1)

    choose(0, 0, 0, 0)
    ends = [b + len(word) for word, at in words.items() for a, b in combinations(at, 2) if b - a >= len(word)]
    return Truth(best, fewest, min(ends))
