"""``lockprobe measures``: lists the measures, and their values in the conditions of a study."""

from __future__ import annotations

import json as json_
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from lockprobe.cli import options
from lockprobe.cli.agents import list_all
from lockprobe.cli.printing import new_table, print_table
from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.record import Trial

if TYPE_CHECKING:
    from lockprobe.statistics.measures import Measured

__all__ = ["measures"]


def measures(
    directory: Annotated[
        Path | None,
        typer.Argument(metavar="[DIR]", help="The directory of a study; without it, the measures are listed."),
    ] = None,
    measure: Annotated[
        list[str] | None, typer.Option(help="Only this measure, or python:module:name; may be repeated.")
    ] = None,
    json: options.AsJson = False,
) -> None:
    """List the measures of a trial, or print a study's means of them for every condition, with 95 % intervals.

    Without --measure these are all measures: those of Lockprobe and those of installed packages.
    """
    from lockprobe.foundation.plugins import plugin_names
    from lockprobe.statistics.measures import MEASURES, find_measure

    if directory is None:
        known = {one.name: one.what for one in map(find_measure, measure or MEASURES)}
        list_all("measure", known, 14, json=json, packaged=not measure)
        return
    from lockprobe.studies.records.journal import load

    cells = defaultdict(list)
    for trial in load(directory):
        cells[trial.group, trial.condition].append(trial)
    if not cells:
        print(f"No trial is on record in {printable(str(directory))}.", file=sys.stderr)
        return
    found = [_measured(cells, name) for name in measure or MEASURES]
    for name in () if measure else plugin_names("measure"):
        try:
            found.append(_measured(cells, name))
        except UserMistake as mistake:  # nobody asked for it by name
            print(printable(f"{name} is left out: {mistake}"), file=sys.stderr)
    _print(cells, found, json=json)


_Cells = Mapping[tuple[str, str], Sequence[Trial]]
"""The trials of every agent under every condition."""


def _measured(cells: _Cells, name: str) -> list[Measured]:
    """One measure of every cell.

    Raises:
        UserMistake: If there is none of this name, or it breaks.
    """
    from lockprobe.statistics.measures import find_measure, measured

    chosen = find_measure(name)
    return [row for trials in cells.values() for row in measured(trials, [chosen])]


def _print(cells: _Cells, found: Sequence[Sequence[Measured]], *, json: bool) -> None:
    table = new_table("agent", "condition", "measure", "value", "95 % interval", "trials", "left out")
    for place, ((agent, condition), (trial, *_)) in enumerate(cells.items()):
        for row in (of[place] for of in found):
            if json:
                named = {"agent": agent, "condition": condition, "doses": trial.doses}
                print(json_.dumps(named | asdict(row)))
            table.add_row(*map(escape, (printable(agent), printable(condition), row.name)), *_cells(row))
    if not json:
        print_table(table)


def _cells(row: Measured) -> tuple[str, str, str, str]:
    value = "-" if row.value is None else f"{row.value:.3f}"
    interval = "-" if row.low is None or row.high is None else f"{row.low:.3f} to {row.high:.3f}"
    return value, interval, str(row.n), str(row.left_out)
