"""Finds the conditions of a study in which nothing was changed, although they have interventions with an effect."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lockprobe.statistics.outcomes import ended
from lockprobe.studies.records.counted import Counted, played_cells
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


def idle_conditions(study: Study, records: Iterable[Counted]) -> list[str]:
    """The names of these conditions, for example ``flips/random/nudge``, in the order of the study.

    Args:
        study: The study.
        records: Of its own trials.
    """
    acting = {one.label for one in study.conditions if not (one.does_nothing or one.plant.options)}
    return [
        cell
        for cell, found in played_cells(study, records).items()
        if found[0].trial.condition in acting and _is_idle([one.trial for one in found])
    ]


def _is_idle(trials: Sequence[Trial]) -> bool:
    """Whether trials that ended say what was changed, and nothing was."""
    over = ended(trials)
    named = {tuple(trial.changed) for trial in over}
    return len(named) == 1 and named != {()} and not any(trial.changed_steps for trial in over)
