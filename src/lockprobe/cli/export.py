"""``lockprobe export``: exports the trials of a study for other tools."""

from __future__ import annotations

import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.interfaces.export.hub_dataset import write_hub_dataset
from lockprobe.interfaces.export.send_traces import endpoints_of, send_traces
from lockprobe.interfaces.export.table_files import Rows, TableName, rows_of, write_rows, write_table
from lockprobe.interfaces.export.traces import EPOCH, requests, write_traces
from lockprobe.interfaces.export.write_dataset import write_dataset
from lockprobe.people.diary import read_diaries
from lockprobe.people.step_times import seconds_of_trials, times_of_steps
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load, read_timings
from lockprobe.studies.records.picture_store import ALBUM

__all__ = ["export"]

Format = Literal["csv", "jsonl", "parquet", "eval", "psych-ds", "otel", "hf"]

_OUT = options.with_brackets(
    options.OUT,
    "standard output, also with -; eval: a file for all agents, or a directory for one log of each; psych-ds, hf: a "
    "new directory",
)

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Format,
        typer.Option(
            help="csv, jsonl, parquet: a table; eval: a log for Inspect AI; psych-ds: a dataset of people; otel: "
            "OpenTelemetry traces (OTLP/JSON); hf: a directory for load_dataset."
        ),
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
    endpoint: Annotated[
        str | None, typer.Option(metavar="URL", help="otel: also send the traces there (OTLP/HTTP).")
    ] = None,
    start: Annotated[
        str | None, typer.Option(metavar="TIME", help="otel: start of the first trace (2000-01-01T00:00:00Z).")
    ] = None,
    licence: Annotated[
        str | None, typer.Option(metavar="NAME", help="hf: the licence in the card, for example cc-by-4.0.")
    ] = None,
) -> None:
    """Export a study: tables of steps or trials, logs for Inspect AI's viewer, a Psych-DS dataset, or traces.

    A table FILE comes with its data dictionary, FILE-metadata.json, which describes every column.
    """
    if format != "psych-ds" and (everybody or platform_ids):
        raise BadValue("--format", format, "psych-ds with --all or --with-platform-ids")
    _refuse_elsewhere(format, "otel", endpoint=endpoint, start=start)
    _refuse_elsewhere(format, "hf", licence=licence)
    if format in ("eval", "psych-ds", "otel", "hf") and table != "steps":
        raise Conflict(f"--table {table}", f"--format {format}", "only csv, jsonl and parquet are single tables")
    if format == "otel":
        _export_traces(directory, out, endpoint, start)
        return
    if out is None or str(out) == "-":
        if format not in ("csv", "jsonl"):
            raise BadValue("--out", None, f"a file or a directory to write, because {format} is not text")
        write_rows(_rows(table, directory), sys.stdout, format)
        return
    refuse_study_file(out)
    if format == "psych-ds":
        written = write_dataset(directory, out, everybody=everybody, platform_ids=platform_ids)
    elif format == "hf":
        written = write_hub_dataset(load(directory), out, directory / ALBUM, licence)
    elif format == "eval":
        written = _write_logs(directory, out)
    else:
        written = write_table(_rows(table, directory), out, format)
    for path in written:
        print(path)


def _refuse_elsewhere(format_: Format, of: Format, **given: str | None) -> None:
    """Refuse options of one format with another format."""
    if format_ != of and any(value is not None for value in given.values()):
        names = " and ".join(f"--{name}" for name in given)
        raise BadValue("--format", format_, f"{of} with {names}")


def _rows(table: TableName, directory: Path) -> Rows:
    """A table of the trials in a directory, with the response times and durations of its participants."""
    trials, diaries = load(directory), read_diaries(directory)
    if not diaries:
        return rows_of(table, trials)
    study = read_study(directory)
    times = times_of_steps(study, trials, diaries, directory)
    return rows_of(table, trials, times, seconds_of_trials(study, diaries))


def _export_traces(directory: Path, out: Path | None, endpoint: str | None, start: str | None) -> None:
    if (out is None and endpoint is None) or str(out) == "-":
        raise BadValue("--out", None if out is None else str(out), "a file to write, or use --endpoint URL")
    if out is not None:
        refuse_study_file(out)
    if endpoint is not None:
        endpoints_of(endpoint)
    begins = EPOCH if start is None else _nanoseconds(start)
    study = read_study(directory).task_identity
    trials, calls = load(directory), list(read_calls(directory))
    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    if out is not None:
        for path in write_traces(trials, out, study, calls, seconds, begins):
            print(path)
    if endpoint is not None:
        send_traces(requests(trials, study, calls, seconds, begins), endpoint)
        print(f"sent {len(trials)} traces to {endpoint}")


def _nanoseconds(start: str) -> int:
    try:
        moment = datetime.fromisoformat(start)
        moment = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
        since = moment - datetime(1970, 1, 1, tzinfo=UTC)
    except (ValueError, OverflowError):
        raise BadValue("--start", start, "a time such as 2026-01-31T12:00:00Z") from None
    if not 0 <= since.days < 366 * 200:
        raise BadValue("--start", start, "a time from 1970 to 2169")
    return (since.days * 86_400 + since.seconds) * 10**9 + since.microseconds * 1000


def _write_logs(directory: Path, out: Path) -> list[Path]:
    from lockprobe.interfaces.inspect.write_log import write_logs

    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    return write_logs(load(directory), read_study(directory), out, pictures=directory / ALBUM, seconds=seconds)
