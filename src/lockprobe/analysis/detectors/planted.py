"""Trials of which it is known whether they go round in circles: random ones, and ones with a planted loop.

All are 20 steps over 4 actions. Outside its planted loop an agent acts at random without immediate repeats.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

__all__ = ["ACTIONS", "PLANTED", "STEPS", "Kind", "Made", "interrupted", "plant", "unplanted"]

STEPS, ACTIONS = 20, 4

MOVES = 0.5
"""Probability that an attempt moves its joint; on chain-4 a random agent's attempts do in 48 of 100."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What is planted.

    Attributes:
        name: In words.
        period: Distinct actions that are repeated in one order.
        copies: How often.
        mutation: Probability that a planted action is another one instead.
    """

    name: str
    period: int
    copies: int
    mutation: float = 0.0

    @property
    def length(self) -> int:
        """Planted steps."""
        return self.period * self.copies


PLANTED = (
    Kind(name="A x6", period=1, copies=6),
    Kind(name="period 2 x4", period=2, copies=4),
    Kind(name="period 3 x3", period=3, copies=3),
    Kind(name="period 4 x3", period=4, copies=3),
    Kind(name="period 4 x3, 10 % mutated", period=4, copies=3, mutation=0.1),
    Kind(name="period 4 x5", period=4, copies=5),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """Trials made by chance.

    Attributes:
        actions: Shape (trials, 20).
        moved: Whether each attempt moved its joint, shape (trials, 20).
        middle: Steps before the middle of the planted loop, shape (trials,); of the trial where none is planted.
    """

    actions: NDArray[np.int64]
    moved: NDArray[np.bool_]
    middle: NDArray[np.int64]


def unplanted(trials: int, rng: Generator, *, repeats: bool) -> Made:
    """Random trials, with immediate repeats or without."""
    turns = rng.integers(0 if repeats else 1, ACTIONS, (trials, STEPS))
    moved = rng.random((trials, STEPS)) < MOVES
    return Made(actions=turns.cumsum(axis=1) % ACTIONS, moved=moved, middle=np.full(trials, STEPS // 2))


def plant(kind: Kind, trials: int, rng: Generator) -> Made:
    """Random trials with a loop at a random place.

    Every copy of the loop meets the same outcomes. A mutated action differs from the one it replaces and from its
    neighbours, and its outcome is drawn anew.
    """
    starts = rng.integers(0, STEPS - kind.length + 1, trials)
    words = rng.permuted(np.tile(np.arange(ACTIONS), (trials, 1)), axis=1)[:, : kind.period]
    loops = np.tile(words, kind.copies)
    # A trial is the sum of its turns: those inside the loop are the loop's, all others are random.
    turns = rng.integers(1, ACTIONS, (trials, STEPS))
    moved = rng.random((trials, STEPS)) < MOVES
    rows, places = np.arange(trials)[:, None], starts[:, None] + np.arange(kind.length)
    turns[rows, places[:, 1:]] = np.diff(loops) % ACTIONS
    moved[rows, places] = moved[rows, places[:, np.arange(kind.length) % kind.period]]
    actions = turns.cumsum(axis=1) % ACTIONS
    mutated = rng.random(places.shape) < kind.mutation
    for row, column in zip(*np.nonzero(mutated), strict=True):
        at = places[row, column]
        actions[row, at] = _other(actions[row, max(at - 1, 0) : at + 2].tolist(), rng)
        moved[row, at] = rng.random() < MOVES
    return Made(actions=actions, moved=moved, middle=starts + kind.length // 2)


def interrupted(made: Made, rng: Generator) -> tuple[list[list[int]], list[list[bool]]]:
    """The trials with two other actions in the middle of the loop, and their outcomes.

    The first differs from both actions around, the second from the first and from the one that follows.
    """
    actions, moved = made.actions.tolist(), made.moved.tolist()
    for row, went, middle in zip(actions, moved, made.middle.tolist(), strict=True):
        first = _other(row[middle - 1 : middle + 1], rng)
        row[middle:middle] = [first, _other([first, row[middle]], rng)]
        went[middle:middle] = (rng.random(2) < MOVES).tolist()
    return actions, moved


def _other(taken: list[int], rng: Generator) -> int:
    """An action that is not taken."""
    return int(rng.choice([action for action in range(ACTIONS) if action not in taken]))
