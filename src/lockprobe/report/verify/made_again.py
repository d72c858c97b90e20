"""The files of a report made again from the records, and held byte by byte against those in the directory."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pydantic import ValidationError

from lockprobe.foundation.errors import LockprobeError
from lockprobe.foundation.inputs import read_input
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.parallel import one_thread, shared, uncollected
from lockprobe.report.rows import MEASURES, Estimate, Fact, Results
from lockprobe.studies.branch import FORKS
from lockprobe.studies.file_names import RECORDS

RESULTS, PAGE = "results.json", "report.html"

_FOLDERS = ("tables", "figures")
"""The directories of a report, which hold nothing else."""

_LARGEST = 2**28
"""Bytes of one file of a report."""

_NAMED = 300
"""Bytes of a line of results that are named."""

_DRAWN_BY, _EMBEDDED = re.compile(rb"<dc:title>(Matplotlib v[\w.]+)"), re.compile(rb"data:image/svg\+xml,[^\"]*")
"""What drew a figure, in its SVG; a figure in a page."""

_RELEASE, _LEFT_OUT = re.compile(rb'^ "lockprobe": "(.*)"', re.MULTILINE), b'\n "sections_left_out": '
"""Lines of results."""


@dataclass
class MadeAgain:
    """How far a report in a directory is the one that its records give.

    Attributes:
        there: How many of its files are there, results aside.
        missing: How many are not.
        different: Those that are not what the records give.
        results: The lines of ``results.json`` that are not.
        advice: Why that may be so, and what to do.
        of_packages: The package of each row of the results that one measured; such a row is taken from the file.
    """

    there: int = 0
    missing: int = 0
    different: list[str] = field(default_factory=list)
    results: list[str] = field(default_factory=list)
    advice: str = ""
    of_packages: Sequence[str] = ()


def made_again(opened: OpenedStudy, processes: int) -> MadeAgain | None:
    """Make the report again, without code of packages; None if there is none in the directory."""
    directory, found, made = opened.directory, MadeAgain(), set[str]()
    if not any((directory / name).exists() for name in (RESULTS, PAGE, *_FOLDERS)):
        return None
    measured = _measured(directory)
    found.of_packages = [row.source for row in measured]
    for name, content in _files(replace(opened, measured=measured), processes):
        if content is not None:
            made.add(name)
            _compare(directory / name, name, content.encode() if isinstance(content, str) else content, found)
    inside = [path for folder in _FOLDERS for path in (directory / folder).rglob("*")]
    pages = [one for one in directory.iterdir() if one.suffix.lower() in (".html", ".htm", ".xhtml")]
    names = [one.relative_to(directory) for one in (*pages, *inside) if one.is_symlink() or not one.is_dir()]
    seen = sorted(name.as_posix() for name in names if not any(part.startswith(".") for part in name.parts))
    found.different += [f"{name}: no file of this report" for name in seen if name not in made]
    if not found.advice and _newer_records(directory):
        found.advice = "; the records or forks are newer: lockprobe report first"
    return found


def _files(opened: OpenedStudy, processes: int) -> Iterator[tuple[str, str | bytes | None]]:
    from lockprobe.report.report_files import report_files

    with uncollected(), shared(opened.directory, processes) as each, one_thread():
        yield from report_files(opened, tell=lambda said: None, each=each)


def _measured(directory: Path) -> tuple[Estimate | Fact, ...]:
    """What installed packages measure, as the results hold it; nothing if they cannot be read."""
    try:
        written = Results.model_validate_json(read_input(directory / RESULTS, _LARGEST))
    except (LockprobeError, ValidationError):
        return ()
    measured = (row for row in written.measures if row.source)
    return (*measured, *(one for one in written.facts if one.about == MEASURES and one.source))


def _compare(path: Path, name: str, expected: bytes, found: MadeAgain) -> None:
    if not path.exists():
        found.missing += 1
        return
    found.there += name != RESULTS
    try:
        written = read_input(path, _LARGEST)
    except LockprobeError as error:
        (found.results if name == RESULTS else found.different).append(str(error))
        return
    if written == expected:
        return
    if name == RESULTS:
        release, ours = (one[1] if (one := _RELEASE.search(text)) else b"" for text in (written, expected))
        if release and release != ours:
            found.advice = f"; it is of release {release.decode(errors='replace')}: lockprobe report first"
        elif _LEFT_OUT in written and _LEFT_OUT not in expected:
            found.advice = "; the report was written without sections that can be made here: lockprobe report first"
        there, made = (dict.fromkeys(line.strip(b" ,\r") for line in text.split(b"\n")) for text in (written, expected))
        lines = [("written", line) for line in there if line not in made]
        lines += [("computed", line) for line in made if line not in there]
        named = [f"{who}: {line[:_NAMED].decode(errors='replace')}" for who, line in lines]
        found.results = named or ["lines in another order"]
        return
    by, ours = (one[1] if (one := _DRAWN_BY.search(svg)) else b"" for svg in (written, expected))
    if name.startswith("figures/") and by != ours:
        found.advice = f"; figures were drawn by {by.decode() or 'another program'}: lockprobe report first"
    alike = not name.startswith("figures/") and _EMBEDDED.sub(b"", written) == _EMBEDDED.sub(b"", expected)
    found.different.append(f"{name}: its figures" if alike else name)


def _newer_records(directory: Path) -> bool:
    """Whether records or forks are newer than the report."""
    reports = [path.stat().st_mtime for name in (RESULTS, PAGE) if (path := directory / name).is_file()]
    records = [path.stat().st_mtime for folder in (".", FORKS) if (path := directory / folder / RECORDS).is_file()]
    return bool(reports) and max(records, default=0.0) > min(reports)
