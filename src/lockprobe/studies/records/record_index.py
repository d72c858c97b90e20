"""The records of a journal without their steps: what was played, how it ended, and where each record stands.

A study of a million trials of strategies takes a gigabyte to load and a tenth of it to count: records that are alike
but for their places are counted together. Records with what adds up over steps, as usage, are read whole.
"""

from __future__ import annotations

import hashlib
import os
from array import array
from pathlib import Path
from typing import NamedTuple

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.inputs import read_lines
from lockprobe.studies.records.counted import Counted
from lockprobe.studies.records.read_records import LinesLeftOut, RecordFilter, records_of
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_json import trial_to_json
from lockprobe.trial.trial_reader import Outline, TrialReader


class _Kind(NamedTuple):
    """Records that are alike but for their places.

    Attributes:
        number: From 0, in the order in which they were met.
        trial: One of them.
        trials: Trials per repetition and condition that the study asks its agent for; 0 if it asks for none.
        foreign: Why they are of another study; empty if they are not.
    """

    number: int
    trial: Trial
    trials: int
    foreign: str


class RecordIndex:
    """The records of a journal that count, of each trial the last one, in the order in which they were finished.

    Args:
        directory: The directory of the study.
        study: The study.

    Attributes:
        left_out: The lines that are no records of its settings, or were replaced.

    Raises:
        BadFile: If there is no journal or a line within it is damaged.
    """

    def __init__(self, directory: Path, study: Study) -> None:
        self._path, self._study = records_of(directory), study
        self._filter, self._reader = RecordFilter(study), TrialReader()
        self._trials = {one: study.trials_of(one) for one in study.agents}
        self._played = {(one, condition.label) for one in study.agents for condition in study.conditions_of(one)}
        self._rows: dict[str, int] = {}
        self._kinds: list[_Kind] = []
        self._known: dict[tuple[int, str], _Kind] = {}
        self._kind, self._own, self._steps, self._begin, self._length = (array("q") for _ in range(5))
        left, begin = LinesLeftOut(self._path), 0
        for number, line in enumerate(read_lines(self._path), 1):
            if line.endswith(b"\n") and line.strip():
                try:
                    self._take(number, line, begin, left)
                except BadValue as error:
                    raise left.damaged(number, error) from error
            begin += len(line)
        self.left_out = left.counts()

    def __len__(self) -> int:
        return len(self._rows)

    def owes(self, key: str) -> bool:
        """Whether a trial is not finished: not on record, or broken by something outside the agent."""
        row = self._rows.get(key)
        return row is None or self._kinds[self._kind[row]].trial.owed_again

    def counted(self, *, own: bool = True) -> list[Counted]:
        """The records of trials that the study asks for (:meth:`Study.asks_for`), or all with its settings."""
        numbers, steps = dict[int, int](), dict[int, int]()
        for row in self._rows.values():
            if self._own[row] or not own:
                kind = self._kind[row]
                numbers[kind] = numbers.get(kind, 0) + 1
                steps[kind] = steps.get(kind, 0) + self._steps[row]
        return [Counted(self._kinds[kind].trial, number, steps[kind]) for kind, number in numbers.items()]

    def digest(self) -> str:
        """:func:`lockprobe.studies.records.results_hash.records_digest` of the trials that the study asks for."""
        found, before = hashlib.sha256(), b""
        with self._path.open("rb") as file:
            for _, row in sorted((key, row) for key, row in self._rows.items() if self._own[row]):
                if length := self._length[row]:
                    found.update(before + os.pread(file.fileno(), length, self._begin[row]) + b"}")
                else:
                    found.update(before + trial_to_json(self._kinds[self._kind[row]].trial))
                before = b"\n"
        return found.hexdigest()

    def _take(self, number: int, line: bytes, begin: int, left: LinesLeftOut) -> None:
        """Add the record on a line, unless it is of another study."""
        kind = None
        if (found := self._reader.outline(line)) is None:
            whole, identity = self._reader.read(line)
            found = Outline(whole, whole.key, (whole.repetition, whole.trial), len(whole.steps), identity, 0)
        else:
            kind = self._known.get((id(found.kind), found.identity))
        if kind is None:
            kind = self._new_kind(found)
            if found.length:
                self._known[id(found.kind), found.identity] = kind
        if kind.foreign:
            left.foreign(number, found.key, kind.foreign)
            return
        if (before := self._rows.pop(found.key, None)) is not None:
            first = self._begin[before]
            left.again(self._kinds[self._kind[before]].trial, kind.trial, lambda: self._line_at(first) == line)
        self._rows[found.key] = len(self._kind)
        repetition, trial = found.place
        self._kind.append(kind.number)
        self._own.append(trial <= kind.trials and repetition <= self._study.repetitions)
        self._steps.append(found.steps)
        self._begin.append(begin)
        self._length.append(found.length)

    def _new_kind(self, found: Outline) -> _Kind:
        """A kind of records that was not met before."""
        trial, foreign = found.kind, self._filter.why_foreign(found.kind, found.identity)
        asked = trial.fork is None and (trial.spec, trial.condition) in self._played
        kind = _Kind(len(self._kinds), trial, self._trials[trial.spec] if asked else 0, foreign)
        self._kinds.append(kind)
        return kind

    def _line_at(self, begin: int) -> bytes:
        with self._path.open("rb") as file:
            file.seek(begin)
            return file.readline()
