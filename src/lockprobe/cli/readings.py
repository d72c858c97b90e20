"""``lockprobe readings``: success under every reading of a false report."""

from __future__ import annotations

import json as json_
import sys
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from math import isnan
from typing import Annotated

import typer
from rich.markup import escape

from lockprobe.boxes.families import DEFAULT_BOX
from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.simulation.montecarlo.readings import (
    AGENTS,
    FALSE_REPORTS,
    P,
    SuccessUnder,
    as_table,
    cell,
    conditions_table,
    success_under,
)
from lockprobe.studies.study_options import parse_p

__all__ = ["readings"]

_AGENT = f"A strategy, cognitive model or learner; may be repeated ({', '.join(AGENTS)})."
_RATES = f"Rates of false reports ({','.join(f'{rate:g}' for rate in P)})."
_TRIALS = "Trials per cell of an agent whose success has to be sampled."


def readings(
    agent: Annotated[list[str] | None, typer.Option(help=_AGENT)] = None,
    p: Annotated[str | None, typer.Option(help=_RATES)] = None,
    box: Annotated[str, typer.Option(help="A box by name, random-N-SEED, or a TOML file.")] = DEFAULT_BOX,
    max_steps: Annotated[int, typer.Option(help="Budget in steps.")] = 20,
    trials: Annotated[int, typer.Option(min=1, max=1_000_000, help=_TRIALS)] = 1_500,
    seed: Annotated[int, typer.Option(min=0, help="Seed of these trials.")] = 1,
    json: Annotated[bool, typer.Option("--json", help="One JSON object per cell.")] = False,
) -> None:
    """Compute how often agents open a box under every reading of a false report, and under its parts.

    The success is exact where the agent has few states, and otherwise the share of trials, with a 95 % interval. In
    brackets: the share of reports whose outcome, told or inferred by comparing two reports, is false. Each kind of
    false report is a condition for lockprobe run.
    """
    rates = P if p is None else parse_p(p)
    found = success_under(agent or AGENTS, box, p=rates, max_steps=max_steps, trials=trials, seed=seed, begun=_begun)
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
