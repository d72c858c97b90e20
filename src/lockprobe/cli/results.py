"""What a study directory holds: ``report``, ``export``."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.errors import BadFile, BadValue
from lockprobe.export import write_csv, write_jsonl, write_parquet
from lockprobe.report import write_report
from lockprobe.studies.album import ALBUM
from lockprobe.studies.calls import ASKED, CALLS
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.settings import read_study

__all__ = ["export", "report"]

STUDY_FILES = ("study.json", "trials.jsonl", "timings.jsonl", CALLS, ASKED, "results.json")

Format = Literal["csv", "jsonl", "parquet", "eval"]

_OUT = "File to write; standard output otherwise. Of logs a file for all agents, or a directory for one log of each."

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
        Format, typer.Option(help="csv, jsonl, parquet: tidy steps; eval: a log for Inspect AI.")
    ] = "csv",
    out: Annotated[Path | None, typer.Option(help=_OUT)] = None,
) -> None:
    """Tidy steps, one row a step, truth beside told; or logs that Inspect AI's viewer and dataframes read."""
    trials = load(directory)
    if out is None and format in ("csv", "jsonl"):
        (write_csv if format == "csv" else write_jsonl)(trials, sys.stdout)
        return
    if out is None:
        raise BadValue("--out", None, f"a file to write, since {format} is no text")
    if out.resolve().parent == directory.resolve() and out.name in STUDY_FILES:
        raise BadFile(out, "a file of the study itself; choose another")
    if format == "eval":
        from lockprobe.evals.writing import write_logs

        seconds = {timing.key: timing.seconds for timing in read_timings(directory)}
        for path in write_logs(trials, read_study(directory), out, pictures=directory / ALBUM, seconds=seconds):
            print(path)
        return
    try:
        if format == "parquet":
            write_parquet(trials, out)
        else:
            with out.open("w", encoding="utf-8", newline="") as file:
                (write_csv if format == "csv" else write_jsonl)(trials, file)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from None
