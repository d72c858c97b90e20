"""``lockprobe detectors``."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated

import typer

from lockprobe.analysis.detectors import DETECTORS, as_table, comparison, flags, microseconds, score
from lockprobe.cli.sequences import MOST_ACTIONS, check_actions, numbered_sequences

__all__ = ["detectors"]

BRIEF = 500
"""Trials per kind that take about two seconds."""


def detectors(
    file: Annotated[
        str | None, typer.Argument(metavar="[FILE|-]", help="One action sequence a line: which detectors flag it.")
    ] = None,
    trials: Annotated[int, typer.Option(min=20, max=100_000, help="Trials of each kind in the table.")] = 1000,
    seed: Annotated[int, typer.Option(help="Of the trials in the table.")] = 0,
    actions: Annotated[int, typer.Option(min=2, max=MOST_ACTIONS, help="Number of joints, for FILE.")] = 4,
    clock: Annotated[bool, typer.Option("--clock", help="Also the time that a trial takes.")] = False,
    json: Annotated[bool, typer.Option("--json", help="One JSON object a detector, or a sequence.")] = False,
) -> None:
    """Loop detectors of agent frameworks beside the paper's: on planted loops, or on your sequences."""
    if file is not None:
        for number, sequence in numbered_sequences(file):
            check_actions(file, f"line {number}", len(set(sequence)), actions)
            print(_verdict(sequence, actions, json=json))
        return
    if trials > BRIEF:
        print(f"playing {8 * trials} random and planted trials, about {trials // 300} s", file=sys.stderr)
    rows = comparison(trials, seed)
    times = {detector.name: microseconds(detector) for detector in DETECTORS} if clock else None
    if json:
        for row in rows:
            print(json_.dumps(asdict(row) | ({"microseconds": times[row.detector]} if times else {})))
    else:
        print(as_table(rows, times))


def _verdict(sequence: Sequence[str], actions: int, *, json: bool) -> str:
    """Which detectors flag a sequence; those that need outcomes are not asked."""
    asked = [detector for detector in DETECTORS if not detector.needs_outcome]
    flagged = [detector.name for detector in asked if flags(detector, sequence, (), joints=actions)]
    if json:
        scores = {detector.name: score(detector, sequence, ()) for detector in asked}
        return json_.dumps({"n": len(sequence), "flagged": flagged, "scores": scores})
    return f"{len(sequence)} actions: {', '.join(flagged) or 'none'}"
