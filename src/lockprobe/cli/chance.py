"""``lockprobe chance``: chance levels of the loop measures."""

from __future__ import annotations

import json as json_
from itertools import chain
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.sequences import MOST_ACTIONS, check_actions, read_sequences
from lockprobe.foundation.errors import BadFile, Conflict
from lockprobe.statistics.loops.chance import Null, chance_level, expected_loop_rate


def chance(
    length: Annotated[int | None, typer.Option(min=0, max=10_000, help="Length of the trial in steps (20).")] = None,
    actions: Annotated[int, typer.Option(min=1, max=MOST_ACTIONS, help=options.ACTIONS)] = 4,
    null: Annotated[Null, typer.Option(help="Any action, or any except the one before.")] = "uniform",
    overlap: options.Overlap = False,
    min_length: options.MinLength = 3,
    sequences: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|-", help="One action sequence per line: the loop rate expected in trials of these lengths."
        ),
    ] = None,
    json: options.AsJson = False,
) -> None:
    """Compute the probability of an action loop in a trial of random choices of this length."""
    if sequences is not None:
        if length is not None:
            raise Conflict("--length", "--sequences", "the sequences have their own lengths")
        if not (trials := read_sequences(sequences)):
            raise BadFile(sequences, "holds no action sequence")
        check_actions(sequences, "all lines", len(set(chain.from_iterable(trials))), actions)
        level = expected_loop_rate(trials, null, actions=actions, overlap=overlap, min_length=min_length)
        setting = f"{null}, the lengths of {len(trials)} trials"
    else:
        length = 20 if length is None else length
        level = chance_level(length, actions, null=null, overlap=overlap, min_length=min_length)
        setting = f"{null}, {length} steps, {actions} joints"
    if json:
        print(json_.dumps({"probability": level.probability, "method": level.method, "error": level.error}))
    else:
        doubt = "" if level.method == "exact" else f" ± {level.error:.4f}"
        print(f"{level.probability:.4f}{doubt} ({level.method}; {setting})")
