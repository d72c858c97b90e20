"""``lockprobe export``: exports the trials of a study for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.interfaces.export.table_files import Rows, TableName, rows_of, write_rows, write_table
from lockprobe.interfaces.export.write_dataset import write_dataset
from lockprobe.people.diary import read_diaries
from lockprobe.people.step_times import seconds_of_trials, times_of_steps
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load, read_timings
from lockprobe.studies.records.picture_store import ALBUM

__all__ = ["export"]

Format = Literal["csv", "jsonl", "parquet", "eval", "psych-ds"]

_OUT = options.with_brackets(
    options.OUT,
    "standard output, also with -; eval: a file for all agents, or a directory for one log of each; psych-ds: a new "
    "directory",
)

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Format,
        typer.Option(help="csv, jsonl, parquet: a table; eval: a log for Inspect AI; psych-ds: a dataset of people."),
    ] = "csv",
    table: Annotated[TableName, typer.Option(help="csv, jsonl, parquet: one row per step, or per trial.")] = "steps",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
    everybody: Annotated[
        bool, typer.Option("--all", help="psych-ds: include trials of strategies and models.")
    ] = False,
    platform_ids: Annotated[
        bool,
        typer.Option("--with-platform-ids", help="psych-ds: include IDs of the platform; they are personal data."),
    ] = False,
) -> None:
    """Export a study: tables of steps or trials, logs for Inspect AI's viewer, or a Psych-DS dataset.

    A table FILE comes with its data dictionary, FILE-metadata.json, which describes every column.
    """
    if format != "psych-ds" and (everybody or platform_ids):
        raise BadValue("--format", format, "psych-ds with --all or --with-platform-ids")
    if format in ("eval", "psych-ds") and table != "steps":
        raise Conflict(f"--table {table}", f"--format {format}", "only csv, jsonl and parquet are single tables")
    if out is None or str(out) == "-":
        if format not in ("csv", "jsonl"):
            raise BadValue("--out", None, f"a file or a directory to write, because {format} is not text")
        write_rows(_rows(table, directory), sys.stdout, format)
        return
    refuse_study_file(out)
    if format == "psych-ds":
        written = write_dataset(directory, out, everybody=everybody, platform_ids=platform_ids)
    elif format == "eval":
        written = _write_logs(directory, out)
    else:
        written = write_table(_rows(table, directory), out, format)
    for path in written:
        print(path)


def _rows(table: TableName, directory: Path) -> Rows:
    """A table of the trials in a directory, with the response times and durations of its participants."""
    trials, diaries = load(directory), read_diaries(directory)
    if not diaries:
        return rows_of(table, trials)
    study = read_study(directory)
    times = times_of_steps(study, trials, diaries, directory)
    return rows_of(table, trials, times, seconds_of_trials(study, diaries))


def _write_logs(directory: Path, out: Path) -> list[Path]:
    from lockprobe.interfaces.inspect.write_log import write_logs

    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    return write_logs(load(directory), read_study(directory), out, pictures=directory / ALBUM, seconds=seconds)
