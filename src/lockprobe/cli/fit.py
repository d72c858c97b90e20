"""``lockprobe fit``: fits cognitive models to trials."""

from __future__ import annotations

import json as json_
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import IO, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.families import box
from lockprobe.cli import options
from lockprobe.cli.out_file import refuse_study_file
from lockprobe.cli.printing import new_table, print_table
from lockprobe.cli.study_options import study_help
from lockprobe.foundation.errors import UserMistake
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.storage.atomic_file import atomic_file
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.prose.model_fit import CAUTION, finding, fit_row
from lockprobe.simulation.fit import RIVALS, AgentFit, FitReport, Parameter, RivalFit, fit_agents
from lockprobe.simulation.fit.model_comparison import Tell
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load

__all__ = ["fit"]

WIDTH = 100
"""Columns of output that does not go to a terminal."""


def fit(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study.")],
    agent: Annotated[list[str] | None, typer.Option(help=study_help("agent", "all"))] = None,
    condition: Annotated[list[str] | None, typer.Option(help=study_help("condition", "all"))] = None,
    models: Annotated[
        str | None, typer.Option(help=f"Only these models, separated by commas: {', '.join(RIVALS)}.")
    ] = None,
    folds: Annotated[int, typer.Option(help="Number of parts; each is held out in turn.")] = 10,
    by_condition: Annotated[bool, typer.Option("--by-condition", help="Fit each condition separately.")] = False,
    json: options.AsJson = False,
    out: Annotated[
        Path | None, typer.Option(help=options.with_brackets(options.OUT, "standard output, also with -"))
    ] = None,
) -> None:
    """Find the simple mechanism that best predicts an agent's choices from what it was told, and how well it does.

    Every model is fitted to the choices of every agent, over all conditions, and evaluated on held-out trials.
    Conditions in which the agent forgets reports are left out: what it still knows is not on record. --json has all
    parameters of all models.
    """
    out = None if str(out) == "-" else out
    if out is not None:
        refuse_study_file(out)
    trials = load(directory)
    report = fit_agents(
        trials,
        agents=agent or None,
        conditions=condition or None,
        models=None if models is None else [name.strip() for name in models.split(",")],
        folds=folds,
        by_condition=by_condition,
        boxes=_boxes(directory, {trial.box for trial in trials}),
        tell=_progress(),
    )
    for label, why in report.unpredicted.items():
        print(printable(f"{label} is left out: {why}."), file=sys.stderr)
    if out is None:
        _write(report, sys.stdout, json=json)
        return
    with atomic_file(out) as draft, draft.open("w", encoding="utf-8") as file:
        _write(report, file, json=json)


def _boxes(directory: Path, names: Iterable[str]) -> dict[str, Lockbox]:
    """The boxes of some trials, if known by name or from the settings of the study."""
    found = {}
    for name in names:
        with suppress(UserMistake):
            found[name] = box(name)
    with suppress(UserMistake):
        own = read_study(directory).box
        found[own.name] = own
    return found


def _progress() -> Tell:
    """Print progress on standard error, at most one line every two seconds, and none for short work."""
    last = time.monotonic()

    def tell(said: str) -> None:
        nonlocal last
        if (now := time.monotonic()) - last > 2:
            last = now
            print(f"fitting {said}", file=sys.stderr)

    return tell


def _write(report: FitReport, file: IO[str], *, json: bool) -> None:
    if json:
        print(json_.dumps(fit_row(report), indent=1, allow_nan=False), file=file)
        return
    console = Console(file=file, highlight=False, emoji=False, width=None if file.isatty() else WIDTH)
    for one in report.agents:
        _print_agent(console, one, file)
    console.print(
        "\nThe best model by BIC comes first. AICc and BIC use the log-likelihood divided by the design effect: "
        "choices of one trial, and of trials with equal labels, flips and draws, may repeat each other. "
        "Bits per choice better than chance, the probability of the joint chosen (geometric mean) and "
        "the share of choices that were the likeliest come from held-out trials, one part of "
        f"{report.folds} at a time. {CAUTION}"
    )


def _print_agent(console: Console, one: AgentFit, file: IO[str]) -> None:
    counted = f"{one.trials} trials, {one.choices} choices"
    said = [
        f"{one.left_out} left out (error, or no step)" if one.left_out else "",
        f"{one.passed_over} more not needed" if one.passed_over else "",
        f"design effect {one.repeats:.1f}" if one.repeats > 1.05 else "",
    ]
    console.print(f"\n[bold]{escape(printable(one.agent))}[/bold]  {'; '.join([counted, *filter(None, said)])}")
    console.print(escape(printable(f"Under {'; '.join(one.conditions)}")))
    console.print(escape(printable(finding(one))))
    print_table(_table(one), file)
    if one.described is not None:
        _print_best(console, one.rivals[0])


def _print_best(console: Console, best: RivalFit) -> None:
    """Print the parameters of the model that describes the agent, and how to play it."""
    console.print(f"\n{escape(best.version)}, with 95 % intervals:")
    for parameter in best.parameters:
        console.print("  " + escape(_parameter(parameter)))
    if best.spec:
        console.print(f"  To play it: --agent '{escape(best.spec)}'", soft_wrap=True)


def _table(one: AgentFit) -> Table:
    table = new_table("model", "par.", "log-lik.", "AICc", "BIC", "behind", "bits, held out", "prob.", "hits")
    for rival in one.rivals:
        table.add_row(*_row(rival))
    return table


def _row(rival: RivalFit) -> list[str]:
    version = rival.version.removeprefix(rival.model)[1:].replace("&", " ")
    chosen = f"\n[dim]{escape(version)}, best of {rival.versions}[/dim]" if rival.versions > 1 else ""
    aside = rival.held_out
    interval = "" if aside is None or aside.low is None else f" [{_two(aside.low)}, {_two(aside.high)}]"
    return [
        rival.model + chosen,
        str(len(rival.parameters)),
        f"{rival.log_likelihood:.1f}",
        "-" if rival.aicc is None else f"{rival.aicc:.1f}",
        f"{rival.bic:.1f}",
        f"{rival.behind:.1f}",
        "-" if aside is None else f"{_two(aside.gain)}{escape(interval)}",
        "-" if aside is None else f"{aside.probability:.2f}",
        "-" if aside is None else percent(aside.hits),
    ]


def _two(value: float | None) -> str:
    """A number with two digits and no minus zero; ``any`` for an infinite one."""
    return "any" if value is None else f"{round(value, 2) + 0.0:.2f}"


def _parameter(one: Parameter) -> str:
    note = "  at its bound" if one.at_bound else ""
    return f"{one.name:20}  {_two(one.value):>6}  [{_two(one.low)}, {_two(one.high)}]{note}"
