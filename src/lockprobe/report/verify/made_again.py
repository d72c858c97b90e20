"""The files of a report made again from the records, and held byte by byte against those in the directory."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

from pydantic import ValidationError

from lockprobe.foundation.errors import LockprobeError, UserMistake
from lockprobe.foundation.inputs import read_input
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.processor import one_thread, uncollected
from lockprobe.report.rows import MEASURES, Estimate, Fact, Results
from lockprobe.report.verify.check import Check, also

RESULTS, PAGE = "results.json", "report.html"

_FOLDERS = ("tables", "figures")
"""The directories of a report, which hold nothing else."""

_LARGEST = 2**28
"""Bytes of one file of a report."""

_NAMED = 300
"""Bytes of a line of results that are named."""

_TIME = re.compile(rb"Made at \d\d:\d\d on \d{1,2} [A-Z][a-z]+ \d{4};")
"""When a page was made, of a study with open trials."""

_ADVICE = "; if they are of another release, of other records or drawn elsewhere: lockprobe report first"


def report_held(opened: OpenedStudy) -> Iterator[Check]:
    """Whether the results are what the records give, and the page, the tables and the figures of a report likewise.

    The report is made without code of packages: the rows that they measured are taken from the file, and named.
    """
    from lockprobe.report.report_files import report_files

    directory, measured = opened.directory, _measured(opened.directory)
    if not any((directory / name).exists() for name in (RESULTS, PAGE, *_FOLDERS)):
        yield Check.of("results", (), "", "there is no report to compare")
        return
    try:
        with uncollected(), one_thread():
            files = dict(report_files(replace(opened, measured=measured), tell=lambda said: None))
    except UserMistake as mistake:
        yield Check.of("results", [str(mistake)], str(mistake), "")
        return
    made = {name: one.encode() if isinstance(one, str) else one for name, one in files.items() if one is not None}
    there = [name for name in made if (directory / name).exists()]
    different = {name: _difference(directory / name, name, made[name]) for name in there}
    packages = ", ".join(dict.fromkeys(row.source for row in measured))
    unchecked = also(len(measured), f"of its rows are not checked: they come from {packages}")
    fails, holds = f"{{n}} lines of results.json differ{_ADVICE}", f"results.json is what the records give{unchecked}"
    yield Check.of("results", different.pop(RESULTS, ()), fails, holds)
    fails = f"{{n}} pages, tables and figures are not what the records give{_ADVICE}"
    holds = f"{len(there) - (RESULTS in there)} pages, tables and figures are what the records give"
    yield Check.of("report", chain(*different.values()), fails, holds + also(len(made) - len(there), "are not there"))


def _measured(directory: Path) -> tuple[Estimate | Fact, ...]:
    """What installed packages measure, as the results hold it; nothing if they cannot be read."""
    try:
        written = Results.model_validate_json(read_input(directory / RESULTS, _LARGEST))
    except (LockprobeError, ValidationError):
        return ()
    measured = (row for row in written.measures if row.source)
    return (*measured, *(one for one in written.facts if one.about == MEASURES and one.source))


def _difference(path: Path, name: str, made: bytes) -> list[str]:
    """What is named of a file that is not what the records give: it, or its lines if it is the results."""
    try:
        written = read_input(path, _LARGEST)
    except LockprobeError as error:
        return [str(error)]
    if name != RESULTS:
        return [] if _TIME.sub(b"", written) == _TIME.sub(b"", made) else [name]
    there, here = (dict.fromkeys(line.strip(b" ,\r") for line in text.split(b"\n")) for text in (written, made))
    lines = [("written", line) for line in there if line not in here]
    lines += [("computed", line) for line in here if line not in there]
    named = [f"{who}: {line[:_NAMED].decode(errors='replace')}" for who, line in lines]
    return named or ["lines in another order"] * (written != made)
