"""``lockprobe loops`` and ``lockprobe chance``."""

from __future__ import annotations

import json as json_
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.analysis.chance import chance_level
from lockprobe.analysis.loops import LoopCover, Rule, Solver, cover, longest_loop, onset, parse_sequence
from lockprobe.errors import BadFile, BadValue

__all__ = ["chance", "loops"]


def loops(
    file: Annotated[str, typer.Argument(metavar="[FILE|-]", help="One action sequence a line.")] = "-",
    json: Annotated[bool, typer.Option("--json", help="One JSON object a line.")] = False,
    solver: Annotated[Solver, typer.Option(help="Exact and fast, or the paper's ILP.")] = "dp",
    rule: Annotated[Rule, typer.Option("--cover", help="What a cover may select.")] = "free",
    overlap: Annotated[bool, typer.Option("--overlap", help="Two occurrences may overlap.")] = False,
    min_length: Annotated[int, typer.Option(min=1, help="Shortest loop in actions.")] = 3,
) -> None:
    """Action loops in sequences, one sequence a line (paper, Sec. 3.3)."""
    empty = 0
    for number, line in enumerate(_lines(file), start=1):
        if not (sequence := parse_sequence(line)):
            empty += 1
            continue
        try:
            found = cover(sequence, rule=rule, solver=solver, overlap=overlap, min_length=min_length)
        except BadValue as error:
            raise BadFile(file, f"line {number}: {error}") from None
        first = onset(sequence, overlap=overlap, min_length=min_length)
        longest = longest_loop(sequence, overlap=overlap, min_length=min_length)
        print(json_.dumps(_row(found, first, longest)) if json else _sentence(found, first, longest))
    if empty:
        print(f"{empty} empty line{'s' * (empty > 1)} left out", file=sys.stderr)


def _lines(file: str) -> list[str]:
    try:
        content = sys.stdin.buffer.read() if file == "-" else Path(file).read_bytes()
        return content.decode("utf-8-sig").splitlines()
    except AttributeError:
        raise BadFile(file, "standard input is closed") from None
    except OSError as error:
        raise BadFile(file, f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise BadFile(file, "not text in UTF-8") from None


def _row(found: LoopCover, first: int, longest: int) -> dict[str, object]:
    return {
        "n": found.n,
        "any_loop": found.any_loop,
        "coverage": found.covered,
        "share": found.share,
        "redundant": found.redundant,
        "onset": first,
        "longest": longest,
        "words": [list(word) for word in found.words],
        "intervals": [list(piece) for piece in found.intervals],
    }


def _sentence(found: LoopCover, first: int, longest: int) -> str:
    if not found.any_loop:
        return f"{found.n} actions: no loop"
    words = ", ".join(" ".join(map(str, word)) for word in found.words)
    places = ", ".join(f"{start}+{length}" for start, length in found.intervals)
    return (
        f"{found.n} actions: {found.covered} in loops ({found.share:.0%}), {found.redundant} of them redundant; "
        f"first complete at step {first}, longest {longest}" + (f": {words} at {places}" if words else "")
    )


def chance(
    length: Annotated[int, typer.Option(min=0, max=10_000, help="Length of the trial in steps.")] = 20,
    actions: Annotated[int, typer.Option(min=1, max=64, help="Number of joints.")] = 4,
    null: Annotated[Literal["uniform", "no-repeat"], typer.Option(help="The blind agent.")] = "uniform",
    overlap: Annotated[bool, typer.Option("--overlap", help="Two occurrences may overlap.")] = False,
    json: Annotated[bool, typer.Option("--json", help="One JSON object.")] = False,
) -> None:
    """The probability that a blind agent's trial of this length holds an action loop."""
    level = chance_level(length, actions, null=null, overlap=overlap)
    if json:
        print(json_.dumps({"probability": level.probability, "method": level.method, "error": level.error}))
    else:
        doubt = "" if level.method == "exact" else f" ± {level.error:.4f}"
        print(f"{level.probability:.4f}{doubt} ({level.method}; {null}, {length} steps, {actions} joints)")
