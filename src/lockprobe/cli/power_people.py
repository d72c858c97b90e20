"""``lockprobe power --people``: how many persons a design needs, or what a number of persons can detect."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import ceil, floor

from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.foundation.errors import BadValue, Conflict, UserMistake
from lockprobe.simulation.power.people import (
    FEWEST,
    Design,
    People,
    PowerOfPeople,
    people_needed,
    power_with,
    spread_by,
)

_DESIGNS: tuple[Design, ...] = ("within", "between")

_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed standard deviations are multiplied by, to show how much they decide."""

_OPTIONS = "--persons, --boxes-each, --person-sd, --effect-sd"


def refuse_other_options(people: bool, what: str | None, given: Sequence[str]) -> None:
    """Refuse what says something about trials of agents beside what says something about people.

    Raises:
        Conflict: If there is anything.
    """
    if not people:
        raise Conflict("--persons, --boxes-each, --person-sd and --effect-sd", "trials of agents", "they need --people")
    names = [*([what] if what else []), *(f"--{name.replace('_', '-')}" for name in given)]
    if names:
        raise Conflict("--people", ", ".join(names), f"it takes --success, {_OPTIONS} and --target")


def refuse_beside_boxes(what: str | None, given: Sequence[str]) -> None:
    """Refuse what says something about one box, or about people, beside numbers of boxes.

    Raises:
        Conflict: If there is anything.
    """
    if names := [*([what] if what else []), *(f"--{name.replace('_', '-')}" for name in given)]:
        raise Conflict("--over-boxes", ", ".join(names), "it takes --success, --trials, --effect-sd and --seed")


def power_people(
    success: Sequence[float] | None,
    of_people: Mapping[str, float | None],
    persons: Sequence[int],
    target: float,
    *,
    json: bool,
) -> None:
    """Print what a study of people needs, for the assumed standard deviations, for half of them, and for more.

    Args:
        success: The share of boxes opened under each condition, the control first.
        of_people: Fields of :class:`People`; None for the default.
        persons: Persons in all whose power is printed; none for how many the power ``target`` needs.
        target: The power to reach.
        json: Whether to print JSON.

    Raises:
        UserMistake: If a value is missing or makes no model, or persons are too few.
    """
    if success is None:
        known = "the share of boxes opened under each condition, the control first: 0.4,0.6"
        raise UserMistake(f"--success is missing, expected {known}")
    if persons and min(persons) < FEWEST:
        raise BadValue("--persons", min(persons), f"{FEWEST} or more persons in all, as 40 or 40,80")
    model = People(success=tuple(success), **{name: value for name, value in of_people.items() if value is not None})  # type: ignore[arg-type] # named as its fields are
    if json:
        each = (_rows(model, design, persons, target, factor) for design in _DESIGNS for factor in _FACTORS)
        rows = [row for rows in each for row in rows]
        print(json_.dumps({"target": target, **asdict(model), "designs": rows}, indent=1))
        return
    by_eye = None in (of_people["person_sd"], of_people["effect_sd"])
    if persons:
        _print_power(model, persons, target, by_eye=by_eye)
    else:
        _print_needed(model, target, by_eye=by_eye)


def _rows(
    model: People, design: Design, persons: Sequence[int], target: float, factor: float
) -> list[dict[str, float | str | None]]:
    """The rows of a design in JSON: one, or one for each number of persons."""
    one = spread_by(model, factor)
    head: dict[str, float | str | None] = {"design": design, "person_sd": one.person_sd, "effect_sd": one.effect_sd}
    if not persons:
        needed = people_needed(one, design, target)
        return [head | ({"people": None, "per_condition": None} if needed is None else asdict(needed))]
    nothing = dict.fromkeys(("per_condition", "power", "below", "above"))
    found = ((number, power_with(one, design, number, target)) for number in persons)
    return [head | ({"people": number, **nothing} if at is None else asdict(at)) for number, at in found]


def _print_needed(model: People, target: float, *, by_eye: bool) -> None:
    table = new_table("design", "boxes each", *_spreads(model))
    for design in _DESIGNS:
        needed = (people_needed(spread_by(model, factor), design, target) for factor in _FACTORS)
        cells = ("more than a million" if one is None else f"{one.people}" for one in needed)
        table.add_row(f"{design} persons", str(model.boxes_in_all), *cells)
    print_table(table)
    plain_console().print(
        f"\nPersons in all for a power of {target:g}. {_deviations(by_eye)}: plan with the largest number of your row "
        f"until a pilot has measured them. At least {FEWEST} persons see each condition. {_ASSUMED}"
    )


def _print_power(model: People, persons: Sequence[int], target: float, *, by_eye: bool) -> None:
    powers, effects = (new_table("design", "persons", *_spreads(model)) for _ in range(2))
    for design in _DESIGNS:
        for number in persons:
            found = [power_with(spread_by(model, factor), design, number, target) for factor in _FACTORS]
            name = (f"{design} persons", str(number))
            powers.add_row(*name, *("too few" if one is None else f"{one.power:.2f}" for one in found))
            effects.add_row(*name, *("too few" if one is None else _effects(one) for one in found))
    console, stated = plain_console(), " and ".join(f"{share:g}" for share in model.success[1:])
    console.print(f"Power to tell {stated} from the control's {model.success[0]:g}:")
    print_table(powers)
    console.print(f"\nShares of boxes opened that are told from {model.success[0]:g} with a power of {target:g}:")
    print_table(effects)
    console.print(
        f"\nPersons in all; between persons, equally many per condition, and at least {FEWEST}. {_deviations(by_eye)}: "
        f"state the smallest power of your row until a pilot has measured them. {_ASSUMED}"
    )


def _effects(one: PowerOfPeople) -> str:
    """The smallest effects that are detected, rounded away from the control."""
    below = [] if one.below is None else [f"≤ {floor(one.below * 100) / 100:.2f}"]
    above = [] if one.above is None else [f"≥ {ceil(one.above * 100) / 100:.2f}"]
    return ", ".join([*below, *above]) or "none"


def _spreads(model: People) -> list[str]:
    return [f"SD {model.person_sd * factor:g} and {model.effect_sd * factor:g}" for factor in _FACTORS]


def _deviations(by_eye: bool) -> str:
    defaults = "; the defaults are chosen by eye, not measured" if by_eye else ""
    return (
        "SD: standard deviations between persons, in logits, of skill (--person-sd) and of the effect of a condition "
        f"(--effect-sd){defaults}. The columns beside the middle one have half of them, and half as much again"
    )


_ASSUMED = (
    "Persons who leave or are screened out come on top.\n"
    "Assumption: a person's boxes are independent but for skill, and nobody learns from box to box. Tests: a "
    "paired t test on shares (within), Welch's t test on shares (between), Bonferroni's correction over conditions."
)
