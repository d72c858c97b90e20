"""Finds the conditions of a study without a valid trial: all played trials ended as errors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lockprobe.studies.records.counted import Counted, played_cells
from lockprobe.studies.study import Study
from lockprobe.trial.record import TrialError


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


def invalid_conditions(study: Study, records: Iterable[Counted]) -> list[Invalid]:
    """The conditions of a study that have errors and no valid trial, in the order of the study.

    Conditions that nobody has played yet, and those of people, are left out.

    Args:
        study: The study.
        records: Of its own trials.
    """
    found = []
    for cell, trials in played_cells(study, records).items():
        errors = [(one.trial, one.trial.error) for one in trials if one.trial.error is not None]
        if len(errors) == len(trials) and not errors[0][0].player:
            first = min(errors, key=lambda one: (one[0].repetition, one[0].trial))
            invalid = Invalid(
                condition=cell,
                errors=len(errors),
                first=first[1],
                owed=sum(trial.owed_again for trial, _ in errors),
                final=tuple(sorted({error.boundary for trial, error in errors if not trial.owed_again})),
            )
            found.append(invalid)
    return found
