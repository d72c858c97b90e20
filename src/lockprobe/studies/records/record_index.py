"""What a study has on record without the steps: what was played and how it ended, counted in the store.

Records that are alike but for their places are counted together. Records with what adds up over steps, as usage, are
read whole.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import NamedTuple

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.records.counted import Counted
from lockprobe.studies.records.read_records import LeftOut, RecordFilter
from lockprobe.studies.records.trial_rows import trial_in, unpacked
from lockprobe.studies.study import Study
from lockprobe.trial.trial_name import TrialName
from lockprobe.trial.trial_reader import TrialReader


class _Place(NamedTuple):
    """What the store says of a record of where it belongs; its fields are columns."""

    key: str
    agent: str
    condition: str
    repetition: int
    trial: int
    identity: str


_PLACE = ", ".join(_Place._fields)

_ALIKE = (
    f"select min(id), count(*), sum(steps), {_PLACE} from trial left join asked on agent = asking where current"  # noqa: S608
    " group by coalesce(alike, id), identity, repetition <= ? and trial <= most order by 1"
)
"""Records that are alike and all within the size of the study, or all beyond it."""


class RecordIndex:
    """The records of a store that count, of each trial the last one.

    Args:
        store: The store.
        study: The study.

    Attributes:
        left_out: The records that are not of its settings, or were replaced.

    Raises:
        BadFile: If a record is damaged, here and below.
    """

    def __init__(self, store: Database, study: Study) -> None:
        self._store, self._study = store, study
        self._identities = {one.label: study.record_identity(one) for one in study.conditions}
        self._trials = {one: study.trials_of(one) for one in study.agents}
        self._played = {(one, condition.label) for one in study.agents for condition in study.conditions_of(one)}
        self._found, self.left_out = self._count()

    def owes(self, key: str) -> bool:
        """Whether a trial is not finished: not on record, or broken by something outside the agent."""
        return not self._store.one("select count(*) from trial where current and not owed and key = ?", key)[0]

    def counted(self, *, own: bool = True) -> list[Counted]:
        """The records of trials that the study asks for (:meth:`Study.asks_for`), or all with its settings."""
        return [one for is_own, one in self._found if is_own or not own]

    def digest(self) -> str:
        """:func:`lockprobe.studies.records.results_hash.records_digest` of the trials that the study asks for."""
        found = hashlib.sha256()
        for record in self.records():
            found.update(record + b"\n")
        return found.hexdigest()

    def records(self) -> Iterator[bytes]:
        """The records of the trials that the study asks for as JSON, in the order of their keys."""
        for *place, record in self._store.rows(f"select {_PLACE}, record from trial where current order by key"):  # noqa: S608
            if self._is_own(_Place(*place)):
                yield unpacked(self._store, place[0], record)

    def _is_own(self, one: _Place) -> bool:
        asked = self._trials[one.agent] if (one.agent, one.condition) in self._played else 0
        return (
            one.trial <= asked
            and one.repetition <= self._study.repetitions
            and one.identity == self._identities[one.condition]
            and one.key == str(TrialName(self._study.name, self._study.label_of(one.agent), *one[2:5]))
        )

    def _count(self) -> tuple[list[tuple[bool, Counted]], LeftOut]:
        """The records of the settings, each with whether the study asks for it; and the others."""
        asked = self._trials or {"": 0}
        values = ", ".join("(?, ?)" for _ in asked)
        rows = self._store.rows(
            f"with asked (asking, most) as (values {values}) {_ALIKE}",
            *(value for pair in asked.items() for value in pair),
            self._study.repetitions,
        )
        own, reader, found, foreign, first = RecordFilter(self._study), TrialReader(), [], 0, ""
        for number, many, steps, *place in rows:
            (record,) = self._store.one("select record from trial where id = ?", number)
            trial, where = trial_in(self._store, reader, place[0], record), _Place(*place)
            if why := own.why_foreign(trial, where.identity):
                foreign, first = foreign + many, first or f"{trial.key}: {why}"
            else:
                found.append((self._is_own(where), Counted(trial, many, steps)))
        (replaced,) = self._store.one("select count(*) from trial where owed and not current")
        return found, LeftOut(replaced=replaced, foreign=foreign, first_foreign=first)
