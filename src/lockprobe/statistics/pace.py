"""The speed of agents: how soon one solves the box beside another, and how many steps one takes over doses."""

from __future__ import annotations

import numpy as np

from lockprobe.statistics.broken_trials import bounded, completed
from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.inference.hazard import Hazard, solving
from lockprobe.statistics.inference.mean_steps import MeanSteps, mean_steps
from lockprobe.statistics.outcomes import Outcomes, with_players_of


def pace(first: AxisTrials, second: AxisTrials) -> Hazard | None:
    """How soon the second of two agents at one dose solves the box, against the first; None if one has no ended trial.

    Clusters are of the luck that they share, or of the people who met it.
    """
    one, two = first.outcomes, second.outcomes
    if not len(one) or not len(two):
        return None
    groups = with_players_of(two, one), with_players_of(one, two)
    broken = with_players_of(two, first.broken_off), with_players_of(one, second.broken_off)
    return solving(groups, broken, max(first.budget, second.budget))


def steps_over_doses(ended: Outcomes, broken: Outcomes, budget: int) -> MeanSteps:
    """The mean steps at all higher doses less those at the lowest, whatever became of broken trials.

    At one end those that broke at the lowest dose were solved in the step in which they broke and all others took their
    whole budget; at the other end the reverse.
    """
    found, broken = mean_steps(ended, budget), broken.at(np.isin(broken.dose, ended.dose))
    if found.p_value is None or not len(broken):
        return found
    lowest = broken.dose == ended.dose.min()
    return bounded(found, *(mean_steps(completed(ended, broken, soon, budget), budget) for soon in (lowest, ~lowest)))
