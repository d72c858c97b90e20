"""Updates the report of a study whenever its records have grown, until every planned trial is finished."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.record_index import RecordIndex
from lockprobe.studies.records.store import read
from lockprobe.studies.stopping import planned_now

PAUSE = 5.0
"""The least seconds from the end of one report to the next."""

_LOOK = 0.5
"""Seconds between checks of the records."""

_SHARE = 1.0
"""The least pause as a multiple of the time for a report, so that the study keeps half of the time."""


def watch_report(
    directory: Path,
    write: Callable[[], None],
    *,
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Write the report now, and again whenever the records or the settings change.

    It returns when every planned trial is finished, including those of people, and the last report holds all of them.

    Args:
        directory: The directory of a study.
        write: Writes the report.
        sleep: Waits for a number of seconds.
        clock: The time in seconds.

    Raises:
        BadFile: If the directory is not a study's, or a record is damaged.
    """
    while True:
        seen, began = _state(directory), clock()
        write()
        took = clock() - began
        if _state(directory) == seen and not owed_trials(directory):
            return
        sleep(max(PAUSE, _SHARE * took))
        while _state(directory) == seen:
            sleep(_LOOK)


def owed_trials(directory: Path) -> int:
    """The number of planned trials that are not finished, including those of people.

    Of a study that stops when it is decided: of those before its next look; 0 once it may stop.

    Raises:
        BadFile: If the directory is not a study's, or a record is damaged.
    """
    study = read_study(directory)
    if study.until:
        trials = study.own_trials(load(directory))
        return planned_now(study, trials) - sum(not trial.owed_again for trial in trials)
    with read(directory) as store:
        found = RecordIndex(store, study).counted()
    return planned_now(study, ()) - sum(one.number for one in found if not one.trial.owed_again)


def _state(directory: Path) -> tuple[object, ...]:
    """What a report depends on most: the records, and when the settings were written."""
    with read(directory) as store:
        found = store.one("select count(*), max(id) from trial")
    return (*found, (directory / SETTINGS).stat().st_mtime_ns)
