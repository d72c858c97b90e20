"""``lockprobe audit``: the error rates of the tests, as they were measured for this release."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from lockprobe.cli import options
from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.simulation.audit.rates import COMPARISON, Rate, measured, shipped

__all__ = ["audit"]


def audit(json: options.AsJson = False) -> None:
    """Print the false positive rate and the power of every test, as measured for this release.

    Simulated agents with known truth (worlds) play the paper's flip study many times; these studies go through the same
    tests as a user's. benchmarks/audit.py in the repository measures again.
    """
    found = shipped()
    if json:
        print(json_.dumps(found, indent=1))
        return
    console = plain_console()
    for question, text in [*QUESTIONS.items(), ("comparison", COMPARISON)]:
        console.print(f"\n[bold]{text}[/bold]")
        print_table(_rate_table([rate for rate in measured() if rate.question == question]))
    console.print("\n[bold]What a report says of many agents[/bold]")
    table = new_table("world", "agents", "sentence", "truth", "said", numbers=False)
    for one in found["many_agents"]["rates"]:
        share = f"{one['rate']:.3f} ±{one['error']:.3f}"
        table.add_row(
            one["world"],
            str(one["agents"]),
            one["sentence"],
            "yes" if one["truth"] else "no",
            share if one["valid"] is not False else f"[red]{share} ![/red]",
        )
    print_table(table)
    _print_every_look(found["every_look"], console)
    for name, says in (found["worlds"] | found["many_agents"]["worlds"]).items():
        console.print(f"[bold]{name}[/bold]  {says}")
    console.print(
        "\nRecommended tests have a star. Rates at a level of 0.05 ± Monte Carlo standard error; ! marks a rate above "
        "0.05 beyond error."
    )


def _print_every_look(found: Mapping[str, Any], console: Console) -> None:
    """The rates of studies that are looked at after every block."""
    console.print("\n[bold]What is said falsely at least once by studies that are looked at after every block[/bold]")
    table = new_table("said", "agents", "worlds", "the worst of them", "of studies", numbers=False)
    for one in found["rates"]:
        share = f"{one['rate']:.3f} ±{one['error']:.3f}"
        share = share if one["valid"] else f"[red]{share} ![/red]"
        table.add_row(one["says"], str(one["agents"]), str(one["worlds"]), one["world"], share)
    print_table(table)
    console.print(
        f"{found['rates'][0]['studies']} studies of {found['blocks']} blocks in each world, seed {found['seed']}; "
        "benchmarks/every_look.py in the repository measures again.\n"
    )


def _rate_table(rates: Sequence[Rate]) -> Table:
    """One row per test: its false positives in worlds without an effect, and its power in the others."""
    table = new_table("test", "false positives, worst world", "power", numbers=False)
    for test in dict.fromkeys(rate.test for rate in rates):
        mine = [rate for rate in rates if rate.test == test]
        worst = max((rate for rate in mine if not rate.truth), key=lambda rate: rate.rate)
        label = f"[bold]{test}[/bold] *" if mine[0].recommended else test
        false = _figure(worst) if worst.valid else f"[red]{_figure(worst)} ![/red]"
        table.add_row(label, false, ", ".join(_figure(rate) for rate in mine if rate.truth))
    return table


def _figure(rate: Rate) -> str:
    return f"{rate.rate:.2f} ±{rate.error:.2f} {rate.world}"
