"""A trial in the terminal, played by whoever sits there."""

from __future__ import annotations

import asyncio
import secrets
from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.agents.participant import participant_spec
from lockprobe.cli.keys import Keys
from lockprobe.cli.person import Ended, Left, Person, ViewKind
from lockprobe.cli.play_summary import tell
from lockprobe.cli.printing import Screen
from lockprobe.errors import BadFile, BadValue
from lockprobe.inputs import check_regular
from lockprobe.interventions.condition import flips
from lockprobe.interventions.flip import FlipKind
from lockprobe.lockbox.families import DEFAULT_BOX, find_box
from lockprobe.plan import Names, Plan
from lockprobe.record import Trial
from lockprobe.spec import PEOPLE
from lockprobe.storage.jsonl import LineFile
from lockprobe.studies.play import play_timed
from lockprobe.studies.single import run_trial
from lockprobe.studies.study import LayoutKind, Study
from lockprobe.trial_json import trial_to_json

__all__ = ["OTHERS", "play"]

OTHERS = ("ideal-observer", "human-inspired", "random")
"""Who plays the same trial afterwards."""

_SEEDS = 10_000
"""A seed that nobody asked for is one of so many."""


def play(
    box: Annotated[str, typer.Option(help="A box by name, random-N-SEED, or a TOML file.")] = DEFAULT_BOX,
    p: Annotated[float, typer.Option(help="Flip rate: how often reports are false.")] = 0.0,
    flip: Annotated[FlipKind, typer.Option(help="What becomes of a false report.")] = "transient",
    seed: Annotated[int | None, typer.Option(help="Seed of everything; drawn where it is left out.")] = None,
    max_steps: Annotated[int, typer.Option(help="Budget in steps.")] = 20,
    layout: Annotated[LayoutKind, typer.Option(help="fixed, or shuffled: joints dealt anew to the panel.")] = "fixed",
    shuffle: Annotated[bool, typer.Option("--shuffle/--no-shuffle", help="Shuffle labels and their listing.")] = True,
    assessment: Annotated[
        bool, typer.Option("--assessment/--no-assessment", help="Ask what the last action did.")
    ] = True,
    view: Annotated[ViewKind, typer.Option(help="Reports drawn, or as the text that models read.")] = "panel",
    record: Annotated[
        Path | None, typer.Option(metavar="FILE.jsonl", help="Append the trial to this file, as studies record it.")
    ] = None,
) -> None:
    """Play a trial yourself, with keys: the same box, reports and budget as any agent; then see what was true."""
    seed = secrets.randbelow(_SEEDS) if seed is None else seed
    if record is not None:
        _check_record(record)
    study = Study(
        name="trial", agents=(PEOPLE,), box=find_box(box), conditions=flips((p,), flip), repetitions=1, trials=1,
        max_steps=max_steps, seed=seed, shuffle=shuffle, layout=layout, assessment=assessment,
    )  # fmt: skip
    plan = study.plan(participant_spec("local"), study.conditions[0], 1, 1)
    screen = Screen()
    screen.say(f"Lockbox (--seed {seed} plays this trial again)", "bold")
    try:
        trial = _played(plan, view, screen)
    except Ended:
        screen.say("The input ended before the trial did; nothing is kept.")
        raise typer.Exit(1) from None
    except Left:
        screen.say("Stopped; nothing is kept.")
        return
    except KeyboardInterrupt:
        screen.say()
        raise
    if record is not None:
        _append(record, trial)
    others = {spec: _of(spec, study) for spec in OTHERS}
    tell(screen, trial, plan.box, others)
    if record is not None:
        screen.say(f"Recorded: {record}")


def _played(plan: Plan, view: ViewKind, screen: Screen) -> Trial:
    """Not through asyncio.run: it would keep Ctrl-C to itself while a key is waited for."""
    loop = asyncio.new_event_loop()
    try:
        with Keys() as keys:
            person = Person(plan.box, Names(plan).labels, view, keys, screen)
            return loop.run_until_complete(play_timed(plan, person, lambda key, step: None))[0]
    finally:
        loop.close()


def _of(spec: str, study: Study) -> Trial | None:
    """A strategy in the same trial; None if the box is too large for it."""
    try:
        return run_trial(
            agent=spec, box=study.box, p=study.p[0], flip=study.flip, seed=study.seed, max_steps=study.max_steps,
            shuffle=study.shuffle, layout=study.layout, assessment=study.assessment,
        )  # fmt: skip
    except BadValue:
        return None


def _check_record(path: Path) -> None:
    """Refuse a file to which nothing could be appended after the trial, and leave none behind."""
    if not path.absolute().parent.is_dir():
        raise BadFile(path, "its directory does not exist")
    check_regular(path)
    there = path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise BadFile(path, f"cannot be written ({error.strerror})") from None
    if not there:
        path.unlink()


def _append(path: Path, trial: Trial) -> None:
    with closing(LineFile(path)) as file:
        if not file.left.tail.endswith(b"\n") and file.left.size:
            file.append(b"")  # a last line without its end is ended, so that this one starts clean
        file.append(trial_to_json(trial))
