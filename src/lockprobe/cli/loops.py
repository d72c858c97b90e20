"""``lockprobe loops``: measures loops in action sequences."""

from __future__ import annotations

import json as json_
from typing import TYPE_CHECKING, Annotated

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.terminal_text import printable
from lockprobe.statistics.loops import Solver

if TYPE_CHECKING:
    from lockprobe.statistics.loops import LoopCover


def loops(
    file: Annotated[
        str, typer.Argument(metavar="[FILE|-]", help="One action sequence per line, also as a JSON array.")
    ] = "-",
    json: options.AsJson = False,
    solver: Annotated[Solver, typer.Option(help="dp: exact and fast; ilp: the paper's ILP.")] = "dp",
    overlap: options.Overlap = False,
    min_length: options.MinLength = 3,
) -> None:
    """Find action loops in sequences, one sequence per line (paper, Sec. 3.3)."""
    from lockprobe.cli.sequences import numbered_sequences
    from lockprobe.statistics.loops import cover

    for number, sequence in numbered_sequences(file):
        try:
            found = cover(sequence, solver=solver, overlap=overlap, min_length=min_length)
        except BadValue as error:
            raise BadFile(file, f"line {number}: {error}") from None
        print(json_.dumps(_row(found)) if json else _sentence(found))


def _row(found: LoopCover) -> dict[str, object]:
    return {
        "n": found.n,
        "any_loop": found.any_loop,
        "coverage": found.covered,
        "share": found.share,
        "words": [list(word) for word in found.words],
        "intervals": [list(piece) for piece in found.intervals],
    }


def _sentence(found: LoopCover) -> str:
    if not found.any_loop:
        return f"{found.n} actions: no loop"
    words = printable(", ".join(" ".join(map(str, word)) for word in found.words))
    places = ", ".join(f"{start}+{length}" for start, length in found.intervals)
    return f"{found.n} actions: {found.covered} in loops ({found.share:.0%}): {words} at {places}"
