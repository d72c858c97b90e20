"""Reads the records of a study (``study.db``) and leaves out those of other studies.

Records of another study, as after a change of ``study.json`` by hand, are counted and reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.store import read
from lockprobe.studies.records.trial_rows import trial_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_reader import TrialReader


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """Counts of the records that are not trials of the study.

    Attributes:
        replaced: Records of trials that were played again after an error.
        foreign: Records of another study.
        first_foreign: The first of them: its key and the setting that differs; empty without one.
    """

    replaced: int
    foreign: int = 0
    first_foreign: str = ""


def load(directory: Path | str) -> list[Trial]:
    """Load the trials of a study directory, in the order in which they were finished.

    Where a trial was played again after an error, the last record counts. Records of another study are left out.

    Raises:
        BadFile: If there is no store, or a record is damaged.
    """
    return read_records(directory)[0]


def left_out(directory: Path | str) -> LeftOut:
    """Count the records of a study directory that :func:`load` leaves out."""
    return read_records(directory)[1]


def read_records(directory: Path | str, study: Study | None = None) -> tuple[list[Trial], LeftOut]:
    """:func:`load` and :func:`left_out` in one pass. ``study`` is that of the directory, if already read."""
    if study is None and (Path(directory) / SETTINGS).exists():
        study = read_study(directory)
    with read(directory) as store:
        return read_stored(store, study)


def read_stored(store: Database, study: Study | None) -> tuple[list[Trial], LeftOut]:
    """:func:`read_records` of an open store; without a study all records are read."""
    own, trials, reader, foreign, first = study and RecordFilter(study), list[Trial](), TrialReader(), 0, ""
    for key, identity, record in store.rows("select key, identity, record from trial where current order by id"):
        trial = trial_in(store, reader, key, record)
        if own and (why := own.why_foreign(trial, identity)):
            foreign, first = foreign + 1, first or f"{key}: {why}"
        else:
            trials.append(trial)
    (replaced,) = store.one("select count(*) from trial where owed and not current")
    return trials, LeftOut(replaced=replaced, foreign=foreign, first_foreign=first)


class RecordFilter:
    """A filter that separates the records of one study from foreign records."""

    def __init__(self, study: Study) -> None:
        self._study = study
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}

    def why_foreign(self, trial: Trial, identity: str) -> str:
        """The difference between a record and this study; empty if the record belongs to it."""
        study = self._study
        own = self._identities.get(trial.condition)
        if identity == own and trial.study == study.name:
            here = study.label_of(trial.spec) if trial.spec in study.agents else trial.group
            return "" if here == trial.group else f"its agent {trial.group} is called {here} here"
        values = {
            "study": study.name,
            "box": study.box_of(trial.trial).name,
            "seed": study.seed,
            "budget": study.max_steps,
        }
        different = [
            f"{name} is {getattr(trial, name)!r}, not {value!r}"
            for name, value in (values | {"assessment": study.assessment, "hypothesis": study.hypothesis}).items()
            if getattr(trial, name) != value
        ]
        if different:
            return "; ".join(different)
        if renamed := [label for label, known in self._identities.items() if known == identity]:
            return f"its condition {trial.condition} is called {renamed[0]} here"
        if own is None:
            return f"its condition is {trial.condition}, which this study does not have"
        return f"{trial.condition} did something else there: it is {identity}, not {own}"
