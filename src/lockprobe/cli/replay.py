"""``lockprobe replay``: shows a finished trial step by step, in words or as a film."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import TrialFault, UnknownName, UserMistake
from lockprobe.foundation.plugins import robot_plugin
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.records.read_records import load
from lockprobe.trial.record import Trial, in_words
from lockprobe.trial.source import CAMERA, VERDICT, outcomes_by, source_of


def replay(
    directory: options.Directory,
    key: Annotated[str, typer.Argument(help="Key of a trial, or its beginning or end.")],
    out: Annotated[Path | None, typer.Option(help=options.with_brackets(options.OUT, "a film: FILE.gif"))] = None,
) -> None:
    """Show a finished trial step by step, truth and report, or with --out as a film."""
    trials = load(directory)
    found = [t for t in trials if t.key == key] or [t for t in trials if t.key.startswith(key) or t.key.endswith(key)]
    if not found:
        raise UnknownName("trial", key, [t.key for t in trials[:12]])
    trial = found[0]
    if out is None:
        for line in _story(trial):
            print(printable(line))
        return
    make_film = robot_plugin("tool", "film", "films need").load()
    try:
        film = make_film(directory, trial, out, tell=lambda said: print(f"Film: {said}", file=sys.stderr, flush=True))
    except TrialFault as fault:
        raise UserMistake(f"the film ends where the trial breaks when it is played again ({fault})") from None
    if film.note:
        print(printable(film.note), file=sys.stderr)
    if film.differs is not None:
        print(printable(f"lockprobe: {film.differs}"), file=sys.stderr)
    size = out.stat().st_size
    agrees = f", every one of {len(trial.steps)} steps as recorded" if film.differs is None else ""
    megabytes = f"{size / 1e6:.2g} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"
    print(f"Film: {out} ({film.pictures} pictures, {megabytes}{agrees})")


def _story(trial: Trial) -> Iterator[str]:
    """The trial, and every step with its truth and its report.

    A remark says which source made a report false, and what arm or camera took a step for if that was not the truth.
    """
    labels = ", ".join(f"{j}={label}" for j, label in zip(trial.joints, trial.labels, strict=True))
    told = f"{trial.ending} after {len(trial.steps)} steps"
    yield f"{trial.key}: {told}; box {trial.box}, target {trial.target}, labels {labels}"
    yield "step  state  joint             truth         told                   then said of it"
    outcomes = {VERDICT: (outcomes_by(VERDICT, trial), "failed"), CAMERA: (outcomes_by(CAMERA, trial), "unclear")}
    source = source_of(trial.modality)
    for i, (step, said) in enumerate(zip(trial.steps, trial.said, strict=True)):
        wrong = source in outcomes and bool(outcomes[source][0][i]) != step.moved
        sensed = [
            f"{name}: {in_words(moved[i], unknown)}"
            for name, (moved, unknown) in outcomes.items()
            if name in step.sensed and moved[i] != step.moved
        ]
        remark = f"  the {source} is wrong" if step.told_falsely and wrong else ""
        remark += f"  ({', '.join(sensed)})" if sensed else ""
        told = f"{in_words(step.told_moved):12} {'<- false' * step.told_falsely}"
        line = f"{step.step:4}  {step.state:5}  {step.joint:16}  {in_words(step.moved):12}  {told:21}  "
        yield f"{line}{in_words(said, ''):12}{remark}".rstrip()
    if trial.error:
        yield f"error at {trial.error.boundary}: {trial.error.message}"
