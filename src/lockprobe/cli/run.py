"""``lockprobe run``: play what is owed of a study, then write its report."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli.display import watch
from lockprobe.errors import BadValue
from lockprobe.report import write_report
from lockprobe.studies.journal import Journal
from lockprobe.studies.runner import Limits
from lockprobe.studies.runner import run as play_study
from lockprobe.studies.study import LayoutKind, Study
from lockprobe.studies.studyfile import Request, parse_p, read_request, study

__all__ = ["run"]


PLANT = typer.Option(
    help="What is acted on: symbolic (flips), fast-twin (modalities) or twin; options as twin?looks=varied."
)
MODALITY = typer.Option(help="How the box is shown: symbolic, rgb, rgbd, rgbd?depth=height; may be repeated.")
LAYOUT = typer.Option(help="fixed, or shuffled: the same interlock on a panel dealt anew in every trial.")
WORKERS = typer.Option(min=1, help="Processes for local models and simulated plants (one a core).")


def run(
    name: Annotated[
        str,
        typer.Argument(metavar="flips|modalities|FILE.toml", help="The study; mechanisms.toml comes with the package."),
    ],
    agent: Annotated[list[str] | None, typer.Option(help="Agent spec; may be repeated.")] = None,
    box: Annotated[str | None, typer.Option(help="A box by name, random-N-SEED, or a TOML file.")] = None,
    p: Annotated[str | None, typer.Option(help="Flip probabilities, for example 0,0.2,0.4.")] = None,
    trials: Annotated[int | None, typer.Option(help="Trials per repetition and condition.")] = None,
    repetitions: Annotated[int | None, typer.Option(help="Repetitions.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of everything (1).")] = None,
    max_steps: Annotated[int | None, typer.Option(help="Budget of a trial in steps (20).")] = None,
    flip: Annotated[str | None, typer.Option(help="transient, sticky or outcome-only.")] = None,
    plant: Annotated[str | None, PLANT] = None,
    modality: Annotated[list[str] | None, MODALITY] = None,
    layout: Annotated[LayoutKind | None, LAYOUT] = None,
    shuffle: Annotated[
        bool | None,
        typer.Option("--shuffle/--no-shuffle", help="Shuffle labels and their listing per trial."),
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="The paper's 7 x 3 x 10 trials per agent (flips).")] = False,
    out: Annotated[Path | None, typer.Option(help="Directory of the study.")] = None,
    workers: Annotated[int | None, WORKERS] = None,
    connections: Annotated[int, typer.Option(min=1, help="Trials side by side for hosted models.")] = 10,
    json: Annotated[bool, typer.Option("--json", help="One JSON object a line.")] = False,
) -> None:
    """Play a study, or resume it, and write its report. The same command again resumes it.

    flips: what false reports do. Without options a short study of the embedded model beside random, round-robin and
    the human-inspired strategy; it ends in a few minutes on two cores.

    modalities: what pictures do. RGB, RGB-D and reports in words, 10 trials of 20 steps each, on a simulated box with
    a camera; without options a scripted agent that looks, beside the human-inspired strategy and random.
    """
    asked = {
        "agent": agent or None,
        "box": box,
        "p": None if p is None else parse_p(p),
        "trials": trials,
        "seed": seed,
        "repetitions": repetitions,
        "max_steps": max_steps,
        "flip": flip,
        "plant": plant,
        "modality": modality or None,
        "layout": layout,
        "shuffle": shuffle,
    }
    planned = _planned(name, asked | ({"full": True} if full else {}))
    directory = out or Path("lockprobe-runs") / f"{planned.name}-{planned.identity}"
    limits = Limits(workers=workers or min(os.cpu_count() or 1, 8), connections=connections)
    with Journal.open(directory, planned) as journal, watch(json=json) as observer:
        try:
            play_study(planned, journal, limits=limits, observer=observer)
        except KeyboardInterrupt:
            observer.interrupted(directory)
            raise
    observer.reported(write_report(directory, tell=lambda said: print(f"Report: {said}", file=sys.stderr)))


def _planned(name: str, asked: Mapping[str, object]) -> Study:
    """The study of a name or file, with what was asked for on the command line before it."""
    if (flip := asked["flip"]) not in (None, "transient", "sticky", "outcome-only"):
        raise BadValue("flip", flip, "one of transient, sticky, outcome-only")
    request = read_request(Path(name)) if name.endswith(".toml") else Request(study=name)
    return study(request.model_copy(update={key: value for key, value in asked.items() if value is not None}))
