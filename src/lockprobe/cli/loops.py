"""``lockprobe loops`` and ``lockprobe chance``: action loops in sequences, and chance levels of the loop measures."""

from __future__ import annotations

import json as json_
import re
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.inputs import read_input
from lockprobe.statistics.loops import Solver, cover


def loops(
    file: Annotated[str, typer.Argument(metavar="[FILE|-]", help="One action sequence per line.")] = "-",
    json: options.AsJson = False,
    solver: Annotated[Solver, typer.Option(help="dp: exact and fast; ilp: the paper's ILP.")] = "dp",
) -> None:
    """Find action loops in sequences, one sequence per line (paper, Sec. 3.3). Empty lines are skipped."""
    try:
        content = sys.stdin.buffer.read() if file == "-" else read_input(Path(file))
        lines = re.split(r"\r\n|\n|\r", content.decode("utf-8-sig"))
    except (AttributeError, UnicodeDecodeError):  # standard input is closed, or something else
        raise BadFile(file, "not text in UTF-8") from None
    for number, line in enumerate(lines, 1):
        try:
            if not (sequence := parse_sequence(line)):
                continue
            found = cover(sequence, solver=solver)
        except BadValue as error:
            raise BadFile(file, f"line {number}: {error}") from None
        if json:
            facts = {"any_loop": found.any_loop, "coverage": found.covered, "share": found.share}
            print(json_.dumps({"n": found.n, **facts, "words": found.words, "intervals": found.intervals}))
        elif not found.any_loop:
            print(f"{found.n} actions: no loop")
        else:
            words = ", ".join(" ".join(map(str, word)) for word in found.words)
            places = ", ".join(f"{start}+{length}" for start, length in found.intervals)
            print(f"{found.n} actions: {found.covered} in loops ({found.share:.0%}): {words} at {places}")


def chance(
    length: Annotated[int, typer.Option(min=0, max=10_000, help="Length of the trial in steps.")] = 20,
    actions: Annotated[int, typer.Option(min=1, max=64, help="Number of different actions.")] = 4,
    null: Annotated[
        Literal["uniform", "no-repeat"], typer.Option(help="Any action, or any except the one before.")
    ] = "uniform",
    json: options.AsJson = False,
) -> None:
    """Compute the probability of an action loop in a trial of random choices of this length."""
    from lockprobe.statistics.loops.chance import chance_level

    level = chance_level(length, actions, null=null)
    if json:
        print(json_.dumps({"probability": level.probability, "method": level.method, "error": level.error}))
    else:
        doubt = "" if level.method == "exact" else f" ± {level.error:.4f}"
        print(f"{level.probability:.4f}{doubt} ({level.method}; {null}, {length} steps, {actions} joints)")


_ACTION = re.compile(r"[+-]?[^\W_][\w'+-]*")


def parse_sequence(line: str) -> tuple[str, ...]:
    """One trial: actions with blanks or commas between them.

    A line without either has one action per character: ``ABCABC`` is six (and ``slider1`` seven: write ``slider1,`` for
    a trial of that one action). A line is refused if punctuation would be an action or part of one.
    """
    text = line.strip()
    found = [part for part in re.split(r"[\s,]+", text) if part] if re.search(r"[\s,]", text) else [*text]
    if all(map(_ACTION.fullmatch, found)):
        return tuple(found)
    shown = text if len(text) <= 40 else f"{text[:39]}…"
    raise BadValue("sequence", shown, "actions with blanks or commas between them")
