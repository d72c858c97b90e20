"""``lockprobe loops`` and ``lockprobe chance``: action loops in sequences, and chance levels of the loop measures."""

from __future__ import annotations

import json as json_
import re
import sys
from itertools import chain
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.cli import options
from lockprobe.foundation.errors import BadFile, BadValue, Conflict
from lockprobe.foundation.formatting import count
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.terminal_text import printable
from lockprobe.statistics.loops import Solver, cover


def loops(
    file: Annotated[
        str, typer.Argument(metavar="[FILE|-]", help="One action sequence per line, also as a JSON array.")
    ] = "-",
    json: options.AsJson = False,
    solver: Annotated[Solver, typer.Option(help="dp: exact and fast; ilp: the paper's ILP.")] = "dp",
) -> None:
    """Find action loops in sequences, one sequence per line (paper, Sec. 3.3)."""
    for number, sequence in _sequences(file):
        try:
            found = cover(sequence, solver=solver)
        except BadValue as error:
            raise BadFile(file, f"line {number}: {error}") from None
        if json:
            facts = {"any_loop": found.any_loop, "coverage": found.covered, "share": found.share}
            print(json_.dumps({"n": found.n, **facts, "words": found.words, "intervals": found.intervals}))
        elif not found.any_loop:
            print(f"{found.n} actions: no loop")
        else:
            words = printable(", ".join(" ".join(map(str, word)) for word in found.words))
            places = ", ".join(f"{start}+{length}" for start, length in found.intervals)
            print(f"{found.n} actions: {found.covered} in loops ({found.share:.0%}): {words} at {places}")


def chance(
    length: Annotated[int | None, typer.Option(min=0, max=10_000, help="Length of the trial in steps (20).")] = None,
    actions: Annotated[int, typer.Option(min=1, max=64, help=options.ACTIONS)] = 4,
    null: Annotated[
        Literal["uniform", "no-repeat"], typer.Option(help="Any action, or any except the one before.")
    ] = "uniform",
    sequences: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|-", help="One action sequence per line: the loop rate expected in trials of these lengths."
        ),
    ] = None,
    json: options.AsJson = False,
) -> None:
    """Compute the probability of an action loop in a trial of random choices of this length."""
    from lockprobe.statistics.loops.chance import chance_level, expected_loop_rate

    if sequences is not None:
        if length is not None:
            raise Conflict("--length", "--sequences", "the sequences have their own lengths")
        if not (trials := [sequence for _, sequence in _sequences(sequences)]):
            raise BadFile(sequences, "holds no action sequence")
        if (seen := len(set(chain.from_iterable(trials)))) > actions:
            raise BadFile(sequences, f"all lines: {seen} distinct actions, but --actions is {actions}")
        level = expected_loop_rate(((len(trial), actions) for trial in trials), null)
        setting = f"{null}, the lengths of {len(trials)} trials"
    else:
        length = 20 if length is None else length
        level = chance_level(length, actions, null=null)
        setting = f"{null}, {length} steps, {actions} joints"
    if json:
        print(json_.dumps({"probability": level.probability, "method": level.method, "error": level.error}))
    else:
        doubt = "" if level.method == "exact" else f" ± {level.error:.4f}"
        print(f"{level.probability:.4f}{doubt} ({level.method}; {setting})")


def _sequences(file: str) -> list[tuple[int, tuple[str, ...]]]:
    """The sequences in a file (``-``: standard input), one a line, with their line numbers.

    Empty lines are skipped, and their number is printed on standard error.
    """
    try:
        content = sys.stdin.buffer.read() if file == "-" else read_input(Path(file))
        lines = re.split(r"\r\n|\n|\r", content.decode("utf-8-sig"))
    except (AttributeError, UnicodeDecodeError):  # standard input is closed, or something else
        raise BadFile(file, "not text in UTF-8") from None
    found = []
    for number, line in enumerate(lines if lines[-1] else lines[:-1], 1):
        try:
            found.append((number, parse_sequence(line)))
        except BadValue as error:
            raise BadFile(file, f"line {number}: {error}") from None
    if empty := sum(not sequence for _, sequence in found):
        print(f"{count(empty, 'empty line')} skipped", file=sys.stderr)
    return [(number, sequence) for number, sequence in found if sequence]


_ACTION = re.compile(r"[+-]?[^\W_][\w'+-]*")


def parse_sequence(line: str) -> tuple[str, ...]:
    """One trial: a JSON array of names or whole numbers, or actions with blanks or commas between them.

    A line without either has one action per character: ``ABCABC`` is six (and ``slider1`` seven: write ``slider1,`` for
    a trial of that one action). A line is refused if punctuation would be an action or part of one.
    """
    text = line.strip()
    if text.startswith("["):
        try:
            found = json_.loads(text)
        except (ValueError, RecursionError):
            found = [None]
        if {*map(type, found)} in ({str}, {int}, set()):
            return tuple(map(str, found))
    else:
        found = [part for part in re.split(r"[\s,]+", text) if part] if re.search(r"[\s,]", text) else [*text]
        if all(map(_ACTION.fullmatch, found)):
            return tuple(found)
    expected = 'actions with blanks or commas between them, or a JSON array such as ["A", "B"]'
    raise BadValue("sequence", text if len(text) <= 40 else f"{text[:39]}…", expected)
