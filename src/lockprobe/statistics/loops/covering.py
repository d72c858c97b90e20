"""Action loops: the first one of a trial, and covers of a trial by them.

An *action loop* is a run of three or more consecutive actions that stands at least twice in one trial. The paper (Sec.
3.3) reports the share of trials that hold one, and covers a trial by disjoint loops of greatest total length, by a
binary integer linear programme. It does not say whether the two copies may overlap (here by default not: ``A A A A``
holds no loop), which changes how many trials loop.

Choosing disjoint pieces of greatest total length is interval scheduling: the best cover of the trial from action i on
follows from the best covers from later actions on. A loop of 2 m actions or more, m the shortest length, is two loops
in a row, so loops of m to 2 m - 1 actions already cover as much as all: the cost is linear in the trial.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue, LockprobeError
from lockprobe.statistics.loops import Solver

Trial = Sequence[Hashable] | NDArray[Any]
"""The actions of a trial in order; of an array, shape (n,)."""

LONGEST_ILP = 120

TRIAL_LENGTH = 5000
"""Up to here a sequence is a trial, and loops of any length are its pieces; above it only the shortest ones."""

Interval = tuple[int, int]
"""A piece of a trial: its first action (from 0) and its length."""


def _letters(trial: Trial, min_length: int = 1) -> tuple[Sequence[Hashable], str]:
    """The actions as plain Python values, and as a string of one letter per action, whose searches run in C."""
    if min_length < 1:
        raise BadValue("shortest loop", min_length, "at least 1 action")
    if isinstance(trial, np.ndarray) and trial.ndim != 1:
        raise BadValue("sequence", trial.shape, "an array of shape (n,)")
    actions: Sequence[Hashable] = trial.tolist() if isinstance(trial, np.ndarray) else trial
    names: dict[Hashable, str] = {}
    text = "".join([names.setdefault(action, chr(len(names))) for action in actions])
    if any(action != action for action in names):  # noqa: PLR0124
        raise BadValue("sequence", "NaN", "one action per step; give trials of different length as a list of sequences")
    return actions, text


def any_loop(trial: Trial, *, min_length: int = 3, overlap: bool = False) -> bool:
    """Whether a trial holds a loop; settings as in :func:`cover`."""
    return onset(trial, min_length=min_length, overlap=overlap) > 0


def onset(trial: Trial, *, min_length: int = 3, overlap: bool = False) -> int:
    """The step at which the first loop of a trial is complete, from 1; 0 if it holds none.

    >>> onset("ABCDABC")
    7
    """
    _, text = _letters(trial, min_length)
    apart = 1 if overlap else min_length
    first: dict[str, int] = {}
    for start in range(len(text) - min_length + 1):
        if start - first.setdefault(text[start : start + min_length], start) >= apart:
            return start + min_length
    return 0


def onset_batch(trials: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False) -> NDArray[np.int64]:
    """:func:`onset` of many trials, integers of shape (trials, n); shape (trials,).

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length.
    """
    if trials.ndim != 2:
        raise BadValue("sequences", trials.shape, "an array of shape (trials, n)")
    steps = np.ascontiguousarray(trials.T)
    n = len(steps)
    first = np.full(len(trials), n + 1)
    for distance in range(1 if overlap else min_length, n - min_length + 1):
        run, size = steps[:-distance] == steps[distance:], 1
        while size < min_length:  # runs of equal steps, each made of two shorter ones
            more = min(size, min_length - size)
            run = run[:-more] & run[more:]
            size += more
        np.minimum(first, np.where(run.any(axis=0), run.argmax(axis=0) + distance + min_length, n + 1), out=first)
    return np.where(first > n, 0, first)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopCover:
    """One cover of a trial by action loops.

    Attributes:
        n: Actions in the trial.
        any_loop: Whether the trial holds a loop.
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


def cover(trial: Trial, *, solver: Solver = "dp", overlap: bool = False, min_length: int = 3) -> LoopCover:
    """Cover as much of a trial as possible by disjoint copies of its action loops (maximum coverage).

    Of several greatest covers it is the one of fewest pieces, longest first. A piece that is itself a repetition is
    then written as its copies, ``ABCABC`` as ``ABC ABC``: loops on the same actions. Above 5000 actions the pieces are
    fewest among those of ``min_length`` to ``2 * min_length - 1`` actions, which cover as much in linear time. 20
    actions take 0.03 ms, 5000 less than half a second, a million a few seconds.

    Args:
        trial: The actions in order.
        solver: Our exact solver, or the paper's integer linear programme, of at most ``LONGEST_ILP`` actions.
        overlap: Whether the two copies that make a loop may share actions. Chosen pieces never do.
        min_length: Fewest actions in a loop (at least 1; 3 in the paper).

    >>> found = cover("ABCABCABC")
    >>> found.words, found.intervals, found.share
    ((('A', 'B', 'C'),), ((0, 3), (3, 3), (6, 3)), 1.0)
    """
    if solver not in get_args(Solver):
        raise BadValue("solver", solver, "dp or ilp")
    actions, text = _letters(trial, min_length)
    if solver == "ilp":
        if len(text) > LONGEST_ILP:
            raise BadValue("actions for the solver ilp", len(text), f"at most {LONGEST_ILP}; dp has no limit")
        chosen = _programme(text, min_length, overlap=overlap)
    else:
        chosen = _fewest_longest(_longest_loops(text, min_length, overlap=overlap), min_length)
    pieces = [part for piece in chosen for part in _copies(text, piece, min_length)]
    return LoopCover(
        n=len(text),
        any_loop=bool(pieces),
        covered=sum([length for _, length in pieces]),
        words=tuple(dict.fromkeys([tuple(actions[start : start + length]) for start, length in pieces])),
        intervals=tuple(pieces),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopMeasures:
    """The loop measures of trials: ``n`` actions, of which ``covered`` by loops; step of the first loop, 0 without."""

    n: NDArray[np.int64]
    covered: NDArray[np.int64]
    onset: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.n)

    @property
    def any_loop(self) -> NDArray[np.bool_]:
        """Whether each trial holds a loop."""
        return self.onset > 0

    @property
    def share(self) -> NDArray[np.float64]:
        """Covered share of each trial, 0 to 1 (0 for an empty trial)."""
        return np.asarray(self.covered / np.maximum(self.n, 1), dtype=np.float64)


def measure(
    trials: NDArray[Any] | Sequence[Sequence[Hashable]], *, overlap: bool = False, min_length: int = 3
) -> LoopMeasures:
    """The loop measures of many trials; 20 actions take 0.05 ms.

    ``trials`` are of equal length as an array of shape (trials, n), or a list of any lengths; settings as in
    :func:`cover`.

    >>> measure(["ABCABCA", "ABCD"]).covered
    array([6, 0])
    """
    if isinstance(trials, np.ndarray) and trials.ndim != 2:
        raise BadValue("sequences", trials.shape, "an array of shape (trials, n), or a list of trials")
    covered = [cover(one, overlap=overlap, min_length=min_length).covered for one in trials]
    first = [onset(one, overlap=overlap, min_length=min_length) for one in trials]
    n, covers, onsets = (np.array(column, dtype=np.int64) for column in ([len(one) for one in trials], covered, first))
    return LoopMeasures(n=n, covered=covers, onset=onsets)


def _loops(text: str, min_length: int, *, overlap: bool, below: int | None = None) -> dict[str, list[int]]:
    """All loops of a trial (of less than ``below`` actions) with the starts of all their copies, short ones first."""
    loops: dict[str, list[int]] = {}
    for length in range(min_length, min(below or len(text), len(text))):
        starts: dict[str, list[int]] = {}
        for start in range(len(text) - length + 1):
            starts.setdefault(text[start : start + length], []).append(start)
        apart = 1 if overlap else length
        found = {word: at for word, at in starts.items() if at[-1] - at[0] >= apart}
        if not found:
            break
        loops.update(found)
    return loops


def _programme(text: str, min_length: int, *, overlap: bool) -> list[Interval]:
    """The pieces of a greatest cover by the paper's binary integer linear programme, solved by HiGHS: the reference.

    Each action is covered at most once. The gain is the covered length, less a bit per piece, plus a smaller bit for
    long pieces.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array

    n, loops = len(text), _loops(text, min_length, overlap=overlap)
    if not (choices := [(start, len(word)) for word, starts in loops.items() for start in starts]):
        return []
    rows, columns = zip(*((start + k, c) for c, (start, size) in enumerate(choices) for k in range(size)), strict=True)
    matrix = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, len(choices)))
    gains = np.array([size - 1 / (n + 1) + size**2 / (n + 1) ** 3 for _, size in choices])
    solution = milp(
        -gains,
        integrality=np.ones(len(choices), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(matrix, ub=1),
        options={"mip_rel_gap": 0.0},
    )
    if not solution.success:
        raise LockprobeError(f"the loop cover of a trial of {n} actions was not found: {solution.message}")
    return sorted(piece for piece, x in zip(choices, solution.x, strict=True) if x > 0.5)


def _copies(text: str, piece: Interval, min_length: int) -> list[Interval]:
    """A piece as the copies of its shortest loop that it repeats; itself if it repeats none."""
    start, length = piece
    word = text[start : start + length]
    for size in range(min_length, length // 2 + 1):
        if length % size == 0 and word == word[:size] * (length // size):
            return [(at, size) for at in range(start, start + length, size)]
    return [piece]


def _longest_loops(text: str, min_length: int, *, overlap: bool) -> list[int]:
    """For each start the length of the longest loop there that may be a piece, 0 for none.

    Every part of a loop (of ``min_length`` or more) is a loop. So as the start goes left the end of the longest never
    goes right: at most 2 n searches of a trial.
    """
    reach = [0] * (len(text) + 1)
    if len(text) > TRIAL_LENGTH:
        for word, starts in _loops(text, min_length, overlap=overlap, below=2 * min_length).items():
            for start in starts:
                reach[start] = len(word)
        return reach
    end = len(text)
    for start in range(len(text) - min_length, -1, -1):
        while end - start >= min_length:
            word = text[start:end]
            if text.rfind(word) > text.find(word) if overlap else text.count(word) > 1:
                reach[start] = len(word)
                break
            end -= 1
    return reach


def _fewest_longest(reach: list[int], min_length: int) -> list[Interval]:
    """The greatest cover of fewest pieces; of those, the first piece starts earliest, is longest, and so on.

    From the right: ``worth[i]`` is the number of actions before action i, and of those that are covered from there on,
    one action counting more than all pieces together. A piece from i may end anywhere in a window whose right edge
    only moves left, so a queue of candidate ends with falling worth gives its best end, in linear time over all i.
    """
    if not any(reach):
        return []
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
