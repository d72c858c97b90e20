"""``lockprobe chance``: chance levels of the loop measures."""

from __future__ import annotations

import json as json_
from itertools import chain
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.sequences import MOST_ACTIONS, check_actions, read_sequences
from lockprobe.foundation.errors import BadFile, BadValue, Conflict
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.statistics.loops.null_models import TrialNull, expected_loop_rate

__all__ = ["chance"]


def chance(
    length: Annotated[int | None, typer.Option(min=0, max=10_000, help="Length of the trial in steps (20).")] = None,
    actions: Annotated[int, typer.Option(min=1, max=MOST_ACTIONS, help=options.ACTIONS)] = 4,
    null: Annotated[
        TrialNull, typer.Option(help="The null model; markov and permutation need --sequences.")
    ] = "uniform",
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
    match null, sequences:
        case _, str(file):
            if length is not None:
                raise Conflict("--length", "--sequences", "the sequences have their own lengths")
            if not (trials := read_sequences(file)):
                raise BadFile(file, "holds no action sequence")
            if null in {"uniform", "no-repeat"}:
                check_actions(file, "all lines", len(set(chain.from_iterable(trials))), actions)
            level = expected_loop_rate(trials, null, actions=actions, overlap=overlap, min_length=min_length)
            setting = f"{null}, the lengths of {len(trials)} trials"
        case "uniform" | "no-repeat", None:
            length = 20 if length is None else length
            level = chance_level(length, actions, null=null, overlap=overlap, min_length=min_length)
            setting = f"{null}, {length} steps, {actions} joints"
        case _:
            raise BadValue("--sequences", None, f"a file of action sequences, or -: --null {null} needs it")
    if json:
        print(json_.dumps({"probability": level.probability, "method": level.method, "error": level.error}))
    else:
        doubt = "" if level.method == "exact" else f" ± {level.error:.4f}"
        print(f"{level.probability:.4f}{doubt} ({level.method}; {setting})")
