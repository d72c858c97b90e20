"""What a study has on record without the steps: what was played and how it ended, counted in the store.

Records that are alike but for their places are counted together. Records with what adds up over steps, as usage, are
read whole.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator

from lockprobe.foundation.storage.database import Database
from lockprobe.studies.records.counted import Counted
from lockprobe.studies.records.read_records import LeftOut, RecordFilter
from lockprobe.studies.records.trial_rows import trial_in, unpacked
from lockprobe.studies.study import Study
from lockprobe.trial.trial_reader import TrialReader

_GROUPS = """
select min(id), identity, count(*), sum(steps), total(seconds), total(own), total(iif(own, steps, 0))
from (
  select *, repetition <= ? and trial <= most as own
  from trial left join (
    select json_extract(value, '$[0]') as asking, json_extract(value, '$[1]') as most from json_each(?)
  ) on agent = asking
  where current and alike is {}
) group by {}
"""
"""Records that are alike, or each of the others: how many, and how many within the size of the study."""


class RecordIndex:
    """The records of a store that count, of each trial the last one.

    Args:
        store: The store.
        study: The study.

    Attributes:
        left_out: The records that are not of its settings, or were replaced.
        steps, seconds: Of all playing, that of trials that were played again too.

    Raises:
        BadFile: If a record is damaged, here and below.
    """

    def __init__(self, store: Database, study: Study) -> None:
        self._store, self._study = store, study
        self._trials = {one: study.trials_of(one) for one in study.agents}
        self._played = {(one, condition.label) for one in study.agents for condition in study.conditions_of(one)}
        self._own, self._all, foreign, first = list[Counted](), list[Counted](), 0, ""
        replaced, self.steps, self.seconds = store.one(
            "select total(owed), total(steps), total(seconds) from trial where not current"
        )
        reader, own = TrialReader(), RecordFilter(study)
        self._filter = own
        asked = study.repetitions, json.dumps([*self._trials.items()])
        together = store.rows(_GROUPS.format("not null", "alike, identity"), *asked)
        alone = store.rows(_GROUPS.format("null", "id"), *asked)
        for number, identity, many, steps, seconds, own_many, own_steps in sorted((*together, *alone)):
            self.steps, self.seconds = self.steps + steps, self.seconds + seconds
            trial = trial_in(store, reader, *store.one("select key, record from trial where id = ?", number))
            if why := own.why_foreign(trial, identity):
                foreign, first = foreign + many, first or f"{trial.key}: {why}"
                continue
            self._all.append(Counted(trial, many, steps))
            if own_many and trial.fork is None and (trial.spec, trial.condition) in self._played:
                self._own.append(Counted(trial, int(own_many), int(own_steps)))
        self.left_out = LeftOut(replaced=int(replaced), foreign=foreign, first_foreign=first)

    def owes(self, key: str) -> bool:
        """Whether a trial is not finished: not on record, or broken by something outside the agent."""
        return not self._store.one("select count(*) from trial where current and not owed and key = ?", key)[0]

    def counted(self, *, own: bool = True) -> list[Counted]:
        """The records of trials that the study asks for (:meth:`Study.asks_for`), or all with its settings."""
        return self._own if own else self._all

    def digest(self) -> str:
        """:func:`lockprobe.studies.records.results_hash.records_digest` of the trials that the study asks for."""
        found = hashlib.sha256()
        for record in self.records():
            found.update(record + b"\n")
        return found.hexdigest()

    def records(self) -> Iterator[bytes]:
        """The records of the trials that the study asks for as JSON, in the order of their keys."""
        for key, agent, condition, repetition, trial, identity, record in self._store.rows(
            "select key, agent, condition, repetition, trial, identity, record from trial "
            "where current and fork is null order by key"
        ):
            if (
                (agent, condition) in self._played
                and trial <= self._trials[agent]
                and repetition <= self._study.repetitions
                and self._filter.group_of(key, agent, condition, repetition, trial, identity)
            ):
                yield unpacked(self._store, key, record)
