"""Finds the conditions of a study in which nothing was changed, although they have interventions with an effect."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.idle import steps_changed
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

__all__ = ["idle_conditions"]


def idle_conditions(study: Study, trials: Mapping[str, Trial]) -> list[str]:
    """The names of these conditions, for example ``flips/random/nudge``, in the order of the study."""
    every = (plan for agent in study.agents for plan in study.plans(agent))
    plans = (plan for plan in every if not (plan.condition.does_nothing or plan.condition.plant.options))
    played = grouped((trials[plan.key] for plan in plans if plan.key in trials), lambda trial: trial.name.cell)
    found = {cell: steps_changed(members) for cell, members in played.items()}
    return [cell for cell, steps in found.items() if steps and steps.known and not steps.changed]
