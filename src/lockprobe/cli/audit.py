"""``lockprobe audit`` and ``lockprobe power``: error rates and power of the statistics."""

from __future__ import annotations

import json as json_
import os
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from lockprobe.audit.many_agents import MANY_AGENTS, SentenceRate, sentence_data, sentence_rates
from lockprobe.audit.power import TRIALS, Needed, default_worlds, stated_world
from lockprobe.audit.power import power as measure_power
from lockprobe.audit.rates import COMPARISON, Rate, as_data, measure
from lockprobe.audit.simulated_agents import WORLDS, P, World, world
from lockprobe.cli import options
from lockprobe.cli.cluster import reached
from lockprobe.cli.printing import new_table, plain_console, print_table, time_left
from lockprobe.errors import BadValue, Conflict, UnknownName
from lockprobe.parallel import Pool, Processes
from lockprobe.prose.hypothesis_tests import QUESTIONS, name_of_test
from lockprobe.spec import Spec
from lockprobe.studies.study_options import parse_p

if TYPE_CHECKING:
    from lockprobe.montecarlo.verdicts import VerdictRates

__all__ = ["audit", "power"]

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of everything.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes (one per core).")]


_SUCCESS = "Effect: success at each flip rate, as 0.2,0.5,0.4 (two effects); for why under truth, lie, retracted."


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
        pool = machines or _processes(workers)
        if what == "lie":
            _audit_lie(names, studies, seed, pool, json=json)
        elif what == "why":
            _audit_why(names, studies, _whole("blocks", blocks), seed, pool, json=json)
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
    from lockprobe.montecarlo.verdicts import MECHANISMS, verdict_rates

    known = {Spec.parse(name).name: name for name in MECHANISMS}
    for name in names or ():
        if name not in known:
            raise UnknownName("world", name, known)
    rates = verdict_rates(
        [known[name] for name in dict.fromkeys(names or known)],
        blocks=blocks,
        studies=studies,
        pool=max(4000, *blocks),
        seed=seed,
        workers=workers,
        progress=time_left("blocks"),
    )
    _print_verdicts(rates, "world", seed, json=json)


def _audit_lie(names: list[str] | None, studies: int, seed: int, workers: Pool, *, json: bool) -> None:
    from lockprobe.montecarlo.interval_rates import AUDITED, interval_rates

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
        shares = ("-" if share is None else f"{100 * share:.1f} %" for share in (one.held, one.detected))
        size = (f"{100 * one.exact:.1f}", "-" if one.mean is None else f"{100 * one.mean:.1f}")
        table.add_row(one.agent, f"{one.p:g}", one.estimate, *size, *shares, f"{one.shown} of {one.studies}")
    print_table(table)
    print("Where the exact effect is 0, P < 0.05 is a false positive. Studies with too few trials have no estimate.")


def _power_why(success: str | None, blocks: str | None, studies: int, seed: int, *, json: bool) -> None:
    from lockprobe.montecarlo.verdicts import STATED, stated_rates

    effects = STATED if success is None else {"as stated": _numbers("success", success)}
    sizes = _whole("trials", blocks) or [50, 100, 150, 300, 600, 1200]
    rates = [
        one
        for name, shares in effects.items()
        for one in stated_rates(name, shares, blocks=sizes, studies=studies, seed=seed)
    ]
    _print_verdicts(rates, "effect", seed, json=json)
    if not json:
        print(
            "Arms share no luck here, as with a hosted model. A seeded agent's arms share luck and need fewer blocks."
        )


def _print_verdicts(rates: Sequence[VerdictRates], what: str, seed: int, *, json: bool) -> None:
    if json:
        rows = [asdict(one) | {"right": one.right, "wrong": one.wrong} for one in rates]
        print(json_.dumps({"seed": seed, "rates": rows}, indent=1))
        return
    table = new_table(what)
    for name in ("truth", "blocks", "right", "wrong", "verdicts"):
        table.add_column(name)
    for one in rates:
        said = ", ".join(f"{found} {n}" for found, n in one.verdicts.items())
        table.add_row(one.world, one.truth, str(one.blocks), f"{one.right:.3f}", f"{one.wrong:.3f}", said)
    print_table(table)


def power(
    what: Annotated[
        str | None, typer.Argument(metavar="[why]", help="why: blocks of a study of controls (trials per flip rate).")
    ] = None,
    success: Annotated[
        str | None,
        typer.Option(
            help="Effect: success at each flip rate, as 0.2,0.5,0.4 (two effects); for why under truth,lie,retracted."
        ),
    ] = None,
    trap: Annotated[
        str | None, typer.Option(help="Effect: chance per step to begin a cycle at each flip rate (none).")
    ] = None,
    harm: Annotated[float, typer.Option(help="Effect: factor on the chance to solve after a loop, 0 to 1.")] = 1.0,
    p: Annotated[str | None, typer.Option(help="Flip rates (0,0.1,...,0.6).")] = None,
    trials: Annotated[str | None, typer.Option(help="Trials per flip rate to measure at (15,30,60,120,240).")] = None,
    target: Annotated[float, typer.Option(help="Power to reach.")] = 0.8,
    studies: Annotated[int, typer.Option(min=1, max=100_000, help="Simulated studies per number of trials.")] = 100,
    seed: Seed = 1,
    workers: Workers = None,
    json: AsJson = False,
) -> None:
    """Find by simulation how many trials per flip rate each test needs to detect a given effect.

    Without an effect, it uses two: a rise and fall of success like the paper's (0.23 at flip rate 0, 0.67 at 0.4, then
    0.5), and an agent that gets trapped in loops when it is told the truth. power why: how many blocks (--trials) a
    study of controls needs to name the reason for a change of success (--success TRUTH,LIE,RETRACTED).
    """
    if what is not None:
        if what != "why":
            raise BadValue("power", what, "why, or nothing")
        _power_why(success, trials, studies, seed, json=json)
        return
    grid = P if p is None else parse_p(p)
    if success is None:
        if trap is not None or harm != 1.0 or p is not None:
            raise BadValue("--success", None, "success at each flip rate: --p, --trap and --harm need it")
        worlds = default_worlds()
    else:
        worlds = (stated_world(_numbers("success", success), p=grid, trap=_numbers("trap", trap), harm=harm),)
    found = measure_power(
        worlds,
        p=grid,
        trials=_whole("trials", trials) or TRIALS,
        target=target,
        studies=studies,
        seed=seed,
        workers=_processes(workers),
        progress=time_left("studies"),
    )
    if json:
        print(json_.dumps({"target": target, "studies": studies, "tests": [_row(one) for one in found]}, indent=1))
    else:
        _print_power(found, target)


def _processes(workers: int | None) -> Processes:
    return Processes(workers or min(os.cpu_count() or 1, 8))


def _numbers(name: str, text: str | None) -> list[float]:
    try:
        return [float(part) for part in text.split(",")] if text is not None else []
    except ValueError:
        raise BadValue(name, text, "numbers separated by commas") from None


def _whole(name: str, text: str | None) -> list[int]:
    values = _numbers(name, text)
    if not all(value.is_integer() for value in values):
        raise BadValue(name, text, "whole numbers separated by commas")
    return [int(value) for value in values]


def _rate_table(rates: Sequence[Rate]) -> Table:
    """One row per test: its false positives in worlds without an effect, and its power in the others."""
    table = new_table("test")
    for name in ("false positives, worst world", "power"):
        table.add_column(name)
    for test in dict.fromkeys(rate.test for rate in rates):
        mine = [rate for rate in rates if rate.test == test]
        worst = max((rate for rate in mine if not rate.truth), key=lambda rate: rate.rate, default=None)
        label = f"[bold]{name_of_test(test)}[/bold] *" if mine[0].recommended else name_of_test(test)
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
        + "; ".join(f"{name_of_test(rate.test)} in {rate.world} ({rate.rate:.2f})" for rate in wrong)
    )
    return f"\n{said}\nRates at a level of 0.05 ± Monte Carlo standard error; ! marks a rate above 0.05 beyond error."


def _row(one: Needed) -> dict[str, object]:
    return {
        "effect": one.world,
        "question": one.question,
        "test": one.test,
        "recommended": one.recommended,
        "trials_needed": one.trials,
        "trials_needed_low": one.low,
        "trials_needed_high": one.high,
        "at_most": one.below,
        "measured": [
            {"trials": rate.trials, "power": rate.rate, "error": rate.error, "studies": rate.studies}
            for rate in one.measured
        ],
    }


def _print_power(found: Sequence[Needed], target: float) -> None:
    console = plain_console()
    for name in dict.fromkeys(one.world for one in found):
        mine = [one for one in found if one.world == name]
        says = WORLDS[name].says if name in WORLDS else "As stated."
        console.print(f"\n[bold]{name}[/bold]  {says}")
        table = new_table(
            "test", *(f"n={rate.trials}" for rate in mine[0].measured), f"trials per flip rate for {target:g}"
        )
        for one in mine:
            label = f"[bold]{name_of_test(one.test)}[/bold] *" if one.recommended else name_of_test(one.test)
            table.add_row(label, *(f"{rate.rate:.2f}±{rate.error:.2f}" for rate in one.measured), _needed(one))
        print_table(table)
    if not found:
        console.print("No test has anything to detect: under this effect every question has the answer no.")
    else:
        console.print("\n* recommended. The others reject too often, or serve as comparisons.")
        if any(one.trials is not None and not one.below for one in found):
            console.print(
                "In brackets: the 95 % interval from the number of simulated studies; more --studies make it narrower."
            )
        console.print("Assumption: trials at different flip rates share no luck, as with a sampled model.")


def _needed(one: Needed) -> str:
    most = one.measured[-1].trials
    if one.trials is None:
        return f"more than {most}"
    low = f"{one.low}" if one.low else f"at most {one.measured[0].trials}"
    high = f"{one.high}" if one.high else f"more than {most}"
    if one.below:
        return f"at most {one.trials}"
    return f"{one.trials} \\[{low}, {high}]"
