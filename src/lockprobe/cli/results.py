"""What a study directory holds: ``report``, ``export``."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.errors import BadFile, BadValue
from lockprobe.export import write_csv, write_jsonl, write_parquet
from lockprobe.export.writing import write_dataset
from lockprobe.people.acts import times_of_steps
from lockprobe.report import write_report
from lockprobe.studies.album import ALBUM
from lockprobe.studies.calls import ASKED, CALLS
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.settings import read_study

__all__ = ["export", "report"]

STUDY_FILES = ("study.json", "trials.jsonl", "timings.jsonl", CALLS, ASKED, "results.json")

Format = Literal["csv", "jsonl", "parquet", "eval", "psych-ds"]

_OUT = (
    "File to write; standard output otherwise. Of logs a file for all agents, or a directory for one log of each; of a "
    "dataset a new directory."
)

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]


def report(directory: Directory, json: AsJson = False) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records."""
    path = write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr), processes=2)
    if all(trial.owed_again for trial in load(directory)):
        print("Report: no trial has ended yet", file=sys.stderr)
    print(json_.dumps({"report": str(path)}) if json else f"Report: {path}")


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Format,
        typer.Option(
            help="csv, jsonl, parquet: tidy steps; eval: a log for Inspect AI; psych-ds: a dataset of people."
        ),
    ] = "csv",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
    everybody: Annotated[bool, typer.Option("--all", help="psych-ds: strategies' and models' trials too.")] = False,
    platform_ids: Annotated[
        bool,
        typer.Option("--with-platform-ids", help="psych-ds: IDs of the recruitment platform too; they are personal."),
    ] = False,
) -> None:
    """Tidy steps, one row a step, truth beside told; logs that Inspect AI's viewer reads; or a Psych-DS dataset."""
    if format != "psych-ds" and (everybody or platform_ids):
        raise BadValue("--format", format, "psych-ds, where --all and --with-platform-ids say something")
    if out is None:
        if format not in ("csv", "jsonl"):
            raise BadValue("--out", None, f"a file or a directory to write, since {format} is no text")
        trials = load(directory)
        (write_csv if format == "csv" else write_jsonl)(trials, sys.stdout, times_of_steps(directory, trials))
        return
    if out.resolve().parent == directory.resolve() and out.name in STUDY_FILES:
        raise BadFile(out, "a file of the study itself; choose another")
    if format == "psych-ds":
        written = write_dataset(directory, out, everybody=everybody, platform_ids=platform_ids)
    elif format == "eval":
        written = _write_logs(directory, out)
    else:
        written = []
        _write_steps(directory, format, out)
    for path in written:
        print(path)


def _write_logs(directory: Path, out: Path) -> list[Path]:
    from lockprobe.evals.writing import write_logs

    seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
    return write_logs(load(directory), read_study(directory), out, pictures=directory / ALBUM, seconds=seconds)


def _write_steps(directory: Path, format: Literal["csv", "jsonl", "parquet"], out: Path) -> None:  # noqa: A002
    trials = load(directory)
    times = times_of_steps(directory, trials)
    try:
        if format == "parquet":
            write_parquet(trials, out, times)
        else:
            with out.open("w", encoding="utf-8", newline="") as file:
                (write_csv if format == "csv" else write_jsonl)(trials, file, times)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from None
