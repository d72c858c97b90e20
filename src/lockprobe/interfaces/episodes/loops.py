"""Action loops of episodes at equal length: in the first steps, beside chance, and whether who looped solves less.

Long episodes hold more loops, and those that fail are long. So where loops do no harm at all, loop rates, loops beyond
chance and shuffles tie loops to failure in up to 100 % of studies. Two comparisons do not: of who looped in the first k
steps with who did not, among episodes that reach k; and at each step of who has looped before with who has not, among
those that still run. Both find that loops and failure go together, not that loops do harm.

Chance, in the first k steps of the same episodes: of uniform choices among the actions of the file (exact counts where
these are few), of the episode's own actions in random order (permutation), and of its own first-order Markov chain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.interfaces.episodes.frame import Codes, Episodes, Flags
from lockprobe.statistics.how_soon import Hazard, excess
from lockprobe.statistics.loops import onset, onset_batch
from lockprobe.statistics.loops.chance import chance_level

NULLS = ("uniform", "permutation", "Markov")
"""The chance levels of loops."""

_DRAWN, _FEWEST, _AT_ONCE = 20_000, 4, 20_000_000
"""Sequences drawn at once for a chance level, and the fewest of one episode; episodes times steps of a test."""


class Played:
    """What episodes did, loops in the first k steps; columns have a place for each episode.

    Attributes:
        length: Actions.
        onset: The step at which the first loop is complete, from 1; 0 without.
        reach: Whether there are k actions.
        early: Whether the first k hold a loop.
    """

    def __init__(self, episodes: Episodes, k: int) -> None:
        self.actions, self.k = episodes.actions, k
        self.length: Codes = np.array([len(did) for did in self.actions], dtype=np.int64)
        self.onset: Codes = np.array([onset(did) for did in self.actions], dtype=np.int64)
        self.reach: Flags = self.length >= k
        self.early: Flags = (self.onset > 0) & (self.onset <= k)
        self._numbers = {action: i for i, action in enumerate({one: None for did in self.actions for one in did})}

    def chance(self, of: Flags, null: str) -> float:
        """The share of sequences with a loop by chance, of k actions of the chosen episodes, which reach k."""
        if null == "uniform":
            return chance_level(self.k, len(self._numbers)).probability
        chosen = np.flatnonzero(of).tolist()
        first = np.array([[self._numbers[one] for one in self.actions[i][: self.k]] for i in chosen])
        every = np.repeat(first, max(_FEWEST, _DRAWN // len(first)), axis=0)
        rng, found = generator(0, "episodes", null), 0
        for some in np.array_split(every, -(-len(every) // _DRAWN)):
            drawn = _chained(some, rng) if null == "Markov" else rng.permuted(some, axis=1)
            found += int((onset_batch(drawn) > 0).sum())
        return found / len(every)


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


def looped_before(episodes: Episodes, at: Codes, onsets: Codes, cluster: Codes) -> Hazard:
    """Whether episodes that have looped before are solved more often at a step than others that still run.

    It is a Mantel-Haenszel test over steps, the log-rank test of a feature that begins when the first loop is complete.
    Its value is the ratio of both rates. ``at`` are places of episodes; onsets and clusters are theirs.
    """
    steps, solved = episodes.steps[at], (episodes.solved[at] > 0) & (episodes.steps[at] > 0)
    moments = np.unique(steps[solved])[: max(1, _AT_ONCE // len(at))]  # steps without an event tell nothing
    last, solved = np.searchsorted(moments, steps, side="right"), solved & np.isin(steps, moments)
    begun = (onsets[:, None] > 0) & (onsets[:, None] < moments)
    found = excess(begun.astype(np.float64), last, solved, cluster)
    after = int(begun[solved, last[solved] - 1].sum())
    before, expected = int(solved.sum()) - after, after - found.total
    defined = before > 0 and min(expected, before + found.total) > 0
    return replace(found, value=after / expected / (before / (before + found.total))) if defined else found
