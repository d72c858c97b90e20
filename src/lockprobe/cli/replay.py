"""``lockprobe replay``: shows a finished trial step by step, in words or as a film."""

from __future__ import annotations

import json as json_
import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lockprobe.cli import options
from lockprobe.cli.robot_tools import robot_tool
from lockprobe.foundation.errors import BadValue, TrialFault, UnknownName, UserMistake
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.records.read_records import load
from lockprobe.trial.record import Step, Trial
from lockprobe.trial.source import CAMERA, VERDICT, SourceKind, camera_outcomes, verdict_outcomes, wrong_source
from lockprobe.trial.told_outcome import in_words

_MEGABYTE = 1_000_000

_FASTEST = 16

_PATIENCE = 2.0
"""Seconds between two lines of progress."""


def replay(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")],
    key: Annotated[str, typer.Argument(help="Key of a trial, or its beginning or end.")],
    out: Annotated[
        Path | None,
        typer.Option(
            help=options.with_brackets(options.OUT, "a film: FILE.gif, FILE.mp4, or a directory for single pictures")
        ),
    ] = None,
    seen: Annotated[
        bool, typer.Option("--seen", help="Film the pictures that the agent saw, from the study's directory.")
    ] = False,
    speed: Annotated[int, typer.Option(min=1, max=_FASTEST, help="Playback speed of a robot.")] = 1,
    json: options.AsJson = False,
) -> None:
    """Show a finished trial step by step, truth and report, or with --out as a film."""
    trials = load(directory)
    found = [t for t in trials if t.key == key] or [t for t in trials if t.key.startswith(key) or t.key.endswith(key)]
    if not found:
        raise UnknownName("trial", key, [t.key for t in trials[:12]])
    trial = found[0]
    if out is None:
        if seen:
            raise BadValue("--out", None, "FILE.gif, FILE.mp4 or a directory, because of --seen")
        for line in _story(trial, json=json):
            print(printable(line))
        return
    make_film = robot_tool("film", "films")
    try:
        film = make_film(directory, trial, out, seen=seen, speed=speed, tell=_Progress())
    except TrialFault as fault:
        raise UserMistake(f"no film: the trial breaks when it is played again ({fault})") from None
    if film.note:
        print(printable(film.note), file=sys.stderr)
    _announce(film, trial, json=json)


class _Progress:
    """Prints a line of progress at most every few seconds."""

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, said: str) -> None:
        if (now := time.monotonic()) - self._last >= _PATIENCE:
            print(f"Film: {said}", file=sys.stderr, flush=True)
            self._last = now


def _announce(film: Any, trial: Trial, *, json: bool) -> None:
    size = sum(part.stat().st_size for part in (film.path.iterdir() if film.path.is_dir() else (film.path,)))
    facts: dict[str, object] = {
        "film": str(film.path),
        "pictures": film.pictures,
        "bytes": size,
        "plant": film.plant or None,
        "differs": film.differs,
    }
    if film.differs is not None:
        print(printable(f"lockprobe: {film.differs}"), file=sys.stderr)
    if json:
        print(json_.dumps(facts))
        return
    agrees = f", every one of {len(trial.steps)} steps as recorded" if film.plant and film.differs is None else ""
    megabytes = f"{size / 1e6:.2g} MB" if size >= _MEGABYTE / 10 else f"{size / 1e3:.0f} kB"
    print(f"Film: {film.path} ({film.pictures} pictures, {megabytes}{agrees})")


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
                    "claimed": said,
                    "hypothesis": s.decision.hypothesis,
                    **{name: s.sensed[name] for name in (VERDICT, CAMERA) if name in s.sensed},
                }
            )
            for s, said in zip(trial.steps, trial.said, strict=True)
        ]
    labels = ", ".join(f"{j}={label}" for j, label in zip(trial.joints, trial.labels, strict=True))
    lines = [
        f"{trial.key}: {trial.ending} after {len(trial.steps)} steps; target {trial.target}, labels {labels}",
        "step  state  joint             truth         told                   then said of it",
    ]
    lines += [
        f"{s.step:4}  {s.state:5}  {s.joint:16}  {in_words(s.moved):12}  {_told(s):21}  "
        f"{in_words(said, ''):12}{_remark(s, wrong, sensed)}".rstrip()
        for s, said, wrong, sensed in zip(
            trial.steps, trial.said, wrong_source(trial), _sensed_otherwise(trial), strict=True
        )
    ]
    if trial.error:
        lines.append(f"error at {trial.error.boundary}: {trial.error.message}")
    return lines


def _told(step: Step) -> str:
    return f"{in_words(step.told_moved):12} {'<- false' * step.told_falsely}"


def _remark(step: Step, wrong: SourceKind | None, sensed: str) -> str:
    """Which source made a report false, and what arm or camera took a step for if that was not the truth."""
    why = f"the {wrong} is wrong" if step.told_falsely and wrong is not None else ""
    return "".join(f"  {said}" for said in (why, sensed) if said)


def _sensed_otherwise(trial: Trial) -> list[str]:
    """For each step the outcome by the arm's verdict and by the camera where it is not the true one."""
    found = [""] * len(trial.steps)
    for name, outcomes in ((VERDICT, verdict_outcomes(trial)), (CAMERA, camera_outcomes(trial))):
        unknown = "failed" if name == VERDICT else "unclear"
        for i, (step, moved) in enumerate(zip(trial.steps, outcomes, strict=True)):
            if name in step.sensed and moved != step.moved:
                found[i] += f"{', ' if found[i] else ''}{name}: {in_words(moved, unknown)}"
    return [f"({said})" if said else "" for said in found]
