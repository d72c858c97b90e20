"""The files of a report made again from the records, and held against those in the directory."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from lockprobe.foundation.errors import BadFile, LockprobeError, UserMistake
from lockprobe.foundation.inputs import read_input
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.parallel import one_thread, shared, uncollected
from lockprobe.report.rows import MEASURES, Results, Row
from lockprobe.report.verify.check import Check, check_of
from lockprobe.studies.branch import FORKS
from lockprobe.studies.file_names import RECORDS

RESULTS = "results.json"

PAGE = "report.html"

_ESTIMATE = ("quantity", "of", "agent", "modality", "condition", "control", "versus", "versus_modality", "axis")

_OF_ROWS: Mapping[str, Sequence[str]] = {
    "rows": _ESTIMATE,
    "curves": _ESTIMATE,
    "findings": ("section", "kind", "agent", "modality"),
    "facts": ("about", "name"),
}
"""Fields of the results that hold rows -> the columns that say what a row is of."""

_FORKS = re.compile(r": (\w+_by_fork|\w+_after_true_report|forks)\b")
"""Rows on forks among those that differ."""

_FOLDERS = ("tables", "figures")
"""The directories of a report, which hold nothing else."""

_PAGE_FORMS = (".html", ".htm", ".xhtml")
"""How names of pages end."""

_LARGEST = 2**28
"""Bytes of one file of a report."""

_DRAWN = re.compile(rb"<dc:title>(Matplotlib v[\w.]+)")
"""What drew a figure, in its SVG."""

_EMBEDDED = re.compile(rb"data:image/svg\+xml,[^\"]*")
"""A figure in a page."""


@dataclass
class _Compared:
    """The files that were compared, and what differs."""

    made: set[str] = field(default_factory=set)
    there: int = 0
    missing: int = 0
    pages: list[str] = field(default_factory=list)
    figures: list[str] = field(default_factory=list)
    drawn_elsewhere: str = ""


def report_checks(opened: OpenedStudy, *, processes: int = 1) -> tuple[Check, ...]:
    """Whether ``results.json``, pages, tables and figures are what the records give.

    No code of packages runs: what they measure is taken from the file.

    Args:
        opened: The study.
        processes: Processes that may work at a large report.
    """
    directory = opened.directory
    names = [RESULTS, PAGE, *_FOLDERS]
    if not any((directory / name).exists() for name in names):
        return (Check(name="results", holds=True, said="there is no report to compare"),)
    written, compared, results = _written(directory), _Compared(), dict[str, Any]()
    opened = replace(
        opened,
        measured=_measured(written),
    )
    try:
        for name, content in _made_again(opened, processes):
            compared.made.add(name)
            if name == RESULTS:
                results = json.loads(str(content))
            else:
                _compare(directory, name, content, compared)
    except UserMistake as mistake:
        return (Check(name="results", holds=False, said=str(mistake)),)
    check = _results(directory, results)
    if not check.holds and ("release" in check.said or "without" in check.said):
        return (check,)
    return check, _pages(opened, compared, newer=_changed_since(directory))


def _made_again(opened: OpenedStudy, processes: int) -> Iterator[tuple[str, str | bytes | None]]:
    from lockprobe.report.report_files import report_files

    with uncollected(), shared(opened.directory, processes) as each, one_thread():
        yield from report_files(opened, tell=lambda said: None, each=each)


def _written(directory: Path) -> Results | None:
    """The results in the directory; None if they cannot be read."""
    try:
        return Results.model_validate_json(read_input(directory / RESULTS, _LARGEST))
    except (LockprobeError, ValidationError):
        return None


def _measured(written: Results | None) -> tuple[Row, ...]:
    """What installed packages measure, as the results hold it."""
    if written is None:
        return ()
    measured = (row for row in written.measures if row.source)
    return (*measured, *(one for one in written.facts if one.about == MEASURES and one.source))


def _compare(directory: Path, name: str, made: str | bytes | None, found: _Compared) -> None:
    path, into = directory / name, found.figures if name.startswith("figures/") else found.pages
    if made is None:
        if path.exists():
            into.append(f"{name}: no file of this report")
        return
    if not path.exists():
        found.missing += 1
        return
    found.there += 1
    try:
        written = read_input(path, _LARGEST)
    except LockprobeError as error:
        into.append(str(error))
        return
    expected = made.encode() if isinstance(made, str) else made
    if written == expected:
        return
    if name.startswith("figures/"):
        software = [one[1].decode() if (one := _DRAWN.search(svg)) else "" for svg in (written, expected)]
        if software[0] != software[1]:
            found.drawn_elsewhere = software[0] or "another program"
        into.append(name)
    elif _EMBEDDED.sub(b"", written) != _EMBEDDED.sub(b"", expected):
        into.append(name)
    else:
        into.append(f"{name}: its figures")


def _changed_since(directory: Path) -> bool:
    """Whether records or forks are newer than the report."""
    reports = [path.stat().st_mtime for name in (RESULTS, PAGE) if (path := directory / name).is_file()]
    records = [path.stat().st_mtime for folder in (".", FORKS) if (path := directory / folder / RECORDS).is_file()]
    return bool(reports) and max(records, default=0.0) > min(reports)


def _pages(opened: OpenedStudy, found: _Compared, *, newer: bool) -> Check:
    """Whether pages, tables and figures are those of the records."""
    strange = [f"{name}: no file of this report" for name in _there(opened.directory) if name not in found.made]
    failed = [*found.pages, *found.figures, *strange]
    missing = f"; {found.missing} are not there" if found.missing else ""
    holds = f"{found.there} pages, tables and figures are what the records give{missing}"
    fails = "pages, tables and figures are not what the records give"
    if found.drawn_elsewhere:
        fails += f"; figures were drawn by {found.drawn_elsewhere}: lockprobe report first"
    elif newer:
        fails += "; the records are newer: lockprobe report first"
    return check_of("report", failed, holds, fails)


def _there(directory: Path) -> list[str]:
    """Pages, and all that is in the directories of a report, as paths; what is hidden is left to the system."""
    pages = [path for path in directory.iterdir() if path.suffix.lower() in _PAGE_FORMS]
    inside = [path for folder in _FOLDERS for path in (directory / folder).rglob("*")]
    names = [path.relative_to(directory) for path in (*pages, *inside) if path.is_symlink() or not path.is_dir()]
    return sorted(name.as_posix() for name in names if not any(part.startswith(".") for part in name.parts))


def _results(directory: Path, found: Mapping[str, Any]) -> Check:
    """Whether ``results.json`` is what the records give; forks that were played after it are said to be."""
    path, forks = directory / RESULTS, directory / FORKS / RECORDS
    check = _check_file("results", path, found)
    if check.failed and all(name.startswith("sections_left_out") for name in check.failed):
        return replace(
            check, said="the report was written without sections that can be made here: lockprobe report first"
        )
    of_forks = check.failed and all(_FORKS.search(name) for name in check.failed)
    if of_forks and forks.is_file() and forks.stat().st_mtime > path.stat().st_mtime:
        return replace(check, said=f"forks were played after {path.name} was written: lockprobe report first")
    return check


def _check_file(name: str, path: Path, found: Mapping[str, Any]) -> Check:
    """Whether a file of results, if there is one, holds what is computed from the records."""
    try:
        written = json.loads(read_input(path, _LARGEST).decode("utf-8"), object_pairs_hook=_once)
    except BadFile as error:
        if not path.exists():
            return Check(name=name, holds=True, said=f"there is no {path.name} to compare")
        return Check(name=name, holds=False, said=str(error))
    except (ValueError, RecursionError) as error:
        return Check(name=name, holds=False, said=f"{path.name} is damaged ({error})")
    if isinstance(written, dict) and written.get("lockprobe") != found["lockprobe"]:
        release = written.get("lockprobe")
        return Check(name=name, holds=False, said=f"{path.name} is of release {release}: lockprobe report first")
    places = tuple(_different(written, found))
    check = check_of(name, places, f"{path.name} is what the records give", f"values of {path.name} differ")
    packages = sorted(str(row["source"]) for row in _rows_of_packages(written))
    if check.holds and packages:
        said = f"{len(packages)} of its rows are not checked: they come from {', '.join(dict.fromkeys(packages))}"
        return replace(check, said=f"{check.said}; {said}")
    return check


def _once(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object. Programs differ in which of two values of one name they read, so there may be only one."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = [name for name, count in Counter(name for name, _ in pairs).items() if count > 1]
        raise ValueError(f"two values of {', '.join(twice)}")
    return found


def _rows_of_packages(value: Any) -> Iterator[Mapping[str, Any]]:
    """The rows that packages add."""
    for rows in value.values() if isinstance(value, Mapping) else ():
        if _listed(rows):
            yield from _of_packages(rows)


def _of_packages(rows: Sequence[Any]) -> list[Mapping[str, Any]]:
    return [row for row in rows if isinstance(row, Mapping) and row.get("source")]


def _different(written: Any, found: Any, where: str = "") -> Iterator[str]:
    """The places at which two JSON values differ; rows are compared by what they are of."""
    if isinstance(written, Mapping) and isinstance(found, Mapping):
        for name in dict.fromkeys([*written, *found]):
            place, one, other = f"{where}.{name}" if where else name, written.get(name), found.get(name)
            if one is other is None and (name in written) != (name in found):
                yield place
            yield from _different(one, other, place)
    elif where in _OF_ROWS and (_listed(written) or written is None) and (_listed(found) or found is None):
        yield from _different_rows(written or (), found or (), where)
    elif _listed(written) and _listed(found) and len(written) == len(found):
        for i, (one, other) in enumerate(zip(written, found, strict=True)):
            yield from _different(one, other, f"{where}[{i}]")
    elif not _same(written, found):
        yield where or "all of it"


def _same(one: Any, other: Any) -> bool:
    """Whether two JSON values are equal; ``true`` is not 1, as it is in Python."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(value, other[name]) for name, value in one.items())
    if _listed(one) and _listed(other):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other) and isinstance(one, bool) == isinstance(other, bool)


def _different_rows(written: Sequence[Any], found: Sequence[Any], where: str) -> Iterator[str]:
    """The rows that differ, are missing or are too many; those of packages are not compared."""
    there, made = (_by_identity(rows, where) for rows in (written, found))
    for name in dict.fromkeys([*there, *made]):
        one, other = there.get(name), made.get(name)
        if _same(one, other):
            continue
        said = f"{where}: {name}"
        if one is None or other is None:
            yield f"{said} is {'missing' if one is None else 'no row of this report'}"
            continue
        column = next(
            key
            for key in dict.fromkeys([*one, *other])
            if (key in one) != (key in other) or not _same(one.get(key), other.get(key))
        )
        yield f"{said}: {column} {one.get(column)} written, {other.get(column)} computed"
    group = _OF_ROWS[where][0]
    for row in _of_packages(written):
        if not f"{row.get(group)}.".startswith(f"{MEASURES}."):
            yield f"{where}: {row.get(group)} of {row['source']} has a name of Lockprobe's rows"


def _by_identity(rows: Sequence[Any], kind: str) -> dict[str, Mapping[str, Any]]:
    """Rows by what they are of, in words; equal ones by their number."""
    named: dict[str, Mapping[str, Any]] = {}
    copies = Counter[str]()
    for row in (row if isinstance(row, Mapping) else {"all of it": row} for row in rows):
        if row.get("source"):
            continue
        name = ", ".join(str(row[key]) for key in _OF_ROWS[kind] if row.get(key))
        copies[name] += 1
        named[f"{name} ({copies[name]})" if copies[name] > 1 else name] = row
    return named


def _listed(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)
