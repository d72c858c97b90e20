"""Maximum covers by exact search, under the rules ``repeat`` and ``whole``, which tie pieces to each other.

Both searches lower the number of covered actions from an upper bound until a cover exists. They memoise states that
cannot cover enough. Whether the copies that make a loop may overlap does not matter: chosen pieces never overlap.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

from lockprobe.statistics.loops.exact_cover import copies, trial_pieces
from lockprobe.statistics.loops.words import Interval, all_loops, whole_copies

__all__ = ["LONGEST_SEARCH", "repeat_pieces", "whole_pieces"]

LONGEST_SEARCH = 90
"""20 actions take 0.1 to 0.3 ms, 60 up to half a second, 90 about a second and at worst half a minute."""


def repeat_pieces(text: str, min_length: int) -> list[Interval]:
    """The pieces of a greatest cover in which every loop stands at least twice, in order.

    The greatest free cover, if it is one. Else loops of m to 2 m - 1 actions are searched (m the shortest length:
    longer ones are made of them), and loops that always follow each other are then joined.
    """
    pieces = trial_pieces(text, min_length)
    if min(Counter(_words(text, pieces)).values(), default=2) > 1:
        return pieces
    found = _joined(text, _RepeatSearch(text, min_length).greatest())
    return [part for piece in found for part in copies(text, piece, min_length)]


def whole_pieces(text: str, min_length: int) -> list[Interval]:
    """The pieces of a greatest cover made of loops with all their copies, in order.

    The greatest free cover, if it is one. Else a set packing: the action that fewest loops can cover is covered by
    one of them, or given up. The bound is the number of actions that the remaining loops would cover together.
    """
    pieces = trial_pieces(text, min_length)
    if not pieces:
        return []
    sets = whole_copies(all_loops(text, min_length))
    if set(pieces) == {piece for taken in sets if set(taken) <= set(pieces) for piece in taken}:
        return pieces
    choices: dict[int, list[Interval]] = {}
    for taken in sets:
        choices.setdefault(sum(((1 << length) - 1) << start for start, length in taken), taken)
    return sorted(piece for mask in _packing(list(choices)) for piece in choices[mask])


def _packing(masks: list[int]) -> list[int]:
    """Disjoint masks of greatest total size."""
    failed: dict[tuple[int, ...], int] = {}

    def packed(rest: list[int], need: int) -> list[int] | None:
        """Disjoint masks that cover ``need`` actions or more."""
        if need <= 0:
            return []
        if _union(rest).bit_count() < need or failed.get(tuple(rest), need + 1) <= need:
            return None
        action = _rarest(rest)
        for mask in rest:
            if mask & action:
                found = packed([other for other in rest if not other & mask], need - mask.bit_count())
                if found is not None:
                    return [mask, *found]
        found = packed([other for other in rest if not other & action], need)
        if found is None:
            failed[tuple(rest)] = need
        return found

    largest_first = sorted(masks, key=int.bit_count, reverse=True)
    need = _union(masks).bit_count()
    while (found := packed(largest_first, need)) is None:
        need -= 1
    return found


def _union(masks: list[int]) -> int:
    union = 0
    for mask in masks:
        union |= mask
    return union


def _rarest(masks: list[int]) -> int:
    """The action, as a bit, that fewest of the masks cover, of those that any covers."""
    once = twice = 0
    for mask in masks:
        twice |= once & mask
        once |= mask
    if once & ~twice:
        return once & ~twice & -(once & ~twice)
    actions = [1 << i for i in range(once.bit_length()) if once >> i & 1]
    return min(actions, key=lambda action: sum(1 for mask in masks if mask & action))


class _RepeatSearch:
    """From left to right. A loop is unchosen, chosen once (so it has to come again), or chosen enough.

    Every set of loops is a number with one bit per loop. A state is an action, and which of the loops that stand
    further on are chosen once, and which enough. The bound is the free cover of the rest by loops that are chosen or
    can still be chosen twice.
    """

    def __init__(self, text: str, min_length: int) -> None:
        self.n = len(text)
        self.pieces: list[list[tuple[int, int]]] = [[] for _ in range(self.n + 1)]
        self.ahead = [0] * (self.n + 1)
        self.twice_ahead = [0] * (self.n + 1)
        for k, (word, starts) in enumerate(all_loops(text, min_length, below=2 * min_length).items()):
            for start in starts:
                self.pieces[start].append((len(word), 1 << k))
            for start in range(starts[-1] + 1):
                self.ahead[start] |= 1 << k
            for start in range(max(i for i in starts if i + len(word) <= starts[-1]) + 1):
                self.twice_ahead[start] |= 1 << k
        for here in self.pieces:
            here.sort(reverse=True)
        self.bounds: dict[tuple[int, int], int] = {}
        self.failed: dict[tuple[int, int, int], int] = {}

    def greatest(self) -> list[Interval]:
        """The pieces of a greatest cover, in order."""
        need = self.bound(0, 0)
        while (found := self.cover(0, need, 0, 0)) is None:
            need -= 1
        return found[::-1]

    def bound(self, start: int, chosen: int) -> int:
        """Most actions that can be covered from ``start`` on, given the chosen loops."""
        key = start, chosen & ~self.twice_ahead[start]
        if key not in self.bounds:
            allowed = chosen | self.twice_ahead[start]
            best = [0] * (self.n + 1)
            for i in range(self.n - 1, start - 1, -1):
                top = best[i + 1]
                for length, loop in self.pieces[i]:
                    if loop & allowed and best[i + length] + length > top:
                        top = best[i + length] + length
                best[i] = top
            self.bounds[key] = best[start]
        return self.bounds[key]

    def cover(self, start: int, need: int, once: int, enough: int) -> list[Interval] | None:
        """Pieces from ``start`` on, last first, that cover ``need`` actions or more and bring all loops again."""
        if once & ~self.ahead[start]:
            return None
        if need <= 0 and not once:
            return []
        enough &= self.ahead[start]
        key = start, once, enough
        if self.bound(start, once | enough) < need or self.failed.get(key, need + 1) <= need:
            return None
        for length, loop in self.pieces[start]:
            rest = None
            if loop & (once | enough):
                rest = self.cover(start + length, need - length, once & ~loop, enough | loop)
            elif loop & self.twice_ahead[start]:
                rest = self.cover(start + length, need - length, once | loop, enough)
            if rest is not None:
                return [*rest, (start, length)]
        rest = self.cover(start + 1, need, once, enough) if start < self.n else None
        if rest is None:
            self.failed[key] = need
        return rest


def _words(text: str, pieces: list[Interval]) -> list[str]:
    return [text[start : start + length] for start, length in pieces]


def _joined(text: str, pieces: list[Interval]) -> list[Interval]:
    """Joins two loops into one where each copy of the one is followed by a copy of the other, as often as there are."""
    counts = Counter(_words(text, pieces))
    neighbours = [(a, b) for a, b in pairwise(pieces) if sum(a) == b[0]]
    pairs = Counter(tuple(_words(text, [a, b])) for a, b in neighbours)
    for (word, after), count in pairs.items():
        if word != after and count == counts[word] == counts[after]:
            joined = [(a[0], a[1] + b[1]) for a, b in neighbours if _words(text, [a, b]) == [word, after]]
            others = [piece for piece in pieces if text[piece[0] : sum(piece)] not in (word, after)]
            return _joined(text, sorted(joined + others))
    return pieces
