"""``lockprobe import``: imports trials that were played elsewhere."""

from __future__ import annotations

import json as json_
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.import_diaries import DiaryImport
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.records.merge import MergeSource, gather, source_of_directory

__all__ = ["take"]

_LOGS = (".eval", ".json")

_SOURCES = "An Inspect log (.eval, .json), a directory of such logs, or the directory of another study."


def take(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study; created if missing.")],
    sources: Annotated[list[Path], typer.Argument(metavar="SOURCE...", help=_SOURCES)],
    json: options.AsJson = False,
) -> None:
    """Import trials that DIR does not have from Inspect logs and other study directories.

    They must be of the same study: all settings except the agents must be equal.
    """
    found = [source for path in sources for source in _sources(path, directory)]
    diaries = DiaryImport(directory, {source.path: source.trials for source in found if source.path.is_dir()})
    people: list[tuple[int, int]] = []
    gathered = gather(
        directory, found, beside=lambda trials: people.append((diaries.take(trials), diaries.lost(trials)))
    )
    ((came, lost),) = people
    if json:
        print(json_.dumps({**asdict(gathered), "participants": came, "places_lost": lost}))
        return
    kept = (
        f" {gathered.replies} replies of unfinished trials were imported; these trials continue from them."
        if gathered.replies
        else ""
    )
    otherwise = (
        f" {gathered.different} trials differ between SOURCE and {directory}, which keeps its own."
        if gathered.different
        else ""
    )
    agents = f" New agents: {', '.join(gathered.agents)}." if gathered.agents else ""
    joined = f" {came} participants." if came else ""
    places = f" {lost} boxes assigned to participants here were played by imported participants." if lost else ""
    missing = f" {gathered.pictures_missing} pictures were not found." if gathered.pictures_missing else ""
    said = (
        f"{gathered.taken} trials imported, {gathered.there} already there, {gathered.unfinished} unfinished."
        f"{otherwise}{kept}{agents}{joined}{places}{missing} Report: lockprobe report {directory}"
    )
    print(printable(said))


def _sources(path: Path, directory: Path) -> list[MergeSource]:
    if path.resolve() == directory.resolve():
        raise BadValue("SOURCE", str(path), "a directory other than DIR")
    if not path.exists():
        raise BadFile(path, "no such file or directory")
    if (path / SETTINGS).is_file():
        return [source_of_directory(path)]
    if path.is_file() and path.suffix not in _LOGS:
        raise BadFile(path, f"not an Inspect log, whose name ends in {' or '.join(_LOGS)}, and not a directory")
    from lockprobe.interfaces.inspect.read_log import log_files, read_log

    if not (files := log_files(path)):
        raise BadFile(path, "not a study directory or a directory of Inspect logs")
    return [read_log(file) for file in files]
