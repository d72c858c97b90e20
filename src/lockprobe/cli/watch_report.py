"""Writes the report of a study again whenever its records have grown, until every planned trial is finished."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from lockprobe.studies.directory import RECORDS, SETTINGS
from lockprobe.studies.journal import load
from lockprobe.studies.settings import read_study

__all__ = ["PAUSE", "owed_trials", "watch_report"]

PAUSE = 5.0
"""Least seconds from the end of one report to the next."""

_LOOK = 0.5
"""Seconds between two looks at the records."""

_SHARE = 1.0
"""Least pause as a multiple of the time that the report took: a study keeps half of the time for itself."""


def watch_report(
    directory: Path,
    write: Callable[[], None],
    *,
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Write the report now, and again when the records or the settings have changed.

    It returns when every planned trial is finished, those of people too, and the last report holds all of them.

    Args:
        directory: The directory of a study.
        write: Writes the report.
        sleep: Waits so many seconds.
        clock: The time in seconds.

    Raises:
        BadFile: If it is not the directory of a study, or a record is damaged.
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
    """Trials of a study that are planned and not finished, those of people too.

    Raises:
        BadFile: If it is not the directory of a study, or a record is damaged.
    """
    study = read_study(directory)
    return study.size - sum(not trial.owed_again for trial in load(directory) if study.asks_for(trial))


def _state(directory: Path) -> tuple[tuple[int, int], ...]:
    """Size and time of change of the files that a report depends on most."""
    found = [directory / name for name in (RECORDS, SETTINGS)]
    return tuple((path.stat().st_size, path.stat().st_mtime_ns) for path in found if path.exists())
