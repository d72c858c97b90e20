"""Reads the records of a study (``trials.jsonl``) and leaves out those of other studies.

Records of another study are counted and reported; they never replace a record of this study, even with the same key.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import check_regular
from lockprobe.foundation.storage.jsonl import whole_lines
from lockprobe.studies.file_names import RECORDS, SETTINGS, not_here
from lockprobe.studies.options.settings import study_from
from lockprobe.studies.records.directory import read_settings
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial
from lockprobe.trial.trial_reader import TrialReader


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """Counts of the lines of a journal that are not trials of the study.

    Attributes:
        unfinished_lines: Lines torn by a crash, 0 or 1; the trial is owed again.
        replaced: Records of trials that were played again after an error.
        repeated: Duplicate records of finished trials; the last one counts.
        contradicted: Of these, records that differ from the one before.
        foreign: Records of another study.
        first_foreign: The first foreign record: its line, its key and the setting that differs; empty without one.
    """

    unfinished_lines: int
    replaced: int
    repeated: int
    contradicted: int = 0
    foreign: int = 0
    first_foreign: str = ""


def load(directory: Path | str) -> list[Trial]:
    """Load the trials of a study directory, in the order in which they were finished.

    Where a trial was played again after an error, the last record counts. Records of another study are left out.

    Raises:
        BadFile: If there is no journal or a line within it is damaged.
    """
    return read_records(directory)[0]


def left_out(directory: Path | str) -> LeftOut:
    """Count the lines of a journal that :func:`load` leaves out."""
    return read_records(directory)[1]


def read_records(directory: Path | str, settings: Mapping[str, object] | None = None) -> tuple[list[Trial], LeftOut]:
    """:func:`load` and :func:`left_out` in one pass. ``settings`` are the directory's settings, if already read."""
    path = records_of(directory)
    if settings is None and (path.parent / SETTINGS).exists():
        settings = read_settings(directory)
    own = None if settings is None else RecordFilter(study_from(settings, path.parent / SETTINGS))
    trials, reader, left = dict[str, Trial](), TrialReader(), LinesLeftOut(path)
    for number, line in whole_lines(path):
        try:
            trial, identity = reader.read(line)
        except BadValue as error:
            raise left.damaged(number, error) from error
        if own is not None and (why := own.why_foreign(trial, identity)):
            left.foreign(number, trial.key, why)
            continue
        if (before := trials.pop(trial.key, None)) is not None:
            left.again(before, trial, lambda before=before, trial=trial: before == trial)  # type: ignore[misc]
        trials[trial.key] = trial
    return list(trials.values()), left.counts()


def records_of(directory: Path | str) -> Path:
    """The file of the records of a study.

    Raises:
        BadFile: If there is none.
    """
    path = Path(directory) / RECORDS
    check_regular(path)
    if not path.is_file():
        raise BadFile(directory, not_here(RECORDS))
    return path


class LinesLeftOut:
    """Counts the lines of a journal that are left out, while it is read.

    Args:
        path: The journal.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._replaced = self._repeated = self._contradicted = self._foreign = 0
        self._first_foreign = ""

    def damaged(self, number: int, error: BadValue) -> BadFile:
        """What is wrong with a line that is no record."""
        return BadFile(self._path, f"line {number}: {error}; without this line its trial is played again")

    def foreign(self, number: int, key: str, why: str) -> None:
        """A line is a record of another study."""
        self._foreign += 1
        self._first_foreign = self._first_foreign or f"line {number}, {key}: {why}"

    def again(self, before: Trial, now: Trial, equal: Callable[[], bool]) -> None:
        """A trial has a second record, which counts in place of the first."""
        asked = now.error is not None and now.error.again  # the same record, owed anew
        self._replaced += before.owed_again
        if not before.owed_again and not asked:
            self._repeated += 1
            self._contradicted += not equal()

    def counts(self) -> LeftOut:
        """What was counted, and whether the last line is torn."""
        with self._path.open("rb") as file:
            file.seek(max(0, self._path.stat().st_size - 1))
            torn = int(file.read(1) not in (b"", b"\n"))
        return LeftOut(
            unfinished_lines=torn,
            replaced=self._replaced,
            repeated=self._repeated,
            contradicted=self._contradicted,
            foreign=self._foreign,
            first_foreign=self._first_foreign,
        )


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
