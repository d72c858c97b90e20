"""The files of a report made again from the records, and held byte by byte against those in the directory."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
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

_DRAWN_BY, _EMBEDDED = re.compile(rb"<dc:title>(Matplotlib v[\w.]+)"), re.compile(rb"data:image/svg\+xml,[^\"]*")
"""What drew a figure, in its SVG; a figure in a page."""

_TIME = re.compile(rb"Made at \d\d:\d\d on \d{1,2} [A-Z][a-z]+ \d{4};")
"""When a page was made, of a study with open trials."""

_RELEASE, _LEFT_OUT = re.compile(rb'^ "lockprobe": "(.*)"', re.MULTILINE), b'\n "sections_left_out": '
"""Lines of results."""

_RECORDS = re.compile(rb'"results_hash": "[^"]*"|"after_true_report".*?"n": \d+')
"""What results say of the records and the forks that they are of."""


def report_held(opened: OpenedStudy) -> Iterator[Check]:
    """Whether the results are what the records give, and the page, the tables and the figures of a report likewise.

    The report is made without code of packages: the rows that they measured are taken from the file, and named.
    """
    directory, measured = opened.directory, _measured(opened.directory)
    if not any((directory / name).exists() for name in (RESULTS, PAGE, *_FOLDERS)):
        yield Check.of("results", (), "", "there is no report to compare")
        return
    try:
        made = _made(replace(opened, measured=measured))
    except UserMistake as mistake:
        yield Check.of("results", [str(mistake)], str(mistake), "")
        return
    there, different, advice = [name for name in made if (directory / name).exists()], dict[str, list[str]](), ""
    for name in there:
        try:
            different[name], why = _difference(name, read_input(directory / name, _LARGEST), made[name])
            advice = why or advice
        except LockprobeError as error:
            different[name] = [str(error)]
    packages = ", ".join(dict.fromkeys(row.source for row in measured))
    unchecked = also(len(measured), f"of its rows are not checked: they come from {packages}")
    fails, holds = f"{{n}} lines of results.json differ{advice}", f"results.json is what the records give{unchecked}"
    yield Check.of("results", different.pop(RESULTS, ()), fails, holds)
    others = [*chain(*different.values()), *(f"{name}: no file of this report" for name in _others(directory, made))]
    fails = f"{{n}} pages, tables and figures are not what the records give{advice}"
    holds = f"{len(there) - (RESULTS in there)} pages, tables and figures are what the records give"
    yield Check.of("report", others, fails, holds + also(len(made) - len(there), "are not there"))


def _measured(directory: Path) -> tuple[Estimate | Fact, ...]:
    """What installed packages measure, as the results hold it; nothing if they cannot be read."""
    try:
        written = Results.model_validate_json(read_input(directory / RESULTS, _LARGEST))
    except (LockprobeError, ValidationError):
        return ()
    measured = (row for row in written.measures if row.source)
    return (*measured, *(one for one in written.facts if one.about == MEASURES and one.source))


def _made(opened: OpenedStudy) -> dict[str, bytes]:
    """The files of the report, as the records give them."""
    from lockprobe.report.report_files import report_files

    with uncollected(), one_thread():
        files = list(report_files(opened, tell=lambda said: None))
    return {
        name: content.encode() if isinstance(content, str) else content
        for name, content in files
        if content is not None
    }


def _difference(name: str, written: bytes, made: bytes) -> tuple[list[str], str]:
    """What is named of a file that is not what the records give, and why that may be so, with what to do."""
    if name == PAGE:
        written, made = (_TIME.sub(b"", one) for one in (written, made))
    if written == made:
        return [], ""
    if name != RESULTS:
        if name.startswith("figures/"):
            by, ours = (one[1] if (one := _DRAWN_BY.search(svg)) else b"" for svg in (written, made))
            other = f"; figures were drawn by {by.decode() or 'another program'}: lockprobe report first"
            return [name], other if by != ours else ""
        return [f"{name}: its figures" if _EMBEDDED.sub(b"", written) == _EMBEDDED.sub(b"", made) else name], ""
    advice, (release, ours) = "", (one[1] if (one := _RELEASE.search(text)) else b"" for text in (written, made))
    if release and release != ours:
        advice = f"; it is of release {release.decode(errors='replace')}: lockprobe report first"
    elif _LEFT_OUT in written and _LEFT_OUT not in made:
        advice = "; the report was written without sections that can be made here: lockprobe report first"
    elif _RECORDS.findall(written) != _RECORDS.findall(made):
        advice = "; it is of other records or forks: lockprobe report first"
    there, here = (dict.fromkeys(line.strip(b" ,\r") for line in text.split(b"\n")) for text in (written, made))
    lines = [("written", line) for line in there if line not in here]
    lines += [("computed", line) for line in here if line not in there]
    named = [f"{who}: {line[:_NAMED].decode(errors='replace')}" for who, line in lines]
    return named or ["lines in another order"], advice


def _others(directory: Path, made: Container[str]) -> list[str]:
    """Pages, tables and figures that the report does not have."""
    inside = [path for folder in _FOLDERS for path in (directory / folder).rglob("*")]
    pages = [one for one in directory.iterdir() if one.suffix.lower() in (".html", ".htm", ".xhtml")]
    names = [one.relative_to(directory) for one in (*pages, *inside) if one.is_symlink() or not one.is_dir()]
    seen = (name.as_posix() for name in names if not any(part.startswith(".") for part in name.parts))
    return sorted(name for name in seen if name not in made)
