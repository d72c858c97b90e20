"""``lockprobe report``: writes the report of a study directory."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli.suite import report_suite
from lockprobe.cli.watch_report import owed_trials, watch_report
from lockprobe.errors import BadValue
from lockprobe.report import write_report
from lockprobe.studies.journal import load
from lockprobe.studies.suites import is_suite

__all__ = ["report"]

_WATCH = "Write it again while the study runs, until all planned trials are finished or Ctrl-C."

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study or a suite.")]
Watch = Annotated[bool, typer.Option("--watch", help=_WATCH)]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object; with --watch one for each report, in a line.")]


def report(directory: Directory, watch: Watch = False, json: AsJson = False) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records; of a suite, suite.json and suite.html."""
    if is_suite(directory):
        if watch:
            raise BadValue("watch", str(directory), "the directory of a study, not of a suite")
        report_suite(directory, json=json)
        return
    if not watch:
        _write(directory, json=json)
        return
    try:
        watch_report(directory, lambda: _write(directory, json=json))
    except KeyboardInterrupt:
        print(f"Report: stopped by Ctrl-C; trials still owed: {owed_trials(directory)}", file=sys.stderr)


def _write(directory: Path, *, json: bool) -> None:
    path = write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr), processes=2)
    if all(trial.owed_again for trial in load(directory)):
        print("Report: no trial has ended yet", file=sys.stderr)
    print(json_.dumps({"report": str(path)}) if json else f"Report: {path}", flush=True)
