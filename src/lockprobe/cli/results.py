"""What a study directory holds: ``status``, ``report``, ``export``, ``replay``."""

from __future__ import annotations

import json as json_
import sys
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.errors import BadFile, UnknownName
from lockprobe.export import write_csv, write_jsonl
from lockprobe.record import Trial
from lockprobe.report import write_report
from lockprobe.studies.journal import load, read_timings
from lockprobe.studies.settings import read_study

__all__ = ["export", "replay", "report", "status"]

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


def replay(
    directory: Directory,
    key: Annotated[str, typer.Argument(help="Key of a trial, or the start or end of one.")],
    json: AsJson = False,
) -> None:
    """A finished trial, step by step, truth beside told."""
    trials = load(directory)
    found = [t for t in trials if t.key == key] or [t for t in trials if t.key.startswith(key) or t.key.endswith(key)]
    if not found:
        raise UnknownName("trial", key, [t.key for t in trials[:12]])
    for line in _story(found[0], json=json):
        print(line)


def _story(trial: Trial, *, json: bool) -> list[str]:
    if json:
        return [
            json_.dumps(
                {
                    "step": s.step,
                    "state": s.state,
                    "joint": s.joint,
                    "moved": s.moved,
                    "told_moved": s.told_moved,
                    "told_state": s.told_state,
                    "told": s.told,
                    "claimed": s.decision.claimed,
                    "hypothesis": s.decision.hypothesis,
                }
            )
            for s in trial.steps
        ]
    labels = ", ".join(f"{j}={label}" for j, label in zip(trial.joints, trial.labels, strict=True))
    lines = [
        f"{trial.key}: {trial.ending} after {len(trial.steps)} steps; target {trial.target}, labels {labels}",
        "step  state  joint             truth         told          then claimed",
    ]
    words = {True: "moved", False: "did not move"}
    for i, s in enumerate(trial.steps):
        later = trial.steps[i + 1].decision.claimed if i + 1 < len(trial.steps) else None
        said = {"moved": "moved", "blocked": "did not move", None: ""}[later]
        lines.append(
            f"{s.step:4}  {s.state:5}  {s.joint:16}  {words[s.moved]:12}  "
            f"{words[s.told_moved]:12}  {said}{'  <- flipped' if s.moved != s.told_moved else ''}"
        )
    if trial.error:
        lines.append(f"error at {trial.error.boundary}: {trial.error.message}")
    return lines
