"""``lockprobe learn``: trains a small network that plays as ``learner:FILE``."""

from __future__ import annotations

import json as json_
import time
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from lockprobe.agents.network.network import HIDDEN
from lockprobe.agents.network.network_file import load, save
from lockprobe.agents.network.training import SCHEDULE, TrainingSettings, success, train
from lockprobe.boxes.families import box as find_box
from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.cli.printing import time_left
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.terminal_text import printable

__all__ = ["learn"]

_TRIALS = 10_000

Box = Annotated[str | None, typer.Option(help=options.with_brackets(options.BOX, "new boxes of --joints"))]
Schedule = Annotated[int, typer.Option(help="Updates over which the learning rate falls.")]
ToldLies = Annotated[bool, typer.Option("--told-lies", help="Train with false reports, at rates from 0 to 1.")]


def learn(
    out: Annotated[Path, typer.Option(metavar="FILE", help=options.with_brackets(options.OUT, "a file"))],
    updates: Annotated[int, typer.Option(help="Number of updates, each on 256 new boxes.")] = SCHEDULE,
    joints: Annotated[int, typer.Option(help=options.with_brackets(options.JOINTS, "2 to 8"))] = 4,
    box: Box = None,
    hidden: Annotated[int, typer.Option(help="Units of the network, 1 to 256.")] = HIDDEN,
    seed: options.Seed = 1,
    schedule: Schedule = SCHEDULE,
    told_lies: ToldLies = False,
    json: options.AsJson = False,
) -> None:
    """Train a small recurrent network to open boxes that it has never seen, and write it to a file.

    The same command writes the same file. lockprobe run flips --agent learner:FILE plays it. With --box it is trained
    on that box alone, whose joints are reassigned each time. False reports help a learner after few updates and hurt it
    after many; see docs/learner.md.
    """
    if not out.parent.is_dir():
        raise BadFile(out, "its directory does not exist")
    if out.is_dir():
        raise BadFile(out, "is a directory, not a file: choose another name")
    refuse_study_file(out)
    only = None if box is None else find_box(box)
    schooling = TrainingSettings(
        updates=updates,
        joints=joints if only is None else len(only.names),
        hidden=hidden,
        seed=seed,
        told_lies=told_lies,
        schedule=schedule,
        box=only,
    )
    tell, began = time_left("updates"), time.monotonic()
    for done, network in enumerate(train(schooling), 1):
        tell(done, updates)
        if done == updates:
            save(out, network, schooling)
    seconds = time.monotonic() - began
    learned = load(out)
    shares = {
        name: success(learned.network, boxes=_TRIALS, temperature=temperature, only=only)
        for name, temperature in (("greedy", 0.0), ("sampled", 1.0))
    }
    if json:
        facts = learned.trained.model_dump() | {"sha256": learned.sha256, "seconds": seconds, "success": shares}
        print(json_.dumps({"file": str(out)} | facts))
        return
    what = "boxes that it has never seen" if only is None else f"trials on {only.name}"
    print(f"{out}: {updates} updates in {seconds:.0f} s, sha256 {learned.sha256[:16]}")
    print(
        f"Told the truth, it opens {percent(shares['greedy'])} of {_TRIALS} {what} within 20 steps if it takes the "
        f"likeliest joint (temperature=0), {percent(shares['sampled'])} if it draws."
    )
    print(printable(f"Play it: lockprobe run flips --agent {quote(f'learner:{out}')}"))
