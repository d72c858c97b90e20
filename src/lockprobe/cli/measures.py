"""``lockprobe measures``: lists the measures, and their values in the conditions of a study."""

from __future__ import annotations

import json as json_
import sys
from collections import defaultdict
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from lockprobe.cli.agents import AsJson, list_all
from lockprobe.cli.printing import new_table, print_table
from lockprobe.terminal_text import printable

if TYPE_CHECKING:
    from lockprobe.analysis.measures import Measured

__all__ = ["measures"]


def measures(
    directory: Annotated[
        Path | None,
        typer.Argument(metavar="[DIR]", help="The directory of a study; without it, the measures are listed."),
    ] = None,
    measure: Annotated[
        list[str] | None, typer.Option(help="Only this measure, or python:module:name; may be repeated.")
    ] = None,
    json: AsJson = False,
) -> None:
    """List the measures of a trial, or print a study's means of them for every condition, with 95 % intervals."""
    from lockprobe.analysis.measures import MEASURES, find_measure, measured

    chosen = [find_measure(spec) for spec in measure or MEASURES]
    if directory is None:
        known = {one.name: one.what for one in chosen}
        list_all("measure", known, 14, json=json, packaged=not measure)
        return
    from lockprobe.studies.journal import load

    by_condition = defaultdict(list)
    for trial in load(directory):
        by_condition[trial.name.cell].append(trial)
    if not by_condition:
        print(f"No trial is on record in {printable(str(directory))}.", file=sys.stderr)
        return
    found = {condition: measured(trials, chosen) for condition, trials in by_condition.items()}
    if json:
        for condition, rows in found.items():
            for row in rows:
                print(json_.dumps({"condition": condition, **asdict(row)}))
        return
    table = new_table("condition", "measure", "value", "95 % interval", "trials", "left out")
    for condition, rows in found.items():
        for row in rows:
            table.add_row(escape(printable(condition)), escape(row.name), *_cells(row))
    print_table(table)


def _cells(row: Measured) -> tuple[str, str, str, str]:
    value = "-" if row.value is None else f"{row.value:.3f}"
    interval = "-" if row.low is None or row.high is None else f"{row.low:.3f} to {row.high:.3f}"
    return value, interval, str(row.n), str(row.left_out)
