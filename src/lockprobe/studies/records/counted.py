"""Records that are counted together, because they are alike but for their places."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lockprobe.foundation.grouping import grouped
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True)
class Counted:
    """Records that are alike but for their places.

    Attributes:
        trial: One of them; without its steps and its own place if it stands for several.
        number: How many there are.
        steps: The steps of all of them.
    """

    trial: Trial
    number: int
    steps: int


def counted(trials: Iterable[Trial]) -> list[Counted]:
    """Each of the trials by itself."""
    return [Counted(trial, 1, len(trial.steps)) for trial in trials]


def played_cells(study: Study, records: Iterable[Counted]) -> dict[str, list[Counted]]:
    """The records of each agent under each condition, by the first three parts of their keys, in the study's order."""
    found = grouped(records, lambda one: (one.trial.spec, one.trial.condition))
    order = [(agent, one.label) for agent in study.agents for one in study.conditions]
    return {found[cell][0].trial.name.cell: found[cell] for cell in order if cell in found}
