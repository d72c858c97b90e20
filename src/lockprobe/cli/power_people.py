"""``lockprobe power --people``: how many persons a design needs, or what a number of persons can detect."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import ceil, floor
from typing import Any

from lockprobe.cli.printing import new_table, plain_console, print_table
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.simulation.power.people import FEWEST, Design, People, people_needed, power_with, spread_by

_DESIGNS: tuple[Design, ...] = ("within", "between")

_FACTORS = (0.5, 1.0, 1.5)
"""What the assumed standard deviations are multiplied by, to show how much they decide."""


def power_people(
    success: Sequence[float],
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
    if not success:
        known = "the share of boxes opened under each condition, the control first: 0.4,0.6"
        raise UserMistake(f"--success is missing, expected {known}")
    if persons and min(persons) < FEWEST:
        raise BadValue("--persons", min(persons), f"{FEWEST} or more persons in all, as 40 or 40,80")
    model = People(success=tuple(success), **{name: value for name, value in of_people.items() if value is not None})  # type: ignore[arg-type] # named as its fields are
    numbers: Sequence[int | None] = persons or [None]
    rows = {
        (design, factor, number): _row(spread_by(model, factor), design, number, target)
        for design in _DESIGNS
        for factor in _FACTORS
        for number in numbers
    }
    if json:
        print(json_.dumps({"target": target, **asdict(model), "designs": list(rows.values())}, indent=1))
        return
    defaults = (
        "; the defaults are chosen by eye, not measured"
        if None in (of_people["person_sd"], of_people["effect_sd"])
        else ""
    )
    spreads = (
        "SD: standard deviations between persons, in logits, of skill (--person-sd) and of the effect of a condition "
        f"(--effect-sd){defaults}. The columns beside the middle one have half of them, and half as much again"
    )
    say = plain_console().print
    heads = [f"SD {model.person_sd * factor:g} and {model.effect_sd * factor:g}" for factor in _FACTORS]
    named = [
        (f"{design} persons", number, [rows[design, factor, number] for factor in _FACTORS])
        for design in _DESIGNS
        for number in numbers
    ]
    if not persons:
        table = new_table("design", "boxes each", *heads)
        for name, _, own in named:
            cells = ("more than a million" if row["people"] is None else f"{row['people']}" for row in own)
            table.add_row(name, str(model.boxes_in_all), *cells)
        print_table(table)
        say(
            f"\nPersons in all for a power of {target:g}. {spreads}: plan with the largest number of your row until a "
            f"pilot has measured them. At least {FEWEST} persons see each condition. {_ASSUMED}"
        )
        return
    powers, effects = (new_table("design", "persons", *heads) for _ in range(2))
    for name, number, own in named:
        powers.add_row(
            name, f"{number}", *("too few" if row["power"] is None else f"{row['power']:.2f}" for row in own)
        )
        effects.add_row(name, f"{number}", *("too few" if row["power"] is None else _effects(row) for row in own))
    say(f"Power to tell {' and '.join(f'{share:g}' for share in model.success[1:])} from the control's {success[0]:g}:")
    print_table(powers)
    say(f"\nShares of boxes opened that are told from {success[0]:g} with a power of {target:g}:")
    print_table(effects)
    say(
        f"\nPersons in all; between persons, equally many per condition, and at least {FEWEST}. {spreads}: state the "
        f"smallest power of your row until a pilot has measured them. {_ASSUMED}"
    )


def _row(model: People, design: Design, number: int | None, target: float) -> dict[str, Any]:
    """The persons that a design needs, or what a number of persons detects; None where that cannot be said."""
    head = {"design": design, "person_sd": model.person_sd, "effect_sd": model.effect_sd}
    if number is None:
        needed = people_needed(model, design, target)
        return head | ({"people": None, "per_condition": None} if needed is None else asdict(needed))
    found = power_with(model, design, number, target)
    too_few = {"people": number} | dict.fromkeys(("per_condition", "power", "below", "above"))
    return head | (too_few if found is None else asdict(found))


def _effects(row: Mapping[str, Any]) -> str:
    """The smallest effects that are detected, rounded away from the control."""
    below = [] if row["below"] is None else [f"≤ {floor(row['below'] * 100) / 100:.2f}"]
    above = [] if row["above"] is None else [f"≥ {ceil(row['above'] * 100) / 100:.2f}"]
    return ", ".join([*below, *above]) or "none"


_ASSUMED = (
    "Persons who leave or are screened out come on top.\n"
    "Assumption: a person's boxes are independent but for skill, and nobody learns from box to box. Tests: a "
    "paired t test on shares (within), Welch's t test on shares (between), Bonferroni's correction over conditions."
)
