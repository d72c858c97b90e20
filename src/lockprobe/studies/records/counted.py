"""Records of a study, counted.

Records that are alike but for their places are counted together in the store, without their steps. Those with what adds
up over steps, as usage, are read whole.
"""

from __future__ import annotations

from dataclasses import dataclass

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.records.read_records import Own
from lockprobe.studies.records.trial_rows import trial_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_reader import TrialReader


@dataclass(frozen=True, slots=True)
class Counted:
    """Records that are alike but for their places.

    Attributes:
        trial: One of them.
        number: How many there are.
        steps: The steps of all of them.
    """

    trial: Trial
    number: int
    steps: int


def count_records(store: Database, study: Study) -> list[Counted]:
    """The records of a study that count, of each trial the last one.

    Raises:
        BadFile: If one that is read is damaged or of another study.
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
