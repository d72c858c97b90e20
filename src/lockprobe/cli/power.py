"""``lockprobe power``: how many trials a design needs, by simulation."""

from __future__ import annotations

import json as json_
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from lockprobe.cli import options
from lockprobe.cli.power_people import power_people, refuse_beside_boxes, refuse_other_options
from lockprobe.cli.printing import new_table, plain_console, print_table, time_left
from lockprobe.cli.study_options import study_help, with_study_options
from lockprobe.foundation.errors import BadValue, Conflict, UserMistake
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.parallel import Processes
from lockprobe.foundation.terminal_text import printable
from lockprobe.simulation.power.boxes import DIFFICULTY_SD, power_over_boxes
from lockprobe.simulation.power.boxes import EFFECT_SD as EFFECT_SD_OF_BOXES
from lockprobe.simulation.power.boxes import TRIALS as OF_EACH_BOX
from lockprobe.simulation.power.flip_rates import TRIALS, Needed, default_worlds, stated_world
from lockprobe.simulation.power.flip_rates import power as measure_power
from lockprobe.simulation.power.people import EFFECT_SD, PERSON_SD
from lockprobe.simulation.power.worlds import P, World
from lockprobe.statistics.why.mechanism import MARGIN

if TYPE_CHECKING:
    from lockprobe.simulation.power.conditions import ConditionPower
    from lockprobe.simulation.power.why import VerdictRates

_WHAT = "why: blocks of a study of controls; a study file: its conditions (trials per flip rate)."
_SUCCESS = (
    "Effect: success at each flip rate, as 0.2,0.5,0.4 (two effects); under each condition, the control first; "
    "for why in its seven arms: truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark."
)
_TRAP = "Effect: chance per step to begin a cycle at each flip rate (none)."
_PEOPLE = "A study of people (how many persons it needs, within and between persons; with --success)."
_PERSONS = "With --people: persons in all whose power is asked for, as 40 or 40,80 (as many as --target needs)."
_BOXES = "With --people: boxes that a person plays under each condition (1)."
_OVER_BOXES = "Numbers of boxes to measure at, as 5,10,20, with --success of two conditions (none)."
_PERSON_SD = f"With --people: standard deviation of skill between persons, in logits ({PERSON_SD:g}, by eye)."
_EFFECT_SD = (
    f"Standard deviation of the effect: with --people between persons, in logits ({EFFECT_SD:g}, by eye); else between "
    f"--over-boxes, as a share ({EFFECT_SD_OF_BOXES:g}, by eye)."
)
_TRIALS = study_help("trials", "numbers to measure at: 15,30,60,120,240; with why 50,150,300,600")
_SHARED = "With --success for conditions: share of trials that one number decides under all of them, 0 to 1."


@with_study_options(without=("boxes", "trials", "strategy_trials", "repetitions", "full", "until", "most", "name"))
def power(
    asked: Mapping[str, Any],
    what: Annotated[str | None, typer.Argument(metavar="[why|FILE.toml]", help=_WHAT)] = None,
    success: Annotated[str | None, typer.Option(help=_SUCCESS)] = None,
    shared: Annotated[float, typer.Option(help=_SHARED)] = 0.0,
    trap: Annotated[str | None, typer.Option(help=_TRAP)] = None,
    trials: Annotated[str | None, typer.Option(help=_TRIALS)] = None,
    target: Annotated[float, typer.Option(help="Power to reach.")] = 0.8,
    people: Annotated[bool, typer.Option("--people", help=_PEOPLE)] = False,
    persons: Annotated[str | None, typer.Option(help=_PERSONS)] = None,
    boxes_each: Annotated[int | None, typer.Option(min=1, max=1000, help=_BOXES)] = None,
    over_boxes: Annotated[str | None, typer.Option(help=_OVER_BOXES)] = None,
    person_sd: Annotated[float | None, typer.Option(help=_PERSON_SD)] = None,
    effect_sd: Annotated[float | None, typer.Option(help=_EFFECT_SD)] = None,
    studies: Annotated[int, typer.Option(min=1, max=100_000, help=options.STUDIES)] = 100,
    workers: options.Workers = None,
    json: options.AsJson = False,
) -> None:
    """Find by simulation how many trials per condition each test needs to detect a given effect.

    --condition, --sweep or --agent: the difference of every condition from its control, by the test of the report: in
    pairs of equal luck, corrected for the conditions of its family and for the agents. Success is what an --agent
    reaches that is played here, or --success. Without them, every test over flip rates (--p, else 0 to 0.6 in steps of
    0.1), for two effects: a rise and fall of success like the paper's (0.23 at flip rate 0, 0.67 at 0.4, then 0.5), and
    an agent that gets trapped in loops when it is told the truth. power why: how many blocks (--trials) a study of
    controls needs to name the reason for a change of success.

    --over-boxes: how often a study on so many boxes, with --trials on each, detects the change on boxes like these.

    --people: how many persons a study of people needs, within and between persons; with --persons, the power of that
    many and the smallest effect that they detect.
    """
    sizes, seed, rates = _whole_numbers("trials", trials), asked.get("seed", 1), asked.get("p")
    beside = asked.keys() - {"p", "seed"}
    if what == "why" and (shared or rates or beside):
        raise Conflict("power why", "--shared and options of a study", "its seven arms are its own")
    shares = None if success is None else _numbers("success", success)
    of_people = {"boxes": boxes_each, "person_sd": person_sd, "effect_sd": effect_sd}
    if many := _whole_numbers("over-boxes", over_boxes):
        given = _given(persons=persons, trap=trap, person_sd=person_sd, boxes_each=boxes_each, people=people or None)
        refuse_beside_boxes(what, [*asked.keys() - {"seed"}, *given])
        _power_over_boxes(shares, many, sizes, effect_sd, seed, json=json)
        return
    if people or persons or set(of_people.values()) != {None}:
        refuse_other_options(people, what, [*asked, *_given(trials=trials, shared=shared or None, trap=trap)])
        power_people(shares, of_people, _whole_numbers("persons", persons), target, json=json)
        return
    processes = Processes(workers or min(os.cpu_count() or 1, 8))
    simulated: dict[str, Any] = {"target": target, "studies": studies, "workers": processes}
    if what == "why":
        _power_why(success, sizes, studies, seed, json=json)
        return
    if what or beside:
        if trap is not None:
            raise Conflict("--trap", "conditions", "it states an effect of flip rates alone")
        _power_of_conditions(what, asked, shares, shared, simulated | {"trials": sizes or TRIALS}, json=json)
        return
    if shared:
        raise Conflict("--shared", "flip rates alone", "they share no luck here; --agent or --condition compares pairs")
    if shares is None and (trap is not None or rates is not None):
        raise BadValue("--success", None, "success at each flip rate: --p and --trap need it")
    grid = P if rates is None else rates
    stated = () if shares is None else (stated_world(shares, p=grid, trap=_numbers("trap", trap)),)
    _power_of_flips(stated or default_worlds(), simulated | {"p": grid, "trials": sizes or TRIALS, "seed": seed}, json)


def _power_over_boxes(
    success: Sequence[float] | None,
    boxes: Sequence[int],
    trials: Sequence[int],
    effect_sd: float | None,
    seed: int,
    *,
    json: bool,
) -> None:
    if success is None:
        raise UserMistake("--success is missing, expected success under the control and under the condition: 0.2,0.6")
    trials, effect_sd = trials or OF_EACH_BOX, EFFECT_SD_OF_BOXES if effect_sd is None else effect_sd
    found = power_over_boxes(
        success, boxes=boxes, trials=trials, effect_sd=effect_sd, seed=seed, progress=time_left("kinds of study")
    )
    if json:
        rows = [{"boxes": k, "trials": n, "power": power} for (k, n), power in found.items()]
        print(json_.dumps({"effect_sd": effect_sd, "seed": seed, "power": rows}, indent=1))
        return
    table = new_table("trials on each box", *(f"{k} boxes" for k in boxes))
    for n in trials:
        table.add_row(str(n), *(f"{found[k, n]:.2f}" for k in boxes))
    print_table(table)
    print(
        "The share of 1000 simulated studies in which the report detects the change of success of boxes like these. "
        f"Standard deviations between boxes, by eye: {100 * DIFFICULTY_SD:g} points of success, {100 * effect_sd:g} of "
        "its change (--effect-sd). Trials share no luck, as with a sampled model."
    )


def _power_of_flips(worlds: Sequence[World], simulated: Mapping[str, Any], json: bool) -> None:
    found = measure_power(worlds, progress=time_left("studies"), **simulated)
    if json:
        head = {name: simulated[name] for name in ("target", "studies")}
        rows = [{"effect": one.world, "question": one.question, "test": one.test} | _measured(one) for one in found]
        print(json_.dumps(head | {"tests": rows}, indent=1))
    else:
        _print_power(found, {world.name: world.says for world in worlds}, simulated["target"])


def _power_of_conditions(
    file: str | None,
    asked: Mapping[str, Any],
    success: Sequence[float] | None,
    shared: float,
    simulated: Mapping[str, Any],
    *,
    json: bool,
) -> None:
    from lockprobe.simulation.power.conditions import condition_power
    from lockprobe.studies.options.studyfile import study

    if file is None and "agent" not in asked:
        if success is None:
            raise BadValue("--success", None, "success under each condition, or --agent with a strategy to be played")
        asked = {**asked, "agent": "random"}  # it is not played
    if file is not None and not file.endswith(".toml"):
        raise BadValue("power", file, "why, a study file ending in .toml, or nothing")
    found = condition_power(
        study(file or "flips", **asked),
        success=success,
        shared=shared,
        playing=time_left("blocks"),
        progress=time_left("studies"),
        **simulated,
    )
    if json:
        rows = [
            {name: value for name, value in asdict(one).items() if name != "needed"} | _measured(one.needed)
            for one in found
        ]
        head = {"target": simulated["target"], "studies": simulated["studies"], "shared": shared}
        print(json_.dumps(head | {"conditions": rows}, indent=1))
    else:
        _print_conditions(found, simulated["target"], shared if success is not None else None)


def _print_conditions(found: Sequence[ConditionPower], target: float, shared: float | None) -> None:
    console = plain_console()
    measured = [f"n={rate.trials}" for rate in found[0].needed.measured]
    for agent in dict.fromkeys(one.agent for one in found):
        console.print(f"\n[bold]{escape(agent)}[/bold]")
        table = new_table("condition", *measured, _heading(target, "condition"))
        for one in (one for one in found if one.agent == agent):
            shares = f"{percent(one.success)} against {percent(one.control_success)}, one of {one.choices}"
            table.add_row(f"{escape(printable(one.condition))}\n[dim]{shares}[/dim]", *_cells(one.needed))
        print_table(table)
    console.print(
        "\nBelow each condition: success under it and under its control, and the number of comparisons that are "
        "corrected together. Flip rates, every other dose and all other conditions are corrected apart. The table "
        "gives the share of simulated studies in which the report detects the difference."
    )
    if any(one.success == one.control_success for one in found):
        console.print("Where success is equal, there is nothing to detect, and the share is of false positives.")
    _print_brackets([one.needed for one in found])
    if shared is None:
        console.print("Assumption: the agent goes on as in the blocks of luck that it has played here.")
        return
    alike = f"{100 * shared:g} % of the trials are decided by one number" if shared else "trials share no luck"
    console.print(f"Assumption: {alike} under different conditions (--shared); a sampled model shares none.")


def _power_why(success: str | None, sizes: Sequence[int], studies: int, seed: int, *, json: bool) -> None:
    from lockprobe.simulation.power.why import STATED, stated_rates

    effects = STATED if success is None else {"as stated": _numbers("success", success)}
    rates = [
        one
        for name, shares in effects.items()
        for one in stated_rates(name, shares, blocks=sizes or (50, 150, 300, 600), studies=studies, seed=seed)
    ]
    if json:
        print(json_.dumps({"seed": seed, "rates": [asdict(one) for one in rates]}, indent=1))
    else:
        _print_verdicts(rates)


def _print_verdicts(rates: Sequence[VerdictRates]) -> None:
    """How often studies of controls conclude what."""
    table = new_table("effect", "change", "truth", "blocks", "right", "wrong", "verdicts", numbers=False)
    for one in rates:
        change = f"{100 * one.change:+.1f}" if one.change else "0"
        said = ", ".join(f"{found} {n}" for found, n in one.verdicts.items())
        table.add_row(one.effect, change, one.truth, str(one.blocks), f"{one.right:.3f}", f"{one.wrong:.3f}", said)
    print_table(table)
    print(
        f"change: of success by lies, in points. truth: the verdict of a large study; where the change is less than "
        f"{100 * MARGIN:g} points, no change is right too. wrong: the verdict asserts something false.\n"
        "Arms share no luck here, as with a hosted model. A seeded agent's arms share luck and need fewer blocks."
    )


def _given(**options: object) -> list[str]:
    """The names of the options that were given."""
    return [name for name, value in options.items() if value is not None]


def _numbers(name: str, text: str | None) -> list[float]:
    try:
        return [float(part) for part in text.split(",")] if text is not None else []
    except ValueError:
        raise BadValue(name, text, "numbers separated by commas") from None


def _whole_numbers(name: str, text: str | None) -> list[int]:
    """Whole numbers separated by commas; none of no text."""
    values = _numbers(name, text)
    if not all(value.is_integer() for value in values):
        raise BadValue(name, text, "whole numbers separated by commas")
    return [int(value) for value in values]


def _measured(one: Needed) -> dict[str, object]:
    return {
        "trials_needed": one.trials,
        "trials_needed_low": one.low,
        "trials_needed_high": one.high,
        "at_most": one.below,
        "measured": [
            {"trials": rate.trials, "power": rate.rate, "error": rate.error, "studies": rate.studies}
            for rate in one.measured
        ],
    }


def _print_power(found: Sequence[Needed], says: Mapping[str, str], target: float) -> None:
    console = plain_console()
    for name in dict.fromkeys(one.world for one in found):
        mine = [one for one in found if one.world == name]
        console.print(f"\n[bold]{name}[/bold]  {says[name]}")
        table = new_table("test", *(f"n={rate.trials}" for rate in mine[0].measured), _heading(target, "flip rate"))
        for one in mine:
            table.add_row(one.test, *_cells(one))
        print_table(table)
    if not found:
        console.print("No test has anything to detect: under this effect every question has the answer no.")
    else:
        _print_brackets(found)
        console.print("Assumption: trials at different flip rates share no luck, as with a sampled model.")


def _heading(target: float, each: str) -> str:
    return f"trials per {each} for {target:g}"


def _cells(one: Needed) -> list[str]:
    """The power at every number of trials, and the number needed."""
    return [*(f"{rate.rate:.2f}±{rate.error:.2f}" for rate in one.measured), _needed(one)]


def _print_brackets(found: Sequence[Needed]) -> None:
    if any(one.trials is not None and not one.below for one in found):
        plain_console().print(
            "In brackets: the 95 % interval from the number of simulated studies; more --studies make it narrower."
        )


def _needed(one: Needed) -> str:
    most = one.measured[-1].trials
    if one.trials is None:
        return f"more than {most}"
    low = f"{one.low}" if one.low else f"at most {one.measured[0].trials}"
    high = f"{one.high}" if one.high else f"more than {most}"
    if one.below:
        return f"at most {one.trials}"
    return f"{one.trials} \\[{low}, {high}]"
