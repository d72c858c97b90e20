"""``lockprobe audit``: error rates of the statistics."""

from __future__ import annotations

import json as json_
from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated

import typer
from rich.table import Table

from lockprobe.cli import options
from lockprobe.cli.cluster import reached
from lockprobe.cli.power import AsJson, Seed, Workers, print_verdicts, processes, whole_numbers
from lockprobe.cli.printing import new_table, plain_console, print_table, time_left
from lockprobe.foundation.errors import BadValue, Conflict, UnknownName
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.parallel import Pool
from lockprobe.foundation.spec import Spec
from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.simulation.audit.many_agents import MANY_AGENTS, SentenceRate, sentence_data, sentence_rates
from lockprobe.simulation.audit.rates import COMPARISON, Rate, as_data, measure
from lockprobe.simulation.audit.simulated_agents import WORLDS, World, world

__all__ = ["audit"]


def audit(
    what: Annotated[
        str | None,
        typer.Argument(metavar="[why|lie]", help="why: verdicts of studies of controls; lie: effects of one lie."),
    ] = None,
    names: Annotated[list[str] | None, typer.Option("--world", help="Only this world; may be repeated.")] = None,
    studies: Annotated[int, typer.Option(min=1, max=100_000, help="Simulated studies per world.")] = 300,
    blocks: Annotated[str, typer.Option(help="Blocks of a study of controls, for why.")] = "150,300,600",
    seed: Seed = 1,
    workers: Workers = None,
    cluster: options.ClusterAt = None,
    json: AsJson = False,
) -> None:
    """Measure the false positive rate and the power of every test.

    Simulated agents with known truth play the paper's flip study many times; these studies go through the same tests
    as a user's. The default takes a few minutes on two cores. audit why: how often lockprobe run why names the true
    mechanism of agents whose mechanism is known. audit lie: how often confidence intervals of the effect of one lie,
    from records and from forks, contain the exact effect.
    """
    if what not in (None, "why", "lie"):
        raise BadValue("audit", what, "why, lie, or nothing")
    with reached(cluster) as machines:
        pool = machines or processes(workers)
        if what == "lie":
            _audit_lie(names, studies, seed, pool, json=json)
        elif what == "why":
            _audit_why(names, studies, whole_numbers("blocks", blocks), seed, pool, json=json)
        else:
            _audit_tests(names, studies, seed, pool, json=json)


def _audit_tests(names: list[str] | None, studies: int, seed: int, workers: Pool, *, json: bool) -> None:
    asked = list(dict.fromkeys(names or [*WORLDS, *MANY_AGENTS]))
    many = [name for name in asked if name in MANY_AGENTS]
    worlds = [_world(name) for name in asked if name not in MANY_AGENTS]
    rates = measure(worlds, studies=studies, seed=seed, workers=workers, progress=time_left("studies"))
    sentences = sentence_rates(many, studies=studies, seed=seed, workers=workers, progress=time_left("studies"))
    if json:
        found = as_data(rates, seed=seed) | ({"many_agents": sentence_data(sentences)} if many else {})
        print(json_.dumps(found, indent=1))
        return
    if worlds:
        _print_tests(worlds, rates)
    if many:
        _print_sentences(sentences)


def _world(name: str) -> World:
    """A world of one agent by name; the message on an unknown name lists those of many agents too."""
    if name not in WORLDS:
        raise UnknownName("world", name, (*WORLDS, *MANY_AGENTS))
    return world(name)


def _print_tests(worlds: Sequence[World], rates: Sequence[Rate]) -> None:
    console = plain_console()
    for made in worlds:
        console.print(f"[bold]{made.name}[/bold]  {made.says}")
    questions: list[tuple[str, str]] = [*QUESTIONS.items(), ("comparison", COMPARISON)]
    for question, text in questions:
        if asked := [rate for rate in rates if rate.question == question]:
            console.print(f"\n[bold]{text}[/bold]")
            print_table(_rate_table(asked))
    console.print(_verdict(rates))


def _print_sentences(rates: Sequence[SentenceRate]) -> None:
    """What is said of many agents, and how often."""
    console = plain_console()
    console.print("\n[bold]What a report says of many agents[/bold]")
    table = new_table("world")
    for name in ("agents", "sentence", "truth", "said"):
        table.add_column(name)
    for one in rates:
        share = f"{one.rate:.3f} ±{one.error:.3f}"
        table.add_row(
            one.world,
            str(one.agents),
            one.sentence,
            "yes" if one.truth else "no",
            share if one.valid is not False else f"[red]{share} ![/red]",
        )
    print_table(table)
    for name in dict.fromkeys(one.world for one in rates):
        console.print(f"[bold]{name}[/bold]  {MANY_AGENTS[name].says}")


def _audit_why(
    names: list[str] | None, studies: int, blocks: list[int], seed: int, workers: Pool, *, json: bool
) -> None:
    from lockprobe.simulation.montecarlo.verdicts import MECHANISMS, verdict_rates

    known = {Spec.parse(name).name: name for name in MECHANISMS}
    for name in names or ():
        if name not in known:
            raise UnknownName("world", name, known)
    rates = verdict_rates(
        [known[name] for name in dict.fromkeys(names or known)],
        blocks=blocks,
        studies=studies,
        seed=seed,
        workers=workers,
        progress=time_left("blocks"),
    )
    print_verdicts(rates, "world", seed, json=json)


def _audit_lie(names: list[str] | None, studies: int, seed: int, workers: Pool, *, json: bool) -> None:
    from lockprobe.simulation.montecarlo.interval_rates import AUDITED, interval_rates

    if names:
        agents = ", ".join(name for name, _ in AUDITED)
        raise Conflict("--world", "audit lie", f"it always audits the agents {agents}")
    rates = interval_rates(studies=studies, seed=seed, workers=workers, progress=time_left("studies"))
    if json:
        print(json_.dumps({"seed": seed, "rates": [asdict(one) for one in rates]}, indent=1))
        return
    table = new_table("agent")
    for name in (
        "p",
        "from",
        "exact effect, points",
        "mean estimate",
        "coverage of 95 % intervals",
        "P < 0.05",
        "studies",
    ):
        table.add_column(name)
    for one in rates:
        shares = ("-" if share is None else percent(share, 1) for share in (one.held, one.detected))
        size = (f"{100 * one.exact:.1f}", "-" if one.mean is None else f"{100 * one.mean:.1f}")
        table.add_row(one.agent, f"{one.p:g}", one.estimate, *size, *shares, f"{one.shown} of {one.studies}")
    print_table(table)
    print("Where the exact effect is 0, P < 0.05 is a false positive. Studies with too few trials have no estimate.")


def _rate_table(rates: Sequence[Rate]) -> Table:
    """One row per test: its false positives in worlds without an effect, and its power in the others."""
    table = new_table("test")
    for name in ("false positives, worst world", "power"):
        table.add_column(name)
    for test in dict.fromkeys(rate.test for rate in rates):
        mine = [rate for rate in rates if rate.test == test]
        worst = max((rate for rate in mine if not rate.truth), key=lambda rate: rate.rate, default=None)
        label = f"[bold]{test}[/bold] *" if mine[0].recommended else test
        table.add_row(label, _false(worst), ", ".join(_figure(rate) for rate in mine if rate.truth))
    return table


def _figure(rate: Rate) -> str:
    return f"{rate.rate:.2f} ±{rate.error:.2f} {rate.world}"


def _false(worst: Rate | None) -> str:
    if worst is None:
        return "-"
    return _figure(worst) if worst.valid else f"[red]{_figure(worst)} ![/red]"


def _verdict(rates: Sequence[Rate]) -> str:
    wrong = [rate for rate in rates if rate.recommended and rate.valid is False]
    said = (
        "Every recommended test (*) rejects in at most 5 % of studies without an effect, within Monte Carlo error."
        if not wrong
        else "Too many false positives: "
        + "; ".join(f"{rate.test} in {rate.world} ({rate.rate:.2f})" for rate in wrong)
    )
    return f"\n{said}\nRates at a level of 0.05 ± Monte Carlo standard error; ! marks a rate above 0.05 beyond error."
