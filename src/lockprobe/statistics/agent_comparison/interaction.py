"""Whether noise helps one agent more than another: how the difference between them changes with p.

The difference of two agents in a block of luck at one p, less the same at the lowest p, has a mean of 0 at every p if
false reports change the success of both alike, in points. The test flips the signs of whole blocks, which keeps what
trials of a block have in common; it assumes that a change is as likely as its opposite. Exchanging the agents would
test whether they are equal in everything. Where one of the two is people their trials are clustered by person too, and
Student's t replaces the flips.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.crossed_clusters import crossed_change, people_of
from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, Sheet, block_mean

FLIPS = 4000
_TIE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class InteractionAt:
    """The interaction at one p: how much more the second agent's success changes from the lowest p than the first's.

    Attributes:
        dose: Flip probability, [0, 1].
        change: Change of the second's success less that of the first's, with its interval, corrected for all p
            (Bonferroni); without a P value.
        p_adjusted: P value from sign flips of whole blocks, corrected for all p (Westfall & Young's maximum); with
            people from Student's t, corrected by Bonferroni.
    """

    dose: float
    change: BlockMean
    p_adjusted: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Interaction:
    """Whether false reports change the success of two agents differently.

    Attributes:
        lowest: The reference p.
        at: The other values of p, ascending.
        mean: The mean of the changes over all higher p. It has no P value: where agents seldom differ such a sum is too
            skewed for flips of signs, which then reject in up to 15 % of studies (``benchmarks/comparison_rates.py``).
        p_value: Of the null hypothesis that no change differs: the largest absolute t over p, by sign flips.
        p_adjusted: Corrected for the number of pairs of agents (Holm); None before that.
    """

    lowest: float
    at: tuple[InteractionAt, ...]
    mean: BlockMean
    p_value: float
    p_adjusted: float | None = None

    @property
    def clearest(self) -> InteractionAt:
        """The change with the smallest P value; of equal ones the largest."""
        return min(self.at, key=lambda at: (at.p_adjusted, -abs(at.change.value)))


def interaction(
    values: tuple[float, ...], first: Sheet, second: Sheet, rng: np.random.Generator, flips: int = FLIPS
) -> Interaction | None:
    """Test whether p changes two agents' success differently; None if fewer than two blocks have both p of a change.

    Args:
        values: The values of p, ascending: the columns of both agents' sheets.
        first: The reference agent.
        second: The other agent.
        rng: The stream of the flips.
        flips: Number of flips.
    """
    apart = second.solved - first.solved
    if (person := people_of((first, second))) is not None:
        return _with_people(values, apart, person)
    changes: Array = apart[:, 1:] - apart[:, :1]
    changes = changes[~np.isnan(changes).all(axis=1)]
    met = [i for i in range(changes.shape[1]) if not np.isnan(changes[:, i]).all()]
    if len(changes) < 2 or not met:
        return None
    found = np.nan_to_num(changes[:, met])
    scale = np.sqrt(np.sum(found**2, axis=0))
    scale = np.where(scale > 0, scale, np.inf)
    observed = np.abs(found.sum(axis=0)) / scale
    signs = rng.integers(0, 2, size=(flips, len(found))) * 2.0 - 1.0
    largest = (np.abs(signs @ found) / scale).max(axis=1)
    reached = [(1 + int(np.sum(largest >= value - _TIE))) / (1 + flips) for value in observed]
    return Interaction(
        lowest=values[0],
        at=tuple(
            InteractionAt(dose=values[i + 1], change=_mean(changes[:, [i]], len(met)), p_adjusted=p_value)
            for i, p_value in zip(met, reached, strict=True)
        ),
        mean=_mean(changes[:, met]),
        p_value=min(reached),
    )


def _with_people(values: tuple[float, ...], apart: Array, person: NDArray[np.str_]) -> Interaction | None:
    """The same with people, who meet no luck twice: the two trials of a change belong to different people."""
    met = ~np.isnan(apart[:, 1:]) & ~np.isnan(apart[:, :1])
    found, choices = [], int(met.any(axis=0).sum())
    for i in range(met.shape[1]):
        if not (here := met[:, i]).any():
            continue
        person_of = person[here, 0], person[here, i + 1]
        change = crossed_change(apart[here, 0], apart[here, i + 1], person_of, choices=choices)
        if change.p_value is not None:
            found.append((values[i + 1], change, change.p_value))
    if not found:
        return None
    at = tuple(
        InteractionAt(dose=p, change=replace(change, p_value=None), p_adjusted=min(1.0, len(found) * p_value))
        for p, change, p_value in found
    )
    mean = replace(_mean(apart[:, 1:] - apart[:, :1]), low=None, high=None)  # its blocks share people
    return Interaction(lowest=values[0], at=at, mean=mean, p_value=min(one.p_adjusted for one in at))


def _mean(changes: Array, choices: int = 1) -> BlockMean:
    return replace(block_mean(changes, unit=2.0, choices=choices), p_value=None)
