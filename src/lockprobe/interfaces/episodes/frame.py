"""Episodes as columns of NumPy, and which of them have equal luck: the same task and the same seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Episodes:
    """Episodes in the order of the file, one each place of every column.

    Attributes:
        agents, conditions, tasks: Names, as they come; the control is the first condition.
        agent, condition, task: Places of these names.
        luck: Number of its task and seed, from 0 as they come; -1 of an episode without a seed.
        rank: Which it is of several of one agent, condition and luck, from 0.
        solved, score, steps: 1 or 0, from 0 to 1, and steps played; NaN where nobody says.
        actions: What each did, step by step; empty where nobody says.
    """

    agents: Sequence[str]
    conditions: Sequence[str]
    tasks: Sequence[str]
    agent: Codes
    condition: Codes
    task: Codes
    luck: Codes
    rank: Codes
    solved: Array
    score: Array
    steps: Array
    actions: Sequence[Sequence[str]]

    def __len__(self) -> int:
        return len(self.agent)

    @property
    def measures(self) -> dict[str, Array]:
        """What can be compared."""
        known = {"success": self.solved, "score": self.score}
        return {name: values for name, values in known.items() if not np.isnan(values).all()}

    @property
    def cells(self) -> list[tuple[dict[str, str], Flags]]:
        """The names of each agent and condition, and which episodes are theirs; those that have any."""
        every = ((a, c) for a in range(len(self.agents)) for c in range(len(self.conditions)))
        own = [(a, c, (self.agent == a) & (self.condition == c)) for a, c in every]
        return [({"agent": self.agents[a], "condition": self.conditions[c]}, at) for a, c, at in own if at.any()]

    def pairs(self, first: Flags, second: Flags, other: Codes) -> tuple[Codes, Codes]:
        """The places of the episodes of two sides that are pairs, in the order of luck.

        A pair has equal luck and rank, and is equal in what else differs: the agent, where conditions are compared.
        """
        key = (self.luck * (other.max() + 1) + other) * (self.rank.max() + 1) + self.rank
        one, two = (np.flatnonzero(side & (self.luck >= 0)) for side in (first, second))
        _, i, j = np.intersect1d(key[one], key[two], assume_unique=True, return_indices=True)
        return one[i], two[j]

    def cluster(self, at: Codes, fewest: int) -> Codes:
        """What is independent of episodes: their tasks; of fewer tasks their luck, or each without a seed; from 0."""
        alone = np.where(self.luck >= 0, self.luck, len(self) + np.arange(len(self)))
        return combined((self.task if len(np.unique(self.task[at])) >= fewest else alone)[at])


def combined(*columns: Codes) -> Codes:
    """The combinations of codes, numbered as they come, from 0.

    >>> combined(np.array([5, 5, 2, 5]), np.array([0, 1, 0, 0])).tolist()
    [0, 1, 2, 0]
    """
    found = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:  # numbered anew each time, so that no product is too large
        found = np.unique(found * (int(column.max(initial=0)) + 1) + column, return_inverse=True)[1].reshape(-1)
    _, first, found = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[found.reshape(-1)]


def position(group: Codes) -> Codes:
    """Which each is of its group, from 0.

    >>> position(np.array([0, 1, 0, 0])).tolist()
    [0, 0, 1, 2]
    """
    order = np.argsort(group, kind="stable")
    starts, sizes = np.unique(group[order], return_index=True, return_counts=True)[1:]
    return (np.arange(len(group)) - np.repeat(starts, sizes))[np.argsort(order)]
