"""Action loops: runs of consecutive actions that stand at least twice in one trial (paper, Sec. 3.3)."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue

Interval = tuple[int, int]
"""A piece of a trial: its first action (from 0) and its length."""

_LETTERS = 0x110000
"""How many characters there are."""


def actions_of(sequence: Sequence[Hashable] | NDArray[Any]) -> Sequence[Hashable]:
    """The trial as a sequence of plain Python values."""
    if not isinstance(sequence, np.ndarray):
        return sequence
    if sequence.ndim != 1:
        raise BadValue("sequence", sequence.shape, "an array of shape (n,)")
    _refuse_nan(sequence)
    actions: list[Hashable] = sequence.tolist()
    return actions


def letters(actions: Sequence[Hashable]) -> str:
    """The trial as a string of one letter per action, whose searches run in C."""
    names: dict[Hashable, str] = {}
    if len(actions) > _LETTERS and (distinct := len(set(actions))) > _LETTERS:
        raise BadValue("distinct actions", distinct, f"at most {_LETTERS}")
    text = "".join([names.setdefault(action, chr(len(names))) for action in actions])
    _refuse_nan(names)
    return text


def _refuse_nan(actions: Collection[Hashable] | NDArray[Any]) -> None:
    """Refuse actions that are not equal to themselves (NaN): their recurrence would depend on their storage."""
    if isinstance(actions, np.ndarray):
        found = actions.dtype.kind not in "iubUS" and bool((actions != actions).any())  # noqa: PLR0124
    else:
        found = any(action != action for action in actions)  # noqa: PLR0124
    if found:
        expected = "one action per step; give trials of different length as a list of sequences"
        raise BadValue("sequence", "NaN", expected)


def any_loop(sequence: Sequence[Hashable] | NDArray[Any], *, min_length: int = 3, overlap: bool = False) -> bool:
    """Whether a trial holds a loop; settings as in :func:`cover`. Words of ``min_length`` decide."""
    return onset(sequence, min_length=min_length, overlap=overlap) > 0


def onset(sequence: Sequence[Hashable] | NDArray[Any], *, min_length: int = 3, overlap: bool = False) -> int:
    """The step at which the first loop of a trial is complete, from 1; 0 if it holds none.

    >>> onset("ABCDABC")
    7
    """
    apart = least_distance(min_length, overlap=overlap)
    text = letters(actions_of(sequence))
    first: dict[str, int] = {}
    for start in range(len(text) - min_length + 1):
        if start - first.setdefault(text[start : start + min_length], start) >= apart:
            return start + min_length
    return 0


def any_loop_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.bool_]:
    """As :func:`any_loop` for many trials: integers of shape (trials, n) in, shape (trials,) out."""
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    _refuse_nan(sequences)
    steps, undecided = np.ascontiguousarray(sequences.T), np.arange(len(sequences))
    found = np.zeros(len(sequences), dtype=np.bool_)
    for distance in range(least_distance(min_length, overlap=overlap), len(steps) - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        run = _runs(same, min_length)
        looping = run.any(axis=0)
        found[undecided[looping]] = True
        undecided, steps = undecided[~looping], steps[:, ~looping]
    return found


def onset_batch(
    sequences: NDArray[np.integer[Any]], *, min_length: int = 3, overlap: bool = False
) -> NDArray[np.int64]:
    """The step at which the first loop of each trial is complete, from 1, shape (trials,); 0 without a loop.

    A trial of length L holds a loop exactly if its onset is at most L, so one call answers every length. Sequences are
    integers of shape (trials, n); settings as in :func:`cover`.
    """
    if sequences.ndim != 2:
        raise BadValue("sequences", sequences.shape, "an array of shape (trials, n)")
    _refuse_nan(sequences)
    steps = np.ascontiguousarray(sequences.T)
    n = len(steps)
    first = np.full(len(sequences), n + 1)
    for distance in range(least_distance(min_length, overlap=overlap), n - min_length + 1):
        same = steps[:-distance] == steps[distance:]
        run = _runs(same, min_length)
        found = np.where(run.any(axis=0), run.argmax(axis=0) + distance + min_length, n + 1)
        np.minimum(first, found, out=first)
    return np.where(first > n, 0, first)


def _runs(same: NDArray[np.bool_], length: int) -> NDArray[np.bool_]:
    """Where runs of ``length`` steps begin, from where single ones are; each is made of two shorter runs."""
    size = 1
    while size < length:
        more = min(size, length - size)
        same = same[:-more] & same[more:]
        size += more
    return same


def all_loops(text: str, min_length: int, *, overlap: bool = False, below: int | None = None) -> dict[str, list[int]]:
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


def least_distance(min_length: int, *, overlap: bool) -> int:
    """Least distance between the starts of two copies of a word of ``min_length``."""
    if min_length < 1:
        raise BadValue("shortest loop", min_length, "at least 1 action")
    return 1 if overlap else min_length
