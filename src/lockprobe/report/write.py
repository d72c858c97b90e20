"""Writes the report of a study directory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lockprobe.foundation.left_out import LeftOutSection
from lockprobe.foundation.storage.atomic_file import remove_file, write_file
from lockprobe.foundation.storage.links import make_directory
from lockprobe.report.processor import one_thread, uncollected


def write_report(
    directory: Path | str,
    *,
    tell: Callable[[str], None] = lambda said: None,
    left_out: Callable[[LeftOutSection], None] = lambda section: None,
) -> Path:
    """Write ``results.json``, ``figures/``, ``tables/``, and the pages into a study directory.

    Every file is replaced in one step, ``report.html`` last. Figures of an earlier report that this one has not go. No
    single section can keep the report from being written: one that cannot be made is left out and named, with its
    reason, on the page and in ``results.json``.

    Args:
        directory: The directory of a study.
        tell: Told what it is at, since it takes some seconds.
        left_out: Told every section that could not be made.

    Returns:
        Where ``report.html`` is.

    Raises:
        BadFile: If the directory is not that of a study.
    """
    directory = Path(directory)
    with uncollected():
        from lockprobe.report.opened import open_study
        from lockprobe.report.report_files import report_files

        with one_thread():
            for name, content in report_files(open_study(directory), tell=tell, left_out=left_out):
                path = directory / name
                if content is None:
                    remove_file(path)
                else:
                    make_directory(path.parent)
                    write_file(path, content)
    return directory / "report.html"
