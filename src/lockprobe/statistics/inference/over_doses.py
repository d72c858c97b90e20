"""The tests of the report on one agent over doses. Each holds whatever became of broken trials; `power` calls the same.

The paper concludes from a peak picked by eye, an order picked by AIC and a correlation. Each question has one test here
that keeps its error rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from lockprobe.statistics.broken_trials import bounded, completed, worst
from lockprobe.statistics.inference.difference import DifferenceAt, any_difference, whatever_broke
from lockprobe.statistics.inference.log_rank import looping
from lockprobe.statistics.inference.mean_steps import mean_steps
from lockprobe.statistics.inference.ushape import TwoLines, onset_lines, two_lines
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import Difference

Question = Literal["success", "speed", "shape", "looping", "looping again"]

TESTS: Mapping[Question, str] = {
    "success": "greatest difference from the lowest dose, permutation",
    "speed": "mean steps, Student over blocks",
    "shape": "two lines",
    "looping": "loop onset, log-rank",
    "looping again": "loop onset, two lines",
}
"""Question -> its test: whether doses change success, how many steps a trial takes, how soon it loops; whether success
rises and falls again, and whether loops come later and sooner again."""


def possible_ends(counted: Outcomes, broken: Outcomes, budget: int, *, shape: bool = False) -> list[Outcomes]:
    """What the trials of one agent can have become at most if some broke; empty if none did at a dose that counts.

    Those at the lowest dose were solved (and looped) in the step in which they broke and those at every other never,
    and the reverse. A shape must hold in two more cases: those at the lowest and the highest dose against all others.
    """
    broken = broken.at(np.isin(broken.dose, counted.dose))
    if not len(broken):
        return []
    lowest = broken.dose == counted.dose.min()
    sides = [lowest, lowest | (broken.dose == counted.dose.max())] if shape else [lowest]
    return [completed(counted, broken, soon, budget) for side in sides for soon in (side, ~side)]


def success_by_dose(
    counted: Outcomes, broken: Outcomes, rng: np.random.Generator, budget: int, *, agents: int = 1
) -> tuple[DifferenceAt, ...]:
    """Success at every dose against that at the lowest; ``agents`` are judged together."""
    found = any_difference(counted, rng, agents=agents)
    ends = [any_difference(end, rng, agents=agents) for end in possible_ends(counted, broken, budget)]
    return whatever_broke(found, *ends) if ends else found


def steps_over_doses(counted: Outcomes, broken: Outcomes, budget: int) -> Difference:
    """The mean steps at all higher doses less those at the lowest."""
    found, ends = mean_steps(counted, budget), possible_ends(counted, broken, budget)
    return bounded(found, *(mean_steps(end, budget) for end in ends)) if found.p_value is not None and ends else found


def rise_and_fall(counted: Outcomes, broken: Outcomes, budget: int, *, agents: int = 1) -> TwoLines:
    """The two-lines test of success, corrected for agents (Bonferroni); none at every look, since it holds for one."""

    def tested(some: Outcomes) -> TwoLines:
        found = two_lines(some.dose, some.solved, some.cluster if some.crossed else None)
        return found if found.p_value is None else replace(found, p_value=min(1.0, agents * found.p_value))

    if counted.order is not None:
        return TwoLines()
    return worst(tested(counted), [tested(end) for end in possible_ends(counted, broken, budget, shape=True)])


def later_and_sooner(counted: Outcomes, broken: Outcomes, budget: int) -> TwoLines:
    """The two-lines test of first loops, which come later and then sooner again, or the reverse."""
    return worst(onset_lines(counted), [onset_lines(end) for end in possible_ends(counted, broken, budget, shape=True)])


def p_values(counted: Outcomes, rng: np.random.Generator, budget: int) -> dict[Question, float | None]:
    """The P value of each question, of an agent alone whose trials all ended; None where there is no test."""

    def turning(found: TwoLines, first: int) -> float | None:
        """The P value of a change of direction whose first line rises (1) or falls (-1)."""
        turns = found.first is not None and first * found.first.z > 0
        return None if found.p_value is None else found.p_value if turns else 1.0

    none, onset = counted.at(np.zeros(len(counted), dtype=np.bool_)), looping(counted)
    return {
        "success": min((one.p_value for one in success_by_dose(counted, none, rng, budget)), default=None),
        "speed": mean_steps(counted, budget).p_value,
        "shape": turning(rise_and_fall(counted, none, budget), 1),
        "looping": onset.p_value if onset else None,
        "looping again": turning(onset_lines(counted), -1),
    }
