"""Whether trials break more often at some p than at others, so that those that remain are a biased sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.outcomes import Outcomes, appended
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion

PERMUTATIONS = 999


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenShares:
    """Share of broken trials by p.

    Attributes:
        at: Share of begun trials that broke, by p, ascending.
        p_value: Permutation test (within trials of equal luck) that the shares are equal at all p; None if no two p
            share a trial.
    """

    at: tuple[tuple[float, Proportion], ...]
    p_value: float | None

    @property
    def differ(self) -> bool:
        """Whether the share of broken trials is shown to depend on p."""
        return self.p_value is not None and self.p_value < ALPHA


def broken_shares(counted: Outcomes, broken: Outcomes, rng: np.random.Generator) -> BrokenShares | None:
    """Count the broken trials of one agent at each p, given its ended ones; None if none broke."""
    if not len(broken):
        return None
    begun = appended(counted, broken)
    broke = replace(begun, solved=np.arange(len(begun)) >= len(counted))
    here = [(float(p), broke.solved[broke.dose == p]) for p in np.unique(broke.dose)]
    return BrokenShares(
        at=tuple((p, proportion(int(which.sum()), len(which))) for p, which in here),
        p_value=any_difference(broke, rng, PERMUTATIONS).omnibus,
    )
