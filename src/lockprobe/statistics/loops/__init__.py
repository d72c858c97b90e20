"""Action loops: the first one of a trial, and covers of a trial by them (paper, Sec. 3.3).

An *action loop* is a run of three or more consecutive actions that stands at least twice in one trial. The paper
reports the share of trials that hold one, and covers a trial by disjoint loops of greatest total length, by a binary
integer linear programme. It does not say whether the two copies may overlap, which changes how many trials loop; here
they may not: ``A A A A`` holds no loop.

Choosing disjoint pieces of greatest total length is interval scheduling: the best cover of the trial from action i on
follows from the best covers from later actions on.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, get_args

from lockprobe.foundation.errors import BadValue, LockprobeError

if TYPE_CHECKING:  # `lockprobe loops --help` does without NumPy
    import numpy as np
    from numpy.typing import NDArray

Solver = Literal["dp", "ilp"]
"""Both are exact. ``dp``: our own dynamic programme. ``ilp``: the paper's linear programme, the reference."""

LENGTH = 3
"""Fewest actions in a loop."""

LONGEST_ILP = 120

LONGEST_WITH_ALL = 5000
"""Up to here loops of any length are pieces of a sequence; above it those of less than twice the
shortest length, which cover as much: a longer loop is two loops in a row."""

Interval = tuple[int, int]
"""A piece of a trial: its first action (from 0) and its length."""


def _letters(trial: Sequence[Hashable]) -> str:
    """A string of one letter per action, whose searches run in C."""
    names: dict[Hashable, str] = {}
    return "".join([names.setdefault(action, chr(len(names))) for action in trial])


def onset(trial: Sequence[Hashable]) -> int:
    """The step at which the first loop of a trial is complete, from 1; 0 if it holds none.

    >>> onset("ABCDABC")
    7
    """
    text = _letters(trial)
    first: dict[str, int] = {}
    for start in range(len(text) - LENGTH + 1):
        if start - first.setdefault(text[start : start + LENGTH], start) >= LENGTH:
            return start + LENGTH
    return 0


def onset_batch(trials: NDArray[np.integer[Any]]) -> NDArray[np.int64]:
    """:func:`onset` of many trials, integers of shape (trials, n); shape (trials,).

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length.
    """
    import numpy as np

    steps = np.ascontiguousarray(trials.T)
    n = len(steps)
    first = np.full(len(trials), never := np.iinfo(np.int64).max)
    for distance in range(LENGTH, n - LENGTH + 1):
        same = steps[:-distance] == steps[distance:]
        run = same[:-2] & same[1:-1] & same[2:]
        np.minimum(first, np.where(run.any(axis=0), run.argmax(axis=0) + distance + LENGTH, never), out=first)
    return np.where(first == never, 0, first)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCover:
    """One cover of a trial by action loops.

    Attributes:
        n: Actions in the trial.
        words: The distinct loops of the cover, in order of first appearance.
        intervals: Where they stand, as (start from 0, length), sorted and disjoint.
    """

    n: int
    words: tuple[tuple[Hashable, ...], ...]
    intervals: tuple[Interval, ...]

    @property
    def any_loop(self) -> bool:
        """Whether the trial holds a loop."""
        return bool(self.intervals)

    @property
    def covered(self) -> int:
        """Actions inside the cover, 0 to n."""
        return sum(length for _, length in self.intervals)

    @property
    def share(self) -> float:
        """Covered share of the trial, 0 to 1 (0 for an empty trial)."""
        return self.covered / self.n if self.n else 0.0


def cover(trial: Sequence[Hashable], *, solver: Solver = "dp") -> LoopCover:
    """Cover as much of a trial as possible by disjoint copies of its action loops (maximum coverage).

    Of several greatest covers it is one of fewest pieces. A piece that is itself a repetition is then written as its
    copies, ``ABCABC`` as ``ABC ABC``: loops on the same actions.

    Args:
        trial: The actions in order.
        solver: Our exact solver, or the paper's integer linear programme, of at most ``LONGEST_ILP`` actions.

    >>> found = cover("ABCABCABC")
    >>> found.words, found.intervals, found.share
    ((('A', 'B', 'C'),), ((0, 3), (3, 3), (6, 3)), 1.0)
    """
    if solver not in get_args(Solver):
        raise BadValue("solver", solver, "dp or ilp")
    text, pieces = _letters(trial), list[Interval]()
    if solver == "ilp" and len(text) > LONGEST_ILP:
        raise BadValue("actions for the solver ilp", len(text), f"at most {LONGEST_ILP}; dp has no limit")
    for start, length in (_programme if solver == "ilp" else _scheduled)(text):
        word = text[start : start + length]
        periods = (size for size in range(LENGTH, length) if word == word[:size] * (length // size))
        size = next(periods, length)
        pieces += [(at, size) for at in range(start, start + length, size)]
    words = dict.fromkeys(tuple(trial[start : start + length]) for start, length in pieces)
    return LoopCover(n=len(text), words=tuple(words), intervals=tuple(pieces))


def _loops(text: str, below: int) -> dict[str, list[int]]:
    """All loops of less than ``below`` actions with the starts of all their copies, short ones first."""
    loops: dict[str, list[int]] = {}
    for length in range(LENGTH, min(below, len(text))):
        starts: dict[str, list[int]] = {}
        for start in range(len(text) - length + 1):
            starts.setdefault(text[start : start + length], []).append(start)
        found = {word: at for word, at in starts.items() if at[-1] - at[0] >= length}
        if not found:
            break
        loops.update(found)
    return loops


def _programme(text: str) -> list[Interval]:
    """The pieces of a greatest cover by the paper's binary integer linear programme, solved by HiGHS: the reference.

    Each action is covered at most once. The gain is the covered length, less a bit per piece, plus a smaller bit for
    long pieces.
    """
    import numpy as np
    from scipy.optimize import LinearConstraint, milp
    from scipy.sparse import csr_array

    n, loops = len(text), _loops(text, len(text))
    if not (choices := [(start, len(word)) for word, starts in loops.items() for start in starts]):
        return []
    rows, columns = zip(*((start + k, c) for c, (start, size) in enumerate(choices) for k in range(size)), strict=True)
    matrix = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, len(choices)))
    bit = 1 / n
    gains = np.array([size - bit + size**2 * bit**3 for _, size in choices])
    solution = milp(
        -gains,
        integrality=np.ones(len(choices), dtype=np.int64),
        constraints=LinearConstraint(matrix, ub=1),
        options={"mip_rel_gap": 0.0},
    )
    if not solution.success:
        raise LockprobeError(f"the loop cover of a trial of {n} actions was not found: {solution.message}")
    return sorted(choices[i] for i in np.flatnonzero(solution.x > 0.5))


def _longest_loops(text: str) -> list[int]:
    """For each start the length of the longest loop there that may be a piece, below ``LENGTH`` for none.

    Every part of a loop is a loop. So as the start goes left the end of the longest never goes right: at most 2 n
    searches of a trial.
    """
    reach, end = [0] * len(text), len(text)
    if end > LONGEST_WITH_ALL:
        for word, starts in _loops(text, 2 * LENGTH).items():
            for start in starts:
                reach[start] = len(word)
        return reach
    for start in range(end - LENGTH, -1, -1):
        while text.count(text[start:end]) < 2:
            end -= 1
        reach[start] = end - start
    return reach


@lru_cache(maxsize=1 << 16)
def _scheduled(text: str) -> list[Interval]:
    """The pieces of a greatest cover of fewest pieces, the first of them as early and as long as they can be."""
    reach = _longest_loops(text)
    n, length = len(text), [0] * len(text)
    worth = [0] * (n + 1)  # of what is covered from an action on; one action counts more than all pieces together
    for start in range(n - 1, -1, -1):
        worth[start] = worth[start + 1]
        for size in range(LENGTH, reach[start] + 1):
            found = size * n - 1 + worth[start + size]
            if found >= worth[start]:
                worth[start], length[start] = found, size
    pieces, start = [], 0
    while start < n:
        if length[start]:
            pieces.append((start, length[start]))
        start += length[start] or 1
    return pieces
