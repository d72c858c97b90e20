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
from lockprobe.studies.records.trial_rows import OnRecord, trial_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_name import TrialName
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
    return trials, LeftOut(replaced=_replaced(store), foreign=foreign, first_foreign=first)


def on_record(store: Database, study: Study) -> tuple[dict[str, OnRecord], LeftOut]:
    """The trials of :func:`read_stored` by key, without reading their records.

    Only a record that need not be of this study is read; all others are damaged or not, as who reads them finds.
    """
    own, reader, same = RecordFilter(study), TrialReader(), dict[str, str]()
    found, foreign, first = dict[str, OnRecord](), 0, ""
    columns = "key, agent, player, condition, repetition, trial, ending, owed, steps, identity, id"
    for key, agent, player, condition, repetition, number, ending, owed, steps, identity, row in store.rows(
        f"select {columns} from trial where current order by id"  # noqa: S608 - our own columns
    ):
        agent, condition, ending = (same.setdefault(one, one) for one in (agent, condition, ending))  # noqa: PLW2901
        group = own.group_of(key, agent, condition, repetition, number, identity)
        if group is None:
            trial = trial_in(store, reader, *store.one("select key, record from trial where id = ?", row))
            if why := own.why_foreign(trial, identity):
                foreign, first = foreign + 1, first or f"{key}: {why}"
                continue
            group = same.setdefault(trial.group, trial.group)
        place = condition, repetition, number
        found[key] = OnRecord(key, agent, group, player, *place, ending, bool(owed), steps)
    return found, LeftOut(replaced=_replaced(store), foreign=foreign, first_foreign=first)


def _replaced(store: Database) -> int:
    return int(store.one("select count(*) from trial where owed and not current")[0])


class RecordFilter:
    """A filter that separates the records of one study from foreign records."""

    def __init__(self, study: Study) -> None:
        self._study = study
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}
        self._groups = {agent: study.label_of(agent) for agent in study.agents}

    def group_of(self, key: str, agent: str, condition: str, repetition: int, trial: int, identity: str) -> str | None:
        """What the study calls the agent of a row; None if the record need not be of the study by these columns."""
        group = self._groups.get(agent)
        if group is None or identity != self._identities.get(condition):
            return None
        name = str(TrialName(self._study.name, group, condition, repetition, trial))
        return group if key == name or key.startswith(f"{name}/") else None  # a fork has the name of its trial first

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
