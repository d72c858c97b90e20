"""The definitions, word for word, and brute force over them: slow, plain, and independent of the package."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple


class Truth(NamedTuple):
    """What brute force finds. ``pieces`` are the fewest of a greatest free cover."""

    free: int
    repeat: int
    whole: int
    pieces: int
    onset: int
    longest: int


def patterns(actions: int, longest: int) -> Iterator[tuple[int, ...]]:
    """Every trial up to ``longest`` steps, up to the names of its actions."""
    layer: list[tuple[int, ...]] = [()]
    for _ in range(longest + 1):
        yield from layer
        layer = [(*p, a) for p in layer for a in range(min(len(set(p)) + 1, actions))]


def copies(trial: Sequence[int], min_length: int, overlap: bool) -> dict[tuple[int, ...], list[int]]:
    """Every run that stands twice, and all places where it stands."""
    places: dict[tuple[int, ...], list[int]] = {}
    for start, end in combinations(range(len(trial) + 1), 2):
        if end - start >= min_length:
            places.setdefault(tuple(trial[start:end]), []).append(start)
    return {word: at for word, at in places.items() if at[-1] - at[0] >= (1 if overlap else len(word))}


def from_the_left(at: Sequence[int], length: int) -> list[int]:
    """Disjoint copies of one word, each the first that is free."""
    taken: list[int] = []
    for start in at:
        if not taken or start >= taken[-1] + length:
            taken.append(start)
    return taken


def truth(trial: tuple[int, ...], overlap: bool, min_length: int = 3) -> Truth:
    """Tries every set of disjoint pieces."""
    words = copies(trial, min_length, overlap)
    if not words:
        return Truth(0, 0, 0, 0, 0, 0)
    pieces = sorted((start, start + len(word), word) for word, at in words.items() for start in at)
    all_copies = {word: len(from_the_left(at, len(word))) for word, at in words.items()}
    first_copies = {(word, start) for word, at in words.items() for start in from_the_left(at, len(word))}
    best, fewest, repeat, whole = 0, 0, 0, 0

    def choose(begin: int, end: int, covered: int, chosen: list[tuple[tuple[int, ...], int]]) -> None:
        nonlocal best, fewest, repeat, whole
        if (covered, -len(chosen)) > (best, -fewest):
            best, fewest = covered, len(chosen)
        if covered > whole:
            counts = Counter(word for word, _ in chosen)
            if min(counts.values()) > 1:
                repeat = max(repeat, covered)
                if counts == {word: all_copies[word] for word in counts} and first_copies.issuperset(chosen):
                    whole = covered
        for k in range(begin, len(pieces)):
            start, stop, word = pieces[k]
            if start >= end:
                choose(k + 1, stop, covered + stop - start, [*chosen, (word, start)])

    choose(0, 0, 0, [])
    ends = [
        b + len(word)
        for word, at in words.items()
        for a, b in combinations(at, 2)
        if b - a >= (1 if overlap else len(word))
    ]
    return Truth(best, repeat, whole, fewest, min(ends), max(map(len, words)))
