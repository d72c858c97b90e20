"""``lockprobe report``: writes the report of a study directory."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.report import write_report
from lockprobe.studies.journal import load

__all__ = ["report"]

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]


def report(directory: Directory, json: AsJson = False) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records."""
    path = write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr), processes=2)
    if all(trial.owed_again for trial in load(directory)):
        print("Report: no trial has ended yet", file=sys.stderr)
    print(json_.dumps({"report": str(path)}) if json else f"Report: {path}")
