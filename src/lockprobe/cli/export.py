"""``lockprobe export``: the trials of a study for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.errors import BadFile, BadValue
from lockprobe.export.table_files import TableName, rows_of, write_rows, write_table
from lockprobe.export.write_dataset import write_dataset
from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.people.step_times import times_of_steps
from lockprobe.studies.call_log import ASKED, CALLS
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.picture_store import ALBUM
from lockprobe.studies.settings import read_study

__all__ = ["export", "refuse_study_file"]

STUDY_FILES = ("study.json", "trials.jsonl", "timings.jsonl", CALLS, ASKED, "results.json")
"""Files of a study that no export replaces."""

Format = Literal["csv", "jsonl", "parquet", "eval", "psych-ds"]

_OUT = (
    "File to write; standard output otherwise, or with -. Of logs a file for all agents, or a directory for one log of "
    "each; of a dataset a new directory."
)

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Format,
        typer.Option(help="csv, jsonl, parquet: a table; eval: a log for Inspect AI; psych-ds: a dataset of people."),
    ] = "csv",
    table: Annotated[TableName, typer.Option(help="csv, jsonl, parquet: a row is a step, or a trial.")] = "steps",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
    everybody: Annotated[bool, typer.Option("--all", help="psych-ds: strategies' and models' trials too.")] = False,
    platform_ids: Annotated[
        bool,
        typer.Option("--with-platform-ids", help="psych-ds: IDs of the recruitment platform too; they are personal."),
    ] = False,
) -> None:
    """Tables of steps or trials, truth and report; logs that Inspect AI's viewer reads; or a Psych-DS dataset.

    Beside a table FILE its data dictionary is written, FILE-metadata.json: what stands in every column.
    """
    if format != "psych-ds" and (everybody or platform_ids):
        raise BadValue("--format", format, "psych-ds, where --all and --with-platform-ids say something")
    if format in ("eval", "psych-ds") and table != "steps":
        raise BadValue("--table", table, f"csv, jsonl or parquet as --format, since {format} is no single table")
    if out is None or str(out) == "-":
        if format not in ("csv", "jsonl"):
            raise BadValue("--out", None, f"a file or a directory to write, since {format} is no text")
        trials = load(directory)
        write_rows(rows_of(table, trials, times_of_steps(directory, trials)), sys.stdout, format)
        return
    refuse_study_file(out, directory)
    if format == "psych-ds":
        written = write_dataset(directory, out, everybody=everybody, platform_ids=platform_ids)
    elif format == "eval":
        written = _write_logs(directory, out)
    else:
        trials = load(directory)
        written = write_table(rows_of(table, trials, times_of_steps(directory, trials)), out, format)
    for path in written:
        print(path)


def refuse_study_file(out: Path, directory: Path) -> None:
    """Refuse to replace what a study records; a link to it is refused too.

    Raises:
        BadFile: If ``out`` is a file of the study in ``directory``.
    """
    file, study = out.resolve(), directory.resolve()
    kept = (study / ALBUM, study / PEOPLE_DIRECTORY)
    if (file.parent == study and file.name in STUDY_FILES) or any(file.is_relative_to(place) for place in kept):
        raise BadFile(out, "a file of the study itself; choose another")


def _write_logs(directory: Path, out: Path) -> list[Path]:
    from lockprobe.evals.write_log import write_logs

    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    return write_logs(load(directory), read_study(directory), out, pictures=directory / ALBUM, seconds=seconds)
