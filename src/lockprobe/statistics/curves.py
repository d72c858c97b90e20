"""Cumulative success by step (one minus Kaplan-Meier), against chance and the optimum (paper, Fig. 3).

A trial that runs out of budget is *censored*. With equal budgets the curve is the plain share solved. A trial that
broke in a step was not solved before it, and may have been solved in it or never: the curve has bounds and is their
middle. One minus Kaplan-Meier would be no estimate there, because long trials break.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.statistics.broken_trials import completed
from lockprobe.statistics.clustered import crossed_proportion
from lockprobe.statistics.loops.incidence import Area, Incidence, incidence
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessCurve:
    """Cumulative success by step (paper, Fig. 3).

    Attributes:
        n: Trials: all that were begun, or none if none ended.
        solved_at: Steps of the solved trials, ascending.
        share: Share solved by step 0, 1, ... up to the largest budget, [0, 1]; the middle of the bounds where trials
            broke.
        low, high: Ends of the pointwise 95 % band of :class:`Incidence`, which holds whatever became of broken trials.
        area: Mean share solved over steps 1 to the largest budget; None without a trial.
    """

    n: int
    solved_at: tuple[int, ...]
    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    area: Area | None

    @property
    def steps(self) -> tuple[int, ...]:
        """0 to the budget."""
        return tuple(range(len(self.share)))

    def steps_to(self, share: float = 0.8) -> int | None:
        """The first step by which at least this share of the trials is solved; None if none is."""
        return _first(self.share, share)

    def steps_to_interval(self, share: float = 0.8) -> tuple[int | None, int | None]:
        """The 95 % interval of :meth:`steps_to`, from the ends of the band; None means beyond the budget."""
        return _first(self.high, share), _first(self.low, share)

    @property
    def km_median(self) -> int | None:
        """Kaplan-Meier median of the steps over *all* trials; None if fewer than half are solved."""
        return self.steps_to(0.5)

    @property
    def restricted_mean_steps(self) -> float | None:
        """Restricted mean steps over *all* trials, unsolved ones counted with the whole budget; None without trials."""
        return sum(1 - share for share in self.share[:-1]) if self.n else None

    @property
    def median_steps(self) -> float | None:
        """Median steps of solved trials; None if none is. Failures lower it, so compare :attr:`km_median` instead."""
        return float(median(self.solved_at)) if self.solved_at else None

    @property
    def mean_steps(self) -> float | None:
        """Mean steps of solved trials; None if none is. It misleads as :attr:`median_steps` does."""
        return sum(self.solved_at) / len(self.solved_at) if self.solved_at else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Relative:
    """An agent between chance and the optimum on the same box.

    Attributes:
        value: Area of its curve, scaled: 0 for a uniformly random agent, 1 for the shortest plan, negative if worse
            than random. An agent that has to find out the interlock cannot reach 1.
        low, high: Ends of the 95 % interval.
        steps: Mean steps; an unsolved trial counts with the whole budget.
        random_steps: Mean steps of the random agent, exact.
        optimal_steps: Steps of the shortest plan.
    """

    value: float
    low: float
    high: float
    steps: float
    random_steps: float
    optimal_steps: int


def success_curve(trials: Sequence[Trial]) -> SuccessCurve:
    """Cumulative success by step over the trials of one condition, with a band clustered by player."""
    counted, broken = outcomes(trials), broken_off(trials)
    budget = max((trial.budget for trial in trials), default=0)
    if len(counted) and len(broken):
        ends = [_incidence(completed(counted, broken, soon, budget), budget) for soon in (False, True)]
    else:
        ends = [_incidence(counted, budget)]
    share, area = (np.array([one.share for one in ends]).mean(axis=0), [one.area for one in ends if one.area])
    return SuccessCurve(
        n=len(counted) and len(trials),
        solved_at=tuple(sorted(counted.length[counted.solved].tolist())),
        share=tuple(share.tolist()),
        low=ends[0].low,
        high=ends[-1].high,
        area=replace(area[0], value=sum(one.value for one in area) / len(area), high=area[-1].high) if area else None,
    )


def _incidence(columns: Outcomes, budget: int) -> Incidence:
    effect = 1.0
    if columns.crossed:  # else all trials are independent
        ones = np.ones(len(columns))
        effect = crossed_proportion(columns.solved, ones, columns.player, columns.luck).design_effect
    return incidence(columns.length, columns.solved, budget, effect)


def _first(values: Sequence[float], share: float) -> int | None:
    return next((step for step, value in enumerate(values) if value >= share - 1e-12), None)


def relative(curve: SuccessCurve, random: Sequence[float], optimum: int | None) -> Relative | None:
    """An agent's success curve on a scale from a uniformly random agent to the shortest plan on the same box.

    Args:
        curve: The agent's curve.
        random: The exact curve of a random agent (:func:`lockprobe.boxes.solve.random_curve`) to the same budget.
        optimum: The fewest steps that solve the box (:func:`lockprobe.boxes.solve.optimum`).

    Returns:
        None without a trial, or if a random agent is as fast as the optimum within the budget.
    """
    budget = len(curve.share) - 1
    if len(random) != len(curve.share):
        raise BadValue("random agent's curve", f"{len(random) - 1} steps", f"the budget of the trials, {budget} steps")
    chance = sum(random[1:]) / budget if budget else 0.0
    room = 0.0 if optimum is None else (budget - optimum + 1) / max(budget, 1) - chance
    mean_steps = curve.restricted_mean_steps
    if curve.area is None or mean_steps is None or optimum is None or room <= 0:
        return None
    return Relative(
        value=(curve.area.value - chance) / room,
        low=(curve.area.low - chance) / room,
        high=(curve.area.high - chance) / room,
        steps=mean_steps,
        random_steps=sum(1 - share for share in random[:-1]),
        optimal_steps=optimum,
    )
