"""``lockprobe power``: how many trials, boxes or persons a design needs."""

from __future__ import annotations

import json as json_
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer
from rich.markup import escape

from lockprobe.cli import options
from lockprobe.cli.printing import new_table, plain_console, print_table, time_left
from lockprobe.cli.study_options import study_help, with_study_options
from lockprobe.foundation.errors import BadValue, Conflict, UserMistake
from lockprobe.foundation.formatting import percent
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.workers import Processes
from lockprobe.simulation.power import effects
from lockprobe.simulation.power.people import EFFECT_SD, PERSON_SD, PERSONS, Design, People, people_power
from lockprobe.simulation.power.simulator import TRIALS, Needed, Simulation
from lockprobe.statistics.inference.over_doses import TESTS
from lockprobe.statistics.why.mechanism import MARGIN

if TYPE_CHECKING:
    from lockprobe.simulation.power.conditions import Contrasts

_WHAT = "why: blocks of a study of controls; a study file: its conditions (trials per flip rate)."
_SUCCESS = (
    "Effect: success at each flip rate, as 0.2,0.5,0.4 (two effects); under each condition, the control first; "
    "for why in its seven arms: truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark."
)
_TRAP = "Effect: chance per step to begin a cycle at each flip rate (none)."
_PEOPLE = "A study of people (how many persons it needs, within and between persons; with --success)."
_PERSONS = "With --people: persons in all at which power is measured, as 40 or 40,80 (10 to 160 for each condition)."
_BOXES = "With --people: boxes that a person plays under each condition (1)."
_OVER_BOXES = "Numbers of boxes to measure at, as 5,10,20, with --success of two conditions (none)."
_PERSON_SD = f"With --people: standard deviation of skill between persons, in logits ({PERSON_SD:g}, by eye)."
_EFFECT_SD = (
    f"Standard deviation of the effect: with --people between persons, in logits ({EFFECT_SD:g}, by eye); else between "
    f"--over-boxes, as a share ({effects.EFFECT_SD:g}, by eye)."
)
_TRIALS = study_help("trials", "numbers to measure at: 15,30,60,120,240; with why 50,150,300,600")
_SHARED = "With --success for conditions: share of trials that one number decides under all of them, 0 to 1 (0)."
_TARGET, _STUDIES = "Power to reach (0.8).", options.with_brackets(options.STUDIES, "100")

_Numbers = Sequence[float]

_FLIPS, _CONDITIONS, _WHY, _OF_BOXES, _OF_PEOPLE = (
    "flip rates alone",
    "conditions",
    "power why",
    "--over-boxes",
    "--people",
)

_TAKE = {
    _FLIPS: ("success", "p", "trap", "trials", "target", "studies", "seed"),
    _CONDITIONS: ("success", "p", "shared", "trials", "target", "studies", "seed"),  # and all that describes a study
    _WHY: ("success", "trials", "studies", "seed"),
    _OF_BOXES: ("over_boxes", "success", "trials", "effect_sd", "seed"),
    _OF_PEOPLE: (
        *("people", "success", "persons", "boxes_each", "person_sd", "effect_sd"),
        *("target", "studies", "seed"),
    ),
}
"""What is simulated -> the options that it takes, beside --workers and --json."""


@with_study_options(without=("boxes", "trials", "strategy_trials", "repetitions", "full", "until", "most", "name"))
def power(
    asked: Mapping[str, Any],
    what: Annotated[str | None, typer.Argument(metavar="[why|FILE.toml]", help=_WHAT)] = None,
    success: Annotated[str | None, typer.Option(help=_SUCCESS)] = None,
    shared: Annotated[float | None, typer.Option(help=_SHARED)] = None,
    trap: Annotated[str | None, typer.Option(help=_TRAP)] = None,
    trials: Annotated[str | None, typer.Option(help=_TRIALS)] = None,
    target: Annotated[float | None, typer.Option(help=_TARGET)] = None,
    people: Annotated[bool, typer.Option("--people", help=_PEOPLE)] = False,
    persons: Annotated[str | None, typer.Option(help=_PERSONS)] = None,
    boxes_each: Annotated[int | None, typer.Option(min=1, max=1000, help=_BOXES)] = None,
    over_boxes: Annotated[str | None, typer.Option(help=_OVER_BOXES)] = None,
    person_sd: Annotated[float | None, typer.Option(help=_PERSON_SD)] = None,
    effect_sd: Annotated[float | None, typer.Option(help=_EFFECT_SD)] = None,
    studies: Annotated[int | None, typer.Option(min=1, max=100_000, help=_STUDIES)] = None,
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
    many.
    """
    own = {
        "success": success, "shared": shared, "trap": trap, "trials": trials, "target": target, "studies": studies,
        "people": people or None, "persons": persons, "boxes_each": boxes_each, "over_boxes": over_boxes,
        "person_sd": person_sd, "effect_sd": effect_sd,
    }  # fmt: skip
    form = _form(what, asked, [name for name, value in own.items() if value is not None])
    shares, sizes, seed = _numbers("success", success), _whole_numbers("trials", trials), asked.get("seed", 1)
    how = effects.OVER_BOXES if form == _OF_BOXES else Simulation(trials=effects.BLOCKS if form == _WHY else TRIALS)
    how = replace(
        how,
        trials=sizes or how.trials,
        target=how.target if target is None else target,
        studies=studies or how.studies,
        workers=Processes(workers or min(os.cpu_count() or 1, 8)),
        progress=time_left("studies"),
    )
    if form == _OF_BOXES:
        _power_over_boxes(shares, _whole_numbers("over-boxes", over_boxes), effect_sd, how, seed, json=json)
    elif form == _OF_PEOPLE:
        of_people = {"boxes": boxes_each, "person_sd": person_sd, "effect_sd": effect_sd}
        _power_of_people(shares, of_people, _whole_numbers("persons", persons), how, seed, json=json)
    elif form == _WHY:
        _power_why(shares, how, seed, json=json)
    elif form == _CONDITIONS:
        _power_of_conditions(what, asked, shares, shared or 0.0, how, json=json)
    else:
        _power_of_flips(shares, asked.get("p"), _numbers("trap", trap), how, seed, json=json)


def _form(what: str | None, asked: Collection[str], own: Collection[str]) -> str:
    """What is simulated; a mistake if an option that is given, of a study or of this command, is of no use there."""
    if "over_boxes" in own or "people" in own:
        form = _OF_BOXES if "over_boxes" in own else _OF_PEOPLE
    elif what == "why":
        form = _WHY
    else:
        form = _CONDITIONS if what or {*asked} - {"p", "seed"} else _FLIPS
    takes = {*_TAKE[form], *(asked if form == _CONDITIONS else ())}
    if refused := [name for name in (*asked, *own) if name not in takes]:
        users = [one for one, names in _TAKE.items() if refused[0] in names] or [_CONDITIONS]
        said = f"{_flag(refused[0])} is for {' and '.join(users)}"
        raise Conflict(form, ", ".join(map(_flag, refused)), said)
    if what and form in (_OF_BOXES, _OF_PEOPLE):
        raise Conflict(form, what, f"it takes {', '.join(map(_flag, _TAKE[form][1:]))}")
    return form


def _flag(option: str) -> str:
    return f"--{option.replace('_', '-')}"


def _power_of_flips(
    success: _Numbers, p: _Numbers | None, trap: _Numbers, how: Simulation, seed: int, *, json: bool
) -> None:
    if not success and (trap or p is not None):
        raise BadValue("--success", None, "success at each flip rate: --p and --trap need it")
    worlds = (effects.stated_world(success, p=p or effects.P, trap=trap),) if success else effects.default_worlds()
    found = effects.flip_power(worlds, how, seed=seed)
    if json:
        rows = [
            {"effect": world.name, "question": question, "test": TESTS[question]} | _measured(one)
            for world, question, one in found
        ]
        print(json_.dumps({"target": how.target, "studies": how.studies, "tests": rows}, indent=1))
        return
    say = plain_console().print
    cells = [(f"[bold]{world.name}[/bold]  {world.says}", TESTS[question], one) for world, question, one in found]
    _print_tables("test", cells, f"trials per flip rate for {how.target:g}")
    if not found:
        say("No test has anything to detect: under this effect every question has the answer no.")
        return
    _print_brackets(one for _, _, one in found)
    say("Assumption: trials at different flip rates share no luck, as with a sampled model.")


def _power_of_conditions(
    file: str | None, asked: Mapping[str, Any], success: _Numbers, shared: float, how: Simulation, *, json: bool
) -> None:
    from lockprobe.simulation.power.conditions import condition_power
    from lockprobe.studies.options.studyfile import study

    if file is None and "agent" not in asked:
        if not success:
            raise BadValue("--success", None, "success under each condition, or --agent with a strategy to be played")
        asked = {**asked, "agent": "random"}  # it is not played
    if file is not None and not file.endswith(".toml"):
        raise BadValue("power", file, "why, a study file ending in .toml, or nothing")
    found = condition_power(
        study(file or "flips", **asked), how, success=success or None, shared=shared, playing=time_left("trials")
    )
    rows = [(_contrast(of, condition), one) for of, needed in found for condition, one in needed.items()]
    if json:
        head = {"target": how.target, "studies": how.studies, "shared": shared}
        print(json_.dumps(head | {"conditions": [row | _measured(one) for row, one in rows]}, indent=1))
        return
    say = plain_console().print
    cells = []
    for row, one in rows:
        shares = f"{percent(row['success'])} against {percent(row['control_success'])}, one of {row['choices']}"
        name = f"{escape(printable(row['condition']))}\n[dim]{shares}[/dim]"
        cells.append((f"[bold]{escape(row['agent'])}[/bold]", name, one))
    _print_tables("condition", cells, f"trials per condition for {how.target:g}")
    say(
        "\nBelow each condition: success under it and under its control, and the number of comparisons that are "
        "corrected together. Flip rates, every other dose and all other conditions are corrected apart. The table "
        "gives the share of simulated studies in which the report detects the difference."
    )
    if any(row["success"] == row["control_success"] for row, _ in rows):
        say("Where success is equal, there is nothing to detect, and the share is of false positives.")
    _print_brackets(one for _, one in rows)
    if not success:
        say("Assumption: the agent goes on as in the blocks of luck that it has played here.")
        return
    alike = f"{100 * shared:g} % of the trials are decided by one number" if shared else "trials share no luck"
    say(f"Assumption: {alike} under different conditions (--shared); a sampled model shares none.")


def _contrast(of: Contrasts, condition: str) -> dict[str, Any]:
    """What one comparison with the control is."""
    success = dict(zip(of.family.doses, of.success, strict=True))
    control = next(iter(success))
    return {
        "agent": of.agent,
        "family": of.family.name,
        "condition": condition,
        "control": control,
        "success": success[condition],
        "control_success": success[control],
        "choices": of.choices,
    }


def _measured(one: Needed, what: str = "trials") -> dict[str, object]:
    """What is needed, of trials or of persons."""
    return {
        f"{what}_needed": one.trials,
        f"{what}_needed_low": one.low,
        f"{what}_needed_high": one.high,
        "at_most": one.below,
        "measured": [
            {what: rate.trials, "power": rate.power, "error": rate.error, "studies": rate.studies}
            for rate in one.measured
        ],
    }


def _print_tables(first: str, rows: Iterable[tuple[str, str, Needed]], last: str) -> None:
    """Print a table for each heading.

    Args:
        first: The head of the first column.
        rows: Heading, first cell and what is needed.
        last: The head of the last column.
    """
    for heading, grouped in groupby(rows, key=itemgetter(0)):
        own = list(grouped)
        plain_console().print(f"\n{heading}")
        table = new_table(first, *(f"n={rate.trials}" for rate in own[0][2].measured), last)
        for _, name, one in own:
            table.add_row(name, *(f"{rate.power:.2f}±{rate.error:.2f}" for rate in one.measured), _needed(one))
        print_table(table)


def _needed(one: Needed) -> str:
    least, most = one.measured[0].trials, one.measured[-1].trials
    if one.trials is None:
        return f"more than {most}"
    if one.below:
        return f"at most {one.trials}"
    return f"{one.trials} \\[{one.low or f'at most {least}'}, {one.high or f'more than {most}'}]"


def _print_brackets(found: Iterable[Needed]) -> None:
    if any(one.trials is not None and not one.below for one in found):
        plain_console().print(
            "In brackets: the 95 % interval from the number of simulated studies; more --studies make it narrower."
        )


def _power_why(success: _Numbers, how: Simulation, seed: int, *, json: bool) -> None:
    rates = effects.why_power({"as stated": success} if success else effects.STATED, how, seed=seed)
    if json:
        print(json_.dumps({"seed": seed, "rates": [asdict(one) for one in rates]}, indent=1))
        return
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


def _power_over_boxes(
    success: _Numbers, boxes: Sequence[int], effect_sd: float | None, how: Simulation, seed: int, *, json: bool
) -> None:
    if not success:
        raise UserMistake("--success is missing, expected success under the control and under the condition: 0.2,0.6")
    deviation = effects.EFFECT_SD if effect_sd is None else effect_sd
    stated = [effects.Boxes(success=tuple(success), boxes=k, effect_sd=deviation) for k in boxes]
    found = effects.power_over_boxes(stated, how, seed=seed)
    if json:
        rows = [{"boxes": k, "trials": n, "power": power} for (k, n), power in found.items()]
        print(json_.dumps({"effect_sd": deviation, "seed": seed, "power": rows}, indent=1))
        return
    table = new_table("trials on each box", *(f"{k} boxes" for k in boxes))
    for n in how.trials:
        table.add_row(str(n), *(f"{found[k, n]:.2f}" for k in boxes))
    print_table(table)
    print(
        f"The share of {how.studies} simulated studies in which the report detects the change of success of boxes like "
        f"these. Standard deviations between boxes, by eye: {100 * effects.DIFFICULTY_SD:g} points of success, "
        f"{100 * deviation:g} of its change (--effect-sd). Trials share no luck, as with a sampled model."
    )


_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed standard deviations are multiplied by, to show how much they decide."""


def _power_of_people(
    success: _Numbers,
    of_people: Mapping[str, float | None],
    persons: Sequence[int],
    how: Simulation,
    seed: int,
    *,
    json: bool,
) -> None:
    """What a study of people needs, for the assumed standard deviations, for half of them, and for more.

    Raises:
        UserMistake: If a value is missing or makes no model, or persons are too few.
    """
    if not success:
        known = "the share of boxes opened under each condition, the control first: 0.4,0.6"
        raise UserMistake(f"--success is missing, expected {known}")
    model = People(success=tuple(success), **{name: value for name, value in of_people.items() if value is not None})  # type: ignore[arg-type] # named as its fields are
    how = replace(how, trials=persons or [len(success) * each for each in PERSONS])
    models = [
        replace(model, design=design, person_sd=model.person_sd * factor, effect_sd=model.effect_sd * factor)
        for design in get_args(Design)
        for factor in _FACTORS
    ]
    found = [*zip(models, people_power(models, how, seed=seed), strict=True)]
    if json:
        rows = [
            {"design": one.design, "person_sd": one.person_sd, "effect_sd": one.effect_sd} | _measured(of, "persons")
            for one, of in found
        ]
        head = {"target": how.target, "studies": how.studies, "success": success, "boxes": model.boxes}
        print(json_.dumps(head | {"designs": rows}, indent=1))
        return
    cells = [
        (
            f"[bold]{one.design} persons[/bold], {one.boxes_in_all} boxes each"
            + " under one condition" * (one.design == "between"),
            f"SD {one.person_sd:g} and {one.effect_sd:g}",
            of,
        )
        for one, of in found
    ]
    _print_tables("deviations", cells, f"persons for {how.target:g}")
    _print_brackets(of for _, of in found)
    chosen = None in (of_people["person_sd"], of_people["effect_sd"])
    by_eye = "; the defaults are chosen by eye, not measured" * chosen
    plain_console().print(
        "n are persons in all. The table gives the share of simulated studies in which the report tells "
        f"{' and '.join(f'{share:g}' for share in success[1:])} from the control's {success[0]:g}. SD: standard "
        "deviations between persons, in logits, of skill (--person-sd) and of the effect of a condition (--effect-sd)"
        f"{by_eye}: plan with the worst row until a pilot has measured them. Persons who leave or are screened out "
        "come on top.\nAssumption: a person's boxes are independent but for skill, and nobody learns from box to box."
    )


def _numbers(name: str, text: str | None) -> list[float]:
    """Numbers separated by commas; none of no text."""
    try:
        return [float(part) for part in text.split(",")] if text is not None else []
    except ValueError:
        raise BadValue(name, text, "numbers separated by commas") from None


def _whole_numbers(name: str, text: str | None) -> list[int]:
    values = _numbers(name, text)
    if not all(value.is_integer() for value in values):
        raise BadValue(name, text, "whole numbers separated by commas")
    return [int(value) for value in values]
