"""Finds the conditions of a study without a valid trial: all played trials ended as errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from lockprobe.foundation.grouping import grouped
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial, TrialError

__all__ = ["Invalid", "invalid_conditions"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Invalid:
    """A condition without a valid trial.

    Attributes:
        condition: Its name, for example ``flips/random/flip?p=0.4``.
        errors: Trials of it that ended as an error, 1 or more.
        first: The error of the first of them.
        owed: How many of them are owed again.
        final: The boundaries at which the others ended.
    """

    condition: str
    errors: int
    first: TrialError
    owed: int
    final: tuple[str, ...]


def invalid_conditions(study: Study, trials: Mapping[str, Trial]) -> list[Invalid]:
    """The conditions of a study that have errors and no valid trial, in the order of the study.

    Conditions that nobody has played yet, and those of people, are left out.
    """
    plans = (plan for agent in study.run_agents for plan in study.plans(agent))
    played = grouped((trials[plan.key] for plan in plans if plan.key in trials), lambda trial: trial.name.cell)
    return [
        Invalid(
            condition=condition,
            errors=len(found),
            first=next(trial.error for trial in found if trial.error is not None),
            owed=sum(trial.owed_again for trial in found),
            final=tuple(sorted({trial.error.boundary for trial in found if trial.error and not trial.owed_again})),
        )
        for condition, found in played.items()
        if all(trial.ending == "error" for trial in found)
    ]
