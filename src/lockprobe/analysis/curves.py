"""How many trials were solved, and when: proportions, cumulative success by step, and differences (paper, Fig. 3).

Trials that ended as ``error`` are in no count; they are counted apart.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from lockprobe.analysis.outcomes import ended
from lockprobe.analysis.proportions import proportion
from lockprobe.record import Trial

__all__ = ["SuccessCurve", "success_curve"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessCurve:
    """Cumulative success by step (paper, Fig. 3).

    Attributes:
        n: Trials that ended as solved or out of budget.
        errors: Trials that ended as error; in none of the shares.
        solved_at: Steps of the solved trials, ascending.
        share: Share solved by step 0, 1, ... up to the budget, [0, 1].
        low: Lower end of the pointwise 95 % Wilson band.
        high: Upper end.
    """

    n: int
    errors: int
    solved_at: tuple[int, ...]
    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    @property
    def steps(self) -> tuple[int, ...]:
        """0 to the budget."""
        return tuple(range(len(self.share)))

    def steps_to(self, share: float = 0.8) -> int | None:
        """The first step by which at least this share of the trials is solved; None if that never happens."""
        return next((step for step, value in enumerate(self.share) if value >= share - 1e-12), None)

    @property
    def median_steps(self) -> float | None:
        """Median steps of the trials that were solved; None if none was."""
        return float(median(self.solved_at)) if self.solved_at else None

    @property
    def mean_steps(self) -> float | None:
        """Mean steps of the trials that were solved; None if none was."""
        return sum(self.solved_at) / len(self.solved_at) if self.solved_at else None


def success_curve(trials: Sequence[Trial]) -> SuccessCurve:
    """Cumulative success by step over the trials of one condition."""
    counted = ended(trials)
    budget = max((trial.budget for trial in trials), default=0)
    solved_at = tuple(sorted(len(trial.steps) for trial in counted if trial.solved))
    by_step = [proportion(bisect_right(solved_at, step), len(counted)) for step in range(budget + 1)]
    return SuccessCurve(
        n=len(counted),
        errors=len(trials) - len(counted),
        solved_at=solved_at,
        share=tuple(point.value for point in by_step),
        low=tuple(point.low for point in by_step),
        high=tuple(point.high for point in by_step),
    )
