"""``lockprobe export``: exports the trials of a study for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.interfaces.export.table_files import write_rows, write_table
from lockprobe.interfaces.export.tables import TableName, table_of
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load, read_timings
from lockprobe.studies.records.picture_store import ALBUM

__all__ = ["export"]

Format = Literal["csv", "jsonl", "parquet", "eval"]

_OUT = options.with_brackets(
    options.OUT, "standard output, also with -; eval: a file for all agents, or a directory for one log of each"
)

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Format, typer.Option(help="csv, jsonl, parquet: a table; eval: a log for Inspect AI.")
    ] = "csv",
    table: Annotated[
        TableName,
        typer.Option(help="A row per step, trial or call of a model; of people also others."),
    ] = "steps",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
    platform_ids: Annotated[
        bool,
        typer.Option("--with-platform-ids", help="Include people's IDs of the platform; they are personal data."),
    ] = False,
) -> None:
    """Export a study: a table of its steps, trials or calls, or logs for Inspect AI's viewer.

    A table FILE comes with its data dictionary, FILE-metadata.json, which describes every column.
    """
    if format == "eval" and table != "steps":
        raise Conflict(f"--table {table}", f"--format {format}", "only csv, jsonl and parquet are single tables")
    if out is None or str(out) == "-":
        if format not in ("csv", "jsonl"):
            raise BadValue("--out", None, f"a file or a directory to write, because {format} is not text")
        write_rows(table_of(directory, table, platform_ids=platform_ids), sys.stdout, format)
        return
    refuse_study_file(out)
    if format == "eval":
        written = _write_logs(directory, out)
    else:
        written = write_table(table_of(directory, table, platform_ids=platform_ids), out, format)
    for path in written:
        print(path)


def _write_logs(directory: Path, out: Path) -> list[Path]:
    from lockprobe.interfaces.inspect.write_log import write_logs

    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    return write_logs(load(directory), read_study(directory), out, pictures=directory / ALBUM, seconds=seconds)
