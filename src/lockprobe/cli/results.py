"""What a study directory holds: ``status``, ``report``, ``export``."""

from __future__ import annotations

import json as json_
import sys
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.errors import BadFile
from lockprobe.export import write_csv, write_jsonl
from lockprobe.report import write_report
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.settings import read_study

__all__ = ["export", "report", "status"]

STUDY_FILES = ("study.json", "trials.jsonl", "timings.jsonl", "results.json")

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]


def status(directory: Directory, json: AsJson = False) -> None:
    """What is done, owed and failed (by boundary), and what it took."""
    study = read_study(directory)
    everything = load(directory)
    trials = [trial for trial in everything if study.asks_for(trial)]
    again = [trial for trial in trials if trial.owed_again]
    timings = read_timings(directory)
    seconds, steps = sum(t.seconds for t in timings), sum(t.steps for t in timings)
    usage = [step.decision.usage for trial in trials for step in trial.steps if step.decision.usage]
    facts: dict[str, object] = {
        "study": study.name,
        "trials": study.size,
        "done": len(trials) - len(again),
        "owed": study.size - len(trials) + len(again),
        "not_asked_for": len(everything) - len(trials),
        "solved": sum(trial.solved for trial in trials),
        "errors": dict(Counter(trial.error.boundary for trial in trials if trial.error)),
        "steps": steps,
        "pictures": len({name for trial in trials for name in trial.picture_names}),
        "seconds_playing": round(seconds, 1),
        "steps_per_minute": round(60 * steps / seconds, 1) if seconds else None,
        "calls": sum(u.calls for u in usage),
        "input_tokens": sum(u.input_tokens for u in usage),
        "output_tokens": sum(u.output_tokens for u in usage),
    }
    if json:
        print(json_.dumps(facts))
    else:
        for name, value in facts.items():
            print(f"{name.replace('_', ' ')}: {value if value != {} else 'none'}")


def report(directory: Directory, json: AsJson = False) -> None:
    """Write results.json, report.html, figures/ and tables/ from the records."""
    path = write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr))
    print(json_.dumps({"report": str(path)}) if json else f"Report: {path}")


def export(
    directory: Directory,
    format: Annotated[  # noqa: A002
        Literal["csv", "jsonl"], typer.Option(help="csv or jsonl.")
    ] = "csv",
    out: Annotated[Path | None, typer.Option(help="File to write; standard output otherwise.")] = None,
) -> None:
    """Tidy steps, one row a step, truth beside told."""
    write = write_csv if format == "csv" else write_jsonl
    trials = load(directory)
    if out is None:
        write(trials, sys.stdout)
    else:
        if out.resolve().parent == directory.resolve() and out.name in STUDY_FILES:
            raise BadFile(out, "a file of the study itself; choose another")
        try:
            with out.open("w", encoding="utf-8", newline="") as file:
                write(trials, file)
        except OSError as error:
            raise BadFile(out, f"cannot be written ({error.strerror})") from None
