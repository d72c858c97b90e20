"""The ranks that agents of a suite may have: from simultaneous intervals of the differences of every two agents.

An agent ranks below every agent that is shown to be more competent and above every agent that is shown to be less
competent; every rank in between is possible. All differences are one family, so with a probability of at least 95 %
every agent's true rank is among its possible ones, whoever comes first by luck (Klein, Wright and Wieczorek, A joint
confidence region for an overall ranking of populations, JRSS C 69, 2020; Mogstad, Romano, Shaikh and Wilhelm,
Inference for ranks, Review of Economic Studies 91, 2024). Two agents are compared on the trials of equal luck that both
finished; levels have equal weight (:func:`lockprobe.statistics.suite.scores.mean_difference`).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from lockprobe.statistics.outcomes import Outcomes, solved_in_pairs
from lockprobe.statistics.suite.scores import mean_difference

__all__ = ["possible_ranks"]


def possible_ranks(told: Sequence[Sequence[Outcomes]]) -> list[tuple[int, int]]:
    """The best and the worst possible rank of every agent, from 1.

    Args:
        told: Each agent's ended trials with true reports, level by level; agents have the same levels.
    """
    above, below = [0] * len(told), [0] * len(told)
    pairs = list(combinations(range(len(told)), 2))
    for one, other in pairs:
        if verdict := _more_competent(told[one], told[other], len(pairs)):
            better, worse = (other, one) if verdict > 0 else (one, other)
            below[better] += 1
            above[worse] += 1
    return [(1 + better, len(told) - worse) for better, worse in zip(above, below, strict=True)]


def _more_competent(first: Sequence[Outcomes], second: Sequence[Outcomes], choices: int) -> int:
    """1 if the second agent is shown to be the more competent, -1 if the first is, else 0."""
    found = mean_difference([solved_in_pairs(*both) for both in zip(first, second, strict=True)], choices)
    return 0 if found is None else (found.low > 0) - (found.high < 0)
