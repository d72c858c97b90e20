"""Reads the records of a study (``study.db``), all of which are of the study in ``study.json``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.store import read
from lockprobe.studies.records.trial_rows import OnRecord, trial_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial, TrialName
from lockprobe.trial.trial_json import TrialReader


def load(directory: Path | str, study: Study | None = None) -> list[Trial]:
    """Load the trials of a study directory, in the order in which they were finished.

    Where a trial was played again after an error, the last record counts. ``study`` is that of the directory, if it was
    read already.

    Raises:
        BadFile: If there is no study, or a record is damaged or of another study.
    """
    study = study or read_study(directory)
    with read(directory) as store:
        own, reader, trials = Own(store, study), TrialReader(), list[Trial]()
        for key, identity, record in store.rows("select key, identity, record from trial where current order by id"):
            trial = trial_in(store, reader, key, record)
            own.check(key, trial.spec, trial.condition, trial.repetition, trial.trial, identity)
            trials.append(trial)
    return trials


def on_record(store: Database, study: Study) -> dict[str, OnRecord]:
    """The trials of :func:`load` by key, from their rows alone: whether a record is damaged, who reads it finds."""
    own, same, found = Own(store, study), dict[str, str](), dict[str, OnRecord]()
    columns = "key, agent, player, condition, repetition, trial, ending, owed, steps, identity"
    for key, agent, player, condition, repetition, number, ending, owed, steps, identity in store.rows(
        f"select {columns} from trial where current order by id"  # noqa: S608 - our own columns
    ):
        agent, condition, ending = (same.setdefault(one, one) for one in (agent, condition, ending))  # noqa: PLW2901
        group = own.check(key, agent, condition, repetition, number, identity)
        place = condition, repetition, number
        found[key] = OnRecord(key, agent, group, player, *place, ending, bool(owed), steps)
    return found


class Own:
    """Refuses records that are not of a study: somebody has changed its settings by hand, or put another store there.

    Records of trials that were played under one name and one seed can differ in what acted in them, so that none of
    them is left out or taken for another one.
    """

    def __init__(self, store: Database, study: Study) -> None:
        self._path, self._study = store.path, study
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}
        self._most = {agent: study.trials_of(agent) for agent in study.agents}

    def check(self, key: str, agent: str, condition: str, repetition: int, trial: int, identity: str) -> str:
        """Refuse what is known of a record, or return what the study calls its agent."""
        study, group = self._study, self._study.label_of(agent)
        name = str(TrialName(study.name, group, condition, repetition, trial))
        if (
            identity != self._identities.get(condition)
            or not 1 <= trial <= self._most.get(agent, 0)
            or not 1 <= repetition <= study.repetitions
            or not (key == name or key.startswith(f"{name}/"))  # a fork has the name of its trial first
        ):
            why = f"holds {key}, which is no trial of the study in {SETTINGS}: put back the one that belongs to it"
            raise BadFile(self._path, why)
        return group


@dataclass(frozen=True, slots=True)
class Counted:
    """Records that are alike but for their places: one of them, how many there are, and the steps of all of them."""

    trial: Trial
    number: int
    steps: int


def count_records(store: Database, study: Study) -> list[Counted]:
    """The records of a study that count, of each trial the last one.

    Those that are alike but for their places are counted together in the store, without their steps. Those with what
    adds up over steps, as usage, are read whole.
    """
    own, reader, found = Own(store, study), TrialReader(), list[Counted]()
    select = (
        "select min(id), identity, count(*), sum(steps) from trial "
        "where current and fork is null and alike is {} group by {}"
    )
    groups = [
        *store.rows(select.format("not null", "alike, identity")),
        *store.rows(select.format("null", "id")),
    ]
    for number, identity, many, steps in sorted(groups):
        trial = trial_in(store, reader, *store.one("select key, record from trial where id = ?", number))
        own.check(trial.key, trial.spec, trial.condition, trial.repetition, trial.trial, identity)
        found.append(Counted(trial, many, steps))
    return found
