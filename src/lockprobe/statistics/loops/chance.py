"""The chance level of action loops: the loop rate of a blind agent, by trial length.

Over 4 joints and 20 steps a uniformly random agent loops in 80 % of its trials. The paper (section "Repetitive Action
Loops as a Candidate Failure Mode") reports about 80 % as its maximum. A loop rate means something only next to the
chance level for the same length.

Most levels are exact. ``chance_table.json``, made by ``scripts/make_chance_table.py``, counts loop-free patterns
(sequences up to the names of their actions). Other levels are simulated.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from math import perm, sqrt
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.statistics.loops import LENGTH, onset_batch

Null = Literal["uniform", "no-repeat"]
"""The blind agent: any action with equal probability, or any but the one before."""

CHUNKS, CHUNK = 20, 5000
"""20 chunks of 5000 sequences are simulated."""

FIRST = 20
"""Steps of the shortest simulated trials; others have 40, 80 ... steps. A trial serves for every shorter length."""


class Chance(NamedTuple):
    """The probability of a loop; its standard error is 0 if it is exact (counted), and never if it is simulated."""

    probability: float
    error: float = 0.0

    @property
    def method(self) -> Literal["exact", "simulation"]:
        """How it was found."""
        return "simulation" if self.error else "exact"


def chance_level(length: int, actions: int = 4, *, null: Null = "uniform") -> Chance:
    """The chance level of an action loop, given the length of the trial.

    Exact over 4 actions or fewer up to length 20 (5: 18, 6: 17, more: 16; without repeats 5: 20, 6: 19, 7: 18, more:
    17), and wherever it is 0 or 1. Otherwise simulated, with the same 100 000 sequences at every call.

    Args:
        length: Steps in the trial (at least 0).
        actions: Actions to choose from (at least 1; ``no-repeat`` needs 2).
        null: How the blind agent chooses.

    >>> chance_level(20).probability == 1 - 219_018_772_080 / 4**20
    True
    """
    if null not in get_args(Null):
        raise BadValue("null", null, " or ".join(get_args(Null)))
    for name, value, least in (("length of the trial", length, 0), ("actions", actions, 1 + (null == "no-repeat"))):
        if value < least:
            raise BadValue(name, value, f"at least {least}")
    starts, others = length - LENGTH + 1, actions - (null == "no-repeat")
    if starts <= LENGTH:
        return Chance(0.0)
    if starts > LENGTH * actions * others ** (LENGTH - 1):
        # Copies of one word in a loop-free trial all start within three steps of each other.
        return Chance(1.0)
    rows = _table()[null]
    row = rows[length][: actions + 1] if length < len(rows) else [None]
    counted = [patterns for patterns in row if patterns is not None]
    if len(counted) == len(row):  # a pattern of k distinct actions stands for actions!/(actions - k)! sequences
        free = sum(patterns * perm(actions, distinct) for distinct, patterns in enumerate(counted))
        total = actions * others ** (length - 1)
        return Chance((total - free) / total)
    # simulated trials are the same for all lengths up to 20, 40, 80 ... steps; beyond about n = 6.5 sqrt(words) steps,
    # where n^2 / 2 pairs of words match with a probability of 1 / words each, none is without a loop (below 1e-9)
    steps = FIRST
    while steps < length:
        steps *= 2
    onsets = _onsets(min(steps, 2 * LENGTH + int(6.5 * sqrt(actions**LENGTH))), actions, null)
    found = ((onsets > 0) & (onsets <= length)).astype(np.float64)
    error = np.append(found, (0.0, 1.0)).std() / sqrt(len(found))  # with one trial of each kind more: never 0
    return Chance(float(found.mean()), float(error))


def expected_loop_rate(sizes: Iterable[tuple[int, int]], null: Null) -> Chance:
    """The loop rate of a blind agent in trials of these lengths and numbers of actions (at least one trial).

    Its error is an upper bound where levels of several lengths were simulated together.
    """
    counted = Counter(sizes)
    levels = [(n / counted.total(), chance_level(*size, null=null)) for size, n in counted.items()]
    probability, error = (sum(share * level[of] for share, level in levels) for of in (0, 1))
    return Chance(probability, error)


@cache
def _table() -> dict[str, list[list[int | None]]]:
    """Loop-free patterns under each null: by length, then by number of distinct actions."""
    return json.loads(files("lockprobe.statistics.loops").joinpath("chance_table.json").read_text("utf-8"))  # type: ignore[no-any-return]


@cache
def _onsets(steps: int, actions: int, null: Null) -> NDArray[np.int64]:
    """Steps at which seeded trials complete their first loop.

    Most loop early: of each trial 20 steps are examined, then 40, 80 ...
    """
    rng = generator(0, "chance", null, actions)
    found = []
    for _ in range(CHUNKS):
        sequences = rng.integers(null == "no-repeat", actions, (CHUNK, steps))
        if null == "no-repeat":
            sequences = sequences.cumsum(axis=1) % actions
        sequences = sequences.astype(np.min_scalar_type(actions))
        onsets, undecided, examined = np.zeros(CHUNK, dtype=np.int64), np.arange(CHUNK), FIRST
        while True:
            onsets[undecided] = onset_batch(sequences[undecided, :examined])
            undecided = undecided[onsets[undecided] == 0]
            if examined >= steps or not len(undecided):
                break
            examined *= 2
        found.append(onsets)
    return np.concatenate(found)
