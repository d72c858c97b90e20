"""``lockprobe power``: how many trials, boxes or persons a design needs."""

from __future__ import annotations

import json as json_
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any, get_args

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import print_rows, time_left
from lockprobe.cli.study_options import study_help, with_study_options
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.workers import Processes
from lockprobe.simulation.power import effects
from lockprobe.simulation.power.people import PERSONS, Design, People, people_power
from lockprobe.simulation.power.simulator import TRIALS, Needed, Simulation
from lockprobe.statistics.why import MARGIN

_WHAT = "why: blocks of a study of controls; a study file: its conditions (trials per flip rate)."
_SUCCESS = (
    "Effect: success at each flip rate, as 0.2,0.5,0.4 (a rise and fall); under each condition, the control first; "
    "for why in its seven arms: truth, lie, truth-truth, lie-truth, truth-lie, lie-lie, remark."
)
_PEOPLE = "A study of people (how many persons it needs, within and between persons; with --success)."
_PERSONS = "With --people: persons in all at which power is measured, as 40 or 40,80 (10 to 160 for each condition)."
_BOXES = "With --people: boxes that a person plays under each condition (1)."
_OVER_BOXES = "Numbers of boxes to measure at, as 5,10,20, with --success of two conditions (none)."
_TRIALS = study_help("trials", "numbers to measure at: 15,30,60,120,240; with why 50,150,300,600")
_STUDIES = options.with_brackets(options.STUDIES, "100")

_FLIPS, _CONDITIONS, _WHY, _OF_BOXES, _OF_PEOPLE = "flip rates", "conditions", "why", "--over-boxes", "--people"

_TAKE = {
    _FLIPS: ("success", "p", "trials", "studies", "seed"),
    _CONDITIONS: ("success", "trials", "studies"),  # and all that describes a study
    _WHY: ("success", "trials", "studies", "seed"),
    _OF_BOXES: ("over_boxes", "success", "trials", "studies", "seed"),
    _OF_PEOPLE: ("people", "success", "persons", "boxes_each", "studies", "seed"),
}
"""What is simulated -> the options that it takes, beside --workers and --json."""

_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed deviations between persons are multiplied by, to show how much they decide."""

_NO_LUCK = "Assumption: trials share no luck under different conditions, as with a sampled model."


@with_study_options(without=("boxes", "trials", "strategy_trials", "repetitions", "full", "until", "most", "name"))
def power(
    asked: Mapping[str, Any],
    what: Annotated[str | None, typer.Argument(metavar="[why|FILE.toml]", help=_WHAT)] = None,
    success: Annotated[str | None, typer.Option(help=_SUCCESS)] = None,
    trials: Annotated[str | None, typer.Option(help=_TRIALS)] = None,
    people: Annotated[bool, typer.Option("--people", help=_PEOPLE)] = False,
    persons: Annotated[str | None, typer.Option(help=_PERSONS)] = None,
    boxes_each: Annotated[int | None, typer.Option(min=1, max=1000, help=_BOXES)] = None,
    over_boxes: Annotated[str | None, typer.Option(help=_OVER_BOXES)] = None,
    studies: Annotated[int | None, typer.Option(min=1, max=100_000, help=_STUDIES)] = None,
    workers: options.Workers = None,
    json: options.AsJson = False,
) -> None:
    """Find by simulation how many trials per condition each test needs to detect a given effect with a power of 0.8.

    --condition, --sweep or --agent: the difference of every condition from its control, by the test of the report: in
    pairs of equal luck, corrected for the conditions of its family and for the agents. Success is what an --agent
    reaches that is played here, or --success. Without them, the tests over flip rates (--p, else 0 to 0.6 in steps of
    0.1), for --success or a rise and fall like the paper's (0.23 at flip rate 0, 0.67 at 0.4, then 0.5). power why: how
    many blocks (--trials) a study of controls needs to name the reason for a change of success.

    --over-boxes: how often a study on so many boxes, with --trials on each, detects the change on boxes like these.

    --people: how many persons a study of people needs, within and between persons; with --persons, the power of that
    many.
    """
    own = {
        "success": success, "trials": trials, "studies": studies, "people": people or None, "persons": persons,
        "boxes_each": boxes_each, "over_boxes": over_boxes,
    }  # fmt: skip
    given = [*asked, *(name for name, value in own.items() if value is not None)]
    form = _CONDITIONS if what or {*asked} - {"p", "seed"} else _FLIPS
    form = _OF_BOXES if over_boxes else _OF_PEOPLE if people else _WHY if what == "why" else form
    takes = {*_TAKE[form], *(asked if form == _CONDITIONS else ())}
    if refused := [f"--{name.replace('_', '-')}" for name in given if name not in takes]:
        raise Conflict(f"power of {form}", ", ".join(refused), "they describe another design")
    if what and form in (_OF_BOXES, _OF_PEOPLE):
        raise Conflict(form, what, "it takes no study")
    if not success and form not in (_WHY, _FLIPS if "p" not in asked else "") and not (what or "agent" in asked):
        raise BadValue("--success", None, "success under each condition, the control first: 0.2,0.6")
    shares, seed = _numbers("success", success), asked.get("seed", 1)
    how = effects.OVER_BOXES if form == _OF_BOXES else Simulation(trials=effects.BLOCKS if form == _WHY else TRIALS)
    how = replace(
        how,
        trials=_whole_numbers("trials", trials) or how.trials,
        studies=studies or how.studies,
        workers=Processes(workers or min(os.cpu_count() or 1, 8)),
        progress=time_left("studies"),
    )
    if form == _OF_BOXES:
        rows, note = _of_boxes(shares, _whole_numbers("over-boxes", over_boxes), how, seed)
    elif form == _OF_PEOPLE:
        rows, note = _of_people(shares, boxes_each or 1, _whole_numbers("persons", persons), how, seed)
    elif form == _WHY:
        rows, note = _of_why(shares, how, seed)
    elif form == _CONDITIONS:
        rows, note = _of_conditions(what, asked, shares, how)
    else:
        rows, note = _of_flips(shares, asked.get("p"), how, seed)
    if json:
        head = {"design": form, "target": how.target, "studies": how.studies, "seed": seed}
        plain = [{name: _plain(value) for name, value in row.items()} for row in rows]
        print(json_.dumps(head | {"rows": plain}, indent=1))
    elif rows:
        print_rows([[*_heads(rows[0])], *([cell for value in row.values() for cell in _cells(value)] for row in rows)])
        print(f"\n{note}")
    else:
        print("No test has anything to detect: under this effect every question has the answer no.")


_Rows = tuple[list[dict[str, Any]], str]
"""What was found, and what is said below it."""


def _of_flips(success: Sequence[float], p: Sequence[float] | None, how: Simulation, seed: int) -> _Rows:
    rates = effects.FlipRates(success=tuple(success), p=tuple(p or effects.P)) if success else effects.FlipRates()
    found = effects.flip_power(rates, how, seed=seed)
    rows = [{"test": effects.TESTS[question], "trials": one} for question, one in found]
    return rows, f"Trials per flip rate. Success {', '.join(f'{share:g}' for share in rates.success)}. {_NO_LUCK}"


def _of_conditions(file: str | None, asked: Mapping[str, Any], success: Sequence[float], how: Simulation) -> _Rows:
    from lockprobe.simulation.power.conditions import condition_power
    from lockprobe.studies.options.studyfile import study

    if file is None and "agent" not in asked:
        asked = {**asked, "agent": "random"}  # it is not played
    if file is not None and not file.endswith(".toml"):
        raise BadValue("power", file, "why, a study file ending in .toml, or nothing")
    planned, playing = study(file or "flips", **asked), time_left("trials")
    rows = []
    for of, needed in condition_power(planned, how, success=success or None, playing=playing):
        shares = dict(zip(of.family.doses, of.success, strict=True))
        control = next(iter(shares))
        head = {"agent": of.agent, "family": of.family.name, "choices": of.choices, "control": control}
        rows += [
            {**head, "control success": shares[control], "condition": label, "success": shares[label], "trials": one}
            for label, one in needed.items()
        ]
    note = (
        "Trials per condition. choices: comparisons that are corrected together; flip rates, every other dose and all "
        "other conditions are corrected apart. Where success equals the control's, the share is of false positives."
    )
    return (
        rows,
        f"{note} {_NO_LUCK if success else 'Assumption: the agent goes on as in the blocks of luck played here.'}",
    )


def _of_why(success: Sequence[float], how: Simulation, seed: int) -> _Rows:
    rates = effects.why_power({"as stated": success} if success else effects.STATED, how, seed=seed)
    note = (
        "change: of success by lies. truth: the verdict of a large study; where the change is less than "
        f"{100 * MARGIN:g} points, no change is right too. wrong: the share of studies whose verdict asserts something "
        f"false. {_NO_LUCK} A seeded agent's arms share luck and need fewer blocks."
    )
    return [asdict(one) for one in rates], note


def _of_boxes(success: Sequence[float], boxes: Sequence[int], how: Simulation, seed: int) -> _Rows:
    found = effects.power_over_boxes([effects.Boxes(success=tuple(success), boxes=k) for k in boxes], how, seed=seed)
    note = (
        f"The share of {how.studies} simulated studies in which the report detects the change of success of boxes like "
        "these, by trials on each box. Standard deviations between boxes, by eye: "
        f"{100 * effects.DIFFICULTY_SD:g} points of success, {100 * effects.EFFECT_SD:g} of its change. {_NO_LUCK}"
    )
    return [{"boxes": k, "trials": n, "power": share} for (k, n), share in found.items()], note


def _of_people(success: Sequence[float], boxes: int, persons: Sequence[int], how: Simulation, seed: int) -> _Rows:
    """What a study of people needs, for the assumed standard deviations, for half of them, and for more."""
    model = People(success=tuple(success), boxes=boxes)
    models = [
        replace(model, design=design, person_sd=model.person_sd * factor, effect_sd=model.effect_sd * factor)
        for design in get_args(Design)
        for factor in _FACTORS
    ]
    found = people_power(models, replace(how, trials=persons or [len(success) * each for each in PERSONS]), seed=seed)
    rows = [
        {"design": f"{one.design} persons", "boxes": one.boxes_in_all, "person sd": one.person_sd,
         "effect sd": one.effect_sd, "persons": needed}
        for one, needed in zip(models, found, strict=True)
    ]  # fmt: skip
    note = (
        "Persons in all. person sd, effect sd: standard deviations between persons, in logits, of skill and of the "
        "effect of a condition, chosen by eye: plan with the worst row until a pilot has measured them. Persons who "
        "leave or are screened out come on top. Assumption: nobody learns from box to box."
    )
    return rows, note


def _plain(value: object) -> object:
    """A cell for JSON."""
    if not isinstance(value, Needed):
        return value
    measured = [{"n": one.trials, "power": one.power, "error": one.error} for one in value.measured]
    return {"needed": value.trials, "low": value.low, "high": value.high, "at_most": value.below, "measured": measured}


def _heads(row: Mapping[str, Any]) -> Iterable[str]:
    """The columns of a row: what is needed has one for every size measured, and one for the answer."""
    for name, value in row.items():
        sizes = [f"n={one.trials}" for one in value.measured] if isinstance(value, Needed) else []
        yield from (*sizes, f"{name} for 0.8" if sizes else name)


def _cells(value: object) -> Iterable[str]:
    if isinstance(value, Needed):
        yield from (f"{one.power:.2f}±{one.error:.2f}" for one in value.measured)
        least, most = value.measured[0].trials, value.measured[-1].trials
        if value.trials is None:
            yield f"more than {most}"
        elif value.below:
            yield f"at most {value.trials}"
        else:  # with its 95 % interval, from the number of simulated studies
            yield f"{value.trials} [{value.low or f'at most {least}'}, {value.high or f'more than {most}'}]"
    elif isinstance(value, Mapping):
        yield ", ".join(f"{name} {count}" for name, count in value.items())
    else:
        yield f"{value:.3g}" if isinstance(value, float) else str(value)


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
