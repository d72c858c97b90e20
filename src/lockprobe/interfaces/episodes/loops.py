"""Action loops of episodes beside chance, and whether something that begins in an episode lets it be solved sooner.

Long episodes hold more loops, and those that fail are long. So where loops do no harm at all, loop rates, loops beyond
chance and shuffles tie loops to failure in up to 100 % of studies. Two comparisons do not: of who looped in the first k
steps with who did not, among episodes that reach k; and at each step of who has looped before with who has not, among
those that still run. Both find that loops and failure go together, not that loops do harm.

Chance, in the first k steps of the same episodes: of uniform choices among the actions of the file (exact counts where
these are few), of the episode's own actions in random order (permutation), and of its own first-order Markov chain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.interfaces.episodes.frame import Array, Codes, Flags
from lockprobe.statistics.how_soon import Hazard, excess
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.loops.chance import chance_level

NULLS = ("uniform", "permutation", "Markov")
"""The chance levels of loops."""

_DRAWN, _FEWEST, _AT_ONCE = 20_000, 4, 20_000_000
"""Sequences drawn at once for a chance level, and the fewest of one episode; episodes times steps of a test."""


def chance(first: Sequence[Sequence[str]], null: str, actions: int) -> Array:
    """The probability of a loop by chance in each of several sequences of one length, among so many actions."""
    if null == "uniform":
        return np.full(len(first), chance_level(len(first[0]), actions).probability)
    numbers = {action: i for i, action in enumerate({one: None for did in first for one in did})}
    every = np.repeat([[numbers[one] for one in did] for did in first], max(_FEWEST, _DRAWN // len(first)), axis=0)
    rng, found = generator(0, "episodes", null), list[Codes]()
    for some in np.array_split(every, -(-len(every) // _DRAWN)):
        found.append(onset_batch(_chained(some, rng) if null == "Markov" else rng.permuted(some, axis=1)))
    looped: Array = (np.concatenate(found) > 0).reshape(len(first), -1).mean(axis=1)
    return looped


def _chained(sequences: Codes, rng: np.random.Generator) -> Codes:
    """Sequences with the same first actions, in which each action follows another as often as in the original.

    After an action comes what follows it at one of its places, drawn evenly; anything after one that stands last alone.
    """
    rows, last = np.arange(len(sequences)), sequences.shape[1] - 1
    order = np.argsort(sequences[:, :-1], axis=1, kind="stable")
    ordered, made = np.take_along_axis(sequences[:, :-1], order, axis=1), sequences.copy()
    for step in range(last):
        now = made[:, step, None]
        first, many = (ordered < now).sum(axis=1), (ordered == now).sum(axis=1)
        first, many = np.where(many > 0, first, 0), np.where(many > 0, many, last)
        place = order[rows, first + (rng.random(len(rows)) * many).astype(np.int64)]
        made[:, step + 1] = sequences[rows, place + 1]
    return made


def sooner(steps: Array, solved: Flags, since: Array, cluster: Codes) -> Hazard:
    """Whether episodes are solved more often at a step after something has begun than others that still run.

    It is a Mantel-Haenszel test over steps, the log-rank test of a feature that may begin late. Its value is the ratio
    of both rates. ``steps`` are those of the end, infinite for one that never ends; ``since`` is the step after which
    it has begun, infinite where it does not. Columns have a place for each episode.
    """
    solved = solved & (steps > 0)
    moments = np.unique(steps[solved])[: max(1, _AT_ONCE // len(steps))]  # steps without an event tell nothing
    last, solved = np.searchsorted(moments, steps, side="right"), solved & np.isin(steps, moments)
    begun = since[:, None] < moments
    found = excess(begun.astype(np.float64), last, solved, cluster)
    after = int(begun[solved, last[solved] - 1].sum())
    before, expected = int(solved.sum()) - after, after - found.total
    defined = before > 0 and min(expected, before + found.total) > 0
    return replace(found, value=after / expected / (before / (before + found.total))) if defined else found
