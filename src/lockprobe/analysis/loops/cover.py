"""Does a trial go round in circles? Action loops, and how much of the trial they cover.

An *action loop* is a run of three or more consecutive actions that stands at least twice in one trial. The paper (Sec.
3.3) reports the share of trials that hold one, and covers a trial by disjoint loops of greatest total length, found by
a binary integer linear programme. It leaves open whether the two copies may overlap (here by default not: ``A A A A``
holds no loop), which changes how many trials loop, and what a cover may choose (:data:`Rule`), which does not.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Literal, get_args

import numpy as np

from lockprobe.analysis.loops.words import least_distance
from lockprobe.errors import BadValue, LockprobeError

__all__ = ["LONGEST_ILP", "LoopCover", "Rule", "Solver", "cover"]

Rule = Literal["free", "repeat", "whole"]
"""What a cover may be made of; each rule covers at most what the one before it does.

* ``free``: every chosen piece is a copy of some loop. What the paper's text says.
* ``repeat``: as ``free``, and every chosen loop is chosen at least twice.
* ``whole``: a loop is chosen with all its copies (two or more disjoint ones, from the left), or not at all.
"""

Solver = Literal["dp", "ilp"]
"""``dp``: exact dynamic programme, for ``free``. ``ilp``: the paper's linear programme, for every rule."""

LONGEST_ILP = 120

Interval = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCover:
    """One cover of a trial by action loops.

    Args:
        n: Actions in the trial.
        any_loop: Whether the trial holds a loop at all, whatever the cover's rule.
        covered: Actions inside the cover, 0 to n.
        words: The distinct loops of the cover, in order of first appearance.
        intervals: Where they stand, as (start from 0, length), sorted and disjoint.
    """

    n: int
    any_loop: bool
    covered: int
    words: tuple[tuple[Hashable, ...], ...]
    intervals: tuple[Interval, ...]

    @property
    def share(self) -> float:
        """Covered share of the trial, 0 to 1 (0 for an empty trial)."""
        return self.covered / self.n if self.n else 0.0


def cover(
    sequence: Sequence[Hashable],
    *,
    rule: Rule = "free",
    solver: Solver = "dp",
    overlap: bool = False,
    min_length: int = 3,
) -> LoopCover:
    """Covers as much of a trial as possible by disjoint copies of its action loops.

    Of several greatest covers ``dp`` takes the one of fewest pieces, longest first; ``ilp`` one of fewest
    pieces, then of long ones (``whole``: of few, then short loops). A piece that is itself a repetition is then
    written as its copies, ``ABCABC`` as ``ABC ABC``: loops on the same actions (not done under ``whole``).
    20 actions take ``dp`` 0.05 ms and 5000 take 0.1 s; ``ilp`` takes at most ``LONGEST_ILP`` actions.

    Args:
        sequence: The actions in order.
        rule: What a cover may be made of. ``repeat`` and ``whole`` need ``solver="ilp"``.
        solver: The exact dynamic programme, or the paper's integer linear programme.
        overlap: Whether the two copies that make a loop may share actions. Chosen pieces never do.
        min_length: Fewest actions in a loop (at least 1; 3 in the paper).

    >>> found = cover("ABCABCABC")
    >>> found.words, found.intervals, found.share
    ((('A', 'B', 'C'),), ((0, 3), (3, 3), (6, 3)), 1.0)
    """
    if rule not in get_args(Rule):
        raise BadValue("cover rule", rule, "free, repeat or whole")
    if solver not in ("dp", "ilp")[rule != "free" :]:
        raise BadValue(f"solver for the cover rule {rule}", solver, "dp or ilp" if rule == "free" else "ilp")
    least_distance(min_length, overlap=overlap)
    text = _letters(sequence)
    if solver == "ilp" and len(sequence) > LONGEST_ILP:
        raise BadValue("actions for the solver ilp", len(text), f"at most {LONGEST_ILP}; dp has no limit")
    if solver == "dp":
        reach = _longest_loops(text, min_length, overlap=overlap)
        looping = any(reach)
        pieces = _fewest_longest(reach, min_length)
    else:
        loops = _loops(text, min_length, overlap=overlap)
        looping = bool(loops)
        pieces = sorted(_programme(loops, len(text), rule))
    if rule != "whole":
        pieces = [part for piece in pieces for part in _copies(text, piece, min_length)]
    return LoopCover(
        n=len(text),
        any_loop=looping,
        covered=sum(length for _, length in pieces),
        words=tuple(dict.fromkeys(tuple(sequence[start : start + length]) for start, length in pieces)),
        intervals=tuple(pieces),
    )


def _letters(sequence: Sequence[Hashable]) -> str:
    """The trial as a string of one letter per action, whose searches run in C."""
    names: dict[Hashable, str] = {}
    return "".join([names.setdefault(action, chr(len(names))) for action in sequence])


def _longest_loops(text: str, min_length: int, *, overlap: bool) -> list[int]:
    """For each start the length of the longest loop there, 0 for none.

    Every part of a loop (of ``min_length`` or more) is a loop. So all shorter lengths are loops too, and as
    the start goes left the end of the longest never goes right: at most 2 n searches.
    """
    reach = [0] * (len(text) + 1)
    end = len(text)
    for start in range(len(text) - min_length, -1, -1):
        while end - start >= min_length:
            word = text[start:end]
            if text.rfind(word) - text.find(word) >= (1 if overlap else len(word)):
                reach[start] = len(word)
                break
            end -= 1
    return reach


def _fewest_longest(reach: list[int], min_length: int) -> list[Interval]:
    """The greatest cover of fewest pieces; of those, the first piece starts earliest, is longest, and so on.

    From the right: ``best[i]`` is the worth of the trial from action i on, one covered action counting more
    than all pieces together. A piece from i may end anywhere in a window whose right edge only moves left, so
    a queue of candidate ends with falling worth gives its best end, in linear time over all i.
    """
    n = len(reach) - 1
    best, length = [0] * (n + 1), [0] * (n + 1)
    ends: deque[tuple[int, int]] = deque()
    for start in range(n - min_length, -1, -1):
        best[start] = best[start + 1]
        nearest = start + min_length
        worth = best[nearest] + nearest * (n + 1)
        while ends and ends[-1][0] < worth:
            ends.pop()
        ends.append((worth, nearest))
        if reach[start]:
            while ends[0][1] > start + reach[start]:
                ends.popleft()
            worth = ends[0][0] - start * (n + 1) - 1
            if worth >= best[start]:
                best[start], length[start] = worth, ends[0][1] - start
    pieces, start = [], 0
    while start < n:
        if length[start]:
            pieces.append((start, length[start]))
        start += length[start] or 1
    return pieces


def _copies(text: str, piece: Interval, min_length: int) -> list[Interval]:
    """A piece as the copies of its shortest loop that it repeats; itself if it repeats none."""
    start, length = piece
    word = text[start : start + length]
    for size in range(min_length, length // 2 + 1):
        if length % size == 0 and word == word[:size] * (length // size):
            return [(at, size) for at in range(start, start + length, size)]
    return [piece]


def _loops(text: str, min_length: int, *, overlap: bool) -> dict[str, list[int]]:
    """All loops of a trial with the starts of all their copies, enumerated as the paper does it."""
    loops: dict[str, list[int]] = {}
    for length in range(min_length, len(text)):
        starts: dict[str, list[int]] = {}
        for start in range(len(text) - length + 1):
            starts.setdefault(text[start : start + length], []).append(start)
        apart = 1 if overlap else length
        found = {word: at for word, at in starts.items() if at[-1] - at[0] >= apart}
        if not found:
            break
        loops.update(found)
    return loops


def _disjoint(starts: list[int], length: int) -> list[Interval]:
    """The copies taken one after another from the left, skipping those that overlap the one before."""
    taken: list[Interval] = []
    for start in starts:
        if not taken or start >= sum(taken[-1]):
            taken.append((start, length))
    return taken


def _choices(loops: dict[str, list[int]], rule: Rule) -> list[list[Interval]]:
    """What each binary of the programme puts into the cover: one copy, or under ``whole`` all of a loop's."""
    if rule == "whole":
        sets = [_disjoint(starts, len(word)) for word, starts in loops.items()]
        return [pieces for pieces in sets if len(pieces) > 1]
    return [[(start, len(word))] for word, starts in loops.items() for start in starts]


def _programme(loops: dict[str, list[int]], n: int, rule: Rule) -> list[Interval]:
    """The paper's binary integer linear programme, solved to optimality by HiGHS.

    Each action is covered at most once; under ``repeat`` twice a copy is at most the sum of its loop's.
    The gain is the covered length, less a bit per binary, plus a smaller bit for long pieces (``whole``: short).
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array

    if not (choices := _choices(loops, rule)):
        return []
    cells = [(i + k, c, 1) for c, copies in enumerate(choices) for i, size in copies for k in range(size)]
    limits = [1] * n
    if rule == "repeat":
        limits += [0] * len(choices)
        ends = list(accumulate(len(starts) for starts in loops.values()))
        for first, end in zip([0, *ends], ends, strict=False):
            cells += [(n + c, d, 2 * (c == d) - 1) for c in range(first, end) for d in range(first, end)]
    rows, columns, factors = zip(*cells, strict=True)
    matrix = csr_array((factors, (rows, columns)), shape=(len(limits), len(choices)))
    lean = -1 if rule == "whole" else 1
    gains = [sum(size for _, size in c) - 1 / (n + 1) + lean * c[0][1] ** 2 / (n + 1) ** 3 for c in choices]
    solution = milp(
        -np.asarray(gains),
        integrality=np.ones(len(choices), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(matrix, ub=limits),
        options={"mip_rel_gap": 0.0},
    )
    if not solution.success:
        raise LockprobeError(f"the loop cover of a trial of {n} actions was not found: {solution.message}")
    chosen = [copies for copies, taken in zip(choices, solution.x, strict=True) if taken > 0.5]
    return [piece for copies in chosen for piece in copies]
