"""``lockprobe detectors``: compares loop detectors on action sequences."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Annotated

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import new_table, print_table
from lockprobe.cli.sequences import MOST_ACTIONS, check_actions, numbered_sequences
from lockprobe.cli.study_options import study_help
from lockprobe.statistics.loops.detectors import DETECTORS, Row, as_table, comparison, flags, microseconds, score

__all__ = ["detectors"]

BRIEF = 500
"""Trials per kind that take about two seconds."""


def detectors(
    file: Annotated[
        str | None,
        typer.Argument(metavar="[FILE|-]", help="One action sequence per line; prints the detectors that flag it."),
    ] = None,
    trials: Annotated[
        int, typer.Option(min=20, max=100_000, help=study_help("trials", "of each kind in the table"))
    ] = 1000,
    seed: options.Seed = 0,
    actions: Annotated[int, typer.Option(min=2, max=MOST_ACTIONS, help=options.ACTIONS)] = 4,
    clock: Annotated[bool, typer.Option("--clock", help="Also measure the time per trial.")] = False,
    json: options.AsJson = False,
) -> None:
    """Compare loop detectors of agent frameworks with the paper's, on planted loops or on your sequences."""
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
        _print(rows, times)


def _print(rows: Sequence[Row], times: Mapping[str, float] | None) -> None:
    """Print two tables that fit 80 columns on a terminal, and one Markdown table elsewhere."""
    if not sys.stdout.isatty():
        print(as_table(rows, times))
        return
    kinds = list(rows[0].auc)
    other = new_table(
        "detector", "false, uniform", "false, no repeat", "renamed", "backwards", "interrupted", *["µs"] * bool(times)
    )
    planted = new_table("detector", *kinds)
    for row in rows:
        kept = ["-" if share is None else f"{share:.2f}" for share in (row.relabelled, row.reversed, row.interrupted)]
        clock = [f"{times[row.detector]:.0f}"] if times else []
        other.add_row(row.detector, f"{row.false_uniform:.3f}", f"{row.false_no_repeat:.3f}", *kept, *clock)
        planted.add_row(row.detector, *(f"{row.auc[kind]:.2f} \\[{row.found[kind]:.2f}]" for kind in kinds))
    print("Share of random trials flagged (false positives); share of planted loops that")
    print("stay flagged after relabelling, reversal or interruption:")
    print_table(other)
    print("\nPlanted loops: area under the ROC curve [share flagged]:")
    print_table(planted)


def _verdict(sequence: Sequence[str], actions: int, *, json: bool) -> str:
    """The detectors that flag a sequence, without those that need outcomes."""
    asked = [detector for detector in DETECTORS if not detector.needs_outcome]
    flagged = [detector.name for detector in asked if flags(detector, sequence, (), joints=actions)]
    if json:
        scores = {detector.name: score(detector, sequence, ()) for detector in asked}
        return json_.dumps({"n": len(sequence), "flagged": flagged, "scores": scores})
    return f"{len(sequence)} actions: {', '.join(flagged) or 'none'}"
