"""A study directory read once: its settings, its trials and what its participants did, as one value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

from lockprobe.people.progress import Flow, flow_of
from lockprobe.people.step_times import times_of_steps
from lockprobe.record import Trial
from lockprobe.studies.branch import read_forks
from lockprobe.studies.directory import SETTINGS, read_settings
from lockprobe.studies.next_choice import read_choices
from lockprobe.studies.records import LeftOut, read_records
from lockprobe.studies.settings import study_from
from lockprobe.studies.study import Study

__all__ = ["OpenedStudy", "open_study"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenedStudy:
    """What a study directory holds. Everything else in a report is computed from it.

    Attributes:
        settings: As in ``study.json``.
        study: The same as a study.
        trials: Those that the settings ask for, by agent in the order of the settings, then by condition.
        journal: What the journal leaves out.
        foreign: Number of trials on record that the settings do not ask for; they are in no other number.
        flow: How many participants finished a study of flips; None if there are none.
        times: Response time of each choice of a participant, ms, by key of the trial and step from 1.
        forks: Forks of these trials on record (``lockprobe branch``).
        choices: Key of a fork -> probability of each joint at its first choice, where that is known.
    """

    settings: Mapping[str, Any]
    study: Study
    trials: tuple[Trial, ...]
    journal: LeftOut
    foreign: int
    flow: Flow | None
    times: Mapping[tuple[str, int], float]
    forks: tuple[Trial, ...] = ()
    choices: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def finished(self) -> int:
        """Trials that are not owed (any more)."""
        return sum(not trial.owed_again for trial in self.trials)


def open_study(directory: Path) -> OpenedStudy:
    """Read a study directory.

    Raises:
        BadFile: If it is not that of a study, or a record or a participant's diary is damaged.
    """
    settings = read_settings(directory)
    everything, left_out = read_records(directory, settings)
    study = study_from(settings, directory / SETTINGS)
    trials = sorted((trial for trial in everything if study.asks_for(trial)), key=_place(study))
    return OpenedStudy(
        settings=settings,
        study=study,
        trials=tuple(trials),
        journal=left_out,
        foreign=len(everything) - len(trials),
        flow=flow_of(directory) if study.of_flips else None,
        times=times_of_steps(directory, trials) if study.of_flips else {},
        forks=tuple(read_forks(directory)),
        choices=read_choices(directory),
    )


def _place(study: Study) -> Callable[[Trial], tuple[Any, ...]]:
    """The sort key of a study's trials; flip rates ascend, other conditions keep their order."""
    if study.of_flips:
        cells = {cell: i for i, cell in enumerate(product(study.agents, study.modalities))}
        return lambda t: (cells[t.group, t.modality], t.p, t.repetition, t.trial)
    names = [condition.label for condition in study.conditions]
    return lambda t: (study.agents.index(t.group), names.index(t.condition), t.repetition, t.trial)
