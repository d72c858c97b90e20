"""``lockprobe export``: exports the trials of a study for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.export.table_files import write_rows, write_table
from lockprobe.interfaces.export.tables import TableName, table_of

Format = Literal["csv", "jsonl", "parquet"]

_OUT = options.with_brackets(options.OUT, "standard output, also with -")

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]


def export(
    directory: Directory,
    format: Annotated[Format, typer.Option(help="The kind of file.")] = "csv",  # noqa: A002
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
    """Export a study: a table of its steps, trials or calls.

    A table FILE comes with its data dictionary, FILE-metadata.json, which describes every column.
    """
    if out is None or str(out) == "-":
        if format == "parquet":
            raise BadValue("--out", None, "a file to write, because parquet is not text")
        write_rows(table_of(directory, table, platform_ids=platform_ids), sys.stdout, format)
        return
    refuse_study_file(out)
    for path in write_table(table_of(directory, table, platform_ids=platform_ids), out, format):
        print(path)
