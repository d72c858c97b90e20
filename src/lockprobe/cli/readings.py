"""``lockprobe readings``: success under every reading of a false report."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from math import isnan
from typing import Annotated, Any

import typer
from rich.markup import escape

from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.cli import options
from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.cli.study_options import study_help, with_study_options
from lockprobe.simulation.exact.readings import (
    AGENTS,
    FALSE_REPORTS,
    P,
    SuccessUnder,
    as_table,
    cell,
    conditions_table,
    success_under,
)

__all__ = ["readings"]

_TRIALS = study_help("trials", "where success has to be sampled")


@with_study_options(only=("agent", "box", "p", "seed", "max_steps"))
def readings(
    asked: Mapping[str, Any],
    trials: Annotated[int, typer.Option(min=1, max=1_000_000, help=_TRIALS)] = 1_500,
    json: options.AsJson = False,
) -> None:
    """Compute how often agents open a box under every reading of a false report, and under its parts.

    The success is exact where the agent has few states, and otherwise the share of trials, with a 95 % interval. In
    brackets: the share of reports whose outcome, told or inferred by comparing two reports, is false. Each kind of
    false report is a condition for lockprobe run. Agents are strategies and cognitive models; without --agent
    human-inspired and cognitive:perseverant, insistent and careful.
    """
    given = {"agent": AGENTS, "box": DEFAULT_BOX, "p": P, "seed": 1, "max_steps": 20, **asked}
    found = success_under(given.pop("agent"), given.pop("box"), **given, trials=trials, begun=_begun)
    if json:
        for one in found:
            share = None if isnan(one.false_outcomes) else one.false_outcomes
            print(json_.dumps(asdict(one) | {"false_outcomes": share}))
    elif sys.stdout.isatty():
        _print(found)
    else:
        print(f"{conditions_table()}\n\n{as_table(found)}")


def _begun(agent: str) -> None:
    if sys.stderr.isatty():
        print(f"following {agent}", file=sys.stderr)


def _print(found: Sequence[SuccessUnder]) -> None:
    """Print one table for each agent, and what the names of false reports mean."""
    console = plain_console()
    for agent, of_agent in groupby(found, key=lambda one: one.agent):
        console.print(f"\n[bold]{escape(agent)}[/bold]")
        rows = [list(of_kind) for _, of_kind in groupby(of_agent, key=lambda one: one.name)]
        table = new_table("false report, by flip rate", *(f"{one.p:g}" for one in rows[0]))
        for row in rows:
            table.add_row(row[0].name, *(escape(cell(one)) for one in row))
        print_table(table)
    console.print("\nSuccess, and in brackets the share of reports whose outcome is false. Conditions:")
    meant = new_table("false report", "condition")
    meant.columns[1].justify = "left"
    for name, condition in FALSE_REPORTS.items():
        meant.add_row(name, condition.format(p="P"))
    print_table(meant)
