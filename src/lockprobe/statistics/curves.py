"""Cumulative success by step (one minus Kaplan-Meier; paper, Fig. 3).

A trial that runs out of budget is *censored*. With equal budgets the curve is the plain share solved. A trial that
broke in a step was not solved before it, and may have been solved in it or never: the curve has bounds and is their
middle. One minus Kaplan-Meier would be no estimate there, because long trials break.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lockprobe.statistics.broken_trials import completed
from lockprobe.statistics.clustered import crossed_proportion
from lockprobe.statistics.loops.incidence import incidence
from lockprobe.statistics.outcomes import Outcomes


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessCurve:
    """The share solved by step 0, 1, ... up to the largest budget.

    Attributes:
        n: Trials: all that were begun, or none if none ended.
        share: [0, 1]; the middle of the bounds where trials broke.
        low, high: Ends of the pointwise 95 % band, which holds whatever became of broken trials.
    """

    n: int
    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def steps_to(self, share: float = 0.8) -> int | None:
        """The first step by which at least this share of the trials is solved; None if none is."""
        return _first(self.share, share)

    def steps_to_interval(self, share: float = 0.8) -> tuple[int | None, int | None]:
        """The 95 % interval of :meth:`steps_to`, from the ends of the band; None means beyond the budget."""
        return _first(self.high, share), _first(self.low, share)

    @property
    def restricted_mean_steps(self) -> float | None:
        """Mean steps over *all* trials, unsolved ones counted with the whole budget; None without trials."""
        return sum(1 - share for share in self.share[:-1]) if self.n else None


def success_curve(counted: Outcomes, broken: Outcomes, budget: int) -> SuccessCurve:
    """Cumulative success by step over the trials of one condition, with a band clustered by player.

    Args:
        counted: The trials that ended.
        broken: Those that broke.
        budget: Most steps of a trial.
    """
    alone = not (len(counted) and len(broken))
    ends = []
    for columns in [counted] if alone else [completed(counted, broken, soon, budget) for soon in (False, True)]:
        effect = 1.0
        if columns.crossed:  # else all trials are independent
            ones = np.ones(len(columns))
            effect = crossed_proportion(columns.solved, ones, columns.player, columns.luck).design_effect
        ends.append(incidence(columns.length, columns.solved, budget, effect))
    share = np.array([one.share for one in ends]).mean(axis=0)
    return SuccessCurve(
        n=len(counted) and len(counted) + len(broken),
        share=tuple(share.tolist()),
        low=ends[0].low,
        high=ends[-1].high,
    )


def _first(values: Sequence[float], share: float) -> int | None:
    return next((step for step, value in enumerate(values) if value >= share - 1e-12), None)
