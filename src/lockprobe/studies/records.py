"""Reads the records of a study (``trials.jsonl``) and leaves out those of other studies.

Records of another study are counted and reported; they never replace a record of this study, even with the same key.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from lockprobe.errors import BadFile, BadValue
from lockprobe.inputs import check_regular
from lockprobe.record import Trial
from lockprobe.storage.jsonl import whole_lines
from lockprobe.studies.directory import RECORDS, SETTINGS, read_settings
from lockprobe.studies.study import LATER, record_identity
from lockprobe.trial_json import trial_from_line

__all__ = ["LeftOut", "left_out", "load", "read_records"]


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
    path = Path(directory) / RECORDS
    check_regular(path)
    if not path.is_file():
        raise BadFile(directory, f"no {RECORDS} here; is it the directory of a study?")
    if settings is None and (path.parent / SETTINGS).exists():
        settings = read_settings(directory)
    study = None if settings is None else _RecordFilter(settings)
    trials: dict[str, Trial] = {}
    replaced = repeated = contradicted = 0
    foreign: list[str] = []
    for number, line in whole_lines(path):
        try:
            trial, identity = trial_from_line(line)
        except BadValue as error:
            raise BadFile(path, f"line {number}: {error}; without this line its trial is played again") from error
        if study is not None and (why := study.why_foreign(trial, identity)):
            foreign.append(f"line {number}, {trial.key}: {why}")
            continue
        before = trials.pop(trial.key, None)
        replaced += before is not None and before.owed_again
        asked = trial.error is not None and trial.error.again  # the same record, owed anew
        if before is not None and not before.owed_again and not asked:
            repeated += 1
            contradicted += before != trial
        trials[trial.key] = trial
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 1))
        torn = int(file.read(1) not in (b"", b"\n"))
    return list(trials.values()), LeftOut(
        unfinished_lines=torn,
        replaced=replaced,
        repeated=repeated,
        contradicted=contradicted,
        foreign=len(foreign),
        first_foreign=foreign[0] if foreign else "",
    )


class _RecordFilter:
    """A filter that separates the records of one study from foreign records."""

    def __init__(self, settings: Mapping[str, object]) -> None:
        known = {**LATER, **settings}
        box = known.get("box")
        self._identity = record_identity(settings)
        self._values = {
            "study": known.get("study"),
            "box": box.get("name") if isinstance(box, dict) else None,
            "seed": known.get("seed"),
            "flip": known.get("flip"),
            "budget": known.get("max_steps"),
            "assessment": known.get("assessment"),
        }

    def why_foreign(self, trial: Trial, identity: str) -> str:
        """The difference between a record and this study; empty if the record belongs to it.

        Records of earlier releases have no ``identity``, so their values are compared.
        """
        if identity == self._identity:
            return ""
        different = [
            f"{name} is {getattr(trial, name)!r}, not {value!r}"
            for name, value in self._values.items()
            if getattr(trial, name) != value
        ]
        if identity and not different:
            return f"its study is {identity}, not {self._identity}"
        return "; ".join(different)
