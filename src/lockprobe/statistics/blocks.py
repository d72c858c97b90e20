"""The one contrast of conditions: a weighted sum of success in blocks of equal luck, with its interval and its test.

A *block* is one repetition and trial, which share their luck under all conditions. Only blocks with an ended trial
under every condition of a contrast count for it. If trials broke, interval and P value hold whatever became of these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.paired import Array, columns, mean_of_blocks
from lockprobe.statistics.broken_trials import bounded
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.paired_proportions import ONE_BOX
from lockprobe.statistics.proportions import Difference

Weights = Mapping[str, int]
"""Condition -> its weight in a contrast; they sum to 0."""


class Played(Protocol):
    """One agent under one condition."""

    @property
    def ended(self) -> Outcomes:
        """Its trials that ended as solved or out of budget."""

    @property
    def broke(self) -> Outcomes:
        """Its trials that broke."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Blocks:
    """Success of one agent under several conditions.

    Attributes:
        solved: Condition -> 1 if solved, 0 if not, NaN where no trial has ended, shape (blocks,).
        broke: Condition -> whether its trial broke, of the same shape; none for conditions in which none did.
        box: The box of each block, of the same shape; no rows if all are of one.
        planned: Whether blocks are in the order of the plan, and what is said must hold at every look.
    """

    solved: Mapping[str, Array]
    broke: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    box: NDArray[np.str_] = field(default_factory=lambda: ONE_BOX)
    planned: bool = False

    def sums(self, *contrasts: Weights) -> list[Array]:
        """The weighted sums of each block, shape (blocks, contrasts), NaN in blocks that lack a condition.

        They are those of the trials that ended, and if some broke, also those at the low and at the high end of what
        these can have become.
        """
        ends = [(self.solved, self.solved)]
        if any(self.broke[name].any() for weights in contrasts for name in weights if name in self.broke):
            low, high = (
                {name: np.where(self.broke.get(name, False), end, own) for name, own in self.solved.items()}
                for end in (0.0, 1.0)
            )
            ends += [(low, high), (high, low)]
        found = []
        for gains, losses in ends:
            sums = [
                np.sum([weight * (gains if weight > 0 else losses)[name] for name, weight in of.items()], axis=0)
                for of in contrasts
            ]
            table = np.column_stack(sums)
            table[np.isnan(table).any(axis=1)] = math.nan
            found.append(table)
        return found


def blocks_of(cells: Mapping[str, Played]) -> Blocks:
    """The blocks of one agent, from its trials under each condition."""
    laid = columns([*(one.ended for one in cells.values()), *(one.broke for one in cells.values())])
    solved = [sheet.solved[:, 0] for sheet in laid]
    broke = zip(cells, (~np.isnan(own) for own in solved[len(cells) :]), strict=True)
    return Blocks(
        solved=dict(zip(cells, solved, strict=False)), broke=dict(broke), box=laid[0].box, planned=laid[0].planned
    )


def contrast(blocks: Blocks, *contrasts: Weights, factor: float = 1.0, choices: int = 1) -> Difference:
    """The mean over blocks of contrasts of success; of nothing if no block has a trial under all of their conditions.

    The P value is from sign flips of whole blocks. ``factor`` scales the sums, and ``choices`` means are judged
    together (Bonferroni).
    """
    most = max(sum(weight for weight in weights.values() if weight > 0) for weights in contrasts)
    found, *ends = (
        mean_of_blocks(sums, blocks.box, planned=blocks.planned, unit=most, factor=factor, choices=choices)
        for sums in blocks.sums(*contrasts)
    )
    return bounded(found, *ends) if ends and found.n else found
