"""A study directory read once: its settings, its trials and what its participants did, as one value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os.path import lexists
from pathlib import Path
from typing import TYPE_CHECKING

from lockprobe.report.rows import EveryLook, Row
from lockprobe.statistics.outcomes import NO_ORDERS, BlockOrder
from lockprobe.studies.branch import read_forks
from lockprobe.studies.decisions import block_orders, broken_by_agent, counted
from lockprobe.studies.file_names import PEOPLE_DIRECTORY
from lockprobe.studies.next_choice import read_choices
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import has_joined
from lockprobe.studies.records.trial_rows import replaced_records
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial

if TYPE_CHECKING:
    from lockprobe.people.diary import Diary


@dataclass(frozen=True, kw_only=True)
class OpenedStudy:
    """What a study directory holds. Everything else in a report is computed from it.

    Attributes:
        directory: The directory, for messages.
        study: The same as a study.
        trials: All, by agent in the order of the settings, then by condition.
        replaced: Number of records of trials that were played again after an error.
        diaries: What participants did, in the order in which they joined.
        withdrawn: Number of participants who withdrew.
        forks: Forks of these trials on record (``lockprobe branch``).
        choices: Key of a fork -> probability of each joint at its first choice, where that is known.
        measured: What installed packages measure, if it is given instead of measured; None otherwise.
    """

    directory: Path
    study: Study
    trials: tuple[Trial, ...]
    replaced: int
    diaries: tuple[Diary, ...]
    withdrawn: int
    forks: tuple[Trial, ...] = ()
    choices: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    measured: Sequence[Row] | None = None

    @cached_property
    def every_look(self) -> EveryLook:
        """Why what is said of its trials must hold at every look; empty if all of a fixed number are played."""
        if self.study.until is not None:
            return "until"
        if self.study.earlier:
            return "extended"
        run = self.finished - self.finished_by_people + sum(self.broken.values())
        return "unfinished" if run < self.study.size - self.study.invited else ""

    @cached_property
    def analysed(self) -> tuple[Trial, ...]:
        """Those that numbers are of: without those behind an open block if the study is judged at every look."""
        return tuple(counted(self.study, self.trials)) if self.every_look else self.trials

    @property
    def orders(self) -> Mapping[str, BlockOrder]:
        """Agent -> the order of its blocks, if what is said must hold at every look; empty if at one alone."""
        return block_orders(self.study) if self.every_look else NO_ORDERS

    @property
    def flip_trials(self) -> tuple[Trial, ...]:
        """Those of its trials that are analysed under flip rates alone, the truth among them."""
        rates = self.study.flip_labels
        return tuple(trial for trial in self.analysed if trial.condition in rates)

    @property
    def finished(self) -> int:
        """Places of the plan whose trial is not owed (any more); two people who played the same place fill one."""
        return self.study.places_filled(self.trials)

    @property
    def broken(self) -> Mapping[str, int]:
        """Agent -> its trials that broke and keep nothing open; :func:`lockprobe.studies.decisions.broken_by_agent`."""
        return broken_by_agent(self.study, self.trials)

    @property
    def finished_by_people(self) -> int:
        """Of these, places of people."""
        return self.study.places_filled([trial for trial in self.trials if trial.player])


def open_study(directory: Path) -> OpenedStudy:
    """Read a study directory.

    Raises:
        BadFile: If it is not that of a study, or a record or a participant's diary is damaged.
    """
    diaries, gone = list["Diary"](), 0
    if lexists(directory / PEOPLE_DIRECTORY) or has_joined(directory):
        from lockprobe.people.diary import read_diaries  # with every act of a person, which few studies have
        from lockprobe.people.withdrawal import withdrawn

        diaries, gone = read_diaries(directory), withdrawn(directory)
    study = read_study(directory)
    forks, choices = read_forks(directory), read_choices(directory)
    trials = sorted(load(directory, study), key=study.place_of)
    return OpenedStudy(
        directory=directory,
        study=study,
        trials=tuple(trials),
        replaced=len(replaced_records(directory)),
        diaries=tuple(diaries),
        withdrawn=gone,
        forks=tuple(forks),
        choices=choices,
    )
